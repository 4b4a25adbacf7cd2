// Narrows the search of median.frag: moves `low` to the last candidate in front of which more than
// half of the light is left.

uniform usampler2D t_low;
uniform sampler2D t_t0;
uniform sampler2D t_t1;
uniform sampler2D t_t2;
uniform sampler2D t_t3;
uniform uint u_step;

layout(location = 0) out uint out_low;

float count(sampler2D t, ivec2 at, vec4 kept) {
    return dot(vec4(greaterThan(texelFetch(t, at, 0), vec4(0.5))), kept);
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 all = vec4(1.0);
    float passed = count(t_t0, at, all) + count(t_t1, at, all) + count(t_t2, at, all)
        + count(t_t3, at, vec4(1.0, 1.0, 1.0, 0.0));  // the sixteenth is the next digit's carry
    out_low = texelFetch(t_low, at, 0).r + uint(passed + 0.5) * u_step;
}
