// Passes over the items: depth of the key light's view (shadow), depth at half size (for what is hidden from the surroundings), background with the round field,
// surfaces.

// What a pipeline draws: 0 matte, 1 moist objects, 2 metal, 3 tissue.
override FAMILY: u32 = 0u;

@group(1) @binding(0) var shadow_map: texture_depth_2d;
@group(1) @binding(1) var shadow_sampler: sampler_comparison;
@group(1) @binding(2) var openness_map: texture_2d<f32>;
@group(1) @binding(3) var smooth_sampler: sampler;

struct Corner {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) rest: vec3f,
    @location(3) layer: f32,
    // Rows from the item's frame to the view frame.
    @location(4) row_x: vec4f,
    @location(5) row_y: vec4f,
    @location(6) row_z: vec4f,
    // Linear light, opacity.
    @location(7) colour: vec4f,
    // x: 1 of a cloth. y, z: opacity below which a surface is not there, and what that of its texture is multiplied by.
    @location(8) pattern: vec4f,
    // Of a texture, from its upper left corner.
    @location(9) coordinates: vec2f,
}

fn placed(corner: Corner) -> vec3f {
    let p = vec4f(corner.position, 1.0);
    return vec3f(dot(corner.row_x, p), dot(corner.row_y, p), dot(corner.row_z, p));
}

// --- Shadow map: orthographic along the key light ---------------------------------------------------------------------

fn light_clip(position: vec3f) -> vec3f {
    return vec3f(
        dot(position, scene.light_x.xyz) * scene.light_x.w,
        dot(position, scene.light_y.xyz) * scene.light_y.w,
        1.0 - (dot(position, scene.light_z.xyz) - scene.lamps.w) * scene.light_z.w,
    );
}

@vertex
fn shadow_vertex(corner: Corner) -> @builtin(position) vec4f {
    return vec4f(light_clip(placed(corner)), 1.0);
}

@vertex
fn depth_vertex(corner: Corner) -> @builtin(position) vec4f {
    return projected(placed(corner));
}

// Points of a disc, spread evenly: the golden angle.
fn spread(index: u32, count: u32, turn: f32) -> vec2f {
    let radius = sqrt((f32(index) + 0.5) / f32(count));
    let angle = 2.3999632 * f32(index) + turn;
    return radius * vec2f(cos(angle), sin(angle));
}

// Fraction of the key light that arrives, 0..1. The penumbra widens with the distance of what casts the shadow; low quality has one width.
fn key_visibility(position: vec3f, pixel: vec2f) -> f32 {
    let clip = light_clip(position);
    // What lies outside the map is lit.
    let inside = all(abs(clip.xy) < vec2f(1.0));
    let place = vec2f(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y);
    let depth = clamp(clip.z, 0.0, 1.0);
    let texel = scene.field.w;
    var visible = 0.0;
    if QUALITY == 0u {
        let step = 1.4 * texel;
        visible = textureSampleCompareLevel(shadow_map, shadow_sampler, place + vec2f(-step, -0.4 * step), depth);
        visible += textureSampleCompareLevel(shadow_map, shadow_sampler, place + vec2f(0.4 * step, -step), depth);
        visible += textureSampleCompareLevel(shadow_map, shadow_sampler, place + vec2f(step, 0.4 * step), depth);
        visible += textureSampleCompareLevel(shadow_map, shadow_sampler, place + vec2f(-0.4 * step, step), depth);
        visible *= 0.25;
    } else {
        let turn = 6.2831853 * grain(pixel);
        // What lies between the surface and the lamp, on the mean.
        let search = 7.0 * texel;
        var sum = 0.0;
        var found = 0.0;
        let side = f32(textureDimensions(shadow_map).x);
        let looks = select(4u, 6u, QUALITY == 2u);
        for (var i = 0u; i < looks; i++) {
            let at = place + search * spread(i, looks, turn);
            let nearest = textureLoad(shadow_map, vec2i(clamp(at, vec2f(0.0), vec2f(0.9999)) * side), 0);
            let covers = select(0.0, 1.0, nearest < depth - 0.0002);
            sum += covers * nearest;
            found += covers;
        }
        let above = select(0.0, depth - sum / found, found > 0.0);
        let radius = clamp(scene.background.w * above, 1.3 * texel, 7.0 * texel);
        let count = select(6u, 12u, QUALITY == 2u);
        for (var i = 0u; i < count; i++) {
            visible += textureSampleCompareLevel(shadow_map, shadow_sampler, place + radius * spread(i, count, turn), depth);
        }
        visible /= f32(count);
    }
    return select(1.0, visible, inside);
}

