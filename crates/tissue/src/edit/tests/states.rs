//! States that follow: motion, plastic flow, ties.

use super::*;
use crate::elements::{Bond, CouplingConstants, PlasticState, couple};

/// New nodes move as the line on which they are, moved ones as the tissue where they are now: a linear motion stays one.
#[test]
fn a_linear_motion_stays_linear() {
    let mut mesh = layers([2, 2, 2]);
    let clamped = vec![false; mesh.positions.len()];
    let material = continuum(Discretisation::Tetrahedra);
    let mut model = build(&mesh, [material; 2], &clamped);
    let turn = nalgebra::Matrix3::new(1.1, 0.2, -0.1, 0.3, 0.8, 0.2, -0.2, 0.1, 1.3);
    let motion = |x: &Vector3<f64>| turn * x + Vector3::new(0.3, 0.1, -0.2);
    let mut state = State::at_rest(&model);
    state.positions = mesh.positions.iter().map(motion).collect();
    state.velocities = mesh.positions.iter().map(|x| motion(x) * 2.0).collect();
    state.accelerations = mesh.positions.iter().map(|x| motion(x) * 3.0).collect();
    let mut next = numbers();
    for _ in 0..6 {
        let flags = vec![false; mesh.positions.len()];
        let mut edit = by_hand::random(&mesh, &flags, &mut next);
        mesh = edit.finish();
        state.edit(&edit.apply(&mesh, &mut model).unwrap());
        let all = [&state.positions, &state.velocities, &state.accelerations];
        for (values, factor) in all.into_iter().zip([1.0, 2.0, 3.0]) {
            assert_eq!(values.len(), mesh.positions.len());
            for (value, x) in values.iter().zip(&mesh.positions) {
                assert!((value - motion(x) * factor).norm() < 1e-13);
            }
        }
    }
}

/// Every edge has flowed by its own amount. After an edge was divided its halves have its plastic stretch, all other edges of before their
/// own, the new ones the mean over the edges of the elements they are in; volumes have that of their parent.
#[test]
fn plastic_flow_is_inherited() {
    let mesh = layers([2, 2, 2]);
    let clamped = vec![false; mesh.positions.len()];
    let moduli = SpringModuli {
        stretch: 25e3,
        area: 0.0,
        volume: 5e4,
    };
    let material = plastic(springs(SpringForm::Scaled(moduli)));
    let other = continuum(Discretisation::Tetrahedra);
    let mut model = build(&mesh, [material, other], &clamped);
    let mut state = State::at_rest(&model);
    let mut next = numbers();
    state
        .internal
        .iter_mut()
        .for_each(|v| *v *= 1.2 + 0.1 * next());
    let flowed = |model: &TissueModel, state: &State, set: usize, nodes: &[u32]| {
        let elements = &model.sets()[set];
        let key = Key::new(nodes);
        let same = |e: &usize| Key::new(elements.nodes(*e)) == key;
        let element = (0..elements.count()).find(same)?;
        let internal = &state.internal[model.internal_range(set)];
        let rest = elements.initial_internal()[element];
        Some([
            internal[element] / rest,
            internal[elements.count() + element],
        ])
    };
    let (model_before, before) = (model.clone(), state.clone());
    // Within the lower layer.
    let lower = mesh.regions.iter().position(|r| *r == 3).unwrap();
    let edge = mesh.element_edges(lower)[3];
    let mut edit = ByHand::new(&mesh);
    let node = edit.divide(edge, 0.3, false);
    let after = edit.finish();
    state.edit(&edit.apply(&after, &mut model).unwrap());
    let close = |a: [f64; 2], b: [f64; 2]| {
        assert!(
            (a[0] - b[0]).abs() < 1e-13 && (a[1] - b[1]).abs() < 1e-13,
            "{a:?} {b:?}"
        );
    };
    let whole = flowed(&model_before, &before, 0, &edge).unwrap();
    let (mut halves, mut kept, mut new) = (0, 0, 0);
    for spring in 0..model.sets()[0].count() {
        let nodes = model.sets()[0].nodes(spring).to_vec();
        let now = flowed(&model, &state, 0, &nodes).unwrap();
        if let Some(old) = flowed(&model_before, &before, 0, &nodes) {
            close(now, old);
            kept += 1;
        } else if edge.iter().any(|end| nodes.contains(end)) {
            close(now, whole);
            halves += 1;
        } else {
            let far = *nodes.iter().find(|n| **n != node).unwrap();
            let around = |e: &usize| {
                let tet = &mesh.tets[*e];
                mesh.regions[*e] == 3 && [edge[0], edge[1], far].iter().all(|n| tet.contains(n))
            };
            let mut edges: Vec<[u32; 2]> = (0..mesh.tets.len())
                .filter(around)
                .flat_map(|e| mesh.element_edges(e))
                .collect();
            edges.sort_unstable();
            edges.dedup();
            let values: Vec<[f64; 2]> = edges
                .iter()
                .map(|e| flowed(&model_before, &before, 0, e).unwrap())
                .collect();
            let mean =
                [0, 1].map(|k| values.iter().map(|v| v[k]).sum::<f64>() / values.len() as f64);
            close(now, mean);
            new += 1;
        }
    }
    assert_eq!(halves, 2);
    assert!(
        kept + 1 == model_before.sets()[0].count() && new > 1,
        "{kept} {new}"
    );
    for (element, tet) in after.tets.iter().enumerate() {
        if after.regions[element] != 3 {
            continue;
        }
        let parent = match element.checked_sub(mesh.tets.len()) {
            None => element,
            Some(place) => edit.parents[place] as usize,
        };
        let now = flowed(&model, &state, 1, tet).unwrap();
        close(
            now,
            flowed(&model_before, &before, 1, &mesh.tets[parent]).unwrap(),
        );
    }
}

