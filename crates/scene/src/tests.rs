//! The strip under a probe: contact, balance of forces, same bits, saving.

use crate::*;
use microsim_mesh::{Block, CellSplit};
use microsim_tissue::{Behaviour, Newton, SpringConstants};
use nalgebra::{UnitQuaternion, Vector3};

mod boundary;
mod cutting;
mod forces;
mod hard;
mod irrigation;
mod layers;
mod limits;
mod placements;
mod residual;
mod response;
mod stretch;
mod tearing;

const TICK: f64 = 8e-3;
const RADIUS: f64 = 0.5e-3;
const TOP: f64 = 0.5e-3;

/// The reference scene: a strip of 20 × 4 × 1 mm, clamped at both ends, and a probe that stands on it or lies across it.
fn strip(cells: [usize; 3], lying: bool) -> SceneSpec {
    let reach = if lying {
        ([0.0, -4e-3, 0.0], [0.0, 4e-3, 0.0])
    } else {
        ([0.0; 3], [0.0, 0.0, 20e-3])
    };
    let end = |x: f64| ClampSpec {
        nodes: Selection::Box(BoxSpec {
            min: [x, -1.0, -1.0],
            max: [x, 1.0, 1.0],
        }),
        motion: None,
        release: None,
    };
    let block = Block {
        center: [0.0; 3],
        size: [20e-3, 4e-3, 1e-3],
        cells,
        split: CellSplit::Kuhn,
    };
    SceneSpec {
        tools: vec![ToolSpec {
            name: "probe".into(),
            capsules: vec![CapsuleSpec::new(reach.0, reach.1, RADIUS)],
            sharpness: 0.0,
            jaw_stiffness: f64::INFINITY,
            irrigation: None,
            motion: Vec::new(),
        }],
        contacts: vec![ContactSpec::new("strip", PartnerSpec::Tool("probe".into()))],
        ..SceneSpec::new(
            vec![BodySpec {
                drag: 100.0,
                clamps: vec![end(-10e-3), end(10e-3)],
                ..BodySpec::new(
                    "strip",
                    block.mesh().unwrap(),
                    Material {
                        density: 1060.0,
                        relaxation_time: 0.0,
                        behaviour: Behaviour::Springs(SpringConstants::scaled(25e3, 5e4)),
                    },
                )
            }],
            Method::StoermerVerlet,
        )
    }
}

/// The probe's axis end at `depth` \[m\] of its lowest point below the top of the strip at rest, a little off any symmetry.
fn pose(depth: f64) -> Pose {
    Pose {
        position: Vector3::new(0.13e-3, 0.07e-3, TOP + RADIUS - depth),
        orientation: UnitQuaternion::identity(),
    }
}

fn push(from: f64, to: f64) -> ToolMotion {
    ToolMotion {
        tool: 0,
        from: pose(from),
        to: pose(to),
        opening_from: 0.0,
        opening_to: 0.0,
        active: true,
    }
}

/// Depth after `k` ticks of 8 ms: from 0.2 mm above the top, 12.5 mm/s down to 1.2 mm, then still.
fn depth(k: usize) -> f64 {
    (-0.2e-3 + 1e-4 * k as f64).min(1.2e-3)
}

fn run(scene: &mut Scene, ticks: std::ops::Range<usize>, exec: &dyn Executor) -> Vec<TickReport> {
    let steps = scene.required_steps(TICK);
    ticks
        .map(|k| {
            scene
                .tick(&[push(depth(k), depth(k + 1))], TICK, steps, exec)
                .unwrap()
        })
        .collect()
}

fn momentum(scene: &Scene) -> Vector3<f64> {
    scene
        .body(0)
        .velocities()
        .iter()
        .zip(scene.body(0).masses())
        .map(|(v, m)| v * *m)
        .sum()
}

#[test]
fn no_surface_node_is_ever_inside_the_probe() {
    for lying in [false, true] {
        let mut scene = Scene::new(&strip([10, 2, 1], lying)).unwrap();
        let steps = scene.required_steps(TICK);
        let h = TICK / f64::from(steps);
        let reach = if lying {
            Vector3::y() * 4e-3
        } else {
            Vector3::zeros()
        };
        let (mut at, mut touched) = (-0.1e-3, false);
        // One step per tick, so that every step is looked at: 12.5 mm/s down by 1.1 mm.
        while at < 1e-3 {
            let next = at + 12.5e-3 * h;
            let report = scene.tick(&[push(at, next)], h, 1, &Serial).unwrap();
            at = next;
            touched |= !report.contacts.is_empty();
            let centre = pose(at).position;
            let top = if lying { reach } else { Vector3::z() * 20e-3 };
            let probe = microsim_geometry::Capsule {
                a: centre - reach,
                b: centre + top,
                radius: RADIUS,
            };
            for &node in &scene.body(0).surface().nodes {
                let distance = probe.signed_distance(&scene.body(0).positions()[node as usize]);
                assert!(
                    distance > -1e-12 * RADIUS,
                    "lying {lying}, depth {at}: node {node} at {distance}"
                );
            }
            for contact in &report.contacts {
                assert!(
                    contact.max_depth_m < 1e-3 * RADIUS,
                    "{}",
                    contact.max_depth_m
                );
            }
        }
        assert!(touched);
    }
}