// --- Round field ------------------------------------------------------------------------------------------------------

@vertex
fn background_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return whole(index);
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
    // Place in the material [mm]; w: layer.
    @location(3) rest: vec4f,
    @location(4) pattern: vec4f,
    @location(5) coordinates: vec2f,
}

@vertex
fn surface_vertex(corner: Corner) -> Surface {
    let position = placed(corner);
    let n = corner.normal;
    let normal = vec3f(dot(corner.row_x.xyz, n), dot(corner.row_y.xyz, n), dot(corner.row_z.xyz, n));
    return Surface(projected(position), position, normal, corner.colour, vec4f(corner.rest, corner.layer), corner.pattern, corner.coordinates);
}

// Value noise, 0..1.
fn scrambled(cell: vec3i) -> f32 {
    var h = u32(cell.x) * 0x8da6b343u + u32(cell.y) * 0xd8163841u + u32(cell.z) * 0xcb1ab31fu;
    h = (h ^ (h >> 15u)) * 0x2c1b3c6du;
    h ^= h >> 12u;
    return f32(h & 0xffffu) / 65535.0;
}

fn noise(place: vec3f) -> f32 {
    let base = floor(place);
    let f = place - base;
    let u = f * f * (3.0 - 2.0 * f);
    let c = vec3i(base);
    let low = mix(
        mix(scrambled(c), scrambled(c + vec3i(1, 0, 0)), u.x),
        mix(scrambled(c + vec3i(0, 1, 0)), scrambled(c + vec3i(1, 1, 0)), u.x),
        u.y,
    );
    let high = mix(
        mix(scrambled(c + vec3i(0, 0, 1)), scrambled(c + vec3i(1, 0, 1)), u.x),
        mix(scrambled(c + vec3i(0, 1, 1)), scrambled(c + vec3i(1, 1, 1)), u.x),
        u.y,
    );
    return mix(low, high, u.z);
}

// 1 where a pattern with this many periods per millimetre is coarse enough to be seen, 0 where it would flicker.
fn seen(frequency: f32) -> f32 {
    return 1.0 - smoothstep(0.25, 0.6, frequency * scene.eye.z);
}

// What the material adds to a surface at a place.
struct Look {
    albedo: vec3f,
    // Height of its relief [mm].
    relief: f32,
    roughness: f32,
    // Strength of the wet coat.
    wet: f32,
    // How far light wanders sideways below the surface: red, green, blue.
    wander: vec3f,
}

// Thin red vessels: lines along which a slow noise passes its middle value.
fn vessels(rest: vec3f) -> f32 {
    let line = abs(noise(rest * vec3f(0.55, 1.3, 1.3) + 7.3) - 0.5);
    let patchy = smoothstep(0.40, 0.60, noise(rest * 0.6 + 31.7));
    return (1.0 - smoothstep(0.005, 0.018, line)) * patchy;
}

// Fibres along the axis of the body, wavy; the middle value where they are finer than pixels.
fn fibres(rest: vec3f, frequency: f32) -> f32 {
    let wave = 0.5 / frequency * sin(2.6 * rest.x + 5.0 * rest.y);
    let lines = noise(vec3f(0.14 * rest.x, rest.y + wave, rest.z - wave) * frequency);
    return mix(0.5, lines, seen(frequency));
}

