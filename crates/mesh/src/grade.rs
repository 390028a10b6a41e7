//! Local refinement: elements are halved where they are to be small, and around there as far as neighbours have to follow.
//!
//! What is here: [`TetMesh::graded`], by bisection of marked tetrahedra (Arnold, Mukherjee & Pouly 2000). The result is conforming, fills the same volume, and its
//! shapes are those of a finite number of descendants of each element, so that no size, however small, makes worse ones than the first few bisections. What is not:
//! estimates of where small elements are needed; coarsening. New nodes lie on the straight edges of the mesh that was there, unless they are
//! placed elsewhere afterwards ([`Graded::place_middles`]).

mod bisection;
mod zone;

pub use zone::Zone;

use crate::TetMesh;
use bisection::{Edge, Marked};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Smallest size relative to the extent of a mesh. Positions are rounded by 2⁻⁵³ of the extent, edges of this size by 1e-7 of theirs.
const LEAST_SIZE: f64 = 1e-9;

/// How small elements are to be somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grading {
    /// Where: in all elements that reach into it.
    pub zone: Zone,
    /// Longest edge that an element may have there \[m\], > 0.
    pub size: f64,
}

/// Why a mesh cannot be refined locally.
#[derive(Clone, Debug, PartialEq)]
pub enum GradeError {
    /// A zone that is none, or not of this mesh.
    Zone {
        /// Number of the grading, from 0.
        index: usize,
        /// What is wrong and what was expected.
        fault: String,
    },
    /// A size that is not positive, not finite, or so small that nodes would coincide by rounding.
    Size {
        /// Number of the grading, from 0.
        index: usize,
        /// The size \[m\].
        size: f64,
        /// The least that the mesh allows \[m\].
        least: f64,
    },
    /// Nodes that were placed on a curved surface turn an element inside out.
    Inverted {
        /// The element.
        element: usize,
    },
    /// More elements than allowed.
    Elements {
        /// How many there were when refinement ended.
        reached: usize,
        /// The limit.
        limit: usize,
    },
}

impl std::fmt::Display for GradeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Zone { fault, .. } => write!(f, "the zone to be refined has {fault}"),
            Self::Size { size, least, .. } => write!(
                f,
                "elements cannot be of size {size:?} m; expected a finite one of at least {least:.1e} m, a billionth of the mesh"
            ),
            Self::Inverted { element } => write!(
                f,
                "new nodes on the curved wall turn element {element} inside out, as large elements beside small ones are too flat for it; expected more cells around, or a size that is nearer to theirs"
            ),
            Self::Elements { reached, limit } => write!(
                f,
                "refinement comes to {reached} tetrahedra and is not done; expected {limit} at most: give a larger size or a smaller zone"
            ),
        }
    }
}

impl std::error::Error for GradeError {}

/// A mesh that was refined locally.
#[derive(Clone, Debug, PartialEq)]
pub struct Graded {
    /// The mesh: the nodes that were there, then the new ones; in place of each element its parts, of its region and its fibre direction.
    pub mesh: TetMesh,
    /// The element of the mesh before that each element is part of, ascending.
    pub parents: Vec<u32>,
    /// The two nodes in whose middle each new node lies: both have smaller indices than its own.
    pub middles: Vec<[u32; 2]>,
}

impl TetMesh {
    /// The mesh with elements as small as each of `gradings` asks for, and at most `limit` elements.
    ///
    /// Elements outside of all zones are halved only where a neighbour that was leaves a node in the middle of one of their edges; all others stay as they are.
    ///
    /// ```
    /// use microsim_mesh::{Block, CellSplit, Grading, Zone};
    ///
    /// // A strip, fine around a line across it.
    /// let block = Block { center: [0.0; 3], size: [10e-3, 2e-3, 0.6e-3], cells: [20, 2, 1], split: CellSplit::Kuhn };
    /// let mesh = block.mesh()?;
    /// let zone = Zone::Capsule { ends: [[0.0, -1e-3, 0.0], [0.0, 1e-3, 0.0]], radius: 0.3e-3 };
    /// let graded = mesh.graded(&[Grading { zone, size: 0.6e-3 }], 10_000)?;
    /// assert!(graded.mesh.tets.len() > mesh.tets.len());
    /// let [before, after] = [&mesh, &graded.mesh].map(|mesh| mesh.volumes().iter().sum::<f64>());
    /// assert!((after / before - 1.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Of zones and sizes that are none, before anything is refined; of more elements than `limit`.
    pub fn graded(&self, gradings: &[Grading], limit: usize) -> Result<Graded, GradeError> {
        let mut meshing = Refinement::new(self, gradings)?;
        while meshing.pass() {
            if meshing.elements.len() > limit {
                let reached = meshing.elements.len();
                return Err(GradeError::Elements { reached, limit });
            }
        }
        Ok(meshing.done())
    }

