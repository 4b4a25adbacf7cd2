// Whether a record can draw anything: the tests of surfel.vert, each loosened by more than what
// rounding may turn, so that a surfel that is dropped would have been culled there.

#define LINEAR_BLEND  // the weight without compensation is the larger: what it drops, both blends drop
#include "opacity.glsl"
#include "footprint.glsl"

uniform vec2 u_size_px;
uniform float u_contribution_min;  // opacity times area, px^2

const float WEIGHT_FLOOR = 0.8 * WEIGHT_MIN;
const float EXTENT_SLACK = 1e-4;    // of the footprint

vec2 int16_pair(uint word) {
    return vec2(bitfieldExtract(int(word), 0, 16), bitfieldExtract(int(word), 16, 16)) / INT16_STEPS;
}

// The record's words are (mean, q.xy) and (q.z | opacity, log2 scales, log2 native | coverage, colour | slot).
bool is_visible(uvec4 head, uvec4 tail) {
    vec3 u = uintBitsToFloat(head.xyz);
    vec2 z_opacity = int16_pair(tail.x);
    if (z_opacity.y <= ALPHA_CUT) return false;
    int slot = int(tail.w >> 24);
    AnchoredView view = view_at(0, slot);
    float side = texelFetch(t_levels, ivec2(4, slot), 0).z;
    float D = depth_ratio(view.g, u);
    if (side * D <= 0.0) return false;  // surfel.vert: DEPTH_FLOOR

    vec2 q = offset_px(view, u, D);
    vec2 centre = anchor_px(view) + q;
    vec3 t1, t2;
    surfel_axes(vec3(int16_pair(head.w), z_opacity.x), t1, t2);
    vec3 wx = (view.gx.xyz - q.x * view.g.xyz) / D;
    vec3 wy = (view.gy.xyz - q.y * view.g.xyz) / D;
    vec2 s = exp2(unpackHalf2x16(tail.y));
    vec2 u1 = s.x * vec2(dot(wx, t1), dot(wy, t1));
    vec2 u2 = s.y * vec2(dot(wx, t2), dot(wy, t2));
    vec2 variance = u1 * u1 + u2 * u2 + LOW_PASS_PX2;
    float area = 6.2838 * sqrt(variance.x) * sqrt(variance.y);  // at least: Hadamard's bound of the determinant
    if (z_opacity.y * area < u_contribution_min) return false;
    vec2 extent = extent_px(variance, z_opacity.y);
    vec2 slack = EXTENT_SLACK * (extent + abs(centre));
    vec2 outside = max(-extent - centre, centre - extent - u_size_px) - slack;
    if (max(outside.x, outside.y) > 0.0) return false;  // nan is kept

#ifdef MODULATED
    vec2 native_coverage = unpackHalf2x16(tail.z);
    float render = log_scale(view.g, u, side);
    return surfel_weight(slot, u, render, native_coverage.x, native_coverage.y) >= WEIGHT_FLOOR;
#else
    return true;
#endif
}
