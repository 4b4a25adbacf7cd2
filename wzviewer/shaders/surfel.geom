// Footprints too big for a point become quads: the extent box, clipped to the image.

layout(points) in;
layout(triangle_strip, max_vertices = 4) out;

uniform vec2 u_size_px;

in Footprint {
    flat vec4 v_centre_opacity_weight;
    flat vec3 v_falloff;
    flat vec3 v_color;
#ifdef RANKED
    flat uint v_rank;
#endif
    flat vec2 v_extent_px;
} v_in[];

out Footprint {
    flat vec4 v_centre_opacity_weight;
    flat vec3 v_falloff;
    flat vec3 v_color;
#ifdef RANKED
    flat uint v_rank;
#endif
};

void corner(vec2 at_px) {
    v_centre_opacity_weight = v_in[0].v_centre_opacity_weight;
    v_falloff = v_in[0].v_falloff;
    v_color = v_in[0].v_color;
#ifdef RANKED
    v_rank = v_in[0].v_rank;
#endif
    gl_Position = vec4(2.0 * at_px / u_size_px - 1.0, 0.0, 1.0);
    EmitVertex();
}

void main() {
    vec2 extent = v_in[0].v_extent_px;
    if (extent.x <= 0.0) return;  // culled by the vertex stage
    vec2 centre = v_in[0].v_centre_opacity_weight.xy;
    vec2 low = max(centre - extent, vec2(-1.0));
    vec2 high = min(centre + extent, u_size_px + 1.0);
    corner(low);
    corner(vec2(high.x, low.y));
    corner(vec2(low.x, high.y));
    corner(high);
    EndPrimitive();
}
