//! Edges across edges, of two bodies or of one.
//!
//! Where nodes alone are kept apart, edges still cut into one another (NUMERICS 6). Three ways to see it: an edge that goes in and out of the
//! other surface lies across one of its edges, which is the way out; two edges that face one another with their inside closest and
//! within the cones of normals of both are the closest parts of the two surfaces; and two edges that have passed through one another in
//! a step keep to their sides. Edges in flat parts and in grooves have no normals of their own and are left
//! to nodes and faces, parallel ones to nodes.

use crate::body::Body;
use crate::meshes::{Direction, Meeting, moved};
use crate::outward;
use crate::point::{Key, Partner, Point};
use crate::skin::NONE;
use microsim_geometry::{
    Aabb, Motion, closest_segments, edge_through_triangle, first_contact_edges, triangle_normal,
};
use nalgebra::Vector3;

/// Edges at a smaller sine² of their angle are parallel.
const PARALLEL: f64 = 1e-6;

/// A direction may be outside of the cone of normals of an edge by this: rounding, of what lies flat on it.
const CONE: f64 = 1e-6;

/// Edges closer than this share of the mean edge length touch: no direction leads from one to the other.
const AT_SURFACE: f64 = 1e-9;

/// Edges are only looked for that have passed one another when something moves by this share of the mean edge length in a step; what
/// moves by less is still seen where it cuts in.
const FAST: f64 = 0.05;

/// An edge and an edge, with the place of closest approach on each.
struct Across {
    edges: [u32; 2],
    shares: [f64; 2],
    normal: Vector3<f64>,
    gap: f64,
}

/// A crossing of an edge with a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    t: f64,
    triangle: u32,
    goes_in: bool,
}

impl Direction {
    /// Adds the points of edges of the first body that go in and out of the second one between nodes that are outside. `turned` when the second
    /// body is the first side of the points.
    pub fn find_cuts(&mut self, meeting: Meeting<'_>, turned: bool, points: &mut Vec<Point>) {
        let Meeting {
            first,
            second,
            frame,
        } = meeting;
        for pairs in self.near.edge_triangles.chunk_by(|a, b| a[0] == b[0]) {
            let edge = pairs[0][0];
            if !first.is_ridge_now(edge, frame.now) {
                continue;
            }
            let [p, q] = first.edge_at(edge, frame.now);
            let around = Aabb::of(&[p, q]);
            self.crossings.clear();
            for &[_, triangle] in pairs {
                let face = second.outward.face(&second.skin, frame.now, triangle);
                if !face.bounds.overlaps(&around) {
                    continue;
                }
                let corners = outward::corners(&second.skin, frame.now, triangle);
                if face.on_one_side(&[p - corners[0], q - corners[0]]) {
                    continue;
                }
                if let Some(crossing) = edge_through_triangle(&p, &q, &corners) {
                    self.crossings.push(Crossing {
                        t: crossing.points.on_segment.t,
                        triangle,
                        goes_in: crossing.from_front,
                    });
                }
            }
            if self.crossings.len() < 2 {
                continue;
            }
            self.crossings
                .sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
            let mut came_in: Option<Crossing> = None;
            for &crossing in &self.crossings {
                if crossing.goes_in {
                    came_in.get_or_insert(crossing);
                } else if let Some(entry) = came_in.take()
                    && let Some(across) = meeting.cut(edge, &[entry, crossing], pairs)
                {
                    meeting.add_edges(&across, turned, points);
                }
            }
        }
    }

    /// Adds the points of edges that face one another, and of edges that have passed one another in the step.
    pub fn find_facing(&self, meeting: Meeting<'_>, points: &mut Vec<Point>) {
        let Meeting {
            first,
            second,
            frame,
        } = meeting;
        let is_fast =
            first.travel + second.travel > FAST * first.skin.mean_edge.min(second.skin.mean_edge);
        if !(is_fast || frame.reach > 0.0) {
            return;
        }
        for &[a, b] in &self.near.edges {
            let across = meeting.facing(a, b);
            let across = across.or_else(|| is_fast.then(|| meeting.passed(a, b)).flatten());
            if let Some(across) = across {
                meeting.add_edges(&across, false, points);
            }
        }
    }
}

