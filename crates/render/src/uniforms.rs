//! What the shaders read of a whole picture.

use crate::light::{AMBIENT, COAXIAL, key_light_direction, key_strength, linear_from_srgb};
use crate::picture::{Picture, View};
use microsim_message::depth_of_field;

/// Side of the shadow map \[texels\].
pub(crate) const SHADOW_SIDE: u32 = 1024;
/// Half the side of the square across the key light that the shadow map covers \[field radii\]: the field, seen at 35°, and what
/// stands up to one radius high in it.
const SHADOW_REACH: f64 = 1.5;
/// Depth range of the shadow map along the key light \[field radii\], with the focus point at zero: instruments reach up, nothing
/// below is seen for long.
const SHADOW_DEPTHS: [f64; 2] = [-3.0, 9.0];
/// Nearest plane that is drawn, in parts of the working distance. Shafts that reach higher have left the field.
const NEAR: f64 = 0.2;
/// How far lookups leave the surface \[texels of the shadow map\]: the reach of the narrowest filter.
const LOOKUP: f64 = 2.0;
/// Half the angle under which the field sees the key light \[rad\]: 2.5°, as of a lens of 22 mm at 250 mm.
const LAMP: f64 = 2.5 * std::f64::consts::PI / 180.0;

/// The shader's `Scene`, same order.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Scene {
    lens: [f32; 4],
    eye: [f32; 4],
    light: [[f32; 4]; 3],
    lamps: [f32; 4],
    background: [f32; 4],
    field: [f32; 4],
    focus: [f32; 4],
}

impl Scene {
    /// Of a picture, drawn at a size \[pixels\] from a place across the view axis \[m\].
    pub fn new(picture: &Picture, (width, height): (u32, u32), beside: f64) -> Self {
        let View {
            field_diameter,
            working_distance,
            ..
        } = picture.view;
        let (width, height) = (f64::from(width), f64::from(height));
        let field_pixels = 0.5 * width.min(height);
        let unit = 0.5 * field_diameter;
        let eye = working_distance / unit;
        // The frame of the view is that of what is drawn: in it, a mirror exchanges the sides of the eye and of the lamp instead.
        let side = if picture.mirrored { -1.0 } else { 1.0 };
        let mut towards = nalgebra::Vector3::from(key_light_direction());
        towards.x *= side;
        let across = nalgebra::Vector3::y().cross(&towards).normalize();
        let along = towards.cross(&across);
        let [far, near] = SHADOW_DEPTHS;
        let single = |parts: [f64; 4]| parts.map(|part| part as f32);
        let row =
            |axis: nalgebra::Vector3<f64>, scale: f64| single([axis.x, axis.y, axis.z, scale]);
        let texel = 2.0 * SHADOW_REACH / f64::from(SHADOW_SIDE);
        let [red, green, blue] = picture
            .background
            .map(|part| linear_from_srgb(f64::from(part)));
        // Depth runs over the whole range, places over twice the reach.
        let penumbra = libm::tan(LAMP) * (near - far) / (2.0 * SHADOW_REACH);
        Self {
            lens: single([
                side * 2.0 * field_pixels / width,
                2.0 * field_pixels / height,
                eye,
                NEAR * eye,
            ]),
            eye: single([
                side * beside / unit,
                1e3 * unit,
                1e3 * unit / field_pixels,
                LOOKUP * texel,
            ]),
            light: [
                row(across, 1.0 / SHADOW_REACH),
                row(along, 1.0 / SHADOW_REACH),
                row(towards, 1.0 / (near - far)),
            ],
            lamps: single([AMBIENT, COAXIAL, key_strength(), far]),
            background: single([red, green, blue, penumbra]),
            field: single([
                0.5 * width,
                0.5 * height,
                field_pixels,
                1.0 / f64::from(SHADOW_SIDE),
            ]),
            focus: single([0.5e3 * depth_of_field(field_diameter), 0.0, 0.0, 0.0]),
        }
    }
}
