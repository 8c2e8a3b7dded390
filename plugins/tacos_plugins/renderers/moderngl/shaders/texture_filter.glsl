// Textures seen at a grazing angle: several samples along the pixel's long footprint.
#ifdef FILTER_IN_HARDWARE
vec3 filtered(sampler2DArray stack, vec2 at, float layer) {
    return texture(stack, vec3(at, layer)).rgb;
}
#else
// Software OpenGL filters anisotropically many times slower than these taps of its fast path.
const int TAPS = 3;
vec3 filtered(sampler2DArray stack, vec2 at, float layer) {
    vec2 dx = dFdx(at), dy = dFdy(at);
    float x2 = dot(dx, dx), y2 = dot(dy, dy);
    vec2 along = x2 > y2 ? dx : dy;
    float area = abs(dx.x * dy.y - dx.y * dy.x);
    float ratio = clamp(max(x2, y2) / max(area, 1e-20), 1.0, float(TAPS));
    vec2 stride = along * ((ratio - 1.0) / (ratio * float(TAPS - 1)));
    float bias = -log2(ratio);
    vec3 total = texture(stack, vec3(at, layer), bias).rgb;
    for (int i = 1; i <= TAPS / 2; ++i)
        total += texture(stack, vec3(at + stride * float(i), layer), bias).rgb
               + texture(stack, vec3(at - stride * float(i), layer), bias).rgb;
    return total / float(TAPS);
}
#endif
