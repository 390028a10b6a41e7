//! What is refused, unions.

use super::*;
use crate::executor::Serial;
use crate::forces::Forces;
use crate::method::Method;
use crate::state::{Control, State};
use crate::testing::{beam, build, numbers, soft_block};

#[test]
fn what_is_no_body_is_refused() {
    let mesh = soft_block([1; 3]);
    let nothing = TetMesh::new(Vec::new(), Vec::new(), Vec::new());
    let nodes_alone = TetMesh::new(mesh.positions.clone(), Vec::new(), Vec::new());
    let build = |mesh: &TetMesh, drag| {
        let densities = vec![1000.0; mesh.tets.len()];
        let clamped = vec![false; mesh.positions.len()];
        TissueModel::new(mesh, &densities, &clamped, Vec::new(), drag).map(|_| ())
    };
    assert_eq!(build(&nothing, 0.0), Err(ModelError::Empty));
    assert_eq!(build(&nodes_alone, 0.0), Err(ModelError::Empty));
    assert_eq!(build(&mesh, 0.0), Ok(()));
    for drag in [-1.0, f64::INFINITY] {
        assert_eq!(build(&mesh, drag), Err(ModelError::Drag { drag }));
    }
    let refused = build(&mesh, f64::NAN);
    assert!(matches!(refused, Err(ModelError::Drag { .. })));
}

/// Two bodies of different elements, clamps and drag, one of them twice: in the union each has the forces, the energies and
/// the steps that it has alone, to the bit.
#[test]
fn bodies_of_a_union_do_not_know_of_one_another() {
    let soft = build(&soft_block([2, 2, 1]), |p| p.x < -0.9e-3);
    let stiff = beam(0.4);
    let mut dragged = soft.clone();
    dragged.drags[0].1 = 30.0;
    let bodies = [&soft, &stiff, &dragged];
    let union = TissueModel::union(&bodies);
    assert_eq!(
        union.node_count(),
        bodies.iter().map(|b| b.node_count()).sum()
    );
    assert_eq!(union.drag(), 30.0);
    assert_eq!(union.mean_edge_length(), soft.mean_edge_length());
    let control = Control {
        gravity: Vector3::new(0.0, 0.3, -9.81),
        ..Control::default()
    };
    let mut next = numbers();
    let mut alone: Vec<State> = bodies.iter().map(|b| State::at_rest(b)).collect();
    let mut joint = State::at_rest(&union);
    joint.positions.clear();
    for (state, body) in alone.iter_mut().zip(&bodies) {
        for p in &mut state.positions {
            *p += Vector3::new(next(), next(), next()) * (0.05 * body.mean_edge_length());
        }
        joint.positions.extend(&state.positions);
    }
    let parts = |all: &[Vector3<f64>]| {
        let mut first = 0;
        bodies.map(|body| {
            first += body.node_count();
            all[first - body.node_count()..first].to_vec()
        })
    };
    for step in 0..3 {
        let forces = parts(Forces::new(&union).compute(&union, &joint, &control, &Serial));
        for ((state, body), forces) in alone.iter_mut().zip(&bodies).zip(forces) {
            assert_eq!(
                Forces::new(body).compute(body, state, &control, &Serial),
                forces,
                "step {step}"
            );
        }
        for (model, state) in bodies
            .into_iter()
            .zip(&mut alone)
            .chain([(&union, &mut joint)])
        {
            let mut solver = Method::StoermerVerlet.solver(model).unwrap();
            solver
                .step(model, state, &control, &[], 1e-5, &Serial)
                .unwrap();
        }
        let positions = parts(&joint.positions);
        assert!(alone.iter().zip(positions).all(|(a, b)| a.positions == b));
    }
}

/// Large bodies keep their parts, small ones next to them are one part each: the same up to the order of one sum.
#[test]
fn a_union_of_a_large_body_is_parallel() {
    let large = build(&soft_block([10, 10, 8]), |_| false);
    let small = build(&soft_block([2, 2, 1]), |_| false);
    let union = TissueModel::union(&[&small, &large]);
    assert_eq!(union.parts().len(), 1 + large.parts().len());
    let mut state = State::at_rest(&union);
    let mut next = numbers();
    for p in &mut state.positions {
        *p += Vector3::new(next(), next(), next()) * (0.05 * union.mean_edge_length());
    }
    let mut part = State::at_rest(&large);
    part.positions
        .copy_from_slice(&state.positions[small.node_count()..]);
    let control = Control::default();
    let mut all = Forces::new(&union);
    let all = &all.compute(&union, &state, &control, &Serial)[small.node_count()..];
    assert_eq!(
        all,
        Forces::new(&large).compute(&large, &part, &control, &Serial)
    );
}
