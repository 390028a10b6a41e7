// Three passes over one scene: depth of the key light's view (shadow), background with the round field, surfaces.
// All positions are in the view frame: origin in the focus point, x right, y up, z towards the eye, unit one field radius.

struct Scene {
    // x, y: clip coordinates per unit in the plane of focus; z: distance of the eye; w: distance of the near plane.
    lens: vec4f,
    // Rows of the rotation to the key light's frame (its z points to the light); w: scale to shadow coordinates -1..1 for
    // the first two, for the third the depth range.
    light_x: vec4f,
    light_y: vec4f,
    light_z: vec4f,
    // x: ambient, y: coaxial, z: key strength; w: height of the far end of the shadow's depth range.
    lamps: vec4f,
    // Colour where there is no item, linear; w: distance by which shadow lookups leave the surface.
    background: vec4f,
    // x, y: middle of the picture [pixels]; z: radius of the field [pixels]; w: one texel of the shadow map (0..1).
    field: vec4f,
}

@group(0) @binding(0) var<uniform> scene: Scene;
@group(1) @binding(0) var shadow_map: texture_depth_2d;
@group(1) @binding(1) var shadow_sampler: sampler_comparison;

// --- Shadow map: orthographic along the key light ---------------------------------------------------------------------

fn light_clip(position: vec3f) -> vec3f {
    return vec3f(
        dot(position, scene.light_x.xyz) * scene.light_x.w,
        dot(position, scene.light_y.xyz) * scene.light_y.w,
        1.0 - (dot(position, scene.light_z.xyz) - scene.lamps.w) * scene.light_z.w,
    );
}

@vertex
fn shadow_vertex(@location(0) position: vec3f) -> @builtin(position) vec4f {
    return vec4f(light_clip(position), 1.0);
}

// Share of the key light that arrives, 0..1: four bilinear comparisons, a soft edge about five texels wide.
fn key_visibility(position: vec3f) -> f32 {
    let clip = light_clip(position);
    let place = vec2f(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y);
    let depth = clamp(clip.z, 0.0, 1.0);
    let step = 1.5 * scene.field.w;
    var visible = textureSampleCompareLevel(shadow_map, shadow_sampler, place + vec2f(-step, -0.5 * step), depth);
    visible += textureSampleCompareLevel(shadow_map, shadow_sampler, place + vec2f(0.5 * step, -step), depth);
    visible += textureSampleCompareLevel(shadow_map, shadow_sampler, place + vec2f(step, 0.5 * step), depth);
    visible += textureSampleCompareLevel(shadow_map, shadow_sampler, place + vec2f(-0.5 * step, step), depth);
    // What lies outside the map is lit.
    let inside = all(abs(clip.xy) < vec2f(1.0));
    return select(1.0, 0.25 * visible, inside);
}

// --- Round field ------------------------------------------------------------------------------------------------------

// 1 inside, 0 outside, a soft edge over the outermost hundredth, and a slight fall-off of the light towards it.
fn field_mask(pixel: vec2f) -> f32 {
    let radius = distance(pixel, scene.field.xy) / scene.field.z;
    let edge = 1.0 - smoothstep(0.99, 1.0, radius);
    let falloff = 1.0 - 0.25 * smoothstep(0.6, 1.0, radius);
    return edge * falloff;
}

@vertex
fn background_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // One triangle that covers the picture.
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 1.0, 1.0);
}

struct BackgroundPixel {
    @location(0) colour: vec4f,
    // Nearest outside the field, so that no surface is shaded there.
    @builtin(frag_depth) depth: f32,
}

@fragment
fn background_fragment(@builtin(position) pixel: vec4f) -> BackgroundPixel {
    let outside = distance(pixel.xy, scene.field.xy) >= scene.field.z;
    return BackgroundPixel(
        vec4f(scene.background.rgb * field_mask(pixel.xy), 1.0),
        select(1.0, 0.0, outside),
    );
}

// --- Surfaces ---------------------------------------------------------------------------------------------------------

struct Surface {
    @builtin(position) pixel: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) colour: vec4f,
    @location(3) finish: f32,
}

@vertex
fn surface_vertex(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) colour: vec4f,
    @location(3) finish: f32,
) -> Surface {
    // Perspective with the eye at height `lens.z`; depth runs from 0 at the near plane to 1 at infinity.
    let ahead = scene.lens.z - position.z;
    let clip = vec4f(position.xy * scene.lens.xy * scene.lens.z, ahead - scene.lens.w, ahead);
    return Surface(clip, position, normal, colour, finish);
}

fn power_64(value: f32) -> f32 {
    let p2 = value * value;
    let p4 = p2 * p2;
    let p8 = p4 * p4;
    let p16 = p8 * p8;
    return p16 * p16 * p16 * p16;
}

// Light from direction `toward` as a polished instrument mirrors it: the dark room at the side, the lit ring of the microscope
// overhead, the lamp.
fn surroundings(toward: vec3f, lamp: f32) -> f32 {
    let overhead = 0.16 + 0.45 * smoothstep(-0.5, 0.7, toward.z);
    let ring = 0.40 * smoothstep(0.72, 0.86, toward.z) * (1.0 - smoothstep(0.93, 0.99, toward.z));
    let glare = 0.9 * smoothstep(0.75, 0.99, dot(toward, scene.light_z.xyz)) * lamp;
    return overhead + ring + glare;
}

@fragment
fn surface_fragment(surface: Surface) -> @location(0) vec4f {
    let to_eye = normalize(vec3f(0.0, 0.0, scene.lens.z) - surface.position);
    // Both sides of a surface are drawn: the normal is the one on the eye's side.
    var normal = normalize(surface.normal);
    let facing = dot(normal, to_eye);
    normal = select(-normal, normal, facing >= 0.0);
    let front = abs(facing);
    let to_light = scene.light_z.xyz;
    let slope = max(dot(normal, to_light), 0.0);
    let lamp = key_visibility(surface.position + normal * scene.background.w);
    let albedo = surface.colour.rgb;

    let ambient = scene.lamps.x * (0.6 + 0.4 * normal.z);
    let diffuse = ambient + scene.lamps.y * front + scene.lamps.z * slope * lamp;
    var colour = albedo * diffuse;
    if surface.finish > 1.5 {
        let mirrored = surroundings(reflect(-to_eye, normal), lamp);
        // Surgical steel is satin, so that it does not dazzle: half of it answers like a matte surface.
        colour = albedo * (0.55 * diffuse + mirrored);
    } else if surface.finish > 0.5 {
        let halfway = normalize(to_light + to_eye);
        let highlight = power_64(max(dot(normal, halfway), 0.0)) * lamp;
        let grazing = 1.0 - front;
        let rim = grazing * grazing * grazing;
        colour += vec3f(0.75 * highlight + 0.10 * rim);
    }
    return vec4f(colour * field_mask(surface.pixel.xy), surface.colour.a);
}
