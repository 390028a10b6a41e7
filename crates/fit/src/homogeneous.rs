//! Homogeneous states of a specimen: given stretches along some axes, no stress along the others.
//!
//! The deformation gradient is diagonal: the specimen is held without shear, as between grips, or its fibres lie symmetrically to its axes.
//! What is not here: where the stresses come from.

use nalgebra::{Matrix3, Vector3};

/// Most iterations of Newton's method.
const ITERATIONS: usize = 50;
/// Stress along a free axis that counts as none, relative to the sum of the stresses along all axes and the modulus: rounding of the laws at
/// ν = 0.4999, whose bulk modulus is 1700 times Young's, stays below it.
const TOLERANCE: f64 = 1e-11;
/// Difference of logarithmic stretches for derivatives, about the root of the rounding unit: a Newton iteration with them gains six digits.
const DIFFERENCE: f64 = 1e-7;
/// Largest change of a logarithmic stretch in an iteration.
const LONGEST: f64 = 0.2;
/// Steps from rest to states that Newton's method does not reach at once.
const STEPS: usize = 16;

/// A homogeneous state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HomogeneousState {
    /// Along axes 1, 2 and 3.
    pub stretch: Vector3<f64>,
    /// First Piola–Kirchhoff stress along them \[Pa\].
    pub piola: Vector3<f64>,
}

impl HomogeneousState {
    /// Cauchy stress along the axes \[Pa\]: σ_i = P_i λ_i/J.
    pub fn cauchy(&self) -> Vector3<f64> {
        self.piola.component_mul(&self.stretch) / self.stretch.product()
    }
}

/// The state with these stretches along axes 1 and 2, free of stress along 3 and where none is given; `None` if there is none that Newton's
/// method finds. `stress` gives the first Piola–Kirchhoff stress \[Pa\] at a deformation gradient; `modulus` \[Pa\] is of its size.
pub fn homogeneous_state(
    stress: &dyn Fn(&Matrix3<f64>) -> Matrix3<f64>,
    stretch: [Option<f64>; 2],
    modulus: f64,
) -> Option<HomogeneousState> {
    let given = stretch.map(|stretch| stretch.map(libm::log));
    let problem = Problem {
        stress,
        modulus,
        free: [given[0].is_none(), given[1].is_none(), true],
    };
    // As if the volume stayed.
    let volume: f64 = given.iter().flatten().sum();
    let free = problem.free.iter().filter(|free| **free).count() as f64;
    let place = |fraction: f64, others: Vector3<f64>| {
        let along = |axis: usize| given[axis].map_or(others[axis], |given| fraction * given);
        Vector3::new(along(0), along(1), others[2])
    };
    let start = place(1.0, Vector3::repeat(-volume / free));
    problem.solve(start).or_else(|| {
        let (mut state, mut others) = (None, Vector3::zeros());
        for step in 1..=STEPS {
            let found = problem.solve(place(step as f64 / STEPS as f64, others))?;
            others = found.stretch.map(libm::log);
            state = Some(found);
        }
        state
    })
}

struct Problem<'a> {
    stress: &'a dyn Fn(&Matrix3<f64>) -> Matrix3<f64>,
    modulus: f64,
    free: [bool; 3],
}

impl Problem<'_> {
    /// The state with these logarithmic stretches.
    fn state(&self, logarithms: &Vector3<f64>) -> HomogeneousState {
        let stretch = logarithms.map(libm::exp);
        let piola = (self.stress)(&Matrix3::from_diagonal(&stretch)).diagonal();
        HomogeneousState { stretch, piola }
    }

    /// Kirchhoff stresses \[Pa\] along the free axes, which are the derivatives of the energy by logarithmic stretches, and 0 along the others.
    fn residual(&self, state: &HomogeneousState) -> Vector3<f64> {
        let kirchhoff = state.piola.component_mul(&state.stretch);
        let free = Vector3::from_fn(|axis, _| f64::from(u8::from(self.free[axis])));
        kirchhoff.component_mul(&free)
    }

    /// Newton's method with a line search, from these logarithmic stretches on; those that are not free stay.
    fn solve(&self, mut at: Vector3<f64>) -> Option<HomogeneousState> {
        let mut state = self.state(&at);
        let mut residual = self.residual(&state);
        for _ in 0..ITERATIONS {
            let kirchhoff = state.piola.component_mul(&state.stretch);
            let bound = TOLERANCE * (self.modulus + kirchhoff.abs().sum());
            if residual.norm() <= bound {
                return Some(state);
            }
            // Rows and columns of the axes that are not free are those of the unit matrix.
            let mut tangent = Matrix3::identity();
            for axis in (0..3).filter(|axis| self.free[*axis]) {
                let mut beside = at;
                beside[axis] += DIFFERENCE;
                let column = (self.residual(&self.state(&beside)) - residual) / DIFFERENCE;
                tangent.set_column(axis, &column);
            }
            let mut change = tangent.lu().solve(&-residual)?;
            let largest = change.amax();
            if !largest.is_finite() {
                return None;
            }
            change *= (LONGEST / largest).min(1.0);
            loop {
                let next = at + change;
                let reached = self.state(&next);
                let left = self.residual(&reached);
                if left.norm() < residual.norm() {
                    (at, state, residual) = (next, reached, left);
                    break;
                }
                change *= 0.5;
                if change.amax() < f64::EPSILON {
                    return None;
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_tissue::law::{Lame, LawName, MaterialLaw};

    /// Uniaxial neo-Hookean stretch in closed form: with Ψ = μ/2 (I₁ − 3 − 2 ln J) + λ/2 ln² J the lateral stretch a of a given λ₁ fulfils
    /// μ (a² − 1) + λ ln(λ₁ a²) = 0, so that λ₁ = exp(−μ (a² − 1)/λ)/a² for a chosen a, and P₁ = (μ (λ₁² − 1) + λ ln J)/λ₁.
    #[test]
    fn a_free_side_contracts_as_the_closed_form_states() {
        for nu in [0.3, 0.45, 0.49] {
            let lame = Lame::from_young_poisson(30e3, nu);
            let law = MaterialLaw::from(LawName::NeoHookean);
            let stress = |f: &Matrix3<f64>| law.stress(f, &lame, Default::default());
            for a in [0.8_f64, 0.95, 1.1] {
                let along = (-lame.mu * (a * a - 1.0) / lame.lambda).exp() / (a * a);
                let log_volume = (along * a * a).ln();
                let piola = (lame.mu * (along * along - 1.0) + lame.lambda * log_volume) / along;
                for axis in [0, 1] {
                    let mut given = [None; 2];
                    given[axis] = Some(along);
                    let state = homogeneous_state(&stress, given, 30e3).expect("a state");
                    // The free stress is below 1e-11 of the others, and the stiffness against it at least E (1 - nu) or so.
                    let scale = 30e3 + piola.abs();
                    assert!((state.stretch[2] - a).abs() < 1e-9, "{state:?}");
                    assert!((state.stretch[1 - axis] - a).abs() < 1e-9, "{state:?}");
                    assert!(
                        (state.piola[axis] - piola).abs() < 1e-9 * scale,
                        "{state:?}"
                    );
                    let cauchy = piola / (a * a);
                    assert!((state.cauchy()[axis] - cauchy).abs() < 1e-8 * scale);
                }
            }
        }
    }

    /// A material whose stress does not vanish anywhere has no such state.
    #[test]
    fn what_is_never_free_of_stress_has_no_state() {
        let stress = |_: &Matrix3<f64>| Matrix3::identity() * 1e3;
        assert_eq!(homogeneous_state(&stress, [Some(1.1), None], 1e3), None);
    }
}
