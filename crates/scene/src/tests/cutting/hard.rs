//! Hard cases of cutting: explicit methods in viscous tissue, a cut that is not made, what still reaches into tissue, restoring where nothing was
//! cut since.

use super::*;
use microsim_geometry::{closest_segment_triangle, point_in_tetrahedron};
use microsim_random::Congruential;
use nalgebra::UnitQuaternion;

/// Numbers from −1 to 1.
fn numbers() -> impl FnMut() -> f64 {
    let mut random = Congruential(7);
    move || random.number()
}

/// A blade that goes down somewhere, turned anyhow about z and a little about the others.
fn anywhere(next: &mut impl FnMut() -> f64) -> ToolMotion {
    let turn = Vector3::new(0.5 * next(), 0.5 * next(), 3.0 * next());
    let (x, y) = (2e-3 * next(), 5e-4 * next());
    let pose = |z| Pose {
        position: Vector3::new(x, y, z),
        orientation: UnitQuaternion::from_scaled_axis(turn),
    };
    ToolMotion {
        from: pose(1.5e-3),
        to: pose(1e-3 * next()),
        ..down(0.0, [0.0; 2], [0.0; 2])
    }
}

/// A bar that moves, of viscous tissue with drag, cut at random again and again: each explicit method stays within its limit for 2,000 steps.
#[test]
fn explicit_methods_stay_stable_after_cuts_of_viscous_tissue() {
    const SPEED: f64 = 0.01;
    let methods = [
        Method::StoermerVerlet,
        Method::SymplecticEuler,
        Method::VelocityVerlet,
        Method::VelocityVerletLagged,
    ];
    for method in methods {
        let mut bar = bar(Discretisation::Tetrahedra, 5e-3);
        bar.start = vec![StartSpec {
            nodes: Selection::All,
            matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            pivot: [0.0; 3],
            shift: [0.0; 3],
            velocity: [0.0, SPEED, 0.0],
        }];
        let blade = tool("blade", 0.0, vec![line(1e-4, None)]);
        let mut scene = Scene::new(&spec(bar, blade, false, method)).unwrap();
        let tick = 20.0 * scene.body(0).stable_step();
        let steps = scene.required_steps(tick);
        let mut next = numbers();
        for index in 0..100 {
            let motion = anywhere(&mut next);
            let motions: &[ToolMotion] = if index < 30 { &[motion] } else { &[] };
            scene.tick(motions, tick, steps, &Serial).unwrap();
        }
        let CutTally { divided, .. } = scene.body(0).cut_tally();
        let floored = scene.body(0).model().added_inertia().iter();
        let floored = floored.filter(|added| **added > 0.0).count();
        assert!(divided > 500 && floored > 50, "{divided} {floored}");
        // Nothing drives it: in waves that meet, velocities add up, and viscosity takes them away.
        let speeds = scene.body(0).velocities().iter().map(|v| v.norm());
        let fastest = speeds.fold(0.0, f64::max);
        assert!(fastest < 3.0 * SPEED, "{}: {fastest} m/s", method.name());
    }
}

/// A stretch of jaws that could not be cut, as a node near it was nowhere, is cut with the next one: nothing is left behind.
#[test]
fn what_was_not_cut_is_cut_in_the_next_tick() {
    let left_behind = |fails: Option<usize>| {
        let jaws = tool(
            "jaws",
            1.0,
            vec![jaw(8e-3, 1.0, Jaw::Left), jaw(8e-3, -1.0, Jaw::Right)],
        );
        let mut body = bar(Discretisation::Tetrahedra, 5e-3);
        // Thinner than what jaws that meet reach across.
        let thin = Block {
            center: [0.0; 3],
            size: [6e-3, 2e-3, 3e-4],
            cells: [12, 4, 1],
            split: CellSplit::Kuhn,
        };
        body.mesh = thin.mesh().unwrap();
        let of = spec(body, jaws, true, Method::ImplicitEuler(NEWTON));
        let mut scene = Scene::new(&of).unwrap();
        let loads = crate::lonor::EdgeLoads::default();
        let mut rejections = 0;
        for k in 0..40 {
            let opening = |k: usize| 1.0 - k as f64 / 40.0;
            let motion = down(0.3e-3, [0.0; 2], [opening(k), opening(k + 1)]);
            let before = scene.state.bodies.clone();
            if fails == Some(k) {
                let good = scene.state.bodies.clone();
                for place in &mut scene.state.bodies[0].positions {
                    place.x = f64::NAN;
                }
                let (cuts, rejected) = scene.cut(&[motion], &before, &loads, &[], TICK, true);
                rejections += rejected.len();
                assert!(cuts.is_empty());
                scene.state.bodies = good;
            } else {
                scene.cut(&[motion], &before, &loads, &[], TICK, true);
            }
        }
        (scene.body(0).piece_count(), rejections)
    };
    assert_eq!(left_behind(None), (2, 0));
    let mut rejected = 0;
    for k in 0..40 {
        let (pieces, rejections) = left_behind(Some(k));
        // The last stretch has none after it.
        if k + 1 < 40 {
            assert_eq!(pieces, 2, "tick {k}");
        }
        rejected += rejections;
    }
    assert!(rejected > 5, "{rejected}");
}

