#version 330
// Luminance of a surface [cd/m2]: Lambertian reflection of baked light, and for glossy materials emission and
// the reflection of lights and surroundings.

out vec4 luminance;

#if defined(TEXTURED) || defined(BUMPY)
in vec2 uv;
flat in ivec2 layers; // of colours and normals
#endif
#ifdef TEXTURED
uniform sampler2DArray colours; // square root of linear reflectance, a layer per texture
//include texture_filter.glsl
#endif
#ifdef BUMPY
uniform sampler2DArray normals; // tilt along tangent and bitangent, 0.5 is none
#endif
#ifdef MAPPED
uniform sampler2D light_map; // luminance of a white texture [cd/m2], unshadowed share
uniform sampler2D bend_map;  // its relative change per tilt of the normal
in vec2 map;
#else
in vec3 light; // luminance of a white texture [cd/m2]
#endif
#if defined(BUMPY) && !defined(MAPPED)
in vec2 bend;
#endif
#ifdef GLOSSY
//include reflection.glsl
#endif

void main() {
#ifdef TEXTURED
    vec3 encoded = filtered(colours, uv, float(layers.x));
    vec3 texel = encoded * encoded;
#else
    const vec3 texel = vec3(1.0);
#endif
#ifdef MAPPED
    vec4 lit = texture(light_map, map);
    vec3 reflected = lit.rgb * texel;
#else
    // Extrapolated beyond a triangle's edge, light may fall below zero.
    vec3 reflected = max(light, 0.0) * texel;
#endif
#ifdef BUMPY
    vec2 tilt = texture(normals, vec3(uv, float(layers.y))).xy * (255.0 / 127.0) - (128.0 / 127.0);
#ifdef MAPPED
    vec2 bend = texture(bend_map, map).xy;
#endif
    reflected *= clamp(1.0 + dot(tilt, bend), 0.0, 2.0);
#endif
#ifdef GLOSSY
#ifdef MAPPED
    float share = lit.a;
#endif
#ifdef BUMPY
    vec3 facing = normalize(normal + tilt.x * tangent.xyz + tilt.y * tangent.w * cross(normal, tangent.xyz));
#else
    vec3 facing = normalize(normal);
#endif
    vec3 left;
    vec3 mirror = mirrored(texel, facing, share, left);
    reflected = reflected * left + mirror;
#endif
    luminance = vec4(reflected, 1.0);
}
