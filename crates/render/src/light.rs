//! The lamps: numbers shared by the shader, the renderer and the tests.
//!
//! Three parts light a scene: an even ambient light from the microscope's side, the coaxial light along the view axis, and one
//! oblique key light that alone casts shadows. Their strengths add up to one for a matte surface that faces the microscope, so
//! that such a surface shows exactly the colour it was given, and [`SHADOW_LEVEL`] of it (in linear light) in full shadow.

/// Angle between the key light and the view axis \[rad\]: 35°. A height h over a surface moves its shadow by h·tan 35° = 0.70 h.
pub const KEY_LIGHT_ZENITH: f64 = 35.0 * std::f64::consts::PI / 180.0;

/// Direction in the picture from which the key light comes \[rad\], counted from the right towards the top: 100°, that is from
/// above. Instruments enter from the lower left and the lower right, so that no shadow hides beneath its own shaft.
pub const KEY_LIGHT_AZIMUTH: f64 = 100.0 * std::f64::consts::PI / 180.0;

/// What is left of the light of a matte surface that faces the microscope when the key light does not reach it \[1\].
pub const SHADOW_LEVEL: f64 = AMBIENT + COAXIAL;

/// Ambient light on a surface that faces the microscope \[1\].
pub(crate) const AMBIENT: f64 = 0.20;

/// Coaxial light on a surface that faces the microscope \[1\].
pub(crate) const COAXIAL: f64 = 0.16;

/// Unit vector towards the key light in the view frame (x right, y up in the picture, z towards the eye).
pub fn key_light_direction() -> [f64; 3] {
    let sideways = libm::sin(KEY_LIGHT_ZENITH);
    [
        sideways * libm::cos(KEY_LIGHT_AZIMUTH),
        sideways * libm::sin(KEY_LIGHT_AZIMUTH),
        libm::cos(KEY_LIGHT_ZENITH),
    ]
}

/// Strength of the key light head-on \[1\]: the rest up to one, divided by the cosine at which it meets a surface that faces the
/// microscope.
pub(crate) fn key_strength() -> f64 {
    (1.0 - SHADOW_LEVEL) / libm::cos(KEY_LIGHT_ZENITH)
}

/// Linear light [0, 1] of an sRGB value [0, 1] (IEC 61966-2-1).
pub(crate) fn linear_from_srgb(value: f64) -> f64 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        libm::pow((value + 0.055) / 1.055, 2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The strengths add up to one on a surface that faces the microscope.
    #[test]
    fn lamps_add_up_to_one() {
        let lit = AMBIENT + COAXIAL + key_strength() * key_light_direction()[2];
        assert!((lit - 1.0).abs() < 4.0 * f64::EPSILON, "{lit}");
    }

    /// IEC 61966-2-1: 0.5 is 0.21404 in linear light; the two branches meet.
    #[test]
    fn srgb_follows_the_standard() {
        assert!((linear_from_srgb(0.5) - 0.214_041_14).abs() < 1e-8);
        assert!((linear_from_srgb(0.04045) - linear_from_srgb(0.040_450_01)).abs() < 1e-6);
    }
}
