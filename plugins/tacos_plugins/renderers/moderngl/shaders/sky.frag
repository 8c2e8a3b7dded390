#version 330
// Luminance of what lies beyond the geometry [cd/m2].

uniform sampler2D sky;   // rows from the zenith to the nadir, columns from +x by way of +y
uniform vec4 ray_x;      // world direction of a pixel centre: x * ray_x + y * ray_y + ray_origin, depth 1
uniform vec4 ray_y;
uniform vec4 ray_origin;

out vec4 luminance;

const float PI = 3.14159265358979;

void main() {
    vec3 d = normalize(gl_FragCoord.x * ray_x.xyz + gl_FragCoord.y * ray_y.xyz + ray_origin.xyz);
    vec2 at = vec2(atan(d.y, d.x) / (2.0 * PI), acos(clamp(d.z, -1.0, 1.0)) / PI);
    luminance = vec4(textureLod(sky, at, 0.0).rgb, 1.0);
}
