#version 330

flat in float surface;
in float depth_m;
out vec2 geometry;

void main() {
    geometry = vec2(depth_m, surface);
}
