#version 330

flat in float surface;
#ifdef DEPTH
in float depth_m;
out vec2 truth;
#else
out float truth;
#endif

void main() {
#ifdef DEPTH
    truth = vec2(depth_m, surface);
#else
    truth = surface;
#endif
}
