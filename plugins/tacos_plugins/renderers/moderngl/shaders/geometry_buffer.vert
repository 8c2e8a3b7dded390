#version 330
// Truth: which smooth surface is seen and its distance along the optical axis.

uniform mat4 clip_from_world;

in vec3 in_position;
in int in_surface;

flat out float surface;
uniform vec4 depth_from_world; // third row of camera_from_world
out float depth_m;

void main() {
    vec4 world = vec4(in_position, 1.0);
    gl_Position = clip_from_world * world;
    surface = float(in_surface); // exact up to 2^24
    depth_m = dot(depth_from_world, world);
}