    /// The longest side of the box around it \[m\].
    fn extent(&self) -> f64 {
        let bounds = microsim_geometry::Aabb::of(&self.positions);
        (bounds.max - bounds.min).max()
    }

    /// The shortest height of an element \[m\]: what steps of explicit methods are about proportional to. 0 for a flat one.
    pub fn shortest_height(&self) -> f64 {
        let heights = self
            .volumes()
            .into_iter()
            .enumerate()
            .map(|(element, volume)| {
                let corners = self.corners(element);
                let areas = crate::tet_mesh::FACES.map(|face| {
                    let [a, b, c] = face.map(|corner| corners[corner]);
                    0.5 * (b - a).cross(&(c - a)).norm()
                });
                let area = areas.into_iter().fold(0.0, f64::max);
                if area > 0.0 { 3.0 * volume / area } else { 0.0 }
            });
        heights.fold(f64::INFINITY, f64::min)
    }
}

impl Graded {
    /// Moves each new node to the place that `place` gives for the two that it lies between \[m\], in their order: onto a curved surface, for example.
    ///
    /// # Errors
    /// If an element would not be positive.
    pub fn place_middles(
        mut self,
        place: impl Fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64>,
    ) -> Result<Self, GradeError> {
        let before = self.mesh.positions.len() - self.middles.len();
        for (new, ends) in self.middles.iter().enumerate() {
            let [a, b] = ends.map(|end| self.mesh.positions[end as usize]);
            self.mesh.positions[before + new] = place(&a, &b);
        }
        let volumes = self.mesh.volumes().into_iter();
        match volumes.enumerate().find(|(_, volume)| *volume <= 0.0) {
            Some((element, _)) => Err(GradeError::Inverted { element }),
            None => Ok(self),
        }
    }

    /// Faces of the mesh before, each in the parts that it is divided into, with its orientation and in the order of the elements. One that is no face
    /// of the boundary is left out.
    pub fn faces(&self, faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let mut wanted: Vec<[u32; 3]> = faces.iter().map(|face| sorted(*face)).collect();
        wanted.sort_unstable();
        let of = self.mesh.boundary_faces(|_| true).into_iter();
        let within = of.filter(|(triangle, _)| {
            let mut nodes = Vec::with_capacity(3);
            triangle
                .iter()
                .for_each(|node| self.corners_of(*node, &mut nodes));
            nodes.sort_unstable();
            nodes.dedup();
            let key: Result<[u32; 3], _> = nodes.try_into();
            key.is_ok_and(|key| wanted.binary_search(&key).is_ok())
        });
        within.map(|(triangle, _)| triangle).collect()
    }

    /// Adds the nodes of the mesh before that a node lies between: those of the smallest corner, edge, face or element that it lies in.
    fn corners_of(&self, node: u32, nodes: &mut Vec<u32>) {
        let before = self.mesh.positions.len() - self.middles.len();
        match (node as usize).checked_sub(before) {
            None => nodes.push(node),
            Some(new) => self.middles[new]
                .iter()
                .for_each(|node| self.corners_of(*node, nodes)),
        }
    }
}

fn sorted(mut face: [u32; 3]) -> [u32; 3] {
    face.sort_unstable();
    face
}

/// An element of a mesh that is being refined.
#[derive(Clone, Copy, Debug)]
struct Part {
    element: Marked,
    parent: u32,
    /// Whether it is small enough.
    small: bool,
}

/// A mesh that is being refined.
struct Refinement<'a> {
    mesh: &'a TetMesh,
    gradings: &'a [Grading],
    positions: Vec<Vector3<f64>>,
    elements: Vec<Part>,
    /// The node in the middle of each edge that was halved.
    halved: BTreeMap<Edge, u32>,
    /// Of each node whether an edge at it was halved: most elements are dismissed by it.
    at_halved: Vec<bool>,
}

