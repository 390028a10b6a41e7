//! The material of a wall: two symmetric families of fibres in a neo-Hookean matrix, in the directions of a tube.
//!
//! Ψ = μ/2 (tr C − 3) − μ ln J + λ/2 ln² J + Σ k₁/(2 k₂) (exp(k₂ E²) − 1), one term for each of the two families while E > 0, with
//! E = κ (tr C − 3) + (1 − 3 κ) (a·C a − 1) (Holzapfel, Gasser & Ogden 2000; Gasser, Ogden & Holzapfel 2006 for κ), or the same E of C̄ = J^(−2/3) C.
//! Both families lie in the plane of θ and z, at +β and −β to θ. Where F has the axes r, θ, z, so have both stretches and stresses.

use super::newton::root;

/// What the strain of the fibres is taken of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Invariants {
    /// C.
    Full,
    /// C̄ = J^(−2/3) C.
    Isochoric,
}

/// The constants of a wall's material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Shear modulus of the matrix \[Pa\].
    pub mu: f64,
    /// Lamé's first constant of the matrix \[Pa\].
    pub lambda: f64,
    /// k₁ \[Pa\].
    pub fibre_stiffness: f64,
    /// k₂.
    pub fibre_exponent: f64,
    /// κ in 0..1/3.
    pub fibre_dispersion: f64,
    /// β \[rad\], from the direction around to that along the axis.
    pub fibre_angle: f64,
    /// Of which tensor.
    pub invariants: Invariants,
}

impl Wall {
    /// λ such that the matrix has this Poisson's ratio.
    pub fn with_poisson(self, poisson: f64) -> Self {
        Self {
            lambda: 2.0 * self.mu * poisson / (1.0 - 2.0 * poisson),
            ..self
        }
    }

    /// Young's modulus of the matrix \[Pa\].
    pub fn young(&self) -> f64 {
        self.mu * (3.0 * self.lambda + 2.0 * self.mu) / (self.lambda + self.mu)
    }

    /// Poisson's ratio of the matrix.
    pub fn poisson(&self) -> f64 {
        self.lambda / (2.0 * (self.lambda + self.mu))
    }

    /// How much of r, θ, z the square of a fibre's stretch takes.
    fn of_fibre(&self) -> [f64; 3] {
        let (sine, cosine) = libm::sincos(self.fibre_angle);
        [0.0, cosine * cosine, sine * sine]
    }

    /// The weight of each squared stretch in E + 1: κ, and 1 − 3 κ of the fibre's.
    fn weights(&self) -> [f64; 3] {
        let kappa = self.fibre_dispersion;
        self.of_fibre().map(|of| kappa + (1.0 - 3.0 * kappa) * of)
    }

    /// J^(−2/3), or 1 for the full invariants.
    fn scale(&self, stretches: &[f64; 3]) -> f64 {
        match self.invariants {
            Invariants::Full => 1.0,
            Invariants::Isochoric => {
                let volume: f64 = stretches.iter().product();
                libm::pow(volume, -2.0 / 3.0)
            }
        }
    }

    /// E of each of the two families, at stretches along r, θ, z.
    pub fn fibre_strain(&self, stretches: [f64; 3]) -> f64 {
        let weights = self.weights();
        let sum: f64 = (0..3)
            .map(|i| weights[i] * stretches[i] * stretches[i])
            .sum();
        self.scale(&stretches) * sum - 1.0
    }

    /// Ψ \[J/m³\] at stretches along r, θ, z.
    pub fn energy(&self, stretches: [f64; 3]) -> f64 {
        let [r, t, z] = stretches;
        let (trace, log) = (r * r + t * t + z * z, libm::log(r * t * z));
        let matrix = self.mu * (0.5 * (trace - 3.0) - log) + 0.5 * self.lambda * log * log;
        let strain = self.fibre_strain(stretches).max(0.0);
        let (k1, k2) = (self.fibre_stiffness, self.fibre_exponent);
        matrix + k1 / k2 * libm::expm1(k2 * strain * strain)
    }

    /// First Piola–Kirchhoff stresses along r, θ, z \[Pa\]: the derivatives of the energy by the stretches.
    pub fn nominal(&self, stretches: [f64; 3]) -> [f64; 3] {
        let log = libm::log(stretches.iter().product());
        let strain = self.fibre_strain(stretches);
        let taut = strain.max(0.0);
        // dΨ/dE of both families.
        let pull = 2.0 * self.fibre_stiffness * taut * libm::exp(self.fibre_exponent * taut * taut);
        let (scale, weights) = (self.scale(&stretches), self.weights());
        let mut stress = [0.0; 3];
        for (i, stretch) in stretches.into_iter().enumerate() {
            let mut by_stretch = 2.0 * scale * weights[i] * stretch;
            if self.invariants == Invariants::Isochoric {
                // The derivative of J^(−2/3) is −2/3 of itself over the stretch.
                by_stretch -= 2.0 / 3.0 * (strain + 1.0) / stretch;
            }
            stress[i] = self.mu * (stretch - 1.0 / stretch)
                + self.lambda * log / stretch
                + pull * by_stretch;
        }
        stress
    }

