//! The connectivity of a mesh, updated edit by edit.
//!
//! Elements at each node, neighbours across each face, and a mark on each face: on the surface, which sheet made it (0: it was
//! there from the start); inside, the sheet that has passed there though the face still holds together, as all its nodes
//! lie on the edge of the cut. Everything is local: a change costs the elements around it.
//!
//! All lists are in the order of indices, so that an updated topology is the same as one rebuilt from the mesh
//! and its marks.

use crate::clusters::Clusters;
use crate::swept::Swept;
use microsim_mesh::TetMesh;
use std::collections::{BTreeMap, BTreeSet};

/// No neighbour: the face is on the surface.
pub const NONE: u32 = u32::MAX;

/// Corners of the face opposite to each corner, outward by the right-hand rule.
pub const FACES: [[usize; 3]; 4] = [[1, 2, 3], [2, 0, 3], [0, 1, 3], [0, 2, 1]];

/// The connectivity of one mesh.
#[derive(Clone, Debug)]
pub struct Topology {
    pub(crate) generation: u64,
    pub(crate) tets: Vec<[u32; 4]>,
    /// The element across the face opposite to each corner.
    pub(crate) neighbours: Vec<[u32; 4]>,
    /// The mark of the face opposite to each corner.
    pub(crate) marks: Vec<[u32; 4]>,
    /// The elements at each node, ascending.
    pub(crate) node_elements: Vec<Vec<u32>>,
    pub(crate) clusters: Clusters,
    /// Nodes that a blade has come to and not yet passed: the edge of a cut.
    pub(crate) front: BTreeSet<u32>,
    /// Of these the ones that have been doubled, though not all around them may be cut.
    pub(crate) parted: BTreeSet<u32>,
    /// Elements that blades have come near to, and how.
    pub(crate) swept: BTreeMap<u32, Swept>,
    /// Mean rest volume of an element of the mesh as it was whole \[m³\].
    pub(crate) mean_volume: f64,
    /// Mean rest length of an edge of the mesh as it was whole \[m\].
    pub(crate) mean_edge: f64,
    /// Number of sheets so far.
    pub(crate) sheets: u32,
}

/// What a topology holds beyond the mesh: with it, a rebuilt one continues another.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TopologyState {
    /// Element, corner opposite to the face, and mark of every face that has one.
    pub marks: Vec<(u32, u8, u32)>,
    /// Nodes on the edges of cuts, ascending.
    pub front: Vec<u32>,
    /// Of these the ones that have been doubled.
    pub parted: Vec<u32>,
    /// Elements that blades have come near to, and how.
    pub swept: Vec<(u32, Swept)>,
    /// Mean rest volume of an element of the mesh as it was whole \[m³\].
    pub mean_volume: f64,
    /// Mean rest length of an edge of the mesh as it was whole \[m\].
    pub mean_edge: f64,
    /// Number of sheets so far.
    pub sheets: u32,
}

/// A triangle of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SurfaceTriangle {
    /// Its nodes, outward by the right-hand rule.
    pub nodes: [u32; 3],
    /// Its element.
    pub element: u32,
    /// The corner of the element opposite to it.
    pub corner: u8,
    /// The sheet that made it, from 1; 0 for the surface that was there from the start.
    pub sheet: u32,
}

impl Topology {
    /// The topology of a whole mesh without defects of severity error. Costs what the mesh holds.
    pub fn new(mesh: &TetMesh) -> Self {
        let count = mesh.tets.len();
        let mut topology = Self {
            generation: mesh.generation,
            tets: mesh.tets.clone(),
            neighbours: vec![[NONE; 4]; count],
            marks: vec![[0; 4]; count],
            node_elements: vec![Vec::new(); mesh.positions.len()],
            clusters: Clusters::new(mesh),
            front: BTreeSet::new(),
            parted: BTreeSet::new(),
            swept: BTreeMap::new(),
            mean_volume: mesh.volumes().iter().sum::<f64>() / count as f64,
            mean_edge: mesh.mean_edge_length(),
            sheets: 0,
        };
        for (element, tet) in mesh.tets.iter().enumerate() {
            for &node in tet {
                topology.node_elements[node as usize].push(element as u32);
            }
        }
        let mut faces: Vec<([u32; 3], u32, u8)> = Vec::with_capacity(4 * count);
        for (element, tet) in mesh.tets.iter().enumerate() {
            for (k, face) in FACES.iter().enumerate() {
                let mut nodes = face.map(|corner| tet[corner]);
                nodes.sort_unstable();
                faces.push((nodes, element as u32, k as u8));
            }
        }
        faces.sort_unstable();
        for pair in faces.windows(2) {
            let [(a, e, k), (b, f, l)] = [pair[0], pair[1]];
            if a == b {
                topology.neighbours[e as usize][k as usize] = f;
                topology.neighbours[f as usize][l as usize] = e;
            }
        }
        topology
    }

