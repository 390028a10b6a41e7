//! The contract of the module, in-process and without files or physics: snapshots and forces in, the verdict out. The
//! host moves the module to a fresh instance in every tick.

use microsim_module_push_strip::Module;
use microsim_sdk::message::{
    ContactForce, ContactForces, LevelControl, Pose, SolverTick, TISSUE_SNAPSHOT, TrainingResult,
};
use microsim_sdk::{BlockBuilder, TestHost};
use serde_json::json;

const DEPTH: f64 = 0.001;
const TOLERANCE: f64 = 0.0001;
/// Ticks of 8 ms for which a depth has to be held for 0.2 s: time counts from the first tick that holds.
const STAY: u64 = 26;

fn host() -> TestHost<Module> {
    let config = json!({
        "tools": [{ "name": "right", "model": "probe" }],
        "models": {},
        "limits": [{
            "metric": "peak-force", "min": null, "max": 0.01, "full": null, "zero": null,
            "source": "this test", "provisional": true, "decides": true, "reason": "pushed-too-hard",
        }],
        "metrics": {
            "idle_speed": 1e-4, "movement_speed": 1e-3, "smoothing": 0.05, "idle_smoothing": 0.08,
            "resample_rate": 60.0, "gap": 0.1, "shortest_path": null,
        },
        "own_metrics": [{
            "id": "peak-force", "unit": "N", "display_unit": "mN", "direction": "lower",
            "category": "tissue", "formula": "peak-force/2", "source": "this test",
            "title": { "de": "Kraft", "en": "Force" }, "advice": { "de": "-", "en": "-" },
        }],
        "reasons": [],
        "module": {
            "task": "push", "depth": DEPTH, "depth_tolerance": TOLERANCE, "dwell": 0.2, "mark_radius": 0.0011,
        },
        "objects": [
            {
                "name": "mark-1", "shape": "sphere", "radius": 0.001, "position": [0.0, 0.0, 0.001],
                "orientation": [0.0, 0.0, 0.0, 1.0], "colour": "#888888", "finish": "matte", "active": false,
            },
        ],
        "bodies": ["strip"],
    });
    let manifest = include_str!("../module.toml");
    let host = TestHost::of_module(manifest, 1, 1, config).expect("a complete set-up");
    host.moving()
}

/// A strip of two layers; the top node in the middle is pushed in by `depth`. Ids are not indices: readers must not
/// take them for such.
fn snapshot(depth: f64) -> Vec<u64> {
    let mut positions = Vec::new();
    for z in [0.0, 0.001] {
        for x in [-0.003, 0.0, 0.003] {
            let dent = if x == 0.0 && z > 0.0 { depth } else { 0.0 };
            positions.extend([x, 0.0, z - dent]);
        }
    }
    BlockBuilder::new(TISSUE_SNAPSHOT, "strip", 0, 0)
        .u32s("node_id", [10, 11, 12, 20, 21, 22])
        .f64s("position", positions)
        .u32s("triangle", [3, 4, 5])
        .finish()
}

/// Holds a depth for so many ticks under a force.
fn hold(host: &mut TestHost<Module>, depth: f64, force: f64, ticks: u64) -> Option<TrainingResult> {
    hold_computed(host, depth, force, ticks, true)
}

/// The same, with whether the computed forces mean anything.
fn hold_computed(
    host: &mut TestHost<Module>,
    depth: f64,
    force: f64,
    ticks: u64,
    valid: bool,
) -> Option<TrainingResult> {
    for _ in 0..ticks {
        host.send_block(&snapshot(depth));
        host.send_tools(&[("right", Pose::default())]);
        host.send(&SolverTick {
            valid,
            ..SolverTick::default()
        });
        host.send(&ContactForces {
            contacts: vec![ContactForce {
                partner: "right".into(),
                body: "strip".into(),
                force: [0.0, 0.6 * force, -0.8 * force],
                peak_force: force,
                sustained_force: force,
                impulse: 0.0,
                point: [0.0; 3],
                depth: 0.0,
                indentation: depth,
                ..ContactForce::default()
            }],
            ..ContactForces::default()
        });
        if let Some(result) = host.tick().expect("a good tick").last() {
            return Some(result);
        }
    }
    None
}

