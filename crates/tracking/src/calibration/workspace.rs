//! Workspace registration: where the frame of a device lies, from points whose places in the field are known and which the tip of an instrument has touched.
//!
//! # Solution
//! The rotation R, scale s and translation b that minimise Σ|s R p_i + b − f_i|² (Umeyama 1991, IEEE Trans. Pattern Anal. 13:376; without scale
//! Arun et al. 1987 and Horn 1987): of the singular value decomposition U D Vᵀ of Σ f′ p′ᵀ, centred, R = U diag(1, 1, ±1) Vᵀ, never a mirror image.
//!
//! # Errors
//! With N points, FLE the root mean square error of a touched point in three dimensions (√3 σ) and FRE the root mean square residual, Fitzpatrick, West & Maurer (1998,
//! IEEE Trans. Med. Imaging 17:694) have ⟨FRE²⟩ = (1 − 2/N) ⟨FLE²⟩, which is 3N − 6 degrees of freedom, and for the error of a target at r
//! ⟨TRE²⟩ = ⟨FLE²⟩/N (1 + ⅓ Σ_k d_k²/f_k²), where d_k and f_k are the distances of the target and, in the root mean square, of the points from principal axis k. A free
//! scale takes one more degree of freedom and adds σ² |r|²/Σ|p_i|², its variance.

use crate::rigid::align;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use std::error::Error;
use std::fmt;

/// How far off a line points have to be, in the root mean square, over how far they are apart along it: less and a turn about the line is hardly determined.
pub const LEAST_WIDTH: f64 = 0.1;

/// A point in both frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// As the device has it `[m]`.
    pub device: [f64; 3],
    /// Where it is in the field `[m]`.
    pub field: [f64; 3],
}

/// Where the frame of a device lies: field point = scale · rotation (device point) + translation.
#[derive(Clone, Debug, PartialEq)]
pub struct Registration {
    /// `field_from_device`, unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
    /// `[m]`
    pub translation: [f64; 3],
    /// Length in the field per length of the device; 1 where it was not free.
    pub scale: f64,
    /// Distance of each mapped point from where it should be `[m]`.
    pub residuals: Vec<f64>,
    /// Root mean square of them, FRE `[m]`.
    pub rms: f64,
    /// Estimated standard deviation of one coordinate of a touched point, in lengths of the field `[m]`.
    pub sigma: f64,
    /// Mean of the points in the field `[m]`.
    centre: Vector3<f64>,
    /// Inverse of Σ (|x|² 1 − x xᵀ) of the mapped points about their mean: covariance of the rotation over σ² `[1/m²]`.
    turning: Matrix3<f64>,
    /// Variance of the scale over σ² `[1/m²]`; 0 where it was not free.
    scaling: f64,
    count: f64,
}

/// Why there is no result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RegistrationError {
    /// This many points.
    TooFew(usize),
    /// A coordinate of the point of this index is not finite.
    NotFinite(usize),
    /// The points lie on a line, or nearly: their width over their length.
    Line(f64),
    /// They fit better to a mirror image: a point or axis was mixed up, or an axis has the wrong sign.
    Mirrored,
}

impl fmt::Display for RegistrationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew(found) => write!(
                f,
                "expected at least 4 points, so that there is a residual that means something, found {found}"
            ),
            Self::NotFinite(index) => {
                write!(f, "a coordinate of point {} is not finite", index + 1)
            }
            Self::Line(width) => write!(
                f,
                "the points lie nearly on a line (width {width:.2} of their length, expected at least {LEAST_WIDTH}); touch one beside it"
            ),
            Self::Mirrored => write!(
                f,
                "the points fit a mirror image better than a rotation; were two points mixed up, or is an axis of the list turned round?"
            ),
        }
    }
}

impl Error for RegistrationError {}

impl Registration {
    /// A point of the device, in the field `[m]`.
    pub fn apply(&self, device: [f64; 3]) -> [f64; 3] {
        let turned = Vector3::from(crate::rotation::rotated(self.rotation, device));
        (turned * self.scale + Vector3::from(self.translation)).into()
    }

    /// Expected error of a point of the field, √⟨TRE²⟩ for the estimated σ `[m]`.
    pub fn target_error(&self, field: [f64; 3]) -> f64 {
        self.sigma * self.target_cofactor(field).sqrt()
    }

