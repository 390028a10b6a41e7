//! Edges across edges, of two bodies or of one.
//!
//! Where nodes alone are held apart, edges still cut into one another (NUMERICS 6). Two ridges with their insides closest, along a direction
//! within the cones of normals of both, are the closest parts of the two surfaces there, or the deepest ones where one goes through a face
//! at the other; and two edges that have passed through one another in a step stay on their sides. Edges in flat parts and in grooves have no normals of their own and are left
//! to nodes and faces, parallel ones to nodes.

use crate::body::Body;
use crate::body_pair::{BAND, BodyPair, DEEPEST_EDGES, EdgePair, edge_reach, moved};
use crate::node_face::Pass;
use crate::normals::is_convex_edge;
use crate::point::{Key, Partner, Point};
use crate::surface::NONE;
use microsim_geometry::{
    Motion, closest_segments, edge_through_triangle, first_contact_edges, triangle_normal,
};
use nalgebra::Vector3;

/// Edges at a smaller sine² of their angle are parallel.
const PARALLEL: f64 = 1e-6;

/// A direction may be outside of the cone of normals of an edge by this: rounding, of what lies flat on it.
const CONE: f64 = 1e-6;

/// Edges closer than this fraction of the mean edge length touch: there is no direction from one to the other.
const AT_SURFACE: f64 = 1e-9;

/// Edges are only looked for that have passed one another when something moves by this fraction of the mean edge length in a step; what
/// moves by less is still seen where it cuts in.
const FAST: f64 = 0.05;

impl Pass {
    /// Adds the points of edges that face one another, and of edges that have passed one another in the step.
    /// `back` are the nodes of the second body inside the first, where that is another one.
    pub fn find_edges(&mut self, back: Option<&Pass>, pair: BodyPair<'_>, points: &mut Vec<Point>) {
        let BodyPair {
            first,
            second,
            frame,
        } = pair;
        if self.near.edges.is_empty() {
            self.across.clear();
            return;
        }
        let travel = first.travel(frame) + second.travel(frame);
        let is_fast = travel > FAST * first.surface.mean_edge.min(second.surface.mean_edge);
        let mut across = std::mem::take(&mut self.across);
        across.clear();
        for &[a, b] in &self.near.edges {
            let found = pair.facing(a, b);
            across.extend(found.or_else(|| is_fast.then(|| pair.passed(a, b)).flatten()));
        }
        // Of several exits that of what entered during the step is right, else the shortest: be it that of a node of one of the edges,
        // or of the next edge.
        let is_better = |direction: &Self, nodes: [u32; 2], across: &EdgePair| {
            nodes.into_iter().any(|node| {
                direction
                    .depth(node)
                    .is_some_and(|depth| depth < -across.gap)
                    || (across.is_old && direction.come_in(node).is_some())
            })
        };
        across.retain(|across| {
            let nodes = first.surface.edges[across.edges[0] as usize].nodes;
            let others = second.surface.edges[across.edges[1] as usize].nodes;
            let back = back.unwrap_or(self);
            across.gap >= 0.0
                || !(is_better(self, nodes, across) || is_better(back, others, across))
        });
        retain_shallowest(&mut across, 0, second);
        across.sort_unstable_by_key(|across| [across.edges[1], across.edges[0]]);
        retain_shallowest(&mut across, 1, first);
        for across in &across {
            pair.add_edges(across, points);
        }
        self.across = across;
    }
}

/// Of an edge that is in two neighbouring edges, the older or deeper one goes. `across` is ascending by `one` of its edges, and the others are those of
/// `body`.
fn retain_shallowest(across: &mut Vec<EdgePair>, one: usize, body: &Body) {
    let other = 1 - one;
    let have_common_node = |a: u32, b: u32| {
        let [a, b] = [a, b].map(|edge| body.surface.edges[edge as usize].nodes);
        a.iter().any(|node| b.contains(node))
    };
    let mut first = 0;
    while first < across.len() {
        let edge = across[first].edges[one];
        let group = across[first..]
            .iter()
            .take_while(|next| next.edges[one] == edge);
        let last = first + group.count();
        for k in first..last {
            let EdgePair {
                edges, gap, is_old, ..
            } = across[k];
            let is_deeper = across[first..last].iter().any(|next| {
                (!next.is_old, next.gap) > (!is_old, gap)
                    && have_common_node(next.edges[other], edges[other])
            });
            // Marked, not removed: it still counts against others of the group, as they do against it.
            if gap < 0.0 && is_deeper {
                across[k].parameters[0] = f64::NAN;
            }
        }
        first = last;
    }
    across.retain(|across| !across.parameters[0].is_nan());
}

