//! Topology edits: one atomic step from a generation of a mesh to the next.
//!
//! An edit is data. It lists which nodes are new and from which two nodes everything that they have is blended, which
//! elements are replaced by which children, and what leaves. It is applied as a whole or not at all, costs what it
//! touches and not what the mesh holds, and carries whatever else is stored by node along
//! ([`TopologyEdit::carry_nodes`]). Nodes and elements are only appended; what leaves is filled from
//! the back, so that most indices stay. What is not here: why (that is for cutting), and whether the children fill their
//! parents' volume.

use crate::TetMesh;
use nalgebra::Vector3;

/// A node that an edit makes, at the next free index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewNode {
    /// The two nodes it comes from: indices smaller than its own, so that one new node may come from another.
    pub between: [u32; 2],
    /// How far from the first to the second, 0..1. A copy has 0.
    pub fraction: f64,
}

/// An element and what takes its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Replacement {
    /// The element that goes.
    pub element: u32,
    /// The corners of its children, positive at rest, at least one. The first takes the place of the element, the others
    /// are appended in their order. All have new ids, and the region and the fibre direction of the element.
    pub children: Vec<[u32; 4]>,
}

/// Side of a sheet: of the plane of its triangles, counted from their corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// From here the corners of the sheet's triangles run clockwise.
    Negative,
    /// From here they run counter-clockwise.
    Positive,
}

/// A face that the edit lays open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutFace {
    /// Its nodes in the new generation, outward.
    pub nodes: [u32; 3],
    /// Its element in the new generation.
    pub element: u32,
    /// Number of the sheet that made it, from 1.
    pub sheet: u32,
    /// The side of the sheet on which its element lies.
    pub side: Side,
}

/// One step of a mesh from a generation to the next.
///
/// In this order: nodes are appended, elements are replaced, elements leave, nodes leave.
///
/// ```
/// use microsim_mesh::{NewNode, Replacement, TetMesh, TopologyEdit};
/// use nalgebra::Vector3;
///
/// let corners = vec![Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
/// let mut mesh = TetMesh::new(corners, vec![[0, 1, 2, 3]], vec![0]);
/// // The edge 0–1 is halved by node 4, and the element with it.
/// let edit = TopologyEdit {
///     nodes: vec![NewNode { between: [0, 1], fraction: 0.5 }],
///     elements: vec![Replacement {
///         element: 0,
///         children: vec![[0, 4, 2, 3], [4, 1, 2, 3]],
///     }],
///     ..TopologyEdit::default()
/// };
/// mesh.apply(&edit)?;
/// assert_eq!((mesh.tets.len(), mesh.generation), (2, 1));
/// assert_eq!(mesh.element_ids, [1, 2]);
/// # Ok::<(), microsim_mesh::EditError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TopologyEdit {
    /// The generation of the mesh to which it applies.
    pub generation: u64,
    /// New nodes, appended in this order.
    pub nodes: Vec<NewNode>,
    /// Elements replaced, ascending.
    pub elements: Vec<Replacement>,
    /// Elements that leave, ascending, as they are numbered after the replacement. From the last to the first, each place is
    /// taken by the last element of the mesh.
    pub removed: Vec<u32>,
    /// Nodes that leave because no element is left at them, ascending; their indices are filled likewise.
    pub removed_nodes: Vec<u32>,
    /// Elements, as they are numbered in the end, that keep their id and have the same corners under the new indices that
    /// [`TopologyEdit::removed_nodes`] brings.
    pub renumbered: Vec<(u32, [u32; 4])>,
    /// What is laid open.
    pub cut_faces: Vec<CutFace>,
}

/// An element that was replaced.
#[derive(Clone, Debug, PartialEq)]
pub struct Replaced {
    /// Its index before the edit.
    pub element: u32,
    /// Its id, which names nothing from now on.
    pub id: u32,
    /// Its corners before the edit.
    pub corners: [u32; 4],
    /// Index (before anything leaves) and id of each child, in the order of [`Replacement::children`].
    pub children: Vec<(u32, u32)>,
}

