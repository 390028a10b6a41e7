//! Least squares over rotation, translation and opening, with points whose markers are known: Gauss–Newton from the closed form for a half-open instrument.

use crate::rigid::align;
use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, UnitQuaternion, Vector3};

/// Iterations; those of a fit of millimetres to tenths of a millimetre are four.
const MOST_ITERATIONS: usize = 20;

/// A point and where it belongs in the frame of the handle: at closed + opening · motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Correspondence {
    pub closed: Vector3<f64>,
    pub motion: Vector3<f64>,
    pub point: Vector3<f64>,
}

/// A fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fitted {
    /// `device_from_handle`.
    pub rotation: Matrix3<f64>,
    pub translation: Vector3<f64>,
    /// Where it was free; may be a little beyond 0 to 1.
    pub opening: Option<f64>,
    /// Root mean square residual `[m]`.
    pub rms: f64,
    /// JᵀJ over turn (about the device's axes), translation, opening; the last row is of 1 alone where the opening was not free.
    pub information: SMatrix<f64, 7, 7>,
}

impl Fitted {
    /// Where a point of the handle is.
    pub fn place(&self, handle: Vector3<f64>) -> Vector3<f64> {
        self.rotation * handle + self.translation
    }

    pub fn quaternion(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(self.rotation))
    }

    /// How well the opening is determined: 1 over its standard error for errors of 1 m `[m]`. 0 where it was not free.
    pub fn opening_reach(&self) -> f64 {
        if self.opening.is_none() {
            return 0.0;
        }
        let pose = self.information.fixed_view::<6, 6>(0, 0).into_owned();
        let across = self.information.fixed_view::<6, 1>(0, 6).into_owned();
        let Some(inverse) = pose.try_inverse() else {
            return 0.0;
        };
        let left = self.information[(6, 6)] - (across.transpose() * inverse * across)[0];
        left.max(0.0).sqrt()
    }
}

/// Root mean square distance of points from the line that is nearest to them `[m]`.
pub(super) fn width(points: &[Vector3<f64>]) -> f64 {
    let count = points.len() as f64;
    let centre = points.iter().sum::<Vector3<f64>>() / count;
    let scatter: Matrix3<f64> = points
        .iter()
        .map(|p| (p - centre) * (p - centre).transpose())
        .sum();
    let mut values: [f64; 3] = scatter.symmetric_eigenvalues().into();
    values.sort_by(f64::total_cmp);
    ((values[0].max(0.0) + values[1].max(0.0)) / count).sqrt()
}

/// The fit to points; `opening`: where it is known, and not free. `None` where the points determine none.
pub(super) fn fit(points: &[Correspondence], opening: Option<f64>) -> Option<Fitted> {
    let mut current = opening.unwrap_or(0.5);
    let count = points.len() as f64;
    let model = |point: &Correspondence, opening: f64| point.closed + point.motion * opening;
    let centre = points
        .iter()
        .map(|p| model(p, current))
        .sum::<Vector3<f64>>()
        / count;
    let seen = points.iter().map(|p| p.point).sum::<Vector3<f64>>() / count;
    let products: Matrix3<f64> = points
        .iter()
        .map(|p| (p.point - seen) * (model(p, current) - centre).transpose())
        .sum();
    let mut rotation = align(products)?.rotation;
    let mut translation = seen - rotation * centre;
    let mut information = SMatrix::<f64, 7, 7>::zeros();
    // One more pass after the last step, for the derivative there.
    for iteration in 0..=MOST_ITERATIONS {
        information = SMatrix::zeros();
        let mut right = SVector::<f64, 7>::zeros();
        for point in points {
            let turned = rotation * model(point, current);
            let residual = point.point - turned - translation;
            let mut derivative = SMatrix::<f64, 3, 7>::zeros();
            derivative
                .fixed_view_mut::<3, 3>(0, 0)
                .copy_from(&(-turned.cross_matrix()));
            derivative
                .fixed_view_mut::<3, 3>(0, 3)
                .copy_from(&Matrix3::identity());
            if opening.is_none() {
                derivative
                    .fixed_view_mut::<3, 1>(0, 6)
                    .copy_from(&(rotation * point.motion));
            }
            information += derivative.transpose() * derivative;
            right += derivative.transpose() * residual;
        }
        if opening.is_some() {
            information[(6, 6)] = 1.0;
        }
        let step = information.cholesky()?.solve(&right);
        let turn = Vector3::new(step[0], step[1], step[2]);
        let shift = Vector3::new(step[3], step[4], step[5]);
        // Lengths of metres and turns of radians alike; below it is rounding.
        let is_rounding = step.norm() < 1e-13;
        if is_rounding || iteration == MOST_ITERATIONS {
            break;
        }
        let half = turn * 0.5;
        // The rotation whose Cayley parameters these are; its angle is that of the step to third order, and it is a rotation exactly.
        let denominator = 1.0 + half.norm_squared();
        let cross = half.cross_matrix();
        let small = Matrix3::identity() + (cross + cross * cross) * (2.0 / denominator);
        rotation = small * rotation;
        translation += shift;
        current += step[6];
        if !current.is_finite() {
            return None;
        }
    }
    let squares: f64 = points
        .iter()
        .map(|p| (p.point - rotation * model(p, current) - translation).norm_squared())
        .sum();
    let rms = (squares / count).sqrt();
    rms.is_finite().then_some(Fitted {
        rotation,
        translation,
        opening: opening.is_none().then_some(current),
        rms,
        information,
    })
}
