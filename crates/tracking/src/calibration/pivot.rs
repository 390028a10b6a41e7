//! Pivot calibration: while the tip stands in a dimple, the handle is turned to all sides. Of every pose, with position p, orientation R and the unknown
//! tip t in the handle's frame, R t + p is the same point c.
//!
//! # Solution
//! Eliminating c from the sum of squares of R_i t + p_i − c leaves, with A_i = R_i − R̄ and d_i = p_i − p̄ (bars are means),
//!
//! ```text
//! S t = −Σ A_iᵀ d_i,   S = Σ A_iᵀ A_i = n (1 − R̄ᵀ R̄)
//! ```
//!
//! The covariance of t is σ² S⁻¹. A direction e of the handle that is turned little has a mean R̄ e of nearly length 1, so that S is nearly singular along it:
//! the angle whose cosine is the largest |R̄ e| is the spread of the poses, and the standard error along that e is σ / (√n sin spread).

use crate::QuaternionError;
use crate::rotation::checked_unit;
use microsim_message::Pose;
use nalgebra::{Matrix3, Quaternion, Unit, UnitQuaternion, Vector3};
use std::error::Error;
use std::fmt;

/// Fewest poses: with fewer the residual is no estimate of σ.
pub const LEAST_POSES: usize = 20;

/// Least spread of the poses `[rad]`, 10°: the standard error of the tip along the worst direction is then 5.8 σ/√n.
pub const LEAST_SPREAD: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// What a pivot calibration gives.
#[derive(Clone, Debug, PartialEq)]
pub struct Pivot {
    /// The tip in the frame of the handle `[m]`.
    pub tip: [f64; 3],
    /// The point about which the instrument was turned, in the frame of the device `[m]`.
    pub centre: [f64; 3],
    /// By how far the tip of each pose is off that point `[m]`.
    pub residuals: Vec<f64>,
    /// Root mean square of them `[m]`.
    pub rms: f64,
    /// Estimated standard deviation of one coordinate of a position `[m]`.
    pub sigma: f64,
    /// Spread of the poses, 0 to π/2 `[rad]`.
    pub spread: f64,
    /// Covariance of the tip over σ²: S⁻¹.
    pub cofactor: [[f64; 3]; 3],
}

/// Why there is no result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PivotError {
    /// This many poses.
    TooFew(usize),
    /// The pose of this index has a position that is not finite.
    NotFinite(usize),
    /// The pose of this index has no orientation.
    Orientation(usize, QuaternionError),
    /// The poses differ by too little.
    TooLittleRotation {
        /// Their spread `[rad]`.
        spread: f64,
        /// The direction in the frame of the handle, of length 1, that was turned least.
        direction: [f64; 3],
    },
}

impl fmt::Display for PivotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew(found) => write!(
                f,
                "expected at least {LEAST_POSES} poses in which the instrument is seen, found {found}; turn it for longer"
            ),
            Self::NotFinite(index) => write!(f, "the position of pose {index} is not finite"),
            Self::Orientation(index, error) => write!(f, "pose {index}: {error}"),
            Self::TooLittleRotation { spread, direction } => {
                let [x, y, z] = direction;
                write!(
                    f,
                    "the instrument was turned too little: direction ({x:.2}, {y:.2}, {z:.2}) of its handle by {:.1}°, expected at least {:.0}°; with the tip in \
                     the dimple tilt the handle by 30° to the left, right, front and back, and turn it about its axis",
                    spread.to_degrees(),
                    LEAST_SPREAD.to_degrees()
                )
            }
        }
    }
}

impl Error for PivotError {}

impl Pivot {
    /// Standard error of the tip, √(σ² tr S⁻¹) `[m]`: the root mean square of its distance from the true one.
    pub fn tip_error(&self) -> f64 {
        let trace: f64 = (0..3).map(|axis| self.cofactor[axis][axis]).sum();
        self.sigma * trace.sqrt()
    }

    /// The largest residual `[m]`.
    pub fn worst(&self) -> f64 {
        self.residuals.iter().copied().fold(0.0, f64::max)
    }
}

/// The tip of an instrument from poses of its handle while the tip stood still.
///
/// # Errors
/// [`PivotError`] if the poses do not determine it.
pub fn pivot(poses: &[Pose]) -> Result<Pivot, PivotError> {
    let count = poses.len();
    if count < LEAST_POSES {
        return Err(PivotError::TooFew(count));
    }
    let mut turns = Vec::with_capacity(count);
    let mut places = Vec::with_capacity(count);
    for (index, pose) in poses.iter().enumerate() {
        if !pose.position.iter().all(|x| x.is_finite()) {
            return Err(PivotError::NotFinite(index));
        }
        let [x, y, z, w] =
            checked_unit(pose.orientation).map_err(|e| PivotError::Orientation(index, e))?;
        let turn: UnitQuaternion<f64> = Unit::new_unchecked(Quaternion::new(w, x, y, z));
        turns.push(turn.to_rotation_matrix().into_inner());
        places.push(Vector3::from(pose.position));
    }
    let n = count as f64;
    let mean_turn = turns.iter().sum::<Matrix3<f64>>() / n;
    let mean_place = places.iter().sum::<Vector3<f64>>() / n;
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (turn, place) in turns.iter().zip(&places) {
        let off = turn - mean_turn;
        normal += off.transpose() * off;
        right -= off.transpose() * (place - mean_place);
    }
    let eigen = normal.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    // 1 − cos² of the spread, from the centred sums so that it stays exact when it is small.
    let sine = (eigen.eigenvalues[least] / n).clamp(0.0, 1.0).sqrt();
    let spread = libm::asin(sine);
    if spread < LEAST_SPREAD {
        return Err(PivotError::TooLittleRotation {
            spread,
            direction: eigen.eigenvectors.column(least).into_owned().into(),
        });
    }
    let inverse = eigen.eigenvectors
        * Matrix3::from_diagonal(&eigen.eigenvalues.map(|value| 1.0 / value))
        * eigen.eigenvectors.transpose();
    let tip = inverse * right;
    let centre = mean_turn * tip + mean_place;
    let residuals: Vec<f64> = turns
        .iter()
        .zip(&places)
        .map(|(turn, place)| (turn * tip + place - centre).norm())
        .collect();
    let squares: f64 = residuals.iter().map(|r| r * r).sum();
    Ok(Pivot {
        tip: tip.into(),
        centre: centre.into(),
        rms: (squares / n).sqrt(),
        sigma: (squares / (3.0 * n - 6.0)).sqrt(),
        residuals,
        spread,
        cofactor: inverse.into(),
    })
}
