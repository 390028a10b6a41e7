//! The verdict of the task `cut`, in-process and without physics.

use microsim_module_push_strip::Module;
use microsim_sdk::message::{
    ContactForce, ContactForces, LevelControl, LevelEvent, Pose, SolverTick, TISSUE_SNAPSHOT,
    TissueCut, TrainingResult,
};
use microsim_sdk::{BlockBuilder, Published, TestHost};
use serde_json::json;
use std::f64::consts::FRAC_1_SQRT_2;

const DWELL: f64 = 0.2;
/// Ticks of 8 ms that a piece has to lie for 0.2 s: time counts from the first one.
const STAY: u64 = 26;

fn started() -> TestHost<Module> {
    let mut host = ready();
    assert!(tick(&mut host, Piece::None, true).is_none());
    host
}

/// Before the first tick.
fn ready() -> TestHost<Module> {
    let tool = |name: &str, sharpness: f64| {
        json!({
            "title": { "de": name, "en": name }, "doc": "-", "hinge": null, "opening_angle": null, "colour": "#888888",
            "finish": "metal", "sharpness": sharpness, "capsule": [],
        })
    };
    let object = |name: &str, mut keys: serde_json::Value| {
        keys["name"] = json!(name);
        // Along y: a mark lies across the strip.
        keys["orientation"] = json!([-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2]);
        keys["colour"] = json!("#888888");
        keys["finish"] = json!("matte");
        keys["active"] = json!(true);
        keys
    };
    let limit = |metric: &str, max: f64, reason: &str| {
        json!({
            "metric": metric, "min": null, "max": max, "full": null, "zero": null,
            "source": "this test", "provisional": true, "decides": true, "reason": reason,
        })
    };
    let own_metric = |id: &str, unit: &str| {
        json!({
            "id": id, "unit": unit, "display_unit": null, "direction": "lower", "category": "target", "formula": "-",
            "source": "this test", "title": { "de": "-", "en": "-" }, "advice": { "de": "-", "en": "-" },
        })
    };
    let config = json!({
        "tools": [{ "name": "left", "model": "forceps" }, { "name": "right", "model": "scissors" }],
        "models": { "forceps": tool("forceps", 0.0), "scissors": tool("scissors", 1.0) },
        "limits": [limit("cut-distance", 0.001, "cut-beside-the-mark"), limit("stray-cut", 1e-8, "stray-cut")],
        "metrics": {
            "idle_speed": 1e-4, "movement_speed": 1e-3, "smoothing": 0.05, "idle_smoothing": 0.08,
            "resample_rate": 60.0, "gap": 0.1, "shortest_path": null,
        },
        "own_metrics": [own_metric("cut-distance", "m"), own_metric("stray-cut", "m^2"), own_metric("drops", "count")],
        "reasons": [],
        "module": { "task": "cut", "depth": 0.001, "depth_tolerance": 0.0001, "dwell": DWELL, "mark_radius": 0.0021 },
        "objects": [
            object("clamp", json!({ "shape": "box", "half_size": [0.001, 0.001, 0.001], "position": [0.004, 0.0, 0.0] })),
            object("mark-1", json!({ "shape": "sphere", "radius": 0.0002, "position": [0.001, 0.0, 0.0] })),
        ],
        "rigid": [{
            "name": "tray", "shape": "tray", "position": [-0.01, 0.0, -0.0035], "orientation": [0.0, 0.0, 0.0, 1.0],
            "half_size": [0.003, 0.002, 0.001], "wall": 0.0005, "colour": "#c8ccd0", "finish": "matte",
        }],
        "bodies": ["strip"],
    });
    let manifest = include_str!("../module.toml");
    let host = TestHost::of_module(manifest, 1, 4, config).expect("a complete set-up");
    let mut host = host.moving();
    host.send(&LevelControl::Start);
    host
}