    /// The topology of a mesh that was cut before.
    pub fn restore(mesh: &TetMesh, state: &TopologyState) -> Self {
        let mut topology = Self::new(mesh);
        for &(element, corner, mark) in &state.marks {
            let marks = topology.marks.get_mut(element as usize);
            if let Some(place) = marks.and_then(|m| m.get_mut(corner as usize)) {
                *place = mark;
            }
        }
        topology.front = state.front.iter().copied().collect();
        topology.parted = state.parted.iter().copied().collect();
        topology.swept = state.swept.iter().copied().collect();
        topology.mean_volume = state.mean_volume;
        topology.mean_edge = state.mean_edge;
        topology.sheets = state.sheets;
        topology
    }

    /// Makes room for half as many elements again, so that cuts do not wait for memory.
    pub fn make_room(&mut self) {
        let (elements, nodes) = (self.tets.len() / 2, self.node_elements.len() / 2);
        self.tets.reserve(elements);
        self.neighbours.reserve(elements);
        self.marks.reserve(elements);
        self.clusters.make_room(elements);
        self.node_elements.reserve(nodes);
    }

    /// What [`Topology::restore`] needs. Costs what the mesh holds.
    pub fn state(&self) -> TopologyState {
        let faces = (0..self.tets.len()).flat_map(|e| (0..4).map(move |k| (e, k)));
        let marked = faces.filter(|&(e, k)| self.marks[e][k] != 0);
        TopologyState {
            marks: marked
                .map(|(e, k)| (e as u32, k as u8, self.marks[e][k]))
                .collect(),
            front: self.front.iter().copied().collect(),
            parted: self.parted.iter().copied().collect(),
            swept: self.swept.iter().map(|(&e, &swept)| (e, swept)).collect(),
            mean_volume: self.mean_volume,
            mean_edge: self.mean_edge,
            sheets: self.sheets,
        }
    }

    /// The generation of the mesh that it describes.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Mean rest volume of an element of the mesh as it was whole \[m³\].
    pub fn mean_volume(&self) -> f64 {
        self.mean_volume
    }

    /// Mean rest length of an edge of the mesh as it was whole \[m\].
    pub fn mean_edge(&self) -> f64 {
        self.mean_edge
    }

    /// The elements at a node, ascending.
    pub fn elements_at(&self, node: u32) -> &[u32] {
        &self.node_elements[node as usize]
    }

