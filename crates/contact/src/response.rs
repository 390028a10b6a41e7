//! From touches to node corrections.
//!
//! Every touched point of the surface is to be moved out of the capsule along its normal by the depth d. For a triangle the
//! correction is distributed with the barycentric coordinates b and the inverse masses w, Δp_i = d·n·b_i w_i / Σ_j w_j b_j², so
//! that the touching point itself moves by d and the forces on the nodes are in the ratio of b (NUMERICS 6), and averaged over
//! the triangles that share a node. An average undoes less than the whole depth, so it is repeated. At the end each surface
//! node inside a capsule is moved out exactly.

use crate::capsule_motion::CapsuleMotion;
use crate::memory::ContactMemory;
use crate::touch::{Touch, in_reach, touch_node, touch_triangle};
use microsim_geometry::Aabb;
use microsim_mesh::Surface;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Passes over the touched triangles at most.
const PASSES: usize = 12;

/// What the passes may move a node by, as a share of the mean edge length, without leaving the candidates incomplete. It
/// covers a tool's way in one step and the part of an old overlap that is undone in it.
const CANDIDATE_MARGIN: f64 = 0.5;

/// Passes end when no point is deeper than this share of the radius.
const PASS_TOLERANCE: f64 = 1e-6;

/// What contact needs to know of a body.
#[derive(Clone, Copy, Debug)]
pub struct BodySurface<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// Positions of all nodes before the step [m].
    pub start: &'a [Vector3<f64>],
    /// Inverse masses of all nodes [1/kg]; 0 for a clamped node, which is never moved.
    pub inverse_masses: &'a [f64],
    /// Mean edge length of the body [m], its characteristic length.
    pub mean_edge_length: f64,
}

/// The correction of one node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeCorrection {
    /// The node.
    pub node: u32,
    /// By how much it was moved [m].
    pub correction: Vector3<f64>,
    /// The share of `correction` that undid an overlap from before the step [m].
    pub overlap: Vector3<f64>,
}

/// The answer of contact to one tool.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Response {
    /// The moved nodes, ascending.
    pub nodes: Vec<NodeCorrection>,
    /// Depth of the deepest point that is still inside a capsule [m], or a little more: of a triangle it is the depth before
    /// the last pass. 0 when all are out.
    pub max_depth: f64,
}

/// Moves the nodes of a body out of the capsules of one tool.
///
/// `positions` are the node positions that the step would reach without this tool [m]; the touched ones are replaced by their
/// targets, so that the next tool sees them. `memory` belongs to this pair of tool and body.
pub fn respond(
    body: &BodySurface<'_>,
    capsules: &[CapsuleMotion],
    memory: &mut ContactMemory,
    positions: &mut [Vector3<f64>],
) -> Response {
    let candidates = Candidates::find(body, capsules, positions);
    if candidates.is_empty() {
        memory.clear();
        return Response::default();
    }

    let mut moved: BTreeMap<u32, Moved> = BTreeMap::new();
    let mut max_depth = 0.0;
    for _ in 0..PASSES {
        let found = triangle_pass(body, capsules, memory, &candidates, positions, &mut moved);
        max_depth = found.depth;
        if found.relative_distance <= PASS_TOLERANCE {
            break;
        }
    }
    let node_depth = node_pass(body, capsules, memory, &candidates, positions, &mut moved);
    let max_depth = node_depth.max(max_depth);

    // What was touched in this step is remembered for the next, all else forgotten.
    memory.clear();
    for (&node, moved) in &moved {
        for &(capsule, normal) in &moved.normals {
            if let Some(normal) = normal.try_normalize(0.0) {
                memory.remember(capsule, node, normal);
            }
        }
    }
    let nodes = moved
        .into_iter()
        .map(|(node, moved)| NodeCorrection {
            node,
            correction: moved.correction,
            overlap: moved.overlap,
        })
        .collect();
    Response { nodes, max_depth }
}

/// What happened to a node so far.
#[derive(Default)]
struct Moved {
    correction: Vector3<f64>,
    overlap: Vector3<f64>,
    /// Sum of the weighted normals per capsule, in the order of first touch.
    normals: Vec<(u32, Vector3<f64>)>,
}

impl Moved {
    fn touched_by(&mut self, capsule: u32, weighted_normal: Vector3<f64>) {
        match self.normals.iter_mut().find(|(index, _)| *index == capsule) {
            Some((_, sum)) => *sum += weighted_normal,
            None => self.normals.push((capsule, weighted_normal)),
        }
    }
}

/// Triangles and nodes near enough to be touched.
struct Candidates {
    triangles: Vec<u32>,
    nodes: Vec<u32>,
}

