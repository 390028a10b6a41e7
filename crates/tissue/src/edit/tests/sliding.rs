//! Layers that slide and are cut.

use super::*;
use crate::elements::{
    Bond, Cohesion, CouplingConstants, Sliding, SlidingConstants, couple, couple_sliding,
};

/// A plate, and on it a smaller one of region 7.
fn plates() -> TetMesh {
    let mut mesh = block_mesh([3.0, 1.0, 0.5], [6, 2, 1]);
    let mut upper = block_mesh([1.0, 1.0, 0.5], [2, 2, 1]);
    upper.positions.iter_mut().for_each(|p| p.z += 0.5);
    mesh.regions.fill(3);
    upper.regions.fill(7);
    mesh.append(&upper, 0);
    mesh
}

fn body(mesh: &TetMesh, set: impl Elements) -> TissueModel {
    let material = continuum(Discretisation::Tetrahedra);
    let clamped = vec![false; mesh.positions.len()];
    let more: Vec<std::sync::Arc<dyn Elements>> = vec![std::sync::Arc::new(set)];
    build_model(mesh, &[(3, material), (7, material)], &clamped, 0.0, more).unwrap()
}

/// The upper plate moved; its nodes are those of its elements, as others lie in the same places.
fn slid(model: &TissueModel, mesh: &TetMesh, by: Vector3<f64>) -> Vec<Vector3<f64>> {
    let mut x = model.rest_positions().to_vec();
    let mut upper: Vec<u32> = Vec::new();
    for (tet, region) in mesh.tets.iter().zip(&mesh.regions) {
        if *region == 7 {
            upper.extend(tet);
        }
    }
    upper.sort_unstable();
    upper.dedup();
    upper.iter().for_each(|node| x[*node as usize] += by);
    x
}

#[test]
fn sliding_ties_are_found_where_they_have_come_and_follow_a_cut() {
    let mesh = plates();
    let constants = SlidingConstants {
        stiffness_per_area: 1e3,
        friction: 0.2,
        shear_strength: 0.0,
    };
    let set = couple_sliding(&mesh, 7, 3, &constants).unwrap();
    let mut model = body(&mesh, set);
    model.prepare_edits();
    let mut state = State::at_rest(&model);
    let coupling = model.sets().len() - 1;
    let before: Vec<Vec<u32>> = (0..9)
        .map(|e| model.sets()[coupling].nodes(e).to_vec())
        .collect();
    // Pressed, then over more than one cell.
    for x in [0.0, 0.3, 0.6] {
        state.positions = slid(&model, &mesh, Vector3::new(x, 0.0, -0.01));
        crate::flow(&model, &mut state, 1.0);
        let other = model.relocate(&state.internal);
        assert_eq!(other, x > 0.0);
        assert!(!model.relocate(&state.internal), "it is in place");
        check_index(&model);
    }
    let now: Vec<Vec<u32>> = (0..9)
        .map(|e| model.sets()[coupling].nodes(e).to_vec())
        .collect();
    assert!(
        before
            .iter()
            .zip(&now)
            .all(|(a, b)| a[0] == b[0] && a[1..] != b[1..])
    );

    let energy = |model: &TissueModel, state: &State| {
        model.sets()[coupling].energy(&state.configuration(model, coupling))
    };
    // k N²/2 of 1e3 × 1 × 0.01, and at the bound μ² of it across.
    let pressed = 0.5 * 1e3 * 1e-4;
    let expected = pressed * (1.0 + 0.04);
    assert!((energy(&model, &state) / expected - 1.0).abs() < 1e-12);
    let lost = state.energies(&model).dissipated;
    assert!(lost > 0.0);

    // Edges of the plate below a tie, and its node.
    let point = now[4][1..].to_vec();
    let mut edit = ByHand::new(&mesh);
    edit.divide([point[0].min(point[1]), point[0].max(point[1])], 0.4, false);
    edit.divide([point[2].min(point[3]), point[2].max(point[3])], 0.5, false);
    edit.split(now[1][0], false);
    let after = edit.finish();
    state.edit(&edit.apply(&after, &mut model).unwrap());
    check_index(&model);
    assert_eq!(model.sets()[coupling].count(), 10);
    let range = model.internal_range(coupling);
    assert_eq!(Sliding::held(&state.internal[range]), 10);
    assert!(!model.relocate(&state.internal));
    // Plates have moved as wholes: points are where they were.
    assert!((energy(&model, &state) / expected - 1.0).abs() < 1e-12);
    assert!((state.energies(&model).dissipated / lost - 1.0).abs() < 1e-12);
    // And on.
    state.positions = slid(&model, &after, Vector3::new(0.8, 0.0, -0.01));
    crate::flow(&model, &mut state, 1.0);
    model.relocate(&state.internal);
    check_index(&model);
    assert!((energy(&model, &state) / expected - 1.0).abs() < 1e-12);
}

