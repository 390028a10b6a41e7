//! Edits of meshes, and what they do to numbers and selections of nodes.

use microsim_mesh::{NewNode, TopologyEdit};
use std::collections::BTreeSet;

/// An edit of a body's mesh.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Edit {
    pub body: usize,
    /// Number of nodes before it.
    pub nodes: usize,
    /// Where elements that slid were then ([`TissueModel::places`](microsim_tissue::TissueModel::places)).
    pub places: Vec<f64>,
    pub edit: TopologyEdit,
}

/// Where each node is after an edit of a mesh that had `old` nodes; `None` for one that leaves with it.
pub(crate) fn renumbering(edit: &TopologyEdit, old: usize) -> impl Fn(u32) -> Option<u32> + '_ {
    let moves = edit.node_moves(old);
    move |node| {
        let stays = edit.removed_nodes.binary_search(&node).is_err();
        // What has come from the back may be at the back again.
        let follow = |node, (from, to): &(u32, u32)| if node == *from { *to } else { node };
        stays.then(|| moves.iter().fold(node, follow))
    }
}

/// What becomes of a selection of nodes: a new node is in it if both nodes are that it comes from. Ascending.
pub(crate) fn nodes_after_edit(
    nodes: impl IntoIterator<Item = u32>,
    edit: &TopologyEdit,
    old: usize,
) -> Vec<u32> {
    nodes_after_edit_by(nodes, edit, old, |all, _, node| {
        node.between.iter().all(|parent| all.contains(parent))
    })
}

/// What becomes of a selection of nodes: a new node is in it if `joins` is true of what is in it already, the node's number before any leaves, and
/// what it comes from. Ascending.
pub(crate) fn nodes_after_edit_by(
    nodes: impl IntoIterator<Item = u32>,
    edit: &TopologyEdit,
    old: usize,
    joins: impl Fn(&BTreeSet<u32>, u32, &NewNode) -> bool,
) -> Vec<u32> {
    let mut all: BTreeSet<u32> = nodes.into_iter().collect();
    for (new, node) in (old as u32..).zip(&edit.nodes) {
        if joins(&all, new, node) {
            all.insert(new);
        }
    }
    let mut all: Vec<u32> = all.into_iter().filter_map(renumbering(edit, old)).collect();
    all.sort_unstable();
    all
}
