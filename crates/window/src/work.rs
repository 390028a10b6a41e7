//! Work on the store in a thread of its own, and how far it is. It goes on whatever screen is shown.

use crate::ledger::{Done, Job};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How far it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// From 0 to 1; `None` where nobody knows how much there is.
    pub done: Option<f64>,
    /// What is being done.
    pub what: String,
}

/// Work that goes on.
#[derive(Debug)]
pub struct Running {
    since: Instant,
    part: Arc<Mutex<Part>>,
    thread: JoinHandle<Result<Done, String>>,
}

/// A panic of the other thread leaves data that can be read all the same.
fn lock(part: &Mutex<Part>) -> MutexGuard<'_, Part> {
    part.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Running {
    /// Starts it; `wake` is called whenever there is something new to show.
    ///
    /// # Errors
    /// If the system has no thread for it.
    pub fn start(job: Box<dyn Job>, wake: impl Fn() + Send + 'static) -> Result<Self, String> {
        let part = Arc::new(Mutex::new(Part::default()));
        let seat = Arc::clone(&part);
        let run = move || {
            let ended = job.run(&mut |done, what| {
                *lock(&seat) = Part { done, what };
                wake();
            });
            wake();
            ended
        };
        let thread = std::thread::Builder::new().name("store".into());
        let thread = thread
            .spawn(run)
            .map_err(|e| format!("no thread for work on the store: {e}"))?;
        Ok(Self {
            since: Instant::now(),
            part,
            thread,
        })
    }

    /// How far it is, and since when it goes on.
    pub fn part(&self) -> (Part, Duration) {
        (lock(&self.part).clone(), self.since.elapsed())
    }

    /// Whether it has ended.
    pub fn has_ended(&self) -> bool {
        self.thread.is_finished()
    }

    /// What came of it; waits for its end.
    ///
    /// # Errors
    /// Why it could not be done.
    pub fn end(self) -> Result<Done, String> {
        let ended = self.thread.join();
        ended.unwrap_or_else(|_| Err("the work on the store broke off: a bug of MicroSim".into()))
    }
}

/// The time that is left if what is to come takes as long as what was.
pub fn left(part: f64, passed: Duration) -> Option<Duration> {
    let is_known = part > 0.0 && part <= 1.0;
    is_known.then(|| passed.mul_f64((1.0 - part) / part))
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Panics;

    impl Job for Panics {
        fn run(
            self: Box<Self>,
            progress: &mut dyn FnMut(Option<f64>, String),
        ) -> Result<Done, String> {
            progress(Some(0.5), "half of it".into());
            panic!("a bug");
        }
    }

    #[test]
    fn work_that_breaks_off_is_an_error() {
        let running = Running::start(Box::new(Panics), || ()).expect("a thread");
        let part = Arc::clone(&running.part);
        let why = running.end().expect_err("it broke off");
        assert!(why.contains("broke off"), "{why}");
        assert_eq!(lock(&part).done, Some(0.5));
    }

    /// A quarter took 10 s, so three quarters take 30 s.
    #[test]
    fn what_is_left_takes_as_long_as_what_was() {
        let ten = Duration::from_secs(10);
        assert_eq!(left(0.25, ten), Some(Duration::from_secs(30)));
        assert_eq!(left(0.0, ten), None);
    }
}