impl BodyPair<'_> {
    /// Two ridges whose insides are the closest parts of both surfaces there, or that are in one another.
    fn facing(&self, a: u32, b: u32) -> Option<EdgePair> {
        let (reach, now) = (self.frame.reach, self.frame.now);
        let first = self.first.edge_at(a, now);
        let second = self.second.edge_at(b, now);
        let edge = self
            .first
            .surface
            .mean_edge
            .min(self.second.surface.mean_edge);
        let limit = edge_reach(self.first, self.second, reach);
        if !are_boxes_within(&first, &second, limit) {
            return None;
        }
        if !(self.first.is_ridge_now(a, now) && self.second.is_ridge_now(b, now)) {
            return None;
        }
        let (parameters, apart, across) = inner(&first, &second)?;
        let distance = apart.norm();
        let is_near = distance < limit;
        if !is_near {
            return None;
        }
        let across = [across, -across].into_iter().find(|normal| {
            self.first.in_cone(a, &-normal, now) && self.second.in_cone(b, normal, now)
        })?;
        let height = apart.dot(&across);
        // The difference of two places far apart has a better direction than the product of two edges.
        let normal = if distance > AT_SURFACE * edge {
            apart / height.signum() / distance
        } else {
            across
        };
        let gap = apart.dot(&normal);
        let mut is_old = false;
        let is_there = if gap >= 0.0 {
            gap < reach
        } else {
            let moved = |at: &[Vector3<f64>]| {
                let place = |[p, q]: [Vector3<f64>; 2], t: f64| p + (q - p) * t;
                place(self.first.edge_at(a, at), parameters[0])
                    - place(self.second.edge_at(b, at), parameters[1])
            };
            // What was apart in this direction before the step came in along it; what was not was in one another then.
            is_old = moved(self.frame.start).dot(&normal) <= -BAND * edge;
            gap > -DEEPEST_EDGES * edge
                && self.cut(a, b, now)
                && (!is_old || self.cut(a, b, self.frame.start))
        };
        is_there.then_some(EdgePair {
            edges: [a, b],
            parameters,
            normal,
            gap,
            is_old,
        })
    }

    /// Whether one of two edges goes through a face at the other.
    fn cut(&self, a: u32, b: u32, at: &[Vector3<f64>]) -> bool {
        let through = |(one, edge): (&Body, u32), (other, next): (&Body, u32)| {
            let [p, q] = one.edge_at(edge, at);
            let triangles = other.surface.edges[next as usize].triangles;
            triangles.iter().any(|&triangle| {
                let corners = other.surface.corners(at, triangle);
                edge_through_triangle(&p, &q, &corners).is_some()
            })
        };
        let (first, second) = ((self.first, a), (self.second, b));
        through(first, second) || through(second, first)
    }

    /// Two edges that went through one another in the step.
    fn passed(&self, a: u32, b: u32) -> Option<EdgePair> {
        let frame = self.frame;
        let [start, now] = [frame.start, frame.now]
            .map(|at| [self.first.edge_at(a, at), self.second.edge_at(b, at)]);
        let volume =
            |[[p, q], [r, s]]: &[[Vector3<f64>; 2]; 2]| (r - p).dot(&(q - p).cross(&(s - r)));
        if volume(&start) * volume(&now) > 0.0 {
            return None;
        }
        let motion = |k: usize| Motion {
            start: start[k],
            end: now[k],
        };
        let contact = first_contact_edges(&motion(0), &motion(1), 0.0)?;
        let parameters = [contact.first[1], contact.second[1]];
        let is_inner = parameters.iter().all(|&t| t > 0.0 && t < 1.0);
        let normal = contact.normal.filter(|_| is_inner)?;
        let at = |[p, q]: [Vector3<f64>; 2], t: f64| p + (q - p) * t;
        let apart = |[first, second]: [[Vector3<f64>; 2]; 2]| {
            normal.dot(&(at(first, parameters[0]) - at(second, parameters[1])))
        };
        let gap = apart(now);
        let came_from_outside = apart(start) > 0.0
            && self.first.in_cone(a, &-normal, frame.start)
            && self.second.in_cone(b, &normal, frame.start);
        (gap < 0.0 && came_from_outside).then_some(EdgePair {
            edges: [a, b],
            parameters,
            normal,
            gap,
            is_old: false,
        })
    }

    fn add_edges(&self, across: &EdgePair, points: &mut Vec<Point>) {
        let is_near = across.gap < self.frame.reach;
        if !is_near {
            return;
        }
        let mut bodies = [self.first, self.second];
        let EdgePair {
            mut edges,
            mut parameters,
            mut normal,
            gap,
            ..
        } = *across;
        let itself = self.first.index == self.second.index;
        if itself && edges[0] > edges[1] {
            bodies.swap(0, 1);
            edges.swap(0, 1);
            parameters.swap(0, 1);
            normal = -normal;
        }
        let [first, second] = [0, 1].map(|k| bodies[k].surface.edges[edges[k] as usize].nodes);
        let nodes = [first[0], first[1], second[0], second[1]];
        let weights = [
            1.0 - parameters[0],
            parameters[0],
            parameters[1] - 1.0,
            -parameters[1],
        ];
        let [p, q] = first.map(|node| self.frame.now[node as usize]);
        points.push(Point {
            key: Key {
                body: bodies[0].index,
                partner: Partner::Body {
                    body: bodies[1].index,
                },
                first: [first[0], first[1], NONE],
                second,
            },
            nodes,
            weights,
            first: 2,
            normal,
            gap,
            start_gap: gap - normal.dot(&moved(self.frame, &nodes, &weights)),
            drift: Vector3::zeros(),
            place: p + (q - p) * parameters[0],
        });
    }
}

