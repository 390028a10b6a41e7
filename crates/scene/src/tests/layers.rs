//! Layers that slide and cling, in scenes: the same bits after saving, conservation, energy.

use super::*;
use crate::cutting::TornBodies;
use microsim_tissue::elements::{Bond, Cohesion, CouplingConstants, SlidingConstants};
use microsim_tissue::law::LawName;
use microsim_tissue::{ContinuumConstants, Discretisation};

/// A free plate of 6 × 3 mm of two layers; the upper one, region 1, moves at 0.1 m/s along x and is pressed down or lifted by `down` [m/s].
fn plate(kind: CouplingKind, method: Method, down: f64) -> SceneSpec {
    let block = Block {
        center: [0.0; 3],
        size: [6e-3, 3e-3, 2e-3],
        cells: [6, 3, 2],
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().unwrap();
    let upper = mesh.tets.len() / 2;
    mesh.regions[upper..].fill(1);
    let mesh = mesh.detached(&[1]).mesh;
    let continuum = ContinuumConstants {
        law: LawName::StableNeoHookean.into(),
        young: 300e3,
        poisson: 0.3,
        discretisation: Discretisation::Tetrahedra,
        plasticity: None,
    };
    let material = Material {
        density: 1060.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(continuum),
    };
    let start = |min: f64, velocity: [f64; 3]| StartSpec {
        nodes: Selection::Box(BoxSpec {
            min: [-1.0, -1.0, min],
            max: [1.0, 1.0, 1.0],
        }),
        matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        pivot: [0.0; 3],
        shift: [0.0; 3],
        velocity,
    };
    let body = BodySpec {
        materials: vec![(0, material), (1, material)],
        couplings: vec![CouplingSpec {
            from: 1,
            to: 0,
            kind,
        }],
        start: vec![start(0.5e-3, [0.3, 0.0, -down])],
        ..BodySpec::new("plate", mesh, material)
    };
    SceneSpec {
        gravity: [0.0; 3],
        ..SceneSpec::new(vec![body], method)
    }
}

fn sliding() -> CouplingKind {
    CouplingKind::Sliding(SlidingConstants {
        stiffness_per_area: 1e8,
        friction: 0.2,
        shear_strength: 0.0,
    })
}

fn clinging() -> CouplingKind {
    // Off after 40 um and 0.01 J/m², a third of what moves.
    CouplingKind::Bonded(CouplingConstants {
        stiffness_per_area: 1e8,
        bond: Bond::Cohesive(Cohesion::new(1e8, 500.0, 0.01)),
    })
}

/// Momentum and angular momentum of the first body.
fn momenta(scene: &Scene) -> [Vector3<f64>; 2] {
    let body = scene.body(0);
    let mut sums = [Vector3::zeros(); 2];
    let nodes = body.positions().iter().zip(body.velocities());
    for ((x, v), mass) in nodes.zip(body.masses()) {
        sums[0] += v * *mass;
        sums[1] += x.cross(v) * *mass;
    }
    sums
}

const STEP: f64 = 0.1e-3;

/// Advances by ticks of half a millisecond.
fn advance(scene: &mut Scene, ticks: usize, steps: u32) {
    for _ in 0..ticks {
        let steps = scene.required_steps(5.0 * STEP).max(steps);
        scene.tick(&[], 5.0 * STEP, steps, &Serial).unwrap();
    }
}

#[test]
fn a_scene_with_layers_goes_on_from_saved_bytes_bit_for_bit() {
    for kind in [sliding(), clinging()] {
        let method = Method::ImplicitEuler(Newton::default());
        let spec = plate(kind, method, 0.05);
        let mut scene = Scene::new(&spec).unwrap();
        // Far enough that nodes have gone on to other elements.
        advance(&mut scene, 14, 5);
        assert!(scene.body(0).energies().dissipated > 0.0);
        let saved = scene.save();
        let mut other = Scene::new(&spec).unwrap();
        let fresh = tied(&other);
        other.restore(&saved).unwrap();
        assert_eq!(
            matches!(kind, CouplingKind::Sliding(_)),
            fresh != tied(&other)
        );
        assert_eq!(other.body(0).energies(), scene.body(0).energies());
        for scene in [&mut scene, &mut other] {
            advance(scene, 6, 5);
        }
        assert!(other.save() == scene.save(), "{kind:?}");
        // And back: the model follows the state.
        scene.restore(&saved).unwrap();
        assert!(scene.save() == saved, "{kind:?}");
        advance(&mut scene, 6, 5);
        assert!(other.save() == scene.save(), "{kind:?}");
    }
}

/// A blade along y, 0.5 mm to the right of the middle, from above the plate to below it.
fn with_blade(mut spec: SceneSpec) -> SceneSpec {
    let edge = CapsuleSpec {
        lonor: true,
        ..CapsuleSpec::new([0.0, -3e-3, 0.0], [0.0, 3e-3, 0.0], 5e-5)
    };
    spec.tools.push(ToolSpec {
        name: "blade".into(),
        capsules: vec![edge],
        sharpness: 0.0,
        jaw_stiffness: f64::INFINITY,
        irrigation: None,
        motion: Vec::new(),
    });
    spec.cuts.push(CutSpec::new("plate", "blade"));
    spec
}

/// One of twelve ticks of the blade.
fn cut(scene: &mut Scene, tick: usize, steps: u32) {
    let pose = |tick: usize| Pose {
        position: Vector3::new(0.5e-3, 0.0, 1.5e-3 - 0.25e-3 * tick as f64),
        ..Pose::identity()
    };
    let motion = ToolMotion {
        tool: 0,
        from: pose(tick),
        to: pose(tick + 1),
        opening_from: 0.0,
        opening_to: 0.0,
        active: true,
    };
    scene.tick(&[motion], 5.0 * STEP, steps, &Serial).unwrap();
}

/// Edits depend on where ties were when they were made: far from where a scene begins, with other elements below them.
#[test]
fn layers_that_slid_and_were_cut_go_on_from_saved_bytes_bit_for_bit() {
    for method in [
        Method::ImplicitEuler(Newton::default()),
        Method::StoermerVerlet,
    ] {
        let spec = with_blade(plate(sliding(), method, 0.05));
        let mut scene = Scene::new(&spec).unwrap();
        let steps = scene.required_steps(5.0 * STEP).max(5);
        let begin = scene.save();
        advance(&mut scene, 14, steps);
        let mut saved = Vec::new();
        for tick in 0..12 {
            saved.push(scene.save());
            cut(&mut scene, tick, steps);
        }
        assert!(scene.edits.len() > 3 && scene.body(0).energies().dissipated > 0.0);
        let after = scene.save();
        advance(&mut scene, 4, steps);
        let (end, digest) = (scene.save(), scene.digest());
        for from in [0, 5, 8, 11] {
            let mut other = Scene::new(&spec).unwrap();
            for scene in [&mut scene, &mut other] {
                scene.restore(&saved[from]).unwrap();
                assert!(scene.save() == saved[from], "{method:?} {from}");
                (from..12).for_each(|tick| cut(scene, tick, steps));
                assert!(scene.save() == after, "{method:?} {from}");
                advance(scene, 4, steps);
                assert!(scene.digest() == digest, "{method:?} {from}");
            }
        }
        scene.restore(&begin).unwrap();
        scene.restore(&end).unwrap();
        assert!(scene.save() == end && scene.digest() == digest);
    }
}

#[test]
fn layers_conserve_momentum_and_what_they_lose_is_counted() {
    for kind in [sliding(), clinging()] {
        let spec = plate(kind, Method::StoermerVerlet, 0.05);
        let mut scene = Scene::new(&spec).unwrap();
        let before = momenta(&scene);
        let energy = |scene: &Scene| {
            let body = scene.body(0);
            body.energies().total() + body.energies().dissipated
        };
        let first = energy(&scene);
        advance(&mut scene, 10, 200);
        let after = momenta(&scene);
        // Rounding of some thousand steps.
        let size = before[0].norm();
        assert!((after[0] - before[0]).norm() < 1e-11 * size);
        // Ties that cling pull along d, whatever is left of them; those that slide leave a moment of first order in the step.
        let turned = (after[1] - before[1]).norm() / (size * 1e-3);
        let bound = match kind {
            CouplingKind::Bonded(_) => 1e-11,
            CouplingKind::Sliding(_) => 1e-3,
        };
        assert!(turned < bound, "{kind:?} {turned}");
        // Störmer–Verlet oscillates by h ω/2 of the energy of a mode: 2.5 us at some 1e5 1/s, a tenth of it in such modes.
        let lost = scene.body(0).energies().dissipated;
        assert!(lost > 0.05 * first, "{kind:?} {lost} of {first}");
        assert!(
            (energy(&scene) / first - 1.0).abs() < 0.02,
            "{kind:?} {} {first}",
            energy(&scene)
        );
    }
}

/// Nodes of a tie.
fn tied(scene: &Scene) -> Vec<u32> {
    let sets = scene.body(0).model().sets();
    sets.last().unwrap().nodes(5).to_vec()
}

/// Reset, layers that have slid are as those of a new scene to the bit, and so is what follows, also where the solver's matrix has followed the
/// ties of a body that can be cut and was not.
#[test]
fn layers_that_have_slid_begin_again_after_a_reset() {
    let mut spec = plate(sliding(), Method::ImplicitEuler(Newton::default()), 0.05);
    for tear_strains in [Vec::new(), vec![(0, 1e3)]] {
        spec.bodies[0].tear_strains = tear_strains;
        let mut scene = Scene::new(&spec).unwrap();
        let mut fresh = Scene::new(&spec).unwrap();
        advance(&mut scene, 14, 5);
        assert_ne!(tied(&scene), tied(&fresh));
        scene.reset();
        assert_eq!(tied(&scene), tied(&fresh));
        for _ in 0..2 {
            assert!(scene.save() == fresh.save());
            for scene in [&mut scene, &mut fresh] {
                advance(scene, 6, 5);
            }
        }
        assert!(scene.save() == fresh.save());
    }
}

/// The plate with a column of shreds, its lower layer held on the left and pulled on the right by five lengths in a tick of few iterations: its forces mean
/// nothing, and the shreds fail while the upper layer slides off. Without them the tick begins again from its start: as in a scene whose shreds
/// were taken before any tick, to the bit, although ties have slid in the try.
#[test]
fn shreds_that_rupture_leave_ties_where_they_were_at_the_start() {
    let newton = Newton {
        iterations: 1,
        tolerance: 1e-6,
        must_converge: false,
    };
    let mut spec = plate(sliding(), Method::ImplicitEuler(newton), 0.05);
    let body = &mut spec.bodies[0];
    for place in &mut body.mesh.positions {
        if place.x.abs() < 1e-6 {
            place.x = -0.95e-3;
        }
    }
    let end = |x: f64, motion: Option<MotionSpec>| ClampSpec {
        nodes: Selection::Box(BoxSpec {
            min: [x - 1e-6, -1.0, -1.0],
            max: [x + 1e-6, 1.0, -0.5e-3],
        }),
        motion,
        release: None,
    };
    let motion = MotionSpec {
        pivot: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        keys: vec![MotionKey {
            time: 0.01,
            shift: [30e-3, 0.0, 0.0],
            angle: 0.0,
        }],
    };
    body.clamps = vec![end(-3e-3, None), end(3e-3, Some(motion))];
    body.tear_strains = vec![(0, 0.5)];
    let tick = |scene: &mut Scene| scene.tick(&[], 10e-3, 1, &Serial).unwrap();
    let mut never = Scene::new(&SceneSpec {
        repeat_invalid: false,
        ..spec.clone()
    })
    .unwrap();
    let start = never.state.bodies[0].internal.clone();
    assert!(!tick(&mut never).valid);
    assert_ne!(never.state.bodies[0].internal, start);
    let shreds = never.failing_shreds();
    let mut before = Scene::new(&spec).unwrap();
    before.rupture(&shreds, &mut TornBodies::default());
    let expected = tick(&mut before);
    let mut scene = Scene::new(&spec).unwrap();
    let report = tick(&mut scene);
    assert!(report.ruptured > expected.ruptured, "{report:?}");
    assert!(scene.save() == before.save());
}