impl Meeting<'_> {
    /// The edge of the second body that leads out of it with the shortest way, for an edge of the first one that is inside between two crossings.
    fn cut(&self, edge: u32, crossings: &[Crossing; 2], pairs: &[[u32; 2]]) -> Option<Across> {
        let [p, q] = self.first.edge_at(edge, self.frame.now);
        let (skin, now) = (&self.second.skin, self.frame.now);
        let face = |triangle: u32| self.second.outward.face(skin, now, triangle);
        let outward = crossings.map(|crossing| face(crossing.triangle).normal);
        // The shortest way within both cones, or if there is none, the shortest that leads out through both faces.
        let mut best: Option<(bool, Across)> = None;
        let around = Aabb::of(&[p, q]);
        for &[_, triangle] in pairs {
            // What is near for other reasons does not matter.
            if !face(triangle).bounds.overlaps(&around) {
                continue;
            }
            for other in skin.triangle_edges[triangle as usize] {
                let [a, b] = self.second.edge_at(other, now);
                let Some((shares, apart, across)) = inner(&[p, q], &[a, b]) else {
                    continue;
                };
                let within = shares[0] >= crossings[0].t && shares[0] <= crossings[1].t;
                if !(within && self.second.is_ridge_now(other, now)) {
                    continue;
                }
                // The edge is on the way out where the other one is deeper.
                let normal = if apart.dot(&across) > 0.0 {
                    -across
                } else {
                    across
                };
                let gap = apart.dot(&normal);
                let in_cones = self.first.in_cone(edge, &-normal, now)
                    && self.second.in_cone(other, &normal, now);
                if !(in_cones || outward.iter().all(|face| normal.dot(face) >= -CONE)) {
                    continue;
                }
                let order = (!in_cones, -gap, other);
                let is_new = best
                    .as_ref()
                    .is_none_or(|(beside, best)| order < (*beside, -best.gap, best.edges[1]));
                if is_new {
                    let edges = [edge, other];
                    let across = Across {
                        edges,
                        shares,
                        normal,
                        gap,
                    };
                    best = Some((!in_cones, across));
                }
            }
        }
        best.map(|(_, across)| across)
    }

    /// Two edges whose insides are the closest parts of both surfaces there.
    fn facing(&self, a: u32, b: u32) -> Option<Across> {
        let (reach, now) = (self.frame.reach, self.frame.now);
        if !(self.first.is_ridge_now(a, now) && self.second.is_ridge_now(b, now)) {
            return None;
        }
        let first = self.first.edge_at(a, self.frame.now);
        let second = self.second.edge_at(b, self.frame.now);
        let (shares, apart, across) = inner(&first, &second)?;
        let distance = apart.norm();
        if !(distance < reach) {
            return None;
        }
        let at_surface = distance <= AT_SURFACE * self.second.skin.mean_edge;
        let normals = if at_surface {
            [across, -across]
        } else {
            [apart / distance; 2]
        };
        let normal = normals.into_iter().find(|normal| {
            self.first.in_cone(a, &-normal, self.frame.now)
                && self.second.in_cone(b, normal, self.frame.now)
        })?;
        Some(Across {
            edges: [a, b],
            shares,
            normal,
            gap: apart.dot(&normal),
        })
    }

    /// Two edges that went through one another in the step.
    fn passed(&self, a: u32, b: u32) -> Option<Across> {
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
        let shares = [contact.first[1], contact.second[1]];
        let is_inner = shares.iter().all(|&share| share > 0.0 && share < 1.0);
        let normal = contact.normal.filter(|_| is_inner)?;
        let at = |[p, q]: [Vector3<f64>; 2], share: f64| p + (q - p) * share;
        let apart = |[first, second]: [[Vector3<f64>; 2]; 2]| {
            normal.dot(&(at(first, shares[0]) - at(second, shares[1])))
        };
        let gap = apart(now);
        let came_from_outside = apart(start) > 0.0
            && self.first.in_cone(a, &-normal, frame.start)
            && self.second.in_cone(b, &normal, frame.start);
        (gap < 0.0 && came_from_outside).then_some(Across {
            edges: [a, b],
            shares,
            normal,
            gap,
        })
    }

    fn add_edges(&self, across: &Across, turned: bool, points: &mut Vec<Point>) {
        if !(across.gap < self.frame.reach) {
            return;
        }
        let mut bodies = [self.first, self.second];
        let Across {
            mut edges,
            mut shares,
            mut normal,
            gap,
        } = *across;
        let itself = self.first.index == self.second.index;
        if turned || (itself && edges[0] > edges[1]) {
            bodies.swap(0, 1);
            edges.swap(0, 1);
            shares.swap(0, 1);
            normal = -normal;
        }
        let [first, second] = [0, 1].map(|k| bodies[k].skin.edges[edges[k] as usize].nodes);
        let nodes = [first[0], first[1], second[0], second[1]];
        let weights = [1.0 - shares[0], shares[0], shares[1] - 1.0, -shares[1]];
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
            place: p + (q - p) * shares[0],
        });
    }
}

