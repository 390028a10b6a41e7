//! What the log states of a run once it was shown: how many pictures, and how long motions, ticks and pictures took.

use crate::pace::{Pace, Times};
use microsim_render::Quality;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Counts what is shown of a run while it goes on.
#[derive(Debug, Default)]
pub struct Account {
    /// When the run was last seen going on.
    seen: Option<Instant>,
    /// For how long it went on.
    time: Duration,
    pictures: u64,
    quality: Quality,
    /// From the begin of drawing a picture to the end.
    drawing: Arc<Mutex<Times>>,
}

impl Account {
    /// Takes that the run goes on, or does not, with pictures of this quality.
    pub fn go_on(&mut self, goes_on: bool, quality: Quality, now: Instant) {
        self.quality = quality;
        if let (true, Some(seen)) = (goes_on, self.seen) {
            self.time += now.duration_since(seen);
        }
        self.seen = goes_on.then_some(now);
    }

    /// Counts a picture; where the time that it takes is put.
    pub fn add(&mut self) -> &Arc<Mutex<Times>> {
        self.pictures += 1;
        &self.drawing
    }

    /// Pictures in a second, once there was one.
    fn rate(&self) -> Option<f64> {
        let time = self.time.as_secs_f64();
        (time > 0.0).then(|| self.pictures as f64 / time)
    }

    /// Writes it into the log, times in milliseconds; nothing if nothing was shown. Those of ticks and pictures are of the last of them ([`Times`]).
    pub fn log(&self, ticks: u64, pace: &Pace, delays: &Mutex<Times>) {
        let Some(rate) = self.rate() else {
            return;
        };
        let [drawing, delays] = [&*self.drawing, delays].map(|times| {
            let times = times.lock().unwrap_or_else(PoisonError::into_inner);
            both(&times)
        });
        let [waits, of_ticks] = [both(&pace.waits), both(&pace.ticks)];
        tracing::info!(
            quality = self.quality.name(),
            pictures = self.pictures,
            seconds = self.time.as_secs_f64(),
            rate,
            picture_p50 = drawing[0],
            picture_p99 = drawing[1],
            to_tick_p50 = waits[0],
            to_tick_p99 = waits[1],
            tick_p50 = of_ticks[0],
            tick_p99 = of_ticks[1],
            to_picture_p50 = delays[0],
            to_picture_p99 = delays[1],
            ticks,
            late = pace.late,
            overdue = pace.overdue,
            overdue_by_work = pace.overdue_by_work,
            unconverged = pace.unconverged,
            held = pace.held,
            "a run was shown"
        );
    }
}

/// p50 and p99 \[ms\]; not a number without any.
fn both(times: &Times) -> [f64; 2] {
    [0.5, 0.99].map(|q| times.quantile(q).map_or(f64::NAN, |time| 1e3 * time))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Time that passes while a run is paused is none of it.
    #[test]
    fn pauses_do_not_count() {
        let mut account = Account::default();
        let start = Instant::now();
        let at = |seconds: u64| start + Duration::from_secs(seconds);
        account.go_on(false, Quality::Low, at(0));
        assert_eq!(account.rate(), None);
        account.go_on(true, Quality::Low, at(5));
        account.go_on(true, Quality::Low, at(7));
        (0..50).for_each(|_| drop(Arc::clone(account.add())));
        account.go_on(false, Quality::Low, at(8));
        account.go_on(true, Quality::Low, at(100));
        account.go_on(true, Quality::Low, at(103));
        assert_eq!(account.rate(), Some(10.0));
    }
}
