// One fragment of a surfel, premultiplied, for "over" blending back to front (Eq. 2).
//
// in:  Footprint (image space, px)      out: premultiplied colour and alpha

#include "footprint.glsl"

in Footprint {
    flat vec4 v_centre_opacity_weight;
    flat vec3 v_falloff;
    flat vec3 v_color;
};

layout(location = 0) out vec4 out_color;

void main() {
    vec2 d = gl_FragCoord.xy - v_centre_opacity_weight.xy;
    float alpha = surfel_alpha(d, v_falloff, v_centre_opacity_weight.z);
    if (alpha < ALPHA_CUT) discard;  // before the weight, so a fading layer keeps its outline
    alpha = modulated_alpha(alpha, v_centre_opacity_weight.w);
    out_color = vec4(v_color * alpha, alpha);
}
