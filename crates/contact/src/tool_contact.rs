//! Capsules of tools against the surface of a body.
//!
//! Each feature of the surface has at most one point with a capsule: a node and the axis point closest to it, an edge and the
//! axis where the closest point is within the edge, a face and an end of the axis whose foot is within the face. A feature stays on
//! the side of the capsule on which it was: where it has come past the axis, the normal is that of the first contact in the step, or
//! the last one of [`Sides`](crate::Sides). Only the front counts, the features that face the capsule: a tool above a thin layer does not
//! touch the layer's other side. A capsule that was inside tissue from the start, without a last normal, exits through the nearest side.
//!
//! Limitations: a capsule that is so deep in tissue that no surface is within its radius touches nothing, until it comes out.

use crate::body::Body;
use crate::capsule_motion::CapsuleMotion;
use crate::features::Features;
use crate::frame::Frame;
use crate::normals::Normals;
use crate::point::{Key, Partner, Point};
use crate::surface::{ContactSurface, NONE};
use microsim_geometry::{
    Aabb, Capsule, Motion, TriangleFeature, closest_on_triangle, closest_segments,
    first_contact_edges, first_contact_point_triangle, triangle_normal,
};
use nalgebra::Vector3;

/// A direction from a point that is closer to the axis than this fraction of the radius is noise.
const ON_AXIS: f64 = 1e-9;

/// A feature whose outward normal has a larger cosine than this with the direction from the axis to it faces away. For the closest
/// feature of a closed surface it is below 0 (Bærentzen, Aanæs 2005); the rest leaves room for flanks.
const FACING: f64 = 0.1;

/// What came past the axis and is outside again has gone through when its direction has turned by more than 120°; by less,
/// it has grazed.
const THROUGH: f64 = -0.5;

/// By this fraction of sizes and displacements what has come through a face may miss it: far above
/// [`CONTACT_TOLERANCE`](microsim_geometry::CONTACT_TOLERANCE).
const PASSED: f64 = 1e-3;

/// Edges up to this fraction of the radius, and faces of such, are left to their nodes: between nodes on the capsule a chord is inside by an
/// eighth of its length times this fraction, 1 % of it. A surface that lies close to a wide capsule would else be held off by that, at
/// places that jump with every small turn of its faces.
const SMALL: f64 = 0.08;

/// One capsule over the step, up to now.
struct SweptCapsule {
    partner: Partner,
    start: Capsule,
    end: Capsule,
    /// How far its axis goes \[m\], at most.
    travel: f64,
}

/// A feature that was in a capsule from the start and faces away from it: the capsule is in the tissue.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inside {
    touch: Touching,
    /// Unit normal of the feature.
    outward: Vector3<f64>,
    /// Of the feature from the axis before the step \[m\].
    distance: f64,
}

/// What a search works with, retained from one to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    /// Leaves no feature out by the distances of its nodes: what tests compare with.
    pub compares_all: bool,
    inside: Vec<Inside>,
    /// By node; of another capsule unless the node is among the features that were found near this one.
    distances: Vec<Distances>,
}

/// Where a node is to the axis of a capsule.
#[derive(Clone, Copy, Debug, Default)]
struct Distances {
    /// Its distance before the step and now \[m\].
    before: f64,
    now: f64,
    /// How far it goes \[m\].
    travel: f64,
}

/// A feature and the place on an axis that it touches.
#[derive(Clone, Copy, Debug)]
struct Touching {
    nodes: [u32; 3],
    weights: [f64; 3],
    count: usize,
    /// Where on the axis, 0..1.
    t: f64,
    /// The end of the axis that a face touches; [`NONE`] of other features.
    end: u32,
}

/// The box of what a capsule may touch, if that of the body comes into it.
pub(crate) fn reach(body: &Body, motion: &CapsuleMotion, frame: &Frame<'_>) -> Option<Aabb> {
    if !motion.is_finite() {
        return None;
    }
    let (start, end) = (motion.start, motion.at(frame.fraction));
    let bounds = start.swept_bounds(&end).inflated(frame.reach);
    bounds.overlaps(&body.tree.bounds).then_some(bounds)
}

