//! What the tests stand on: a level, a host, and a vessel of two layers that is snapshots alone.

use microsim_mesh::{Arc, CellSplit, Layer, TetMesh, Tube};
use microsim_module_trim_blunt::Module;
use microsim_sdk::message::{
    ContactForce, ContactForces, LevelControl, RegionForce, SolverTick, TISSUE_ELEMENTS,
    TISSUE_SNAPSHOT, TrainingResult,
};
use microsim_sdk::message::{Pose, ToolState, ToolStates, ToolStatus};
use microsim_sdk::{BlockBuilder, Fault, Published, TestHost};
use serde_json::{Value, json};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// \[s\]
pub const STAY_TIME: f64 = 0.2;
/// Ticks of 8 ms for which something has to last for 0.2 s: time counts from the first one.
pub const STAY: u64 = 26;

/// The vessel lies along x from where it is held, at 0, to its end \[m\].
pub const LENGTH: f64 = 3e-3;
/// How far its media is to be bare \[m\], and how evenly.
pub const BARE: f64 = 0.7e-3;
/// See [`BARE`].
pub const EVEN: f64 = 0.85;

/// Corners of a section: a multiple of the sixteen directions in which the module looks, turned against them by nothing.
const AROUND: usize = 64;
const MEDIA: u32 = 0;
const ADVENTITIA: u32 = 1;

pub fn limit(metric: &str, max: f64, reason: &str) -> Value {
    json!({
        "metric": metric, "min": null, "max": max, "full": 0.0, "zero": 2.0 * max,
        "source": "this test", "provisional": true, "decides": true, "reason": reason,
    })
}

/// A level of which a test makes another one.
pub fn config(limits: Value) -> Value {
    let forceps = json!({
        "title": { "de": "-", "en": "-" }, "doc": "-", "hinge": null, "opening_angle": null, "colour": "#888888",
        "finish": "metal", "sharpness": 0.0, "capsule": [],
    });
    let object = |name: &str, x: f64| {
        json!({
            "name": name, "shape": "box", "half_size": [0.001, 0.001, 0.001], "position": [x, 0.0, 0.0],
            "orientation": [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2], "colour": "#888888", "finish": "matte",
            "active": true,
        })
    };
    json!({
        "tools": [{ "name": "left", "model": "forceps" }, { "name": "right", "model": "forceps" }],
        "models": { "forceps": forceps },
        "limits": limits,
        "metrics": {
            "idle_speed": 1e-4, "movement_speed": 1e-3, "smoothing": 0.05, "idle_smoothing": 0.08, "resample_rate": 60.0, "gap": 0.1,
            "shortest_path": null,
        },
        "own_metrics": [],
        "reasons": [],
        "module": { "free_length": BARE, "evenness": EVEN, "stay": STAY_TIME, "injuring_stretch": 1.3 },
        "objects": [object("clamp", 0.0), object("mark-1", 0.0)],
        "bodies": ["vessel"],
    })
}

pub fn host(config: Value) -> Result<TestHost<Module>, Fault> {
    TestHost::of_module(include_str!("../../module.toml"), 1, 2, config)
}

/// A level that has begun, and nobody there.
pub fn started(limits: Value) -> TestHost<Module> {
    let mut host = host(config(limits)).expect("a complete set-up").moving();
    host.send(&LevelControl::Start);
    host
}

/// What a tool does to the vessel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Touch {
    /// Size of its force \[N\].
    pub force: f64,
    /// Forces of its grip on media and adventitia \[N\].
    pub grip: [f64; 2],
}

/// What the physics publishes in a tick.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// How far the adventitia is pushed back from the end, mean around the vessel; negative where it hangs over \[m\].
    pub bare: f64,
    /// Upwards the media is barer than in the mean by this part of it, and downwards less.
    pub uneven: f64,
    /// What the left forceps do; `None` while they are out of sight.
    pub tool: Option<Touch>,
    /// Largest stretch of a quarter of the media by volume.
    pub stretch: f64,
    /// How far the whole vessel has been moved along itself and aside \[m\].
    pub moved: [f64; 2],
    /// Whether forces mean anything.
    pub valid: bool,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            bare: 0.0,
            uneven: 0.0,
            tool: None,
            stretch: 1.0,
            moved: [0.0; 2],
            valid: true,
        }
    }
}

fn layer(inner_radius: f64, region: u32) -> TetMesh {
    let tube = Tube {
        center: [0.5 * LENGTH, 0.0, 0.0],
        axis: [1.0, 0.0, 0.0],
        inner_radius,
        layers: vec![Layer {
            thickness: 0.15e-3,
            cells: 1,
            region,
        }],
        length: LENGTH,
        around: AROUND,
        along: 6,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    };
    tube.mesh().expect("a tube")
}