fn tissue_look(layer: f32, colour: vec3f, rest: vec3f) -> Look {
    let kind = u32(layer + 0.5);
    let slow = noise(rest * 1.7 + 11.0);
    let detailed = QUALITY > 0u;
    var look = Look(colour, 0.0, 0.34, 1.0, vec3f(0.32, 0.12, 0.08));
    var fine = 0.5;
    if detailed {
        fine = fibres(rest, 17.0);
    }
    let coarse = fibres(rest, 7.0);
    let red = vec3f(0.42, 0.035, 0.03);
    switch kind {
        case 0u: {
            // Connective tissue: mottled, a film over it, thin vessels in it.
            look.albedo = colour * (0.78 + 0.42 * slow) * mix(vec3f(1.0), vec3f(1.06, 1.02, 1.0), coarse - 0.3);
            look.albedo = mix(look.albedo, red, 0.40 * vessels(rest));
            look.roughness = 0.25;
            look.relief = 0.060 * slow + 0.022 * coarse + 0.008 * fine;
        }
        case 1u: {
            // Adventitia: whitish strands over what lies below, which shows where they are thin.
            let strands = smoothstep(0.20, 0.80, 0.4 * coarse + 0.6 * fine);
            let below = mix(colour, vec3f(0.62, 0.22, 0.18), 0.35);
            look.albedo = mix(below, vec3f(0.80, 0.72, 0.66), 0.5 + 0.35 * strands);
            look.albedo = mix(look.albedo, red, 0.45 * vessels(rest));
            look.relief = 0.030 * slow + 0.014 * coarse + 0.008 * fine;
            look.roughness = 0.38;
            look.wet = 0.85;
        }
        case 2u: {
            // Media: pale, smooth, faint rings of muscle.
            let rings = noise(vec3f(7.0 * rest.x, 0.8 * rest.y, 0.8 * rest.z));
            look.albedo = mix(colour, vec3f(0.80, 0.40, 0.29), 0.75) * (0.93 + 0.1 * rings + 0.06 * slow);
            look.relief = 0.002 * rings;
            look.roughness = 0.26;
        }
        case 3u: {
            // Lumen: dark with what blood is left, glistening.
            look.albedo = mix(colour, vec3f(0.20, 0.012, 0.010), 0.90) * (0.8 + 0.3 * slow);
            look.roughness = 0.2;
            look.wet = 0.8;
        }
        case 4u: {
            // Cut tissue: raw, grainy.
            look.albedo = mix(colour, vec3f(0.46, 0.035, 0.035), 0.62) * (0.82 + 0.36 * coarse);
            look.relief = 0.020 * slow + 0.010 * fine + 0.010 * coarse;
            look.roughness = 0.24;
        }
        case 5u: {
            // Loose tissue: white, fibrous, lets light through.
            let strands = smoothstep(0.2, 0.8, 0.5 * coarse + 0.5 * fine);
            look.albedo = mix(mix(colour, vec3f(0.72, 0.42, 0.36), 0.5), vec3f(0.86, 0.84, 0.82), 0.4 + 0.5 * strands);
            look.relief = 0.030 * slow + 0.020 * coarse + 0.010 * fine;
            look.roughness = 0.45;
            look.wet = 0.7;
            look.wander = vec3f(0.55, 0.36, 0.30);
        }
        default: {
            // Vein: thin, blood shows blue through it.
            look.albedo = mix(colour, vec3f(0.26, 0.17, 0.33), 0.6) * (0.85 + 0.3 * slow);
            look.albedo = mix(look.albedo, vec3f(0.62, 0.52, 0.55), 0.25 * coarse);
            look.relief = 0.004 * coarse;
            look.roughness = 0.26;
        }
    }
    return look;
}

// Normal of a surface with a relief [view units], from how it changes between neighbouring pixels.
fn embossed(normal: vec3f, position: vec3f, relief: f32) -> vec3f {
    let dx = dpdx(position);
    let dy = dpdy(position);
    let across = cross(dy, normal);
    let along = cross(normal, dx);
    let area = dot(dx, across);
    let slope = sign(area) * (dpdx(relief) * across + dpdy(relief) * along);
    // Steeper than 45° is a seam between neighbouring pixels, not a relief.
    let most = abs(area);
    let size = length(slope);
    return normalize(most * normal - slope * min(1.0, most / max(size, 1e-12)));
}

// Microfacets (GGX, Smith) with the reflection of water or steel at right angles `f0`; times the cosine to the light.
fn glint(normal: vec3f, to_eye: vec3f, to_light: vec3f, roughness: f32, f0: vec3f) -> vec3f {
    let halfway = normalize(to_light + to_eye);
    let nh = max(dot(normal, halfway), 0.0);
    let nl = max(dot(normal, to_light), 0.0);
    let nv = max(dot(normal, to_eye), 0.05);
    let vh = max(dot(to_eye, halfway), 0.0);
    let a = roughness * roughness;
    let a2 = a * a;
    let d = nh * nh * (a2 - 1.0) + 1.0;
    let k = 0.5 * a;
    let shading = 0.25 / ((nl * (1.0 - k) + k) * (nv * (1.0 - k) + k));
    let m = 1.0 - vh;
    let fresnel = f0 + (1.0 - f0) * (m * m * m * m * m);
    return fresnel * (a2 / (3.14159265 * d * d) * shading * nl);
}

