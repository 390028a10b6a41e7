//! Remedies after edits, where they touched, against those of the whole body and dense eigenvalues.

use super::*;
use crate::method::Method;
use crate::stability::{
    Part, WORKING_STRETCH, floor_nodes, gershgorin_bound, gershgorin_bound_at, mass_floor,
    stretched,
};
use nalgebra::Matrix3;

/// Largest eigenvalue of M⁻¹K at rest \[1/s²\].
fn largest(model: &TissueModel) -> f64 {
    let internal: Vec<f64> = model
        .sets()
        .iter()
        .flat_map(|s| s.initial_internal())
        .collect();
    let mut matrix = answer_at(model, &State::at_rest(model), &internal).stiffness;
    for (node, w) in model.inverse_masses().iter().enumerate() {
        for k in 3 * node..3 * node + 3 {
            matrix.row_mut(k).scale_mut(w.sqrt());
            matrix.column_mut(k).scale_mut(w.sqrt());
        }
    }
    matrix.symmetric_eigenvalues().max()
}

/// A step that does for the body before. After each edit the touched nodes get what all would get, and the step does again; without it it does not for
/// most materials. With viscosity, D = τ K at rest, the step is shorter and h² + 2 h τ stands for h².
#[test]
fn touched_nodes_are_all_that_need_a_remedy() {
    let safety = 0.9;
    for viscous in [false, true] {
        let mut failed = 0;
        for material in materials() {
            let mut mesh = layers([2, 2, 1]);
            let mut clamped = clamps(&mesh);
            let free = build(&mesh, [material; 2], &clamped);
            let rate = gershgorin_bound(&free, Part::Stiffness).sqrt();
            let relaxation_time = if viscous { 1.0 / rate } else { 0.0 };
            let material = Material {
                relaxation_time,
                ..material
            };
            let mut model = build(&mesh, [material; 2], &clamped);
            // h² λ + 2 h τ λ = 4 s², with √λ = 1/τ.
            let h = match viscous {
                false => 2.0 * safety / rate,
                true => ((1.0 + 4.0 * safety * safety).sqrt() - 1.0) / rate,
            };
            let over =
                |model: &TissueModel| (largest(model) * (h * h + 2.0 * h * relaxation_time)).sqrt();
            assert!(over(&model) <= 2.0 * safety * (1.0 + 1e-12));
            let (mut next, mut bare) = (numbers(), model.clone());
            for _ in 0..4 {
                let mut edit = by_hand::random(&mesh, &clamped, &mut next);
                mesh = edit.finish();
                clamped.extend(&edit.clamped);
                for &node in edit.removed_nodes.iter().rev() {
                    clamped.swap_remove(node as usize);
                }
                let change = edit.apply(&mesh, &mut model).unwrap();
                let at_rest = State::at_rest(&model);
                let remedied = floor_nodes(
                    &mut model,
                    &change.touched,
                    &Method::StoermerVerlet,
                    h,
                    safety,
                );
                let all = mass_floor(&model, &at_rest, h, safety);
                let size = model.masses().iter().copied().fold(0.0, f64::max);
                for (a, b) in model.added_inertia().iter().zip(&all) {
                    assert!((a - b).abs() <= 1e-11 * (size + b), "{a} {b}");
                }
                let added: f64 = model.added_inertia().iter().sum();
                assert!(remedied.added <= added * (1.0 + 1e-12));
                assert_eq!(remedied.nodes > 0, remedied.added > 0.0);
                assert!(over(&model) <= 2.0 * safety * (1.0 + 1e-12));
                edit.apply(&mesh, &mut bare).unwrap();
                failed += usize::from(over(&bare) > 2.0);
            }
        }
        assert!(failed > 0);
    }
}

