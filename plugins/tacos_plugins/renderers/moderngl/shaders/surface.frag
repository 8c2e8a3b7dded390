#version 330
// Luminance of a surface [cd/m2]: Lambertian reflection of baked light, and for glossy materials emission and
// the reflection of lights and surroundings.

uniform sampler2DArray colours;  // square root of linear reflectance, a layer per texture
uniform sampler2DArray normals;  // tilt along tangent and bitangent, 0.5 is none
uniform sampler2D light_map;     // luminance of a white texture [cd/m2], unshadowed share
uniform sampler2D bend_map;      // its relative change per tilt of the normal

in vec2 uv;
in vec2 map;
in vec3 light;
in vec2 bend;
flat in ivec2 layers; // of colours and normals

out vec4 luminance;

//include texture_filter.glsl
#ifdef GLOSSY
//include reflection.glsl
#endif

void main() {
    vec3 encoded = filtered(colours, uv, float(layers.x));
    vec3 texel = encoded * encoded;
    vec4 lit = texture(light_map, map);
    // Interpolated beyond a triangle's edge, light may fall below zero.
    vec3 reflected = max(lit.rgb + light, 0.0) * texel;
#ifdef BUMPY
    vec2 tilt = texture(normals, vec3(uv, float(layers.y))).xy * (255.0 / 127.0) - (128.0 / 127.0);
    reflected *= clamp(1.0 + dot(tilt, bend + texture(bend_map, map).xy), 0.0, 2.0);
#else
    const vec2 tilt = vec2(0.0);
#endif
#ifdef GLOSSY
    reflected += mirrored(texel, tilt, lit.a + share);
#endif
    luminance = vec4(reflected, 1.0);
}
