//! Obstacles against the surface of a body.
//!
//! Nodes by the signed distance; the edges of boxes and the sides of cylinders against edges of the surface, and the corners of boxes
//! against its faces, so that none sinks into a triangle between its nodes. What was outside before the step stays on the side on
//! which it entered; what was inside already, on the side of the last normal, else on the nearest one.
//!
//! Limitations: the rims of cylinders touch nodes only.

use crate::body::Body;
use crate::features::Features;
use crate::frame::Frame;
use crate::obstacle::{ObstaclePart, ObstacleShape};
use crate::point::{Key, Partner, Point};
use crate::surface::NONE;
use microsim_geometry::{
    Aabb, TriangleFeature, closest_on_triangle, closest_segments, triangle_normal,
};
use nalgebra::Vector3;

/// Steps of the search for the place where a node enters an obstacle (sphere tracing). At each the distance that is left shrinks by its own size; what grazes is
/// not in after these.
const MARCH: usize = 64;

/// A node is at the surface when it is closer than this fraction of its displacement in the step.
const AT_SURFACE: f64 = 1e-9;

/// Edges at a smaller sine² of their angle are parallel: their nodes touch.
const PARALLEL: f64 = 1e-6;

/// A direction may be outside of the cone of normals of an edge or a corner by this: rounding, of what lies flat on it.
const CONE: f64 = 1e-6;

/// Whether [`find`] looks up triangles.
pub(crate) fn needs_triangles(body: &Body, obstacle: &ObstaclePart, frame: &Frame<'_>) -> bool {
    let bounds = obstacle.bounds().inflated(frame.reach);
    obstacle.shape != ObstacleShape::HalfSpace && bounds.overlaps(&body.tree.bounds)
}

/// Adds the points of a body with a part of an obstacle.
pub(crate) fn find(
    body: &Body,
    (part, obstacle): (u32, &ObstaclePart),
    frame: &Frame<'_>,
    features: &mut Features,
    points: &mut Vec<Point>,
) {
    let bounds = obstacle.bounds().inflated(frame.reach);
    if !bounds.overlaps(&body.tree.bounds) {
        return;
    }
    let mut search = Search {
        body,
        obstacle,
        partner: Partner::Obstacle { part },
        frame,
        points,
    };
    for &node in &body.surface.nodes {
        search.node(node, &bounds);
    }
    match obstacle.shape {
        ObstacleShape::HalfSpace => {}
        ObstacleShape::Cuboid {
            half_size,
            rounding,
        } => search.cuboid(&Vector3::from(half_size), rounding, features),
        ObstacleShape::Cylinder {
            radius,
            half_length,
        } => search.cylinder(radius, half_length, features),
    }
}

struct Search<'a> {
    body: &'a Body,
    obstacle: &'a ObstaclePart,
    partner: Partner,
    frame: &'a Frame<'a>,
    points: &'a mut Vec<Point>,
}

