//! Bodies against one another, and against themselves.
//!
//! A node inside has the depth and the way out of [`Depths`]; one that is outside, its distance from the nearest point of the other
//! surface; and one that has come through a face in the step, the distance along the normal that it had before. Edges across edges
//! see `edges`.

use crate::body::Body;
use crate::depth::{Depths, crossing, nearest};
use crate::detector::{Frame, VesselEnd};
use crate::edges::Crossing;
use crate::near::Near;
use crate::outward;
use crate::point::{Key, Partner, Point};
use crate::skin::NONE;
use microsim_geometry::{Motion, TrianglePoint, closest_on_triangle, first_contact_point_triangle};
use nalgebra::Vector3;

/// A node is at a surface when it is closer than this share of the mean edge length: no direction leads from it to there.
const AT_SURFACE: f64 = 1e-9;

/// Nodes whose outward normal has a larger cosine than this with the normal of the point are on the side that faces away.
const FACING: f64 = 0.1;

/// No way along the surface from a node may lead closer to what it touches than at this cosine, 60°: in a flat face what lies
/// beside it in its plane does not touch it. Strictly no way may lead closer at all; but where a surface is only a little
/// curved, its nodes stand for their surroundings.
const SLOPE: f64 = 0.5;

/// Within a body, what is less deep than this share of the mean edge length is rounding of neighbours (NUMERICS 6).
const SELF_DEPTH: f64 = 1e-4;

/// What is kept of one direction of a pair: nodes and edges of the one, faces and edges of the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct Direction {
    pub near: Near,
    pub depths: Depths,
    pub crossings: Vec<Crossing>,
    /// The nodes that the end-plane rule is for.
    caught: Vec<u32>,
}

/// Two bodies, or one twice, in a frame.
#[derive(Clone, Copy)]
pub(crate) struct Meeting<'a> {
    pub first: &'a Body,
    pub second: &'a Body,
    pub frame: &'a Frame<'a>,
}

impl Direction {
    /// Adds the points of nodes of the first body with the second one, of which `end` is an end opposite to one of the first.
    pub fn find(&mut self, meeting: Meeting<'_>, end: Option<&VesselEnd>, points: &mut Vec<Point>) {
        let Meeting {
            first,
            second,
            frame,
        } = meeting;
        self.near.update(first, second, frame.reach);
        self.depths.find(first, second, &self.near, frame);
        self.caught.clear();
        if let Some(end) = end {
            let inside = self.depths.nodes.iter().map(|deep| deep.node);
            meeting.at_end(end, inside, &self.near, &mut self.caught, points);
        }
        let itself = first.index == second.index;
        for deep in &self.depths.nodes {
            let is_noise = itself && deep.depth < SELF_DEPTH * first.skin.mean_edge;
            let is_done = self.caught.binary_search(&deep.node).is_ok();
            if is_noise || is_done || !deep.has_way() {
                continue;
            }
            let p = &frame.now[deep.node as usize];
            let beyond = p + deep.out * (2.0 * deep.depth + second.skin.mean_edge);
            let left = crossing(p, &beyond, deep.node, false, first, second, frame);
            if let Some((triangle, at)) = left.or_else(|| nearest(deep.node, first, second, frame))
            {
                let nodes = &second.skin.triangles[triangle as usize];
                meeting.add(deep.node, nodes, &at, &deep.out, -deep.depth, points);
            }
        }
        for pairs in self.near.node_triangles.chunk_by(|a, b| a[0] == b[0]) {
            let node = pairs[0][0];
            if self.depths.place(node).is_none() && self.caught.binary_search(&node).is_err() {
                meeting.outside(node, pairs, points);
            }
        }
    }
}

