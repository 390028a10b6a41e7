//! What finding points of contact costs: CPU time of one call, for
//!
//! 1. the dissertation's pair of tubes (section 4.3), apart, as they meet, and one in the other;
//! 2. two waving sheets of 1,000 to 100,000 surface triangles that lie on one another, a sheet against itself, and a sheet
//!    against two tools of four capsules.
//!
//! Retained: nodes have moved so little since the last call that the lists of candidates hold. New: they have not.
//! The difference is the broad phase.
//!
//! `cargo run --release -p microsim-contact --example detect`

use microsim_contact::{CapsuleMotion, ContactPair, ContactSurface, Detector, Frame, Point, Sides};
use microsim_geometry::Capsule;
use microsim_mesh::{Arc, Block, CellSplit, Layer, TetMesh, Tube};
use nalgebra::{UnitQuaternion, Vector3};
use rustix::time::{ClockId, clock_gettime};

type V3 = Vector3<f64>;

fn main() {
    println!("CPU time of a call in microseconds, the fastest of several; points found.\n");
    tubes();
    sheets();
}

/// CPU time of this process \[s\].
fn cpu() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// A group, and how it moves.
struct Case {
    detector: Detector,
    rest: Vec<V3>,
    tools: Vec<Option<Vec<CapsuleMotion>>>,
    reach: f64,
    /// A step that changes no list, and one that changes all \[m\].
    steps: [f64; 2],
}

impl Case {
    /// The least time of a call with steps of each length, in microseconds, and the number of points.
    fn time(&mut self) -> ([f64; 2], usize) {
        let sides = Sides::new();
        let mut points: Vec<Point> = Vec::new();
        let mut least = [f64::INFINITY; 2];
        let calls = (200_000 / self.rest.len()).clamp(5, 300);
        for (kind, step) in self.steps.into_iter().enumerate() {
            for call in 0..calls {
                let shift = V3::x() * step * if call % 2 == 0 { 0.0 } else { 1.0 };
                let now: Vec<V3> = self.rest.iter().map(|p| p + shift).collect();
                let frame = Frame {
                    start: &now,
                    now: &now,
                    tools: &self.tools,
                    fraction: 1.0,
                    reach: self.reach,
                    sides: &sides,
                };
                let before = cpu();
                self.detector.find(&frame, &mut points);
                let time = 1e6 * (cpu() - before);
                if call > 1 {
                    least[kind] = least[kind].min(time);
                }
            }
        }
        (least, points.len())
    }
}

fn tubes() {
    let tube = |along: usize, around: usize, cells: usize| Tube {
        center: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        inner_radius: 8e-3,
        layers: vec![Layer {
            thickness: 2e-3,
            cells,
            region: 0,
        }],
        length: 60e-3,
        around,
        along,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    };
    println!(
        "{:<44}{:>10}{:>10}{:>10}",
        "two tubes", "retained", "new", "points"
    );
    for (name, along, around, cells) in [
        ("252 nodes each", 13, 9, 1),
        ("1,458 nodes each", 26, 18, 2),
    ] {
        let mesh = tube(along, around, cells).mesh().expect("a tube");
        let edge = mesh.mean_edge_length();
        for (place, gap, reach) in [
            ("apart", 2e-3, 0.0),
            ("touching", -0.05e-3, 0.0),
            ("touching, seen 0.5 mm ahead", 0.1e-3, 0.5e-3),
            ("30 mm in one another", -30e-3, 0.0),
        ] {
            let turn = UnitQuaternion::from_axis_angle(&V3::x_axis(), 10f64.to_radians());
            let other = mesh
                .positions
                .iter()
                .map(|p| turn * p + V3::new(60e-3 + gap, 3e-3, 0.0));
            let rest: Vec<V3> = mesh.positions.iter().copied().chain(other).collect();
            let surfaces = vec![
                ContactSurface::new(&mesh, 0),
                ContactSurface::new(&mesh, mesh.positions.len() as u32),
            ];
            let pair = ContactPair::Bodies {
                body: 0,
                with: 1,
                ends: None,
            };
            let mut case = Case {
                detector: Detector::new(surfaces, Vec::new(), vec![pair]),
                rest,
                tools: Vec::new(),
                reach,
                steps: [0.01 * edge, 0.3 * edge],
            };
            let ([retained, new], points) = case.time();
            println!(
                "{:<44}{retained:>10.1}{new:>10.1}{points:>10}",
                format!("{name}, {place}")
            );
        }
    }
}

/// A waving layer of `n` × `n` cells of edge length 1, the lower side at `height`.
fn sheet(n: usize, height: f64) -> TetMesh {
    let size = n as f64;
    let block = Block {
        center: [0.5 * size, 0.5 * size, height + 0.5],
        size: [size, size, 1.0],
        cells: [n, n, 1],
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().expect("a block");
    for p in &mut mesh.positions {
        p.z += 0.5 * libm::sin(0.3 * p.x) * libm::cos(0.2 * p.y);
    }
    mesh
}

fn sheets() {
    println!(
        "\n{:<24}{:>12}{:>10}{:>10}{:>10}{:>10}{:>10}",
        "", "triangles", "retained", "new", "broad", "points", "growth"
    );
    let mut before: [Option<(f64, f64)>; 3] = [None; 3];
    for triangles in [1_000, 3_000, 10_000, 30_000, 100_000] {
        let n = (f64::from(triangles) / 4.0).sqrt().round() as usize;
        let (lower, upper) = (sheet(n, 0.0), sheet(n, 0.98));
        for (kind, name) in ["two sheets", "sheet and itself", "sheet and two tools"]
            .into_iter()
            .enumerate()
        {
            let mut rest = lower.positions.clone();
            let mut surfaces = vec![ContactSurface::new(&lower, 0)];
            let mut tools = Vec::new();
            let mut pairs = Vec::new();
            match kind {
                0 => {
                    surfaces.push(ContactSurface::new(&upper, rest.len() as u32));
                    rest.extend(upper.positions.iter().map(|p| p + V3::new(0.3, 0.2, 0.0)));
                    pairs.push(ContactPair::Bodies {
                        body: 0,
                        with: 1,
                        ends: None,
                    });
                }
                1 => pairs.push(ContactPair::Itself { body: 0 }),
                _ => {
                    for tool in 0..2 {
                        let x = n as f64 * (0.4 + 0.2 * f64::from(tool));
                        let capsules = (0..4).map(|k| {
                            let capsule = Capsule {
                                a: V3::new(x, 8.0 + 2.0 * f64::from(k), 1.5),
                                b: V3::new(x, 10.0 + 2.0 * f64::from(k), 1.5),
                                radius: 0.7,
                            };
                            CapsuleMotion {
                                start: capsule,
                                end: capsule,
                            }
                        });
                        tools.push(Some(capsules.collect()));
                        pairs.push(ContactPair::Tool {
                            body: 0,
                            tool: tool as u32,
                        });
                    }
                }
            }
            let mut case = Case {
                detector: Detector::new(surfaces, Vec::new(), pairs),
                rest,
                tools,
                reach: 0.05,
                steps: [0.01, 0.3],
            };
            let ([retained, new], points) = case.time();
            let count = (4 * n * n + 4 * n) as f64;
            let growth = before[kind].map_or_else(String::new, |(count_before, time)| {
                format!(
                    "{:.2}",
                    libm::log(new / time) / libm::log(count / count_before)
                )
            });
            before[kind] = Some((count, new));
            let broad = new - retained;
            println!(
                "{name:<24}{count:>12}{retained:>10.1}{new:>10.1}{broad:>10.1}{points:>10}{growth:>10}"
            );
        }
    }
}