fn started() -> TestHost<Module> {
    let mut host = host();
    host.send(&LevelControl::Start);
    hold(&mut host, 0.0, 0.0, 1);
    host
}

#[test]
fn the_depth_held_for_long_enough_passes() {
    let mut host = started();
    let within = DEPTH - 0.9 * TOLERANCE;
    assert!(
        hold(&mut host, within, 0.005, STAY - 1).is_none(),
        "a tick too early"
    );
    let result = hold(&mut host, within, 0.005, 1).expect("the verdict");
    assert!(result.passed, "{:?}", result.failed);
}

#[test]
fn each_reason_comes_alone() {
    let mut shallow = started();
    hold(&mut shallow, DEPTH - 1.1 * TOLERANCE, 0.005, 2 * STAY);
    assert_eq!(shallow.end().failed, ["not-deep-enough"]);

    let mut short = started();
    // The tick that ends the input still sees the last snapshot.
    hold(&mut short, DEPTH, 0.005, STAY - 2);
    assert_eq!(short.end().failed, ["dwell-too-short"]);

    let mut deep = started();
    hold(&mut deep, DEPTH + 1.1 * TOLERANCE, 0.005, 2 * STAY);
    assert_eq!(
        deep.end().failed,
        ["dwell-too-short"],
        "too deep does not count as held"
    );

    let mut hard = started();
    hold(&mut hard, DEPTH / 2.0, 0.011, 1);
    let result = hold(&mut hard, DEPTH, 0.005, STAY).expect("the verdict");
    assert_eq!(result.failed, ["pushed-too-hard"]);
    let peak = result
        .metrics
        .iter()
        .find(|m| m.id == "peak-force")
        .and_then(|m| m.value);
    // The size of a force of 0.011 N along (0, 0.6, -0.8); tolerance: rounding of its root.
    assert!((peak.expect("measured") - 0.011).abs() < 1e-16);
}

#[test]
fn without_tissue_nothing_is_reached() {
    let mut host = host();
    host.send(&LevelControl::Start);
    for _ in 0..2 * STAY {
        host.send_tools(&[("right", Pose::default())]);
        host.tick().expect("a good tick");
    }
    let result = host.end();
    assert_eq!(
        (result.targets_done, result.score, result.passed),
        (0, 0.0, false)
    );
}

/// A force that means nothing decides nothing; a run with more than one such tick in fifty is neither passed nor failed.
#[test]
fn forces_that_mean_nothing_are_no_ground_for_a_verdict() {
    let mut few = started();
    hold_computed(&mut few, DEPTH / 2.0, 0.011, 1, false);
    let result = hold(&mut few, DEPTH, 0.005, STAY).expect("the verdict");
    assert!(result.passed, "{:?}", result.failed);
    let peak = result.metrics.iter().find(|m| m.id == "peak-force");
    assert!(peak.and_then(|m| m.value).expect("measured") < 0.006);

    for force in [0.005, 0.011] {
        let mut many = started();
        hold_computed(&mut many, DEPTH, force, STAY / 4, false);
        let result = hold(&mut many, DEPTH, force, STAY).expect("the end");
        assert!(!result.passed && result.failed.is_empty() && result.reasons.is_empty());
        assert_eq!(result.not_judged.len(), 1);
    }
}

/// Forces are taken only with the report that they mean something.
#[test]
fn forces_without_the_report_of_the_solver_are_refused() {
    let mut host = started();
    host.send_block(&snapshot(DEPTH));
    host.send(&ContactForces::default());
    let fault = host.tick().expect_err("refused");
    assert!(fault.to_string().contains("tissue.solver"), "{fault}");
}
