// How much of the surroundings each place sees, from the depth of the picture at half size.

@group(1) @binding(0) var depth_map: texture_depth_2d;
@group(1) @binding(1) var raw_map: texture_2d<f32>;
@group(1) @binding(2) var smooth_sampler: sampler;

// Reach of what hides [field radii], and the largest on the screen [pixels of the half size].
const REACH: f32 = 0.05;

@vertex
fn whole_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return whole(index);
}

// Place in the view frame of a pixel of the half size.
fn place_at(pixel: vec2i, size: vec2i) -> vec3f {
    let at = clamp(pixel, vec2i(0), size - 1);
    let depth = min(textureLoad(depth_map, at, 0), 0.99999);
    let ahead = scene.lens.w / (1.0 - depth);
    let full = 2.0 * (vec2f(at) + 0.5);
    let clip = vec2f(sign(scene.lens.x) * (full.x - scene.field.x), scene.field.y - full.y) / scene.field.z;
    let x = scene.eye.x + (clip.x - scene.eye.x) * ahead / scene.lens.z;
    return vec3f(x, clip.y * ahead / scene.lens.z, scene.lens.z - ahead);
}

@fragment
fn openness_fragment(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let size = vec2i(textureDimensions(depth_map));
    let at = vec2i(pixel.xy);
    let radius = distance(2.0 * pixel.xy, scene.field.xy) / scene.field.z;
    let here = place_at(at, size);
    if radius > 1.01 || textureLoad(depth_map, clamp(at, vec2i(0), size - 1), 0) >= 0.99999 {
        return vec4f(1.0);
    }
    // The flatter side is of the plane, the other may be across an edge.
    let right = place_at(at + vec2i(1, 0), size) - here;
    let left = here - place_at(at - vec2i(1, 0), size);
    let down = place_at(at + vec2i(0, 1), size) - here;
    let up = here - place_at(at - vec2i(0, 1), size);
    let across = select(left, right, abs(right.z) < abs(left.z));
    let along = select(up, down, abs(down.z) < abs(up.z));
    let normal = normalize(cross(along, across)) * sign(scene.lens.x);
    let reach = REACH * 0.5 * scene.field.z;
    let turn = 6.2831853 * grain(pixel.xy);
    let count = select(6u, 12u, QUALITY == 2u);
    var hidden = 0.0;
    for (var i = 0u; i < count; i++) {
        let distance = (f32(i) + 0.7) / f32(count);
        let angle = 2.3999632 * f32(i) + turn;
        let step = vec2i(round(reach * distance * vec2f(cos(angle), sin(angle))));
        let off = place_at(at + step, size) - here;
        let squared = dot(off, off);
        let rise = max(dot(off, normal) - 0.006, 0.0);
        let near = max(1.0 - squared / (4.0 * REACH * REACH), 0.0);
        hidden += near * rise / (squared + 0.0001) * REACH;
    }
    let open = clamp(1.0 - 0.9 * hidden / f32(count), 0.0, 1.0);
    return vec4f(open);
}

// Mean over four by four pixels, the period of the noise.
@fragment
fn smooth_fragment(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    // Four lookups between four texels each.
    let texel = 1.0 / vec2f(textureDimensions(raw_map));
    let at = pixel.xy * texel;
    var sum = textureSampleLevel(raw_map, smooth_sampler, at + vec2f(-1.5, -1.5) * texel, 0.0).r;
    sum += textureSampleLevel(raw_map, smooth_sampler, at + vec2f(0.5, -1.5) * texel, 0.0).r;
    sum += textureSampleLevel(raw_map, smooth_sampler, at + vec2f(-1.5, 0.5) * texel, 0.0).r;
    sum += textureSampleLevel(raw_map, smooth_sampler, at + vec2f(0.5, 0.5) * texel, 0.0).r;
    return vec4f(0.25 * sum);
}
