//! The carotid artery of a rabbit with two layers, the example of Holzapfel, Gasser & Ogden (2000), J. Elasticity 61:1–48.
//!
//! Constants and thicknesses are those that the paper gives for it, as they are commonly cited: media c = 3.0 kPa, k₁ = 2.3632 kPa,
//! k₂ = 0.8393, 29°, 0.26 mm; adventitia c = 0.3 kPa, k₁ = 0.5620 kPa, k₂ = 0.7112, 62°, 0.13 mm; inner radius 0.71 mm without opening angle
//! and 1.43 mm with 160°. They were not compared with the printed paper. One check of the two radii is at hand: the middle of the wall has the
//! same length in both, 2π · 0.905 mm and 200/360 · 2π · 1.625 mm, within 0.3 %.
//!
//! The paper's curves (pressure and inner radius at axial stretches of 1.5, 1.7, 1.9; stresses through the wall at 13.33 kPa) are printed without numbers, so
//! none of them is compared. Its material is incompressible; here Poisson's ratio of the matrix is a parameter.

use super::layers::Layer;
use super::wall::{Invariants, Wall};

/// Mean pressure in the artery \[Pa\]: 100 mmHg.
pub const PRESSURE: f64 = 13.33e3;

/// Axial stretch in the body, of the three in the paper the middle one.
pub const STRETCH: f64 = 1.7;

/// Radius of the lumen \[m\] where the layers are whole rings.
pub const INNER_RADIUS: f64 = 0.71e-3;

/// Inner radius \[m\] of the sector that is left of the ring with [`OPENING`].
pub const OPENED_RADIUS: f64 = 1.43e-3;

/// The opening angle of both layers \[rad\].
pub const OPENING: f64 = 160.0 / 180.0 * std::f64::consts::PI;

/// Thicknesses of media and adventitia \[m\].
pub const THICKNESSES: [f64; 2] = [0.26e-3, 0.13e-3];

/// What the media is made of.
pub fn media(poisson: f64) -> Wall {
    Wall {
        mu: 3.0e3,
        lambda: 0.0,
        fibre_stiffness: 2.3632e3,
        fibre_exponent: 0.8393,
        fibre_dispersion: 0.0,
        fibre_angle: 29_f64.to_radians(),
        invariants: Invariants::Full,
    }
    .with_poisson(poisson)
}

/// What the adventitia is made of.
pub fn adventitia(poisson: f64) -> Wall {
    Wall {
        mu: 0.3e3,
        lambda: 0.0,
        fibre_stiffness: 0.5620e3,
        fibre_exponent: 0.7112,
        fibre_dispersion: 0.0,
        fibre_angle: 62_f64.to_radians(),
        invariants: Invariants::Full,
    }
    .with_poisson(poisson)
}

/// The two layers, whose natural states are sectors with this inner radius \[m\] and opening angle \[rad\].
pub fn layers(poisson: f64, inner_radius: f64, opening: f64) -> [Layer; 2] {
    let walls = [media(poisson), adventitia(poisson)];
    let inner = [inner_radius, inner_radius + THICKNESSES[0]];
    [0, 1].map(|i| Layer {
        sector: std::f64::consts::TAU - opening,
        ..Layer::closed(walls[i], inner[i], THICKNESSES[i])
    })
}
