//! A closed line in space and the plane nearest to it: the rim of a vessel's end.

use nalgebra::{Matrix3, Vector3};

/// What is measured of a closed line of straight edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rim {
    /// Its length \[m\].
    pub circumference: f64,
    /// Length of a thread drawn tight around it, seen along the normal of its plane \[m\]: of an even rim the circumference, which notches and shreds make longer and the thread
    /// does not follow.
    pub girth: f64,
    /// Area that it surrounds, seen along the normal of its plane \[m²\].
    pub area: f64,
    /// Its centroid, through which its plane goes \[m\].
    pub centre: [f64; 3],
    /// Normal of the plane with the least mean square distance over its length, of length 1; its sense is that in which the line runs counter-clockwise.
    pub normal: [f64; 3],
    /// Distance of the line from its plane, root mean square over its length \[m\].
    pub unevenness: f64,
    /// Largest distance of the line from its plane \[m\].
    pub farthest: f64,
}

impl Rim {
    /// Of its corners in order \[m\]. `None` of a line without length or area.
    pub fn of(corners: &[[f64; 3]]) -> Option<Self> {
        let corners: Vec<Vector3<f64>> = corners.iter().map(|p| Vector3::from(*p)).collect();
        let edges = || corners.iter().zip(corners.iter().cycle().skip(1));
        let circumference: f64 = edges().map(|(a, b)| (b - a).norm()).sum();
        if circumference <= 0.0 {
            return None;
        }
        let moments = edges().map(|(a, b)| (a + b) * (0.5 * (b - a).norm()));
        let centre = moments.sum::<Vector3<f64>>() / circumference;
        // ∫ x xᵀ ds of an edge from a to b is its length times (a aᵀ + b bᵀ + (a + b)(a + b)ᵀ)/6.
        let squares = edges().map(|(a, b)| {
            let (p, q) = (a - centre, b - centre);
            let sum = p + q;
            let square = p * p.transpose() + q * q.transpose() + sum * sum.transpose();
            square * ((b - a).norm() / 6.0)
        });
        let spread = squares.sum::<Matrix3<f64>>() / circumference;
        let eigen = spread.symmetric_eigen();
        let least = eigen.eigenvalues.imin();
        let across: Vector3<f64> = eigen.eigenvectors.column(least).into();
        let areas = edges().map(|(a, b)| (a - centre).cross(&(b - centre)) * 0.5);
        let signed = areas.sum::<Vector3<f64>>().dot(&across);
        if signed == 0.0 {
            return None;
        }
        let normal = across * signed.signum();
        let away = corners.iter().map(|p| (p - centre).dot(&normal).abs());
        let [u, v] = across_to(&normal);
        let flat = corners.iter().map(|p| [p.dot(&u), p.dot(&v)]);
        Some(Self {
            circumference,
            girth: hull_length(flat.collect()),
            area: signed.abs(),
            centre: centre.into(),
            normal: normal.into(),
            unevenness: normal.dot(&(spread * normal)).max(0.0).sqrt(),
            farthest: away.fold(0.0, f64::max),
        })
    }

    /// Angle between the normal of its plane and a direction of length 1 \[rad\], at most a right angle: of a vessel's axis, 0 if the end is straight.
    pub fn angle_to(&self, direction: [f64; 3]) -> f64 {
        let (normal, direction) = (Vector3::from(self.normal), Vector3::from(direction));
        // An arc cosine loses half of the digits near 1.
        let (sine, cosine) = (
            normal.cross(&direction).norm(),
            normal.dot(&direction).abs(),
        );
        libm::atan2(sine, cosine)
    }
}

/// Two directions across a normal and each other, of length 1.
fn across_to(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let least = Vector3::ith(normal.iamin(), 1.0);
    let u = normal.cross(&least).normalize();
    [u, normal.cross(&u)]
}

