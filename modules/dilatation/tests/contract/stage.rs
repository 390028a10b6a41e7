//! What the tests stand on: a level, a host, and a vessel that is snapshots alone.

use microsim_mesh::{Arc, CellSplit, Layer, TetMesh, Tube};
use microsim_module_dilatation::Module;
use microsim_sdk::message::{
    ContactForce, ContactForces, LevelControl, PartForce, Pose, RegionForce, SolverTick,
    TISSUE_ELEMENTS, TISSUE_SNAPSHOT, TissueCut, ToolState, ToolStates, ToolStatus, TrainingResult,
};
use microsim_sdk::{BlockBuilder, Fault, Published, TestHost, turned_to};
use serde_json::{Value, json};

/// \[s\]
pub const DWELL: f64 = 0.2;
/// Ticks of 8 ms for which something has to last for 0.2 s: time counts from the first one.
pub const STAY: u64 = 26;

/// Corners of a section.
pub const AROUND: usize = 48;
/// Inner radius of the vessel, which lies along x from where it is held, at 0, to its opening \[m\].
pub const RADIUS: f64 = 0.5e-3;
/// See [`RADIUS`].
pub const LENGTH: f64 = 3e-3;
/// How deep the dilator has to be \[m\].
pub const INSERTION: f64 = 0.8e-3;
/// How wide the opening has to stay \[m\].
pub const WIDE: f64 = 1.08e-3;

/// Where a vessel in two has been torn through: in a section of its mesh \[m\].
const TORN: f64 = 1.5e-3;

const MEDIA: u32 = 0;
const ADVENTITIA: u32 = 1;

pub fn limit(metric: &str, bounds: [Option<f64>; 2], reason: &str) -> Value {
    let [min, max] = bounds;
    let bound = min.or(max).expect("a bound");
    // What is worst for the score lies on the other side of the bound; which numbers these are does not matter here.
    let [full, zero] = match max {
        Some(max) => [0.0, 2.0 * max + 1e-9],
        None => [2.0 * bound, 0.0],
    };
    json!({
        "metric": metric, "min": min, "max": max, "full": full, "zero": zero,
        "source": "this test", "provisional": true, "decides": true, "reason": reason,
    })
}

/// A level of which a test makes another one.
pub fn config(limits: Value) -> Value {
    let tool = json!({
        "title": { "de": "-", "en": "-" }, "doc": "-", "hinge": null, "opening_angle": null, "colour": "#888888",
        "finish": "metal", "sharpness": 0.0, "capsule": [],
    });
    json!({
        "tools": [{ "name": "right", "model": "dilator" }, { "name": "left", "model": "forceps" }],
        "models": { "dilator": tool, "forceps": tool },
        "limits": limits,
        "metrics": {
            "idle_speed": 1e-4, "movement_speed": 1e-3, "smoothing": 0.05, "idle_smoothing": 0.08, "resample_rate": 60.0, "gap": 0.1,
            "shortest_path": null,
        },
        "own_metrics": [],
        "reasons": [],
        "module": {
            "held_end": [0.0, 0.0, 0.0], "open_end": [LENGTH, 0.0, 0.0], "insertion": INSERTION, "diameter": WIDE,
            "dwell": DWELL, "injury_stretch": 1.7,
        },
        "objects": [],
        "bodies": ["vessel"],
    })
}

pub fn host(config: Value) -> Result<TestHost<Module>, Fault> {
    TestHost::of_module(include_str!("../../module.toml"), 1, 2, config)
}

/// A level that has begun, with the vessel as it hung, and nobody there.
pub fn started(limits: Value) -> TestHost<Module> {
    let mut host = host(config(limits)).expect("a complete set-up").moving();
    host.send(&LevelControl::Start);
    host
}

