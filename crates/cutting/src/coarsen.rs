//! Coarsening: nodes that cuts have left behind and the shape does without are merged with a neighbour.
//!
//! A cut divides every edge that it crosses, so that a few of them side by side make a mesh several times finer than the one that was
//! meshed. Here an edge collapses (Hoppe et al. 1993): a node takes the place of its neighbour, the elements between them vanish, those around
//! become larger. It does so where the mesh stays conforming and its surface a manifold (link conditions: Dey et al. 1999); along all faces of the surface, of a cut and
//! between two regions at the node, as far as these stay within a small fraction of an edge of where they were; and where no element becomes a sliver, much longer than those of the whole mesh or distorted.
//! Which nodes may go is for the caller to decide: those that something else refers to must not.
//!
//! Limitations: what a node carries is lost with it, where that is not what its neighbours have; momentum changes by that of the
//! difference of two velocities. Copies of nodes that were there before a cut may go as well: one lip of a cut then has fewer nodes than the other, and both may overlap at rest by as much as faces move. Nothing
//! remembers the first surface: errors of merges one after the other add up.

use crate::editor::Editor;
use crate::report::Cut;
use crate::topology::{NONE, Topology};
use microsim_geometry::{closest_on_triangle, signed_volume};
use microsim_mesh::TetMesh;
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeSet;

/// How far a merged node may lie from the faces that take the place of its own, and the other node from the planes of these, over the mean edge at the node: half of
/// what a cut strays by ([`Settings::least_fraction`](crate::Settings::least_fraction)).
const SURFACE: f64 = 0.08;

/// Cosine of the angle by which a face may turn.
const TURN: f64 = 0.9;

/// How far a merged node may be from where its neighbours' displacements put it, over the mean edge at the node.
const DISPLACEMENT: f64 = 0.04;

/// Least quality of an element that grows: 6 √2 V over the cube of the root mean square edge, 1 for the regular tetrahedron (Parthasarathy, Graichen
/// and Hathaway 1994). Less only where one around the node is worse.
const QUALITY: f64 = 0.1;

/// Longest edge of an element that grows, over the mean edge of the whole mesh.
const LONGEST: f64 = 1.5;

/// Least volume of an element that grows, over that at rest.
const COMPRESSED: f64 = 0.3;

impl Topology {
    /// Merges nodes among `candidates` without a common element, as many as can be; `None` where none can. Nodes are now at `current` \[m\]. The
    /// topology is then that of the next generation, as after [`Topology::cut`].
    pub fn coarsen(
        &mut self,
        mesh: &TetMesh,
        current: &[Vector3<f64>],
        candidates: impl IntoIterator<Item = u32>,
    ) -> Option<Cut> {
        let (mut merges, mut used) = (Vec::new(), BTreeSet::new());
        for node in candidates {
            let at = self.elements_at(node);
            if self.front.contains(&node) || at.iter().any(|e| used.contains(e)) {
                continue;
            }
            let star = Star::new(self, mesh, current, node);
            let Some(onto) = star.and_then(|star| star.target(&used)) else {
                continue;
            };
            used.extend(at.iter().chain(self.elements_at(onto)));
            merges.push([node, onto]);
        }
        if merges.is_empty() {
            return None;
        }
        let mut editor = Editor::new(self, mesh, current);
        for [node, onto] in merges {
            editor.merge(node, onto);
        }
        Some(editor.conclude_merges())
    }

    /// The elements between two nodes collapse, and those at `node` alone go over to `onto`. The former, which are returned, are then without neighbours, but
    /// not yet taken out.
    pub(crate) fn merge(&mut self, node: u32, onto: u32) -> Vec<u32> {
        let between: Vec<u32> = self.elements_at_edge([node, onto]).collect();
        for &element in &between {
            let tet = self.tets[element as usize];
            let opposite = |of: u32| tet.iter().position(|n| *n == of).expect("both are corners");
            // Faces opposite to `node` and to `onto`, which come to lie on one another.
            let corners = [opposite(node), opposite(onto)];
            let others = corners.map(|corner| self.neighbours[element as usize][corner]);
            let marks = corners.map(|corner| self.marks[element as usize][corner]);
            for (this, that) in [(0, 1), (1, 0)] {
                if others[this] == NONE {
                    continue;
                }
                let back = self.back(element, others[this]);
                self.neighbours[others[this] as usize][back] = others[that];
                self.marks[others[this] as usize][back] =
                    marks[if others[that] == NONE { that } else { 0 }];
            }
            self.neighbours[element as usize] = [NONE; 4];
        }
        let moving = self.elements_at(node).iter().copied();
        let moving: Vec<u32> = moving
            .filter(|e| between.binary_search(e).is_err())
            .collect();
        for &element in &moving {
            let corners = self.tets[element as usize].iter_mut();
            corners.filter(|n| **n == node).for_each(|n| *n = onto);
            self.clusters.gains_node(element, onto);
            let list = &mut self.node_elements[onto as usize];
            let place = list.partition_point(|e| *e < element);
            list.insert(place, element);
        }
        self.node_elements[node as usize].clone_from(&between);
        between
    }
}

