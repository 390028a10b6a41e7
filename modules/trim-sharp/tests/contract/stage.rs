//! What the tests stand on: a level, a host, and a vessel that is snapshots alone.

use microsim_mesh::{Arc, CellSplit, Layer, TetMesh, Tube};
use microsim_module_trim_sharp::Module;
use microsim_sdk::message::{
    ContactForce, ContactForces, LevelControl, Pose, RegionForce, SolverTick, TISSUE_ELEMENTS,
    TISSUE_SNAPSHOT, TissueCut, ToolState, ToolStates, ToolStatus, TrainingResult,
};
use microsim_sdk::{BlockBuilder, Fault, Published, TestHost, turned_to};
use serde_json::{Value, json};
use std::f64::consts::FRAC_1_SQRT_2;

/// \[s\]
pub const STAY: f64 = 0.2;
/// Ticks of 8 ms for which something has to last for 0.2 s: time counts from the first one.
pub const STAY_TICKS: u64 = 26;
/// \[s\]
pub const TICK: f64 = 8e-3;

/// Of the media; it ends at 0 and is held there \[m\].
pub const LENGTH: f64 = 4e-3;
/// Between the layers \[m\].
const BETWEEN: f64 = 0.5e-3;

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

/// A level that asks for so much bare media \[m\].
pub fn config(free_length: f64, limits: Value) -> Value {
    let tool = |sharpness: f64| {
        json!({
            "title": { "de": "-", "en": "-" }, "doc": "-", "hinge": null, "opening_angle": null, "colour": "#888888",
            "finish": "metal", "sharpness": sharpness, "capsule": [],
        })
    };
    let object = |name: &str, x: f64| {
        json!({
            "name": name, "shape": "box", "half_size": [0.001, 0.001, 0.001], "position": [x, 0.0, 0.0],
            "orientation": [0.0, -FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2], "colour": "#888888", "finish": "matte",
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
            metric("overhang", "m", "target"), metric("free-length", "m", "target"), metric("scissors-tilt", "rad", "handling"),
            metric("cuts", "count", "handling"), metric("held", "1", "handling"), metric("draw-speed", "m/s", "tissue"),
            metric("peak-force", "N", "tissue"), metric("peak-grip", "N", "tissue"), metric("media-grip", "N", "tissue"),
            metric("media-cut", "m^2", "tissue"), metric("media-injury", "1", "tissue"),
        ],
        "reasons": [],
        "module": { "free_length": free_length, "stay": STAY, "injuring_stretch": 1.3 },
        "objects": [object("clamp", LENGTH), object("mark-1", 0.0)],
        "bodies": ["vessel"],
    })
}

pub fn host(config: Value) -> Result<TestHost<Module>, Fault> {
    TestHost::of_module(include_str!("../../module.toml"), 1, 4, config)
}

/// What the physics publishes in a tick.
#[derive(Clone, Copy)]
pub struct Scene {
    /// How far the adventitia hangs over the end on top, and all round; below 0, how far it ends before it \[m\].
    pub top: f64,
    pub around: f64,
    /// Force of a grip of the forceps, of which the media bears a quarter \[N\].
    pub grip: f64,
    /// Whether the vessel slides through them.
    pub slides: bool,
    /// Where the tip of the forceps is along x \[m\].
    pub forceps: f64,
    /// Direction of the handle of the scissors, and how far they are open.
    pub handle: [f64; 3],
    pub opening: f64,
    /// Whether a strip of the media, and one of the adventitia, has been opened.
    pub media_cut: bool,
    pub adventitia_cut: bool,
    /// Stretch of half of the media.
    pub stretch: f64,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            top: 0.5e-3,
            around: -0.3e-3,
            grip: 0.0,
            slides: false,
            forceps: 0.0,
            handle: [0.0, -1.0, 0.0],
            opening: 0.3,
            media_cut: false,
            adventitia_cut: false,
            stretch: 1.0,
        }
    }
}

/// The end as it is to be: bare by 0.2 mm.
pub const BARE: Scene = Scene {
    top: -0.2e-3,
    around: -0.3e-3,
    grip: 0.0,
    slides: false,
    forceps: 0.0,
    handle: [0.0, -1.0, 0.0],
    opening: 0.0,
    media_cut: false,
    adventitia_cut: true,
    stretch: 1.0,
};

