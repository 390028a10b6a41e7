//! What the tests stand on: a level, a host, and tissue that is snapshots alone.

use microsim_module_coordination::Module;
use microsim_sdk::message::{
    ContactForce, ContactForces, LevelControl, Pose, SolverTick, TISSUE_SNAPSHOT, TissueCut,
    ToolState, ToolStates, ToolStatus, TrainingResult,
};
use microsim_sdk::{BlockBuilder, Fault, Published, TestHost};
use serde_json::{Value, json};
use std::f64::consts::FRAC_1_SQRT_2;

pub const DWELL: f64 = 0.2;
/// Ticks of 8 ms for which something has to last for 0.2 s: time counts from the first one.
pub const STAY: u64 = 26;
/// Ticks without a grip after which tissue is dropped: 0.1 s, counted from the first one.
pub const DROP: u64 = 14;

pub fn object(name: &str, shape: Value, position: [f64; 3]) -> Value {
    let mut object = json!({
        // Along y, as the tissue is cut across.
        "orientation": [-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2],
        "colour": "#888888", "finish": "matte", "active": true,
    });
    object["name"] = json!(name);
    object["position"] = json!(position);
    for (key, value) in shape.as_object().expect("keys") {
        object[key] = value.clone();
    }
    object
}

pub fn limit(metric: &str, max: f64, reason: &str) -> Value {
    json!({
        "metric": metric, "min": null, "max": max, "full": 0.0, "zero": 2.0 * max,
        "source": "this test", "provisional": true, "decides": true, "reason": reason,
    })
}

pub fn metric(id: &str, unit: &str, category: &str) -> Value {
    json!({
        "id": id, "unit": unit, "display_unit": null, "direction": "lower", "category": category, "formula": "-",
        "source": "this test", "title": { "de": "-", "en": "-" }, "advice": { "de": "-", "en": "-" },
    })
}

pub fn config(task: &str, limits: Value) -> Value {
    let tool = |sharpness: f64| {
        json!({
            "title": { "de": "-", "en": "-" }, "doc": "-", "hinge": null, "opening_angle": null, "colour": "#888888",
            "finish": "metal", "sharpness": sharpness, "capsule": [],
        })
    };
    let half = json!({ "shape": "box", "half_size": [0.001, 0.001, 0.001] });
    let line = json!({ "shape": "capsule", "radius": 0.0001, "length": 0.002 });
    let mut objects = vec![
        object("clamp-left", half.clone(), [-0.004, 0.0, 0.0]),
        object("clamp-right", half, [0.004, 0.0, 0.0]),
        object("mark-1", line.clone(), [-0.002, 0.0, 0.0]),
        object(
            "ring",
            json!({ "shape": "ring", "radius": 0.0012, "tube": 0.0002 }),
            [-0.002, 0.0, 0.003],
        ),
    ];
    if task != "hold" {
        objects.push(object("mark-2", line, [0.002, 0.0, 0.0]));
    }
    json!({
        "tools": [{ "name": "left", "model": "forceps" }, { "name": "right", "model": "scissors" }],
        "models": { "forceps": tool(0.0), "scissors": tool(1.0) },
        "limits": limits,
        "metrics": {
            "idle_speed": 1e-4, "movement_speed": 1e-3, "smoothing": 0.05, "idle_smoothing": 0.08, "resample_rate": 60.0, "gap": 0.1,
            "shortest_path": null,
        },
        "own_metrics": [
            metric("place-error", "m", "target"), metric("cut-distance", "m", "target"), metric("cut-angle", "rad", "target"),
            metric("stray-cut", "m^2", "tissue"), metric("torn", "m^2", "tissue"), metric("steadied", "1", "handling"),
            metric("peak-force", "N", "tissue"), metric("excess-time", "s", "tissue"), metric("peak-grip", "N", "tissue"),
            metric("drops", "count", "handling"),
        ],
        "reasons": [],
        "module": { "task": task, "dwell": DWELL, "mark_radius": 0.0005, "mark_reach": 0.001, "cut_width": 0.0004 },
        "objects": objects,
        "rigid": [{
            "name": "tray", "shape": "tray", "position": [0.0, -0.01, -0.003], "orientation": [0.0, 0.0, 0.0, 1.0],
            "half_size": [0.003, 0.002, 0.001], "wall": 0.0005, "colour": "#c8ccd0", "finish": "matte",
        }],
        "bodies": ["tissue"],
    })
}

pub fn host(config: Value) -> Result<TestHost<Module>, Fault> {
    TestHost::of_module(include_str!("../../module.toml"), 1, 4, config)
}

pub fn started(task: &str, limits: Value) -> TestHost<Module> {
    let host = host(config(task, limits)).expect("a complete set-up");
    let mut host = host.moving();
    host.send(&LevelControl::Start);
    tick(&mut host, &Scene::default());
    host
}

/// What the physics publishes in a tick.
#[derive(Clone, Copy, Default)]
pub struct Scene {
    /// How far the piece between the marks, or the tissue at the first mark, has gone.
    pub by: [f64; 3],
    /// Numbers of the pieces: left, middle, right.
    pub pieces: [u32; 3],
    pub held: bool,
    /// Force of the forceps \[N\].
    pub force: f64,
    /// How the forceps touch.
    pub touch: Touch,
    /// What lies in the tray: the part in the middle, or the one on the left.
    pub stump: bool,
}

