//! A ring that is slit along its axis: it opens to a sector without moment.

use super::layers::Layer;
use super::newton::solve;
use super::radial::{Inside, Profile, STEPS, profile};

/// The wall of a tube of these layers after a slit along its whole length: inner radius, angle and axial stretch are such that both sides are
/// free of pressure and the section of moment and of axial force. The force around then is zero too, as ∫ σ_θ dr is the difference of r σ_r.
/// Far from the ends of the tube and from the edges of the slit, where stress is not that of pure bending.
///
/// # Panics
/// If there is no solution near.
pub fn slit(layers: &[Layer]) -> Profile {
    let wall = |[radius, angle, along]: [f64; 3]| {
        let inside = Inside {
            radius,
            pressure: 0.0,
            angle,
            along,
        };
        profile(layers, inside, STEPS)
    };
    let first = &layers[0];
    let thickness: f64 = layers.iter().map(|layer| layer.thickness).sum();
    let scale = first.wall.mu;
    let excess = |unknowns: [f64; 3]| {
        let wall = wall(unknowns);
        [
            wall.outer_stress / scale,
            wall.moment / (scale * thickness * thickness),
            wall.force / (scale * thickness * first.inner_radius),
        ]
    };
    let start = [first.inner_radius, first.sector, 1.0 / first.prestretch];
    wall(solve(&excess, start, 1e-9))
}