impl Body {
    fn edge_at(&self, edge: u32, at: &[Vector3<f64>]) -> [Vector3<f64>; 2] {
        self.surface.edges[edge as usize]
            .nodes
            .map(|node| at[node as usize])
    }

    fn is_ridge_now(&self, edge: u32, now: &[Vector3<f64>]) -> bool {
        self.normals.is_ridge(&self.surface, now, edge)
    }

    /// Whether the points along `direction` from the inside of an edge have their closest point there: the edge is a ridge, and the direction
    /// points away from both faces.
    fn in_cone(&self, edge: u32, direction: &Vector3<f64>, at: &[Vector3<f64>]) -> bool {
        let surface = &self.surface;
        let sides = &surface.edges[edge as usize];
        if sides.triangles.contains(&NONE) {
            return false;
        }
        let normals = sides
            .triangles
            .map(|triangle| triangle_normal(&surface.corners(at, triangle)));
        let [Some(n), Some(m)] = normals else {
            return false;
        };
        if direction.dot(&(n + m)) <= 0.0 || !is_convex_edge(surface, at, edge, &[n, m]) {
            return false;
        }
        let [p, q] = sides.nodes.map(|node| at[node as usize]);
        let along = q - p;
        [0, 1].into_iter().all(|side| {
            let arm = at[surface.opposite(sides, side) as usize] - p;
            let inward = arm - along * (arm.dot(&along) / along.norm_squared());
            direction.dot(&inward) <= CONE * inward.norm()
        })
    }
}

/// Whether the boxes around two edges are at most `limit` apart on every axis.
#[inline]
fn are_boxes_within([p, q]: &[Vector3<f64>; 2], [a, b]: &[Vector3<f64>; 2], limit: f64) -> bool {
    let near = |k: usize| {
        p[k].min(q[k]) - a[k].max(b[k]) <= limit && a[k].min(b[k]) - p[k].max(q[k]) <= limit
    };
    near(0) && near(1) && near(2)
}

/// Where two edges are closest, when both places are within them: their parameters along the edges, the vector from the second to the first, and the unit normal of both.
fn inner(
    [p, q]: &[Vector3<f64>; 2],
    [a, b]: &[Vector3<f64>; 2],
) -> Option<([f64; 2], Vector3<f64>, Vector3<f64>)> {
    let (u, v) = (q - p, b - a);
    let across = u.cross(&v);
    let squared = across.norm_squared();
    let is_across = squared > PARALLEL * u.norm_squared() * v.norm_squared();
    if !is_across {
        return None;
    }
    let closest = closest_segments(p, q, a, b);
    let parameters = [closest.first.t, closest.second.t];
    let is_inner = parameters.iter().all(|&t| t > 0.0 && t < 1.0);
    is_inner.then(|| {
        let apart = closest.first.point - closest.second.point;
        (parameters, apart, across / squared.sqrt())
    })
}