    /// Cauchy stresses along r, θ, z \[Pa\].
    pub fn cauchy(&self, stretches: [f64; 3]) -> [f64; 3] {
        let volume: f64 = stretches.iter().product();
        let nominal = self.nominal(stretches);
        [0, 1, 2].map(|i| stretches[i] * nominal[i] / volume)
    }

    /// The stretch along r at which the Cauchy stress along it is `stress` \[Pa\], others given; not a number where there is none
    /// between a tenth and ten times that of the same volume.
    pub fn radial_stretch(&self, around: f64, along: f64, stress: f64) -> f64 {
        let same = 1.0 / (around * along);
        let wanted = stress * around * along;
        let excess = |radial: f64| self.nominal([radial, around, along])[0] - wanted;
        root(&excess, [0.1 * same, 10.0 * same])
    }

    /// The stretches \[r, θ, z\] under a stretch along `axis` alone, the two others free of stress.
    pub fn uniaxial(&self, axis: usize, stretch: f64) -> [f64; 3] {
        assert!(axis > 0, "fibres lie across r");
        let at = |across: f64| {
            let mut stretches = [1.0, across, across];
            stretches[axis] = stretch;
            stretches[0] = self.radial_stretch(stretches[1], stretches[2], 0.0);
            stretches
        };
        let excess = |across: f64| self.nominal(at(across))[3 - axis];
        let same = 1.0 / stretch.sqrt();
        at(root(&excess, [0.3 * same, 2.0 * same]))
    }

    /// The stretches \[r, θ, z\] under stretches around and along, free of stress through the wall.
    pub fn biaxial(&self, around: f64, along: f64) -> [f64; 3] {
        [self.radial_stretch(around, along, 0.0), around, along]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walls() -> Vec<Wall> {
        let mut walls = Vec::new();
        for invariants in [Invariants::Full, Invariants::Isochoric] {
            for fibre_dispersion in [0.0, 0.1, 1.0 / 3.0] {
                walls.push(Wall {
                    mu: 1.3,
                    lambda: 9.0,
                    fibre_stiffness: 0.9,
                    fibre_exponent: 0.8,
                    fibre_dispersion,
                    fibre_angle: 0.6,
                    invariants,
                });
            }
        }
        walls
    }

    const STRETCHES: [[f64; 3]; 4] = [
        [0.7, 1.2, 1.4],
        [1.1, 0.8, 0.9],
        [0.6, 1.5, 1.0],
        [1.0, 1.0, 1.3],
    ];

    /// Central differences of fourth order, off by h⁴/30 of the fifth derivative of the energy, here up to 1e5, and by rounding, 1e-16 of
    /// the energy over h.
    #[test]
    fn stresses_are_derivatives_of_the_energy() {
        let h = 3e-4;
        for wall in walls() {
            for at in STRETCHES {
                for (i, stress) in wall.nominal(at).into_iter().enumerate() {
                    let energy = |step: f64| {
                        let mut moved = at;
                        moved[i] += step * h;
                        wall.energy(moved)
                    };
                    let difference = (8.0 * (energy(1.0) - energy(-1.0)) - energy(2.0)
                        + energy(-2.0))
                        / (12.0 * h);
                    let error = difference - stress;
                    assert!(error.abs() < 1e-9, "{wall:?} {at:?} {i}: {error}");
                }
            }
        }
    }

    /// Slack fibres add nothing: the stress is that of the matrix, μ (ℓ − 1/ℓ) + λ ln(J)/ℓ. Without a direction no fibres of C̄ are slack.
    #[test]
    fn slack_fibres_add_nothing() {
        let at = [1.1, 0.8, 0.9];
        let directed = |wall: &Wall| wall.fibre_dispersion < 0.3;
        for wall in walls().into_iter().filter(directed) {
            assert!(wall.fibre_strain(at) < 0.0, "{wall:?}");
            let log = libm::log(1.1 * 0.8 * 0.9);
            for (stress, stretch) in wall.nominal(at).into_iter().zip(at) {
                let matrix = wall.mu * (stretch - 1.0 / stretch) + wall.lambda * log / stretch;
                assert!((stress - matrix).abs() < 1e-14);
            }
        }
    }

    /// A change of volume alone stretches no fibre of C̄, so its stress is that of the matrix.
    #[test]
    fn isochoric_fibres_do_not_resist_a_change_of_volume() {
        for wall in walls() {
            let strain = wall.fibre_strain([1.2; 3]);
            let expected = match wall.invariants {
                Invariants::Full => 0.44,
                Invariants::Isochoric => 0.0,
            };
            assert!((strain - expected).abs() < 1e-14, "{wall:?}");
        }
    }

    #[test]
    fn sides_that_are_free_have_no_stress() {
        for wall in walls() {
            for (axis, stretch) in [(1, 1.3), (2, 1.3), (1, 0.8), (2, 1.6)] {
                let at = wall.uniaxial(axis, stretch);
                let stress = wall.nominal(at);
                assert_eq!(at[axis], stretch);
                let free = [stress[0], stress[3 - axis]];
                assert!(
                    free.iter().all(|s| s.abs() < 1e-12),
                    "{wall:?} {at:?} {stress:?}"
                );
                // Pulled along the axis alone it resists, and pushed it pushes back.
                assert!(stress[axis] * (stretch - 1.0) > 0.0);
            }
            assert!(wall.nominal(wall.biaxial(1.2, 1.3))[0].abs() < 1e-12);
        }
    }
}
