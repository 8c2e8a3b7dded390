#version 330
// Surfaces with their baked light.

uniform mat4 clip_from_world;

in vec3 in_position;
#if defined(TEXTURED) || defined(BUMPY)
in vec2 in_uv; // texture coordinates [tiles]
in ivec2 in_layers;
out vec2 uv;
flat out ivec2 layers;
#endif
#ifdef MAPPED
in vec2 in_map; // light map coordinates
out vec2 map;
#else
in vec3 in_light; // luminance of a white texture [cd/m2]
out vec3 light;
#endif
#if defined(BUMPY) && !defined(MAPPED)
in vec2 in_bend; // its relative change per tilt of the normal along tangent and bitangent
out vec2 bend;
#endif
#ifdef GLOSSY
in vec3 in_normal;
in vec4 in_tangent; // w: sign of the bitangent
in float in_share;  // share of direct light that shadows leave
in int in_gloss;    // material
out vec3 normal;
// Of the material: fetched once a vertex, as it costs several times more once a pixel.
uniform sampler2D materials;   // three texels each, see textures.material_table
flat out vec4 base_roughness;
flat out vec4 emission_metallic;
flat out float level; // of roughness, among the layers of a probe
#ifdef BUMPY
out vec4 tangent;
#endif
#ifndef MAPPED
out float share;
#endif
#endif

void main() {
    gl_Position = clip_from_world * vec4(in_position, 1.0);
#if defined(TEXTURED) || defined(BUMPY)
    uv = in_uv;
    layers = in_layers;
#endif
#ifdef MAPPED
    map = in_map;
#else
    light = in_light;
#endif
#if defined(BUMPY) && !defined(MAPPED)
    bend = in_bend;
#endif
#ifdef GLOSSY
    normal = in_normal;
    vec4 kind = texelFetch(materials, ivec2(1, in_gloss), 0); // roughness, metallic, level
    base_roughness = vec4(texelFetch(materials, ivec2(0, in_gloss), 0).rgb, kind.x);
    emission_metallic = vec4(texelFetch(materials, ivec2(2, in_gloss), 0).rgb, kind.y);
    level = kind.z;
#ifdef BUMPY
    tangent = in_tangent;
#endif
#ifndef MAPPED
    share = in_share;
#endif
#endif
}