/// Where the dilator is.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dilator {
    /// Of its tip behind the plane of the opening \[m\]; before it where it is negative.
    pub depth: f64,
    /// Of its tip beside the vessel's axis \[m\].
    pub aside: f64,
    /// 0 closed to 1 open.
    pub opening: f64,
    /// Size of its force on the vessel as a whole \[N\].
    pub force: f64,
    /// Force with which each of its jaws presses the wall apart \[N\], and in which direction, from z on \[rad\].
    pub spread: f64,
    /// See [`Dilator::spread`].
    pub direction: f64,
}

/// How a vessel has come apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Apart {
    /// Not at all.
    Whole,
    /// Its middle has been torn through: what carries the opening is a piece of its own.
    InTwo,
    /// It is slit along its whole length.
    Slit,
}

/// What the physics publishes in a tick.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// `None` while it is out of sight.
    pub dilator: Option<Dilator>,
    /// Forces of a grip of the forceps on media and adventitia \[N\].
    pub grip: [f64; 2],
    /// How much wider the opening is than at rest, along y and along z.
    pub wider: [f64; 2],
    /// Largest stretch of a quarter of the media by volume.
    pub stretch: f64,
    pub apart: Apart,
    /// How far the vessel, or what came off it, has been moved away \[m\].
    pub away: f64,
    /// Whether forces mean anything.
    pub valid: bool,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            dilator: None,
            grip: [0.0; 2],
            wider: [1.0; 2],
            stretch: 1.0,
            apart: Apart::Whole,
            away: 0.0,
            valid: true,
        }
    }
}

