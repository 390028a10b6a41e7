//! Samples of one motion, as far as the next one is compared with them.

use serde::{Deserialize, Serialize};

/// Times that differ by less are taken to differ by this `[s]`: shorter than the 16 ms of usual devices, longer than what networks and coarse clocks
/// make of intervals of a millisecond. A judgement.
pub(super) const SHORTEST_INTERVAL_S: f64 = 0.01;

/// A sample in the device's frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Point {
    /// By the device's clock `[s]`.
    pub time_s: f64,
    pub position: [f64; 3],
    /// A unit quaternion.
    pub orientation: [f64; 4],
    /// That of the tool, 0 closed to 1 open.
    pub opening: f64,
}

/// Samples of one motion: the last one, and one before it for its velocity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Track {
    last: Point,
    /// Where the velocity is counted from: at least [`SHORTEST_INTERVAL_S`] before the last one.
    before: Option<Point>,
    /// What becomes so.
    pending: Point,
}

impl Track {
    pub(super) fn new(point: Point) -> Self {
        Self {
            last: point,
            before: None,
            pending: point,
        }
    }

    pub(super) fn last(&self) -> &Point {
        &self.last
    }

    pub(super) fn before(&self) -> Option<&Point> {
        self.before.as_ref()
    }

    pub(super) fn push(&mut self, point: Point) {
        if point.time_s < self.last.time_s {
            // The clock was set back: no interval, no velocity.
            *self = Self::new(point);
            return;
        }
        if point.time_s - self.pending.time_s >= SHORTEST_INTERVAL_S {
            self.before = Some(self.pending);
            self.pending = point;
        }
        self.last = point;
    }
}