impl Body {
    fn edge_at(&self, edge: u32, at: &[Vector3<f64>]) -> [Vector3<f64>; 2] {
        self.skin.edges[edge as usize]
            .nodes
            .map(|node| at[node as usize])
    }

    fn is_ridge_now(&self, edge: u32, now: &[Vector3<f64>]) -> bool {
        self.outward.is_ridge(&self.skin, now, edge)
    }

    /// Whether the points along `direction` from the inside of an edge have their closest point there: the edge is a ridge, and the direction
    /// points away from both faces.
    fn in_cone(&self, edge: u32, direction: &Vector3<f64>, at: &[Vector3<f64>]) -> bool {
        let skin = &self.skin;
        let sides = &skin.edges[edge as usize];
        if sides.triangles.contains(&NONE) {
            return false;
        }
        let normals = sides
            .triangles
            .map(|triangle| triangle_normal(&outward::corners(skin, at, triangle)));
        let [Some(n), Some(m)] = normals else {
            return false;
        };
        if direction.dot(&(n + m)) <= 0.0 || !outward::stands_out(skin, at, edge, &[n, m]) {
            return false;
        }
        let [p, q] = sides.nodes.map(|node| at[node as usize]);
        let along = q - p;
        [0, 1].into_iter().all(|side| {
            let way = at[skin.opposite(sides, side) as usize] - p;
            let inward = way - along * (way.dot(&along) / along.norm_squared());
            direction.dot(&inward) <= CONE * inward.norm()
        })
    }
}

/// Where two edges are closest, when both places are within them: their shares, from the second to the first, and the unit normal of both.
fn inner(
    [p, q]: &[Vector3<f64>; 2],
    [a, b]: &[Vector3<f64>; 2],
) -> Option<([f64; 2], Vector3<f64>, Vector3<f64>)> {
    let (u, v) = (q - p, b - a);
    let across = u.cross(&v);
    let squared = across.norm_squared();
    if !(squared > PARALLEL * u.norm_squared() * v.norm_squared()) {
        return None;
    }
    let closest = closest_segments(p, q, a, b);
    let shares = [closest.first.t, closest.second.t];
    let is_inner = shares.iter().all(|&share| share > 0.0 && share < 1.0);
    is_inner.then(|| {
        let apart = closest.first.point - closest.second.point;
        (shares, apart, across / squared.sqrt())
    })
}