/// Where the free half of the strip is.
#[derive(Clone, Copy)]
enum Piece {
    None,
    Off([f64; 3]),
}

/// A tick with a strip of four nodes, whose ids stand in another order after the cut, as after one that has removed crumbs.
fn tick(host: &mut TestHost<Module>, piece: Piece, held: bool) -> Option<TrainingResult> {
    tick_published(host, piece, held).last()
}

/// The same, with all that the module publishes in it.
fn tick_published(host: &mut TestHost<Module>, piece: Piece, held: bool) -> Published {
    let (ids, off, [x, y, z]) = match piece {
        Piece::None => ([10, 11, 12, 13], 0, [0.0; 3]),
        Piece::Off(by) => ([10, 13, 12, 11], 1, by),
    };
    let free = |at: f64| [at + x, y, z];
    let places = match piece {
        Piece::None => [
            [0.004, 0.0, 0.0],
            free(-0.003),
            free(-0.002),
            [0.003, 0.0, 0.0],
        ],
        Piece::Off(_) => [
            [0.004, 0.0, 0.0],
            [0.003, 0.0, 0.0],
            free(-0.002),
            free(-0.003),
        ],
    };
    let pieces = match piece {
        Piece::None => [0; 4],
        Piece::Off(_) => [0, 0, off, off],
    };
    let block = BlockBuilder::new(TISSUE_SNAPSHOT, "strip", 0, 0)
        .u32s("node_id", ids)
        .f64s("position", places.into_iter().flatten())
        .u32s("piece", pieces)
        .u32s("triangle", [0, 1, 2]);
    host.send_block(&block.finish());
    host.send_tools(&[("left", Pose::default()), ("right", Pose::default())]);
    let last = pieces[3];
    let force = |tool: &str, grip_force: f64| ContactForce {
        partner: tool.into(),
        body: "strip".into(),
        sticking_fraction: 1.0,
        grip_force,
        pieces: vec![last],
        ..ContactForce::default()
    };
    let grip = held.then(|| force("left", 0.01));
    host.send(&SolverTick {
        valid: true,
        ..SolverTick::default()
    });
    host.send(&ContactForces {
        contacts: grip.into_iter().collect(),
        between: vec![force("tray", 0.0)],
    });
    host.tick().expect("a good tick")
}

fn cut(host: &mut TestHost<Module>, x: f64) {
    cut_at(host, x, [1.0, 0.0, 0.0]);
}

fn cut_at(host: &mut TestHost<Module>, x: f64, rest_normal: [f64; 3]) {
    host.send(&TissueCut {
        body: "strip".into(),
        tool: "right".into(),
        area: 1e-6,
        // Only along the normal does it count.
        rest_centroid: [x, 0.0005, -0.0005],
        rest_normal,
        valid: true,
        ..TissueCut::default()
    });
}

const IN_TRAY: Piece = Piece::Off([-0.0075, 0.0, -0.0035]);
const BESIDE: Piece = Piece::Off([-0.0075, 0.0, -0.0049]);
const ABOVE: Piece = Piece::Off([-0.0075, 0.0, 0.0]);
/// Ticks without a grip after which a piece is dropped: 0.1 s, counted from the first one.
const DROP: u64 = 14;

fn lie(
    host: &mut TestHost<Module>,
    piece: Piece,
    held: bool,
    ticks: u64,
) -> Option<TrainingResult> {
    (0..ticks).find_map(|_| tick(host, piece, held))
}

fn metric(result: &TrainingResult, id: &str) -> Option<f64> {
    result.metrics.iter().find(|m| m.id == id)?.value
}

