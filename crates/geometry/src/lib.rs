//! Pure geometry: closest points between points, segments and triangles, capsules, boxes, poses; what contact asks of it, from
//! pairs of boxes that overlap ([`BroadPhase`]) over the features of these pairs to the first contact of moving ones.
//!
//! What is here: free functions and small value types on `f64` coordinates \[m\]. What is not: meshes, time, physics,
//! files. Nothing here can fail: degenerate input (a segment of length zero, a triangle without area) gives the closest
//! point of what is left of the feature. Every tolerance is a ratio, so all results scale with the input. What is decided (which
//! side, through or not) is decided without rounding ([`orientation`]); what is measured is rounded in its last digits. Of the broad phases
//! contact uses [`Bvh`] unless a scene names another one: [`SpatialHash`] costs as much or more in what was measured (`cargo run --example broad_phase`), and is better only where
//! everything is new in every step.

#![forbid(unsafe_code)]

mod aabb;
mod all_pairs;
mod broad_phase;
mod bvh;
mod capsule;
#[cfg(test)]
mod closest_tests;
mod crossing;
mod first_contact;
mod joint;
mod orientation;
mod pose;
mod segment;
mod spatial_hash;
#[cfg(test)]
mod testing;
mod tetrahedron;
mod triangle;

pub use aabb::Aabb;
pub use all_pairs::AllPairs;
pub use broad_phase::BroadPhase;
pub use bvh::Bvh;
pub use capsule::Capsule;
pub use crossing::{EdgeCrossing, closest_segment_triangle, edge_through_triangle};
pub use first_contact::{
    CONTACT_TOLERANCE, FirstContact, Motion, first_contact_edges, first_contact_point_triangle,
    first_contact_segment_triangle,
};
pub use joint::{Hinge, Joint, JointBounds};
pub use orientation::orientation;
pub use pose::Pose;
pub use segment::{SegmentPoint, SegmentsClosest, closest_on_segment, closest_segments};
pub use spatial_hash::SpatialHash;
pub use tetrahedron::{INSIDE_TOLERANCE, point_in_tetrahedron};
pub use triangle::{
    SegmentTriangle, TriangleFeature, TrianglePoint, closest_on_triangle, triangle_normal,
};

use nalgebra::Vector3;

/// Signed volume of the tetrahedron `(a, b, c, d)` \[m³\]; positive when it is right-handed (NUMERICS, notation).
#[inline]
pub fn signed_volume(
    a: &Vector3<f64>,
    b: &Vector3<f64>,
    c: &Vector3<f64>,
    d: &Vector3<f64>,
) -> f64 {
    (b - a).dot(&(c - a).cross(&(d - a))) / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volume_of_the_unit_corner_is_one_sixth_and_swapping_two_nodes_flips_its_sign() {
        let (o, x, y, z) = (Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z());
        assert_eq!(signed_volume(&o, &x, &y, &z), 1.0 / 6.0);
        assert_eq!(signed_volume(&o, &y, &x, &z), -1.0 / 6.0);
    }
}