impl Search<'_> {
    fn node(&mut self, node: u32, bounds: &Aabb) {
        let (from, to) = (
            self.frame.start[node as usize],
            self.frame.now[node as usize],
        );
        if bounds.sides(&from) & bounds.sides(&to) != 0 {
            return;
        }
        let (distance, own) = self.obstacle.distance(&to);
        let (before, _) = self.obstacle.distance(&from);
        let travel = (to - from).norm();
        // The distance changes by no more than the displacement.
        let may_enter = before > 0.0 && before + distance < travel;
        if !(distance < self.frame.reach || may_enter) {
            return;
        }
        let side = if before > 0.0 {
            let entry = may_enter.then(|| self.entry(&from, &to)).flatten();
            entry.filter(|entry| own.dot(entry) < if distance < 0.0 { 0.5 } else { -0.5 })
        } else {
            let old = self.frame.sides.normal(&self.partner, node);
            old.try_normalize(0.0).filter(|old| own.dot(old) < 0.5)
        };
        let (gap, normal) = match side {
            Some(side) => (to.dot(&side) - self.obstacle.support(&side), side),
            None => (distance, own),
        };
        self.add(&[node], &[1.0], NONE, &normal, gap);
    }

    /// The normal where the segment between two points, of which the first is outside, enters.
    fn entry(&self, from: &Vector3<f64>, to: &Vector3<f64>) -> Option<Vector3<f64>> {
        let along = to - from;
        let travel = along.norm();
        let mut fraction = 0.0;
        for _ in 0..MARCH {
            let (distance, normal) = self.obstacle.distance(&(from + along * fraction));
            if distance <= AT_SURFACE * travel {
                return Some(normal);
            }
            fraction += distance / travel;
            let is_on_path = fraction < 1.0;
            if !is_on_path {
                return None;
            }
        }
        None
    }

    fn cuboid(&mut self, half: &Vector3<f64>, rounding: f64, features: &mut Features) {
        let inner = half.add_scalar(-rounding);
        let rotation = self.obstacle.pose.orientation;
        let faces = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| rotation * axis);
        let corner = |signs: [f64; 3]| {
            let local = Vector3::new(inner.x * signs[0], inner.y * signs[1], inner.z * signs[2]);
            self.obstacle.pose.apply(&local)
        };
        let depth = self.obstacle.half_thickness();
        let margin = (rounding + self.frame.reach).max(depth);
        const SIGNS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
        let mut edges = [([Vector3::zeros(); 2], [Vector3::zeros(); 2]); 12];
        for axis in 0..3 {
            let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
            for (side, [sj, sk]) in SIGNS.into_iter().enumerate() {
                let mut signs = [0.0; 3];
                (signs[j], signs[k]) = (sj, sk);
                let ends = [-1.0, 1.0].map(|end| {
                    signs[axis] = end;
                    corner(signs)
                });
                edges[4 * axis + side] = (ends, [faces[j] * sj, faces[k] * sk]);
            }
        }
        for (index, (ends, cone)) in edges.iter().enumerate() {
            let bounds = Aabb::of(ends).inflated(margin);
            if !bounds.overlaps(&self.body.tree.bounds) {
                continue;
            }
            features.find(&self.body.surface, &self.body.tree.triangles, &bounds);
            for &edge in &features.edges {
                self.box_edge(edge, ends, cone, rounding, index as u32);
            }
        }
        for index in 0..8u32 {
            let signs = [0, 1, 2].map(|axis| if index >> axis & 1 == 0 { -1.0 } else { 1.0 });
            let ([at], cone) = (
                [corner(signs)],
                [0, 1, 2].map(|axis| faces[axis] * signs[axis]),
            );
            let bounds = Aabb::of(&[at]).inflated(margin);
            if !bounds.overlaps(&self.body.tree.bounds) {
                continue;
            }
            features.find(&self.body.surface, &self.body.tree.triangles, &bounds);
            for &triangle in &features.triangles {
                self.box_corner(triangle, &at, &cone, rounding, 12 + index);
            }
        }
    }

    /// An edge of the surface across an edge of a box, both at their insides.
    fn box_edge(
        &mut self,
        edge: u32,
        [a, b]: &[Vector3<f64>; 2],
        cone: &[Vector3<f64>; 2],
        rounding: f64,
        feature: u32,
    ) {
        let nodes = self.body.surface.edges[edge as usize].nodes;
        let [p, q] = nodes.map(|node| self.frame.now[node as usize]);
        let (u, v) = (q - p, b - a);
        let across = u.cross(&v);
        let is_across = across.norm_squared() > PARALLEL * u.norm_squared() * v.norm_squared();
        if !is_across {
            return;
        }
        let closest = closest_segments(&p, &q, a, b);
        let (s, t) = (closest.first.t, closest.second.t);
        if !(s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) {
            return;
        }
        let across = across.normalize();
        let normal = if across.dot(&(cone[0] + cone[1])) < 0.0 {
            -across
        } else {
            across
        };
        let gap = normal.dot(&(closest.first.point - closest.second.point)) - rounding;
        let is_outward = cone.iter().all(|face| normal.dot(face) >= -CONE);
        if is_outward && gap > -self.obstacle.half_thickness() {
            self.add(&nodes, &[1.0 - s, s], feature, &normal, gap);
        }
    }

    /// A corner of a box at the inside of a face.
    fn box_corner(
        &mut self,
        triangle: u32,
        at: &Vector3<f64>,
        cone: &[Vector3<f64>; 3],
        rounding: f64,
        feature: u32,
    ) {
        let surface = &self.body.surface;
        let corners = surface.corners(self.frame.now, triangle);
        let Some(outward) = triangle_normal(&corners) else {
            return;
        };
        let gap = (at - corners[0]).dot(&outward) - rounding;
        let limit = self.obstacle.half_thickness().min(surface.mean_edge);
        let is_outward = cone.iter().all(|face| outward.dot(face) <= CONE);
        if !(is_outward && gap > -limit && gap < self.frame.reach) {
            return;
        }
        let foot = closest_on_triangle(at, &corners);
        if foot.feature() == TriangleFeature::Face {
            let nodes = surface.triangles[triangle as usize];
            self.add(&nodes, &foot.barycentric, feature, &-outward, gap);
        }
    }

    /// Edges of the surface across the side of a cylinder.
    fn cylinder(&mut self, radius: f64, half_length: f64, features: &mut Features) {
        let along = Vector3::z() * half_length;
        let [a, b] = [-along, along].map(|end| self.obstacle.pose.apply(&end));
        let bounds = Aabb::of(&[a, b]).inflated(radius + self.frame.reach);
        features.find(&self.body.surface, &self.body.tree.triangles, &bounds);
        for &edge in &features.edges {
            let nodes = self.body.surface.edges[edge as usize].nodes;
            let [p, q] = nodes.map(|node| self.frame.now[node as usize]);
            let closest = closest_segments(&p, &q, &a, &b);
            let (s, t) = (closest.first.t, closest.second.t);
            if !(s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) {
                continue;
            }
            let apart = closest.first.point - closest.second.point;
            let distance = apart.norm();
            // What is nearer to an end than to the side, or at the axis, is left to its nodes.
            let to_end = t.min(1.0 - t) * 2.0 * half_length;
            if distance > 0.0 && radius - distance < to_end {
                let normal = apart / distance;
                self.add(&nodes, &[1.0 - s, s], NONE, &normal, distance - radius);
            }
        }
    }

    fn add(
        &mut self,
        nodes: &[u32],
        weights: &[f64],
        feature: u32,
        normal: &Vector3<f64>,
        gap: f64,
    ) {
        let is_near = gap < self.frame.reach;
        if !is_near {
            return;
        }
        let mut first = [NONE; 3];
        first[..nodes.len()].copy_from_slice(nodes);
        first.sort_unstable();
        let mut all = [nodes[0]; 4];
        let mut all_weights = [0.0; 4];
        all[..nodes.len()].copy_from_slice(nodes);
        all_weights[..nodes.len()].copy_from_slice(weights);
        let (mut place, mut before) = (Vector3::zeros(), Vector3::zeros());
        for (&node, &weight) in nodes.iter().zip(weights) {
            place += self.frame.now[node as usize] * weight;
            before += self.frame.start[node as usize] * weight;
        }
        self.points.push(Point {
            key: Key {
                body: self.body.index,
                partner: self.partner,
                first,
                second: [feature, NONE],
            },
            nodes: all,
            weights: all_weights,
            first: nodes.len() as u8,
            normal: *normal,
            gap,
            start_gap: gap - normal.dot(&(place - before)),
            drift: Vector3::zeros(),
            place,
        });
    }
}
