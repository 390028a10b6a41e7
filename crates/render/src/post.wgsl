// From one or two pictures to the image: depth of field, and the layouts of stereo pictures.

override LAYOUT: u32 = 0u;

@group(1) @binding(0) var left_eye: texture_2d<f32>;
@group(1) @binding(1) var right_eye: texture_2d<f32>;
@group(1) @binding(2) var depth_map: texture_depth_2d;
@group(1) @binding(3) var smooth_sampler: sampler;

@vertex
fn whole_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return whole(index);
}

// Radius of the disc into which a depth out of focus is spread [pixels]: half a pixel of 720 rows for each millimetre beyond what is sharp.
fn spread_of(depth: f32) -> f32 {
    let z = scene.lens.z - scene.lens.w / (1.0 - min(depth, 0.99999));
    let off = max(abs(z) * scene.eye.y - scene.focus.x, 0.0);
    return min(0.0014 * scene.field.z * off, 0.012 * scene.field.z);
}

// The smallest spread about a pixel: depths are known at every second pixel alone, so that the edge of what is sharp would be taken for what lies behind it, and run
// into that.
fn spread_at(at: vec2i) -> f32 {
    let size = vec2i(textureDimensions(depth_map)) - 1;
    let own = at / 2;
    var least = spread_of(textureLoad(depth_map, clamp(own, vec2i(0), size), 0));
    for (var i = 0; i < 4; i++) {
        let beside = own + vec2i(2 * (i & 1) - 1, (i & 2) - 1);
        least = min(least, spread_of(textureLoad(depth_map, clamp(beside, vec2i(0), size), 0)));
    }
    return least;
}

@fragment
fn focus_fragment(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let at = vec2i(pixel.xy);
    let size = vec2f(textureDimensions(left_eye));
    let sharp = textureLoad(left_eye, at, 0);
    let own = spread_at(at);
    if distance(pixel.xy, scene.field.xy) > scene.field.z {
        return sharp;
    }
    let turn = 6.2831853 * grain(pixel.xy);
    var sum = sharp.rgb;
    var weight = 1.0;
    let radius = max(own, 1.0);
    for (var i = 0u; i < 14u; i++) {
        let distance = radius * sqrt((f32(i) + 0.5) / 14.0);
        let angle = 2.3999632 * f32(i) + turn;
        let place = pixel.xy + distance * vec2f(cos(angle), sin(angle));
        // What is sharp does not run into what is not.
        let reaches = clamp(max(spread_at(vec2i(place)), 0.0) - distance + 1.0, 0.0, 1.0);
        sum += reaches * textureSampleLevel(left_eye, smooth_sampler, place / size, 0.0).rgb;
        weight += reaches;
    }
    return vec4f(sum / weight, 1.0);
}

@fragment
fn compose_fragment(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let at = vec2i(pixel.xy);
    let size = vec2i(textureDimensions(left_eye));
    if LAYOUT == 1u {
        let right = at.x >= size.x;
        let place = select(at, at - vec2i(size.x, 0), right);
        return select(textureLoad(left_eye, place, 0), textureLoad(right_eye, place, 0), right);
    }
    if LAYOUT == 2u {
        let lower = at.y >= size.y;
        let place = select(at, at - vec2i(0, size.y), lower);
        return select(textureLoad(left_eye, place, 0), textureLoad(right_eye, place, 0), lower);
    }
    let left = textureLoad(left_eye, at, 0);
    let right = textureLoad(right_eye, at, 0);
    if LAYOUT == 3u {
        return select(left, right, (at.y & 1) == 1);
    }
    // Red of the left eye from its brightness, so that what is red in both does not flicker between them.
    let brightness = dot(left.rgb, vec3f(0.30, 0.59, 0.11));
    return vec4f(mix(left.r, brightness, 0.7), right.g, right.b, 1.0);
}
