//! Where the tip of an instrument is in the frame of its handle, and where the frame of a tracker lies: least squares from what a tracker has
//! sent, with what theory gives for the errors of the result.
//!
//! Both estimates assume errors of positions that are independent, normal and as large along each axis (standard deviation σ). Then
//! the sums of squared residuals over σ² are chi-square distributed with as many degrees of freedom as there are equations less unknowns, and the covariances
//! of the results are those stated at [`Pivot::tip_error`] and [`Registration::target_error`].
//!
//! Errors of orientations act on a pivot calibration as errors of positions of size (angle × length of the lever); they are in its residual.

mod dwell;
mod pivot;
mod workspace;

pub use dwell::{Dwell, dwells};
pub use pivot::{LEAST_POSES, LEAST_SPREAD, Pivot, PivotError, pivot};
pub use workspace::{LEAST_WIDTH, Pair, Registration, RegistrationError, register};

#[cfg(test)]
mod pivot_tests;
#[cfg(test)]
mod workspace_tests;