// Light from direction `toward` as steel mirrors it: the microscope overhead with its dark lens in a lit ring, two lamps at the ceiling, the dim walls of the room. It is
// near: what is mirrored changes along an instrument, whose facets are flat.
fn surroundings(place: vec3f, toward: vec3f) -> f32 {
    let seen = on_screen(normalize(toward * 1.6 + 1.1 * place));
    let room = 0.10 + 0.30 * smoothstep(-0.4, 0.7, seen.z);
    let ring = 1.10 * smoothstep(0.72, 0.86, seen.z) * (1.0 - 0.55 * smoothstep(0.95, 0.99, seen.z));
    let left = 0.85 * smoothstep(0.80, 0.90, dot(seen, vec3f(-0.62, 0.38, 0.69)));
    let right = 0.55 * smoothstep(0.84, 0.93, dot(seen, vec3f(0.80, 0.10, 0.59)));
    let window = 0.30 * smoothstep(0.55, 0.8, seen.y) * (1.0 - smoothstep(0.2, 0.5, abs(seen.x)));
    return room + ring + left + right + window;
}

// Highlights are brighter than a screen: what is above 0.65 is compressed, evenly, towards 1.
fn toned(light: vec3f) -> vec3f {
    let knee = vec3f(0.65);
    let above = max(light - knee, vec3f(0.0));
    return min(light, knee) + 0.35 * (1.0 - exp(-above / 0.35));
}

@group(2) @binding(0) var base_colour: texture_2d<f32>;
@group(2) @binding(1) var base_sampler: sampler;

@fragment
fn surface_fragment(surface: Surface) -> @location(0) vec4f {
    return shaded(surface, surface.colour.rgb);
}

@fragment
fn textured_fragment(surface: Surface) -> @location(0) vec4f {
    return shaded(surface, surface.colour.rgb * textureSample(base_colour, base_sampler, surface.coordinates).rgb);
}

// --- Surfaces that are not there where their texture is translucent ---------------------------------------------------

struct Cut {
    @builtin(position) pixel: vec4f,
    @location(0) coordinates: vec2f,
    @location(1) pattern: vec4f,
}

@vertex
fn cut_shadow_vertex(corner: Corner) -> Cut {
    return Cut(vec4f(light_clip(placed(corner)), 1.0), corner.coordinates, corner.pattern);
}

@vertex
fn cut_depth_vertex(corner: Corner) -> Cut {
    return Cut(projected(placed(corner)), corner.coordinates, corner.pattern);
}

fn is_there(opacity: f32, pattern: vec4f) -> bool {
    return opacity * pattern.z >= pattern.y;
}

@fragment
fn cut_fragment(cut: Cut) {
    if !is_there(textureSample(base_colour, base_sampler, cut.coordinates).a, cut.pattern) {
        discard;
    }
}

@fragment
fn masked_fragment(surface: Surface) -> @location(0) vec4f {
    let texel = textureSample(base_colour, base_sampler, surface.coordinates);
    if !is_there(texel.a, surface.pattern) {
        discard;
    }
    return shaded(surface, surface.colour.rgb * texel.rgb);
}

