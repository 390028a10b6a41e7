//! Forces and energies that are not computed again where they are known: a step of statics begins where the last one ended, Newton's method
//! comes back to the start of a step, and a line search begins where the one before it has ended.

use crate::executor::Executor;
use crate::forces::Forces;
use crate::model::TissueModel;
use crate::state::{Control, State};
use nalgebra::Vector3;

/// [`Forces`] with what they were computed for last. The same bits, known or not.
#[derive(Clone, Debug)]
pub(super) struct KnownForces {
    forces: Forces,
    state: State,
    control: Control,
}

impl KnownForces {
    /// Working memory for one model.
    pub fn new(model: &TissueModel) -> Self {
        let mut state = State::at_rest(model);
        // Nothing is known: solvers refuse states that are not finite.
        state.positions.fill(Vector3::repeat(f64::NAN));
        Self {
            forces: Forces::new(model),
            state,
            control: Control::default(),
        }
    }

    /// The force on each node \[N\], as [`Forces::compute`].
    pub fn compute(
        &mut self,
        model: &TissueModel,
        state: &State,
        control: &Control,
        exec: &dyn Executor,
    ) -> &[Vector3<f64>] {
        let known = same_bits(&self.state.positions, &state.positions)
            && same_bits(&self.state.velocities, &state.velocities)
            && self.state.internal == state.internal
            && self.control == *control;
        if known {
            return self.forces.last();
        }
        self.state.positions.copy_from_slice(&state.positions);
        self.state.velocities.copy_from_slice(&state.velocities);
        self.state.internal.copy_from_slice(&state.internal);
        self.control.clone_from(control);
        self.forces.compute(model, state, control, exec)
    }

    /// The forces of the last [`compute`](Self::compute) \[N\].
    pub fn last(&self) -> &[Vector3<f64>] {
        self.forces.last()
    }
}

/// The elastic energy of a model with what it was computed for last. The same bits, known or not.
#[derive(Clone, Debug)]
pub(super) struct KnownEnergy {
    value: f64,
    state: State,
}

impl KnownEnergy {
    /// Working memory for one model. Nothing is known yet.
    pub fn new(model: &TissueModel) -> Self {
        let mut state = State::at_rest(model);
        state.positions.fill(Vector3::repeat(f64::NAN));
        Self { value: 0.0, state }
    }

    /// The energy of all elements \[J\], which velocities are no part of.
    pub fn compute(&mut self, model: &TissueModel, state: &State) -> f64 {
        let known = same_bits(&self.state.positions, &state.positions)
            && self.state.internal == state.internal;
        if !known {
            self.state.positions.copy_from_slice(&state.positions);
            self.state.internal.copy_from_slice(&state.internal);
            let sets = model.sets().iter().enumerate();
            self.value = sets.fold(0.0, |sum, (set, elements)| {
                sum + elements.energy(&state.configuration(model, set))
            });
        }
        self.value
    }
}

/// Not `==`, which takes −0 for 0.
fn same_bits(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> bool {
    let bits = |v: &Vector3<f64>| [v.x, v.y, v.z].map(f64::to_bits);
    a.iter().zip(b).all(|(a, b)| bits(a) == bits(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::executor::Serial;
    use crate::testing::{build, soft_block};

    /// Positions, velocities and loads changed one by one, and back: always what is computed again.
    #[test]
    fn nothing_old_is_taken_for_new() {
        let model = build(&soft_block([2; 3]), |p| p.x < -0.9e-3);
        let rest = State::at_rest(&model);
        let mut moved = rest.clone();
        moved.positions[5].x += 1e-4;
        let mut fast = rest.clone();
        fast.velocities[5].x += 1e-2;
        let mut control = Control::default();
        let mut known = KnownForces::new(&model);
        for gravity in [0.0, -9.81, 0.0] {
            control.gravity.z = gravity;
            for state in [&rest, &rest, &moved, &fast, &moved, &rest] {
                let expected = Forces::new(&model)
                    .compute(&model, state, &control, &Serial)
                    .to_vec();
                assert_eq!(known.compute(&model, state, &control, &Serial), expected);
                assert_eq!(known.last(), expected);
            }
        }
        control.forces.push((3, Vector3::x()));
        let expected = Forces::new(&model)
            .compute(&model, &rest, &control, &Serial)
            .to_vec();
        assert_eq!(known.compute(&model, &rest, &control, &Serial), expected);
    }

    /// Positions changed and back, and velocities: always what is computed again.
    #[test]
    fn no_old_energy_is_taken_for_new() {
        let model = build(&soft_block([2; 3]), |p| p.x < -0.9e-3);
        let rest = State::at_rest(&model);
        let mut moved = rest.clone();
        moved.positions[5].x += 1e-4;
        let mut fast = moved.clone();
        fast.velocities[5].x += 1e-2;
        let mut known = KnownEnergy::new(&model);
        for state in [&rest, &rest, &moved, &fast, &moved, &rest] {
            let expected = KnownEnergy::new(&model).compute(&model, state);
            assert_eq!(known.compute(&model, state), expected);
        }
        let [at_rest, in_motion] = [&rest, &moved].map(|state| known.compute(&model, state));
        assert!(at_rest < in_motion);
    }
}
