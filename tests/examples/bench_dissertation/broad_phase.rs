//! Section 4.3, figures 4.11 to 4.13: which nodes of one tube are in which tetrahedra of the other, while one passes through the other.
//!
//! What is timed is what the dissertation timed: all that finds these pairs, from new positions on, of each tube in the other; nothing is resolved. Every method must
//! find the same pairs.

use crate::plot::{Line, log_log};
use microsim_geometry::{Aabb, BroadPhase, Bvh, SpatialHash, point_in_tetrahedron};
use microsim_mesh::{Arc, CellSplit, Layer, TetMesh, Tube};
use microsim_tests::measured::thread_time;
use microsim_tests::simulated::simulate;
use microsim_tests::statistics::percentile;
use nalgebra::Vector3;
use std::fmt::Write as _;

type Point = Vector3<f64>;

/// Positions in a passage.
const POSITIONS: usize = 60;

/// Overlap of the tubes along the axis at the first and last position \[m\].
const PASSAGE: [f64; 2] = [-2e-3, 30e-3];

/// A picture of the dissertation's system \[s\]: 25 in a second (its section 3.1).
const PICTURE: f64 = 0.04;

/// Cells around, along and through the wall: 252 tetrahedra, the dissertation's 702, and finer ones.
const SIZES: [[usize; 3]; 6] = [
    [6, 7, 1],
    [9, 13, 1],
    [18, 26, 2],
    [27, 39, 3],
    [36, 52, 4],
    [47, 68, 5],
];

/// The dissertation's tube among them.
const PRINTED: usize = 1;

/// Without a broad phase a passage of a larger tube takes more than two minutes, and its time is known to grow with the square.
const LARGEST_WITHOUT: usize = 10_000;

/// Edges of a cell of the hash, over the mean edge of the mesh (the choice of Teschner et al. 2003 is 1).
const CELLS: [f64; 7] = [0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0];

/// How candidates are found.
#[derive(Clone, Copy, PartialEq)]
enum Finder {
    /// Every node in every tetrahedron.
    Without,
    /// Nodes in a hash with such cells, over mean edges; boxes of tetrahedra look them up.
    Hash(f64),
    /// Boxes of tetrahedra in a hierarchy that is refitted; nodes look them up, as contact does.
    Hierarchy,
}

impl Finder {
    fn name(self) -> String {
        match self {
            Self::Without => "every node in every tetrahedron".into(),
            Self::Hash(cell) => format!("spatial hash, cell {cell} mean edges"),
            Self::Hierarchy => "hierarchy of boxes, refitted".into(),
        }
    }
}

/// Two identical tubes, one of which passes into the other.
struct Passage {
    mesh: TetMesh,
    mean_edge: f64,
}

