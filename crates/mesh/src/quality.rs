//! Quality of elements: radius ratio, dihedral angles, edge ratio.

#[cfg(test)]
use crate::TetMesh;
use crate::tet_mesh::EDGES;
use microsim_geometry::signed_volume;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Quality of one tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementQuality {
    /// Three times the radius of the inscribed sphere over that of the circumscribed one: 1 for the regular
    /// tetrahedron, 0 for a flat one; below 0 when the element is inverted.
    pub radius_ratio: f64,
    /// Smallest of the six angles between the faces, inside \[rad\]; arccos(1/3) for the regular tetrahedron.
    pub dihedral_min: f64,
    /// Largest of the six angles between the faces, inside \[rad\].
    pub dihedral_max: f64,
    /// Longest edge over shortest; 1 for the regular tetrahedron.
    pub edge_ratio: f64,
}

impl ElementQuality {
    /// The quality of the tetrahedron with `corners` \[m\]. The angles do not depend on its orientation.
    pub fn of(corners: &[Vector3<f64>; 4]) -> Self {
        let [a, b, c, d] = corners;
        let (mut shortest, mut longest) = (f64::INFINITY, 0.0f64);
        let (mut dihedral_min, mut dihedral_max) = (PI, 0.0f64);
        for (index, [i, j]) in EDGES.into_iter().enumerate() {
            let edge = corners[j] - corners[i];
            let length = edge.norm();
            shortest = shortest.min(length);
            longest = longest.max(length);
            // The angle at the edge between the directions to the other two corners, seen along the edge:
            // |u × v| = |edge| |edge · (p × q)| and u · v = |edge|² (components of p and q across the edge).
            let [k, l] = EDGES[5 - index];
            let u = edge.cross(&(corners[k] - corners[i]));
            let v = edge.cross(&(corners[l] - corners[i]));
            let angle = libm::atan2(u.cross(&v).norm(), u.dot(&v));
            dihedral_min = dihedral_min.min(angle);
            dihedral_max = dihedral_max.max(angle);
        }

        let volume = signed_volume(a, b, c, d);
        let face = |p: &Vector3<f64>, q: &Vector3<f64>, r: &Vector3<f64>| {
            (q - p).cross(&(r - p)).norm() / 2.0
        };
        let area = face(a, b, c) + face(a, b, d) + face(a, c, d) + face(b, c, d);
        // Circumcentre relative to a, times 12 V.
        let (b, c, d) = (b - a, c - a, d - a);
        let center = c.cross(&d) * b.norm_squared()
            + d.cross(&b) * c.norm_squared()
            + b.cross(&c) * d.norm_squared();
        // r = 3V/area, R = |center|/(12 |V|): 3r/R = 108 V²/(area |center|), with the sign of V.
        let scale = area * center.norm();
        let radius_ratio = if scale > 0.0 {
            108.0 * volume * volume.abs() / scale
        } else {
            0.0
        };
        Self {
            radius_ratio,
            dihedral_min,
            dihedral_max,
            edge_ratio: longest / shortest,
        }
    }
}

/// The smallest radius ratio, and the smallest and largest dihedral angle \[rad\] of all elements of a mesh.
#[cfg(test)]
pub(crate) fn extremes(mesh: &TetMesh) -> [f64; 3] {
    let elements = 0..mesh.tets.len();
    elements.fold(
        [f64::INFINITY, f64::INFINITY, 0.0],
        |[ratio, min, max], element| {
            let quality = ElementQuality::of(&mesh.corners(element));
            [
                ratio.min(quality.radius_ratio),
                min.min(quality.dihedral_min),
                max.max(quality.dihedral_max),
            ]
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positive: (0, −2, −2) · (−2, −2, 0) × (−2, 0, −2) = (0, −2, −2) · (4, −4, −4) = 16 are six volumes.
    const REGULAR: [Vector3<f64>; 4] = [
        Vector3::new(1.0, 1.0, 1.0),
        Vector3::new(1.0, -1.0, -1.0),
        Vector3::new(-1.0, -1.0, 1.0),
        Vector3::new(-1.0, 1.0, -1.0),
    ];

    #[test]
    fn the_regular_tetrahedron_has_the_best_of_each_and_its_mirror_image_the_negative_ratio() {
        let mirrored = [REGULAR[0], REGULAR[2], REGULAR[1], REGULAR[3]];
        for (corners, sign) in [(REGULAR, 1.0), (mirrored, -1.0)] {
            let quality = ElementQuality::of(&corners.map(|p| p * 1e-3));
            assert!((quality.radius_ratio - sign).abs() < 1e-14, "{quality:?}");
            let expected = libm::acos(1.0 / 3.0);
            assert!((quality.dihedral_min - expected).abs() < 1e-14);
            assert!((quality.dihedral_max - expected).abs() < 1e-14);
            assert!((quality.edge_ratio - 1.0).abs() < 1e-14);
        }
    }

    /// Corner of a cube: r = a/(3 + √3), R = a√3/2, right angles at the three legs, arccos(1/√3) at the others.
    /// Kuhn element: angles 45°, 60°, 90°; edges 1 to √3; ratio 3r/R with V = 1/6, faces (1 + 1 + √2 + √2)/2, R = √3/2:
    /// 0.7174, the 0.72 of NUMERICS 5.
    #[test]
    fn corner_and_kuhn_elements_have_their_closed_forms() {
        let corner =
            ElementQuality::of(&[Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()]);
        let root3 = 3f64.sqrt();
        assert!((corner.radius_ratio - 6.0 / ((3.0 + root3) * root3)).abs() < 1e-14);
        assert!((corner.dihedral_min - libm::acos(1.0 / root3)).abs() < 1e-14);
        assert!((corner.dihedral_max - PI / 2.0).abs() < 1e-14);
        assert!((corner.edge_ratio - 2f64.sqrt()).abs() < 1e-14);

        let kuhn = ElementQuality::of(&[
            Vector3::zeros(),
            Vector3::x(),
            Vector3::new(1.0, 1.0, 0.0),
            Vector3::repeat(1.0),
        ]);
        let expected = 3.0 * (3.0 / 6.0 / (1.0 + 2f64.sqrt())) / (root3 / 2.0);
        assert!((kuhn.radius_ratio - expected).abs() < 1e-14 && (expected - 0.7174).abs() < 1e-4);
        assert!((kuhn.dihedral_min - PI / 4.0).abs() < 1e-14);
        assert!((kuhn.dihedral_max - PI / 2.0).abs() < 1e-14);
        assert!((kuhn.edge_ratio - root3).abs() < 1e-14);
    }

    #[test]
    fn a_flat_element_has_ratio_zero_and_angles_of_0_and_180_degrees() {
        let quality = ElementQuality::of(&[
            Vector3::zeros(),
            Vector3::x(),
            Vector3::new(1.0, 1.0, 0.0),
            Vector3::y(),
        ]);
        assert_eq!(quality.radius_ratio, 0.0);
        assert_eq!((quality.dihedral_min, quality.dihedral_max), (0.0, PI));
    }
}
