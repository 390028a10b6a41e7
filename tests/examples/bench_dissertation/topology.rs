//! Sections 3.7, 4.2.1 and 4.4.3: the exchangeable change of topology, on a block whose cut is known exactly, and its cost over the number of elements.

use crate::plot::{Line, log_log};
use microsim_cutting::{Blade, Cut, Settings, Stroke, Sweep, Topology, TopologyChange};
use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_random::SplitMix64;
use microsim_tests::measured::thread_time;
use microsim_tissue::stability::{Part, limit, power_iteration};
use microsim_tissue::{Behaviour, Material, Method, SpringConstants, build_model};
use nalgebra::Vector3;
use std::fmt::Write as _;

type V3 = Vector3<f64>;

const CHANGES: [(&str, TopologyChange); 4] = [
    ("remove", TopologyChange::Remove),
    ("split-at-faces", TopologyChange::SplitAtFaces),
    ("semi-progressive", TopologyChange::SemiProgressive),
    ("progressive", TopologyChange::Progressive),
];

/// Half of the sides of the block \[mm\], and its cells of half a millimetre.
const HALF: [f64; 3] = [4.0, 2.0, 2.0];
const CELLS: [usize; 3] = [16, 8, 8];

/// How far nodes within are off a regular mesh, over a cell.
const JITTER: f64 = 0.1;

/// The plane of the cut: x = OFFSET + TILT·(y, z).
const OFFSET: f64 = 0.17;
const TILT: [f64; 2] = [0.3, 0.2];

/// Advance of the blade in a step \[mm\]: a third of a cell.
const STEP: f64 = 0.17;

/// Where the end of a blade goes that cuts in part \[mm\].
const PART: f64 = 0.6;

/// Cells across the blade in the sections that are cut in one step: 6 elements each, 6 to 10,086.
const SECTIONS: [usize; 9] = [1, 2, 3, 5, 8, 13, 20, 29, 41];

/// Cuts of which the fastest is taken.
const RUNS: usize = 5;

/// Iterations for the stiffest mode.
const ITERATIONS: usize = 200;

