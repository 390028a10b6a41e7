//! Validity of a tetrahedral mesh: what is wrong with it, where, and what helps.

use crate::TetMesh;
use crate::tet_mesh::FACES;
use crate::topology::{Groups, edge_uses, pinched_nodes};
use microsim_geometry::signed_volume;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// An element is flat when its volume is at most this fraction of the cube of its longest edge (0.118 in the regular one).
pub const FLAT: f64 = 1e-6;

/// Nodes coincide when they are closer than this fraction of the mean edge: more than the six digits of a text file leave.
pub const COINCIDING: f64 = 1e-4;

/// How bad a defect is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Nothing can be computed on this mesh, or not what it seems.
    Error,
    /// It can be computed; look whether it is meant.
    Warning,
}

/// A node or element as a report names it: by its index now and its id for ever.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Named {
    /// Index in the mesh.
    pub index: u32,
    /// Stable id.
    pub id: u32,
}

impl std::fmt::Display for Named {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} (id {})", self.index, self.id)
    }
}

/// Something wrong with a tetrahedral mesh.
#[derive(Clone, Debug, PartialEq)]
pub enum Defect {
    /// The mesh has no element.
    Empty,
    /// A coordinate is NaN or infinite.
    NotFinite {
        /// The node.
        node: Named,
    },
    /// An element names a node that is not there.
    NodeOutOfRange {
        /// The element.
        element: Named,
        /// The node index it names.
        node: u32,
        /// Number of nodes.
        nodes: usize,
    },
    /// An element names a node twice.
    RepeatedNode {
        /// The element.
        element: Named,
        /// The node.
        node: Named,
    },
    /// The volume of an element is negative.
    Inverted {
        /// The element.
        element: Named,
        /// Its volume \[m³\].
        volume: f64,
    },
    /// An element has no volume to speak of: see [`FLAT`].
    Flat {
        /// The element.
        element: Named,
        /// Its volume over the cube of its longest edge.
        ratio: f64,
    },
    /// Two elements have the same four nodes.
    Duplicated {
        /// The later one.
        element: Named,
        /// The earlier one.
        first: Named,
    },
    /// More than two elements at a face.
    FaceNotManifold {
        /// The nodes of the face.
        face: [Named; 3],
        /// The first of its elements.
        element: Named,
        /// Number of its elements.
        count: usize,
    },
    /// More than two triangles of the boundary at an edge.
    EdgeNotManifold {
        /// The nodes of the edge.
        edge: [Named; 2],
        /// Number of triangles.
        count: usize,
    },
    /// The boundary touches itself in a node only.
    NodeNotManifold {
        /// The node.
        node: Named,
        /// Number of sheets that meet there.
        sheets: usize,
    },
    /// A node that no element names.
    UnusedNode {
        /// The node.
        node: Named,
    },
    /// Two nodes in one place: see [`COINCIDING`].
    CoincidingNodes {
        /// The nodes.
        nodes: [Named; 2],
        /// Their distance \[m\].
        distance: f64,
    },
    /// The mesh falls into parts without a common node.
    Components {
        /// Number of parts.
        count: usize,
    },
}

impl Defect {
    /// How bad it is.
    pub fn severity(&self) -> Severity {
        match self {
            Self::EdgeNotManifold { .. }
            | Self::NodeNotManifold { .. }
            | Self::CoincidingNodes { .. }
            | Self::Components { .. } => Severity::Warning,
            _ => Severity::Error,
        }
    }
}

