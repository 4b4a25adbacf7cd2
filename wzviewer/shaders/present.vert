// One triangle over the whole viewport; v_at is (0, 0) at its lower left and (1, 1) at its upper right.

out vec2 v_at;

void main() {
    v_at = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));
    gl_Position = vec4(2.0 * v_at - 1.0, 0.0, 1.0);
}
