//! A condition that must hold without interruption for a time.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Watches one condition. Plain data: saved and restored as it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Dwell {
    /// How long the condition must hold \[s\].
    required_s: f64,
    /// Since when it holds, and when that was last seen \[s\].
    held: Option<(f64, f64)>,
}

/// What an update found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DwellState {
    /// The condition does not hold.
    Idle,
    /// It holds, for so long so far \[s\].
    Holding(f64),
    /// It has held for the time required, and still does.
    Complete,
    /// It held until the last update, for so long \[s\], which was not long enough. Reported once; the measurement restarts.
    Lost(f64),
}

/// A dwell time that is negative or not a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DwellError(pub f64);

impl fmt::Display for DwellError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "dwell time {} s: must be 0 or more", self.0)
    }
}

impl std::error::Error for DwellError {}

impl Dwell {
    /// Watches for `required_s` \[s\], 0 or more; with 0 the condition is complete as soon as it holds.
    pub fn new(required_s: f64) -> Result<Self, DwellError> {
        if !required_s.is_finite() || required_s < 0.0 {
            return Err(DwellError(required_s));
        }
        Ok(Dwell {
            required_s,
            held: None,
        })
    }

    /// Updates whether the condition holds at time `now` \[s\]; times do not decrease. Time counts from the first update that
    /// finds it holding.
    pub fn update(&mut self, now: f64, holds: bool) -> DwellState {
        if holds {
            let (since, _) = self.held.unwrap_or((now, now));
            self.held = Some((since, now));
            let held = now - since;
            return if held >= self.required_s {
                DwellState::Complete
            } else {
                DwellState::Holding(held)
            };
        }
        match self.held.take() {
            Some((since, last)) if last - since < self.required_s => DwellState::Lost(last - since),
            _ => DwellState::Idle,
        }
    }

    /// Fraction of the time required, 0..1, as of the last update.
    pub fn progress(&self) -> f64 {
        match self.held {
            None => 0.0,
            Some((since, last)) if last - since < self.required_s => {
                (last - since) / self.required_s
            }
            Some(_) => 1.0,
        }
    }

    /// Forgets what was held, without a loss: the level was paused, or the target changed.
    pub fn reset(&mut self) {
        self.held = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn completes_only_without_interruption() {
        let mut dwell = Dwell::new(1.0).expect("a time");
        assert_eq!(dwell.update(0.0, false), DwellState::Idle);
        assert_eq!(dwell.update(0.25, true), DwellState::Holding(0.0));
        assert_eq!(dwell.update(1.0, true), DwellState::Holding(0.75));
        assert_eq!(dwell.progress(), 0.75);
        assert_eq!(
            dwell.update(1.125, false),
            DwellState::Lost(0.75),
            "held until 1.0, when it was last seen"
        );
        assert_eq!(dwell.progress(), 0.0);
        assert_eq!(
            dwell.update(1.25, false),
            DwellState::Idle,
            "a loss is reported once"
        );
        assert_eq!(
            dwell.update(1.5, true),
            DwellState::Holding(0.0),
            "restarts"
        );
        assert_eq!(dwell.update(2.5, true), DwellState::Complete);
        assert_eq!(dwell.update(3.0, true), DwellState::Complete);
        assert_eq!(dwell.progress(), 1.0);
        assert_eq!(
            dwell.update(3.25, false),
            DwellState::Idle,
            "after completion nothing is lost"
        );
    }

    #[test]
    fn zero_is_complete_at_once_and_other_times_are_refused() {
        let mut dwell = Dwell::new(0.0).expect("a time");
        assert_eq!(dwell.progress(), 0.0);
        assert_eq!(dwell.update(0.0, true), DwellState::Complete);
        assert_eq!(dwell.progress(), 1.0);
        assert_eq!(Dwell::new(-1.0), Err(DwellError(-1.0)));
        assert!(Dwell::new(f64::NAN).is_err());
    }

    #[test]
    fn goes_on_after_restoring_as_before() {
        let mut dwell = Dwell::new(1.0).expect("a time");
        dwell.update(0.1, true);
        let text = serde_json::to_string(&dwell).expect("plain data");
        let mut again: Dwell = serde_json::from_str(&text).expect("own text");
        assert_eq!(again, dwell);
        assert_eq!(again.update(1.1, true), dwell.update(1.1, true));
        dwell.reset();
        assert_eq!(dwell.update(1.2, true), DwellState::Holding(0.0));
    }
}
