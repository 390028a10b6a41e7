//! What the tests stand on: a level, a host, and two vessels that are snapshots alone.

use microsim_mesh::{Arc, CellSplit, Layer, TetMesh, Tube};
use microsim_module_diagonal_cut::Module;
use microsim_sdk::message::{
    ContactForce, ContactForces, LevelControl, RegionForce, SolverTick, TISSUE_ELEMENTS,
    TISSUE_SNAPSHOT, TissueCut, ToolState, ToolStates, ToolStatus, TrainingResult,
};
use microsim_sdk::{BlockBuilder, Fault, Published, TestHost};
use serde_json::{Value, json};
use std::f64::consts::FRAC_1_SQRT_2;

/// \[s\]
pub const DWELL: f64 = 0.2;
/// Ticks of 8 ms for which something has to last for 0.2 s: time counts from the first one.
pub const STAY: u64 = 26;

/// Corners of a section: with so many the circumference of an ellipse with half axes 1 and 2 is short by less than 1e-4 of it.
const AROUND: usize = 96;

/// Inner radii of the vessels, and their ends \[m\]: the smaller one reaches from 2 mm to 0, the larger one from -3 mm to -1 mm.
pub const SMALLER: f64 = 0.4e-3;
pub const LARGER: f64 = 0.5e-3;
pub const LENGTH: f64 = 2e-3;

fn metric(id: &str, unit: &str, category: &str) -> Value {
    json!({
        "id": id, "unit": unit, "display_unit": null, "direction": "lower", "category": category, "formula": "-",
        "source": "this test", "title": { "de": "-", "en": "-" }, "advice": { "de": "-", "en": "-" },
    })
}

pub fn limit(metric: &str, max: f64, reason: &str) -> Value {
    json!({
        "metric": metric, "min": null, "max": max, "full": 0.0, "zero": 2.0 * max,
        "source": "this test", "provisional": true, "decides": true, "reason": reason,
    })
}

/// A level of which `change` makes another one.
pub fn config(solution: &str, limits: Value) -> Value {
    let tool = |sharpness: f64| {
        json!({
            "title": { "de": "-", "en": "-" }, "doc": "-", "hinge": null, "opening_angle": null, "colour": "#888888",
            "finish": "metal", "sharpness": sharpness, "capsule": [],
        })
    };
    let clamp = |name: &str, x: f64, side: f64| {
        json!({
            "name": name, "shape": "box", "half_size": [0.001, 0.001, 0.001], "position": [x, 0.0, 0.0],
            "orientation": [0.0, side * FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2], "colour": "#888888", "finish": "matte",
            "active": true,
        })
    };
    json!({
        "tools": [{ "name": "left", "model": "forceps" }, { "name": "right", "model": "scissors" }],
        "models": { "forceps": tool(0.0), "scissors": tool(1.0) },
        "limits": limits,
        "metrics": {
            "idle_speed": 1e-4, "movement_speed": 1e-3, "smoothing": 0.05, "idle_smoothing": 0.08, "resample_rate": 60.0, "gap": 0.1,
            "shortest_path": null,
        },
        "own_metrics": [
            metric("circumference-mismatch", "1", "target"), metric("area-mismatch", "1", "target"),
            metric("angle-error", "rad", "target"), metric("facing-error", "rad", "target"),
            metric("unevenness", "m", "target"), metric("raggedness", "1", "target"), metric("bites", "count", "handling"), metric("length-lost", "m", "target"),
            metric("steadied", "1", "handling"), metric("media-grip", "N", "tissue"), metric("peak-grip", "N", "tissue"),
            metric("peak-force", "N", "tissue"), metric("torn", "m^2", "tissue"), metric("other-vessel", "m^2", "tissue"),
            metric("needless-spread", "1", "tissue"), metric("needless-cut", "m^2", "tissue"),
            metric("overstretched", "1", "tissue"),
        ],
        "reasons": [],
        "module": {
            "solution": solution, "facing": "trainee", "dwell": DWELL, "tolerance": 0.03, "injury_stretch": 1.6,
        },
        "objects": [clamp("clamp-smaller", LENGTH, -1.0), clamp("clamp-larger", -0.003, 1.0)],
        "bodies": ["smaller", "larger"],
    })
}

pub fn host(config: Value) -> Result<TestHost<Module>, Fault> {
    TestHost::of_module(include_str!("../../module.toml"), 1, 4, config)
}

/// A tube along x with its free end at `end`, held `length` from there, of so many corners around.
fn tube(inner_radius: f64, end: f64, held: f64) -> TetMesh {
    let layer = Layer {
        thickness: 0.16e-3,
        cells: 1,
        region: 0,
    };
    let tube = Tube {
        center: [0.5 * (end + held), 0.0, 0.0],
        axis: [1.0, 0.0, 0.0],
        inner_radius,
        layers: vec![layer],
        length: (end - held).abs(),
        around: AROUND,
        along: 4,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    };
    tube.mesh().expect("a tube")
}