/// How the forceps touch tissue.
#[derive(Clone, Copy, Default)]
pub enum Touch {
    /// They squeeze the part in the middle, which moves with them.
    #[default]
    Grip,
    /// So the part on the left.
    Stump,
    /// So the part on the right.
    FarStump,
    /// The tissue lies on both jaws, which press in the same direction.
    Hook,
    /// It slides along them.
    Slide,
}

/// Nodes at the clamps, at the ends of the marks and in the middle, by the part that they belong to.
pub const NODES: [([f64; 3], usize); 7] = [
    ([-0.004, 0.0, 0.0], 0),
    ([-0.002, -0.001, 0.0], 1),
    ([-0.002, 0.001, 0.0], 1),
    ([0.0, 0.0, 0.0], 1),
    ([0.002, -0.001, 0.0], 1),
    ([0.002, 0.001, 0.0], 1),
    ([0.004, 0.0, 0.0], 2),
];

pub fn tick(host: &mut TestHost<Module>, scene: &Scene) -> Published {
    tick_with(host, scene, &[("left", Some(0.0)), ("right", Some(0.0))])
}

/// With tools at heights above the origin \[m\]; those without one are not in view.
pub fn tick_with(
    host: &mut TestHost<Module>,
    scene: &Scene,
    tools: &[(&str, Option<f64>)],
) -> Published {
    let place = |(place, part): &([f64; 3], usize)| {
        let by = if *part == 1 { scene.by } else { [0.0; 3] };
        [0, 1, 2].map(|k| place[k] + by[k])
    };
    let block = BlockBuilder::new(TISSUE_SNAPSHOT, "tissue", 0, 0)
        .u32s("node_id", (0..7).map(|id| 10 + id))
        .f64s("position", NODES.iter().flat_map(place))
        .u32s("piece", NODES.iter().map(|(_, part)| scene.pieces[*part]))
        .u32s("triangle", [0, 1, 2]);
    host.send_block(&block.finish());
    let state = |(tool, height): &(&str, Option<f64>)| ToolState {
        tool: (*tool).into(),
        model: "-".into(),
        status: match height {
            Some(_) => ToolStatus::Tracked,
            None => ToolStatus::Stale,
        },
        pose: Pose {
            position: [0.0, 0.0, height.unwrap_or_default()],
            ..Pose::default()
        },
        opening: 0.0,
    };
    host.send(&ToolStates {
        tools: tools.iter().map(state).collect(),
    });
    let contact = |tool: &str, part: usize, grip_force: f64, sticking_fraction: f64| ContactForce {
        partner: tool.into(),
        body: "tissue".into(),
        // At the clamps, or in the middle between the marks.
        point: place(&NODES[3 * part]),
        force: [0.0, 0.0, scene.force],
        sustained_force: scene.force,
        time_over_limit: if scene.force > 0.02 { 0.008 } else { 0.0 },
        sticking_fraction,
        grip_force,
        sustained_grip: grip_force,
        pieces: vec![scene.pieces[part]],
        ..ContactForce::default()
    };
    let forceps = match scene.touch {
        Touch::Grip => contact("left", 1, 0.01, 1.0),
        Touch::Stump => contact("left", 0, 0.01, 1.0),
        Touch::FarStump => contact("left", 2, 0.01, 1.0),
        Touch::Hook => contact("left", 1, 0.0, 1.0),
        Touch::Slide => contact("left", 1, 0.01, 0.1),
    };
    host.send(&SolverTick {
        valid: true,
        ..SolverTick::default()
    });
    host.send(&ContactForces {
        contacts: if scene.held {
            vec![forceps]
        } else {
            Vec::new()
        },
        between: vec![contact("tray", usize::from(!scene.stump), 0.0, 1.0)],
    });
    host.tick().expect("a good tick")
}

pub fn ticks(host: &mut TestHost<Module>, scene: &Scene, count: u64) -> Option<TrainingResult> {
    (0..count).find_map(|_| tick(host, scene).last())
}

pub fn cut(host: &mut TestHost<Module>, tool: &str, x: f64, normal: [f64; 3]) {
    host.send(&TissueCut {
        body: "tissue".into(),
        tool: tool.into(),
        area: 1e-6,
        rest_centroid: [x, 0.0, 0.0],
        rest_normal: normal,
        valid: true,
        ..TissueCut::default()
    });
}

pub fn value(result: &TrainingResult, id: &str) -> Option<f64> {
    result.metrics.iter().find(|m| m.id == id)?.value
}

pub const ACROSS: [f64; 3] = [1.0, 0.0, 0.0];
pub const HELD: Scene = Scene {
    by: [0.0; 3],
    pieces: [0; 3],
    held: true,
    force: 0.01,
    touch: Touch::Grip,
    stump: false,
};
pub const FREE: Scene = Scene {
    pieces: [0, 1, 2],
    ..HELD
};
pub const IN_TRAY: Scene = Scene {
    by: [0.0, -0.01, -0.0035],
    held: false,
    ..FREE
};

/// Both marks cut through while the forceps hold.
pub fn both_cut(task: &str, x: f64, normal: [f64; 3], limits: Value) -> TestHost<Module> {
    let mut host = started(task, limits);
    tick(&mut host, &HELD);
    cut(&mut host, "right", -0.002 + x, normal);
    tick(&mut host, &HELD);
    cut(&mut host, "right", 0.002, ACROSS);
    host
}
