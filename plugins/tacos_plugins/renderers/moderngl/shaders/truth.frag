#version 330

in float depth_m;
flat in float surface;

out vec2 truth;

void main() {
    truth = vec2(depth_m, surface);
}
