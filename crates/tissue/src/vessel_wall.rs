//! The residual state of a vessel's wall: how its layers, each free of stress when it is cut out and open, are stretched where they lie.
//!
//! A layer in its natural state is a sector of a tube with the opening angle α missing. Closing it, joining it to the others, stretching the
//! tube along its axis by λ_z and a pressure p inside bring it to the place that is given. With natural radius R, radius r, k = 2π/(2π − α) its
//! stretches are λ_r = dr/dR, λ_θ = k r/R, λ_z (Chuong & Fung 1986; Holzapfel, Gasser & Ogden 2000, section 4, there for an incompressible
//! wall). Equilibrium along the radius is dσ_rr/dr = (σ_θθ − σ_rr)/r, with σ_rr = −p inside, 0 outside and no jump between layers.
//!
//! Place, opening angles, λ_z and p do not determine how much of p each layer bears: layers that grew on one another are taken to
//! have one λ_θ where they meet. Of one layer nothing is free.
//!
//! What is here: this problem of one dimension, for every law, at its own compressibility. What is not: meshes, and the equilibrium of
//! their elements, which is off by as much as they are coarse.

use crate::law::{Constants, Law, with_law};
use crate::material::ContinuumConstants;
use microsim_mesh::FAMILIES;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Steps of the Runge–Kutta method of fourth order through a layer. Halving them changes stretches of arteries by 1e-9.
const STEPS: usize = 128;

/// λ_θ at the inside is looked for in this range.
const STRETCHES: [f64; 2] = [0.2, 5.0];

/// And λ_r in this one: of a wall that is stretched five times around and along 1/25 is left.
const RADIAL_STRETCHES: [f64; 2] = [0.01, 50.0];

/// A layer of a wall in its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallLayer {
    /// Inner and outer radius \[m\].
    pub radii: [f64; 2],
    /// What it is made of.
    pub constants: ContinuumConstants,
    /// Fibre directions in the natural state by the axes r, θ, z.
    pub directions: [Vector3<f64>; FAMILIES],
    /// Opening angle α \[rad\]: what is missing of a circle, below 2π; negative where the layer is too wide.
    pub opening_angle: f64,
}

/// A wall in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct VesselWall {
    /// From the inside, each where the last one ends.
    pub layers: Vec<WallLayer>,
    /// λ_z.
    pub axial_stretch: f64,
    /// p inside less what is outside \[Pa\].
    pub pressure: f64,
}

/// Why a wall has no residual state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WallError {
    /// No radial stretch between 0.01 and 50 brings this stress about.
    NoStretch {
        /// The layer.
        layer: usize,
        /// Radius \[m\].
        radius: f64,
        /// σ_rr there \[Pa\].
        stress: f64,
    },
    /// No natural state bears the pressure.
    NoEquilibrium,
}

impl std::fmt::Display for WallError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoStretch {
                layer,
                radius,
                stress,
            } => write!(
                f,
                "layer {layer} of the wall bears no radial stress of {:.3} kPa, as it would have at a radius of {:.4} mm: its radial stretch would be below {} or above {}",
                1e-3 * stress,
                1e3 * radius,
                RADIAL_STRETCHES[0],
                RADIAL_STRETCHES[1]
            ),
            Self::NoEquilibrium => write!(
                f,
                "no natural state of the wall is in equilibrium with this pressure, axial stretch and opening angle: the circumference would be \
                 stretched by less than {} or more than {}",
                STRETCHES[0], STRETCHES[1]
            ),
        }
    }
}

impl std::error::Error for WallError {}

/// The stretches of a wall in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct WallStretches {
    layers: Vec<LayerStretches>,
    axial_stretch: f64,
}

#[derive(Clone, Debug, PartialEq)]
struct LayerStretches {
    radii: [f64; 2],
    /// λ_r and λ_θ at the ends of the steps.
    at: Vec<[f64; 2]>,
}

impl VesselWall {
    /// The stretches that are in equilibrium.
    pub fn stretches(&self) -> Result<WallStretches, WallError> {
        // The stress at the outside grows with λ_θ at the inside. A trial that has no solution ends in a layer that is crushed, where
        // those inside of it bear too little, or torn apart, where they bear too much.
        let outside = |inner: f64| match self.integrate(inner, None) {
            Ok(stress) => stress,
            Err(WallError::NoStretch { stress, .. }) if stress < 0.0 => f64::NEG_INFINITY,
            Err(_) => f64::INFINITY,
        };
        let [mut low, mut high] = STRETCHES;
        if !(outside(low) < 0.0 && outside(high) > 0.0) {
            return Err(WallError::NoEquilibrium);
        }
        while high - low > 4.0 * f64::EPSILON * high {
            let middle = 0.5 * (low + high);
            match outside(middle) > 0.0 {
                true => high = middle,
                false => low = middle,
            }
        }
        let mut layers = Vec::with_capacity(self.layers.len());
        self.integrate(0.5 * (low + high), Some(&mut layers))?;
        Ok(WallStretches {
            layers,
            axial_stretch: self.axial_stretch,
        })
    }