/// Added inertia moves with its node's velocity but weighs nothing, and masses are as they were.
#[test]
fn added_inertia_has_no_weight() {
    use crate::executor::Serial;
    use crate::forces::Forces;
    use crate::state::Control;
    let mesh = layers([1, 1, 1]);
    let material = continuum(Discretisation::Tetrahedra);
    let light = build(&mesh, [material; 2], &vec![false; mesh.positions.len()]);
    let heavy = light
        .clone()
        .with_added_inertia(light.masses().iter().map(|m| 2.0 * m).collect());
    let mut state = State::at_rest(&light);
    state.velocities.fill(Vector3::new(1.0, 2.0, 3.0));
    let kinetic = |model: &TissueModel| state.energies(model).kinetic;
    assert!((kinetic(&heavy) / kinetic(&light) - 3.0).abs() < 1e-14);
    let control = Control {
        gravity: Vector3::new(0.0, 0.0, -9.81),
        ..Control::default()
    };
    let weight = |model: &TissueModel| {
        Forces::new(model)
            .compute(model, &state, &control, &Serial)
            .to_vec()
    };
    assert_eq!(weight(&heavy), weight(&light));
    assert_eq!(heavy.masses(), light.masses());
    for (a, b) in heavy.inverse_masses().iter().zip(light.inverse_masses()) {
        assert!((3.0 * a / b - 1.0).abs() < 1e-14);
    }
}

/// A wall of collagen that answers to its stretch by an exponential.
fn wall(discretisation: Discretisation) -> Material {
    let Behaviour::Continuum(constants) = continuum(discretisation).behaviour else {
        panic!("a continuum");
    };
    Material {
        behaviour: Behaviour::Continuum(ContinuumConstants {
            law: LawName::HolzapfelGasserOgden.into(),
            ..constants
        }),
        ..continuum(discretisation)
    }
}

/// What touched nodes are given is by the stiffness and the damping of elements in their place, stretched: what `mass_floor` gives by their
/// matrices. It is more than in the natural state.
#[test]
fn prestretched_elements_get_what_they_need_in_their_place() {
    for discretisation in [Discretisation::Tetrahedra, Discretisation::EdgeSmoothed] {
        let mut mesh = layers([2, 2, 2]);
        let clamped = clamps(&mesh);
        let material = wall(discretisation);
        let natural = build(&mesh, [material; 2], &clamped);
        let across = 1.0 / WORKING_STRETCH.sqrt();
        let prestretch = Vector3::new(across, WORKING_STRETCH, across);
        mesh.prestretches = vec![Matrix3::from_diagonal(&prestretch); mesh.tets.len()];
        let model = build(&mesh, [material; 2], &clamped);
        let all: Vec<u32> = (0..mesh.positions.len() as u32).collect();
        // The longest step that does in the natural state without viscosity.
        let h = 1.8 / gershgorin_bound(&natural, Part::Stiffness).sqrt();
        let floor = |model: &TissueModel| {
            let expected = mass_floor(model, &State::at_rest(model), h, 0.9);
            let mut floored = model.clone();
            floor_nodes(&mut floored, &all, &Method::StoermerVerlet, h, 0.9);
            let size = model.masses().iter().copied().fold(0.0, f64::max);
            for (found, expected) in floored.added_inertia().iter().zip(&expected) {
                assert!(
                    (found - expected).abs() <= 1e-11 * (size + expected),
                    "{discretisation:?} {found} {expected}"
                );
            }
            expected.iter().sum::<f64>()
        };
        let (in_place, at_ease) = (floor(&model), floor(&natural));
        assert!(in_place > 2.0 * at_ease, "{in_place} {at_ease}");
    }
}

/// The inertia that a step needs at the working stretch makes it stable there, by Gershgorin; that which it needs at rest does not.
#[test]
fn a_mass_floor_of_a_stretched_shape_holds_there() {
    let mesh = layers([2, 2, 2]);
    let material = Material {
        relaxation_time: 0.0,
        ..wall(Discretisation::Tetrahedra)
    };
    let model = build(&mesh, [material; 2], &clamps(&mesh));
    let bound = gershgorin_bound(&model, Part::Stiffness);
    // Beyond the limit at rest, so that there is something to add.
    let (h, safety) = (2.0 / bound.sqrt(), 0.9);
    let at_rest = State::at_rest(&model);
    for axis in 0..3 {
        let shape = stretched(&model, WORKING_STRETCH, axis);
        let needed = |state: &State| mass_floor(&model, state, h, safety);
        let over = |added: Vec<f64>| {
            let floored = model.clone().with_added_inertia(added);
            h * gershgorin_bound_at(&floored, &shape, Part::Stiffness).sqrt() / (2.0 * safety)
        };
        assert!(over(needed(&shape)) <= 1.0 + 1e-12);
        assert!(over(needed(&at_rest)) > 1.0);
    }
}