fn send_vessel(host: &mut TestHost<Module>, scene: &Scene) {
    let (mut rest, mut triangles, mut regions) = (Vec::new(), Vec::new(), Vec::new());
    let mut now = Vec::new();
    for (radius, region) in [(0.35e-3, MEDIA), (0.5e-3, ADVENTITIA)] {
        let mesh = layer(radius, region);
        let first = rest.len() as u32;
        for p in &mesh.positions {
            // 1 upwards, -1 downwards; 1 at the end, 0 where the vessel is held.
            let (upwards, free) = (p.z / libm::hypot(p.y, p.z), p.x / LENGTH);
            let back = match region {
                MEDIA => 0.0,
                _ => free * scene.bare * (1.0 + scene.uneven * upwards),
            };
            let [along, aside] = scene.moved;
            rest.push([p.x, p.y, p.z]);
            now.push([p.x - back + along, p.y + aside, p.z]);
        }
        for triangle in &mesh.surface().triangles {
            triangles.push(triangle.map(|node| node + first));
            regions.push(region);
        }
    }
    let block = BlockBuilder::new(TISSUE_SNAPSHOT, "vessel", 0, 0)
        .u32s("node_id", 0..rest.len() as u32)
        .f64s("position", now.into_iter().flatten())
        .u32s("piece", rest.iter().map(|_| 0))
        .u32s("triangle", triangles.iter().flatten().copied())
        .u32s("inner", triangles.iter().map(|_| 0));
    host.send_block(&block.finish());
    let block = BlockBuilder::new(TISSUE_ELEMENTS, "vessel", 0, 0)
        .f64s("rest", rest.iter().flatten().copied())
        .u32s("triangle_region", regions)
        .u32s("region", [MEDIA, MEDIA, ADVENTITIA])
        .f64s("volume", [3e-9, 1e-9, 4e-9])
        .f64s("stretch", [1.0, scene.stretch, 9.0]);
    host.send_block(&block.finish());
}

pub fn tick(host: &mut TestHost<Module>, scene: &Scene) -> Published {
    send_vessel(host, scene);
    let tool = |tool: &str, status| ToolState {
        tool: tool.into(),
        model: "-".into(),
        status,
        pose: Pose {
            position: [LENGTH + 5e-3, 0.0, 0.0],
            ..Pose::default()
        },
        opening: 0.3,
    };
    let status = match scene.tool {
        Some(_) => ToolStatus::Tracked,
        None => ToolStatus::Occluded,
    };
    host.send(&ToolStates {
        tools: vec![tool("left", status), tool("right", ToolStatus::Occluded)],
    });
    host.send(&SolverTick {
        steps: 1,
        valid: scene.valid,
        ..SolverTick::default()
    });
    let touch = scene.tool.filter(|of| of.force > 0.0);
    let contact = touch.map(|Touch { force, grip }| {
        let on = |region: u32, force: f64| RegionForce {
            region,
            normal_force: 2.0 * force,
            ..RegionForce::default()
        };
        let [media, adventitia] = grip;
        ContactForce {
            partner: "left".into(),
            body: "vessel".into(),
            force: [-force, 0.0, 0.0],
            peak_force: force,
            sustained_force: force,
            sticking_fraction: 1.0,
            grip_force: media + adventitia,
            sustained_grip: media + adventitia,
            pieces: vec![0],
            regions: vec![on(MEDIA, media), on(ADVENTITIA, adventitia)],
            ..ContactForce::default()
        }
    });
    host.send(&ContactForces {
        contacts: contact.into_iter().collect(),
        between: Vec::new(),
    });
    host.tick().expect("a good tick")
}

/// Ticks of a scene until there is a result, so many at most.
pub fn ticks(host: &mut TestHost<Module>, scene: &Scene, count: u64) -> Option<TrainingResult> {
    (0..count).find_map(|_| tick(host, scene).last())
}

/// The input ends while this is so.
pub fn end(host: &mut TestHost<Module>, scene: &Scene) -> TrainingResult {
    host.send(&LevelControl::InputEnded);
    let result = tick(host, scene).last();
    result.expect("a verdict when the input has ended")
}

pub fn value(result: &TrainingResult, metric: &str) -> Option<f64> {
    let metrics = result.metrics.iter();
    metrics.clone().find(|of| of.id == metric)?.value
}

/// By how much a chord between two corners lies within the circle at most, of its radius: what a length between corners may be off by.
pub fn chord() -> f64 {
    1.0 - libm::cos(PI / AROUND as f64)
}
