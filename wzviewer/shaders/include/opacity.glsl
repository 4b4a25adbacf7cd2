// Scale-aware opacity modulation (Eq. 1-3 on a tree): twin of core/opacity.py.
//
// All scales are log2 of world units per pixel over the level's unit.  A level's row of t_levels
// is described in gl/blocks.py.

#include "anchor.glsl"

uniform sampler2D t_levels;

AnchoredView view_at(int texel, int slot) {
    return AnchoredView(
        texelFetch(t_levels, ivec2(texel, slot), 0),
        texelFetch(t_levels, ivec2(texel + 1, slot), 0),
        texelFetch(t_levels, ivec2(texel + 2, slot), 0));
}

// m: 1 inside an image of (width, height), smoothstep over `feather` px to 0 at its border.
float edge_coverage(vec2 point_px, vec3 size_px) {
    vec2 border = min(point_px, size_px.xy - point_px);
    float s = clamp(min(border.x, border.y) / size_px.z, 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

// t: 0 at the parent's log scale (top), 1 at the child's (low).
float log_ramp(float top, float here, float low) {
    return clamp((top - here) / max(top - low, LOG_SPAN_MIN), 0.0, 1.0);
}

// m t of the cover whose texels start at `texel`.
float cover_share(int texel, int slot, vec3 u, float render) {
    AnchoredView view = view_at(texel, slot);
    vec4 parent = texelFetch(t_levels, ivec2(texel + 3, slot), 0);
    vec4 size = texelFetch(t_levels, ivec2(texel + 4, slot), 0);
    float D = depth_ratio(view.g, u);
    if (size.w * D <= DEPTH_FLOOR) return 0.0;  // behind the cover's camera
    float m = edge_coverage(anchor_px(view) + offset_px(view, u, D), size.xyz);
    return m * log_ramp(log_scale(parent, u, 1.0), render, log_scale(view.g, u, size.w));
}

// By how much the low-pass widens a footprint at its native scale, over how much it does here.
//   cell      log2 of the native pixels along a side of what it stands for
float compensation(float native, float render, float cell) {
    const float VARIANCE_PX2 = SURFEL_SIGMA_PX * SURFEL_SIGMA_PX;
    float area = exp2(2.0 * min(native + cell - render, 0.0));
    return area * (VARIANCE_PX2 + LOW_PASS_PX2) / (VARIANCE_PX2 * area + LOW_PASS_PX2);
}

// Weight w of a surfel, Eq. 3 with coverage; without LINEAR_BLEND times its compensation.
//   u         local position
//   render    its log scale at the rendering camera
//   native    log2 of s_native over the unit
//   coverage  product of m over the level and its ancestors
float surfel_weight(int slot, vec3 u, float render, float native, float coverage) {
    vec4 counts = texelFetch(t_levels, ivec2(4, slot), 0);
    float w = coverage;
    if (counts.y > 0.5) {
        float top = log_scale(texelFetch(t_levels, ivec2(3, slot), 0), u, 1.0);
        w *= log_ramp(top, render, native);
#ifndef LINEAR_BLEND
        w *= compensation(native, render, counts.w);
#endif
    }
    int num_covers = int(counts.x);
    for (int k = 0; k < num_covers; ++k) {
        if (w <= 0.0) return 0.0;
        w *= 1.0 - cover_share(5 + 5 * k, slot, u, render);
    }
    return clamp(w, 0.0, 1.0);
}