#[test]
fn at_rest_the_probe_carries_what_clamps_and_weight_do_not() {
    for lying in [false, true] {
        let mut scene = Scene::new(&strip([10, 2, 1], lying)).unwrap();
        let reports = run(&mut scene, 0..60, &Serial);
        assert!(
            reports[..2].iter().all(|r| r.contacts.is_empty()),
            "it starts above the strip"
        );
        let before = momentum(&scene);
        let report = run(&mut scene, 60..61, &Serial).remove(0);
        let contact = &report.contacts[0];
        let force = Vector3::from(contact.force_on_tissue);

        // Balance: contact + weight = what the clamps hold + dP/dt + drag.
        let weight = Vector3::from([0.0, 0.0, -9.81]) * scene.body(0).masses().iter().sum::<f64>();
        let forces = scene.body(0).forces();
        let held: Vector3<f64> = forces
            .iter()
            .zip(scene.body(0).clamped())
            .filter(|(_, clamped)| *clamped)
            .map(|(f, _)| f)
            .sum();
        let unsettled = (momentum(&scene) - before).norm() / TICK + 100.0 * momentum(&scene).norm();
        let size: f64 = forces.iter().map(|f| f.norm()).sum();
        let error = (force + weight - held).norm();
        // Forces of a strip at rest are known to the rounding of positions: ε·reach over the shortest edge strains.
        let rounding = size * f64::EPSILON * (20e-3 / 1e-3) * 100.0;
        assert!(
            error <= unsettled + rounding,
            "lying {lying}: {error} N, unsettled {unsettled}, rounding {rounding}"
        );
        assert!(unsettled < 1e-3 * force.norm(), "{unsettled} {force}");

        // It pushes down, at the probe, by the depth.
        assert!(
            force.z < -3e-4 && force.xy().norm() < 0.2 * force.norm(),
            "{force}"
        );
        assert!((contact.impulse_ns / (force.norm() * TICK) - 1.0).abs() < 1e-2);
        assert!((contact.peak_force_n / force.norm() - 1.0).abs() < 1e-2);
        assert!(
            (contact.point[0] - 0.13e-3).abs() < RADIUS && contact.point[1].abs() < RADIUS,
            "{:?}",
            contact.point
        );
        assert!(
            (contact.indentation_m - depth(60)).abs() < 0.3 * RADIUS,
            "{}",
            contact.indentation_m
        );
    }
}

#[test]
fn impulse_is_the_momentum_that_a_free_body_takes() {
    let mut spec = strip([6, 2, 1], true);
    spec.bodies[0].clamps.clear();
    spec.bodies[0].drag = 0.0;
    spec.gravity = [0.0; 3];
    let mut scene = Scene::new(&spec).unwrap();
    let steps = scene.required_steps(TICK);
    scene.tick(&[], TICK, steps, &Serial).unwrap();
    let report = scene
        .tick(&[push(-0.2e-3, 0.3e-3)], TICK, steps, &Serial)
        .unwrap();
    let impulse = Vector3::from(report.contacts[0].force_on_tissue) * TICK;
    let taken = momentum(&scene);
    assert!(taken.z < 0.0);
    // Internal forces cancel to rounding in each of the steps.
    assert!(
        (impulse - taken).norm() < 1e-10 * taken.norm(),
        "{impulse} {taken}"
    );
}

#[test]
fn the_strip_comes_back_when_the_probe_leaves() {
    let mut scene = Scene::new(&strip([10, 2, 1], false)).unwrap();
    let steps = scene.required_steps(TICK);
    for _ in 0..60 {
        scene.tick(&[], TICK, steps, &Serial).unwrap();
    }
    let sagged = scene.body(0).positions().to_vec();
    assert!((scene.body(0).volume() / 80e-9 - 1.0).abs() < 0.01);
    run(&mut scene, 0..30, &Serial);
    for k in 0..90 {
        let (from, to) = (
            depth(30) - 1e-4 * k as f64,
            depth(30) - 1e-4 * (k + 1) as f64,
        );
        scene.tick(&[push(from, to)], TICK, steps, &Serial).unwrap();
    }
    // The slowest mode decays with e^(−ct/2), c = 100/s: after 0.5 s less than e^(−25) is left.
    for (now, then) in scene.body(0).positions().iter().zip(&sagged) {
        assert!((now - then).norm() < 1e-9 * 20e-3);
    }
}