/// What an edit did to a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Applied {
    /// The elements replaced, in the order of [`TopologyEdit::elements`].
    pub replaced: Vec<Replaced>,
    /// Ids of the elements that left, in the order of [`TopologyEdit::removed`].
    pub removed_ids: Vec<u32>,
    /// Where elements went as others left: from, to, in this order.
    pub element_moves: Vec<(u32, u32)>,
    /// Where nodes went.
    pub node_moves: Vec<(u32, u32)>,
}

/// Why an edit cannot be applied. The mesh is as it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EditError {
    /// It is for another generation.
    Generation {
        /// That of the mesh.
        mesh: u64,
        /// That of the edit.
        edit: u64,
    },
    /// A new node is not finite, comes from itself or a later one, or is not there.
    Node {
        /// Its index.
        node: u32,
    },
    /// An element is not there, stands twice or out of order, has no child, or a child without four different nodes.
    Element {
        /// Its index.
        element: u32,
    },
    /// No id is left.
    Ids,
}

impl std::fmt::Display for EditError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Generation { mesh, edit } => write!(
                f,
                "the edit is for generation {edit}, the mesh is at {mesh}: make it anew"
            ),
            Self::Node { node } => write!(
                f,
                "node {node} of the edit is not finite, not there, or comes from a later one"
            ),
            Self::Element { element } => write!(
                f,
                "element {element} of the edit is not there, out of order, or has no proper children"
            ),
            Self::Ids => write!(f, "no id is left for another node or element"),
        }
    }
}

impl std::error::Error for EditError {}

/// The moves by which `removed` (ascending) leave a list of `count`: from, to.
fn moves(count: usize, removed: &[u32]) -> Vec<(u32, u32)> {
    let lasts = (0..count as u32).rev();
    let moves = removed
        .iter()
        .rev()
        .zip(lasts)
        .map(|(&to, from)| (from, to));
    moves.filter(|(from, to)| from != to).collect()
}

/// Whether the numbers are below `count` and ascending.
fn ascending(numbers: &[u32], count: usize) -> Result<(), u32> {
    let sorted = numbers.windows(2).find(|pair| pair[0] >= pair[1]);
    let largest = numbers.iter().find(|&&n| n as usize >= count);
    match (sorted, largest) {
        (None, None) => Ok(()),
        (Some(pair), _) => Err(pair[1]),
        (_, Some(&n)) => Err(n),
    }
}

impl TopologyEdit {
    /// Number of elements that it appends.
    pub fn appended(&self) -> usize {
        self.elements.iter().map(|r| r.children.len() - 1).sum()
    }

    /// Where elements go as others leave a mesh that had `elements` before the edit: from, to.
    pub fn element_moves(&self, elements: usize) -> Vec<(u32, u32)> {
        moves(elements + self.appended(), &self.removed)
    }

    /// Where nodes go as others leave a mesh that had `nodes` before the edit: from, to.
    pub fn node_moves(&self, nodes: usize) -> Vec<(u32, u32)> {
        moves(nodes + self.nodes.len(), &self.removed_nodes)
    }

    /// Brings one vector per node along: new nodes get the blend of those they come from. Rest positions, positions,
    /// velocities and coordinates of a texture alike.
    pub fn carry_nodes(&self, values: &mut Vec<Vector3<f64>>) {
        for new in &self.nodes {
            let [a, b] = new.between.map(|n| values[n as usize]);
            values.push(a + (b - a) * new.fraction);
        }
        for &node in self.removed_nodes.iter().rev() {
            values.swap_remove(node as usize);
        }
    }

