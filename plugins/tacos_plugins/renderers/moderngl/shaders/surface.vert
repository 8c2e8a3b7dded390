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
in ivec2 in_gloss;  // material and probe
out vec3 normal;
flat out ivec2 gloss;
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
    gloss = in_gloss;
#ifdef BUMPY
    tangent = in_tangent;
#endif
#ifndef MAPPED
    share = in_share;
#endif
#endif
}
