//! Two bodies in a frame, and what searches over their nodes, faces and edges have in common.

use crate::body::Body;
use crate::frame::Frame;
use crate::point::{Key, Partner, Point};
use crate::surface::NONE;
use microsim_geometry::TrianglePoint;
use nalgebra::Vector3;

/// A node less deep before the step than this fraction of the mean edge length was at the surface: implicit solvers leave gaps of up to a
/// thousandth of it.
pub(crate) const BAND: f64 = 2e-3;

/// Ridges that are deeper in one another than this fraction of the mean edge length are left to nodes: what seems to be their exit may lead
/// through the body.
pub(crate) const DEEPEST_EDGES: f64 = 0.25;

/// Two bodies, or one twice, in a frame.
#[derive(Clone, Copy)]
pub(crate) struct BodyPair<'a> {
    pub first: &'a Body,
    pub second: &'a Body,
    pub frame: &'a Frame<'a>,
}

/// An edge and an edge, with the place of closest approach on each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgePair {
    pub edges: [u32; 2],
    pub parameters: [f64; 2],
    pub normal: Vector3<f64>,
    pub gap: f64,
    /// Whether the edges were in one another from before the step.
    pub is_old: bool,
}

impl BodyPair<'_> {
    /// Adds the point of a node of the first body with a triangle of the second one.
    pub fn add(
        &self,
        node: u32,
        triangle: &[u32; 3],
        at: &TrianglePoint,
        normal: &Vector3<f64>,
        gap: f64,
        points: &mut Vec<Point>,
    ) {
        let frame = self.frame;
        let is_near = gap < frame.reach;
        if !is_near {
            return;
        }
        let [a, b, c] = *triangle;
        let nodes = [node, a, b, c];
        let [wa, wb, wc] = at.barycentric;
        let weights = [1.0, -wa, -wb, -wc];
        points.push(Point {
            key: Key {
                body: self.first.index,
                partner: Partner::Body {
                    body: self.second.index,
                },
                first: [node, NONE, NONE],
                second: [NONE; 2],
            },
            nodes,
            weights,
            first: 1,
            normal: *normal,
            gap,
            start_gap: gap - normal.dot(&moved(frame, &nodes, &weights)),
            drift: Vector3::zeros(),
            place: frame.now[node as usize],
        });
    }
}

/// Within which distance from a body something is looked for \[m\].
pub(crate) fn reach(second: &Body, frame: &Frame<'_>) -> f64 {
    frame.reach + BAND * second.surface.mean_edge
}

/// How far apart the edges of points of two surfaces can be \[m\].
pub(crate) fn edge_reach(first: &Body, second: &Body, reach: f64) -> f64 {
    reach.max(DEEPEST_EDGES * first.surface.mean_edge.min(second.surface.mean_edge))
}

/// By how much the sides moved against one another since the start of the step \[m\].
pub(crate) fn moved(frame: &Frame<'_>, nodes: &[u32; 4], weights: &[f64; 4]) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    for (&node, &weight) in nodes.iter().zip(weights) {
        sum += (frame.now[node as usize] - frame.start[node as usize]) * weight;
    }
    sum
}
