//! The plane nearest to where a tool went through tissue at a mark.

use super::mark_line::MarkLine;
use microsim_message::PathPoints;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// A plane has three parameters.
const PARAMETERS: f64 = 3.0;

/// A slope is known where its variance is below this square: 0.1, or 6°, of standard error.
const SLOPE_VARIANCE: f64 = 0.01;

/// Variances below this part of the largest are rounding.
const ROUNDING: f64 = 1e-9;

/// Sums over the points at which a tool crossed edges of a mesh, in the frame of a mark: from its middle, across it, along it and normal to the tissue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PathSums {
    count: f64,
    /// \[m\]
    sum: [f64; 3],
    /// \[m²\]
    products: [[f64; 3]; 3],
}

impl PathSums {
    pub fn new(points: &PathPoints, mark: &MarkLine) -> Self {
        let count = f64::from(points.count);
        let (sum, middle) = (Vector3::from(points.sum), Vector3::from(mark.middle));
        let [xx, yy, zz, xy, xz, yz] = points.products;
        let products = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let about_middle = products - sum * middle.transpose() - middle * sum.transpose()
            + middle * middle.transpose() * count;
        let (across, along) = (Vector3::from(mark.across), Vector3::from(mark.along));
        let frame = Matrix3::from_columns(&[across, along, across.cross(&along)]).transpose();
        Self {
            count,
            sum: (frame * (sum - middle * count)).into(),
            products: (frame * about_middle * frame.transpose()).into(),
        }
    }

    pub fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.sum = (Vector3::from(self.sum) + Vector3::from(other.sum)).into();
        self.products = (Matrix3::from(self.products) + Matrix3::from(other.products)).into();
    }

    /// Root mean square distance \[m\] of the mark's middle from the points along the normal of the plane nearest to all, and the angle of that plane to the mark's
    /// \[rad\]. The plane is the regression of offsets across the mark on those along it and through the tissue: as a cut of the mark runs along it,
    /// scatter is across. `None` where the points are too few, or scatter too far, for its slopes to be known to a standard error of 6°.
    pub fn plane(&self) -> Option<(f64, f64)> {
        if self.count <= PARAMETERS {
            return None;
        }
        let mean = Vector3::from(self.sum) / self.count;
        let moments = Matrix3::from(self.products) / self.count;
        let covariance = moments - mean * mean.transpose();
        let within: Matrix2<f64> = covariance.fixed_view::<2, 2>(1, 1).into();
        let mixed = Vector2::new(covariance[(0, 1)], covariance[(0, 2)]);
        let slopes = within.try_inverse()? * mixed;
        let scatter = covariance[(0, 0)] - mixed.dot(&slopes);
        // The larger variance of the two slopes, of regression.
        let least = within.symmetric_eigenvalues().min();
        let noise = scatter.max(0.0) / (self.count - PARAMETERS);
        if least <= (ROUNDING * covariance.trace()).max(noise / SLOPE_VARIANCE) {
            return None;
        }
        let normal = Vector3::new(1.0, -slopes.x, -slopes.y).normalize();
        let square = normal.dot(&(moments * normal));
        Some((square.max(0.0).sqrt(), libm::acos(normal.x.min(1.0))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mark along y, 2 mm beside the origin.
    fn mark() -> MarkLine {
        MarkLine {
            middle: [2e-3, 0.0, 0.0],
            along: [0.0, 1.0, 0.0],
            across: [1.0, 0.0, 0.0],
        }
    }

    fn sums(points: &[[f64; 3]]) -> PathSums {
        let mut all = PathSums::default();
        for &[x, y, z] in points {
            let points = PathPoints {
                count: 1,
                sum: [x, y, z],
                products: [x * x, y * y, z * z, x * y, x * z, y * z],
            };
            all.merge(&PathSums::new(&points, &mark()));
        }
        all
    }

    /// A grid of 5 × 3 points over 2 mm of the mark and 0.6 mm of thickness, at the given offset across.
    fn grid(across: impl Fn(f64, f64) -> f64) -> Vec<[f64; 3]> {
        let ys = [-1e-3, -0.5e-3, 0.0, 0.5e-3, 1e-3];
        let zs = [-0.3e-3, 0.0, 0.3e-3];
        let points = ys
            .iter()
            .flat_map(|&y| zs.map(|z| [2e-3 + across(y, z), y, z]));
        points.collect()
    }

    /// Planes beside the mark and through it, askew and as a bevel; expected are their own distance and angle. Tolerance: sums of squares of 2 mm cancel down to
    /// 0.1 mm, so 1e-16 × 400 of it; the arc cosine halves the digits near 1.
    #[test]
    fn a_plane_is_found_from_its_points() {
        for (beside, askew, bevel) in [
            (0.1e-3, 0.0, 0.0),
            (0.0, 0.75, 0.0),
            (0.0, 0.0, 0.5),
            (0.2e-3, 0.3, -0.4),
        ] {
            let points = grid(|y, z| beside + askew * y + bevel * z);
            let (distance, angle) = sums(&points).plane().expect("a plane");
            let size = libm::sqrt(1.0 + askew * askew + bevel * bevel);
            assert!((distance - beside / size).abs() < 1e-11, "{distance}");
            assert!((angle - libm::acos(1.0 / size)).abs() < 1e-7, "{angle}");
        }
    }

    /// Points on two planes 0.1 mm to either side are 0.1 mm from the mark: distances do not cancel. Where the planes are 0.2 mm to either side, as far apart as the tissue is
    /// thick, no plane is known.
    #[test]
    fn bites_on_both_sides_do_not_make_up_for_each_other() {
        let both = |beside: f64| {
            let mut points = grid(|_, _| beside);
            points.extend(grid(|_, _| -beside));
            sums(&points).plane()
        };
        let (distance, angle) = both(0.1e-3).expect("a plane");
        assert!(
            (distance - 0.1e-3).abs() < 1e-11 && angle < 1e-7,
            "{distance} {angle}"
        );
        assert!(both(0.2e-3).is_none());
    }

    /// Three points, lines along an axis and in general directions, and six points over the thickness of tissue that scatter by 20 µm.
    #[test]
    fn points_without_a_plane_give_none() {
        let plane = grid(|_, _| 0.0);
        assert!(sums(&plane[..3]).plane().is_none());
        for [x, y, z] in [
            [0.0, 1.0, 0.0],
            [0.3, 0.8, 0.5],
            [-0.2, 0.1, 0.9],
            [0.7, 0.7, 0.1],
        ] {
            let line: Vec<[f64; 3]> = (0..8)
                .map(|k| 1e-4 * f64::from(k))
                .map(|s| [2e-3 + s * x, s * y, s * z])
                .collect();
            assert!(sums(&line).plane().is_none(), "{x} {y} {z}");
        }
        let narrow = [
            [20.0, -30.0, -300.0],
            [-20.0, 30.0, -180.0],
            [-20.0, -30.0, -60.0],
            [20.0, 30.0, 60.0],
            [20.0, 30.0, 180.0],
            [-20.0, -30.0, 300.0],
        ];
        let narrow = narrow.map(|[x, y, z]| [2e-3 + 1e-6 * x, 1e-6 * y, 1e-6 * z]);
        assert!(sums(&narrow).plane().is_none());
    }
}
