//! Points of the tissue that stay where they are in it while the mesh changes.

use microsim_mesh::{Applied, Replaced, TopologyEdit};

/// A point in an element: a mark, a clamp between nodes, the end of a thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialPoint {
    /// The element, by its index in the mesh's generation.
    pub element: u32,
    /// Its id.
    pub id: u32,
    /// Barycentric coordinates for its four corners, sum 1.
    pub weights: [f64; 4],
}

impl MaterialPoint {
    /// Follows an edit that was applied to a mesh with so many nodes: of the children of its element it goes to the one that
    /// it lies in, of several to the first. False, and the point unchanged, when the place has left with a crumb.
    pub fn follow(&mut self, edit: &TopologyEdit, applied: &Applied, nodes: usize) -> bool {
        let mut next = *self;
        let place = applied
            .replaced
            .binary_search_by_key(&self.element, |replaced| replaced.element);
        if let Ok(place) = place {
            let corners = edit.elements[place].children.iter();
            let replaced = &applied.replaced[place];
            let mut best = f64::NEG_INFINITY;
            for (tet, (element, id)) in corners.zip(&replaced.children) {
                let Some(weights) = child_weights(edit, replaced, nodes, tet, &self.weights) else {
                    continue;
                };
                let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
                if least > best {
                    best = least;
                    next = Self {
                        element: *element,
                        id: *id,
                        weights,
                    };
                }
            }
        }
        if edit.removed.binary_search(&next.element).is_ok() {
            return false;
        }
        for &(from, to) in &applied.element_moves {
            if next.element == from {
                next.element = to;
            }
        }
        *self = next;
        true
    }
}

/// Barycentric coordinates in a child of a point that has `weights` in the parent. `None` for a child without volume.
fn child_weights(
    edit: &TopologyEdit,
    replaced: &Replaced,
    nodes: usize,
    child: &[u32; 4],
    weights: &[f64; 4],
) -> Option<[f64; 4]> {
    // Rows: the child's corners in coordinates of the parent's. The point is their mean by the weights that are sought.
    let rows = child.map(|node| corner_weights(edit, replaced, nodes, node));
    let matrix = nalgebra::Matrix4::from_fn(|i, j| rows[j][i]);
    let found = matrix.lu().solve(&nalgebra::Vector4::from(*weights))?;
    Some(found.into())
}

/// Coordinates of a node of a child for the corners of its parent.
fn corner_weights(edit: &TopologyEdit, replaced: &Replaced, nodes: usize, node: u32) -> [f64; 4] {
    if let Some(corner) = replaced.corners.iter().position(|&n| n == node) {
        return std::array::from_fn(|k| if k == corner { 1.0 } else { 0.0 });
    }
    let new = (node as usize)
        .checked_sub(nodes)
        .and_then(|k| edit.nodes.get(k));
    let Some(new) = new else {
        return [0.0; 4];
    };
    let [a, b] = new
        .between
        .map(|n| corner_weights(edit, replaced, nodes, n));
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * new.share)
}

#[cfg(test)]
mod tests;
