//! Edits of a mesh made by hand: edges divided, nodes split, elements taken away.

use crate::edit::{EditError, ModelChange, ModelEdit};
use crate::model::TissueModel;
use microsim_mesh::TetMesh;

/// An edit in the making, and the mesh with it so far; nothing has left yet.
pub struct ByHand {
    before: TetMesh,
    /// With all that is new, nothing gone.
    mesh: TetMesh,
    pub replaced: Vec<u32>,
    pub parents: Vec<u32>,
    pub new_nodes: Vec<([u32; 2], f64)>,
    pub clamped: Vec<bool>,
    pub removed_elements: Vec<u32>,
    pub removed_nodes: Vec<u32>,
}

impl ByHand {
    pub fn new(mesh: &TetMesh) -> Self {
        Self {
            before: mesh.clone(),
            mesh: mesh.clone(),
            replaced: Vec::new(),
            parents: Vec::new(),
            new_nodes: Vec::new(),
            clamped: Vec::new(),
            removed_elements: Vec::new(),
            removed_nodes: Vec::new(),
        }
    }

    fn at(&self, nodes: &[u32]) -> Vec<u32> {
        let has_all = |e: &u32| {
            let tet = &self.mesh.tets[*e as usize];
            nodes.iter().all(|node| tet.contains(node)) && !self.removed_elements.contains(e)
        };
        (0..self.mesh.tets.len() as u32).filter(has_all).collect()
    }

    fn add_node(&mut self, between: [u32; 2], share: f64, clamped: bool) -> u32 {
        let [a, b] = between.map(|node| self.mesh.positions[node as usize]);
        let node = self.mesh.positions.len() as u32;
        self.mesh.positions.push(a + (b - a) * share);
        self.mesh.node_ids.push(node);
        self.new_nodes.push((between, share));
        self.clamped.push(clamped);
        node
    }

    fn replace(&mut self, element: u32, tet: [u32; 4]) {
        self.mesh.tets[element as usize] = tet;
        if (element as usize) < self.before.tets.len() {
            self.replaced.push(element);
        }
    }

    /// Divides the edge (a, b) for all its elements; clamps the new node if both ends are.
    pub fn divide(&mut self, [a, b]: [u32; 2], share: f64, clamped: bool) -> u32 {
        let node = self.add_node([a, b], share, clamped);
        for element in self.at(&[a, b]) {
            let tet = self.mesh.tets[element as usize];
            let with = |old: u32| tet.map(|n| if n == old { node } else { n });
            self.replace(element, with(b));
            let parent = match (element as usize).checked_sub(self.before.tets.len()) {
                None => element,
                Some(place) => self.parents[place],
            };
            self.parents.push(parent);
            self.mesh.tets.push(with(a));
            self.mesh.regions.push(self.mesh.regions[element as usize]);
            let direction = self.mesh.directions.get(element as usize).copied();
            self.mesh.directions.extend(direction);
            self.mesh
                .element_ids
                .push(self.mesh.element_ids.len() as u32);
        }
        node
    }

    /// Gives every second of the elements at a node a copy of it.
    pub fn split(&mut self, node: u32, clamped: bool) {
        let at = self.at(&[node]);
        if at.len() < 2 {
            return;
        }
        let copy = self.add_node([node, node], 0.0, clamped);
        for element in at.into_iter().step_by(2) {
            let tet = self.mesh.tets[element as usize];
            self.replace(element, tet.map(|n| if n == node { copy } else { n }));
        }
    }

    /// Puts `onto` in the place of a node; the elements between the two leave.
    pub fn merge(&mut self, node: u32, onto: u32) {
        self.removed_elements.extend(self.at(&[node, onto]));
        for element in self.at(&[node]) {
            let tet = self.mesh.tets[element as usize];
            self.replace(element, tet.map(|n| if n == node { onto } else { n }));
        }
        self.removed_nodes.push(node);
    }

    /// Takes an element away, and its nodes that no other one has.
    pub fn remove(&mut self, element: u32) {
        self.removed_elements.push(element);
        for node in self.mesh.tets[element as usize] {
            if self.at(&[node]).is_empty() {
                self.removed_nodes.push(node);
            }
        }
    }

    /// The mesh after the edit.
    pub fn finish(&mut self) -> TetMesh {
        for list in [
            &mut self.replaced,
            &mut self.removed_elements,
            &mut self.removed_nodes,
        ] {
            list.sort_unstable();
            list.dedup();
        }
        let mut mesh = self.mesh.clone();
        for &element in self.removed_elements.iter().rev() {
            mesh.tets.swap_remove(element as usize);
            mesh.regions.swap_remove(element as usize);
            if !mesh.directions.is_empty() {
                mesh.directions.swap_remove(element as usize);
            }
            mesh.element_ids.swap_remove(element as usize);
        }
        let mut names: Vec<u32> = (0..mesh.positions.len() as u32).collect();
        for &node in self.removed_nodes.iter().rev() {
            mesh.positions.swap_remove(node as usize);
            mesh.node_ids.swap_remove(node as usize);
            names.swap_remove(node as usize);
        }
        let mut now = vec![u32::MAX; self.mesh.positions.len()];
        for (place, old) in names.iter().enumerate() {
            now[*old as usize] = place as u32;
        }
        mesh.tets
            .iter_mut()
            .flatten()
            .for_each(|node| *node = now[*node as usize]);
        mesh.generation += 1;
        mesh
    }

    /// Lets a model follow; `mesh` is that of [`finish`](Self::finish).
    pub fn apply(&self, mesh: &TetMesh, model: &mut TissueModel) -> Result<ModelChange, EditError> {
        model.edit(&self.edit(mesh))
    }

    /// The edit as a model wants it.
    pub fn edit<'a>(&'a self, mesh: &'a TetMesh) -> ModelEdit<'a> {
        ModelEdit {
            mesh,
            replaced: self.replaced.clone(),
            parents: self.parents.clone(),
            new_nodes: self.new_nodes.clone(),
            clamped: self.clamped.clone(),
            removed_elements: self.removed_elements.clone(),
            removed_nodes: self.removed_nodes.clone(),
        }
    }
}

/// A random edit: some edges divided, nodes split, elements taken away where they stand out.
pub fn random(mesh: &TetMesh, clamped: &[bool], next: &mut impl FnMut() -> f64) -> ByHand {
    let mut edit = ByHand::new(mesh);
    let mut pick = |count: usize| ((0.5 * next() + 0.5) * count as f64) as usize % count;
    let fixed = |edit: &ByHand, node: u32| match (node as usize).checked_sub(clamped.len()) {
        None => clamped[node as usize],
        Some(new) => edit.clamped[new],
    };
    for _ in 0..2 {
        let edges = edit.mesh.edges();
        let edge = edges[pick(edges.len())];
        let share = 0.3 + 0.01 * pick(40) as f64;
        let both = fixed(&edit, edge[0]) && fixed(&edit, edge[1]);
        edit.divide(edge, share, both);
    }
    for _ in 0..2 {
        let node = pick(edit.mesh.positions.len()) as u32;
        let is_fixed = fixed(&edit, node);
        edit.split(node, is_fixed);
    }
    for _ in 0..2 {
        let element = pick(edit.mesh.tets.len()) as u32;
        if !edit.removed_elements.contains(&element) {
            edit.remove(element);
        }
    }
    edit
}