/// Two threads that take the parts in turn.
struct TwoThreads;

impl Executor for TwoThreads {
    fn for_each(&self, parts: usize, body: &(dyn Fn(usize) + Sync)) {
        std::thread::scope(|scope| {
            scope.spawn(|| (0..parts).skip(1).step_by(2).for_each(body));
            (0..parts).step_by(2).for_each(body);
        });
    }
}

#[test]
fn threads_do_not_change_a_bit_of_state_or_report() {
    // 4800 elements: enough that forces are computed in parts.
    let spec = strip([40, 10, 2], false);
    let results = [&Serial as &dyn Executor, &TwoThreads].map(|exec| {
        let mut scene = Scene::new(&spec).unwrap();
        // Short ticks: what matters is contact under both executors.
        let reports: Vec<TickReport> = (0..6)
            .map(|k| {
                let depth = |k: i32| 5e-5 * f64::from(k);
                let steps = scene.required_steps(TICK / 10.0);
                scene
                    .tick(&[push(depth(k), depth(k + 1))], TICK / 10.0, steps, exec)
                    .unwrap()
            })
            .collect();
        assert!(!reports[5].contacts.is_empty());
        (scene.save(), reports)
    });
    assert_eq!(results[0], results[1]);
}

#[test]
fn saved_restored_and_continued_gives_the_same_bytes() {
    let spec = strip([10, 2, 1], true);
    let mut straight = Scene::new(&spec).unwrap();
    run(&mut straight, 0..20, &Serial);
    let bytes = straight.save();
    let straight_reports = run(&mut straight, 20..30, &Serial);

    let mut continued = Scene::new(&spec).unwrap();
    continued.restore(&bytes).unwrap();
    assert_eq!(continued.save(), bytes);
    let reports = run(&mut continued, 20..30, &Serial);
    assert_eq!(reports, straight_reports);
    assert_eq!(continued.save(), straight.save());
    assert!((continued.time() - 30.0 * TICK).abs() < 1e-12);

    continued.reset();
    assert_eq!(continued.save(), Scene::new(&spec).unwrap().save());
}

#[test]
fn damaged_bytes_are_refused_and_change_nothing() {
    let spec = strip([4, 1, 1], false);
    let mut scene = Scene::new(&spec).unwrap();
    run(&mut scene, 0..8, &Serial);
    let bytes = scene.save();
    let mut other = Scene::new(&spec).unwrap();
    let untouched = other.save();
    for length in 0..bytes.len() {
        assert!(other.restore(&bytes[..length]).is_err(), "{length}");
    }
    let longer = [bytes.as_slice(), &[0]].concat();
    assert_eq!(other.restore(&longer), Err(RestoreError::Length));
    let mut version = bytes.clone();
    version[4] = 255;
    assert_eq!(
        other.restore(&version),
        Err(RestoreError::Version { found: 255 })
    );
    let mut not_finite = bytes.clone();
    not_finite[8..16].copy_from_slice(&f64::NAN.to_le_bytes());
    assert_eq!(other.restore(&not_finite), Err(RestoreError::NotFinite));
    assert_eq!(
        Scene::new(&strip([5, 1, 1], false))
            .unwrap()
            .restore(&bytes),
        Err(RestoreError::OtherScene)
    );
    assert_eq!(other.save(), untouched);
}

#[test]
fn accessors_agree_with_the_description() {
    let scene = Scene::new(&strip([20, 4, 1], false)).unwrap();
    assert_eq!((scene.body_count(), scene.body(0).name()), (1, "strip"));
    assert_eq!((scene.tool_count(), scene.tool_name(0)), (1, "probe"));
    assert_eq!(
        (
            scene.body(0).positions().len(),
            scene.body(0).element_count()
        ),
        (21 * 5 * 2, 20 * 4 * 6)
    );
    assert_eq!(
        (
            scene.body(0).node_ids().len(),
            scene.body(0).element_ids().len()
        ),
        (210, 480)
    );
    assert_eq!(scene.body(0).clamped().iter().filter(|c| **c).count(), 20);
    assert_eq!(
        scene.body(0).surface().triangles.len(),
        4 * (20 * 4 + 4 + 20)
    );
    assert_eq!(scene.body(0).generation(), 0);
    // ρV = 1060 kg/m³ · 80 mm³.
    assert!((scene.body(0).masses().iter().sum::<f64>() / 84.8e-6 - 1.0).abs() < 1e-12);
    assert!((scene.body(0).volume() / 80e-9 - 1.0).abs() < 1e-12);
    assert!(scene.body(0).energies().total() < 1e-25, "at rest");
}
