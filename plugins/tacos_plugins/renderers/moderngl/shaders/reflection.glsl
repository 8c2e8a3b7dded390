// What glossy materials mirror: probes hold the light around a place in each room, blurred as a GGX lobe of the
// material's roughness would (split-sum approximation: Karis, "Real shading in Unreal Engine 4", 2013), and are
// looked up with the parallax of a box around the room (Lagarde and Zanuttini, SIGGRAPH 2012). A map from above
// says which probes a place mirrors: one, or two between rooms, so that nothing jumps where nothing is.

uniform vec4 ray_x;      // world direction of a pixel centre: x * ray_x + y * ray_y + ray_origin, depth 1
uniform vec4 ray_y;
uniform vec4 ray_origin;
uniform vec3 eye;        // optical centre in the world [m]
uniform sampler2DArray probes;  // octahedral luminance [cd/m2], one layer per probe and roughness
uniform float probe_scale;      // of octahedral coordinates into a layer, which has a border
uniform vec3 probe_boxes[3 * MOST_PROBES]; // of each: centre; lower and upper corner of the box [m]
uniform sampler2D probe_map;    // in one number: first and second probe, and the share of the second
uniform vec3 map_origin;        // x and y of its corner [m], and cells per metre
uniform int probe_levels;       // layers per probe

in vec3 normal;
flat in vec4 base_roughness;
flat in vec4 emission_metallic;
flat in float level; // of roughness, among the layers of a probe
#ifdef BUMPY
in vec4 tangent; // w: sign of the bitangent
#endif
#ifndef MAPPED
in float share; // share of direct light that shadows leave
#endif

const float DIELECTRIC = 0.04; // reflectance of dielectrics at normal incidence
const float MATTE = 0.8;       // they reflect less the rougher they are, down to nothing here
const float OFF_WALL_M = 0.1; // what is looked up in the map lies this far off the surface
const float HIDDEN = 0.25;     // how much of a reflection remains where no direct light arrives

vec2 octahedral(vec3 d) {
    vec2 p = d.xy / (abs(d.x) + abs(d.y) + abs(d.z));
    vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return d.z >= 0.0 ? p : folded;
}

// Luminance that a probe shows along a direction from a place.
vec3 seen_by(int probe, vec3 position, vec3 direction) {
    vec3 centre = probe_boxes[3 * probe], lower = probe_boxes[3 * probe + 1], upper = probe_boxes[3 * probe + 2];
    vec3 inside = clamp(position, lower, upper);
    vec3 far = max((lower - inside) / direction, (upper - inside) / direction);
    vec3 seen = inside + direction * min(far.x, min(far.y, far.z)) - centre;
    vec2 at = octahedral(seen) * probe_scale + 0.5;
    return texture(probes, vec3(at, float(probe * probe_levels) + level)).rgb;
}

// What is mirrored, and in `left` the share of light that gets beneath the coat to be scattered there.
vec3 mirrored(vec3 texel, vec3 n, float unshadowed, out vec3 left) {
    float roughness = base_roughness.w, metallic = emission_metallic.w;
    vec3 ray = gl_FragCoord.x * ray_x.xyz + gl_FragCoord.y * ray_y.xyz + ray_origin.xyz;
    vec3 position = eye + ray / gl_FragCoord.w;
    vec3 view = -normalize(ray);
    float nv = clamp(dot(n, view), 0.02, 1.0);
    vec3 out_of = reflect(-view, n);

    vec3 safe = mix(vec3(1e-6), out_of, greaterThan(abs(out_of), vec3(1e-6)));
    ivec2 cell = ivec2(((position + OFF_WALL_M * n).xy - map_origin.xy) * map_origin.z);
    int mirrors = int(texelFetch(probe_map, clamp(cell, ivec2(0), textureSize(probe_map, 0) - 1), 0).r);
    float second = float(mirrors >> 10) / 1023.0;
    vec3 around = (1.0 - second) * seen_by(mirrors & 31, position, safe);
    for (int i = 0; i < (second > 0.0 ? 1 : 0); ++i) // software skips a loop, but no branch
        around += second * seen_by((mirrors >> 5) & 31, position, safe);

    // How much a rough mirror returns at this angle (Karis, "Physically based shading on mobile", 2014).
    vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float x = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
    vec2 scale_and_bias = vec2(-1.04, 1.04) * x + r.zw;
    float sheen = clamp((MATTE - roughness) / 0.4, 0.0, 1.0);
    float strength = max(sheen, metallic);
    vec3 f0 = mix(vec3(DIELECTRIC * sheen), base_roughness.rgb * texel, metallic);
    vec3 returned = f0 * scale_and_bias.x + strength * scale_and_bias.y;
    left = 1.0 - returned;
    return returned * around * mix(HIDDEN, 1.0, clamp(unshadowed, 0.0, 1.0)) + emission_metallic.rgb;
}