/// A face at a node that is to stay where it is.
struct Face {
    /// Outward, or from the region with the smaller number.
    nodes: [u32; 3],
    of: Surface,
}

/// Faces that lie side by side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Surface {
    /// Those of a region that one sheet laid open.
    Outer { region: u32, sheet: u32 },
    /// Those between two regions.
    Between([u32; 2]),
}

/// The elements around a node that may go.
struct Star<'a> {
    topology: &'a Topology,
    mesh: &'a TetMesh,
    current: &'a [Vector3<f64>],
    node: u32,
    faces: Vec<Face>,
    /// Of the edges at the node that lie on the surface the other ends, ascending.
    rim: Vec<u32>,
    /// The other ends of all edges at the node, by their lengths at rest \[m\].
    neighbours: Vec<(f64, u32)>,
    /// Mean of these lengths, but no more than that of the whole mesh \[m\].
    edge: f64,
}

impl<'a> Star<'a> {
    /// `None` where the surface is no manifold at the node or a blade has passed a face at it that still holds together.
    fn new(
        topology: &'a Topology,
        mesh: &'a TetMesh,
        current: &'a [Vector3<f64>],
        node: u32,
    ) -> Option<Self> {
        let mut faces = Vec::new();
        for (element, corner) in faces_at(topology, node) {
            let region = mesh.regions[element as usize];
            let sheet = topology.marks[element as usize][corner];
            let of = match topology.neighbour(element, corner) {
                None => Surface::Outer { region, sheet },
                Some(_) if sheet != 0 => return None,
                Some(other) => match mesh.regions[other as usize] {
                    beyond if beyond > region => Surface::Between([region, beyond]),
                    _ => continue,
                },
            };
            let nodes = topology.face(element, corner);
            faces.push(Face { nodes, of });
        }
        let rim = rim(topology, node)?;
        let at = topology.elements_at(node).iter();
        let mut neighbours: Vec<u32> = at.flat_map(|e| topology.tets[*e as usize]).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours.retain(|other| *other != node);
        let place = mesh.positions[node as usize];
        let length = |other: u32| (mesh.positions[other as usize] - place).norm();
        let mut neighbours: Vec<(f64, u32)> = neighbours
            .into_iter()
            .map(|other| (length(other), other))
            .collect();
        neighbours.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let sum: f64 = neighbours.iter().map(|(length, _)| length).sum();
        Some(Self {
            topology,
            mesh,
            current,
            node,
            faces,
            rim,
            edge: topology.mean_edge.min(sum / neighbours.len() as f64),
            neighbours,
        })
    }

    /// The nearest neighbour with which the node may merge; none of its elements is `used`.
    fn target(&self, used: &BTreeSet<u32>) -> Option<u32> {
        let mut neighbours = self.neighbours.iter().map(|(_, other)| *other);
        neighbours.find(|&onto| {
            let topology = self.topology;
            !topology.front.contains(&onto)
                && !topology.elements_at(onto).iter().any(|e| used.contains(e))
                && self.retains_surfaces(onto)
                && self.retains_elements(onto)
                && self.is_link_of_edge(onto)
        })
    }

