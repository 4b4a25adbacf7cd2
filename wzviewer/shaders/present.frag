// The finished frame over its background.
//
// in:  t_frame, premultiplied, first row = top of the image      out: display colour, alpha

in vec2 v_at;

uniform sampler2D t_frame;
uniform vec4 u_background;   // straight alpha
uniform float u_top_first;   // 1: rows of the target are image rows; 0: a window, bottom first
uniform float u_closed;      // coverage from which a surface counts as closed; 1: as rendered

layout(location = 0) out vec4 out_color;

void main() {
    vec2 at = vec2(v_at.x, mix(1.0 - v_at.y, v_at.y, u_top_first));
    vec4 frame = texture(t_frame, at);
    frame *= min(1.0 / max(frame.a, u_closed), 1.0 / u_closed);
    float behind = (1.0 - frame.a) * u_background.a;
    out_color = vec4(frame.rgb + behind * u_background.rgb, frame.a + behind);
}
