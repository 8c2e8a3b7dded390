#version 330

flat in float surface;
#ifdef DEPTH
in float depth_m;
out vec2 geometry;
#else
out float geometry;
#endif

void main() {
#ifdef DEPTH
    geometry = vec2(depth_m, surface);
#else
    geometry = surface;
#endif
}