fn shaded(surface: Surface, base: vec3f) -> vec4f {
    let to_eye = normalize(vec3f(scene.eye.x, 0.0, scene.lens.z) - surface.position);
    // Both sides of a surface are drawn: the normal is the one on the eye's side.
    var normal = normalize(surface.normal);
    let facing = dot(normal, to_eye);
    normal = select(-normal, normal, facing >= 0.0);
    let front = abs(facing);
    let to_light = scene.light_z.xyz;
    let smooth_normal = normal;
    let lamp = key_visibility(surface.position + normal * scene.eye.w, surface.pixel.xy);
    var albedo = base;
    var open = 1.0;
    if QUALITY > 0u {
        let size = vec2f(textureDimensions(openness_map)) * 2.0;
        open = textureSampleLevel(openness_map, smooth_sampler, surface.pixel.xy / size, 0.0).r;
    }
    // The surroundings reach less of a crevice than the lamps, which look into it.
    let open_lamps = 0.5 + 0.5 * open;
    let mask = field_mask(surface.pixel.xy);

    if FAMILY == 0u {
        if surface.pattern.x > 0.5 {
            let rest = surface.rest.xyz;
            // Weave of a cloth: threads of a third of a millimetre over and under each other, fading where they are finer than pixels.
            let thread = rest.xy * 3.0;
            let over = sin(6.2831853 * thread.x) * sin(6.2831853 * thread.y);
            let shade = noise(vec3f(rest.xy * 0.35, 0.0)) - 0.5;
            var speckle = 0.0;
            if QUALITY > 0u {
                speckle = noise(vec3f(rest.xy * 5.0, 2.0)) - 0.5;
            }
            albedo *= 1.0 + 0.16 * shade + seen(3.0) * (0.10 * over + 0.10 * speckle);
        }
        let slope = max(dot(normal, to_light), 0.0);
        let ambient = scene.lamps.x * (0.6 + 0.4 * normal.z) * open;
        let diffuse = ambient + (scene.lamps.y * front + scene.lamps.z * slope * lamp) * open_lamps;
        // Its light is at most what the lamps give: nothing to compress.
        return vec4f(albedo * diffuse * mask, surface.colour.a);
    }

    if FAMILY == 2u {
        let rest = surface.rest.xyz;
        if QUALITY > 0u {
            // Brushed along its length, fine lines that bend the mirror image.
            let brush = noise(vec3f(rest.x * 28.0, rest.y * 28.0, rest.z * 0.6)) - 0.5;
            let spots = noise(rest * 1.3) - 0.5;
            normal = normalize(normal + (0.16 * brush * seen(14.0) + 0.05 * spots) * cross(normal, vec3f(0.31, 0.59, 0.75)));
            albedo *= 1.0 + 0.08 * spots;
        }
        // A colour is what matte paint would have: metal mirrors more than that.
        albedo = min(1.6 * albedo + vec3f(0.03), vec3f(0.9));
        let slope = max(dot(normal, to_light), 0.0);
        let ambient = scene.lamps.x * (0.6 + 0.4 * normal.z) * open;
        let diffuse = ambient + scene.lamps.y * front + scene.lamps.z * slope * lamp;
        let toward = reflect(-to_eye, normal);
        // Little of the room is seen from within a crevice, between jaws for example.
        var mirrored = vec3f(surroundings(surface.position, toward) * open);
        // The mirror image of the field below.
        mirrored = mix(mirrored, scene.background.rgb * 1.2 + vec3f(0.06, 0.02, 0.02), smoothstep(0.1, -0.4, toward.z));
        // Metal mirrors all colours alike at grazing angles.
        let grazing = 1.0 - front;
        let tint = mix(albedo, vec3f(0.9), 0.6 * grazing * grazing * grazing);
        // Surgical steel is satin, so that it does not dazzle: a part of it answers like a matte surface.
        let shine = glint(normal, to_eye, to_light, 0.30, albedo) * (2.6 * lamp);
        let colour = tint * (0.12 * diffuse + 1.15 * mirrored * (0.55 + 0.45 * lamp)) + shine;
        return vec4f(toned(colour) * mask, surface.colour.a);
    }

    // Moist objects and tissue: light that wanders below the surface, under a thin coat of water.
    var look = Look(albedo, 0.0, 0.30, 1.0, vec3f(0.12));
    if FAMILY == 3u {
        look = tissue_look(surface.rest.w, albedo, surface.rest.xyz);
        normal = embossed(normal, surface.position, look.relief / scene.eye.y);
    }
    let wander = look.wander;
    let slope = dot(normal, to_light);
    let lit = max((vec3f(slope) + wander) / (1.0 + wander), vec3f(0.0));
    // Light that enters beside a shadow comes out within it, red the most.
    let soft_lamp = pow(vec3f(lamp), 1.0 - 0.75 * wander);
    let ambient = scene.lamps.x * (0.6 + 0.4 * normal.z) * open;
    let diffuse = vec3f(ambient) + (vec3f(scene.lamps.y * front) + scene.lamps.z * lit * soft_lamp) * open_lamps;
    var colour = look.albedo * diffuse;
    // Where little light gets into a crevice it comes back red.
    colour *= mix(vec3f(1.0, 0.82, 0.80), vec3f(1.0), open);
    // The film of water is smoother than the tissue below.
    let coat = normalize(mix(normal, smooth_normal, 0.45));
    let water = vec3f(0.03);
    var shine = glint(coat, to_eye, to_light, look.roughness, water) * (4.0 * lamp);
    shine += glint(coat, to_eye, normalize(on_screen(vec3f(0.10, 0.06, 1.0))), look.roughness + 0.08, water) * (1.4 * open);
    if FAMILY == 3u {
        // Small bright points where the film is curved: the lamp itself, and the ring about the lens.
        let drops = normalize(mix(normal, smooth_normal, 0.15));
        shine += glint(drops, to_eye, to_light, 0.5 * look.roughness, water) * (2.2 * lamp);
        shine += glint(drops, to_eye, normalize(on_screen(vec3f(-0.22, 0.10, 1.0))), 0.5 * look.roughness, water) * (0.8 * open);
    }
    let grazing = 1.0 - max(dot(coat, to_eye), 0.0);
    let rim = grazing * grazing * grazing;
    shine += vec3f(0.22 * rim * open * surroundings(surface.position, reflect(-to_eye, coat)));
    colour += shine * look.wet;
    return vec4f(toned(colour) * mask, surface.colour.a);
}
