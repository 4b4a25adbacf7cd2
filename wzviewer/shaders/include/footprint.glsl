// The screen footprint of a surfel and its fragment alpha: twin of core/reference.py.

// First two columns of the rotation of a unit quaternion given by (x, y, z), w >= 0.
void surfel_axes(vec3 q, out vec3 t1, out vec3 t2) {
    float w = sqrt(max(1.0 - dot(q, q), 0.0));
    t1 = vec3(1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * (q.x * q.y + w * q.z), 2.0 * (q.x * q.z - w * q.y));
    t2 = vec3(2.0 * (q.x * q.y - w * q.z), 1.0 - 2.0 * (q.x * q.x + q.z * q.z), 2.0 * (q.y * q.z + w * q.x));
}

// Conic K = Cov^-1 as (xx, xy, yy) and the diagonal of Cov, from the two screen axes u1, u2 (px).
// det Cov = (u1 x u2)^2 + lp (|u1|^2 + |u2|^2) + lp^2 has no cancellation at grazing angles, and
// the division by the larger variance keeps footprints of 1e12 px inside float32.
vec3 conic_of_axes(vec2 u1, vec2 u2, out vec2 variance) {
    variance = u1 * u1 + u2 * u2 + LOW_PASS_PX2;
    float m = max(variance.x, variance.y);
    float lp = LOW_PASS_PX2 / m;
    vec2 a = u1 * inversesqrt(m);
    vec2 b = u2 * inversesqrt(m);
    float area = a.x * b.y - a.y * b.x;
    float det = area * area + lp * (dot(a, a) + dot(b, b)) + lp * lp;
    float xy = a.x * a.y + b.x * b.y;
    return vec3(variance.y / m, -xy, variance.x / m) / (det * m);
}

// Half sides of the box outside which alpha is below the cut, px; 0 where it is everywhere.
vec2 extent_px(vec2 variance, float opacity) {
    return sqrt(max(2.0 * log(opacity / ALPHA_CUT), 0.0) * variance);
}

// The conic as surfel_alpha wants it: -log2 G = d.x (x d.x + y d.y) + z d.y d.y.
vec3 falloff_of_conic(vec3 conic) {
    const float LOG2_E = 1.442695041;
    return LOG2_E * vec3(0.5 * conic.x, conic.y, 0.5 * conic.z);
}

// o G at an offset d (px) from the centre.
float surfel_alpha(vec2 d, vec3 falloff, float opacity) {
    float power = d.x * (falloff.x * d.x + falloff.y * d.y) + falloff.z * d.y * d.y;
    return min(opacity * exp2(-power), ALPHA_MAX);
}

// Eq. 2 multiplies opacity by the weight (linear); the power law multiplies log transmittance, so
// that two layers that share a pixel let through exactly what each of them would.
float modulated_alpha(float alpha, float weight) {
#if defined(UNIT_WEIGHT)
    return alpha;
#elif defined(LINEAR_BLEND)
    return alpha * weight;
#else
    return 1.0 - exp2(weight * log2(1.0 - alpha));
#endif
}
