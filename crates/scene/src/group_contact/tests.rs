//! Which ends of vessels face one another.

use super::*;
use crate::{BodySpec, Scene, SceneSpec};
use microsim_mesh::{Block, CellSplit};
use microsim_tissue::law::LawName;
use microsim_tissue::{Behaviour, ContinuumConstants, Discretisation, Material};

/// A block from −1 to 1 mm along x about `x` \[m\], with its faces there as ends.
fn vessel(name: &str, x: f64) -> BodySpec {
    let block = Block {
        center: [x, 0.0, 0.0],
        size: [2e-3, 1e-3, 1e-3],
        cells: [2, 1, 1],
        split: CellSplit::Kuhn,
    };
    let mesh = block.mesh().unwrap();
    let all = mesh.surface().triangles;
    let end = |side: f64| {
        let there = |node: &u32| (mesh.positions[*node as usize].x - side).abs() < 1e-9;
        let face = all.iter().filter(|triangle| triangle.iter().all(there));
        face.copied().collect::<Vec<_>>()
    };
    let constants = ContinuumConstants {
        law: LawName::StableNeoHookean.into(),
        young: 50e3,
        poisson: 0.3,
        discretisation: Discretisation::Tetrahedra,
        plasticity: None,
    };
    let material = Material {
        density: 1060.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(constants),
    };
    BodySpec {
        ends: vec![end(x - 1e-3), end(x + 1e-3)],
        origin: [x, 0.0, 0.0],
        ..BodySpec::new(name, mesh, material)
    }
}

/// Of two vessels in line the ends between them face one another; once one of these has been cut away it is the other one of its vessel, which is
/// farther off than the origin, where the middle of nothing would be.
#[test]
fn an_end_of_which_nothing_is_left_faces_nothing() {
    let spec = SceneSpec {
        gravity: [0.0; 3],
        containment: false,
        repeat_unconverged: false,
        ..SceneSpec::new(
            vec![vessel("left", -2e-3), vessel("right", 2e-3)],
            Method::StoermerVerlet,
        )
    };
    let mut bodies = Scene::new(&spec).unwrap().bodies;
    let facing = |bodies: &[Body]| {
        let member = |body| Member {
            body,
            first_node: 0,
        };
        let both = [0, 1].map(|body| (&bodies[body], member(body)));
        facing_ends(both).map(|end| end.triangles)
    };
    let ends = [&bodies[0], &bodies[1]].map(|body| body.ends.clone());
    assert_eq!(facing(&bodies), [ends[0][1].clone(), ends[1][0].clone()]);
    bodies[0].ends[1].clear();
    assert_eq!(facing(&bodies), [ends[0][0].clone(), ends[1][0].clone()]);
}
