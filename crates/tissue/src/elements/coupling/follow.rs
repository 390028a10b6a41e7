//! Ties of a coupling after an edit of the mesh.
//!
//! A node that was split keeps its tie on all of its copies, in equal parts: the sum of the stiffnesses stays. New nodes of an interface
//! are not tied; what holds them are the old ones around. A point whose tetrahedron was divided belongs to the child in which it
//! lies, and has its coordinates there: it stays where it was, at rest and deformed. A tie goes with its node, or with the
//! tetrahedron of its point.

use super::{Coupling, Stencil, Support, Tie};
use microsim_mesh::{TetMesh, signed_volume};
use nalgebra::Vector3;

/// What has become of nodes and elements, as ties see it.
pub(crate) struct Followed<'a> {
    /// The mesh after the edit.
    pub mesh: &'a TetMesh,
    /// Rest positions before it \[m\].
    pub rest_positions: &'a [Vector3<f64>],
    /// The nodes that a node before the edit is now: itself, its copies; none if it is gone.
    pub copies: &'a dyn Fn(u32) -> Vec<u32>,
    /// The elements that an element before the edit is now, and whether its coordinates hold no more.
    pub children: &'a dyn Fn(u32) -> (Vec<u32>, bool),
}

impl Coupling {
    /// Those of the ties `dirty`, and for each which of them it was.
    pub(crate) fn follow(&self, dirty: &[u32], edit: &Followed<'_>) -> (Self, Vec<Vec<u32>>) {
        let (mut ties, mut ancestors) = (Self::new(&[], self.bond), Vec::new());
        for &old in dirty {
            let stencil = &self.stencils[old as usize];
            let (children, divided) = (edit.children)(self.elements[old as usize]);
            let support = match children[..] {
                [] => continue,
                [element] if !divided => {
                    let renamed = stencil.nodes()[1..].iter().map(|&node| {
                        // The corners of an element that is as it was are their first selves.
                        (edit.copies)(node).first().copied()
                    });
                    let Some(nodes) = renamed.collect::<Option<Vec<u32>>>() else {
                        continue;
                    };
                    let mut same = *stencil;
                    same.nodes[1..=nodes.len()].copy_from_slice(&nodes);
                    (element, same)
                }
                _ => inside(stencil, &children, edit),
            };
            let nodes = (edit.copies)(stencil.nodes[0]);
            let share = self.stiffness[old as usize] / nodes.len() as f64;
            for node in nodes {
                let (element, mut stencil) = support;
                stencil.nodes[0] = node;
                ties.stencils.push(stencil);
                ties.stiffness.push(share);
                ties.elements.push(element);
                ancestors.push(vec![old]);
            }
        }
        (ties, ancestors)
    }
}

/// The point of a tie in the child in which it lies most.
fn inside(stencil: &Stencil, children: &[u32], edit: &Followed<'_>) -> (u32, Stencil) {
    let mut point = Vector3::zeros();
    for (node, weight) in stencil.weighted().skip(1) {
        point -= edit.rest_positions[node] * weight;
    }
    let mut best = (f64::NEG_INFINITY, children[0], [0.0; 4]);
    for &child in children {
        let weights = coordinates(&edit.mesh.corners(child as usize), &point);
        let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
        if least > best.0 {
            best = (least, child, weights);
        }
    }
    let (_, element, weights) = best;
    let tie = Tie {
        node: stencil.nodes[0],
        support: Support::Tet(edit.mesh.tets[element as usize], weights),
        element,
        stiffness: 0.0,
    };
    (element, Stencil::of(&tie))
}

/// Barycentric coordinates of a point in a tetrahedron; their sum is 1 to the last bit but one.
pub(super) fn coordinates(corners: &[Vector3<f64>; 4], point: &Vector3<f64>) -> [f64; 4] {
    let [a, b, c, d] = corners;
    let volume = signed_volume(a, b, c, d);
    let share = |corner: usize| {
        let mut with = [a, b, c, d];
        with[corner] = point;
        signed_volume(with[0], with[1], with[2], with[3]) / volume
    };
    let [b, c, d] = [share(1), share(2), share(3)];
    [1.0 - b - c - d, b, c, d]
}
