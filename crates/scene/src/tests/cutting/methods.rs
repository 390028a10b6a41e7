//! The dissertation's own methods: changes of topology, cutting by penetration, lines beside the axis, grip by a box.

use super::*;
use crate::spec::{ContactResponse, CutTrigger, Grip};
use microsim_contact::Depth;
use microsim_cutting::TopologyChange;

const CHANGES: [TopologyChange; 4] = [
    TopologyChange::Remove,
    TopologyChange::SplitAtFaces,
    TopologyChange::SemiProgressive,
    TopologyChange::Progressive,
];

/// The bar under a blade that lines go through, with a change of topology.
fn cut_by(topology: TopologyChange) -> SceneSpec {
    let body = bar(Discretisation::EdgeSmoothed, 0.0);
    let blade = tool("blade", 0.0, vec![line(5e-5, None)]);
    SceneSpec {
        cuts: vec![CutSpec {
            topology,
            ..cut("blade")
        }],
        ..spec(body, blade, false, Method::StoermerVerlet)
    }
}

/// A blade at x = 0.37 mm goes through the cells from 0 to 0.5 mm. With each change two pieces are left on a valid mesh; all that is missing is the layer of 0.5 · 2 · 1
/// mm³ that removal takes.
#[test]
fn each_change_of_topology_leaves_two_pieces_of_what_is_left() {
    for topology in CHANGES {
        let mut scene = Scene::new(&cut_by(topology)).unwrap();
        through(&mut scene, 0.37e-3, 20);
        let body = &scene.bodies[0];
        check(&body.mesh, body.topology.as_ref().unwrap()).unwrap();
        assert_eq!(scene.body(0).piece_count(), 2, "{topology:?}");
        let volume: f64 = body.mesh.volumes().iter().sum();
        let lost = if topology == TopologyChange::Remove {
            1e-9
        } else {
            0.0
        };
        assert!(
            (volume + lost - 12e-9).abs() < 1e-20,
            "{topology:?} {volume}"
        );
        assert!(
            (body.tally.lost_volume - lost).abs() < 1e-20,
            "{topology:?}"
        );
    }
}

/// What waits is part of what is saved: restored in the middle of a cut, a scene goes on with the same bits. A blade that is taken away leaves nothing waiting.
#[test]
fn a_cut_that_waits_is_saved() {
    let fresh = || Scene::new(&cut_by(TopologyChange::SemiProgressive)).unwrap();
    let mut scene = fresh();
    let steps = scene.required_steps(1e-3);
    let motion = |k: usize| {
        let height = |k: usize| 1e-3 - 1e-4 * k as f64;
        [down(0.37e-3, [height(k), height(k + 1)], [0.0; 2])]
    };
    let waits = |scene: &Scene| {
        let strokes = scene.state.blades[0].strokes.iter();
        strokes
            .map(|(_, stroke)| stroke.waiting.len())
            .sum::<usize>()
    };
    let mut most = (0, 0, Vec::new());
    for k in 0..12 {
        scene.tick(&motion(k), 1e-3, steps, &Serial).unwrap();
        if waits(&scene) > most.0 {
            most = (waits(&scene), k + 1, scene.save());
        }
    }
    let (count, from, saved) = most;
    assert!(count > 0, "nothing waits");
    let mut again = fresh();
    again.restore(&saved).unwrap();
    assert_eq!(again.save(), saved);
    for k in from..12 {
        again.tick(&motion(k), 1e-3, steps, &Serial).unwrap();
    }
    assert_eq!(again.digest(), scene.digest());
    assert!(waits(&scene) > 0);
    scene.tick(&[], 1e-3, steps, &Serial).unwrap();
    assert_eq!(waits(&scene), 0);
}

/// A capsule of one jaw alone that comes down on a bar which nothing moves: the height of its axis \[m\] at the end of the tick in which it cuts first.
fn first_cut(trigger: CutTrigger, offset: Option<[f64; 3]>) -> Option<f64> {
    let mut body = bar(Discretisation::EdgeSmoothed, 0.0);
    // All of it but its end.
    body.clamps[0].nodes = Selection::Box(BoxSpec {
        min: [-3e-3, -1.0, -1.0],
        max: [2.4e-3, 1.0, 1.0],
    });
    let capsule = CapsuleSpec {
        lonor_offset: offset,
        ..line(1.2e-4, None)
    };
    let mut of = spec(
        body,
        tool("jaw", 0.5, vec![capsule]),
        true,
        Method::StoermerVerlet,
    );
    let depth = Depth::Nearest;
    of.contacts[0].friction = 0.0;
    of.contacts[0].response = ContactResponse::Penalty {
        stiffness: 1.0,
        depth,
    };
    of.cuts[0].trigger = trigger;
    let mut scene = Scene::new(&of).unwrap();
    let steps = scene.required_steps(1e-3);
    let height = |k: usize| 0.7e-3 - 1e-5 * k as f64;
    (0..40).find_map(|k| {
        let motion = down(0.37e-3, [height(k), height(k + 1)], [0.0; 2]);
        let report = scene.tick(&[motion], 1e-3, steps, &Serial).unwrap();
        let divided = scene.bodies[0].mesh.generation > 0;
        assert!(report.valid);
        divided.then(|| height(k + 1))
    })
}