    fn check(&self, mesh: &TetMesh) -> Result<(), EditError> {
        if self.generation != mesh.generation {
            return Err(EditError::Generation {
                mesh: mesh.generation,
                edit: self.generation,
            });
        }
        let old = mesh.positions.len();
        for (k, new) in self.nodes.iter().enumerate() {
            let node = (old + k) as u32;
            if new.between.iter().any(|&n| n >= node) || !new.fraction.is_finite() {
                return Err(EditError::Node { node });
            }
        }
        let nodes = old + self.nodes.len();
        ascending(&self.removed_nodes, nodes).map_err(|node| EditError::Node { node })?;
        let replaced: Vec<u32> = self.elements.iter().map(|r| r.element).collect();
        let element = |element| EditError::Element { element };
        ascending(&replaced, mesh.tets.len()).map_err(element)?;
        let proper = |tet: &[u32; 4], nodes: usize| {
            let different = (1..4).all(|i| !tet[..i].contains(&tet[i]));
            different && tet.iter().all(|&n| (n as usize) < nodes)
        };
        for r in &self.elements {
            if r.children.is_empty() || !r.children.iter().all(|child| proper(child, nodes)) {
                return Err(EditError::Element { element: r.element });
            }
        }
        let elements = mesh.tets.len() + self.appended();
        ascending(&self.removed, elements).map_err(element)?;
        let (nodes, elements) = (
            nodes - self.removed_nodes.len(),
            elements - self.removed.len(),
        );
        for (index, corners) in &self.renumbered {
            if *index as usize >= elements || !proper(corners, nodes) {
                return Err(EditError::Element { element: *index });
            }
        }
        let children: usize = self.elements.iter().map(|r| r.children.len()).sum();
        let free = |next: u32| (u32::MAX - next) as usize;
        if free(mesh.next_node_id) < self.nodes.len() || free(mesh.next_element_id) < children {
            return Err(EditError::Ids);
        }
        Ok(())
    }
}

impl TetMesh {
    /// Takes the mesh to its next generation, or leaves it as it is.
    ///
    /// Checked are generation and indices. What the edit promises of the whole mesh is not looked up, as that would cost
    /// what the mesh holds: that no element is left at a node that leaves.
    pub fn apply(&mut self, edit: &TopologyEdit) -> Result<Applied, EditError> {
        edit.check(self)?;
        let mut applied = Applied {
            element_moves: edit.element_moves(self.tets.len()),
            node_moves: edit.node_moves(self.positions.len()),
            ..Applied::default()
        };
        edit.carry_nodes(&mut self.positions);
        for _ in &edit.nodes {
            self.node_ids.push(self.next_node_id);
            self.next_node_id += 1;
        }
        for &node in edit.removed_nodes.iter().rev() {
            self.node_ids.swap_remove(node as usize);
        }
        for replacement in &edit.elements {
            let slot = replacement.element as usize;
            let (id, corners) = (self.element_ids[slot], self.tets[slot]);
            let mut children = Vec::with_capacity(replacement.children.len());
            for (k, child) in replacement.children.iter().enumerate() {
                let new_id = self.next_element_id;
                self.next_element_id += 1;
                if k == 0 {
                    self.tets[slot] = *child;
                    self.element_ids[slot] = new_id;
                    children.push((replacement.element, new_id));
                } else {
                    children.push((self.tets.len() as u32, new_id));
                    self.tets.push(*child);
                    self.element_ids.push(new_id);
                    self.regions.push(self.regions[slot]);
                    if let Some(directions) = self.directions.get(slot).copied() {
                        self.directions.push(directions);
                    }
                    if let Some(prestretch) = self.prestretches.get(slot).copied() {
                        self.prestretches.push(prestretch);
                    }
                }
            }
            applied.replaced.push(Replaced {
                element: replacement.element,
                id,
                corners,
                children,
            });
        }
        let ids = edit.removed.iter().map(|&e| self.element_ids[e as usize]);
        applied.removed_ids = ids.collect();
        for &element in edit.removed.iter().rev() {
            self.tets.swap_remove(element as usize);
            self.regions.swap_remove(element as usize);
            if !self.directions.is_empty() {
                self.directions.swap_remove(element as usize);
            }
            if !self.prestretches.is_empty() {
                self.prestretches.swap_remove(element as usize);
            }
            self.element_ids.swap_remove(element as usize);
        }
        for (element, corners) in &edit.renumbered {
            self.tets[*element as usize] = *corners;
        }
        self.generation += 1;
        Ok(applied)
    }
}

#[cfg(test)]
mod tests;