/// Which parts of a tool reach into a body is the same as when every triangle and every element is looked at.
#[test]
fn what_reaches_into_tissue_is_what_a_look_at_all_of_it_finds() {
    let short = |x: f64| CapsuleSpec {
        a: [x, -3e-4, 0.0],
        b: [x, 3e-4, 0.0],
        ..line(1e-4, Some([0.0, 0.0, -1.0]))
    };
    let capsules = vec![short(-1e-3), short(0.0), line(1e-4, None), short(1e-3)];
    let body = bar(Discretisation::Tetrahedra, 0.0);
    let blade = tool("blade", 0.5, capsules);
    let mut scene = Scene::new(&spec(body, blade, false, Method::StoermerVerlet)).unwrap();
    let (mut next, mut found) = (numbers(), [0; 2]);
    for index in 0..300 {
        if index % 30 == 10 {
            let motion = anywhere(&mut next);
            let before = scene.state.bodies.clone();
            let loads = crate::lonor::EdgeLoads::default();
            scene.cut(&[motion], &before, &loads, &[], TICK, true);
        }
        let shift = Vector3::from_fn(|_, _| 1e-3 * next());
        for place in &mut scene.state.bodies[0].positions {
            *place += shift * 0.1 + Vector3::from_fn(|_, _| 2e-5 * next());
        }
        let motion = anywhere(&mut next);
        let edges = [0, 1, 3];
        let reaching = scene.reaching(0, &motion, &edges);
        let (positions, mesh) = (scene.body(0).positions(), scene.body(0).mesh());
        let corners = |tet: &[u32; 4]| tet.map(|node| positions[node as usize]);
        let lines = scene.tools[0].lines(&motion, 1.0);
        let expected = edges.into_iter().filter(|edge| {
            let line = lines.iter().find(|line| line.capsule == *edge).unwrap();
            let near = |triangle: &[u32; 3]| {
                let triangle = triangle.map(|node| positions[node as usize]);
                closest_segment_triangle(&line.a, &line.b, &triangle).distance() < line.radius
            };
            // What is near no triangle is inside with its whole length, or outside.
            scene.body(0).surface().triangles.iter().any(near)
                || mesh
                    .tets
                    .iter()
                    .any(|tet| point_in_tetrahedron(&line.a, &corners(tet)).is_some())
        });
        let expected: Vec<u32> = expected.collect();
        assert_eq!(reaching, expected, "{index}");
        found[0] += reaching.len();
        found[1] += edges.len() - reaching.len();
    }
    assert!(scene.body(0).cut_tally().divided > 100);
    assert!(found.iter().all(|count| *count > 100), "{found:?}");
}

/// A save restored into the scene that made it, which has moved on without an edit since, goes on with the same bits.
#[test]
fn a_scene_that_was_not_cut_since_goes_back() {
    for (method, touches) in [
        (Method::StoermerVerlet, false),
        (Method::ImplicitEuler(NEWTON), true),
    ] {
        let capsules = match touches {
            true => vec![jaw(8e-3, 1.0, Jaw::Left), jaw(8e-3, -1.0, Jaw::Right)],
            false => vec![line(1e-4, None)],
        };
        let body = bar(Discretisation::Tetrahedra, 5e-3);
        let of = spec(body, tool("tool", 1.0, capsules), touches, method);
        let mut scene = Scene::new(&of).unwrap();
        let tick = match touches {
            true => 4e-3,
            false => 20.0 * scene.body(0).stable_step(),
        };
        let steps = scene.required_steps(tick).max(2);
        let go = |scene: &mut Scene, ticks: std::ops::Range<usize>| {
            for k in ticks {
                // Slowly where they close around the bar, which is from 0.114 to 0.089.
                let left = |k: usize| match k {
                    0..40 => 1.0 - 0.02 * k as f64,
                    _ => 0.2 - 0.004 * (k - 40) as f64,
                };
                let motion = match touches {
                    true => down(1.6e-3, [0.0; 2], [left(k), left(k + 1)]),
                    false => {
                        let height = |k| 1e-3 - 5e-5 * k as f64;
                        down(0.3e-3, [height(k), height(k + 1)], [0.0; 2])
                    }
                };
                scene.tick(&[motion], tick, steps, &Serial).unwrap();
            }
        };
        // Into the cut.
        let mut middle = 0;
        while scene.body(0).generation() < 1 {
            go(&mut scene, middle..middle + 1);
            middle += 1;
            assert!(middle < 68, "{}", method.name());
        }
        let saved = scene.save();
        go(&mut scene, middle..middle + 8);
        let expected = scene.save();
        scene.restore(&saved).unwrap();
        // On without a cut: nothing that follows cuts is rebuilt.
        let edits = scene.edits.len();
        for _ in 0..3 {
            scene.tick(&[], tick, steps, &Serial).unwrap();
        }
        assert_eq!(scene.edits.len(), edits);
        assert!(scene.save() != saved);
        scene.restore(&saved).unwrap();
        assert!(scene.save() == saved);
        go(&mut scene, middle..middle + 8);
        assert!(scene.edits.len() > edits);
        assert!(scene.save() == expected, "{}", method.name());
    }
}