/// Adds the points of a body with the capsules of a tool.
pub(crate) fn find(
    body: &Body,
    (tool, capsules): (u32, &[CapsuleMotion]),
    frame: &Frame<'_>,
    features: &mut Features,
    scratch: &mut Scratch,
    points: &mut Vec<Point>,
) {
    let Scratch {
        inside,
        distances,
        compares_all,
    } = scratch;
    distances.resize(frame.now.len(), Distances::default());
    for (index, motion) in capsules.iter().enumerate() {
        let Some(bounds) = reach(body, motion, frame) else {
            continue;
        };
        let (start, end) = (motion.start, motion.at(frame.fraction));
        features.find(&body.surface, &body.tree.triangles, &bounds);
        let swept = SweptCapsule {
            partner: Partner::Tool {
                tool,
                capsule: index as u32,
            },
            start,
            end,
            travel: (end.a - start.a).norm().max((end.b - start.b).norm()),
        };
        inside.clear();
        let mut search = Search {
            surface: &body.surface,
            body: body.index,
            normals: &body.normals,
            frame,
            swept: &swept,
            front: f64::INFINITY,
            compares_all: *compares_all,
            inside: &mut *inside,
            points,
        };
        for &node in &features.nodes {
            distances[node as usize] = search.node(node);
        }
        for &edge in &features.edges {
            search.edge(edge, distances);
        }
        for &triangle in &features.triangles {
            if search.may_touch_face(triangle, distances) {
                search.faces(triangle);
            }
        }
        search.leave();
    }
}

struct Search<'a> {
    surface: &'a ContactSurface,
    body: u32,
    normals: &'a Normals,
    frame: &'a Frame<'a>,
    swept: &'a SweptCapsule,
    /// The smallest distance from the axis before the step, of features that face it and touch.
    front: f64,
    compares_all: bool,
    inside: &'a mut Vec<Inside>,
    points: &'a mut Vec<Point>,
}

/// Where a node or an edge is to an axis.
struct Places<'a> {
    nodes: &'a [u32],
    /// From the axis to the feature, before the step and now \[m\].
    start: Vector3<f64>,
    now: Vector3<f64>,
    /// Where on the axis now.
    t: f64,
    /// Weights of the nodes now.
    weights: [f64; 2],
    /// Distance from the axis before the step and now, and how far the nodes go, at most.
    distances: Distances,
}

