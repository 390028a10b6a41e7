//! The end-plane rule for the ends of two vessels that lie opposite to one another (dissertation 4.3, NUMERICS 6).
//!
//! The wall of a vessel is one or few layers of tetrahedra: the exit of a node that is deep in the other vessel's end may lead into
//! the lumen, and the ends come to lie in one another. In a clamp they can only meet end to end; so the nodes of edges that collide
//! there are brought before the plane of the other end.

use crate::body::Body;
use crate::body_pair::BodyPair;
use crate::frame::Frame;
use crate::near::Near;
use crate::pair::VesselEnd;
use crate::point::Point;
use microsim_geometry::{TrianglePoint, closest_on_triangle, edge_through_triangle};
use nalgebra::Vector3;

/// How far beyond the ring a node may be, and how deep behind the plane, in mean edge lengths: half a cell, and one layer.
const BESIDE: f64 = 0.5;
const DEEPEST: f64 = 1.0;

/// The plane of an end at one time.
pub(crate) struct EndPlane<'a> {
    end: &'a VesselEnd,
    centre: Vector3<f64>,
    normal: Vector3<f64>,
    radius: f64,
    deepest: f64,
}

impl<'a> EndPlane<'a> {
    /// Through the mean of the end's nodes, across the mean of its normals. `None` of an end without area.
    pub fn new(end: &'a VesselEnd, body: &Body, now: &[Vector3<f64>]) -> Option<Self> {
        let (mut centre, mut normal, mut area) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for nodes in &end.triangles {
            let [a, b, c] = nodes.map(|node| now[node as usize]);
            let cross = (b - a).cross(&(c - a));
            // Weighted by areas the mean does not depend on how the end is divided.
            centre += (a + b + c) * (cross.norm() / 3.0);
            area += cross.norm();
            normal += cross;
        }
        let normal = normal.try_normalize(0.0)?;
        let centre = centre / area;
        let nodes = end.triangles.iter().flatten();
        let radius = nodes
            .map(|&node| (now[node as usize] - centre).norm())
            .fold(0.0, f64::max);
        Some(Self {
            end,
            centre,
            normal,
            radius: radius + BESIDE * body.surface.mean_edge,
            deepest: DEEPEST * body.surface.mean_edge,
        })
    }

    /// How deep a node is behind the plane, if the rule is for it.
    fn depth(&self, p: &Vector3<f64>) -> Option<f64> {
        let offset = self.centre - p;
        let depth = offset.dot(&self.normal);
        let beside = (offset - self.normal * depth).norm();
        (depth > 0.0 && depth < self.deepest && beside < self.radius).then_some(depth)
    }

    /// The place of the end that is nearest to a node.
    fn nearest(&self, p: &Vector3<f64>, now: &[Vector3<f64>]) -> Option<([u32; 3], TrianglePoint)> {
        let places = self.end.triangles.iter().map(|nodes| {
            let corners = nodes.map(|node| now[node as usize]);
            (*nodes, closest_on_triangle(p, &corners))
        });
        let distance = |at: &TrianglePoint| (at.point - p).norm_squared();
        places.min_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1)))
    }
}

impl BodyPair<'_> {
    /// Adds the points of the nodes `inside` (ascending) and of edges that cross the other surface with the plane of the other body's end;
    /// replaces `caught` by these nodes, ascending.
    pub fn at_end(
        &self,
        end: &VesselEnd,
        inside: impl Iterator<Item = u32>,
        near: &Near,
        caught: &mut Vec<u32>,
        points: &mut Vec<Point>,
    ) {
        let Frame { now, .. } = self.frame;
        caught.clear();
        let Some(plane) = EndPlane::new(end, self.second, now) else {
            return;
        };
        caught.extend(inside);
        for &[edge, triangle] in &near.edge_triangles {
            let nodes = self.first.surface.edges[edge as usize].nodes;
            let [p, q] = nodes.map(|node| now[node as usize]);
            let corners = self.second.surface.corners(now, triangle);
            let face = self
                .second
                .normals
                .face(&self.second.surface, now, triangle);
            if !face.on_one_side(&[p - corners[0], q - corners[0]])
                && edge_through_triangle(&p, &q, &corners).is_some()
            {
                caught.extend(nodes);
            }
        }
        caught.sort_unstable();
        caught.dedup();
        caught.retain(|&node| {
            let p = &now[node as usize];
            let found = plane.depth(p).zip(plane.nearest(p, now));
            if let Some((depth, (nodes, at))) = &found {
                self.add(node, nodes, at, &plane.normal, -depth, points);
            }
            found.is_some()
        });
    }
}