impl<'a> Refinement<'a> {
    fn new(mesh: &'a TetMesh, gradings: &'a [Grading]) -> Result<Self, GradeError> {
        let least = LEAST_SIZE * mesh.extent();
        for (index, Grading { zone, size }) in gradings.iter().enumerate() {
            if let Some(fault) = zone.fault(mesh) {
                return Err(GradeError::Zone { index, fault });
            }
            if !(size.is_finite() && *size > 0.0 && *size >= least) {
                let size = *size;
                return Err(GradeError::Size { index, size, least });
            }
        }
        let mut refinement = Self {
            mesh,
            gradings,
            positions: mesh.positions.clone(),
            elements: Vec::new(),
            halved: BTreeMap::new(),
            at_halved: vec![false; mesh.positions.len()],
        };
        let elements = mesh.tets.iter().enumerate().map(|(parent, tet)| {
            refinement.part(Marked::new(*tet, &mesh.positions), parent as u32)
        });
        refinement.elements = elements.collect();
        Ok(refinement)
    }

    fn part(&self, element: Marked, parent: u32) -> Part {
        let size = element.size(&self.positions);
        let region = self.mesh.regions[parent as usize];
        let mut wanted = self.gradings.iter().filter(|grading| size > grading.size);
        let small = !wanted.any(|grading| {
            let corners = element.nodes.map(|node| self.positions[node as usize]);
            grading.zone.meets(&corners, region)
        });
        Part {
            element,
            parent,
            small,
        }
    }

    /// Whether an edge of it has a node in its middle.
    fn hangs(&self, element: &Marked) -> bool {
        let ends = element
            .nodes
            .iter()
            .filter(|node| self.at_halved[**node as usize]);
        ends.count() > 1
            && element
                .edges()
                .iter()
                .any(|edge| self.halved.contains_key(edge))
    }

    /// Halves each element once that is too large or has a node in the middle of an edge; whether there was one.
    fn pass(&mut self) -> bool {
        let elements = std::mem::take(&mut self.elements);
        let before = elements.len();
        let mut next = Vec::with_capacity(before);
        for part in elements {
            if part.small && !self.hangs(&part.element) {
                next.push(part);
                continue;
            }
            let middle = self.middle(part.element.refinement);
            let halves = part.element.halves(middle);
            next.extend(halves.map(|half| self.part(half, part.parent)));
        }
        self.elements = next;
        self.elements.len() > before
    }

    /// The node in the middle of an edge, new if there is none.
    fn middle(&mut self, edge: Edge) -> u32 {
        if let Some(node) = self.halved.get(&edge) {
            return *node;
        }
        let node = self.positions.len() as u32;
        let [a, b] = edge.map(|node| self.positions[node as usize]);
        self.positions.push((a + b) * 0.5);
        edge.iter()
            .for_each(|end| self.at_halved[*end as usize] = true);
        self.at_halved.push(false);
        self.halved.insert(edge, node);
        node
    }

    fn done(self) -> Graded {
        let mut middles: Vec<(u32, Edge)> = self.halved.iter().map(|(e, n)| (*n, *e)).collect();
        middles.sort_unstable();
        let parents: Vec<u32> = self.elements.iter().map(|part| part.parent).collect();
        let tets = self.elements.iter().map(|part| part.element.nodes);
        let of = |parent: &u32| self.mesh.regions[*parent as usize];
        let regions = parents.iter().map(of).collect();
        let mut mesh = TetMesh::new(self.positions, tets.collect(), regions);
        let (directions, prestretches) = (&self.mesh.directions, &self.mesh.prestretches);
        if !directions.is_empty() {
            let of = |parent: &u32| directions[*parent as usize];
            mesh.directions = parents.iter().map(of).collect();
        }
        if !prestretches.is_empty() {
            let of = |parent: &u32| prestretches[*parent as usize];
            mesh.prestretches = parents.iter().map(of).collect();
        }
        Graded {
            mesh,
            parents,
            middles: middles.into_iter().map(|(_, edge)| edge).collect(),
        }
    }
}

#[cfg(test)]
mod tests;
