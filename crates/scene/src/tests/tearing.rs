//! Shreds that rupture, and whole elements beside them.

use super::*;
use crate::cutting::TornBodies;
use microsim_cutting::check;
use microsim_mesh::TetMesh;
use microsim_tissue::law::LawName;
use microsim_tissue::{ContinuumConstants, Discretisation};

/// A bar of 3 × 1 × 1 mm whose middle layer is 50 µm thick, a twentieth of the mean: its elements are shreds. Its ends are held, the one on the
/// right by a clamp that moves.
fn bar(pull: f64, tear_strain: f64, newton: Newton) -> SceneSpec {
    let block = Block {
        center: [0.0; 3],
        size: [3e-3, 1e-3, 1e-3],
        cells: [3, 1, 1],
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().unwrap();
    for place in &mut mesh.positions {
        if place.x.abs() < 1e-3 {
            place.x = 25e-6 * place.x.signum();
        }
    }
    let end = |x: f64, motion: Option<MotionSpec>| ClampSpec {
        nodes: Selection::Box(BoxSpec {
            min: [x - 1e-6, -1.0, -1.0],
            max: [x + 1e-6, 1.0, 1.0],
        }),
        motion,
        release: None,
    };
    let motion = MotionSpec {
        pivot: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        keys: vec![MotionKey {
            time: 0.01,
            shift: [pull, 0.0, 0.0],
            angle: 0.0,
        }],
    };
    let behaviour = Behaviour::Continuum(ContinuumConstants {
        law: LawName::StableNeoHookean.into(),
        young: 80e3,
        poisson: 0.4,
        discretisation: Discretisation::Tetrahedra,
        plasticity: None,
    });
    let material = Material {
        density: 1060.0,
        relaxation_time: 0.0,
        behaviour,
    };
    let body = BodySpec {
        clamps: vec![end(-1.5e-3, None), end(1.5e-3, Some(motion))],
        tear_strains: vec![(0, tear_strain)],
        ..BodySpec::new("bar", mesh, material)
    };
    SceneSpec::new(vec![body], Method::ImplicitEuler(newton))
}

/// A tick of a power of two \[s\], by which a budget is divided and multiplied without rounding.
const EXACT: f64 = 0.0078125;

/// The budget of a tick of [`EXACT`] in which a single iteration fits, as more are made where forces mean nothing; and one more in a repetition.
fn budget_of_an_iteration(spec: &SceneSpec) -> WorkBudget {
    let budget = |work: f64| WorkBudget {
        tick: work / EXACT,
        mean: f64::INFINITY,
    };
    // One is made in any case.
    let alone = SceneSpec {
        budget: Some(budget(1e-12)),
        repeat_invalid: false,
        ..spec.clone()
    };
    let report = Scene::new(&alone).unwrap().tick(&[], EXACT, 1, &Serial);
    let solver = report.unwrap().solver;
    assert_eq!(solver.iterations, 1);
    budget(2.0 * solver.work)
}

/// What is left: two halves with their 8 nodes each, so that no face of a whole element was opened.
fn assert_halves(scene: &Scene) {
    let body = &scene.bodies[0];
    let measures = check(&body.mesh, body.topology.as_ref().unwrap()).unwrap();
    assert_eq!((measures.parts, body.mesh.positions.len()), (2, 16));
}

/// Stretched 21 times while whole elements are as at rest: the mean of both sides, 11, would open the faces between them, for which 21 times 50 µm of
/// tissue have stored next to nothing. Nothing happens up to the strain that tissue bears. What the shreds held together is the section, 1 mm².
#[test]
fn a_shred_ruptures_and_does_not_tear_what_it_hangs_on() {
    let mut scene = Scene::new(&bar(0.0, 3.0, Newton::default())).unwrap();
    let torn = |scene: &mut Scene, by: f64| {
        let rest = scene.bodies[0].mesh.positions.clone();
        for (now, rest) in scene.state.bodies[0].positions.iter_mut().zip(rest) {
            *now = rest + Vector3::x() * if rest.x > 0.0 { by } else { 0.0 };
        }
        let mut torn = TornBodies::default();
        scene.tear_bodies(&mut torn);
        torn.reports()
    };
    assert_eq!(torn(&mut scene, 0.14e-3), []);
    let found = torn(&mut scene, 1e-3);
    let [found] = &found[..] else {
        panic!("{found:?}")
    };
    assert!(found.valid && found.pieces == [1], "{found:?}");
    assert!((found.area - 1e-6).abs() < 1e-15, "{}", found.area);
    assert!((found.rest_normal[0].abs() - 1.0).abs() < 1e-9);
    assert_halves(&scene);
    assert_eq!(torn(&mut scene, 1e-3), []);
}

/// Two elements on one face, of 3 and 1 mm in height, the lower of which is stretched: of volumes 3 : 1 the mean square over both is (3 + λ²) / 4. It bears up to 4, that is up
/// to λ = √61 = 7.81; the plain mean would be 4 at 7.
#[test]
fn a_face_tears_by_the_mean_square_over_both_sides() {
    let positions = [
        [0.0, 0.0, 0.0],
        [1e-3, 0.0, 0.0],
        [0.0, 1e-3, 0.0],
        [0.0, 0.0, 3e-3],
        [0.0, 0.0, -1e-3],
    ];
    let positions = positions.map(Vector3::from).to_vec();
    let mesh = TetMesh::new(positions, vec![[0, 1, 2, 3], [0, 2, 1, 4]], vec![0; 2]);
    let whole = bar(0.0, 3.0, Newton::default());
    let body = BodySpec {
        tear_strains: vec![(0, 3.0)],
        ..BodySpec::new("two", mesh, whole.bodies[0].materials[0].1)
    };
    let spec = SceneSpec::new(vec![body], whole.method);
    for (stretch, tears) in [(7.5, false), (7.8, false), (7.82, true)] {
        let mut scene = Scene::new(&spec).unwrap();
        scene.state.bodies[0].positions[4].z = -1e-3 * stretch;
        let mut torn = TornBodies::default();
        scene.tear_bodies(&mut torn);
        assert_eq!(!torn.reports().is_empty(), tears, "{stretch}");
    }
}

/// One iteration of Newton's method, as no more fit in the budget, for 2.3 mm in one tick: its forces mean nothing, and shreds fail in what it finds. Without them the tick is valid, with what they laid
/// open; a state that was saved before goes on alike. A scene that must not repeat takes nothing away.
#[test]
fn a_tick_that_means_nothing_is_repeated_without_the_shreds_that_fail() {
    let once = Newton {
        iterations: 1,
        tolerance: 1e-6,
        must_converge: false,
    };
    let mut spec = bar(3e-3, 0.5, once);
    spec.budget = Some(budget_of_an_iteration(&spec));
    let mut scene = Scene::new(&spec).unwrap();
    let mut other = Scene::new(&spec).unwrap();
    other.restore(&scene.save()).unwrap();
    let report = scene.tick(&[], EXACT, 1, &Serial).unwrap();
    assert!(report.valid && report.recoveries.is_empty(), "{report:?}");
    assert_eq!((report.ruptured, report.repetitions), (6, 1));
    let [torn] = &report.cuts[..] else {
        panic!("{:?}", report.cuts)
    };
    assert!(torn.valid && torn.tool.is_none(), "{torn:?}");
    // Never more than the section; less, as fibres lean while the bar gets thinner.
    assert!(torn.area > 0.0 && torn.area <= 1e-6, "{}", torn.area);
    assert_halves(&scene);
    assert_eq!(other.tick(&[], EXACT, 1, &Serial).unwrap(), report);
    assert_eq!(scene.digest(), other.digest());
    let mut saved = Scene::new(&spec).unwrap();
    saved.restore(&scene.save()).unwrap();
    assert_eq!(saved.digest(), scene.digest());
    let mut never = Scene::new(&SceneSpec {
        repeat_invalid: false,
        ..spec
    })
    .unwrap();
    let report = never.tick(&[], EXACT, 1, &Serial).unwrap();
    assert_eq!(
        (report.valid, report.ruptured, report.repetitions),
        (false, 0, 0)
    );
}