impl std::fmt::Display for Defect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Empty => write!(
                f,
                "the mesh has no tetrahedron: export volume elements, not only the surface"
            ),
            Self::NotFinite { node } => write!(
                f,
                "node {node} has a coordinate that is not a finite number: correct its position"
            ),
            Self::NodeOutOfRange {
                element,
                node,
                nodes,
            } => write!(
                f,
                "element {element} names node {node}, but there are only nodes 0 to {}: correct its nodes (do they count from 1?)",
                *nodes as i64 - 1
            ),
            Self::RepeatedNode { element, node } => write!(
                f,
                "element {element} names node {node} more than once: remove the element"
            ),
            Self::Inverted { element, volume } => write!(
                f,
                "element {element} is inverted (volume {volume:.3e} m³): swap two of its nodes, or move the node that went through it"
            ),
            Self::Flat { element, ratio } => write!(
                f,
                "element {element} is flat (volume {ratio:.1e} of its longest edge cubed, at least {FLAT:.0e} expected): remesh around it or remove it"
            ),
            Self::Duplicated { element, first } => write!(
                f,
                "element {element} has the same nodes as element {first}: remove one of them"
            ),
            Self::FaceNotManifold {
                face: [a, b, c],
                element,
                count,
            } => write!(
                f,
                "the face of nodes {a}, {b}, {c} belongs to {count} elements, the first is {element}; at most 2 expected: remove those that overlap"
            ),
            Self::EdgeNotManifold {
                edge: [a, b],
                count,
            } => write!(
                f,
                "{count} triangles of the surface meet at the edge of nodes {a} and {b}, 2 expected: the parts touch along a line only; join or separate them there"
            ),
            Self::NodeNotManifold { node, sheets } => write!(
                f,
                "{sheets} sheets of the surface meet at node {node}, 1 expected: the parts touch in a point only; join or separate them there"
            ),
            Self::UnusedNode { node } => write!(
                f,
                "node {node} belongs to no element, so it has no mass: remove it"
            ),
            Self::CoincidingNodes {
                nodes: [a, b],
                distance,
            } => write!(
                f,
                "nodes {a} and {b} lie in one place ({distance:.1e} m apart): merge them unless the parts are meant to be apart"
            ),
            Self::Components { count } => write!(
                f,
                "the mesh falls into {count} parts without a common node: merge their common nodes unless they are meant to be apart"
            ),
        }
    }
}

/// Everything wrong with `mesh`; empty when nothing is. Elements whose nodes are out of range, repeated or not finite take
/// no part in the later checks.
///
/// ```
/// use microsim_mesh::{Severity, TetMesh, defects};
/// use nalgebra::Vector3;
///
/// // Two corners exchanged: the element is inverted.
/// let corners = vec![Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
/// let mesh = TetMesh::new(corners, vec![[1, 0, 2, 3]], vec![0]);
/// let found = defects(&mesh);
/// assert_eq!(found.len(), 1);
/// assert_eq!(found[0].severity(), Severity::Error);
/// assert!(found[0].to_string().contains("inverted"));
/// ```
pub fn defects(mesh: &TetMesh) -> Vec<Defect> {
    defects_but_detached(mesh, &[])
}

/// The same of a mesh of which these regions have nodes of their own on purpose ([`TetMesh::detached`]): nodes of one of them and of another
/// region in one place join what lies there, and are no defect.
pub fn defects_but_detached(mesh: &TetMesh, detached: &[u32]) -> Vec<Defect> {
    let mut found = Vec::new();
    if mesh.tets.is_empty() {
        found.push(Defect::Empty);
    }
    let finite: Vec<bool> = mesh
        .positions
        .iter()
        .map(|p| p.iter().all(|x| x.is_finite()))
        .collect();
    for (i, _) in finite.iter().enumerate().filter(|(_, finite)| !**finite) {
        found.push(Defect::NotFinite {
            node: node(mesh, i as u32),
        });
    }
    unused_nodes(mesh, &mut found);
    let sound = elements(mesh, &finite, &mut found);
    faces(mesh, &sound, &mut found);
    let close = coinciding(mesh, &sound, &finite);
    let owners = owners(mesh, &sound, detached);
    let (apart, defects): (Vec<_>, Vec<_>) = close
        .into_iter()
        .partition(|(i, j, _)| owners[*i as usize] != owners[*j as usize]);
    components(mesh, &sound, &apart, &mut found);
    found.extend(defects.into_iter().map(|(i, j, distance)| {
        let nodes = [node(mesh, i), node(mesh, j)];
        Defect::CoincidingNodes { nodes, distance }
    }));
    found
}