/// A bar flows by another strain in each element, up to 0.3, and an edge is divided. In tetrahedra a child has what its parent has, to rounding. Around
/// edges what is new is a mean of what was around: no more and no less than the least and the largest, with no volume. In both what dissipated
/// is, over the volume, between what it was; and with the same flow everywhere nothing changes at all.
#[test]
fn what_has_flowed_in_a_continuum_is_inherited() {
    for discretisation in [Discretisation::Tetrahedra, Discretisation::EdgeSmoothed] {
        for uniform in [true, false] {
            let mut mesh = layers([2, 2, 2]);
            mesh.regions.fill(3);
            let material = plastic(continuum(discretisation));
            let clamped = vec![false; mesh.positions.len()];
            let mut model =
                build_model(&mesh, &[(3, material)], &clamped, 0.0, Vec::new()).unwrap();
            let mut state = State::at_rest(&model);
            let bend = if uniform { 0.0 } else { 0.25 };
            let stretch = |x: &Vector3<f64>| {
                let across = 1.0 / 1.15 - bend * x.x;
                Vector3::new(1.3 * x.x + bend * x.z * x.z, across * x.y, across * x.z)
            };
            state.positions = mesh.positions.iter().map(stretch).collect();
            crate::flow(&model, &mut state, 1.0);
            let before = model.plastic_states(&mesh, &state).unwrap();
            let range = |value: &dyn Fn(&PlasticState) -> f64| {
                let values = before.iter().map(value);
                let least = values.clone().fold(f64::INFINITY, f64::min);
                (least, values.fold(0.0, f64::max))
            };
            assert!(range(&|one| one.strain).1 > 0.1);
            let lower = mesh.regions.iter().position(|r| *r == 3).unwrap();
            let mut edit = ByHand::new(&mesh);
            edit.divide(mesh.element_edges(lower)[3], 0.3, false);
            let after = edit.finish();
            let taken = state.energies(&model).dissipated;
            state.edit(&edit.apply(&after, &mut model).unwrap());
            let now = model.plastic_states(&after, &state).unwrap();
            for (element, now) in now.iter().enumerate() {
                let parent = match element.checked_sub(mesh.tets.len()) {
                    None => element,
                    Some(place) => edit.parents[place] as usize,
                };
                let close = |a: f64, b: f64| (a - b).abs() < 1e-13 * (1.0 + b.abs());
                assert!(close(now.inverse.determinant(), 1.0));
                if uniform || discretisation == Discretisation::Tetrahedra {
                    let parent = &before[parent];
                    assert!((now.inverse - parent.inverse).amax() < 1e-13);
                    assert!(close(now.strain, parent.strain));
                    assert!(close(now.stiffening, parent.stiffening));
                    assert!(close(now.dissipated, parent.dissipated));
                }
                let (least, largest) = range(&|one| one.strain);
                assert!(now.strain > least - 1e-13 && now.strain < largest + 1e-13);
            }
            if uniform || discretisation == Discretisation::Tetrahedra {
                let same = state.energies(&model).dissipated / taken;
                assert!((same - 1.0).abs() < 1e-12, "{same}");
            }
        }
    }
}

