//! What follows cuts piece by piece is what is rebuilt of the meshes.

use super::*;
use crate::pieces::Pieces;
use microsim_random::Congruential;
use microsim_tissue::law::LawName;
use microsim_tissue::{ContinuumConstants, Discretisation};

/// A bar over a table, in contact with that, with itself, with a second bar above it, and with what cuts both.
fn bars() -> SceneSpec {
    let bar = |name: &str, z: f64| BodySpec {
        drag: 20.0,
        toughness: 1.0,
        brittleness: 0.5,
        loads: vec![LoadSpec {
            surface: Selection::All,
            kind: LoadKind::Pressure(20.0),
            ramp: 0.0,
        }],
        ..BodySpec::new(
            name,
            Block {
                center: [0.0, 0.0, z],
                size: [5e-3, 2e-3, 1e-3],
                cells: [10, 4, 2],
                split: CellSplit::Kuhn,
            }
            .mesh()
            .unwrap(),
            Material {
                density: 1060.0,
                relaxation_time: 0.0,
                behaviour: Behaviour::Continuum(ContinuumConstants {
                    law: LawName::StableNeoHookean.into(),
                    young: 40e3,
                    poisson: 0.3,
                    discretisation: Discretisation::EdgeSmoothed,
                    plasticity: None,
                }),
            },
        )
    };
    let contact = |body: &str, with: PartnerSpec| ContactSpec {
        friction: 0.2,
        ..ContactSpec::new(body, with)
    };
    let other = PartnerSpec::Body {
        name: "upper".into(),
        end_planes: false,
    };
    let cut = |body: &str| CutSpec::new(body, "blade");
    SceneSpec {
        bodies: vec![bar("lower", 0.0), bar("upper", 1.05e-3)],
        tools: vec![ToolSpec {
            name: "blade".into(),
            capsules: vec![CapsuleSpec {
                lonor: true,
                ..CapsuleSpec::new([0.0, -1.5e-3, 0.0], [0.0, 1.5e-3, 0.0], 5e-5)
            }],
            sharpness: 1.0,
            jaw_stiffness: f64::INFINITY,
            irrigation: None,
            motion: Vec::new(),
        }],
        obstacles: vec![ObstacleSpec {
            name: "table".into(),
            parts: vec![ObstaclePart {
                shape: ObstacleShape::HalfSpace,
                pose: Pose {
                    position: Vector3::new(0.0, 0.0, -0.5e-3),
                    ..Pose::identity()
                },
            }],
        }],
        contacts: vec![
            contact("lower", PartnerSpec::Obstacle("table".into())),
            contact("lower", PartnerSpec::Itself),
            contact("lower", other),
        ],
        cuts: vec![cut("lower"), cut("upper")],
        ..SceneSpec::new(Vec::new(), Method::StoermerVerlet)
    }
}

fn check_boundaries(scene: &Scene, what: &str) {
    for body in &scene.bodies {
        let mut rebuilt = body.clone();
        rebuilt.rebuild_surface();
        assert!(body.surface_edits.is_none(), "{what}");
        assert_eq!(body.triangles, rebuilt.triangles, "{what}");
        assert_eq!(body.surface, rebuilt.surface, "{what}");
        assert_eq!(body.opened, rebuilt.opened, "{what}");
        let bits = |areas: &[f64]| areas.iter().map(|a| a.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&body.node_areas), bits(&rebuilt.node_areas), "{what}");
        // The load is that of the skin that was there from the start: everything that no cut has opened.
        let area = |inner: bool| {
            let all = body.surface.area_vectors(&body.mesh.positions);
            let of = all.iter().zip(&body.opened).filter(|(_, i)| **i == inner);
            of.map(|(a, _)| a.norm()).sum::<f64>()
        };
        // A bar of 5 × 2 × 1 mm.
        assert!(
            (area(false) / 34e-6 - 1.0).abs() < 1e-9,
            "{what}: {}",
            area(false)
        );
        let (of_nodes, count) = (body.pieces.of_nodes.clone(), body.pieces.count());
        assert_eq!(
            body.pieces,
            Pieces::new(of_nodes, count, &body.mesh.tets),
            "{what}"
        );
        // What hangs together is of one piece.
        let topology = body.topology.as_ref().unwrap();
        for (element, tet) in body.mesh.tets.iter().enumerate() {
            let piece = body.pieces.of_nodes[tet[0] as usize];
            for corner in 0..4 {
                if let Some(other) = topology.neighbour(element as u32, corner) {
                    let node = body.mesh.tets[other as usize][0];
                    assert_eq!(body.pieces.of_nodes[node as usize], piece, "{what}");
                }
            }
        }
    }
}

