//! One capsule against one triangle or node: depth, normal, and how much of the depth is old.

use crate::capsule_motion::CapsuleMotion;
use crate::memory::ContactMemory;
use crate::response::BodySurface;
use microsim_geometry::{Capsule, SegmentPoint, closest_segment_triangle, triangle_normal};
use nalgebra::Vector3;

/// A direction from a point that is closer to the axis than this share of the radius is noise.
const ON_AXIS: f64 = 1e-9;

/// At most this share of the mean edge length of an old overlap is undone in one step (NUMERICS 2.7).
const OVERLAP_PER_STEP: f64 = 0.2;

/// A point of the surface inside a capsule.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    /// Unit normal, from the axis towards the tissue.
    pub normal: Vector3<f64>,
    /// How far the point is inside [m], > 0.
    pub depth: f64,
    /// Distance by which the point is to be moved along the normal in this step [m], ≥ 0: the depth less the part of an old
    /// overlap that is left for later steps.
    pub distance: f64,
    /// Share of `distance` that undoes an overlap from before the step, 0..1.
    pub old_share: f64,
}

/// A triangle inside a capsule.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleTouch {
    /// The point that touches.
    pub touch: Touch,
    /// Where it is on the triangle.
    pub barycentric: [f64; 3],
}

/// The touch of triangle `nodes` with capsule `index`, for the node positions `positions` after the step.
///
/// Only the front counts: a tool above a thin layer does not touch the layer's other side.
pub(crate) fn touch_triangle(
    body: &BodySurface<'_>,
    positions: &[Vector3<f64>],
    nodes: &[u32; 3],
    index: u32,
    capsule: &CapsuleMotion,
    memory: &ContactMemory,
) -> Option<TriangleTouch> {
    let corners = nodes.map(|node| positions[node as usize]);
    if !in_reach(&corners, &capsule.end, 0.0) {
        return None;
    }
    let closest = closest_segment_triangle(&capsule.end.a, &capsule.end.b, &corners);
    let offset = closest.on_triangle.point - closest.on_segment.point;
    let radius = capsule.end.radius;
    if offset.norm_squared() >= radius * radius {
        return None;
    }
    let b = closest.on_triangle.barycentric;
    let remembered = nodes
        .iter()
        .zip(b)
        .filter_map(|(&node, b)| memory.normal(index, node).map(|normal| normal * b))
        .sum::<Vector3<f64>>()
        .try_normalize(0.0);
    let outward = triangle_normal(&corners);
    if remembered.is_none() && outward.is_some_and(|n| offset.dot(&n) > ON_AXIS * radius) {
        return None;
    }
    let direction =
        direction(offset, radius, remembered).or_else(|| outward.map(|n| (-n, offset.dot(&-n))))?;
    let start: Vector3<f64> = nodes
        .iter()
        .zip(b)
        .map(|(&node, b)| body.start[node as usize] * b)
        .sum();
    let touch = touch(body, direction, &start, &closest.on_segment, capsule);
    Some(TriangleTouch {
        touch,
        barycentric: b,
    })
}

/// The touch of `node` with capsule `index`, for its position `position` after the step.
pub(crate) fn touch_node(
    body: &BodySurface<'_>,
    position: &Vector3<f64>,
    node: u32,
    index: u32,
    capsule: &CapsuleMotion,
    memory: &ContactMemory,
) -> Option<Touch> {
    let axis_point = capsule.end.axis_point(position);
    let offset = position - axis_point.point;
    let radius = capsule.end.radius;
    if offset.norm_squared() >= radius * radius {
        return None;
    }
    let remembered = memory.normal(index, node).copied();
    let direction = direction(offset, radius, remembered)?;
    Some(touch(
        body,
        direction,
        &body.start[node as usize],
        &axis_point,
        capsule,
    ))
}

/// Whether a triangle may come within `margin` [m] of the capsule: a quick no for most. It is away when a ball around it is, or
/// when the whole axis lies further than the radius on one side of its plane.
pub(crate) fn in_reach(corners: &[Vector3<f64>; 3], capsule: &Capsule, margin: f64) -> bool {
    let reach = capsule.radius + margin;
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let (a, b) = (
        (capsule.a - corners[0]).dot(&normal),
        (capsule.b - corners[0]).dot(&normal),
    );
    let nearest = a.min(b).max(-a.max(b));
    if nearest > 0.0 && nearest * nearest > reach * reach * normal.norm_squared() {
        return false;
    }
    let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
    let ball = corners
        .iter()
        .map(|corner| (corner - centre).norm_squared())
        .fold(0.0, f64::max)
        .sqrt();
    let reach = reach + ball;
    (centre - capsule.axis_point(&centre).point).norm_squared() <= reach * reach
}

/// Unit normal and signed distance from the axis along it, for a point at `offset` from the axis: its own direction, or the
/// remembered one where that is noise or has turned round (the point crossed the axis).
fn direction(
    offset: Vector3<f64>,
    radius: f64,
    remembered: Option<Vector3<f64>>,
) -> Option<(Vector3<f64>, f64)> {
    let distance = offset.norm();
    let own = (distance > ON_AXIS * radius).then(|| offset / distance);
    match (own, remembered) {
        (Some(own), Some(old)) if own.dot(&old) < 0.0 => Some((old, offset.dot(&old))),
        (Some(own), _) => Some((own, distance)),
        (None, Some(old)) => Some((old, offset.dot(&old))),
        (None, None) => None,
    }
}

/// The touch of a point whose distance from the axis along `normal` is `along`, and which was at `start` before the step.
fn touch(
    body: &BodySurface<'_>,
    (normal, along): (Vector3<f64>, f64),
    start: &Vector3<f64>,
    axis_point: &SegmentPoint,
    capsule: &CapsuleMotion,
) -> Touch {
    let radius = capsule.end.radius;
    // How far the point was inside before the step, against the capsule as it was then.
    let start_axis = capsule.start.a + (capsule.start.b - capsule.start.a) * axis_point.t;
    let nearest = capsule.start.signed_distance(start);
    let along_start = (start - start_axis).dot(&normal) - radius;
    let old = if along_start < -radius {
        -along_start
    } else {
        -nearest
    }
    .max(0.0);
    let undone = old.min(OVERLAP_PER_STEP * body.mean_edge_length);
    let depth = radius - along;
    let distance = (depth - (old - undone)).max(0.0);
    let old_share = if distance > 0.0 {
        (undone / distance).min(1.0)
    } else {
        0.0
    };
    Touch {
        normal,
        depth,
        distance,
        old_share,
    }
}
