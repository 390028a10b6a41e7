//! Internal variables that flow between two steps.

use crate::elements::{Constraint, Plasticity, Springs};
use crate::executor::Serial;
use crate::flow::flow;
use crate::method::Method;
use crate::model::TissueModel;
use crate::state::{Control, State};
use nalgebra::Vector3;
use std::sync::Arc;

/// p' = p + h (v + ½h a) with a = −k/m (p − rest) of the rest length after the flow. The spring is stretched by 0.5 m and,
/// after a flow that has ended, by 1.5 (1 − 1/1.1) = 0.14 m: an a from before is 3.7 times too large.
#[test]
fn a_step_after_the_flow_pulls_with_the_new_rest_length() {
    let spring = Constraint {
        nodes: [0, 1],
        rest: 1.0,
        stiffness: 8.0,
        damping: 0.0,
    };
    let set = Springs::new([spring]).with_plasticity(Plasticity {
        yield_strain: 0.1,
        creep_rate: 50.0,
        max_strain: 1.0,
        hardening: 0.0,
        max_stiffening: 1.0,
    });
    let model = TissueModel::assemble(
        vec![Vector3::zeros(), Vector3::x()],
        vec![1.0, 2.0],
        &[true, false],
        vec![],
        1.0,
        vec![Arc::new(set)],
        0.0,
    );
    let mut state = State::at_rest(&model);
    state.positions[1].x = 1.5;
    let (control, h) = (Control::default(), 1e-3);
    let mut solver = Method::VelocityVerlet.solver(&model).unwrap();
    let mut step = |state: &mut State| {
        solver
            .step(&model, state, &control, &[], h, &Serial)
            .unwrap();
    };
    step(&mut state);
    flow(&model, &mut state, 10.0);
    let (p, v, rest) = (
        state.positions[1].x,
        state.velocities[1].x,
        state.internal[0],
    );
    step(&mut state);
    let expected = p + h * (v - 0.5 * h * 4.0 * (p - rest));
    // Three roundings of a position.
    assert!((state.positions[1].x - expected).abs() < 4.0 * f64::EPSILON * p);
}
