//! Consistent penetration depth (Heidelberger, Teschner, Keiser, Müller, Gross 2004; NUMERICS 1.4): how deep the nodes of one body are
//! in another one, or in another part of the same one, and in which direction the exit is.
//!
//! A node that is not the first to come in gets its depth and direction from the nodes before it, layer by layer: it exits where it entered,
//! and not at the nearest point, which deep inside a thin wall is on the wrong side.

use crate::body::Body;
use crate::frame::Frame;
use crate::near::Near;
use crate::surface::ContactSurface;
use microsim_geometry::{
    Aabb, BroadPhase, TrianglePoint, closest_on_triangle, edge_through_triangle,
    point_in_tetrahedron,
};
use nalgebra::Vector3;

/// A node that is closer to a surface point than this fraction of the mean edge length is at it.
const AT_SURFACE: f64 = 1e-9;

/// Not reached by any layer; or reached, by nodes in the same place.
const UNREACHED: u32 = u32::MAX;
const FAILED: u32 = u32::MAX - 1;

/// A node inside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deep {
    pub node: u32,
    /// How deep along `out` \[m\], ≥ 0.
    pub depth: f64,
    /// Unit vector of the exit.
    pub out: Vector3<f64>,
    layer: u32,
}

impl Deep {
    /// Whether the direction of the exit is known.
    pub fn has_direction(&self) -> bool {
        self.out != Vector3::zeros()
    }
}

/// The nodes of one body inside another one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Depths {
    /// Ascending by node.
    pub nodes: Vec<Deep>,
    layer: Vec<u32>,
    next: Vec<u32>,
}

impl Depths {
    /// Replaces the nodes by those of `first` that are inside of `second` now, without depths yet.
    pub fn mark(&mut self, second: &Body, near: &Near, frame: &Frame<'_>) {
        self.nodes.clear();
        for pairs in near.node_tets.chunk_by(|a, b| a[0] == b[0]) {
            let node = pairs[0][0];
            let p = &frame.now[node as usize];
            let is_inside = pairs.iter().any(|&[_, tet]| {
                let corners = second.surface.tets[tet as usize].map(|n| frame.now[n as usize]);
                point_in_tetrahedron(p, &corners).is_some()
            });
            if is_inside {
                self.nodes.push(Deep {
                    node,
                    depth: 0.0,
                    out: Vector3::zeros(),
                    layer: UNREACHED,
                });
            }
        }
    }

    /// The depths of all nodes.
    pub fn solve(&mut self, first: &Body, second: &Body, frame: &Frame<'_>) {
        self.layer.clear();
        for place in 0..self.nodes.len() {
            if let Some((depth, out)) = self.at_border(place, first, second, frame) {
                self.set(place, depth, out, 0);
            }
        }
        self.spread(&first.surface, frame);
        // A part that is inside as a whole goes to the nearest side with its surface; what is within it goes with it.
        for deep in &mut self.nodes {
            if deep.layer >= FAILED
                && first.surface.nodes.binary_search(&deep.node).is_ok()
                && let Some((triangle, at)) = nearest(deep.node, first, second, frame)
            {
                let p = &frame.now[deep.node as usize];
                let offset = at.point - p;
                deep.depth = offset.norm();
                let noise = AT_SURFACE * second.surface.mean_edge;
                deep.out = if deep.depth > noise {
                    offset / deep.depth
                } else {
                    second.normal_at(frame.now, triangle, &at)
                };
            }
        }
    }

    /// Where a node is in the list of those inside.
    pub fn place(&self, node: u32) -> Option<usize> {
        self.nodes
            .binary_search_by_key(&node, |deep| deep.node)
            .ok()
    }

    fn set(&mut self, place: usize, depth: f64, out: Vector3<f64>, layer: u32) {
        let deep = &mut self.nodes[place];
        deep.depth = depth.max(0.0);
        deep.out = out;
        deep.layer = layer;
        self.layer.push(place as u32);
    }

    /// Depth and exit direction of a node with edges to nodes outside (4.5–4.8).
    fn at_border(
        &self,
        place: usize,
        first: &Body,
        second: &Body,
        frame: &Frame<'_>,
    ) -> Option<(f64, Vector3<f64>)> {
        let node = self.nodes[place].node;
        let p = frame.now[node as usize];
        let itself = first.index == second.index;
        let mut mean = Mean::new();
        for other in first.surface.neighbours(node) {
            // Within one body the other end may be inside as well, but of another part: then the edge comes in all the same.
            if !itself && self.place(other).is_some() {
                continue;
            }
            let from = frame.now[other as usize];
            let entry = crossing(&from, &p, node, true, first, second, frame);
            let Some((triangle, at)) = entry else {
                continue;
            };
            let normal = smooth_normal(second, frame.now, triangle, &at);
            let offset = at.point - p;
            let distance = offset.norm_squared();
            let noise = AT_SURFACE * second.surface.mean_edge;
            if distance <= noise * noise {
                return Some((offset.dot(&normal), normal));
            }
            mean.add(1.0 / distance, offset.dot(&normal), &normal);
        }
        mean.finish()
    }

