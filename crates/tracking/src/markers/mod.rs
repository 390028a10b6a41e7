//! Pose and opening of an instrument from the positions of its markers.
//!
//! An instrument has three to eight markers, each at a known place in the frame of its handle. Those of jaws move with the opening o: a marker is
//! at c + o (c′ − c), with its places when closed (c) and when open (c′). The fit is the least sum of squares over rotation, translation and opening.
//!
//! # Which point is which marker
//! Points come with the names of markers, which may be mixed up, or point at nothing: every assignment of points to markers whose distances agree is tried,
//! and the one that explains the most points with the least residual counts. Two that explain as much but place the instrument
//! differently are distinguished by their residuals, by a factor of two at least, else by the names; what neither decides is ambiguous and no pose.
//!
//! A marker may be missing. Two that come close to each other may be seen as one point between them: such a point is compared with their mean.
//! With at least three points that do not lie on a line there is a pose; the opening is known where those points determine it.
//!
//! # Errors
//! With errors of σ along each axis the covariance of pose and opening is σ² (JᵀJ)⁻¹, with J the derivative of the points.

mod assign;
mod fit;
mod group;

pub use assign::{MarkerFit, MarkerLoss, MarkerPoint};
pub use group::MarkedInstrument;

use nalgebra::Vector3;
use std::error::Error;
use std::fmt;

/// Most markers of an instrument.
pub const MOST_MARKERS: usize = 8;
/// Fewest.
pub const FEWEST_MARKERS: usize = 3;

/// A marker in the frame of the handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marker {
    /// Where it is when the instrument is closed `[m]`.
    pub closed: [f64; 3],
    /// Where it is when it is open; the same for one that does not move `[m]`.
    pub open: [f64; 3],
}

/// The markers of an instrument.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerModel {
    pub(crate) markers: Vec<Marker>,
    /// Largest root mean square residual of a fit `[m]`.
    pub(crate) tolerance: f64,
    /// Two markers nearer than this may be seen as one point `[m]`.
    pub(crate) merge: f64,
}

/// What is wrong with markers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MarkerProblem {
    /// This many.
    Count(usize),
    /// A coordinate of the marker of this index is not finite.
    NotFinite(usize),
    /// The tolerance is not a finite positive number, or the merging distance not finite or below 0.
    Rule(f64),
    /// They lie on a line, or within ten tolerances of one.
    Line,
}

impl fmt::Display for MarkerProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(found) => write!(
                f,
                "expected {FEWEST_MARKERS} to {MOST_MARKERS} markers, found {found}"
            ),
            Self::NotFinite(index) => {
                write!(f, "a coordinate of marker {} is not finite", index + 1)
            }
            Self::Rule(value) => write!(f, "expected a finite positive length, found {value}"),
            Self::Line => write!(
                f,
                "the markers lie on a line, or closer to it than ten times the tolerance; a turn about it cannot be seen"
            ),
        }
    }
}

impl Error for MarkerProblem {}

impl Marker {
    /// Its place at an opening `[m]`.
    pub(crate) fn at(&self, opening: f64) -> Vector3<f64> {
        Vector3::from(self.closed) + self.motion() * opening
    }

    /// From closed to open `[m]`.
    pub(crate) fn motion(&self) -> Vector3<f64> {
        Vector3::from(self.open) - Vector3::from(self.closed)
    }
}

impl MarkerModel {
    /// An instrument with these markers; a fit whose root mean square residual is beyond `tolerance` `[m]` is none, and markers nearer than `merge` `[m]` may
    /// be seen as one.
    ///
    /// # Errors
    /// [`MarkerProblem`] if they determine no pose.
    pub fn new(markers: Vec<Marker>, tolerance: f64, merge: f64) -> Result<Self, MarkerProblem> {
        if !(FEWEST_MARKERS..=MOST_MARKERS).contains(&markers.len()) {
            return Err(MarkerProblem::Count(markers.len()));
        }
        let is_finite = |marker: &Marker| {
            marker
                .closed
                .iter()
                .chain(&marker.open)
                .all(|x| x.is_finite())
        };
        if let Some(index) = markers.iter().position(|marker| !is_finite(marker)) {
            return Err(MarkerProblem::NotFinite(index));
        }
        if !(tolerance.is_finite() && tolerance > 0.0) {
            return Err(MarkerProblem::Rule(tolerance));
        }
        if !(merge.is_finite() && merge >= 0.0) {
            return Err(MarkerProblem::Rule(merge));
        }
        for opening in [0.0, 1.0] {
            let points: Vec<_> = markers.iter().map(|marker| marker.at(opening)).collect();
            if fit::width(&points) < 10.0 * tolerance {
                return Err(MarkerProblem::Line);
            }
        }
        Ok(Self {
            markers,
            tolerance,
            merge,
        })
    }

    /// Number of its markers.
    pub fn count(&self) -> usize {
        self.markers.len()
    }

    /// Least and largest distance of two markers over all openings `[m]`.
    pub(crate) fn distances(&self, first: usize, second: usize) -> (f64, f64) {
        let (a, b) = (&self.markers[first], &self.markers[second]);
        let [closed, open] = [0.0, 1.0].map(|opening| a.at(opening) - b.at(opening));
        let motion = open - closed;
        let square = motion.norm_squared();
        // Where the line from one difference to the other is nearest to 0.
        let nearest = if square > 0.0 {
            (-closed.dot(&motion) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let least = (closed + motion * nearest).norm();
        (least, closed.norm().max(open.norm()))
    }
}

#[cfg(test)]
mod tests;