#[test]
fn a_piece_cut_off_at_the_mark_that_lies_in_the_tray_passes() {
    let mut host = started();
    cut(&mut host, 0.0018);
    cut(&mut host, 0.0008);
    assert!(lie(&mut host, Piece::Off([0.0; 3]), true, 3).is_none());
    // What is done to the piece afterwards does not count.
    cut(&mut host, -0.003);
    assert!(lie(&mut host, IN_TRAY, true, 2 * STAY).is_none(), "held");
    assert!(
        lie(&mut host, IN_TRAY, false, STAY - 1).is_none(),
        "a tick too early"
    );
    let result = tick(&mut host, IN_TRAY, false).expect("the verdict");
    assert!(result.passed, "{:?}", result.failed);
    // The mean of 0.8 and 0.2 mm; tolerance: rounding.
    let distance = metric(&result, "cut-distance").expect("measured");
    assert!((distance - 0.0005).abs() < 1e-12, "{distance}");
}

#[test]
fn each_reason_comes_alone() {
    let mut uncut = started();
    lie(&mut uncut, Piece::None, false, 2 * STAY);
    assert_eq!(uncut.end().failed, ["not-cut"]);

    let mut lost = started();
    cut(&mut lost, 0.001);
    lie(&mut lost, Piece::Off([0.0; 3]), true, 1);
    lie(&mut lost, BESIDE, false, 2 * STAY);
    assert_eq!(lost.end().failed, ["not-in-tray"]);

    let mut beside = started();
    cut(&mut beside, -0.0005);
    lie(&mut beside, Piece::Off([0.0; 3]), true, 1);
    let result = lie(&mut beside, IN_TRAY, false, 2 * STAY).expect("the verdict");
    assert_eq!(result.failed, ["cut-beside-the-mark"]);

    // Cut off by planes along the strip alone: nothing is known of a distance, and that must not let it pass.
    let mut slit = started();
    cut_at(&mut slit, 0.001, [0.0, 1.0, 0.0]);
    lie(&mut slit, Piece::Off([0.0; 3]), true, 1);
    let result = lie(&mut slit, IN_TRAY, false, 2 * STAY).expect("the verdict");
    assert_eq!(result.failed, ["stray-cut"]);
    assert_eq!(metric(&result, "cut-distance"), None);
}

/// What is let go straight above the tray falls into it and is delivered; what is let go elsewhere was dropped, at the first tick of
/// 0.1 s; what was never gripped neither is dropped nor delivered, wherever it lies.
#[test]
fn a_piece_is_dropped_only_where_it_does_not_fall_into_the_tray() {
    let carried = || {
        let mut host = started();
        cut(&mut host, 0.001);
        lie(&mut host, Piece::Off([0.0; 3]), true, 1);
        host
    };
    let mut delivered = carried();
    assert!(lie(&mut delivered, ABOVE, false, 2 * DROP).is_none());
    let result = lie(&mut delivered, IN_TRAY, false, STAY + 1).expect("the verdict");
    assert!(result.passed, "{:?}", result.failed);
    assert_eq!(metric(&result, "drops"), Some(0.0));

    for (ticks, drops) in [(DROP - 2, 0.0), (DROP, 1.0)] {
        let mut dropped = carried();
        lie(&mut dropped, BESIDE, false, ticks);
        assert_eq!(metric(&dropped.end(), "drops"), Some(drops));
    }
    // The report tells when: it is an event, in the tick in which the piece counts as dropped.
    let mut dropped = carried();
    lie(&mut dropped, BESIDE, false, DROP - 2);
    for told in [0, 1, 0] {
        let published = tick_published(&mut dropped, BESIDE, false);
        let events = published.all::<LevelEvent>();
        assert_eq!(events.iter().filter(|e| e.id == "drop").count(), told);
    }

    for place in [IN_TRAY, BESIDE] {
        let mut fallen = ready();
        lie(&mut fallen, Piece::None, false, 1);
        cut(&mut fallen, 0.001);
        assert!(lie(&mut fallen, place, false, 2 * STAY).is_none());
        let result = fallen.end();
        assert_eq!(result.failed, ["not-in-tray"]);
        assert_eq!(metric(&result, "drops"), None);
    }
}
