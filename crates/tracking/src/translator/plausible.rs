//! Which samples are of a motion that a hand makes.
//!
//! A sample counts if a hand can have come to it from those that have counted. One that does not begins a second track: the samples after it go
//! on with the track that they are nearer to, seen from what a hand can do. So
//!
//! - a single sample elsewhere is left out, and the next one counts again;
//! - a few of them, or of a tracker that sees something else at every sample, are left out as well: while samples contradict each other a
//!   hand is given [`LONGEST_IN_DOUBT_S`] and no more to come to where the next one counts;
//! - a jump that lasts (the tracker was registered again, or has found the instrument elsewhere) counts once its samples have been consistent with each other
//!   for [`HandLimits::accept_after_s`], three of them at least. The tool is lost before, for a tick at least: nothing joins the two
//!   places.

use super::hand::{Excess, HandLimits};
use super::track::{Point, Track};
use serde::{Deserialize, Serialize};

/// Samples that make a lasting jump, at least: two of any tracker can lie beside each other by chance.
const FEWEST_SAMPLES: u32 = 3;

/// How long a hand is given to come from the last sample that counts to the next one while others contradict it `[s]`: two intervals of usual devices,
/// so that a hand goes on during a single wrong sample, and a tracker that errs moves a tool by some millimetres at most. A judgement.
const LONGEST_IN_DOUBT_S: f64 = 0.03;

/// Samples elsewhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Elsewhere {
    track: Track,
    /// What its first sample was beyond.
    excess: Excess,
    samples: u32,
    /// When its first sample arrived, in the session's time `[s]`.
    since_s: f64,
    /// When it had lasted for long enough.
    lasting_s: Option<f64>,
}

/// What becomes of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Assessment {
    /// It counts.
    Counts,
    /// It is left out.
    LeftOut(Excess),
    /// So too, and those elsewhere have lasted: the tool is not where it was.
    Lost(Excess),
}

/// What is remembered of the samples of a device.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Plausible {
    counts: Option<Track>,
    elsewhere: Option<Elsewhere>,
}

impl Plausible {
    /// Takes a sample that arrives at `now_s` `[s]` of the session.
    pub(super) fn assess(&mut self, point: Point, now_s: f64, limits: &HandLimits) -> Assessment {
        let Some(track) = &mut self.counts else {
            self.counts = Some(Track::new(point));
            return Assessment::Counts;
        };
        let longest_s = match self.elsewhere {
            Some(_) => LONGEST_IN_DOUBT_S,
            None => f64::INFINITY,
        };
        let (ratio, excess) = limits.ratio(track, &point, longest_s);
        let other = self.elsewhere.as_mut();
        let other = other.map(|other| {
            let ratio = limits.ratio(&other.track, &point, f64::INFINITY).0;
            (ratio, other)
        });
        let nearest = other.as_ref().map_or(f64::INFINITY, |(ratio, _)| *ratio);
        if ratio <= 1.0 && ratio <= nearest {
            track.push(point);
            self.elsewhere = None;
            return Assessment::Counts;
        }
        let Some((_, other)) = other.filter(|(ratio, _)| *ratio <= 1.0) else {
            self.elsewhere = Some(Elsewhere {
                track: Track::new(point),
                excess,
                samples: 1,
                since_s: now_s,
                lasting_s: None,
            });
            return Assessment::LeftOut(excess);
        };
        other.track.push(point);
        other.samples = other.samples.saturating_add(1);
        match other.lasting_s {
            Some(lasting_s) if now_s > lasting_s => {
                self.counts = Some(other.track.clone());
                self.elsewhere = None;
                return Assessment::Counts;
            }
            Some(_) => {}
            None => {
                let has_lasted = now_s - other.since_s >= limits.accept_after_s;
                if has_lasted && other.samples >= FEWEST_SAMPLES {
                    other.lasting_s = Some(now_s);
                }
            }
        }
        match other.lasting_s {
            Some(_) => Assessment::Lost(other.excess),
            None => Assessment::LeftOut(other.excess),
        }
    }

    /// The device does not see the instrument, or reports no pose: what was elsewhere is not followed any further.
    pub(super) fn interrupt(&mut self) {
        self.elsewhere = None;
    }
}