/// The bar's top is at 0.5 mm. By penetration what passes the line is cut, wherever it lies in the capsule; the force of a line without an edge cuts nothing.
#[test]
fn one_jaw_cuts_what_passes_its_line() {
    let near = |found: Option<f64>, expected: f64| {
        // The tick in which the line passes, of 10 µm.
        let found = found.expect("a cut");
        assert!((found - expected).abs() <= 1.01e-5, "{found} {expected}");
    };
    near(first_cut(CutTrigger::Penetration, None), 0.5e-3);
    near(
        first_cut(CutTrigger::Penetration, Some([0.0, 0.0, -8e-5])),
        0.58e-3,
    );
    near(
        first_cut(CutTrigger::Penetration, Some([0.0, 0.0, 8e-5])),
        0.42e-3,
    );
    assert_eq!(first_cut(CutTrigger::Force, None), None);
}

/// Whether a free bar that is thrown up with a `speed` \[m/s\] under `gravity` \[m/s²\] is cut by a line 5 µm above its top within a tick of 1 ms.
fn is_cut_when_thrown(speed: f64, gravity: f64) -> bool {
    let mut body = bar(Discretisation::EdgeSmoothed, 0.0);
    body.clamps.clear();
    body.drag = 0.0;
    body.start = vec![StartSpec {
        nodes: Selection::All,
        matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        pivot: [0.0; 3],
        shift: [0.0; 3],
        velocity: [0.0, 0.0, speed],
    }];
    let blade = tool("jaw", 0.5, vec![line(1.2e-4, None)]);
    let mut of = spec(body, blade, true, Method::StoermerVerlet);
    let depth = Depth::Nearest;
    of.gravity = [0.0, 0.0, -gravity];
    of.contacts[0].friction = 0.0;
    of.contacts[0].response = ContactResponse::Penalty {
        stiffness: 1e-3,
        depth,
    };
    of.cuts[0].trigger = CutTrigger::Penetration;
    let mut scene = Scene::new(&of).unwrap();
    let steps = scene.required_steps(1e-3);
    let motion = down(0.37e-3, [0.505e-3; 2], [0.0; 2]);
    let report = scene.tick(&[motion], 1e-3, steps, &Serial).unwrap();
    assert!(report.valid);
    // Both end 10 µm higher, past the line: v t − g t² / 2, and so does all of the bar, which nothing deforms.
    let risen = scene.body(0).positions()[0].z - scene.body(0).rest_positions()[0].z;
    assert!((risen - 1e-5).abs() < 5e-7, "{risen}");
    scene.bodies[0].mesh.generation > 0
}

/// Tissue that has passed a line and goes on is cut; what moves back at the end of the tick is not (case 2: the rule of the velocities' sign).
#[test]
fn tissue_that_returns_over_a_line_is_not_cut() {
    assert!(is_cut_when_thrown(0.01, 0.0));
    assert!(!is_cut_when_thrown(0.06, 100.0));
}

/// What cannot be is refused with the reason.
#[test]
fn grips_that_cannot_be_are_refused() {
    let refused = |capsules: Vec<CapsuleSpec>, method: Method| {
        let body = bar(Discretisation::EdgeSmoothed, 0.0);
        let mut of = spec(body, tool("jaws", 0.0, capsules), true, method);
        of.cuts.clear();
        of.contacts[0].grip = Grip::Box;
        Scene::new(&of).expect_err("refused").to_string()
    };
    let jaws = || vec![jaw(2e-3, 1.0, Jaw::Left), jaw(2e-3, -1.0, Jaw::Right)];
    let one = refused(vec![line(5e-5, None)], Method::StoermerVerlet);
    assert!(one.contains("each of two jaws"), "{one}");
    let implicit = refused(jaws(), Method::ImplicitEuler(NEWTON));
    assert!(implicit.contains("explicit methods but"), "{implicit}");
}
