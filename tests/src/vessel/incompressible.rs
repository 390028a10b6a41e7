//! A closed tube of incompressible layers: the volume gives all radii, and the balance of forces is an integral.
//!
//! p = ∫ (σ_θ − σ_r)/r dr and F = 2π ∫ (σ_z − σ_r) r dr + π (p r_i² − ∫ (σ_θ − σ_r) r dr), as Holzapfel, Gasser & Ogden (2000) have them, by the
//! quadrature of Gauss with three points on parts of each layer. λ of the layers is not used.

use super::layers::Layer;
use std::f64::consts::{PI, TAU};

/// Parts of a layer: with three points the error falls with the sixth power.
const PARTS: usize = 16;

/// Places and weights of Gauss's rule on 0..1.
const GAUSS: [[f64; 2]; 3] = [
    [0.112_701_665_379_258_31, 5.0 / 18.0],
    [0.5, 8.0 / 18.0],
    [0.887_298_334_620_741_7, 5.0 / 18.0],
];

/// Pressure \[Pa\] and axial force in the wall \[N\] at an inner radius \[m\] and an axial stretch.
pub fn pressure_and_force(layers: &[Layer], inner_radius: f64, along: f64) -> [f64; 2] {
    let mut inner = inner_radius * inner_radius;
    let (mut pressure, mut axial, mut around_r) = (0.0, 0.0, 0.0);
    for layer in layers {
        let outer = layer.squared_radius(layer.outer_radius(), inner, TAU, along);
        let (first, last) = (inner.sqrt(), outer.sqrt());
        let width = (last - first) / PARTS as f64;
        for (part, [place, weight]) in
            (0..PARTS).flat_map(|part| GAUSS.map(move |gauss| (part, gauss)))
        {
            let radius = first + width * (part as f64 + place);
            // The volume inside the point, turned back.
            let area = (radius * radius - inner) * TAU * layer.prestretch * along / layer.sector;
            let natural = (layer.inner_radius * layer.inner_radius + area).sqrt();
            let [around, along] = layer.stretches(natural, radius, TAU, along);
            let stress = layer.wall.cauchy([1.0 / (around * along), around, along]);
            pressure += weight * width * (stress[1] - stress[0]) / radius;
            axial += weight * width * (stress[2] - stress[0]) * radius;
            around_r += weight * width * (stress[1] - stress[0]) * radius;
        }
        inner = outer;
    }
    let force = TAU * axial + PI * (pressure * inner_radius * inner_radius - around_r);
    [pressure, force]
}
