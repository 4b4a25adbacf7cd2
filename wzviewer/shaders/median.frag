// Transmittance in front of 16 candidate ranks of a pixel: one step of the search for the median.
//
// A rank is a surfel's place in the frame's order, 0 nearest.  Channel k holds the product of
// (1 - alpha) over the ranks below low + (k + 1) step; the blend multiplies, so no order is needed.
// in:  Footprint with rank      out: 16 factors in 4 targets

#include "footprint.glsl"

in Footprint {
    flat vec4 v_centre_opacity_weight;
    flat vec3 v_falloff;
    flat vec3 v_color;
    flat uint v_rank;
};

uniform usampler2D t_low;
uniform uint u_step;

layout(location = 0) out vec4 out_t0;
layout(location = 1) out vec4 out_t1;
layout(location = 2) out vec4 out_t2;
layout(location = 3) out vec4 out_t3;

void main() {
    vec2 d = gl_FragCoord.xy - v_centre_opacity_weight.xy;
    float alpha = surfel_alpha(d, v_falloff, v_centre_opacity_weight.z);
    if (alpha < ALPHA_CUT) discard;
    uint low = texelFetch(t_low, ivec2(gl_FragCoord.xy), 0).r;
    uint place = v_rank < low ? 0u : (v_rank - low) / u_step;  // channels from `place` on hold it
    if (place >= 16u) discard;
    float behind = 1.0 - modulated_alpha(alpha, v_centre_opacity_weight.w);
    vec4 first = vec4(0.0, 1.0, 2.0, 3.0);
    vec4 at = vec4(float(place));
    out_t0 = mix(vec4(behind), vec4(1.0), lessThan(first, at));
    out_t1 = mix(vec4(behind), vec4(1.0), lessThan(first + 4.0, at));
    out_t2 = mix(vec4(behind), vec4(1.0), lessThan(first + 8.0, at));
    out_t3 = mix(vec4(behind), vec4(1.0), lessThan(first + 12.0, at));
}
