//! Remedies after edits, where they touched, against those of the whole body and dense eigenvalues.

use super::*;
use crate::method::Method;
use crate::stability::{Part, floor_nodes, gershgorin_bound, mass_floor};

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