fn block() -> TetMesh {
    let block = Block {
        center: [0.0; 3],
        size: HALF.map(|half| 2.0 * half),
        cells: CELLS,
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().expect("a block");
    let mut random = SplitMix64(11);
    let cell = 2.0 * HALF[0] / CELLS[0] as f64;
    for place in &mut mesh.positions {
        let by = random.vector() * (JITTER * cell);
        let is_within = (0..3).all(|k| place[k].abs() < HALF[k] - 0.1 * cell);
        if is_within {
            *place += by;
        }
    }
    mesh
}

/// A place of the plane.
fn on_plane(y: f64, z: f64) -> V3 {
    V3::new(OFFSET + TILT[0] * y + TILT[1] * z, y, z)
}

/// Distance from the plane.
fn distance(place: &V3) -> f64 {
    let normal = V3::new(1.0, -TILT[0], -TILT[1]);
    (place - on_plane(0.0, 0.0)).dot(&normal).abs() / normal.norm()
}

/// Area of the plane over so much of y, through the whole height.
fn plane_area(width: f64) -> f64 {
    let slope = (1.0 + TILT[0] * TILT[0] + TILT[1] * TILT[1]).sqrt();
    width * 2.0 * HALF[2] * slope
}

struct Result {
    mesh: TetMesh,
    topology: Topology,
    lost: f64,
    area: f64,
    pieces: usize,
    /// Of all steps \[s\].
    time: f64,
}

/// Cuts down through the block with a blade that reaches to `end`.
fn cut(change: TopologyChange, end: f64) -> Result {
    let mesh = block();
    let mut of = Result {
        topology: Topology::new(&mesh),
        mesh,
        lost: 0.0,
        area: 0.0,
        pieces: 0,
        time: 0.0,
    };
    let settings = Settings {
        change,
        ..Settings::default()
    };
    let mut stroke = Stroke::new();
    let line = |z: f64| [on_plane(-3.0, z), on_plane(end, z)];
    let top = HALF[2] + 0.5;
    let count = (2.0 * top / STEP).ceil() as usize;
    for k in 0..count {
        let sweep = Sweep {
            before: line(top - STEP * k as f64),
            now: line(top - STEP * (k + 1) as f64),
        };
        let places = of.mesh.positions.clone();
        let blade = Blade::Sweep {
            sweeps: &[sweep],
            before: &places,
            now: &places,
        };
        let start = thread_time();
        let made = of.topology.cut(&of.mesh, &mut stroke, &blade, &settings);
        of.add(made.expect("a blade"), start);
    }
    let places = of.mesh.positions.clone();
    let start = thread_time();
    let made = of
        .topology
        .conclude_stroke(&of.mesh, &mut stroke, &places, &settings);
    of.add(made, start);
    of
}

impl Result {
    /// Adds a step that began at a CPU time \[s\].
    fn add(&mut self, cut: Option<Cut>, start: f64) {
        if let Some(cut) = cut {
            self.mesh.apply(&cut.edit).expect("an edit of this mesh");
            self.time += thread_time() - start;
            self.lost += cut.lost_volume;
            self.area += cut.opened[0].area;
            self.pieces += cut.pieces.len();
        } else {
            self.time += thread_time() - start;
        }
    }

    /// Mean and largest distance of the lips from the plane, over their area \[mm\].
    fn place(&self) -> [f64; 2] {
        let (mut sum, mut area, mut most) = (0.0, 0.0, 0.0_f64);
        for triangle in self.topology.surface() {
            if triangle.sheet == 0 {
                continue;
            }
            let [a, b, c] = triangle
                .nodes
                .map(|node| self.mesh.positions[node as usize]);
            let of = (b - a).cross(&(c - a)).norm();
            sum += of * distance(&((a + b + c) / 3.0));
            area += of;
            for corner in [a, b, c] {
                most = most.max(distance(&corner));
            }
        }
        [sum / area, most]
    }

    /// Smallest angle between two faces of an element \[degrees\].
    fn smallest_angle(&self) -> f64 {
        let angles = (0..self.mesh.tets.len()).flat_map(|e| dihedral_angles(&self.mesh.corners(e)));
        angles.fold(f64::INFINITY, f64::min).to_degrees()
    }

    /// The longest stable step with springs, whose constants go with the elements \[s\].
    fn stable_step(&self) -> f64 {
        let springs = SpringConstants::scaled(25e3, 5e4);
        let material = Material {
            density: 1060.0,
            relaxation_time: 0.0,
            behaviour: Behaviour::Springs(springs),
        };
        let mut mesh = self.mesh.clone();
        mesh.positions.iter_mut().for_each(|place| *place *= 1e-3);
        let free = vec![false; mesh.positions.len()];
        let model = build_model(&mesh, &[(0, material)], &free, 0.0, Vec::new());
        let model = model.expect("a valid mesh");
        let highest = power_iteration(&model, Part::Stiffness, ITERATIONS);
        limit(&Method::StoermerVerlet, highest, 0.0)
    }
}

/// The angles between the faces of a tetrahedron \[rad\]: at each edge, between the directions to the two other corners, seen along it.
fn dihedral_angles(corners: &[V3; 4]) -> [f64; 6] {
    let edges = [
        [0, 1, 2, 3],
        [0, 2, 1, 3],
        [0, 3, 1, 2],
        [1, 2, 0, 3],
        [1, 3, 0, 2],
        [2, 3, 0, 1],
    ];
    edges.map(|[i, j, k, l]: [usize; 4]| {
        let edge = corners[j] - corners[i];
        let u = edge.cross(&(corners[k] - corners[i]));
        let v = edge.cross(&(corners[l] - corners[i]));
        libm::atan2(u.cross(&v).norm(), u.dot(&v))
    })
}

/// Measures and describes it.
pub fn measure(text: &mut String) -> std::result::Result<crate::Drawings, String> {
    // A blade beside it.
    let mut whole = cut(TopologyChange::default(), -2.5);
    let uncut = whole.stable_step();
    let all: f64 = whole.mesh.volumes().iter().sum();
    let elements = whole.mesh.tets.len();
    whole.time = 0.0;
    let _ = writeln!(
        text,
        "\n## 3.7, 4.2.1: change of topology\n\nThe dissertation calls the algorithm exchangeable (4.4.3) and compares others in words (3.7). A block of 8 × 4 × 4 mm, {elements} tetrahedra of about half a millimetre, nodes within off a regular mesh by {:.0} % of a cell, is \
         cut along an oblique plane by a blade that advances {STEP} mm in a step; nothing moves meanwhile. Lost: mass, over that of the block. Area: what counts as laid open, against the plane. Off: mean and largest distance \
         of the lips from the plane. Angle: smallest between two faces of an element, {:.1}° before. Step: longest stable one of Störmer–Verlet with springs that go with the elements and without a mass floor, over that of the whole \
         block. Time: CPU time of all steps, with the edit of the mesh.\n",
        100.0 * JITTER,
        whole.smallest_angle(),
    );
    for (name, end) in [("right through", 3.0), ("in part", PART)] {
        let exact = plane_area(HALF[1] + end.min(HALF[1]));
        let _ = writeln!(
            text,
            "Cut {name}, {exact:.2} mm²:\n\n| `topology` | elements after | pieces | lost | area | off | angle | step | time |\n|---|---|---|---|---|---|---|---|---|"
        );
        for (key, change) in CHANGES {
            let of = cut(change, end);
            let [mean, most] = of.place();
            let _ = writeln!(
                text,
                "| `{key}` | {} | {} | {:.2} % | {:+.1} % | {mean:.3}, {most:.3} mm | {:.1}° | {:.2} | {:.1} ms |",
                of.mesh.tets.len(),
                of.pieces,
                100.0 * of.lost / all,
                100.0 * (of.area / exact - 1.0),
                of.smallest_angle(),
                of.stable_step() / uncut,
                1e3 * of.time,
            );
        }
        text.push('\n');
    }
    let drawing = over_number(text);
    Ok(vec![("cut_elements.svg", drawing.into_bytes())])
}

/// CPU time of one step over the number of elements that it divides, opens or takes away.
fn over_number(text: &mut String) -> String {
    let _ = writeln!(
        text,
        "The dissertation states O(k log k) for k elements that are cut. A blade passes through a layer of k tetrahedra of a block of 4 k in one step; the fastest of {RUNS}, without the edit of the mesh. If the time goes with k log k, the last columns are \
         constant.\n\n| `topology` | k | time | per element | over k log₂ k |\n|---|---|---|---|---|"
    );
    let mut lines = Vec::new();
    for (key, change) in CHANGES {
        let mut line = Line::new(key.to_owned());
        for side in SECTIONS {
            let count = 6 * side * side;
            let time = (0..RUNS)
                .map(|_| one_step(change, side))
                .fold(f64::INFINITY, f64::min);
            line.push(count as f64, time);
            let k = count as f64;
            let _ = writeln!(
                text,
                "| `{key}` | {count} | {:.3} ms | {:.2} µs | {:.3} µs |",
                1e3 * time,
                1e6 * time / k,
                1e6 * time / (k * libm::log2(k)),
            );
        }
        lines.push(line);
    }
    text.push_str(
        "\n![CPU time of a cut over the number of its elements](dissertation/cut_elements.svg)\n",
    );
    log_log("elements in one stroke", "CPU time [s]", &lines)
}

/// CPU time of a cut through a layer of so many cells squared \[s\].
fn one_step(change: TopologyChange, side: usize) -> f64 {
    let size = side as f64;
    let block = Block {
        center: [0.0; 3],
        size: [4.0, size, size],
        cells: [4, side, side],
        split: CellSplit::Kuhn,
    };
    let mesh = block.mesh().expect("a block");
    let mut topology = Topology::new(&mesh);
    let settings = Settings {
        change,
        ..Settings::default()
    };
    let line = |z: f64| [V3::new(0.3, -size, z), V3::new(0.3, size, z)];
    let sweep = Sweep {
        before: line(size),
        now: line(-size),
    };
    let places = &mesh.positions;
    let blade = Blade::Sweep {
        sweeps: &[sweep],
        before: places,
        now: places,
    };
    let mut stroke = Stroke::new();
    let start = thread_time();
    let cut = topology.cut(&mesh, &mut stroke, &blade, &settings);
    let time = thread_time() - start;
    let cut = cut.expect("a blade").expect("it goes through");
    assert_eq!(cut.pieces.len(), 1, "one part comes off");
    time
}