/// Cuts make edges shorter: a tie that is beyond the rim by less than a quarter of an edge before them stays, and one that is free already does
/// not come back.
#[test]
fn ties_beyond_a_rim_are_held_or_free_as_before_a_cut() {
    let mesh = plates();
    let reach = 0.25 * mesh.mean_edge_length();
    let constants = SlidingConstants {
        stiffness_per_area: 1e3,
        friction: 0.2,
        shear_strength: 0.0,
    };
    // A column of three of the nine ties, of a quarter of the area, goes beyond the rim at 1.5.
    for (beyond, held, area) in [(0.95 * reach, 9, 1.0), (1.2 * reach, 6, 0.75)] {
        let mut model = body(&mesh, couple_sliding(&mesh, 7, 3, &constants).unwrap());
        let mut state = State::at_rest(&model);
        let coupling = model.sets().len() - 1;
        let slide = |mesh: &TetMesh, model: &mut TissueModel, state: &mut State, x: f64| {
            state.positions = slid(model, mesh, Vector3::new(x, 0.0, -0.01));
            crate::flow(model, state, 1.0);
            model.relocate(&state.internal);
            Sliding::held(&state.internal[model.internal_range(coupling)])
        };
        for x in [0.0, 0.3, 0.6, 0.9] {
            assert_eq!(slide(&mesh, &mut model, &mut state, x), 9);
        }
        assert_eq!(slide(&mesh, &mut model, &mut state, 1.0 + beyond), held);

        // All diagonals through cells of the plate are halved.
        let mut edit = ByHand::new(&mesh);
        let plate = (0..mesh.tets.len()).filter(|e| mesh.regions[*e] == 3);
        let mut diagonals: Vec<[u32; 2]> = plate.flat_map(|e| mesh.element_edges(e)).collect();
        let place = |node: u32| mesh.positions[node as usize];
        diagonals.retain(|[a, b]| (place(*a) - place(*b)).norm() > 0.8);
        diagonals.iter_mut().for_each(|edge| edge.sort_unstable());
        diagonals.sort_unstable();
        diagonals.dedup();
        assert_eq!(diagonals.len(), 12);
        for edge in diagonals {
            edit.divide(edge, 0.5, false);
        }
        let after = edit.finish();
        assert!(0.25 * after.mean_edge_length() < 0.95 * reach);
        state.edit(&edit.apply(&after, &mut model).unwrap());
        check_index(&model);
        for x in [1.0 + beyond + 0.03 * reach, 0.9, 0.6, 0.3, 0.0] {
            assert_eq!(slide(&after, &mut model, &mut state, x), held, "{x}");
            // k N²/2 of 1e3 × area × 0.01, and at the bound μ² of it across.
            let expected = area * 0.5 * 1e3 * 1e-4 * (1.0 + 0.04);
            let energy = model.sets()[coupling].energy(&state.configuration(&model, coupling));
            assert!((energy / expected - 1.0).abs() < 1e-10, "{x} {energy}");
        }
    }
}

#[test]
fn damage_is_inherited_by_a_cut_through_an_interface() {
    let mesh = plates();
    // Softens from 0.01 to 0.05.
    let bond = Bond::Cohesive(Cohesion::new(1e3, 10.0, 0.25));
    let constants = CouplingConstants {
        stiffness_per_area: 1e3,
        bond,
    };
    let mut model = body(&mesh, couple(&mesh, 7, 3, &constants).unwrap());
    let mut state = State::at_rest(&model);
    let coupling = model.sets().len() - 1;
    state.positions = slid(&model, &mesh, Vector3::new(0.0, 0.0, 0.03));
    crate::flow(&model, &mut state, 1.0);
    // t at 0.03 is half of the strength, over an area of 1: area below the law less what is stored.
    let lost = 0.5 * 10.0 * 0.01 + 0.5 * (10.0 + 5.0) * 0.02 - 0.5 * 5.0 * 0.03;
    assert!((state.energies(&model).dissipated / lost - 1.0).abs() < 1e-12);
    let node = model.sets()[coupling].nodes(4)[0];
    let point = model.sets()[coupling].nodes(2)[1..].to_vec();
    let mut edit = ByHand::new(&mesh);
    edit.divide([point[0].min(point[1]), point[0].max(point[1])], 0.4, false);
    edit.split(node, false);
    let after = edit.finish();
    state.edit(&edit.apply(&after, &mut model).unwrap());
    assert_eq!(model.sets()[coupling].count(), 10);
    assert!((state.energies(&model).dissipated / lost - 1.0).abs() < 1e-12);
    let energy = model.sets()[coupling].energy(&state.configuration(&model, coupling));
    assert!(
        (energy / (0.5 * 5.0 * 0.03) - 1.0).abs() < 1e-12,
        "{energy}"
    );
}
