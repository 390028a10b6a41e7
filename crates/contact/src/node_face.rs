//! Bodies against one another, and against themselves.
//!
//! A node that has entered during the step, or passed through, has the depth below the face that it crossed; one that was inside before, the
//! depth and exit direction of [`Depths`]; and one that is outside, its distance from the nearest point of the other surface. Edges
//! across edges see `edges`.

use crate::body_pair::{BAND, BodyPair, EdgePair, edge_reach, reach};
use crate::depth::{Depths, crossing, nearest};
use crate::near::Near;
use crate::pair::{Depth, VesselEnd};
use crate::point::Point;
use microsim_geometry::{
    Motion, TrianglePoint, closest_on_triangle, first_contact_point_triangle, triangle_normal,
};
use nalgebra::Vector3;

/// A node is at a surface when it is closer than this fraction of the mean edge length: there is no direction from one to the other.
const AT_SURFACE: f64 = 1e-9;

/// Nodes whose outward normal has a larger cosine than this with the normal of the point are on the side that faces away.
const FACING: f64 = 0.1;

/// No edge of the surface at a node may approach what it touches at more than this cosine, 60°: in a flat face what lies
/// beside it in its plane does not touch it. Strictly none may approach at all; but where a surface is only a little
/// curved, its nodes represent their surroundings.
const SLOPE: f64 = 0.5;

/// Within a body, what is less deep than this fraction of the mean edge length is rounding of neighbours (NUMERICS 6).
const SELF_DEPTH: f64 = 1e-4;

/// One pass of the two-pass search of a pair, with its caches: nodes and edges of the first body, faces and edges of the second.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pass {
    pub near: Near,
    pub depths: Depths,
    pub across: Vec<EdgePair>,
    /// The nodes that the end-plane rule is for.
    caught: Vec<u32>,
    /// The nodes that have entered during the step, with their depths.
    done: Vec<(u32, f64)>,
}

impl Pass {
    /// Adds the points of nodes of the first body with the second one, of which `end` is an end opposite to one of the first.
    pub fn find(&mut self, pair: BodyPair<'_>, end: Option<&VesselEnd>, points: &mut Vec<Point>) {
        let BodyPair {
            first,
            second,
            frame,
        } = pair;
        let reach = reach(second, frame);
        let edge_reach = edge_reach(first, second, reach);
        self.near.update(first, second, reach, edge_reach);
        self.depths.mark(second, &self.near, frame);
        self.caught.clear();
        if let Some(end) = end {
            let inside = self.depths.nodes.iter().map(|deep| deep.node);
            pair.at_end(end, inside, &self.near, &mut self.caught, points);
        }
        self.done.clear();
        for pairs in self.near.node_triangles.chunk_by(|a, b| a[0] == b[0]) {
            let node = pairs[0][0];
            if self.caught.binary_search(&node).is_ok() {
                continue;
            }
            if let Some(depth) = pair.entered(node, pairs, points) {
                self.done.push((node, depth));
            } else if self.depths.place(node).is_none() {
                pair.outside(node, pairs, points);
            }
        }
        // Where all have entered just now, their depths are known.
        if self.depths.nodes.iter().all(|deep| self.is_done(deep.node)) {
            return;
        }
        self.exit_consistently(pair, points);
    }

    /// Adds the points of nodes of the first body that are in the second one at the end of the step, and of no others.
    pub fn find_inside(&mut self, pair: BodyPair<'_>, depth: Depth, points: &mut Vec<Point>) {
        let BodyPair {
            first,
            second,
            frame,
        } = pair;
        let reach = reach(second, frame);
        self.near
            .update(first, second, reach, edge_reach(first, second, reach));
        self.depths.mark(second, &self.near, frame);
        self.caught.clear();
        self.done.clear();
        if depth == Depth::Consistent {
            return self.exit_consistently(pair, points);
        }
        for deep in &self.depths.nodes {
            let Some((triangle, at)) = nearest(deep.node, first, second, frame) else {
                continue;
            };
            let offset = at.point - frame.now[deep.node as usize];
            let distance = offset.norm();
            if distance > AT_SURFACE * second.surface.mean_edge {
                let nodes = &second.surface.triangles[triangle as usize];
                pair.add(
                    deep.node,
                    nodes,
                    &at,
                    &(offset / distance),
                    -distance,
                    points,
                );
            }
        }
    }

    /// Adds the points of the nodes inside that have none yet, by their consistent depths.
    fn exit_consistently(&mut self, pair: BodyPair<'_>, points: &mut Vec<Point>) {
        let BodyPair {
            first,
            second,
            frame,
        } = pair;
        self.depths.solve(first, second, frame);
        let itself = first.index == second.index;
        for deep in &self.depths.nodes {
            let is_noise = itself && deep.depth < SELF_DEPTH * first.surface.mean_edge;
            if is_noise || self.is_done(deep.node) || !deep.has_direction() {
                continue;
            }
            let p = &frame.now[deep.node as usize];
            let beyond = p + deep.out * (2.0 * deep.depth + second.surface.mean_edge);
            let left = crossing(p, &beyond, deep.node, false, first, second, frame);
            if let Some((triangle, at)) = left.or_else(|| nearest(deep.node, first, second, frame))
            {
                let nodes = &second.surface.triangles[triangle as usize];
                pair.add(deep.node, nodes, &at, &deep.out, -deep.depth, points);
            }
        }
    }
}