/// Length of the convex hull of points in a plane, by Andrew's monotone chains (1979).
fn hull_length(mut points: Vec<[f64; 2]>) -> f64 {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let chain = |points: &mut dyn Iterator<Item = &[f64; 2]>| {
        let mut hull: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., a, b] = hull[..] {
                let turn = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
                if turn > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(*p);
        }
        let edges = hull.windows(2);
        let lengths =
            edges.map(|edge| libm::hypot(edge[1][0] - edge[0][0], edge[1][1] - edge[0][1]));
        lengths.sum::<f64>()
    };
    chain(&mut points.iter()) + chain(&mut points.iter().rev())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Vector2};
    use std::f64::consts::PI;

    /// The place of a plane figure in space.
    fn placed(flat: &[Vector2<f64>], height: impl Fn(usize) -> f64) -> Vec<[f64; 3]> {
        let turn = Rotation3::new(Vector3::new(0.4, -0.9, 1.3));
        let shift = Vector3::new(2.0, -1.0, 0.5);
        let places = flat.iter().enumerate();
        let places = places.map(|(k, p)| turn * Vector3::new(p.x, p.y, height(k)) + shift);
        places.map(Into::into).collect()
    }

    fn normal() -> Vector3<f64> {
        Rotation3::new(Vector3::new(0.4, -0.9, 1.3)) * Vector3::z()
    }

    /// Stars of 3 to 40 corners at uneven radii and angles, of which some are not convex: length by their edges, area by the shoelace formula, both in the plane.
    #[test]
    fn polygons_have_their_length_area_and_plane() {
        let part = |k: usize| (k as f64 * 0.618_033_988_749_895).fract();
        for corners in 3..=40 {
            let flat: Vec<Vector2<f64>> = (0..corners)
                .map(|k| {
                    let angle =
                        2.0 * PI * (k as f64 + 0.8 * part(7 * k + corners)) / corners as f64;
                    let radius = 0.4 + part(3 * k + corners);
                    Vector2::new(radius * libm::cos(angle), radius * libm::sin(angle))
                })
                .collect();
            let edges = || (0..corners).map(|k| (flat[k], flat[(k + 1) % corners]));
            let length: f64 = edges().map(|(a, b)| (b - a).norm()).sum();
            let area: f64 = edges().map(|(a, b)| 0.5 * (a.x * b.y - a.y * b.x)).sum();
            let rim = Rim::of(&placed(&flat, |_| 0.0)).expect("a line");
            assert!((rim.circumference - length).abs() < 1e-12 * length);
            assert!((rim.area - area).abs() < 1e-12, "{} {area}", rim.area);
            assert!(rim.farthest < 1e-12 && rim.unevenness < 1e-7, "{rim:?}");
            assert!((Vector3::from(rim.normal) - normal()).norm() < 1e-7);
        }
    }

    /// A square whose corners lie alternately h above and below its plane: along each edge the height falls linearly from h to −h, its mean square is h²/3.
    #[test]
    fn a_saddle_is_uneven() {
        let square = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(Vector2::from);
        let h = 0.1;
        let saddle = placed(&square, |k| if k % 2 == 0 { h } else { -h });
        let rim = Rim::of(&saddle).expect("a line");
        assert!((rim.farthest - h).abs() < 1e-14, "{}", rim.farthest);
        assert!(
            (rim.unevenness - h / 3f64.sqrt()).abs() < 1e-14,
            "{}",
            rim.unevenness
        );
        assert!((rim.circumference - 8.0 * (1.0 + h * h).sqrt()).abs() < 1e-14);
        assert!((rim.area - 4.0).abs() < 1e-14);
        assert!(rim.angle_to(normal().into()) < 1e-14);
    }

    /// A regular star of n points between two radii: the thread goes from tip to tip, 2 n R sin(π/n), as long as the notches lie within R cos(π/n); its edges are 2 n times
    /// the distance of a tip from a notch. A regular polygon is its own hull.
    #[test]
    fn a_thread_around_a_rim_passes_its_notches() {
        for (n, ratio) in [(5, 0.3), (12, 0.8), (7, 1.0)] {
            let around = f64::from(2 * n);
            let flat: Vec<Vector2<f64>> = (0..2 * n)
                .map(|k| {
                    let angle = 2.0 * PI * f64::from(k) / around;
                    let radius = if k % 2 == 0 { 1.0 } else { ratio };
                    Vector2::new(radius * libm::cos(angle), radius * libm::sin(angle))
                })
                .collect();
            let rim = Rim::of(&placed(&flat, |_| 0.0)).expect("a line");
            let side = (1.0 + ratio * ratio - 2.0 * ratio * libm::cos(2.0 * PI / around)).sqrt();
            let corners = if ratio < 1.0 { f64::from(n) } else { around };
            let girth = 2.0 * corners * libm::sin(PI / corners);
            assert!((rim.circumference - around * side).abs() < 1e-12, "{rim:?}");
            assert!((rim.girth - girth).abs() < 1e-12, "{} {girth}", rim.girth);
        }
    }

    #[test]
    fn lines_without_length_or_area_have_no_rim() {
        assert!(Rim::of(&[]).is_none());
        assert!(Rim::of(&[[1.0; 3]; 4]).is_none());
        assert!(Rim::of(&[[0.0; 3], [1.0, 0.0, 0.0]]).is_none());
    }
}
