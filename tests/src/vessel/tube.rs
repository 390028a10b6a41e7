//! A closed tube: its wall at a pressure inside, nothing outside, and an axial stretch or force.

use super::layers::Layer;
use super::newton::solve;
use super::radial::{Inside, Profile, STEPS, profile};
use std::f64::consts::TAU;

/// Relative change of the unknowns at which Newton's method ends: as it squares its error, the next one would be rounding.
const TOLERANCE: f64 = 1e-9;

/// A tube of layers, each joined to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Tube {
    /// From the inside.
    pub layers: Vec<Layer>,
    /// Steps through each.
    pub steps: usize,
}

impl Tube {
    /// Of these layers.
    pub fn new(layers: &[Layer]) -> Self {
        Self {
            layers: layers.to_vec(),
            steps: STEPS,
        }
    }

    fn wall(&self, pressure: f64, radius: f64, along: f64) -> Profile {
        let inside = Inside {
            radius,
            pressure,
            angle: TAU,
            along,
        };
        profile(&self.layers, inside, self.steps)
    }

    /// Inner radius \[m\] of a tube in which the middle of the inner layer is as long as it was.
    fn guess(&self) -> f64 {
        let Layer {
            inner_radius,
            thickness,
            sector,
            ..
        } = self.layers[0];
        let middle = sector / TAU * (inner_radius + 0.5 * thickness);
        (middle - 0.5 * thickness).max(0.2 * middle)
    }

    /// A stress that this tube has of its matrix \[Pa\], to which others are compared.
    fn scale(&self) -> f64 {
        self.layers[0].wall.mu
    }

    /// At a pressure \[Pa\] and an axial stretch.
    ///
    /// # Panics
    /// If there is no solution near.
    pub fn at_stretch(&self, pressure: f64, along: f64) -> Profile {
        let excess =
            |[radius]: [f64; 1]| [self.wall(pressure, radius, along).outer_stress / self.scale()];
        let [radius] = solve(&excess, [self.guess()], TOLERANCE);
        self.wall(pressure, radius, along)
    }

    /// At a pressure \[Pa\] and an axial force in the wall \[N\]: 0 for open ends that nothing holds.
    ///
    /// # Panics
    /// If there is no solution near.
    pub fn at_force(&self, pressure: f64, force: f64) -> Profile {
        let area = self.guess() * self.guess();
        let excess = |[radius, along]: [f64; 2]| {
            let wall = self.wall(pressure, radius, along);
            let scale = self.scale();
            [
                wall.outer_stress / scale,
                (wall.force - force) / (scale * area),
            ]
        };
        let along = 1.0 / self.layers[0].prestretch;
        let [radius, along] = solve(&excess, [self.guess(), along], TOLERANCE);
        self.wall(pressure, radius, along)
    }
}