impl Candidates {
    /// Broad phase: by a box around the tool, then by a ball around each triangle. The margin leaves room for what the
    /// passes move.
    fn find(
        body: &BodySurface<'_>,
        capsules: &[CapsuleMotion],
        positions: &[Vector3<f64>],
    ) -> Self {
        let margin = CANDIDATE_MARGIN * body.mean_edge_length;
        let bounds = capsules.iter().fold(Aabb::empty(), |all, capsule| {
            all.union(&capsule.end.bounds())
        });
        let bounds = bounds.inflated(margin);
        let mut candidates = Self {
            triangles: Vec::new(),
            nodes: Vec::new(),
        };
        // On which sides of the box each node lies; a triangle with a side common to its corners is away.
        let mut sides = vec![0u8; positions.len()];
        let mut common = u8::MAX;
        for &node in &body.surface.nodes {
            let side = bounds.sides(&positions[node as usize]);
            sides[node as usize] = side;
            common &= side;
            if side == 0 {
                candidates.nodes.push(node);
            }
        }
        if common != 0 {
            return candidates;
        }
        for (index, triangle) in body.surface.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|node| node as usize);
            if sides[a] & sides[b] & sides[c] == 0 {
                let corners = [positions[a], positions[b], positions[c]];
                if capsules
                    .iter()
                    .any(|capsule| in_reach(&corners, &capsule.end, margin))
                {
                    candidates.triangles.push(index as u32);
                }
            }
        }
        candidates
    }

    fn is_empty(&self) -> bool {
        self.triangles.is_empty() && self.nodes.is_empty()
    }
}

/// The largest values that a pass over the triangles found, before it moved anything.
struct Deepest {
    /// Distance to be moved, as a share of the capsule's radius.
    relative_distance: f64,
    /// Depth [m].
    depth: f64,
}

/// One pass over the candidate triangles.
fn triangle_pass(
    body: &BodySurface<'_>,
    capsules: &[CapsuleMotion],
    memory: &ContactMemory,
    candidates: &Candidates,
    positions: &mut [Vector3<f64>],
    moved: &mut BTreeMap<u32, Moved>,
) -> Deepest {
    // All touches are found on the same positions, then averaged: the order of triangles does not matter.
    struct Sum {
        correction: Vector3<f64>,
        overlap: Vector3<f64>,
        touches: f64,
    }
    let mut sums: BTreeMap<u32, Sum> = BTreeMap::new();
    let mut deepest = Deepest {
        relative_distance: 0.0,
        depth: 0.0,
    };
    for &triangle in &candidates.triangles {
        let nodes = &body.surface.triangles[triangle as usize];
        for (index, capsule) in capsules.iter().enumerate() {
            let Some(found) = touch_triangle(body, positions, nodes, index as u32, capsule, memory)
            else {
                continue;
            };
            let Touch {
                normal,
                depth,
                distance,
                old_share,
            } = found.touch;
            let shares = distribute(
                nodes.map(|node| body.inverse_masses[node as usize]),
                found.barycentric,
            );
            if shares == [0.0; 3] {
                continue;
            }
            deepest.depth = deepest.depth.max(depth);
            if distance == 0.0 {
                continue;
            }
            let relative = distance / capsule.end.radius;
            deepest.relative_distance = deepest.relative_distance.max(relative);
            for (&node, share) in nodes.iter().zip(shares) {
                if share > 0.0 {
                    let correction = normal * (distance * share);
                    let sum = sums.entry(node).or_insert_with(|| Sum {
                        correction: Vector3::zeros(),
                        overlap: Vector3::zeros(),
                        touches: 0.0,
                    });
                    sum.correction += correction;
                    sum.overlap += correction * old_share;
                    sum.touches += 1.0;
                    moved
                        .entry(node)
                        .or_default()
                        .touched_by(index as u32, correction);
                }
            }
        }
    }
    for (node, sum) in sums {
        let correction = sum.correction / sum.touches;
        positions[node as usize] += correction;
        let moved = moved.entry(node).or_default();
        moved.correction += correction;
        moved.overlap += sum.overlap / sum.touches;
    }
    deepest
}

/// Moves each candidate node out of the capsules; returns the largest depth that is left for later steps [m].
fn node_pass(
    body: &BodySurface<'_>,
    capsules: &[CapsuleMotion],
    memory: &ContactMemory,
    candidates: &Candidates,
    positions: &mut [Vector3<f64>],
    moved: &mut BTreeMap<u32, Moved>,
) -> f64 {
    let mut left = 0.0f64;
    for &node in &candidates.nodes {
        if body.inverse_masses[node as usize] == 0.0 {
            continue;
        }
        for (index, capsule) in capsules.iter().enumerate() {
            let position = &mut positions[node as usize];
            let Some(touch) = touch_node(body, position, node, index as u32, capsule, memory)
            else {
                continue;
            };
            left = left.max(touch.depth - touch.distance);
            let correction = touch.normal * touch.distance;
            *position += correction;
            let moved = moved.entry(node).or_default();
            moved.correction += correction;
            moved.overlap += correction * touch.old_share;
            moved.touched_by(index as u32, correction);
        }
    }
    left
}

/// Factors b_i w_i / Σ_j w_j b_j² by which each node of a triangle takes part in a correction.
///
/// When the point lies almost at a clamped node, a free one would have to go 1/b times the depth for it: the factors are
/// scaled by 3·Σ_free b², which is at least 1 for a triangle without clamps, and the passes do the rest.
fn distribute(w: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let sum: f64 = (0..3).map(|k| w[k] * b[k] * b[k]).sum();
    if sum <= 0.0 {
        return [0.0; 3];
    }
    let free: f64 = (0..3).filter(|&k| w[k] > 0.0).map(|k| b[k] * b[k]).sum();
    let scale = (3.0 * free).min(1.0);
    std::array::from_fn(|k| scale * b[k] * w[k] / sum)
}

#[cfg(test)]
mod tests;
