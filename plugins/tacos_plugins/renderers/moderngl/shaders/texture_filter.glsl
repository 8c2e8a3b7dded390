// Textures seen at a grazing angle: several samples along the pixel's long footprint.

// Mipmapping alone is blurrier than the mean over a pixel; this bias is where both differ least (measured
// against 16 samples a pixel).
const float BIAS = -0.5;

#ifdef FILTER_IN_HARDWARE
vec3 filtered(sampler2DArray stack, vec2 at, float layer) {
    return texture(stack, vec3(at, layer), BIAS).rgb;
}
#else
// Software OpenGL filters anisotropically many times slower than with these taps of its fast path.
const float MOST_TAPS = 4.0;
vec3 filtered(sampler2DArray stack, vec2 at, float layer) {
    vec2 dx = dFdx(at), dy = dFdy(at);
    float x2 = dot(dx, dx), y2 = dot(dy, dy);
    vec2 along = x2 > y2 ? dx : dy;
    float area = abs(dx.x * dy.y - dx.y * dy.x);
    float ratio = clamp(max(x2, y2) / max(area, 1e-20), 1.0, MOST_TAPS);
    int taps = int(ratio + 0.5);
    // The level for the footprint of one tap, found once: the driver would find it for each.
    float edge = float(textureSize(stack, 0).x);
    float level = 0.5 * log2(max(max(x2, y2) * edge * edge, 1e-20)) - log2(ratio) + BIAS;
    vec2 stride = along / float(taps);
    vec2 first = at - 0.5 * (along - stride);
    vec3 total = vec3(0.0);
    for (int i = 0; i < taps; ++i)
        total += textureLod(stack, vec3(first + stride * float(i), layer), level).rgb;
    return total / float(taps);
}
#endif
