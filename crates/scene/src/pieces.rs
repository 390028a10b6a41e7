//! The pieces into which a body has come apart.

use microsim_mesh::TopologyEdit;

/// The pieces of a body.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pieces {
    /// The piece that each node is of; 0 before any came off.
    pub of_nodes: Vec<u32>,
    /// Number of elements of each piece there ever was.
    sizes: Vec<u32>,
}

impl Pieces {
    /// So many pieces, each node of a given one of them.
    pub fn new(of_nodes: Vec<u32>, count: u32, tets: &[[u32; 4]]) -> Self {
        let mut sizes = vec![0; count as usize];
        for tet in tets {
            sizes[of_nodes[tet[0] as usize] as usize] += 1;
        }
        Self { of_nodes, sizes }
    }

    /// How many there ever were.
    pub fn count(&self) -> u32 {
        self.sizes.len() as u32
    }

    /// Updates pieces after an edit; `tets` are the elements before it.
    pub fn update_after_edit(&mut self, edit: &TopologyEdit, tets: &[[u32; 4]]) {
        let piece_of = |of_nodes: &[u32], element: u32| {
            let node = tets[element as usize][0];
            of_nodes[node as usize] as usize
        };
        for replacement in &edit.elements {
            let piece = piece_of(&self.of_nodes, replacement.element);
            self.sizes[piece] += replacement.children.len() as u32 - 1;
        }
        let mut parents = Vec::new();
        if !edit.removed.is_empty() {
            for replacement in &edit.elements {
                let appended = replacement.children.len() - 1;
                parents.extend(std::iter::repeat_n(replacement.element, appended));
            }
        }
        for &element in &edit.removed {
            let appended = (element as usize).checked_sub(tets.len());
            let before = appended.map_or(element, |place| parents[place]);
            let piece = piece_of(&self.of_nodes, before);
            self.sizes[piece] -= 1;
        }
        for node in &edit.nodes {
            self.of_nodes.push(self.of_nodes[node.between[0] as usize]);
        }
        for &node in edit.removed_nodes.iter().rev() {
            self.of_nodes.swap_remove(node as usize);
        }
    }

    /// Gives parts (elements among `tets`) that have come off numbers: those that leave something of their old piece behind. Returns the new
    /// numbers.
    pub fn number(&mut self, parts: &[Vec<u32>], tets: &[[u32; 4]]) -> Vec<u32> {
        let mut new = Vec::new();
        for part in parts {
            let Some(&first) = part.first() else {
                continue;
            };
            let node = tets[first as usize][0];
            let old = self.of_nodes[node as usize] as usize;
            let size = part.len() as u32;
            if self.sizes[old] == size {
                continue;
            }
            let piece = self.count();
            for node in part.iter().flat_map(|&element| tets[element as usize]) {
                self.of_nodes[node as usize] = piece;
            }
            self.sizes[old] -= size;
            self.sizes.push(size);
            new.push(piece);
        }
        new
    }
}