    /// The corners of the elements at a node.
    fn at(&self, node: u32) -> impl Iterator<Item = &[u32; 4]> + '_ {
        let elements = self.topology.elements_at(node).iter();
        elements.map(|&element| &self.topology.tets[element as usize])
    }

    fn rest(&self, node: u32) -> Vector3<f64> {
        self.mesh.positions[node as usize]
    }

    /// Whether the faces at the node stay where they are as it merges.
    fn retains_surfaces(&self, onto: u32) -> bool {
        let node = self.node;
        let most = SURFACE * self.edge;
        let (place, other) = (self.rest(node), self.rest(onto));
        self.faces.iter().enumerate().all(|(first, face)| {
            let surface = face.of;
            if self.faces[..first].iter().any(|face| face.of == surface) {
                return true;
            }
            let faces = || self.faces.iter().filter(|face| face.of == surface);
            let along = faces().any(|face| face.nodes.contains(&onto));
            let mut nearest = f64::INFINITY;
            for face in faces().filter(|face| along && !face.nodes.contains(&onto)) {
                let before = face.nodes.map(|n| self.rest(n));
                let after = face
                    .nodes
                    .map(|n| self.rest(if n == node { onto } else { n }));
                let [from, to] = [before, after].map(|[a, b, c]| (b - a).cross(&(c - a)));
                let height = from.dot(&(other - place)).abs();
                // Written so that a face without area does not stay.
                let stays = from.dot(&to) > TURN * from.norm() * to.norm();
                if !stays || height > most * from.norm() {
                    return false;
                }
                let closest = closest_on_triangle(&place, &after);
                nearest = nearest.min((closest.point - place).norm());
            }
            nearest <= most
        })
    }

    /// Whether the elements that grow are none that a mesh should not have, and bring the node to where it is.
    fn retains_elements(&self, onto: u32) -> bool {
        let node = self.node;
        let quality = |tet: &[u32; 4]| quality(&tet.map(|n| self.rest(n)));
        let worst = self.at(node).map(quality).fold(QUALITY, f64::min);
        let longest = LONGEST * self.topology.mean_edge;
        let place = self.rest(node);
        // The least of the barycentric coordinates of the node in the element that holds it, and how far it is from where that puts it.
        let mut held = (f64::NEG_INFINITY, f64::INFINITY);
        for tet in self.at(node).filter(|tet| !tet.contains(&onto)) {
            let tet = tet.map(|n| if n == node { onto } else { n });
            let rest = tet.map(|n| self.rest(n));
            let now = tet.map(|n| self.current[n as usize]);
            let [at_rest, is] = [&rest, &now].map(|[a, b, c, d]| signed_volume(a, b, c, d));
            let short = tet
                .iter()
                .all(|&n| (self.rest(n) - self.rest(onto)).norm() <= longest);
            let sound =
                at_rest > 0.0 && self::quality(&rest) >= worst && is >= COMPRESSED * at_rest;
            if !(short && sound) {
                return false;
            }
            let edges =
                |[a, b, c, d]: &[Vector3<f64>; 4]| Matrix3::from_columns(&[b - a, c - a, d - a]);
            let Some(inverse) = edges(&rest).try_inverse() else {
                return false;
            };
            let along = inverse * (place - rest[0]);
            let least = along.min().min(1.0 - along.sum());
            if least > held.0 {
                let brought = now[0] + edges(&now) * along;
                held = (least, (brought - self.current[node as usize]).norm());
            }
        }
        held.1 <= DISPLACEMENT * self.edge
    }

    /// Whether what both nodes are linked to is what the edge between them is linked to, with the outside as one more node: then the mesh
    /// stays a mesh (Dey, Edelsbrunner, Guha and Nekhayev 1999).
    fn is_link_of_edge(&self, onto: u32) -> bool {
        let node = self.node;
        let between: Vec<[u32; 2]> = self
            .at(node)
            .filter(|tet| tet.contains(&onto))
            .map(|tet| pair(tet.iter().copied().filter(|n| ![node, onto].contains(n))))
            .collect();
        let mut ring: Vec<u32> = between.concat();
        ring.sort_unstable();
        ring.dedup();
        let nodes = |of: u32| -> BTreeSet<u32> { self.at(of).flatten().copied().collect() };
        let common = &nodes(node) & &nodes(onto);
        let in_ring = |n: &u32| [node, onto].contains(n) || ring.binary_search(n).is_ok();
        if !common.iter().all(in_ring) {
            return false;
        }
        let edges = |of: u32, without: u32| -> BTreeSet<[u32; 2]> {
            let tets = self.at(of).filter(|tet| !tet.contains(&without));
            let edges = tets.flat_map(|tet| {
                let [a, b, c] = triple(tet.iter().copied().filter(|n| *n != of));
                [[a, b], [a, c], [b, c]].map(|edge| pair(edge.into_iter()))
            });
            edges.collect()
        };
        let shared = &edges(node, onto) & &edges(onto, node);
        if !shared.iter().all(|edge| between.contains(edge)) {
            return false;
        }
        // Two elements on the same three nodes would become one.
        let mut faces = self.at(node).filter(|tet| !tet.contains(&onto));
        let faces_of_onto: BTreeSet<[u32; 3]> = self
            .at(onto)
            .map(|tet| triple(tet.iter().copied().filter(|n| *n != onto)))
            .collect();
        if faces
            .any(|tet| faces_of_onto.contains(&triple(tet.iter().copied().filter(|n| *n != node))))
        {
            return false;
        }
        self.is_link_of_edge_outside(onto)
    }

    /// The same for what the outside is linked to.
    fn is_link_of_edge_outside(&self, onto: u32) -> bool {
        let node = self.node;
        let Some(other) = rim(self.topology, onto) else {
            return false;
        };
        if self.rim.is_empty() {
            return true;
        }
        if !self.rim.contains(&onto) {
            return false;
        }
        let beside = faces_at(self.topology, node)
            .filter(|&(element, corner)| self.topology.neighbour(element, corner).is_none());
        let beside = beside.map(|(element, corner)| self.topology.face(element, corner));
        let beside: Vec<u32> = beside
            .filter(|face| face.contains(&onto))
            .flatten()
            .collect();
        let common = self.rim.iter().filter(|n| other.binary_search(n).is_ok());
        let mut common = common.filter(|n| **n != onto);
        let shared = common.all(|n| beside.contains(n));
        // An element with both faces on the surface would vanish, and join what it parts.
        let flap = |&element: &u32| {
            let tet = &self.topology.tets[element as usize];
            let is_outer = |of: u32| {
                let corner = tet.iter().position(|n| *n == of);
                corner.is_some_and(|corner| self.topology.neighbour(element, corner).is_none())
            };
            is_outer(node) && is_outer(onto)
        };
        shared
            && !self
                .topology
                .elements_at_edge([node, onto])
                .any(|e| flap(&e))
    }
}