impl Search<'_> {
    /// Adds the point of a node, if there is one; gives where it is.
    fn node(&mut self, node: u32) -> Distances {
        let SweptCapsule { start, end, .. } = self.swept;
        let (from, to) = (
            self.frame.start[node as usize],
            self.frame.now[node as usize],
        );
        let on_axis = end.axis_point(&to);
        let apart_before = from - start.axis_point(&from).point;
        let apart = to - on_axis.point;
        let distances = Distances {
            before: apart_before.norm(),
            now: apart.norm(),
            travel: (to - from).norm(),
        };
        let places = Places {
            nodes: &[node],
            start: apart_before,
            now: apart,
            t: on_axis.t,
            weights: [1.0, 0.0],
            distances,
        };
        let motion = Motion {
            start: [from, from],
            end: [to, to],
        };
        let (surface, now) = (self.surface, self.frame.now);
        self.point_or_edge(&places, &motion, |search| {
            search.normals.of_node(surface, now, node)
        });
        distances
    }

    /// Adds the point of an edge, if there is one.
    fn edge(&mut self, edge: u32, distances: &[Distances]) {
        let SweptCapsule { start, end, .. } = self.swept;
        let nodes = self.surface.edges[edge as usize].nodes;
        let from = nodes.map(|node| self.frame.start[node as usize]);
        let to = nodes.map(|node| self.frame.now[node as usize]);
        let ends = nodes.map(|node| distances[node as usize]);
        let [from_length, to_length] = [&from, &to].map(|of| (of[1] - of[0]).norm_squared());
        if self.is_edge_out_of_reach(&ends, from_length, to_length) || self.is_small(&from) {
            return;
        }
        let travel = ends[0].travel.max(ends[1].travel);
        let closest = closest_segments(&to[0], &to[1], &end.a, &end.b);
        let before = closest_segments(&from[0], &from[1], &start.a, &start.b);
        let apart_before = before.first.point - before.second.point;
        let apart = closest.first.point - closest.second.point;
        let places = Places {
            nodes: &nodes,
            start: apart_before,
            now: apart,
            t: closest.second.t,
            weights: [1.0 - closest.first.t, closest.first.t],
            distances: Distances {
                before: apart_before.norm(),
                now: apart.norm(),
                travel,
            },
        };
        let motion = Motion {
            start: from,
            end: to,
        };
        let (surface, now) = (self.surface, self.frame.now);
        self.point_or_edge(&places, &motion, |search| {
            search.normals.of_edge(surface, now, edge)
        });
    }

    /// Whether these corners are so near to one another that they suffice.
    fn is_small(&self, corners: &[Vector3<f64>]) -> bool {
        let most = SMALL * self.swept.start.radius;
        let mut others = corners.iter().enumerate();
        others.all(|(k, a)| {
            let rest = corners[k + 1..].iter();
            rest.into_iter()
                .all(|b| (a - b).norm_squared() <= most * most)
        })
    }

    fn is_near(&self, of: &Distances) -> bool {
        of.now - self.swept.end.radius < self.frame.reach
    }

    /// Whether it may have been in the capsule meanwhile: a distance changes by no more than the displacements.
    fn may_pass(&self, of: &Distances) -> bool {
        let travel = of.travel + self.swept.travel;
        of.before + of.now - travel < 2.0 * self.swept.end.radius
    }

    /// Whether no point of an edge can touch, by where its ends are and the squares of its length before the step and now \[m²\]: no point of a segment is nearer than half of what
    /// the distances of its ends exceed its length by. It takes no square root, as most edges are out of reach, and may leave some of them to what follows.
    fn is_edge_out_of_reach(
        &self,
        [one, two]: &[Distances; 2],
        length_before: f64,
        length_now: f64,
    ) -> bool {
        if self.compares_all {
            return false;
        }
        let radius = (1.0 + ON_AXIS) * self.swept.end.radius;
        let now = one.now + two.now;
        // Of what is near, the length exceeds this, and of what may pass, the sum of both lengths does.
        let of_near = now - 2.0 * (radius + self.frame.reach);
        let travel = one.travel.max(two.travel) + self.swept.travel;
        let of_passing = one.before + two.before + now - 2.0 * travel - 4.0 * radius;
        let may_exceed = |length: f64, squared: f64| length <= 0.0 || length * length <= squared;
        let is_near = may_exceed(of_near, length_now);
        // (a + b)² ≤ 2 (a² + b²).
        !is_near && !may_exceed(of_passing, 2.0 * (length_before + length_now))
    }

    /// Whether an end of the axis may touch the inside of a face, or have come through it: its distance from it was 0 meanwhile, but for
    /// [`PASSED`].
    fn may_touch_face(&self, triangle: u32, distances: &[Distances]) -> bool {
        let corners = self.surface.corners(self.frame.now, triangle);
        let nodes = self.surface.triangles[triangle as usize];
        let of = nodes.map(|node| distances[node as usize]);
        let longest = (0..3)
            .map(|k| (corners[(k + 1) % 3] - corners[k]).norm_squared())
            .fold(0.0, f64::max);
        // With barycentric coordinates λ of a point p, Σ λ_k |p − v_k|² is at most R² = longest²/3 (Jung 1901), and so is the least of the |p − v_k|².
        let radius = (longest / 3.0).sqrt();
        let nearest = of.iter().map(|of| of.now).fold(f64::INFINITY, f64::min) - radius;
        let travel = of.iter().map(|of| of.travel).fold(0.0, f64::max) + self.swept.travel;
        let most = travel.max(self.swept.end.radius + self.frame.reach);
        self.compares_all || nearest <= most + PASSED * (most + radius)
    }

    /// Adds the point of a node or an edge, if there is one.
    fn point_or_edge(
        &mut self,
        places: &Places<'_>,
        motion: &Motion<2>,
        outward: impl FnOnce(&mut Self) -> Vector3<f64>,
    ) {
        let radius = self.swept.end.radius;
        let (before, distance) = (places.distances.before, places.distances.now);
        let travel = places.distances.travel + self.swept.travel;
        let (near, may_pass) = (
            self.is_near(&places.distances),
            self.may_pass(&places.distances),
        );
        if !(near || may_pass) {
            return;
        }
        let own = (distance > ON_AXIS * radius).then(|| places.now / distance);
        // What is now outside has gone through when it has turned by more than what is inside needs to.
        let through = if distance < radius { 0.0 } else { THROUGH };
        let mut touch = Touching {
            nodes: [places.nodes[0], *places.nodes.last().unwrap_or(&NONE), NONE],
            weights: [places.weights[0], places.weights[1], 0.0],
            count: places.nodes.len(),
            t: places.t,
            end: NONE,
        };
        if before >= radius {
            // From outside to the other side of the axis it is further than the radius.
            if may_pass
                && travel > radius
                && let Some(first) = first_contact_edges(motion, &self.swept.axis(), radius)
                && let Some(entry) = first.normal
                && own.is_none_or(|own| own.dot(&entry) < through)
            {
                touch.t = first.second[1];
                touch.weights = [first.first[0], first.first[1], 0.0];
                if touch.count == 1 {
                    touch.weights = [1.0, 0.0, 0.0];
                }
                if touch.is_inner() && entry.dot(&outward(self)) <= FACING {
                    self.add(&touch, &entry);
                }
                return;
            }
            if let Some(own) = own
                && near
                && touch.is_inner()
                && own.dot(&outward(self)) <= FACING
            {
                self.front = self.front.min(before);
                self.add(&touch, &own);
            }
            return;
        }
        if !touch.is_inner() {
            return;
        }
        let side = (before > ON_AXIS * radius).then(|| places.start / before);
        let side = match (self.remembered(&touch), side) {
            (Some(old), Some(side)) if side.dot(&old) > 0.0 => side,
            (Some(old), _) => old,
            (None, side) => {
                let outward = outward(self);
                match side {
                    Some(side) if side.dot(&outward) <= FACING => side,
                    Some(_) => {
                        if near {
                            self.inside.push(Inside {
                                touch,
                                outward,
                                distance: before,
                            });
                        }
                        return;
                    }
                    // The axis lies in the surface.
                    None if outward != Vector3::zeros() => -outward,
                    None => return,
                }
            }
        };
        self.front = self.front.min(before);
        let both_inner = touch.count == 2 && touch.t > 0.0 && touch.t < 1.0;
        match own {
            Some(own) if own.dot(&side) > through => {
                if near {
                    self.add(&touch, &own);
                }
            }
            // EdgePair both lines there is one direction and its opposite.
            Some(own) if both_inner => self.add(&touch, &-own),
            _ => self.add(&touch, &side),
        }
    }

    /// Adds the points of the inside of a face with the ends of the axis, if there are any.
    fn faces(&mut self, triangle: u32) {
        let corners = self.surface.corners(self.frame.now, triangle);
        if let Some(normal) = triangle_normal(&corners) {
            self.face(triangle, 0, &corners, &normal);
            self.face(triangle, 1, &corners, &normal);
        }
    }

    /// Adds the point of the inside of a face with its corners and normal now and of an end of the axis, if there is one.
    fn face(
        &mut self,
        triangle: u32,
        end: u32,
        corners: &[Vector3<f64>; 3],
        normal: &Vector3<f64>,
    ) {
        let (surface, frame) = (self.surface, self.frame);
        let (from, to) = self.swept.end(end);
        let (corners, normal) = (*corners, *normal);
        let height = (to - corners[0]).dot(&normal);
        let radius = self.swept.end.radius;
        if height - radius >= frame.reach {
            return;
        }
        let start = surface.corners(frame.start, triangle);
        if self.is_small(&start) {
            return;
        }
        let before = (from - start[0]).dot(&triangle_normal(&start).unwrap_or(normal));
        let foot = closest_on_triangle(&to, &corners);
        let is_inner = foot.feature() == TriangleFeature::Face;
        let mut touch = Touching {
            nodes: surface.triangles[triangle as usize],
            weights: foot.barycentric,
            count: 3,
            t: f64::from(end),
            end,
        };
        let first = || {
            let end = Motion {
                start: [from],
                end: [to],
            };
            let triangle = Motion {
                start,
                end: corners,
            };
            first_contact_point_triangle(&end, &triangle, 0.0)
        };
        if before >= 0.0 && height < 0.0 {
            if let Some(first) = first() {
                touch.weights = first.second;
                self.add(&touch, &-normal);
            }
            return;
        }
        if !is_inner {
            return;
        }
        if height >= 0.0 {
            // What was behind the plane may have come round the face, or through it from the other side.
            if before >= 0.0 || first().is_none() {
                self.front = self.front.min(before.abs());
                self.add(&touch, &-normal);
            }
            return;
        }
        match self.remembered(&touch) {
            Some(old) if old.dot(&-normal) > 0.5 && -height < radius => {
                self.front = self.front.min(-before);
                self.add(&touch, &-normal);
            }
            None if -before < radius && -height < radius => self.inside.push(Inside {
                touch,
                outward: normal,
                distance: -before,
            }),
            _ => {}
        }
    }

    /// Out of the tissue through the nearest side, where no side that faces the capsule is nearer.
    fn leave(&mut self) {
        let nearest = self
            .inside
            .iter()
            .min_by(|a, b| a.distance.total_cmp(&b.distance));
        let Some(nearest) = nearest.filter(|nearest| nearest.distance < self.front) else {
            return;
        };
        let outward = nearest.outward;
        for k in 0..self.inside.len() {
            let feature = self.inside[k];
            if feature.outward.dot(&outward) > 0.0 {
                self.add(&feature.touch, &-feature.outward);
            }
        }
    }

    /// The unit normal that a feature had at the end of the step before.
    fn remembered(&self, touch: &Touching) -> Option<Vector3<f64>> {
        let mut sum = Vector3::zeros();
        for k in 0..touch.count {
            let normal = self.frame.sides.normal(&self.swept.partner, touch.nodes[k]);
            sum += normal * touch.weights[k];
        }
        sum.try_normalize(0.0)
    }

    fn add(&mut self, touch: &Touching, normal: &Vector3<f64>) {
        let SweptCapsule {
            partner,
            start,
            end,
            ..
        } = self.swept;
        let axis = |capsule: &Capsule| capsule.a + (capsule.b - capsule.a) * touch.t;
        let (from, to) = (axis(start), axis(end));
        let (mut place, mut before) = (Vector3::zeros(), Vector3::zeros());
        for k in 0..touch.count {
            let node = touch.nodes[k] as usize;
            place += self.frame.now[node] * touch.weights[k];
            before += self.frame.start[node] * touch.weights[k];
        }
        let gap = (place - to).dot(normal) - end.radius;
        let is_near = gap < self.frame.reach;
        if !is_near {
            return;
        }
        let mut first = touch.nodes;
        first[touch.count..].fill(NONE);
        first.sort_unstable();
        let mut nodes = [touch.nodes[0]; 4];
        let mut weights = [0.0; 4];
        nodes[..touch.count].copy_from_slice(&touch.nodes[..touch.count]);
        weights[..touch.count].copy_from_slice(&touch.weights[..touch.count]);
        self.points.push(Point {
            key: Key {
                body: self.body,
                partner: *partner,
                first,
                second: [touch.end, NONE],
            },
            nodes,
            weights,
            first: touch.count as u8,
            normal: *normal,
            gap,
            start_gap: (before - from).dot(normal) - end.radius,
            drift: to - from,
            place,
        });
    }
}

impl Touching {
    /// Whether the point of an edge lies within it, and not at a node.
    fn is_inner(&self) -> bool {
        self.weights[..self.count].iter().all(|&w| w > 0.0)
    }
}

impl SweptCapsule {
    fn axis(&self) -> Motion<2> {
        Motion {
            start: [self.start.a, self.start.b],
            end: [self.end.a, self.end.b],
        }
    }

    /// An end of the axis before the step and now.
    fn end(&self, end: u32) -> (Vector3<f64>, Vector3<f64>) {
        if end == 0 {
            (self.start.a, self.end.a)
        } else {
            (self.start.b, self.end.b)
        }
    }
}