impl Passage {
    fn new([around, along, cells]: [usize; 3]) -> Self {
        let tube = Tube {
            center: [30e-3, 0.0, 0.0],
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
        let mesh = tube.mesh().expect("a tube");
        Self {
            mean_edge: mesh.mean_edge_length(),
            mesh,
        }
    }

    /// The second tube: 3 mm aside, turned by 10 degrees.
    fn second(&self, position: usize) -> Vec<Point> {
        let [first, last] = PASSAGE;
        let overlap = first + (last - first) * position as f64 / (POSITIONS - 1) as f64;
        let angle = 10_f64.to_radians();
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        let moved = self.mesh.positions.iter().map(|p| {
            let (y, z) = (cosine * p.y - sine * p.z, sine * p.y + cosine * p.z);
            Point::new(p.x + 60e-3 - overlap, y + 3e-3, z)
        });
        moved.collect()
    }

    /// CPU time at each position \[s\], and the number of nodes inside at each.
    fn pass(&self, finder: Finder) -> (Vec<f64>, Vec<usize>) {
        let first = &self.mesh.positions;
        let (mut hash, mut trees) = (SpatialHash::new(), [Bvh::new(), Bvh::new()]);
        let (mut boxes, mut pairs) = (Vec::new(), Vec::new());
        let mut found = Vec::new();
        let mut times = Vec::new();
        // What lies on a face counts as inside, to rounding.
        let bounds = |corners: &[Point; 4]| Aabb::of(corners).inflated(1e-6 * self.mean_edge);
        for position in 0..POSITIONS {
            let second = self.second(position);
            let start = thread_time();
            let mut inside = 0;
            for (side, (nodes, other)) in
                [(first, &second), (&second, first)].into_iter().enumerate()
            {
                let tets = || self.mesh.tets.iter();
                let corners = |tet: &[u32; 4]| tet.map(|node| other[node as usize]);
                let is_in = |node: &Point, tet: &[u32; 4]| {
                    point_in_tetrahedron(node, &corners(tet)).is_some()
                };
                if finder == Finder::Without {
                    for tet in tets() {
                        let corners = corners(tet);
                        let within = |node: &&Point| point_in_tetrahedron(node, &corners).is_some();
                        inside += nodes.iter().filter(within).count();
                    }
                    continue;
                }
                boxes.clear();
                if let Finder::Hash(cell) = finder {
                    boxes.extend(nodes.iter().map(|node| Aabb::of(&[*node])));
                    hash.rebuild(cell * self.mean_edge, &boxes);
                    for tet in tets() {
                        hash.visit(&bounds(&corners(tet)), |node| {
                            inside += usize::from(is_in(&nodes[node as usize], tet));
                        });
                    }
                } else {
                    boxes.extend(tets().map(|tet| bounds(&corners(tet))));
                    let tree = &mut trees[side];
                    tree.refit(&boxes);
                    boxes.clear();
                    boxes.extend(nodes.iter().map(|node| Aabb::of(&[*node])));
                    tree.pairs(&boxes, &mut pairs);
                    let hits = pairs.iter().filter(|[node, tet]| {
                        is_in(&nodes[*node as usize], &self.mesh.tets[*tet as usize])
                    });
                    inside += hits.count();
                }
            }
            times.push(thread_time() - start);
            found.push(inside);
        }
        (times, found)
    }
}

/// Measures and describes it; the drawings with their names.
pub fn measure(text: &mut String) -> Result<crate::Drawings, String> {
    let _ = writeln!(
        text,
        "\n## 4.3: broad phase\n\nTwo identical tubes (252 nodes and 702 tetrahedra each in the dissertation), 3 mm aside and turned by 10°, pass into each other by 30 mm in {POSITIONS} positions. \
         Timed is what figures 4.12 and 4.13 time: all that finds which nodes are in which tetrahedra, both ways. The figures are curves without numbers; the text states that without a \
         broad phase there is no real time, which then was a picture every 40 ms on an i7 of 2.67 GHz. Every method found the same pairs.\n"
    );
    let mut lines: Vec<Line> = Vec::new();
    let mut cells_lines: Vec<Line> = Vec::new();
    let mut over_cells = String::new();
    let _ = writeln!(
        text,
        "| tetrahedra | method | p50 | p99 | p50 over a picture of 40 ms |\n|---|---|---|---|---|"
    );
    for (index, size) in SIZES.into_iter().enumerate() {
        let passage = Passage::new(size);
        let tets = passage.mesh.tets.len();
        let hashes = CELLS.map(Finder::Hash);
        let finders = [Finder::Without, Finder::Hierarchy];
        let mut expected: Option<Vec<usize>> = None;
        let mut best: Vec<(f64, f64)> = Vec::new();
        for finder in finders.into_iter().chain(hashes) {
            if finder == Finder::Without && tets > LARGEST_WITHOUT {
                continue;
            }
            let (times, found) = passage.pass(finder);
            if *expected.get_or_insert(found.clone()) != found {
                return Err(format!("{} finds other nodes inside", finder.name()));
            }
            let (p50, p99) = (percentile(&times, 0.5), percentile(&times, 0.99));
            if let Finder::Hash(cell) = finder {
                best.push((cell, p50));
            }
            if matches!(finder, Finder::Hash(cell) if cell != 1.0) {
                continue;
            }
            let _ = writeln!(
                text,
                "| {tets} | {} | {:.3} ms | {:.3} ms | {:.2} % |",
                finder.name(),
                1e3 * p50,
                1e3 * p99,
                100.0 * p50 / PICTURE
            );
            let name = finder.name();
            let at = match lines.iter().position(|line| line.name == name) {
                Some(at) => at,
                None => {
                    lines.push(Line::new(name));
                    lines.len() - 1
                }
            };
            lines[at].push(tets as f64, 1e3 * p50);
        }
        let row: Vec<String> = best
            .iter()
            .map(|(_, time)| format!("{:.3}", 1e3 * time))
            .collect();
        let _ = writeln!(over_cells, "| {tets} | {} |", row.join(" | "));
        if index >= PRINTED {
            let mut line = Line::new(format!("{tets} tetrahedra"));
            for (cell, time) in best {
                line.push(cell, 1e3 * time);
            }
            cells_lines.push(line);
        }
    }
    let heads: Vec<String> = CELLS.iter().map(|cell| format!("{cell}")).collect();
    let _ = writeln!(
        text,
        "\n![time over the number of tetrahedra](dissertation/broad_phase.svg)\n\nThe hash over the size of its cells, in mean edges; p50 in ms:\n\n| tetrahedra | {} |\n|---|{}\n{over_cells}\n![time over the size of the cells](dissertation/hash_cells.svg)\n",
        heads.join(" | "),
        "---|".repeat(CELLS.len()),
    );
    contact(text)?;
    Ok(vec![
        (
            "broad_phase.svg",
            log_log("tetrahedra of a tube", "ms", &lines).into_bytes(),
        ),
        (
            "hash_cells.svg",
            log_log("edge of a cell over the mean edge", "ms", &cells_lines).into_bytes(),
        ),
    ])
}

/// Whole scenes with each broad phase: contact looks for more than nodes in tetrahedra, and its boxes hold over several steps.
fn contact(text: &mut String) -> Result<(), String> {
    let _ = writeln!(
        text,
        "In a whole scene (`microsim simulate SCENE --set run.broad_phase=NAME`), with forces, steps and contact of nodes, edges and faces; CPU s per simulated second. States are the same to the bit:\n\n| scene | bvh | spatial-hash | all-pairs |\n|---|---|---|---|"
    );
    for (scene, duration) in [("two-tubes", "80ms"), ("five-bodies", "100ms")] {
        let mut row = Vec::new();
        let mut states = Vec::new();
        for name in ["bvh", "spatial-hash", "all-pairs"] {
            let set = [
                format!("run.broad_phase={name}"),
                format!("run.duration={duration}"),
            ];
            let document = simulate(scene, &set)?;
            let number = |key: &str| document[key].as_f64().ok_or(format!("{scene}: no {key}"));
            row.push(format!("{:.2}", number("cpu_s")? / number("simulated_s")?));
            states.push(document["state_hash"].clone());
        }
        if states.iter().any(|state| *state != states[0]) {
            return Err(format!("{scene}: states differ"));
        }
        let _ = writeln!(text, "| {scene} | {} |", row.join(" | "));
    }
    Ok(())
}