fn node(mesh: &TetMesh, index: u32) -> Named {
    let id = mesh
        .node_ids
        .get(index as usize)
        .copied()
        .unwrap_or(u32::MAX);
    Named { index, id }
}

fn element(mesh: &TetMesh, index: usize) -> Named {
    let id = mesh.element_ids.get(index).copied().unwrap_or(u32::MAX);
    Named {
        index: index as u32,
        id,
    }
}

fn unused_nodes(mesh: &TetMesh, found: &mut Vec<Defect>) {
    let mut used = vec![false; mesh.positions.len()];
    for &i in mesh.tets.iter().flatten() {
        if let Some(used) = used.get_mut(i as usize) {
            *used = true;
        }
    }
    for (i, _) in used.iter().enumerate().filter(|(_, used)| !**used) {
        found.push(Defect::UnusedNode {
            node: node(mesh, i as u32),
        });
    }
}

/// Checks each element by itself; returns which can take part in the later checks.
fn elements(mesh: &TetMesh, finite: &[bool], found: &mut Vec<Defect>) -> Vec<bool> {
    let nodes = mesh.positions.len();
    let mut sound = Vec::with_capacity(mesh.tets.len());
    for (e, tet) in mesh.tets.iter().enumerate() {
        let mut sorted = *tet;
        sorted.sort_unstable();
        let repeated = sorted.windows(2).find(|pair| pair[0] == pair[1]);
        let outside = tet.iter().find(|&&i| i as usize >= nodes);
        if let Some(&outside) = outside {
            found.push(Defect::NodeOutOfRange {
                element: element(mesh, e),
                node: outside,
                nodes,
            });
        }
        if let Some(pair) = repeated {
            found.push(Defect::RepeatedNode {
                element: element(mesh, e),
                node: node(mesh, pair[0]),
            });
        }
        let usable =
            outside.is_none() && repeated.is_none() && tet.iter().all(|&i| finite[i as usize]);
        sound.push(usable);
        if !usable {
            continue;
        }
        let [a, b, c, d] = mesh.corners(e);
        let volume = signed_volume(&a, &b, &c, &d);
        let longest = [b - a, c - a, d - a, c - b, d - b, d - c]
            .iter()
            .map(Vector3::norm)
            .fold(0.0, f64::max);
        let cube = longest * longest * longest;
        if volume.abs() <= FLAT * cube {
            found.push(Defect::Flat {
                element: element(mesh, e),
                ratio: if cube > 0.0 { volume.abs() / cube } else { 0.0 },
            });
        } else if volume < 0.0 {
            found.push(Defect::Inverted {
                element: element(mesh, e),
                volume,
            });
        }
    }
    sound
}

/// Duplicated elements, shared faces, and the boundary's edges and nodes.
fn faces(mesh: &TetMesh, sound: &[bool], found: &mut Vec<Defect>) {
    let mut first: BTreeMap<[u32; 4], usize> = BTreeMap::new();
    let mut owners: BTreeMap<[u32; 3], Vec<usize>> = BTreeMap::new();
    for (e, tet) in mesh.tets.iter().enumerate().filter(|(e, _)| sound[*e]) {
        let mut key = *tet;
        key.sort_unstable();
        if let Some(&first) = first.get(&key) {
            found.push(Defect::Duplicated {
                element: element(mesh, e),
                first: element(mesh, first),
            });
            // Its faces would only say the same again.
            continue;
        }
        first.insert(key, e);
        for face in FACES {
            let mut key = face.map(|corner| tet[corner]);
            key.sort_unstable();
            owners.entry(key).or_default().push(e);
        }
    }
    for (face, elements) in &owners {
        if elements.len() > 2 {
            found.push(Defect::FaceNotManifold {
                face: face.map(|i| node(mesh, i)),
                element: element(mesh, elements[0]),
                count: elements.len(),
            });
        }
    }
    let boundary: Vec<[u32; 3]> = owners
        .into_iter()
        .filter(|(_, elements)| elements.len() == 1)
        .map(|(face, _)| face)
        .collect();
    for shared in edge_uses(&boundary) {
        if shared.triangles.len() > 2 {
            found.push(Defect::EdgeNotManifold {
                edge: shared.edge.map(|i| node(mesh, i)),
                count: shared.triangles.len(),
            });
        }
    }
    for (i, sheets) in pinched_nodes(&boundary) {
        found.push(Defect::NodeNotManifold {
            node: node(mesh, i),
            sheets,
        });
    }
}

