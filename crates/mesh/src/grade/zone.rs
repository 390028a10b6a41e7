//! Parts of space, and of a mesh, in which elements are to be small.

use crate::TetMesh;
use crate::tet_mesh::FACES;
use microsim_geometry::{closest_on_triangle, closest_segment_triangle, point_in_tetrahedron};
use nalgebra::Vector3;

/// A part of space or of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Zone {
    /// All that is no farther from a point than a radius.
    Ball {
        /// The point \[m\].
        center: [f64; 3],
        /// The radius \[m\], > 0.
        radius: f64,
    },
    /// All that is no farther from a segment than a radius.
    Capsule {
        /// The ends of the segment \[m\].
        ends: [[f64; 3]; 2],
        /// The radius \[m\], > 0.
        radius: f64,
    },
    /// All that is no farther from a plane than a distance, on either side.
    Slab {
        /// A point of the plane \[m\].
        point: [f64; 3],
        /// Normal of the plane, of any length but 0.
        normal: [f64; 3],
        /// The distance \[m\], > 0.
        distance: f64,
    },
    /// The elements of a region.
    Region(u32),
}

impl Zone {
    /// What is wrong with it for `mesh`, in words; `None` if nothing is.
    pub(super) fn fault(&self, mesh: &TetMesh) -> Option<String> {
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        let distance = |name: &str, value: f64| {
            let good = value.is_finite() && value > 0.0;
            (!good).then(|| format!("a {name} of {value:?} m; expected one above 0 m"))
        };
        let places = |places: &[[f64; 3]]| {
            let bad = places.iter().find(|place| !finite(&place[..]));
            bad.map(|place| format!("the place {place:?} m; expected finite coordinates"))
        };
        match self {
            Self::Ball { center, radius } => {
                places(&[*center]).or_else(|| distance("radius", *radius))
            }
            Self::Capsule { ends, radius } => places(ends).or_else(|| distance("radius", *radius)),
            Self::Slab {
                point,
                normal,
                distance: across,
            } => places(&[*point])
                .or_else(|| {
                    let length = Vector3::from(*normal).norm();
                    let good = length.is_finite() && length > 0.0;
                    (!good).then(|| {
                        format!(
                            "the normal {normal:?}; expected a direction of finite length above 0"
                        )
                    })
                })
                .or_else(|| distance("distance", *across)),
            Self::Region(region) => {
                let mut there = mesh.regions.clone();
                there.sort_unstable();
                there.dedup();
                (there.binary_search(region).is_err()).then(|| {
                    format!(
                        "region {region}, which the mesh does not have; expected one of {there:?}"
                    )
                })
            }
        }
    }

    /// Whether a tetrahedron of a region reaches into it; its boundary belongs to it.
    pub(super) fn meets(&self, corners: &[Vector3<f64>; 4], region: u32) -> bool {
        let faces = || FACES.map(|face| face.map(|corner| corners[corner]));
        match self {
            Self::Region(own) => *own == region,
            Self::Slab {
                point,
                normal,
                distance,
            } => {
                let normal = Vector3::from(*normal);
                let normal = normal / normal.norm();
                let heights = corners.map(|p| (p - Vector3::from(*point)).dot(&normal));
                let [low, high] = [
                    heights.into_iter().fold(f64::INFINITY, f64::min),
                    heights.into_iter().fold(f64::NEG_INFINITY, f64::max),
                ];
                low <= *distance && high >= -distance
            }
            Self::Ball { center, radius } => {
                let center = Vector3::from(*center);
                point_in_tetrahedron(&center, corners).is_some()
                    || faces().iter().any(|face| {
                        (closest_on_triangle(&center, face).point - center).norm() <= *radius
                    })
            }
            Self::Capsule { ends, radius } => {
                let [a, b] = ends.map(Vector3::from);
                point_in_tetrahedron(&a, corners).is_some()
                    || faces()
                        .iter()
                        .any(|face| closest_segment_triangle(&a, &b, face).distance() <= *radius)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNER: [Vector3<f64>; 4] = [
        Vector3::new(0.0, 0.0, 0.0),
        Vector3::new(1.0, 0.0, 0.0),
        Vector3::new(0.0, 1.0, 0.0),
        Vector3::new(0.0, 0.0, 1.0),
    ];

    /// The slanted face x + y + z = 1 is nearest to (1, 1, 1) at (1/3, 1/3, 1/3): 2/√3 away.
    #[test]
    fn a_ball_meets_what_it_reaches_and_what_it_lies_in() {
        let meets = |center, radius| Zone::Ball { center, radius }.meets(&CORNER, 0);
        let reach = 2.0 / 3f64.sqrt();
        assert!(meets([1.0; 3], reach * (1.0 + 1e-12)));
        assert!(!meets([1.0; 3], reach * (1.0 - 1e-12)));
        assert!(meets([0.1; 3], 1e-9), "inside, far from all faces");
        assert!(meets([-0.5, 0.2, 0.2], 0.5), "its boundary belongs to it");
        assert!(!meets([-0.5, 0.2, 0.2], 0.499_999));
    }

    /// Through it without an end in it; inside; beside it: the line x = y = 1 in z is 1/√2 away from the edge from (1, 0, 0) to (0, 1, 0).
    #[test]
    fn a_capsule_meets_what_its_axis_crosses_or_comes_near() {
        let meets = |ends, radius| Zone::Capsule { ends, radius }.meets(&CORNER, 0);
        assert!(meets([[0.2, 0.2, -1.0], [0.2, 0.2, 1.0]], 1e-9));
        assert!(meets([[0.1; 3], [0.2, 0.1, 0.1]], 1e-9));
        let (beside, reach) = ([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0]], 0.5f64.sqrt());
        assert!(meets(beside, reach * (1.0 + 1e-12)));
        assert!(!meets(beside, reach * (1.0 - 1e-12)));
    }

    #[test]
    fn a_slab_meets_what_lies_on_both_sides_or_comes_near_and_a_region_its_own() {
        let meets = |z, distance| {
            let slab = Zone::Slab {
                point: [7.0, -3.0, z],
                normal: [0.0, 0.0, -2.0],
                distance,
            };
            slab.meets(&CORNER, 0)
        };
        assert!(meets(0.5, 1e-9));
        assert!(meets(1.5, 0.5));
        assert!(!meets(1.5, 0.499_999));
        assert!(!meets(-0.25, 0.2));
        assert!(Zone::Region(3).meets(&CORNER, 3));
        assert!(!Zone::Region(3).meets(&CORNER, 4));
    }
}
