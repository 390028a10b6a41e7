//! A tube, closed or slit along its axis: its wall at a pressure inside, nothing outside, and an axial stretch or force.

use super::layers::Layer;
use super::newton::{root, solve};
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

    /// A stress of the tube's matrix \[Pa\], to which others are compared.
    fn scale(&self) -> f64 {
        self.layers[0].wall.mu
    }

    /// The wall over an angle \[rad\] at a pressure \[Pa\] and an axial stretch: with the smallest inner radius, from a quarter to four times that
    /// at which the inner layer is as long around as it was, at which no stress is left outside.
    ///
    /// # Panics
    /// If there is none.
    fn balanced(&self, pressure: f64, angle: f64, along: f64) -> Profile {
        let wall = |radius: f64| {
            let inside = Inside {
                radius,
                pressure,
                angle,
                along,
            };
            profile(&self.layers, inside, self.steps)
        };
        // Where no radial stretch bears the stress, the wall is too wide: what lies outside is pulled more than it can bear.
        let excess = |radius: f64| match wall(radius).outer_stress {
            stress if stress.is_nan() => f64::INFINITY,
            stress => stress,
        };
        let first = &self.layers[0];
        let middle = first.sector / angle * (first.inner_radius + 0.5 * first.thickness);
        let places = (0..57).map(|k| 0.25 * middle * libm::pow(1.05, f64::from(k)));
        let signs: Vec<(f64, bool)> = places.map(|place| (place, excess(place) > 0.0)).collect();
        let change = signs.windows(2).find(|pair| !pair[0].1 && pair[1].1);
        let Some(&[(low, _), (high, _)]) = change else {
            panic!("no solution at {pressure} Pa and a stretch of {along} over {angle} rad");
        };
        let found = wall(root(&excess, [low, high]));
        let left = found.outer_stress;
        assert!(left.abs() < 1e-8 * self.scale(), "{left} Pa are left");
        found
    }

    /// Closed, at a pressure \[Pa\] and an axial stretch.
    ///
    /// # Panics
    /// If there is no solution.
    pub fn at_stretch(&self, pressure: f64, along: f64) -> Profile {
        self.balanced(pressure, TAU, along)
    }

    /// Closed, at a pressure \[Pa\] and an axial force in the wall \[N\]: 0 for open ends that nothing holds.
    ///
    /// # Panics
    /// If there is no solution near.
    pub fn at_force(&self, pressure: f64, force: f64) -> Profile {
        let Layer {
            inner_radius,
            thickness,
            prestretch,
            ..
        } = self.layers[0];
        let scale = self.scale() * inner_radius * thickness;
        let excess = |[along]: [f64; 1]| [(self.at_stretch(pressure, along).force - force) / scale];
        let [along] = solve(&excess, [1.0 / prestretch], TOLERANCE);
        self.at_stretch(pressure, along)
    }

    /// Slit along its whole length: angle and axial stretch are such that, without pressure, the section is free of moment and of axial force.
    /// The force around then is zero too, as ∫ σ_θ dr is the difference of r σ_r. Far from the ends of the tube and from the edges of
    /// the slit, where stress is not that of pure bending.
    ///
    /// # Panics
    /// If there is no solution near.
    pub fn slit(&self) -> Profile {
        let first = &self.layers[0];
        let thickness: f64 = self.layers.iter().map(|layer| layer.thickness).sum();
        let scale = self.scale() * thickness;
        let excess = |[angle, along]: [f64; 2]| {
            let wall = self.balanced(0.0, angle, along);
            [
                wall.moment / (scale * thickness),
                wall.force / (scale * first.inner_radius),
            ]
        };
        let count = self.layers.len() as f64;
        let mean = |of: fn(&Layer) -> f64| self.layers.iter().map(of).sum::<f64>() / count;
        let start = [
            mean(|layer| layer.sector),
            1.0 / mean(|layer| layer.prestretch),
        ];
        let [angle, along] = solve(&excess, start, TOLERANCE);
        self.balanced(0.0, angle, along)
    }
}