fn layer(inner_radius: f64, thickness: f64, region: u32) -> TetMesh {
    let tube = Tube {
        center: [0.5 * LENGTH, 0.0, 0.0],
        axis: [1.0, 0.0, 0.0],
        inner_radius,
        layers: vec![Layer {
            thickness,
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
    let layers = [
        (layer(RADIUS, 0.1e-3, MEDIA), MEDIA),
        (layer(RADIUS + 0.1e-3, 0.1e-3, ADVENTITIA), ADVENTITIA),
    ];
    let (mut rest, mut triangles, mut regions) = (Vec::new(), Vec::<[u32; 3]>::new(), Vec::new());
    for (mesh, region) in &layers {
        let first = rest.len() as u32;
        rest.extend(mesh.positions.iter().map(|p| [p.x, p.y, p.z]));
        for triangle in &mesh.surface().triangles {
            triangles.push(triangle.map(|node| node + first));
            regions.push(*region);
        }
    }
    let is_off = |[x, ..]: [f64; 3]| scene.apart == Apart::InTwo && x > TORN;
    // What lies across the tear is gone.
    let is_across = |nodes: &[u32; 3]| {
        let off = nodes.map(|node| is_off(rest[node as usize]));
        off != [off[0]; 3]
    };
    let all = triangles.into_iter().zip(regions);
    let left = all.filter(|(nodes, _)| !is_across(nodes));
    let (triangles, regions): (Vec<[u32; 3]>, Vec<u32>) = left.unzip();
    let is_opened = |nodes: &[u32; 3]| match scene.apart {
        Apart::Whole => false,
        Apart::InTwo => nodes
            .iter()
            .any(|node| (rest[*node as usize][0] - TORN).abs() < 1e-9),
        // Upwards, over three strips or so, whichever way their corners lie.
        Apart::Slit => {
            let middle = nodes.map(|node| rest[node as usize]);
            let [y, z] = [1, 2].map(|k| middle.iter().map(|p| p[k]).sum::<f64>());
            z > 0.0 && y.abs() < 0.2 * z
        }
    };
    let now = |[x, y, z]: [f64; 3]| {
        // 1 at the opening, 0 where the vessel is held.
        let free = x / LENGTH;
        let [wide, high] = scene.wider.map(|wider| 1.0 + (wider - 1.0) * free);
        let moves = scene.apart == Apart::Whole || is_off([x, y, z]);
        let away = if moves { scene.away } else { 0.0 };
        [x, wide * y + away, high * z]
    };
    let generation = u64::from(scene.apart != Apart::Whole);
    let block = BlockBuilder::new(TISSUE_SNAPSHOT, "vessel", generation, 0)
        .u32s("node_id", 0..rest.len() as u32)
        .f64s("position", rest.iter().flat_map(|place| now(*place)))
        .u32s("piece", rest.iter().map(|place| u32::from(is_off(*place))))
        .u32s("triangle", triangles.iter().flatten().copied())
        .u32s("inner", triangles.iter().map(|of| u32::from(is_opened(of))));
    host.send_block(&block.finish());
    let block = BlockBuilder::new(TISSUE_ELEMENTS, "vessel", generation, 0)
        .f64s("rest", rest.iter().flatten().copied())
        .u32s("triangle_region", regions)
        .u32s("region", [MEDIA, MEDIA, ADVENTITIA])
        .f64s("volume", [3e-9, 1e-9, 4e-9])
        .f64s("stretch", [1.0, scene.stretch, 9.0]);
    host.send_block(&block.finish());
}

fn contacts(scene: &Scene) -> Vec<ContactForce> {
    let mut contacts = Vec::new();
    if let Some(of) = scene.dilator.filter(|of| of.force > 0.0 || of.spread > 0.0) {
        let apart = [
            0.0,
            -of.spread * libm::sin(of.direction),
            of.spread * libm::cos(of.direction),
        ];
        let jaw = |part: &str, sign: f64| PartForce {
            part: part.into(),
            force: apart.map(|c| sign * c),
            normal_force: of.spread,
            nodes: 1,
            ..PartForce::default()
        };
        contacts.push(ContactForce {
            partner: "right".into(),
            body: "vessel".into(),
            force: [of.force, 0.0, 0.0],
            sustained_force: of.force,
            pieces: vec![0],
            parts: vec![jaw("left-tip", 1.0), jaw("right-tip", -1.0)],
            ..ContactForce::default()
        });
    }
    let [media, adventitia] = scene.grip;
    let grip = media + adventitia;
    if grip > 0.0 {
        let on = |region: u32, force: f64| RegionForce {
            region,
            normal_force: 2.0 * force,
            ..RegionForce::default()
        };
        contacts.push(ContactForce {
            partner: "left".into(),
            body: "vessel".into(),
            sticking_fraction: 1.0,
            grip_force: grip,
            sustained_grip: grip,
            pieces: vec![0],
            regions: vec![on(MEDIA, media), on(ADVENTITIA, adventitia)],
            ..ContactForce::default()
        });
    }
    contacts
}

pub fn tick(host: &mut TestHost<Module>, scene: &Scene) -> Published {
    send_vessel(host, scene);
    let tool = |tool: &str, status, pose, opening| ToolState {
        tool: tool.into(),
        model: "-".into(),
        status,
        pose,
        opening,
    };
    let dilator = match scene.dilator {
        None => tool("right", ToolStatus::Occluded, Pose::default(), 0.0),
        Some(of) => {
            let pose = Pose {
                position: [LENGTH - of.depth, of.aside, 0.0],
                orientation: turned_to([1.0, 0.0, 0.0]),
            };
            tool("right", ToolStatus::Tracked, pose, of.opening)
        }
    };
    let forceps = match scene.grip == [0.0; 2] {
        true => tool("left", ToolStatus::Occluded, Pose::default(), 0.0),
        false => tool("left", ToolStatus::Tracked, Pose::default(), 0.1),
    };
    host.send(&ToolStates {
        tools: vec![dilator, forceps],
    });
    host.send(&SolverTick {
        steps: 1,
        valid: scene.valid,
        ..SolverTick::default()
    });
    host.send(&ContactForces {
        contacts: contacts(scene),
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

/// The media tears by itself.
pub fn tear(host: &mut TestHost<Module>, area: f64) {
    host.send(&TissueCut {
        body: "vessel".into(),
        area,
        valid: true,
        ..TissueCut::default()
    });
}

pub fn value(result: &TrainingResult, metric: &str) -> Option<f64> {
    let metrics = result.metrics.iter();
    metrics.clone().find(|of| of.id == metric)?.value
}
