//! Quality of elements: radius ratio, dihedral angles, edge ratio, and their distribution over a mesh.

use crate::TetMesh;
use crate::tet_mesh::EDGES;
use microsim_geometry::signed_volume;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Number of bins of a histogram.
pub const HISTOGRAM_BINS: usize = 20;

/// Number of elements that a report names as the worst.
const WORST: usize = 10;

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
    /// The quality of the tetrahedron with `corners` \[m\]. The angles do not tell its orientation.
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

/// Counts of values in equal bins.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Lower end of the first bin; smaller values are counted in it.
    pub from: f64,
    /// Upper end of the last bin; larger values are counted in it.
    pub to: f64,
    /// Number of values in each of [`HISTOGRAM_BINS`] bins.
    pub counts: Vec<u32>,
}

/// Distribution of one measure over the elements. A percentile p is the smallest value that at least p % of the values do
/// not exceed.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    /// Smallest value.
    pub min: f64,
    /// 1st percentile.
    pub p1: f64,
    /// 5th percentile.
    pub p5: f64,
    /// Median.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
    /// 99th percentile.
    pub p99: f64,
    /// Largest value.
    pub max: f64,
    /// Counts.
    pub histogram: Histogram,
}

/// An element with its quality.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankedElement {
    /// Index of the element.
    pub element: u32,
    /// Its stable id.
    pub id: u32,
    /// Its quality.
    pub quality: ElementQuality,
}

/// Quality of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct QualityReport {
    /// Radius ratio; histogram from 0 to 1.
    pub radius_ratio: Distribution,
    /// Smallest dihedral angle of each element \[rad\]; histogram from 0 to π/2.
    pub dihedral_min: Distribution,
    /// Largest dihedral angle of each element \[rad\]; histogram from 0 to π.
    pub dihedral_max: Distribution,
    /// Edge ratio; histogram from 1 to 11.
    pub edge_ratio: Distribution,
    /// The ten elements with the smallest radius ratio, worst first.
    pub worst: Vec<RankedElement>,
}

impl QualityReport {
    /// The report on `mesh`; `None` when it has no element.
    pub fn of(mesh: &TetMesh) -> Option<Self> {
        let qualities: Vec<ElementQuality> = (0..mesh.tets.len())
            .map(|element| ElementQuality::of(&mesh.corners(element)))
            .collect();
        let distribution = |of: fn(&ElementQuality) -> f64, from: f64, to: f64| {
            Distribution::of(qualities.iter().map(of).collect(), from, to)
        };
        let mut order: Vec<usize> = (0..qualities.len()).collect();
        order.sort_by(|&i, &j| {
            qualities[i]
                .radius_ratio
                .total_cmp(&qualities[j].radius_ratio)
        });
        Some(Self {
            radius_ratio: distribution(|q| q.radius_ratio, 0.0, 1.0)?,
            dihedral_min: distribution(|q| q.dihedral_min, 0.0, PI / 2.0)?,
            dihedral_max: distribution(|q| q.dihedral_max, 0.0, PI)?,
            edge_ratio: distribution(|q| q.edge_ratio, 1.0, 11.0)?,
            worst: order
                .into_iter()
                .take(WORST)
                .map(|element| RankedElement {
                    element: element as u32,
                    id: mesh.element_ids[element],
                    quality: qualities[element],
                })
                .collect(),
        })
    }
}

impl Distribution {
    /// The distribution of `values`, counted between `from` and `to`; `None` without values.
    fn of(mut values: Vec<f64>, from: f64, to: f64) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let (&min, &max) = (values.first()?, values.last()?);
        let percentile = |p: usize| values[(values.len() * p).div_ceil(100).max(1) - 1];
        let mut counts = vec![0; HISTOGRAM_BINS];
        for value in &values {
            let bin = (value - from) / (to - from) * HISTOGRAM_BINS as f64;
            // The conversion takes everything below 0 (and NaN) to 0.
            counts[(bin as usize).min(HISTOGRAM_BINS - 1)] += 1;
        }
        Some(Self {
            min,
            p1: percentile(1),
            p5: percentile(5),
            p50: percentile(50),
            p95: percentile(95),
            p99: percentile(99),
            max,
            histogram: Histogram { from, to, counts },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Block, CellSplit};

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

    /// 100 values 1…100: percentile p is p by definition; the bins hold five each.
    #[test]
    fn percentiles_and_counts_follow_their_definition() {
        let values: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        let d = Distribution::of(values, 0.5, 100.5).unwrap();
        assert_eq!(
            [d.min, d.p1, d.p5, d.p50, d.p95, d.p99, d.max],
            [1.0, 1.0, 5.0, 50.0, 95.0, 99.0, 100.0]
        );
        assert_eq!(d.histogram.counts, vec![5; HISTOGRAM_BINS]);
        let outside = Distribution::of(vec![-1.0, 2.0], 0.0, 1.0).unwrap();
        assert_eq!(
            (outside.histogram.counts[0], outside.histogram.counts[19]),
            (1, 1)
        );
    }

    #[test]
    fn the_worst_element_of_a_mesh_is_named_with_its_id() {
        let mut mesh = Block {
            center: [0.0; 3],
            size: [1.0; 3],
            cells: [2; 3],
            split: CellSplit::Kuhn,
        }
        .mesh()
        .unwrap();
        mesh.element_ids.iter_mut().for_each(|id| *id += 1000);
        let last = mesh.tets.len() - 1;
        mesh.tets[last].swap(0, 1);
        let report = QualityReport::of(&mesh).unwrap();
        assert_eq!(
            (report.worst[0].element, report.worst[0].id),
            (last as u32, 1000 + last as u32)
        );
        assert!(report.radius_ratio.min < -0.7 && report.radius_ratio.p5 > 0.7);
        assert_eq!(report.worst.len(), 10);
        mesh.tets.clear();
        assert_eq!(QualityReport::of(&mesh), None);
    }
}
