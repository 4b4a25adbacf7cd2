// A surfel's footprint: centre, falloff, opacity, weight, colour.
//
// in:  a record of gl/records.py (level-local)      out: Footprint (image space, px, y down)
// The viewport is the image widened by u_guard_px on every side, because GL clips a point by its
// centre.  Rows of the target are image rows, top first.

#include "opacity.glsl"
#include "footprint.glsl"

in vec3 in_mean;
in ivec4 in_quat_opacity;
in vec4 in_logs_coverage;
in vec4 in_color_slot;
#ifdef RANKED
in uint in_rank;
#endif

uniform vec2 u_size_px;
uniform float u_guard_px;
uniform float u_contribution_min;  // opacity times area, px^2

out Footprint {
    flat vec4 v_centre_opacity_weight;
    flat vec3 v_falloff;
    flat vec3 v_color;
#ifdef RANKED
    flat uint v_rank;
#endif
#ifdef QUADS
    flat vec2 v_extent_px;
#endif
};

void cull() {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    gl_PointSize = 1.0;
    v_centre_opacity_weight = vec4(0.0);
    v_falloff = vec3(1.0, 0.0, 1.0);
    v_color = vec3(0.0);
#ifdef RANKED
    v_rank = 0u;
#endif
#ifdef QUADS
    v_extent_px = vec2(0.0);
#endif
}

void main() {
    int slot = int(in_color_slot.w * 255.0 + 0.5);
    vec4 quat_opacity = vec4(in_quat_opacity) / INT16_STEPS;
    float opacity = quat_opacity.w;
    AnchoredView view = view_at(0, slot);
    float side = texelFetch(t_levels, ivec2(4, slot), 0).z;
    float D = depth_ratio(view.g, in_mean);
    if (side * D <= DEPTH_FLOOR || opacity <= ALPHA_CUT) { cull(); return; }

    vec2 q = offset_px(view, in_mean, D);
    vec2 centre = anchor_px(view) + q;
    vec3 t1, t2;
    surfel_axes(quat_opacity.xyz, t1, t2);
    vec3 wx = (view.gx.xyz - q.x * view.g.xyz) / D;  // d p_px / d u
    vec3 wy = (view.gy.xyz - q.y * view.g.xyz) / D;
    vec2 s = exp2(in_logs_coverage.xy);
    vec2 variance;
    vec3 conic = conic_of_axes(s.x * vec2(dot(wx, t1), dot(wy, t1)), s.y * vec2(dot(wx, t2), dot(wy, t2)), variance);
    vec2 extent = extent_px(variance, opacity);
    float area = 6.283185307 * inversesqrt(max(conic.x * conic.z - conic.y * conic.y, 1e-30));
    if (opacity * area < u_contribution_min) { cull(); return; }
    vec2 outside = max(-extent - centre, centre - extent - u_size_px);
    if (!(max(outside.x, outside.y) < 0.0)) { cull(); return; }  // nan is culled too

#ifdef UNIT_WEIGHT
    float weight = 1.0;
#else
    float render = log_scale(view.g, in_mean, side);
    float weight = surfel_weight(slot, in_mean, render, in_logs_coverage.z, in_logs_coverage.w);
    if (weight < WEIGHT_MIN) { cull(); return; }
#endif

    v_centre_opacity_weight = vec4(centre, opacity, weight);
    v_falloff = falloff_of_conic(conic);
    v_color = in_color_slot.rgb;
#ifdef RANKED
    v_rank = in_rank;
#endif
#ifdef QUADS
    v_extent_px = extent;
#endif
    vec2 guarded = (centre + u_guard_px) / (u_size_px + 2.0 * u_guard_px);
    gl_Position = vec4(2.0 * guarded - 1.0, 0.0, 1.0);
    gl_PointSize = 2.0 * max(extent.x, extent.y) + POINT_SLACK_PX;  // the fragment decides, the point bounds
}