impl Pass {
    /// Whether a node has its point already.
    fn is_done(&self, node: u32) -> bool {
        self.caught.binary_search(&node).is_ok() || self.come_in(node).is_some()
    }

    /// The depth of a node that has entered during the step.
    pub fn come_in(&self, node: u32) -> Option<f64> {
        let place = self.done.binary_search_by_key(&node, |&(node, _)| node);
        place.ok().map(|place| self.done[place].1)
    }

    /// The depth of a node that is inside.
    pub fn depth(&self, node: u32) -> Option<f64> {
        let deep = || {
            self.depths
                .place(node)
                .map(|place| self.depths.nodes[place].depth)
        };
        self.come_in(node).or_else(deep)
    }
}

impl BodyPair<'_> {
    /// A node that was outside before the step and has entered since, or passed through: its depth.
    fn entered(&self, node: u32, pairs: &[[u32; 2]], points: &mut Vec<Point>) -> Option<f64> {
        let Self {
            first,
            second,
            frame,
        } = self;
        let surface = &second.surface;
        let (from, to) = (frame.start[node as usize], frame.now[node as usize]);
        let band = BAND * surface.mean_edge;
        let mut best: Option<(f64, u32)> = None;
        for &[_, triangle] in pairs {
            let corners = surface.corners(frame.now, triangle);
            let normal = second.normals.face(surface, frame.now, triangle).normal;
            let is_behind = (to - corners[0]).dot(&normal) < 0.0;
            if !is_behind {
                continue;
            }
            let start = surface.corners(frame.start, triangle);
            let is_apart = (0..3).any(|k| {
                let [low, high] = [from[k].min(to[k]) - band, from[k].max(to[k]) + band];
                let all = || start.iter().chain(&corners).map(|p| p[k]);
                all().all(|x| x > high) || all().all(|x| x < low)
            });
            if is_apart {
                continue;
            }
            let Some(normal) = triangle_normal(&start) else {
                continue;
            };
            let height = (from - start[0]).dot(&normal);
            let was_outside = height > -band;
            if !was_outside {
                continue;
            }
            // What lies at the surface counts as outside.
            let lifted = from + normal * (band - height).max(0.0);
            let point = Motion {
                start: [lifted],
                end: [to],
            };
            let triangle_motion = Motion {
                start,
                end: corners,
            };
            if let Some(contact) = first_contact_point_triangle(&point, &triangle_motion, 0.0) {
                let found = (contact.time, triangle);
                if best.is_none_or(|best| found < best) {
                    best = Some(found);
                }
            }
        }
        let (_, triangle) = best?;
        let corners = surface.corners(frame.now, triangle);
        let normal = second.normals.face(surface, frame.now, triangle).normal;
        let outward = first.normals.of_node(&first.surface, frame.now, node);
        if outward.dot(&normal) > FACING {
            return None;
        }
        let at = closest_on_triangle(&to, &corners);
        let gap = (to - corners[0]).dot(&normal);
        let nodes = &surface.triangles[triangle as usize];
        self.add(node, nodes, &at, &normal, gap, points);
        Some(-gap)
    }

    /// A node that is not inside now, and has not passed through.
    fn outside(&self, node: u32, pairs: &[[u32; 2]], points: &mut Vec<Point>) {
        let Self { second, frame, .. } = self;
        let surface = &second.surface;
        let to = frame.now[node as usize];
        let mut best: Option<(f64, u32, TrianglePoint)> = None;
        for &[_, triangle] in pairs {
            let corners = surface.corners(frame.now, triangle);
            if is_beyond(&to, &corners, frame.reach) {
                continue;
            }
            let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            let height = (to - corners[0]).dot(&normal);
            if height * height > frame.reach * frame.reach * normal.norm_squared() {
                continue;
            }
            let at = closest_on_triangle(&to, &corners);
            let found = ((at.point - to).norm(), triangle);
            if found.0 < frame.reach && best.is_none_or(|best| found < (best.0, best.1)) {
                best = Some((found.0, triangle, at));
            }
        }
        let Some((distance, triangle, at)) = best else {
            return;
        };
        let outward = second.normal_at(frame.now, triangle, &at);
        let apart = to - at.point;
        let (gap, normal) = if distance > AT_SURFACE * surface.mean_edge {
            (distance, apart / distance)
        } else {
            (apart.dot(&outward), outward)
        };
        if normal.dot(&outward) > 0.0 && self.faces(node, &normal) {
            let nodes = &surface.triangles[triangle as usize];
            self.add(node, nodes, &at, &normal, gap, points);
        }
    }

    /// Whether a node of the first body faces what it touches along `normal`.
    fn faces(&self, node: u32, normal: &Vector3<f64>) -> bool {
        let (surface, now) = (&self.first.surface, self.frame.now);
        let p = &now[node as usize];
        let outward = self.first.normals.of_node(surface, now, node);
        outward.dot(normal) <= FACING
            && surface.triangles_at(node).iter().all(|&triangle| {
                surface.triangles[triangle as usize].iter().all(|&other| {
                    let edge = now[other as usize] - p;
                    -edge.dot(normal) <= SLOPE * edge.norm()
                })
            })
    }
}

/// Whether a point is further than `limit` from the box around a triangle on any axis.
#[inline]
fn is_beyond(p: &Vector3<f64>, [a, b, c]: &[Vector3<f64>; 3], limit: f64) -> bool {
    (0..3).any(|k| {
        let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
        low - p[k] > limit || p[k] - high > limit
    })
}