    /// The elements at an edge, ascending.
    pub fn elements_at_edge(&self, [a, b]: [u32; 2]) -> impl Iterator<Item = u32> + '_ {
        let [a, b] = if self.elements_at(a).len() > self.elements_at(b).len() {
            [b, a]
        } else {
            [a, b]
        };
        let at = self.elements_at(a).iter().copied();
        at.filter(move |&element| self.tets[element as usize].contains(&b))
    }

    /// The element across the face of `element` opposite to its corner `corner`; `None` on the surface.
    pub fn neighbour(&self, element: u32, corner: usize) -> Option<u32> {
        let neighbour = self.neighbours[element as usize][corner];
        (neighbour != NONE).then_some(neighbour)
    }

    /// The sheet that made, or tore, the face of `element` opposite to its corner `corner`, from 1; 0 for none.
    pub fn sheet(&self, element: u32, corner: usize) -> u32 {
        self.marks[element as usize][corner]
    }

    /// The nodes of the face of `element` opposite to its corner `corner`, outward.
    pub fn face(&self, element: u32, corner: usize) -> [u32; 3] {
        FACES[corner].map(|k| self.tets[element as usize][k])
    }

    /// The corner of `other` that is opposite to its face to `element`.
    pub(crate) fn back(&self, element: u32, other: u32) -> usize {
        let neighbours = &self.neighbours[other as usize];
        let corner = neighbours.iter().position(|&n| n == element);
        corner.expect("neighbours know each other")
    }

    /// The triangles of an element that lie on the surface, in the order of the corners opposite to them.
    pub fn triangles_of(&self, element: u32) -> impl Iterator<Item = SurfaceTriangle> + '_ {
        let outer = (0..4).filter(move |&k| self.neighbours[element as usize][k] == NONE);
        outer.map(move |corner| SurfaceTriangle {
            nodes: self.face(element, corner),
            element,
            corner: corner as u8,
            sheet: self.marks[element as usize][corner],
        })
    }

    /// The whole surface, in the order of the elements. Costs what the mesh holds.
    pub fn surface(&self) -> Vec<SurfaceTriangle> {
        let elements = 0..self.tets.len() as u32;
        elements.flat_map(|e| self.triangles_of(e)).collect()
    }

    /// Takes the element out of the lists of its nodes.
    fn leave_nodes(&mut self, element: u32) {
        for node in self.tets[element as usize] {
            let list = &mut self.node_elements[node as usize];
            if let Ok(place) = list.binary_search(&element) {
                list.remove(place);
            }
        }
    }

    /// Enters the element into the lists of its nodes.
    fn enter_nodes(&mut self, element: u32) {
        for node in self.tets[element as usize] {
            let list = &mut self.node_elements[node as usize];
            if let Err(place) = list.binary_search(&element) {
                list.insert(place, element);
            }
        }
    }

    /// Finds the neighbours of `element` again, and updates theirs.
    fn link(&mut self, element: u32) {
        for corner in 0..4 {
            let face = self.face(element, corner);
            let other = self.across(element, &face);
            self.neighbours[element as usize][corner] = other.unwrap_or(NONE);
            if let Some(other) = other {
                let tet = self.tets[other as usize];
                if let Some(back) = (0..4).find(|&k| !face.contains(&tet[k])) {
                    self.neighbours[other as usize][back] = element;
                }
            }
        }
    }

    /// The other element with the nodes of `face`.
    fn across(&self, element: u32, face: &[u32; 3]) -> Option<u32> {
        let shortest = face.iter().min_by_key(|&&n| self.elements_at(n).len())?;
        let mut at = self.elements_at(*shortest).iter().copied();
        at.find(|&e| e != element && face.iter().all(|n| self.tets[e as usize].contains(n)))
    }

    /// Puts children in the place of elements: the first child of each takes its slot, the others are appended. All elements with a common
    /// divided face must be replaced at once.
    pub(crate) fn replace(&mut self, replaced: &[(u32, Vec<Child>)], nodes: usize) {
        self.node_elements.resize(nodes, Vec::new());
        for (element, _) in replaced {
            self.leave_nodes(*element);
        }
        let mut touched = Vec::new();
        for (element, children) in replaced {
            let swept = self.swept.get(element).copied();
            for (k, child) in children.iter().enumerate() {
                let slot = if k == 0 {
                    *element
                } else {
                    self.tets.push(child.corners);
                    self.neighbours.push([NONE; 4]);
                    self.marks.push(child.marks);
                    self.clusters.appended(*element);
                    self.tets.len() as u32 - 1
                };
                self.clusters.has_nodes(slot, &child.corners);
                self.tets[slot as usize] = child.corners;
                self.marks[slot as usize] = child.marks;
                touched.push(slot);
                if let Some(passed) = swept {
                    self.swept.insert(slot, passed);
                }
            }
        }
        for &slot in &touched {
            self.enter_nodes(slot);
        }
        for &slot in &touched {
            self.link(slot);
        }
        self.clusters
            .halve_large(&touched, &self.tets, &self.neighbours);
    }

    /// Gives `copy` (the next free node) to the elements of `group` in place of `node`; faces to elements that keep `node` come apart.
    /// Calls `opened` for each: element, corner, other element, its corner.
    pub(crate) fn double(
        &mut self,
        node: u32,
        group: &[u32],
        mut opened: impl FnMut(&Self, [(u32, usize); 2]),
    ) {
        let copy = self.node_elements.len() as u32;
        for &element in group {
            for corner in 0..4 {
                let other = self.neighbours[element as usize][corner];
                let holds = self.tets[element as usize][corner] != node;
                if other == NONE || !holds || group.binary_search(&other).is_ok() {
                    continue;
                }
                let back = self.back(element, other);
                self.neighbours[element as usize][corner] = NONE;
                self.neighbours[other as usize][back] = NONE;
                opened(self, [(element, corner), (other, back)]);
            }
        }
        for &element in group {
            let tet = &mut self.tets[element as usize];
            tet.iter_mut()
                .filter(|n| **n == node)
                .for_each(|n| *n = copy);
            self.clusters.has_nodes(element, &[copy]);
        }
        self.node_elements[node as usize].retain(|e| group.binary_search(e).is_err());
        self.node_elements.push(group.to_vec());
    }

    /// The groups into which the elements at `node` fall when one may pass through faces at `node` that have no mark: each
    /// ascending, in the order of their first elements.
    pub(crate) fn groups_at(&self, node: u32) -> Vec<Vec<u32>> {
        let all = self.elements_at(node);
        let mut seen = vec![false; all.len()];
        let mut groups = Vec::new();
        for start in 0..all.len() {
            if seen[start] {
                continue;
            }
            seen[start] = true;
            let mut group = vec![all[start]];
            let mut next = 0;
            while let Some(&element) = group.get(next) {
                next += 1;
                for corner in 0..4 {
                    let e = element as usize;
                    let other = self.neighbours[e][corner];
                    if self.tets[e][corner] == node || other == NONE || self.marks[e][corner] != 0 {
                        continue;
                    }
                    if let Ok(place) = all.binary_search(&other)
                        && !seen[place]
                    {
                        seen[place] = true;
                        group.push(other);
                    }
                }
            }
            group.sort_unstable();
            groups.push(group);
        }
        groups
    }

    /// Takes elements (ascending) out and fills their places from the back; they have no neighbours among those that stay. Then
    /// the same for the nodes that have no element left, which are returned.
    pub(crate) fn remove(&mut self, elements: &[u32]) -> Vec<u32> {
        let mut nodes: Vec<u32> = Vec::new();
        for &element in elements {
            nodes.extend(self.tets[element as usize]);
            self.leave_nodes(element);
        }
        nodes.sort_unstable();
        nodes.dedup();
        nodes.retain(|&node| self.elements_at(node).is_empty());
        for &gone in elements.iter().rev() {
            let last = self.tets.len() as u32 - 1;
            if last != gone {
                self.leave_nodes(last);
            }
            self.tets.swap_remove(gone as usize);
            self.neighbours.swap_remove(gone as usize);
            self.marks.swap_remove(gone as usize);
            self.clusters.swap_remove(gone);
            self.swept.remove(&gone);
            if let Some(passed) = self.swept.remove(&last)
                && last != gone
            {
                self.swept.insert(gone, passed);
            }
            if last == gone {
                continue;
            }
            self.enter_nodes(gone);
            for other in self.neighbours[gone as usize] {
                if other != NONE {
                    let places = &mut self.neighbours[other as usize];
                    places
                        .iter_mut()
                        .filter(|n| **n == last)
                        .for_each(|n| *n = gone);
                }
            }
        }
        for &gone in nodes.iter().rev() {
            let last = self.node_elements.len() as u32 - 1;
            self.node_elements.swap_remove(gone as usize);
            for set in [&mut self.front, &mut self.parted] {
                set.remove(&gone);
                if set.remove(&last) && last != gone {
                    set.insert(gone);
                }
            }
            if last == gone {
                continue;
            }
            for e in self.node_elements[gone as usize].clone() {
                let tet = &mut self.tets[e as usize];
                tet.iter_mut()
                    .filter(|n| **n == last)
                    .for_each(|n| *n = gone);
                self.clusters.has_nodes(e, &[gone]);
            }
        }
        nodes
    }
}

/// An element that comes from another.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Child {
    pub corners: [u32; 4],
    /// Marks of its faces, by the corner opposite.
    pub marks: [u32; 4],
}