    /// From the inside outwards: σ_rr at the outside \[Pa\] with λ_θ at the inside, and the stretches of each layer, where they are wanted.
    fn integrate(
        &self,
        inner: f64,
        mut found: Option<&mut Vec<LayerStretches>>,
    ) -> Result<f64, WallError> {
        let (mut stress, mut around) = (-self.pressure, inner);
        for (index, layer) in self.layers.iter().enumerate() {
            let [r0, r1] = layer.radii;
            let closing = TAU / (TAU - layer.opening_angle);
            let h = (r1 - r0) / STEPS as f64;
            let mut natural = closing * r0 / around;
            let mut radial = 1.0;
            let mut at = Vec::with_capacity(STEPS + 1);
            // dR/dr = 1/λ_r and dσ_rr/dr = (σ_θθ − σ_rr)/r.
            let mut rates = |r: f64, natural: f64, stress: f64| -> Result<_, WallError> {
                let around = closing * r / natural;
                let none = WallError::NoStretch {
                    layer: index,
                    radius: r,
                    stress,
                };
                radial = self
                    .radial_stretch(layer, around, stress, radial)
                    .ok_or(none)?;
                let hoop = self.hoop_stress(layer, [radial, around]);
                Ok(([1.0 / radial, (hoop - stress) / r], [radial, around]))
            };
            for step in 0..STEPS {
                let r = r0 + step as f64 * h;
                let (k1, stretches) = rates(r, natural, stress)?;
                at.push(stretches);
                let (k2, _) = rates(
                    r + 0.5 * h,
                    natural + 0.5 * h * k1[0],
                    stress + 0.5 * h * k1[1],
                )?;
                let (k3, _) = rates(
                    r + 0.5 * h,
                    natural + 0.5 * h * k2[0],
                    stress + 0.5 * h * k2[1],
                )?;
                let (k4, _) = rates(r + h, natural + h * k3[0], stress + h * k3[1])?;
                let mean = |i: usize| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0;
                natural += h * mean(0);
                stress += h * mean(1);
            }
            let (_, stretches) = rates(r1, natural, stress)?;
            at.push(stretches);
            around = stretches[1];
            if let Some(found) = &mut found {
                let radii = layer.radii;
                found.push(LayerStretches { radii, at });
            }
        }
        Ok(stress)
    }

    /// λ_r at which σ_rr is `stress` \[Pa\], from a guess: Newton's method within a bracket that bisection narrows.
    fn radial_stretch(
        &self,
        layer: &WallLayer,
        around: f64,
        stress: f64,
        guess: f64,
    ) -> Option<f64> {
        // P_rr = σ_rr λ_θ λ_z.
        let wanted = stress * around * self.axial_stretch;
        let [mut low, mut high] = RADIAL_STRETCHES;
        let mut radial = guess.clamp(low, high);
        for _ in 0..100 {
            let (force, slope) = self.radial_force(layer, [radial, around]);
            match force > wanted {
                true => high = radial,
                false => low = radial,
            }
            let next = radial - (force - wanted) / slope;
            let next = match next > low && next < high {
                true => next,
                false => 0.5 * (low + high),
            };
            if (next - radial).abs() <= 2.0 * f64::EPSILON * next {
                let [least, most] = RADIAL_STRETCHES;
                let inside = next > least * 1.001 && next < most * 0.999;
                return inside.then_some(next);
            }
            radial = next;
        }
        None
    }

    fn deformation(&self, [radial, around]: [f64; 2]) -> Matrix3<f64> {
        Matrix3::from_diagonal(&Vector3::new(radial, around, self.axial_stretch))
    }

    /// P_rr and ∂P_rr/∂λ_r \[Pa\].
    fn radial_force(&self, layer: &WallLayer, stretches: [f64; 2]) -> (f64, f64) {
        let (f, lame) = (self.deformation(stretches), layer.constants.lame());
        with_law!(&layer.constants.law, L, p => {
            let constants = L::constants(&lame, p).along(layer.directions);
            (L::stress(&f, &constants)[(0, 0)], L::tangent(&f, &constants)[(0, 0)])
        })
    }

    /// σ_θθ \[Pa\].
    fn hoop_stress(&self, layer: &WallLayer, stretches: [f64; 2]) -> f64 {
        let constants = &layer.constants;
        let f = self.deformation(stretches);
        let stress = constants
            .law
            .stress(&f, &constants.lame(), layer.directions);
        // σ = P Fᵀ/J.
        stress[(1, 1)] / (stretches[0] * self.axial_stretch)
    }
}

impl WallStretches {
    /// λ_r, λ_θ, λ_z at a radius \[m\], linear between steps; outside of the wall those of its surface, between layers those of the inner one.
    pub fn at(&self, radius: f64) -> Vector3<f64> {
        let within = |layer: &&LayerStretches| radius <= layer.radii[1];
        let last = self.layers.last();
        let Some(layer) = self.layers.iter().find(within).or(last) else {
            return Vector3::new(1.0, 1.0, self.axial_stretch);
        };
        let [r0, r1] = layer.radii;
        let place = ((radius - r0) / (r1 - r0)).clamp(0.0, 1.0) * STEPS as f64;
        let step = (place as usize).min(STEPS - 1);
        let part = place - step as f64;
        let [radial, around] =
            [0, 1].map(|i| layer.at[step][i] * (1.0 - part) + layer.at[step + 1][i] * part);
        Vector3::new(radial, around, self.axial_stretch)
    }
}

#[cfg(test)]
mod tests;