/// For each node the detached region to which it belongs, as one more than its place in the list; 0 for all others.
fn owners(mesh: &TetMesh, sound: &[bool], detached: &[u32]) -> Vec<usize> {
    let mut owners = vec![0; mesh.positions.len()];
    let elements = mesh.tets.iter().zip(&mesh.regions).zip(sound);
    for ((tet, region), _) in elements.filter(|(_, sound)| **sound) {
        if let Some(place) = detached.iter().position(|of| of == region) {
            tet.iter().for_each(|&i| owners[i as usize] = place + 1);
        }
    }
    owners
}

/// Parts that hang together neither by elements nor by `pairs` of nodes.
fn components(mesh: &TetMesh, sound: &[bool], pairs: &[(u32, u32, f64)], found: &mut Vec<Defect>) {
    let mut groups = Groups::new(mesh.positions.len());
    let mut used = vec![false; mesh.positions.len()];
    for (_, tet) in mesh.tets.iter().enumerate().filter(|(e, _)| sound[*e]) {
        for &i in tet {
            used[i as usize] = true;
            groups.join(tet[0] as usize, i as usize);
        }
    }
    for &(i, j, _) in pairs {
        groups.join(i as usize, j as usize);
    }
    let count = (0..used.len())
        .filter(|&i| used[i] && groups.root(i) == i)
        .count();
    if count > 1 {
        found.push(Defect::Components { count });
    }
}

/// Nodes closer than [`COINCIDING`] times the mean edge, with their distance \[m\].
fn coinciding(mesh: &TetMesh, sound: &[bool], finite: &[bool]) -> Vec<(u32, u32, f64)> {
    let (mut sum, mut count) = (0.0, 0usize);
    for e in (0..mesh.tets.len()).filter(|&e| sound[e]) {
        for [i, j] in mesh.element_edges(e) {
            sum += (mesh.positions[j as usize] - mesh.positions[i as usize]).norm();
            count += 1;
        }
    }
    let reach = COINCIDING * sum / count.max(1) as f64;
    close_pairs(&mesh.positions, finite, reach)
}

/// The pairs of finite points at most `reach` \[m\] apart, with their distance \[m\], in ascending order.
pub(crate) fn close_pairs(
    points: &[Vector3<f64>],
    finite: &[bool],
    reach: f64,
) -> Vec<(u32, u32, f64)> {
    if reach.is_nan() || reach <= 0.0 {
        return Vec::new();
    }
    // Points at most `reach` apart lie in the same or in neighbouring cells.
    let cell = |p: &Vector3<f64>| [p.x, p.y, p.z].map(|x| (x / reach).floor() as i64);
    let mut cells: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
    let mut pairs = Vec::new();
    for (j, p) in points.iter().enumerate().filter(|(j, _)| finite[*j]) {
        let home = cell(p);
        for x in -1..=1i64 {
            for y in -1..=1i64 {
                // One range over the three cells along z.
                let from = [
                    home[0].saturating_add(x),
                    home[1].saturating_add(y),
                    home[2].saturating_sub(1),
                ];
                let to = [from[0], from[1], home[2].saturating_add(1)];
                for &i in cells.range(from..=to).flat_map(|(_, indices)| indices) {
                    let distance = (points[i as usize] - p).norm();
                    if distance <= reach {
                        pairs.push((i, j as u32, distance));
                    }
                }
            }
        }
        cells.entry(home).or_default().push(j as u32);
    }
    pairs.sort_unstable_by_key(|&(i, j, _)| (i, j));
    pairs
}

#[cfg(test)]
mod tests;