    /// ⟨TRE²⟩ over σ².
    pub(crate) fn target_cofactor(&self, field: [f64; 3]) -> f64 {
        let from_centre = Vector3::from(field) - self.centre;
        let cross = from_centre.cross_matrix();
        let turned = (cross * self.turning * cross.transpose()).trace();
        3.0 / self.count + turned + self.scaling * from_centre.norm_squared()
    }

    /// The largest residual `[m]`.
    pub fn worst(&self) -> f64 {
        self.residuals.iter().copied().fold(0.0, f64::max)
    }
}

/// The registration of pairs of points; `with_scale`: the scale is free, otherwise it is 1.
///
/// # Errors
/// [`RegistrationError`] if the points do not determine it.
pub fn register(pairs: &[Pair], with_scale: bool) -> Result<Registration, RegistrationError> {
    if pairs.len() < 4 {
        return Err(RegistrationError::TooFew(pairs.len()));
    }
    let is_finite = |pair: &Pair| pair.device.iter().chain(&pair.field).all(|x| x.is_finite());
    if let Some(index) = pairs.iter().position(|pair| !is_finite(pair)) {
        return Err(RegistrationError::NotFinite(index));
    }
    let count = pairs.len() as f64;
    let device: Vec<Vector3<f64>> = pairs.iter().map(|pair| pair.device.into()).collect();
    let field: Vec<Vector3<f64>> = pairs.iter().map(|pair| pair.field.into()).collect();
    let [device_centre, field_centre] =
        [&device, &field].map(|points| points.iter().sum::<Vector3<f64>>() / count);
    let device: Vec<_> = device.iter().map(|point| point - device_centre).collect();
    let field_off: Vec<_> = field.iter().map(|point| point - field_centre).collect();
    for points in [&device, &field_off] {
        let width = width(points);
        if width.is_nan() || width < LEAST_WIDTH {
            return Err(RegistrationError::Line(if width.is_nan() {
                0.0
            } else {
                width
            }));
        }
    }
    let mut products = Matrix3::zeros();
    for (from, to) in device.iter().zip(&field_off) {
        products += to * from.transpose();
    }
    let aligned = align(products).ok_or(RegistrationError::Line(0.0))?;
    let [largest, _, smallest] = aligned.values;
    // Points in a plane have their own mirror image, which is a rotation as well.
    if smallest < -0.05 * largest {
        return Err(RegistrationError::Mirrored);
    }
    let rotation = aligned.rotation;
    let spread: f64 = device.iter().map(Vector3::norm_squared).sum();
    let scale = match with_scale {
        true => aligned.values.iter().sum::<f64>() / spread,
        false => 1.0,
    };
    let translation = field_centre - scale * (rotation * device_centre);
    let mapped: Vec<_> = device
        .iter()
        .map(|point| scale * (rotation * point))
        .collect();
    let residuals: Vec<f64> = mapped
        .iter()
        .zip(&field_off)
        .map(|(found, expected)| (found - expected).norm())
        .collect();
    let squares: f64 = residuals.iter().map(|r| r * r).sum();
    let unknowns = if with_scale { 7.0 } else { 6.0 };
    let mut inertia = Matrix3::zeros();
    for point in &mapped {
        inertia += Matrix3::from_diagonal_element(point.norm_squared()) - point * point.transpose();
    }
    let quaternion =
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    Ok(Registration {
        rotation: quaternion.coords.into(),
        translation: translation.into(),
        scale,
        rms: (squares / count).sqrt(),
        sigma: (squares / (3.0 * count - unknowns)).sqrt(),
        residuals,
        centre: field_centre,
        turning: inertia.try_inverse().ok_or(RegistrationError::Line(0.0))?,
        scaling: match with_scale {
            true => 1.0 / (scale * scale * spread),
            false => 0.0,
        },
        count,
    })
}

/// Extent of centred points across their longest direction over that along it: of the second to the first singular value. 0/0 of points that are one.
fn width(points: &[Vector3<f64>]) -> f64 {
    let mut scatter = Matrix3::zeros();
    for point in points {
        scatter += point * point.transpose();
    }
    let mut values: [f64; 3] = scatter.symmetric_eigenvalues().into();
    values.sort_by(f64::total_cmp);
    (values[1].max(0.0) / values[2]).sqrt()
}
