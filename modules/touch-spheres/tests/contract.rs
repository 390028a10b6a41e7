//! The contract of the module, in-process and without files: the platform's messages in, the verdict out. The host moves
//! the module to a fresh instance in every tick, so whatever `save` leaves out would be lost.

use microsim_module_touch_spheres::{Module, Place, places};
use microsim_sdk::TestHost;
use microsim_sdk::message::{
    LevelControl, ObjectSet, Pose, ToolState, ToolStates, ToolStatus, TrainingResult,
};
use serde_json::json;
use std::path::Path;

const SEED: u64 = 7;
const RADIUS: f64 = 0.002;
const SPREAD: [f64; 3] = [0.008, 0.006, 0.002];
const DIRECTION_MAX: f64 = 0.5;
/// Ticks of 8 ms for which a touch of 0.4 s has to last: time counts from the first tick inside.
const STAY: u64 = 51;

fn metric(id: &str, unit: &str) -> serde_json::Value {
    let text = json!({ "de": "-", "en": "-" });
    json!({
        "id": id, "unit": unit, "display_unit": null, "direction": "lower", "category": "handling",
        "formula": id, "source": "this test", "title": text, "advice": text,
    })
}

fn object(mut keys: serde_json::Value) -> serde_json::Value {
    keys["position"] = json!([0.0, 0.0, 0.0]);
    keys["orientation"] = json!([0.0, 0.0, 0.0, 1.0]);
    keys["colour"] = json!("#888888");
    keys["finish"] = json!("matte");
    keys["active"] = json!(false);
    keys
}

fn host() -> TestHost<Module> {
    let config = json!({
        "tools": [{ "name": "right", "model": "forceps" }],
        "models": {},
        "limits": [],
        "metrics": {
            "idle_speed": 1e-4, "movement_speed": 1e-3, "smoothing": 0.05, "idle_smoothing": 0.08,
            "resample_rate": 60.0, "gap": 0.1, "shortest_path": null,
        },
        "own_metrics": [
            metric("angle-error", "rad"), metric("centre-distance", "m"), metric("losses", "count"),
        ],
        "reasons": [],
        "module": {
            "angle_tolerance": 0.3, "dwell": 0.4, "spread": SPREAD, "direction_max": DIRECTION_MAX,
        },
        "objects": [
            object(json!({ "name": "sphere", "count": 2, "shape": "sphere", "radius": RADIUS })),
            object(json!({ "name": "needle", "shape": "capsule", "radius": 1e-4, "length": 0.004 })),
        ],
    });
    let manifest = include_str!("../module.toml");
    let host = TestHost::of_module(manifest, SEED, 1, config).expect("a complete set-up");
    host.moving()
}

fn level_places() -> Vec<Place> {
    places(SEED, 2, RADIUS, SPREAD, DIRECTION_MAX).expect("room for two spheres")
}

/// The forceps with its tip at a place, turned about the horizontal axis across `direction` so that its axis is off by
/// `angle`.
fn tool(tip: [f64; 3], direction: [f64; 3], angle: f64) -> ToolStates {
    let [x, y, z] = direction;
    let flat = (x * x + y * y).sqrt();
    // Within the plane of direction and vertical: zenith angle of the direction plus the error.
    let zenith = libm::atan2(flat, z) + angle;
    let (s, c) = (libm::sin(0.5 * zenith), libm::cos(0.5 * zenith));
    let orientation = [-y / flat * s, x / flat * s, 0.0, c];
    ToolStates {
        tools: vec![ToolState {
            tool: "right".into(),
            model: "forceps".into(),
            status: ToolStatus::Tracked,
            pose: Pose {
                position: tip,
                orientation,
            },
            opening: 0.0,
        }],
    }
}

fn run(host: &mut TestHost<Module>, states: &ToolStates, ticks: u64) -> Option<TrainingResult> {
    for _ in 0..ticks {
        host.send(states);
        if let Some(result) = host.tick().expect("a good tick").last() {
            return Some(result);
        }
    }
    None
}