    /// From layer to layer, until no node is left that has a neighbour with a depth.
    fn spread(&mut self, surface: &ContactSurface, frame: &Frame<'_>) {
        for layer in 1.. {
            self.next.clear();
            for &place in &self.layer {
                for other in surface.neighbours(self.nodes[place as usize].node) {
                    if let Some(other) = self.place(other)
                        && self.nodes[other].layer == UNREACHED
                    {
                        self.next.push(other as u32);
                    }
                }
            }
            if self.next.is_empty() {
                return;
            }
            self.next.sort_unstable();
            self.next.dedup();
            self.layer.clear();
            for k in 0..self.next.len() {
                let place = self.next[k] as usize;
                let node = self.nodes[place].node;
                let p = frame.now[node as usize];
                let mut mean = Mean::new();
                for other in surface.neighbours(node) {
                    let Some(other) = self.place(other) else {
                        continue;
                    };
                    let other = self.nodes[other];
                    if other.layer >= layer {
                        continue;
                    }
                    let offset = frame.now[other.node as usize] - p;
                    let weight = 1.0 / offset.norm_squared();
                    if weight.is_finite() {
                        let depth = offset.dot(&other.out) + other.depth;
                        mean.add(weight, depth, &other.out);
                    }
                }
                match mean.finish() {
                    Some((depth, out)) => self.set(place, depth, out, layer),
                    // All its neighbours are in its place: it is left to the nearest surface point.
                    None => self.nodes[place].layer = FAILED,
                }
            }
        }
    }
}

/// Weighted means of depths and passes.
struct Mean {
    weight: f64,
    depth: f64,
    out: Vector3<f64>,
    /// The direction of the largest weight.
    largest: (f64, Vector3<f64>),
}

impl Mean {
    fn new() -> Self {
        Self {
            weight: 0.0,
            depth: 0.0,
            out: Vector3::zeros(),
            largest: (0.0, Vector3::zeros()),
        }
    }

    fn add(&mut self, weight: f64, depth: f64, out: &Vector3<f64>) {
        self.weight += weight;
        self.depth += depth * weight;
        self.out += out * weight;
        if weight > self.largest.0 {
            self.largest = (weight, *out);
        }
    }

    fn finish(&self) -> Option<(f64, Vector3<f64>)> {
        let has_any = self.weight > 0.0;
        if !has_any {
            return None;
        }
        let out = self.out / self.weight;
        let length = out.norm();
        // Directions that cancel leave rounding.
        let out = if length > AT_SURFACE {
            out / length
        } else {
            self.largest.1
        };
        Some((self.depth / self.weight, out))
    }
}

/// The first crossing of a segment with the surface of `second`, from its front or from its back. Triangles next to `node` do not count.
pub(crate) fn crossing(
    from: &Vector3<f64>,
    to: &Vector3<f64>,
    node: u32,
    from_front: bool,
    first: &Body,
    second: &Body,
    frame: &Frame<'_>,
) -> Option<(u32, TrianglePoint)> {
    let mut best: Option<(f64, u32, TrianglePoint)> = None;
    let itself = first.index == second.index;
    second
        .tree
        .triangles
        .visit(&Aabb::of(&[*from, *to]), |triangle| {
            let nodes = &second.surface.triangles[triangle as usize];
            if itself && first.surface.is_close(&[node], nodes) {
                return;
            }
            let corners = second.surface.corners(frame.now, triangle);
            if let Some(crossing) = edge_through_triangle(from, to, &corners)
                && crossing.from_front == from_front
            {
                let found = (crossing.points.on_segment.t, triangle);
                if best.is_none_or(|best| found < (best.0, best.1)) {
                    best = Some((found.0, triangle, crossing.points.on_triangle));
                }
            }
        });
    best.map(|(_, triangle, at)| (triangle, at))
}

/// The nearest point of the surface of `second`.
pub(crate) fn nearest(
    node: u32,
    first: &Body,
    second: &Body,
    frame: &Frame<'_>,
) -> Option<(u32, TrianglePoint)> {
    let p = &frame.now[node as usize];
    let bounds = &second.tree.bounds;
    let itself = first.index == second.index;
    let whole = (bounds.max - bounds.min).norm() + (bounds.min - p).norm();
    let mut size = second.surface.mean_edge;
    loop {
        let mut best: Option<(f64, u32, TrianglePoint)> = None;
        let around = Aabb { min: *p, max: *p }.inflated(size);
        second.tree.triangles.visit(&around, |triangle| {
            let nodes = &second.surface.triangles[triangle as usize];
            if itself && first.surface.is_close(&[node], nodes) {
                return;
            }
            let corners = second.surface.corners(frame.now, triangle);
            let at = closest_on_triangle(p, &corners);
            let found = ((at.point - p).norm(), triangle);
            if best.is_none_or(|best| found < (best.0, best.1)) {
                best = Some((found.0, triangle, at));
            }
        });
        match best {
            // What is further than the box is wide may have a nearer one outside of it.
            Some((distance, triangle, at)) if distance <= size => return Some((triangle, at)),
            _ if size < whole => size *= 2.0,
            Some((_, triangle, at)) => return Some((triangle, at)),
            None => return None,
        }
    }
}

/// The normals of the corners, blended at a point.
fn smooth_normal(
    body: &Body,
    now: &[Vector3<f64>],
    triangle: u32,
    at: &TrianglePoint,
) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    for (corner, b) in at.barycentric.into_iter().enumerate() {
        sum += body.normals.of_corner(&body.surface, now, triangle, corner) * b;
    }
    sum.try_normalize(0.0)
        .unwrap_or_else(|| body.normals.face(&body.surface, now, triangle).normal)
}
