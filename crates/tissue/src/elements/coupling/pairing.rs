//! Which node of one part is tied to which point of another.

use super::layer::{Layer, REACH};
use super::{Coupling, CouplingConstants, Sliding, SlidingConstants, Support, Tie, coordinates};
use crate::range::MaterialError;
use microsim_geometry::{closest_on_triangle, triangle_normal};
use microsim_mesh::TetMesh;
use nalgebra::Vector3;

/// Two triangles face each other when the angle between their outward normals is above 120°.
const FACING: f64 = -0.5;

/// Why two regions cannot be coupled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CoupleError {
    /// A constant is out of range.
    Constants(MaterialError),
    /// The boundaries of the two regions do not meet anywhere.
    NoInterface {
        /// The region whose nodes are tied.
        from: u32,
        /// The region that they are tied to.
        to: u32,
    },
}

impl std::fmt::Display for CoupleError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Constants(source) => write!(f, "{source}"),
            Self::NoInterface { from, to } => write!(
                f,
                "regions {from} and {to} do not meet: no boundary of one faces the other within {REACH} mean edge \
                 lengths"
            ),
        }
    }
}

impl std::error::Error for CoupleError {}

/// An outward triangle of a boundary.
struct Face {
    nodes: [u32; 3],
    corners: [Vector3<f64>; 3],
    normal: Vector3<f64>,
    element: u32,
    /// Among all triangles of the boundary.
    index: u32,
}

/// Ties every node of the interface of region `from` to region `to`. A node is on the interface when a boundary triangle at
/// it faces one of the other region within reach; its stiffness is that per area times its third of such triangles. It is
/// tied to the tetrahedron behind the nearest of them, in whose coordinates it may lie slightly outside: so every tie is at
/// rest in the rest shape. A node that belongs to both regions is tied already.
pub fn couple(
    mesh: &TetMesh,
    from: u32,
    to: u32,
    constants: &CouplingConstants,
) -> Result<Coupling, CoupleError> {
    constants.check().map_err(CoupleError::Constants)?;
    let pairs = pairs(mesh, from, to, constants.stiffness_per_area)?;
    let ties: Vec<Tie> = pairs.into_iter().map(|(tie, _)| tie).collect();
    Ok(Coupling::new(&ties, constants.bond))
}

/// As [`couple`], with ties that slide.
pub fn couple_sliding(
    mesh: &TetMesh,
    from: u32,
    to: u32,
    constants: &SlidingConstants,
) -> Result<Sliding, CoupleError> {
    constants.check().map_err(CoupleError::Constants)?;
    let pairs = pairs(mesh, from, to, constants.stiffness_per_area)?;
    let layer = Layer::new(mesh, to);
    Ok(Sliding::new(layer, &pairs, constants, &mesh.positions))
}

/// The ties of an interface, each with the number of its triangle among all of the boundary of `to`.
fn pairs(
    mesh: &TetMesh,
    from: u32,
    to: u32,
    stiffness_per_area: f64,
) -> Result<Vec<(Tie, u32)>, CoupleError> {
    let (sources, targets) = (boundary(mesh, from), boundary(mesh, to));
    let mut at_node: Vec<(u32, usize)> = Vec::with_capacity(3 * sources.len());
    for (index, face) in sources.iter().enumerate() {
        at_node.extend(face.nodes.map(|node| (node, index)));
    }
    at_node.sort_unstable();

    let reach = REACH * mesh.mean_edge_length();
    let mut ties = Vec::new();
    for fan in at_node.chunk_by(|a, b| a.0 == b.0) {
        let node = fan[0].0;
        let faces = || fan.iter().map(|(_, index)| &sources[*index]);
        let Some(target) = nearest(&mesh.positions[node as usize], faces, &targets, reach) else {
            continue;
        };
        let tet = mesh.tets[target.element as usize];
        if tet.contains(&node) {
            continue;
        }
        let area: f64 = faces()
            .filter(|face| face.normal.dot(&target.normal) < FACING)
            .map(|face| {
                let [a, b, c] = face.corners;
                (b - a).cross(&(c - a)).norm() / 6.0
            })
            .sum();
        let tie = Tie {
            node,
            support: Support::Tet(
                tet,
                coordinates(
                    &mesh.corners(target.element as usize),
                    &mesh.positions[node as usize],
                ),
            ),
            element: target.element,
            stiffness: stiffness_per_area * area,
        };
        ties.push((tie, target.index));
    }
    if ties.is_empty() {
        return Err(CoupleError::NoInterface { from, to });
    }
    Ok(ties)
}

/// The boundary of a region.
fn boundary(mesh: &TetMesh, region: u32) -> Vec<Face> {
    let faces = mesh.boundary_faces(|element| mesh.regions[element] == region);
    let face = |(index, (nodes, element)): (u32, ([u32; 3], u32))| {
        let corners = nodes.map(|node| mesh.positions[node as usize]);
        let normal = triangle_normal(&corners)?;
        Some(Face {
            nodes,
            corners,
            normal,
            element,
            index,
        })
    };
    (0..).zip(faces).filter_map(face).collect()
}

/// The triangle of `targets` nearest to `p` within `reach` that one of `faces` faces.
fn nearest<'a, F: Iterator<Item = &'a Face>>(
    p: &Vector3<f64>,
    faces: impl Fn() -> F,
    targets: &'a [Face],
    reach: f64,
) -> Option<&'a Face> {
    let mut best = None;
    let mut least = reach;
    for target in targets {
        // Farther from the plane than the best one so far: most end here.
        if (p - target.corners[0]).dot(&target.normal).abs() > least {
            continue;
        }
        let distance = (closest_on_triangle(p, &target.corners).point - p).norm();
        let faced = || faces().any(|face| face.normal.dot(&target.normal) < FACING);
        if distance <= least && faced() {
            // Of equally near ones the first.
            if best.is_none() || distance < least {
                best = Some(target);
            }
            least = distance;
        }
    }
    best
}
