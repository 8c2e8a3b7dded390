#version 330
// Surfaces with their baked light.

uniform mat4 clip_from_world;

in vec3 in_position;
in vec2 in_uv;    // texture coordinates [tiles]
in vec2 in_map;   // light map coordinates
in vec3 in_light; // luminance of a white texture [cd/m2], for surfaces lit per vertex
in vec2 in_bend;  // its relative change per tilt of the normal along tangent and bitangent
in ivec2 in_layers;
#ifdef GLOSSY
in vec3 in_normal;
in vec4 in_tangent; // w: sign of the bitangent
in float in_share;  // share of direct light that shadows leave
in ivec2 in_gloss;  // material and probe
#endif

out vec2 uv;
out vec2 map;
out vec3 light;
out vec2 bend;
flat out ivec2 layers;
#ifdef GLOSSY
out vec3 normal;
out vec4 tangent;
out float share;
flat out ivec2 gloss;
#endif

void main() {
    gl_Position = clip_from_world * vec4(in_position, 1.0);
    uv = in_uv;
    map = in_map;
    light = in_light;
    bend = in_bend;
    layers = in_layers;
#ifdef GLOSSY
    normal = in_normal;
    tangent = in_tangent;
    share = in_share;
    gloss = in_gloss;
#endif
}