impl Meeting<'_> {
    /// A node that is not inside now.
    fn outside(&self, node: u32, pairs: &[[u32; 2]], points: &mut Vec<Point>) {
        let Self {
            first,
            second,
            frame,
        } = self;
        let skin = &second.skin;
        let (from, to) = (frame.start[node as usize], frame.now[node as usize]);
        let mut best: Option<(f64, u32, TrianglePoint)> = None;
        let mut entered: Option<(f64, u32)> = None;
        for &[_, triangle] in pairs {
            let corners = outward::corners(skin, frame.now, triangle);
            let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            let height = (to - corners[0]).dot(&normal);
            if height < 0.0 {
                let start = outward::corners(skin, frame.start, triangle);
                let normal = (start[1] - start[0]).cross(&(start[2] - start[0]));
                if (from - start[0]).dot(&normal) > 0.0 {
                    let motions = motions(&from, &to, &start, &corners);
                    if let Some(contact) = first_contact_point_triangle(&motions.0, &motions.1, 0.0)
                    {
                        let found = (contact.time, triangle);
                        if entered.is_none_or(|entered| found < entered) {
                            entered = Some(found);
                        }
                    }
                }
            }
            if height * height > frame.reach * frame.reach * normal.norm_squared() {
                continue;
            }
            let at = closest_on_triangle(&to, &corners);
            let found = ((at.point - to).norm(), triangle);
            if found.0 < frame.reach && best.is_none_or(|best| found < (best.0, best.1)) {
                best = Some((found.0, triangle, at));
            }
        }
        if let Some((_, triangle)) = entered {
            let corners = outward::corners(skin, frame.now, triangle);
            let start = outward::corners(skin, frame.start, triangle);
            let motions = motions(&from, &to, &start, &corners);
            if let Some(contact) = first_contact_point_triangle(&motions.0, &motions.1, 0.0) {
                let [b0, b1, b2] = contact.second;
                let at = TrianglePoint {
                    point: corners[0] * b0 + corners[1] * b1 + corners[2] * b2,
                    barycentric: contact.second,
                };
                let normal = contact
                    .normal
                    .unwrap_or_else(|| second.outward.face(skin, frame.now, triangle).normal);
                let gap = (to - at.point).dot(&normal);
                let outward = first.outward.of_node(&first.skin, frame.now, node);
                if gap < 0.0 && outward.dot(&normal) <= FACING {
                    let nodes = &skin.triangles[triangle as usize];
                    self.add(node, nodes, &at, &normal, gap, points);
                    return;
                }
            }
        }
        let Some((distance, triangle, at)) = best else {
            return;
        };
        let outward = outward::of_point(second, frame.now, triangle, &at);
        let apart = to - at.point;
        let (gap, normal) = if distance > AT_SURFACE * skin.mean_edge {
            (distance, apart / distance)
        } else {
            (apart.dot(&outward), outward)
        };
        if normal.dot(&outward) > 0.0 && self.faces(node, &normal) {
            let nodes = &skin.triangles[triangle as usize];
            self.add(node, nodes, &at, &normal, gap, points);
        }
    }

    /// Whether a node of the first body faces what it touches along `normal`.
    fn faces(&self, node: u32, normal: &Vector3<f64>) -> bool {
        let (skin, now) = (&self.first.skin, self.frame.now);
        let p = &now[node as usize];
        let outward = self.first.outward.of_node(skin, now, node);
        outward.dot(normal) <= FACING
            && skin.triangles_at(node).iter().all(|&triangle| {
                skin.triangles[triangle as usize].iter().all(|&other| {
                    let way = now[other as usize] - p;
                    -way.dot(normal) <= SLOPE * way.norm()
                })
            })
    }

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
        if !(gap < frame.reach) {
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

/// By how much the sides moved against one another since the start of the step [m].
pub(crate) fn moved(frame: &Frame<'_>, nodes: &[u32; 4], weights: &[f64; 4]) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    for (&node, &weight) in nodes.iter().zip(weights) {
        sum += (frame.now[node as usize] - frame.start[node as usize]) * weight;
    }
    sum
}

fn motions(
    from: &Vector3<f64>,
    to: &Vector3<f64>,
    start: &[Vector3<f64>; 3],
    end: &[Vector3<f64>; 3],
) -> (Motion<1>, Motion<3>) {
    let point = Motion {
        start: [*from],
        end: [*to],
    };
    let triangle = Motion {
        start: *start,
        end: *end,
    };
    (point, triangle)
}