#[test]
fn both_spheres_touched_rightly_pass() {
    let mut host = host();
    host.send(&LevelControl::Start);
    let places = level_places();
    let away = tool([0.0, 0.0, 0.02], [0.0, 1e-3, 1.0], 0.0);
    assert!(run(&mut host, &away, 3).is_none());
    // Just within the tolerance of 0.3 rad, and not in the middle.
    let edge = |p: &Place| [p.centre[0] + 0.9 * RADIUS, p.centre[1], p.centre[2]];
    assert!(
        run(
            &mut host,
            &tool(edge(&places[0]), places[0].direction, 0.29),
            STAY
        )
        .is_none()
    );
    let second = tool(edge(&places[1]), places[1].direction, 0.29);
    assert!(
        run(&mut host, &second, STAY - 1).is_none(),
        "a tick too early"
    );
    let result = run(&mut host, &second, 1).expect("the verdict with the last sphere");
    assert!(result.passed, "{:?}", result.failed);
    assert_eq!((result.targets_done, result.score), (2, 100.0));
    let metric = |id: &str| {
        result
            .metrics
            .iter()
            .find(|m| m.id == id)
            .and_then(|m| m.value)
    };
    // Errors that the tool was given; tolerance: rounding of a few operations on numbers of size 1.
    assert!((metric("angle-error").expect("measured") - 0.29).abs() < 1e-12);
    assert!((metric("centre-distance").expect("measured") - 0.9 * RADIUS).abs() < 1e-15);
}

#[test]
fn a_wrong_angle_and_a_short_stay_are_told_apart() {
    for (angle, ticks, reason) in [
        (0.31, STAY + 1, "wrong-angle"),
        (0.0, STAY - 1, "dwell-too-short"),
        (0.31, 5, "targets-missed"),
    ] {
        let mut host = host();
        host.send(&LevelControl::Start);
        let first = level_places()[0];
        run(
            &mut host,
            &tool(first.centre, first.direction, angle),
            ticks,
        );
        let result = host.end();
        assert_eq!(result.failed, [reason], "{angle} rad for {ticks} ticks");
        assert_eq!((result.targets_done, result.score), (0, 0.0));
    }
}

#[test]
fn nothing_counts_before_the_start_nor_while_not_tracked() {
    let mut host = host();
    let first = level_places()[0];
    let good = tool(first.centre, first.direction, 0.0);
    run(&mut host, &good, 2 * STAY);
    host.send(&LevelControl::Start);
    let mut lost = good.clone();
    lost.tools[0].status = ToolStatus::Stale;
    run(&mut host, &lost, 2 * STAY);
    // Half before the loss and half after it are not one stay, and the loss is not the trainee's.
    run(&mut host, &good, STAY / 2);
    run(&mut host, &lost, 1);
    run(&mut host, &good, STAY / 2);
    let result = host.end();
    assert_eq!(result.targets_done, 0);
    let losses = result.metrics.iter().find(|m| m.id == "losses");
    assert_eq!(losses.and_then(|m| m.value), Some(0.0));
}

#[test]
fn an_aborted_run_is_no_failure_of_the_trainee() {
    let mut host = host();
    host.send(&LevelControl::Start);
    host.tick().expect("a good tick");
    host.send(&LevelControl::Abort);
    let result: TrainingResult = host.tick().expect("a good tick").last().expect("a result");
    assert!(result.aborted && !result.passed);
    assert_eq!(result.failed, ["aborted"]);
}

#[test]
fn the_current_sphere_shows_its_colour() {
    let mut host = host();
    host.send(&LevelControl::Start);
    let shown: Vec<ObjectSet> = host.tick().expect("a good tick").all();
    let pose = |name: &str| shown.iter().find(|o| o.name == name).and_then(|o| o.pose);
    assert_eq!(
        pose("sphere-2").expect("shown").position,
        level_places()[1].centre
    );
    assert!(pose("needle").is_some());
    let first = level_places()[0];
    host.send(&tool(first.centre, first.direction, 1.0));
    let changes: Vec<ObjectSet> = host.tick().expect("a good tick").all();
    let [red] = &changes[..] else {
        panic!("all is shown once, and the change of one colour: {changes:?}");
    };
    assert_eq!(red.name, "sphere-1");
    let [r, g, b] = red.colour.expect("a colour");
    assert!(r > 0.7 && g < 0.3 && b < 0.3, "red inside at a wrong angle");
}

/// The test host reads a level as the host does: its targets, tools and limits are those of the file.
#[test]
fn a_level_is_read_from_its_file() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let tools = folder.join("../../config/tools");
    let level = |number| TestHost::<Module>::of_level(folder, &tools, SEED, number);
    let mut host = level(1).expect("the shipped level").moving();
    host.send(&LevelControl::Start);
    host.send_open_tools(&[("right", Pose::default(), 0.5)]);
    host.tick().expect("a good tick");
    let file = std::fs::read_to_string(folder.join("levels/level1.toml")).expect("a level");
    let limits = file.matches("[[limit]]").count();
    let result = host.end();
    assert!(!result.passed && result.targets > 0, "{result:?}");
    let limited = result
        .metrics
        .iter()
        .filter(|metric| metric.limit.is_some());
    assert_eq!(limited.count(), limits, "{result:?}");
    let missing = level(99).err().expect("there is no such level");
    assert!(missing.text.contains("level99.toml"), "{missing:?}");
}
