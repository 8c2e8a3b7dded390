#version 330
// Truth at pixel centres: distance along the optical axis, and whose surface it is.

uniform mat4 clip_from_world;
uniform vec4 depth_from_world; // third row of camera_from_world

in vec3 in_position;
in int in_object;

out float depth_m;
flat out float object_id;

void main() {
    vec4 world = vec4(in_position, 1.0);
    gl_Position = clip_from_world * world;
    depth_m = dot(depth_from_world, world);
    object_id = float(in_object);
}