/// What the physics publishes of the smaller vessel in a tick.
#[derive(Clone, Copy)]
pub struct Scene {
    /// Angle of its end to a straight one \[rad\], facing the trainee or, mirrored, away; only an end that was cut has one at rest.
    pub angle: f64,
    /// How far it has been cut off \[m\].
    pub cut: Option<f64>,
    /// By how much its end is wider than at rest.
    pub wider: f64,
    /// Largest stretch of half of it.
    pub stretch: f64,
    /// Force of a grip of the forceps, on layer 0 by a quarter \[N\].
    pub grip: f64,
    /// How far the scissors are open.
    pub opening: f64,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            angle: 0.0,
            cut: None,
            wider: 0.0,
            stretch: 1.0,
            grip: 0.0,
            opening: 0.8,
        }
    }
}

fn send_vessel(
    host: &mut TestHost<Module>,
    name: &str,
    mesh: &TetMesh,
    scene: &Scene,
    place: impl Fn([f64; 3], bool) -> [f64; 3],
) {
    let surface = mesh.surface().triangles;
    let nodes = || mesh.positions.iter().map(|p| [p.x, p.y, p.z]);
    let generation = u64::from(scene.cut.is_some());
    // What is left of the nodes of the free half after a cut are others.
    let ids = (0_u32..).zip(nodes()).map(|(id, [x, ..])| match scene.cut {
        Some(_) if x < 0.5 * LENGTH => id + 100_000,
        _ => id,
    });
    let block = BlockBuilder::new(TISSUE_SNAPSHOT, name, generation, 0)
        .u32s("node_id", ids)
        .f64s("position", nodes().flat_map(|p| place(p, false)))
        .u32s("piece", nodes().map(|_| 0))
        .u32s("triangle", surface.iter().flatten().copied())
        .u32s("inner", surface.iter().map(|_| 0));
    host.send_block(&block.finish());
    let block = BlockBuilder::new(TISSUE_ELEMENTS, name, generation, 0)
        .f64s("rest", nodes().flat_map(|p| place(p, true)))
        .u32s("triangle_region", surface.iter().map(|_| 0))
        .u32s("region", [0, 0])
        .f64s("volume", [1e-9; 2])
        .f64s("stretch", [1.0, scene.stretch]);
    host.send_block(&block.finish());
}

pub fn tick(host: &mut TestHost<Module>, scene: &Scene) -> Published {
    let smaller = tube(SMALLER, 0.0, LENGTH);
    let end = scene.cut.unwrap_or_default();
    let shape = |[x, y, z]: [f64; 3], at_rest: bool| {
        // 1 at the free end, 0 where it is held.
        let free = 1.0 - x / LENGTH;
        let wide = if at_rest {
            1.0
        } else {
            1.0 + scene.wider * free
        };
        let oblique = free * (end - y * libm::tan(scene.angle));
        [x + oblique, wide * y, wide * z]
    };
    send_vessel(host, "smaller", &smaller, scene, shape);
    let larger = tube(LARGER, -1e-3, -3e-3);
    let standing = Scene::default();
    send_vessel(host, "larger", &larger, &standing, |place, _| place);
    let tool = |tool: &str, opening: f64| ToolState {
        tool: tool.into(),
        model: "-".into(),
        status: ToolStatus::Tracked,
        pose: Default::default(),
        opening,
    };
    host.send(&ToolStates {
        tools: vec![tool("left", 0.2), tool("right", scene.opening)],
    });
    host.send(&SolverTick {
        valid: true,
        ..SolverTick::default()
    });
    let on = |region: u32, normal_force: f64| RegionForce {
        region,
        normal_force,
        ..RegionForce::default()
    };
    let grip = ContactForce {
        partner: "left".into(),
        body: "smaller".into(),
        sticking_fraction: 1.0,
        grip_force: scene.grip,
        sustained_grip: scene.grip,
        pieces: vec![0],
        regions: vec![on(0, 0.5 * scene.grip), on(1, 1.5 * scene.grip)],
        ..ContactForce::default()
    };
    let grips = scene.grip > 0.0;
    host.send(&ContactForces {
        contacts: if grips { vec![grip] } else { Vec::new() },
        between: Vec::new(),
    });
    host.tick().expect("a good tick")
}

pub fn ticks(host: &mut TestHost<Module>, scene: &Scene, count: u64) -> Option<TrainingResult> {
    (0..count).find_map(|_| tick(host, scene).last())
}

pub fn cut(host: &mut TestHost<Module>, body: &str, tool: &str) {
    host.send(&TissueCut {
        body: body.into(),
        tool: tool.into(),
        area: 1e-6,
        valid: true,
        ..TissueCut::default()
    });
}

/// A level that has begun, with both vessels as they were.
pub fn started(solution: &str, limits: Value) -> TestHost<Module> {
    let host = host(config(solution, limits)).expect("a complete set-up");
    let mut host = host.moving();
    host.send(&LevelControl::Start);
    tick(&mut host, &Scene::default());
    host
}

pub fn value(result: &TrainingResult, metric: &str) -> Option<f64> {
    let metrics = result.metrics.iter();
    metrics.clone().find(|of| of.id == metric)?.value
}
