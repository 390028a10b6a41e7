//! The layers of a tube in their natural states, in which they have no stress.

use super::wall::Wall;
use std::f64::consts::TAU;

/// A layer: in its natural state a sector of a ring, which is bent to a ring, joined and stretched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// What it is made of.
    pub wall: Wall,
    /// Inner radius of the sector \[m\].
    pub inner_radius: f64,
    /// Thickness of the sector \[m\].
    pub thickness: f64,
    /// Θ₀, the angle of the sector \[rad\]: 2π less the opening angle.
    pub sector: f64,
    /// Axial stretch of the layer where that of the tube is 1.
    pub prestretch: f64,
}

impl Layer {
    /// A layer that is a whole ring, without prestretch.
    pub fn closed(wall: Wall, inner_radius: f64, thickness: f64) -> Self {
        Self {
            wall,
            inner_radius,
            thickness,
            sector: TAU,
            prestretch: 1.0,
        }
    }

    /// Outer radius of the sector \[m\].
    pub fn outer_radius(&self) -> f64 {
        self.inner_radius + self.thickness
    }

    /// Stretches around and along of what was at a natural radius and is at `radius` \[m\], where the layer covers `angle` \[rad\] and the tube is
    /// stretched by `along`.
    pub fn stretches(&self, natural: f64, radius: f64, angle: f64, along: f64) -> [f64; 2] {
        let around = angle / self.sector * radius / natural;
        [around, self.prestretch * along]
    }

    /// The squared radius \[m²\] of what was at a natural radius, where the inner side lies at the squared radius `inner` \[m²\] and the volume
    /// is unchanged.
    pub fn squared_radius(&self, natural: f64, inner: f64, angle: f64, along: f64) -> f64 {
        let area = natural * natural - self.inner_radius * self.inner_radius;
        inner + self.sector / (angle * self.prestretch * along) * area
    }
}
