//! Whether a mesh that was cut is valid and conforming: for tests and soaks. Its cost is proportional to the mesh.

use crate::topology::{FACES, NONE, Topology};
use microsim_geometry::signed_volume;
use microsim_mesh::TetMesh;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// What is wrong with a mesh and its topology.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flaw {
    /// An element without positive rest volume.
    Volume {
        /// The element.
        element: u32,
        /// Its volume \[m³\].
        volume: f64,
    },
    /// A face of more than two elements, or of two on the same side of it.
    Face {
        /// Its nodes.
        nodes: [u32; 3],
        /// Number of its elements.
        elements: usize,
    },
    /// The updated topology differs from that of the mesh at this element.
    Topology {
        /// The element.
        element: u32,
    },
    /// Elements that have this node alone in common, or nothing at it.
    Node {
        /// The node.
        node: u32,
        /// Number of parts around it without a common face.
        parts: usize,
    },
    /// The surface has a rim at this edge.
    Open {
        /// The edge.
        edge: [u32; 2],
    },
}

/// What can be compared before and after a cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measures {
    /// Rest volume \[m³\].
    pub volume: f64,
    /// Smallest rest volume of an element \[m³\].
    pub least_volume: f64,
    /// Area at rest of the surface that was there from the start \[m²\].
    pub outer_area: f64,
    /// For each sheet, from 1: area of all that it laid open, both sides \[m²\], and what is left of the sum of area vectors \[m²\].
    pub sheets: Vec<(f64, f64)>,
    /// Number of parts that hang together by faces.
    pub parts: usize,
}

/// Looks for flaws and takes measures.
pub fn check(mesh: &TetMesh, topology: &Topology) -> Result<Measures, Flaw> {
    let mut measures = Measures {
        least_volume: f64::INFINITY,
        sheets: vec![(0.0, 0.0); topology.sheets as usize],
        ..Measures::default()
    };
    for element in 0..mesh.tets.len() {
        let [a, b, c, d] = mesh.corners(element);
        let volume = signed_volume(&a, &b, &c, &d);
        // Written so that what is not a number is a flaw.
        if !matches!(volume.partial_cmp(&0.0), Some(std::cmp::Ordering::Greater)) {
            return Err(Flaw::Volume {
                element: element as u32,
                volume,
            });
        }
        measures.volume += volume;
        measures.least_volume = measures.least_volume.min(volume);
    }
    check_faces(mesh)?;
    let fresh = Topology::new(mesh);
    let same = |e: &usize| {
        let e = *e;
        topology.tets.get(e) == mesh.tets.get(e)
            && topology.neighbours.get(e) == fresh.neighbours.get(e)
    };
    let count = mesh.tets.len().max(topology.tets.len());
    if let Some(element) = (0..count).find(|e| !same(e)) {
        return Err(Flaw::Topology {
            element: element as u32,
        });
    }
    for node in 0..fresh.node_elements.len() {
        let parts = fresh.groups_at(node as u32).len();
        if parts != 1 || topology.node_elements.get(node) != fresh.node_elements.get(node) {
            return Err(Flaw::Node {
                node: node as u32,
                parts,
            });
        }
    }
    measure_surface(mesh, topology, &mut measures)?;
    measures.parts = parts(topology);
    Ok(measures)
}

fn check_faces(mesh: &TetMesh) -> Result<(), Flaw> {
    // Nodes of each face, and whether they run outward in the order of an even permutation of the sorted ones.
    let mut faces: Vec<([u32; 3], bool)> = Vec::with_capacity(4 * mesh.tets.len());
    for tet in &mesh.tets {
        for face in FACES {
            let nodes = face.map(|k| tet[k]);
            let mut sorted = nodes;
            sorted.sort_unstable();
            let first = nodes.iter().position(|n| *n == sorted[0]).unwrap_or(0);
            faces.push((sorted, nodes[(first + 1) % 3] == sorted[1]));
        }
    }
    faces.sort_unstable();
    for same in faces.chunk_by(|a, b| a.0 == b.0) {
        if same.len() > 2 || (same.len() == 2 && same[0].1 == same[1].1) {
            return Err(Flaw::Face {
                nodes: same[0].0,
                elements: same.len(),
            });
        }
    }
    Ok(())
}

fn measure_surface(
    mesh: &TetMesh,
    topology: &Topology,
    measures: &mut Measures,
) -> Result<(), Flaw> {
    let mut sums = vec![Vector3::zeros(); measures.sheets.len()];
    let mut edges: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for triangle in topology.surface() {
        let [a, b, c] = triangle.nodes.map(|n| mesh.positions[n as usize]);
        let vector = (b - a).cross(&(c - a)) * 0.5;
        match (triangle.sheet as usize).checked_sub(1) {
            None => measures.outer_area += vector.norm(),
            Some(k) => {
                measures.sheets[k].0 += vector.norm();
                sums[k] += vector;
            }
        }
        for k in 0..3 {
            let (i, j) = (triangle.nodes[k], triangle.nodes[(k + 1) % 3]);
            *edges.entry([i.min(j), i.max(j)]).or_default() += if i < j { 1 } else { -1 };
        }
    }
    for (sheet, sum) in measures.sheets.iter_mut().zip(&sums) {
        sheet.1 = sum.norm();
    }
    match edges.into_iter().find(|(_, sum)| *sum != 0) {
        Some((edge, _)) => Err(Flaw::Open { edge }),
        None => Ok(()),
    }
}

/// Number of parts that hang together by faces.
fn parts(topology: &Topology) -> usize {
    let mut seen = vec![false; topology.tets.len()];
    let mut parts = 0;
    for start in 0..seen.len() {
        if seen[start] {
            continue;
        }
        parts += 1;
        seen[start] = true;
        let mut open = vec![start];
        while let Some(element) = open.pop() {
            for other in topology.neighbours[element] {
                if other != NONE && !seen[other as usize] {
                    seen[other as usize] = true;
                    open.push(other as usize);
                }
            }
        }
    }
    parts
}