/// Two blocks one above the other with a gap, tied.
fn tied() -> (TetMesh, TissueModel) {
    let mut mesh = block_mesh([1.0, 1.0, 0.5], [3, 3, 1]);
    let mut upper = block_mesh([1.0, 1.0, 0.5], [2, 2, 1]);
    upper.positions.iter_mut().for_each(|p| p.z += 0.51);
    mesh.regions.fill(3);
    upper.regions.fill(7);
    mesh.append(&upper, 0);
    let constants = CouplingConstants {
        stiffness_per_area: 1e3,
        bond: Bond::Elastic {
            break_distance: 0.2,
        },
    };
    let coupling = couple(&mesh, 7, 3, &constants).unwrap();
    let clamped = vec![false; mesh.positions.len()];
    let material = continuum(Discretisation::Tetrahedra);
    let materials = [(3, material), (7, material)];
    let more: Vec<std::sync::Arc<dyn Elements>> = vec![std::sync::Arc::new(coupling)];
    let model = build_model(&mesh, &materials, &clamped, 0.0, more).unwrap();
    (mesh, model)
}

/// Ties stay at rest, keep their stiffness in sum, and pull in a linear motion as before; a tie with its point or its node taken away is
/// gone, a broken one stays broken.
#[test]
fn ties_follow_their_points_and_nodes() {
    let (mesh, mut model) = tied();
    let mut state = State::at_rest(&model);
    let coupling = model.sets().len() - 1;
    let range = model.internal_range(coupling);
    state.internal[range.start] = 1.0;
    let stretch = |x: &Vector3<f64>| x + Vector3::new(0.0, 0.0, 0.05 * x.z + 0.02 * x.x);
    let apart = |model: &TissueModel, state: &State| {
        let mut state = state.clone();
        let moved = |(node, x): (usize, &Vector3<f64>)| {
            let is_upper = model.rest_positions()[node].z > 0.253;
            stretch(x) + Vector3::new(0.0, 0.0, if is_upper { 0.1 } else { 0.0 })
        };
        state.positions = model
            .rest_positions()
            .iter()
            .enumerate()
            .map(moved)
            .collect();
        model.sets()[coupling].energy(&state.configuration(model, coupling))
    };
    let before = apart(&model, &state);
    let node = model.sets()[coupling].nodes(1)[0];
    let point = model.sets()[coupling].nodes(4)[1..].to_vec();
    let mut edit = ByHand::new(&mesh);
    edit.divide([point[0].min(point[1]), point[0].max(point[1])], 0.4, false);
    edit.divide([point[2].min(point[3]), point[2].max(point[3])], 0.5, false);
    edit.split(node, false);
    let after = edit.finish();
    state.edit(&edit.apply(&after, &mut model).unwrap());
    check_index(&model);
    let rest = model.sets()[coupling].energy(&state.configuration(&model, coupling));
    assert!(rest < 1e-26, "{rest}");
    let followed = apart(&model, &state);
    assert!(
        (followed / before - 1.0).abs() < 1e-12,
        "{before} {followed}"
    );
    assert_eq!(model.sets()[coupling].count(), range.len() + 1);
    let broken = |state: &State, model: &TissueModel| {
        state.internal[model.internal_range(coupling)]
            .iter()
            .filter(|b| **b != 0.0)
            .count()
    };
    assert_eq!(broken(&state, &model), 1);
    // Without the tetrahedra of one corner of the upper block its ties are gone; all that is renumbered pulls as before.
    let count = model.sets()[coupling].count();
    let tied_node = model.sets()[coupling].nodes(count - 1)[0];
    let mut edit = ByHand::new(&after);
    for element in 0..after.tets.len() {
        if after.tets[element].contains(&tied_node) {
            edit.remove(element as u32);
        }
    }
    let last = edit.finish();
    state.edit(&edit.apply(&last, &mut model).unwrap());
    assert!(model.sets()[coupling].count() < count);
    check_index(&model);
    let rest = model.sets()[coupling].energy(&state.configuration(&model, coupling));
    assert!(rest < 1e-26, "{rest}");
}
