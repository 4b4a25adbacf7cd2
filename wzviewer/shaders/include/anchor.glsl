// Anchored projection: twin of core/anchor.py.
//
// Spaces: level-local u (native pixels from the level's anchor) -> image (px, y down).
// `side` is +1 where the anchor lies in front of the camera and -1 behind it: D(u) is the depth
// relative to the anchor's, so side * D(u) > 0 is in front.

struct AnchoredView {
    vec4 gx;  // (gx, anchor_x_px)
    vec4 gy;  // (gy, anchor_y_px)
    vec4 g;   // (g, base)
};

float depth_ratio(vec4 g, vec3 u) {
    return 1.0 + dot(g.xyz, u);
}

// Image position relative to the anchor's, px.
vec2 offset_px(AnchoredView view, vec3 u, float D) {
    return vec2(dot(view.gx.xyz, u), dot(view.gy.xyz, u)) / D;
}

vec2 anchor_px(AnchoredView view) {
    return vec2(view.gx.w, view.gy.w);
}

// log2 of Eq. 1's d / f over the level's unit, from a (g, base) row.
float log_scale(vec4 g, vec3 u, float side) {
    return g.w + log2(max(side * depth_ratio(g, u), DEPTH_FLOOR));
}