/// The faces at a node: their elements, and the corners opposite to them.
fn faces_at(topology: &Topology, node: u32) -> impl Iterator<Item = (u32, usize)> + '_ {
    let elements = topology.elements_at(node).iter();
    elements.flat_map(move |&element| {
        let tet = &topology.tets[element as usize];
        (0..4)
            .filter(move |&k| tet[k] != node)
            .map(move |k| (element, k))
    })
}

/// The other ends of the edges at a node that lie on the surface, ascending; `None` where an edge does so other than between two faces.
fn rim(topology: &Topology, node: u32) -> Option<Vec<u32>> {
    let outer =
        faces_at(topology, node).filter(|&(e, corner)| topology.neighbour(e, corner).is_none());
    let mut ends: Vec<u32> = outer
        .flat_map(|(element, corner)| topology.face(element, corner))
        .filter(|n| *n != node)
        .collect();
    ends.sort_unstable();
    let manifold = ends.chunk_by(|a, b| a == b).all(|same| same.len() == 2);
    ends.dedup();
    manifold.then_some(ends)
}

fn quality(corners: &[Vector3<f64>; 4]) -> f64 {
    let [a, b, c, d] = corners;
    let squares = crate::pattern::EDGES.map(|[i, j]| (corners[j] - corners[i]).norm_squared());
    let mean = squares.iter().sum::<f64>() / 6.0;
    6.0 * std::f64::consts::SQRT_2 * signed_volume(a, b, c, d) / (mean * mean.sqrt())
}

/// Two nodes, ascending.
fn pair(nodes: impl Iterator<Item = u32>) -> [u32; 2] {
    sorted(nodes)
}

/// Three nodes, ascending.
fn triple(nodes: impl Iterator<Item = u32>) -> [u32; 3] {
    sorted(nodes)
}

fn sorted<const N: usize>(mut nodes: impl Iterator<Item = u32>) -> [u32; N] {
    let mut all = std::array::from_fn(|_| nodes.next().unwrap_or(NONE));
    all.sort_unstable();
    all
}

#[cfg(test)]
mod tests;
