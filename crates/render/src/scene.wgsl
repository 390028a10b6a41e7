// What all passes read. All positions are in the view frame: origin in the focus point, x right, y up, z towards the eye, unit one field radius.

struct Scene {
    // x, y: clip coordinates per unit in the plane of focus, x negative in a mirrored picture; z: distance of the eye; w: distance of the near plane.
    lens: vec4f,
    // x: place of the eye across the view axis; y: millimetres per unit; z: millimetres per pixel; w: distance by which shadow lookups leave the surface.
    eye: vec4f,
    // Rows of the rotation to the key light's frame (its z points to the light); w: scale to shadow coordinates -1..1 for
    // the first two, for the third the depth range.
    light_x: vec4f,
    light_y: vec4f,
    light_z: vec4f,
    // x: ambient, y: coaxial, z: key strength; w: height of the far end of the shadow's depth range.
    lamps: vec4f,
    // Colour where there is no item, linear; w: tangent of the half angle of the lamp, as penumbra per depth in shadow coordinates.
    background: vec4f,
    // x, y: middle of the picture [pixels]; z: radius of the field [pixels]; w: one texel of the shadow map (0..1).
    field: vec4f,
    // x: depth to each side of the plane of focus that is sharp [mm].
    focus: vec4f,
}

// 0 low, 1 medium, 2 high.
override QUALITY: u32 = 1u;

@group(0) @binding(0) var<uniform> scene: Scene;

fn projected(position: vec3f) -> vec4f {
    // Perspective with the eye at height `lens.z`; depth runs from 0 at the near plane to 1 at infinity. An eye beside the axis has an off-axis frustum:
    // the plane of focus is the same for both.
    let ahead = scene.lens.z - position.z;
    let across = (position.x - scene.eye.x) * scene.lens.z + scene.eye.x * ahead;
    return vec4f(across * scene.lens.x, position.y * scene.lens.y * scene.lens.z, ahead - scene.lens.w, ahead);
}

// A direction as it appears on the screen: lamps and room stay where they are in a mirrored picture.
fn on_screen(direction: vec3f) -> vec3f {
    return direction * vec3f(sign(scene.lens.x), 1.0, 1.0);
}

// 1 inside, 0 outside, a soft edge over the outermost hundredth, and the fall-off of the lamp towards it.
fn field_mask(pixel: vec2f) -> f32 {
    let radius = distance(pixel, scene.field.xy) / scene.field.z;
    let edge = 1.0 - smoothstep(0.99, 1.0, radius);
    let falloff = 1.0 - 0.4 * smoothstep(0.55, 1.05, radius);
    return edge * falloff;
}

// Noise that spreads evenly over neighbouring pixels (interleaved gradient noise), 0..1.
fn grain(pixel: vec2f) -> f32 {
    return fract(52.9829189 * fract(dot(pixel, vec2f(0.06711056, 0.00583715))));
}

// One triangle that covers the picture.
fn whole(index: u32) -> vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 1.0, 1.0);
}