fn tube(inner_radius: f64, thickness: f64) -> TetMesh {
    let layer = Layer {
        thickness,
        cells: 1,
        region: 0,
    };
    let tube = Tube {
        center: [0.5 * LENGTH, 0.0, 0.0],
        axis: [1.0, 0.0, 0.0],
        inner_radius,
        layers: vec![layer],
        length: LENGTH,
        around: 48,
        along: 4,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    };
    tube.mesh().expect("a tube")
}

/// Area of what one opened triangle has, of one side \[m²\]: the one that lies first on the surface of a layer.
pub fn opened_area(layer: usize) -> f64 {
    let mesh = &layers()[layer];
    let [a, b, c] = mesh.surface().triangles[0].map(|node| mesh.positions[node as usize]);
    0.25 * (b - a).cross(&(c - a)).norm()
}

fn layers() -> [TetMesh; 2] {
    [tube(0.35e-3, 0.15e-3), tube(BETWEEN, 0.12e-3)]
}

fn send_vessel(host: &mut TestHost<Module>, scene: &Scene) {
    let (mut places, mut rest, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    let (mut regions, mut opened) = (Vec::new(), Vec::new());
    for (layer, mesh) in layers().iter().enumerate() {
        let first = (places.len() / 3) as u32;
        for p in &mesh.positions {
            // 1 at the free end, 0 where it is held.
            let free = 1.0 - p.x / LENGTH;
            // On top from 45 degrees of the upright on, and evenly on the other side.
            let upward = p.z / libm::hypot(p.y, p.z);
            let over = match (layer, upward > FRAC_1_SQRT_2) {
                (0, _) => 0.0,
                (_, true) => scene.top,
                (_, false) => scene.around,
            };
            places.extend([p.x - free * over, p.y, p.z]);
            rest.extend([p.x, p.y, p.z]);
        }
        let is_cut = [scene.media_cut, scene.adventitia_cut][layer];
        for (number, triangle) in mesh.surface().triangles.iter().enumerate() {
            triangles.extend(triangle.map(|node| node + first));
            regions.push(layer as u32);
            opened.push(u32::from(is_cut && number == 0));
        }
    }
    let nodes = places.len() / 3;
    let block = BlockBuilder::new(TISSUE_SNAPSHOT, "vessel", 0, 0)
        .u32s("node_id", 0..nodes as u32)
        .f64s("position", places)
        .u32s("piece", (0..nodes).map(|_| 0))
        .u32s("triangle", triangles)
        .u32s("inner", opened);
    host.send_block(&block.finish());
    let block = BlockBuilder::new(TISSUE_ELEMENTS, "vessel", 0, 0)
        .f64s("rest", rest)
        .u32s("triangle_region", regions)
        .u32s("region", [0, 0, 1])
        .f64s("volume", [1e-9; 3])
        .f64s("stretch", [1.0, scene.stretch, 3.0]);
    host.send_block(&block.finish());
}

pub fn tick(host: &mut TestHost<Module>, scene: &Scene) -> Published {
    send_vessel(host, scene);
    let tool = |tool: &str, position: [f64; 3], orientation: [f64; 4], opening: f64| ToolState {
        tool: tool.into(),
        model: "-".into(),
        status: ToolStatus::Tracked,
        pose: Pose {
            position,
            orientation,
        },
        opening,
    };
    let at = [scene.forceps, 0.0, 1e-3];
    host.send(&ToolStates {
        tools: vec![
            tool("left", at, [0.0, 0.0, 0.0, 1.0], 0.1),
            tool("right", [0.0; 3], turned_to(scene.handle), scene.opening),
        ],
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
        body: "vessel".into(),
        sticking_fraction: if scene.slides { 0.0 } else { 1.0 },
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

/// The scissors open something above the vessel, in the next tick.
pub fn cut(host: &mut TestHost<Module>, tool: &str) {
    host.send(&TissueCut {
        body: "vessel".into(),
        tool: tool.into(),
        area: 1e-8,
        centroid: [0.0, 0.0, 0.7e-3],
        valid: true,
        ..TissueCut::default()
    });
}

/// A level that has begun, with the vessel as it was.
pub fn started(free_length: f64, limits: Value) -> TestHost<Module> {
    let host = host(config(free_length, limits)).expect("a complete set-up");
    let mut host = host.moving();
    host.send(&LevelControl::Start);
    tick(&mut host, &Scene::default());
    host
}

pub fn value(result: &TrainingResult, metric: &str) -> Option<f64> {
    let metrics = result.metrics.iter();
    metrics.clone().find(|of| of.id == metric)?.value
}