/// Strokes at random places and angles through both bars. After every tick all lists are those rebuilt, and a scene that was restored, for
/// which all was rebuilt, makes the same step.
#[test]
fn what_follows_cuts_is_what_is_made_anew() {
    let spec = bars();
    let mut scene = Scene::new(&spec).unwrap();
    let tick = 2e-5;
    let steps = scene.required_steps(tick);
    let mut random = Congruential(3);
    let mut number = move || random.number();
    let mut divided = 0;
    for stroke in 0..4 {
        let (x, turn) = (
            2e-3 * number(),
            UnitQuaternion::new(Vector3::new(0.2 * number(), 0.3 * number(), number())),
        );
        let at = |k: usize| Pose {
            position: Vector3::new(x, 0.0, 2e-3 - 3e-3 * k as f64 / 6.0),
            orientation: turn,
        };
        for k in 0..6 {
            let what = format!("stroke {stroke}, tick {k}");
            let motion = ToolMotion {
                tool: 0,
                from: at(k),
                to: at(k + 1),
                opening_from: 0.0,
                opening_to: 0.0,
                active: true,
            };
            let mut again = Scene::new(&spec).unwrap();
            again.restore(&scene.save()).unwrap();
            let report = scene.tick(&[motion], tick, steps, &Serial).unwrap();
            again.tick(&[motion], tick, steps, &Serial).unwrap();
            assert!(scene.save() == again.save(), "{what}");
            divided += report.cuts.iter().map(|cut| cut.divided).sum::<usize>();
            check_boundaries(&scene, &what);
        }
    }
    assert!(
        divided > 500 && scene.body(0).piece_count() > 4,
        "{divided}, {}",
        scene.body(0).piece_count()
    );
}

/// A cube that is large enough for a solver with two levels, cut into halves: a scene restored in between, with a solver that has not seen the
/// edits before, goes on with the same bits.
#[test]
fn a_solver_that_follows_is_the_one_that_was_restored() {
    let mut spec = bars();
    spec.bodies.truncate(1);
    spec.cuts.truncate(1);
    spec.contacts.truncate(1);
    spec.method = Method::ImplicitEuler(Newton {
        iterations: 1,
        tolerance: 1e-3,
        must_converge: false,
    });
    spec.bodies[0].mesh = Block {
        center: [0.0, 0.0, 0.5e-3],
        size: [2e-3; 3],
        cells: [8; 3],
        split: CellSplit::Kuhn,
    }
    .mesh()
    .unwrap();
    let mut scene = Scene::new(&spec).unwrap();
    let at = |k: usize| Pose {
        position: Vector3::new(0.07e-3, 0.0, 1.6e-3 - 0.75e-3 * k as f64),
        ..Pose::identity()
    };
    let motion = |k: usize| ToolMotion {
        tool: 0,
        from: at(k),
        to: at(k + 1),
        opening_from: 0.0,
        opening_to: 0.0,
        active: true,
    };
    let mut saved = Vec::new();
    for k in 0..3 {
        scene.tick(&[motion(k)], 1e-3, 1, &Serial).unwrap();
        saved.push(scene.save());
    }
    assert_eq!(scene.body(0).piece_count(), 2);
    let mut again = Scene::new(&spec).unwrap();
    for k in 1..3 {
        again.restore(&saved[k - 1]).unwrap();
        again.tick(&[motion(k)], 1e-3, 1, &Serial).unwrap();
        assert!(again.save() == saved[k], "tick {k}");
    }
}
