//! Threads that compute a run go before those that draw it.
//!
//! A software driver draws on all cores of the processor, and ticks would wait for it. On Linux a thread has the priority of the one that starts it, and what it gives
//! up it cannot take back; so one that has given up nothing stays behind, and starts those that compute.

use std::io;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread::{Builder, JoinHandle};

type Work = Box<dyn FnOnce() + Send>;

/// What the thread that starts others is asked for.
static STARTER: OnceLock<Mutex<Sender<Work>>> = OnceLock::new();

/// By how much drawing is "nicer" than computing: a tenth of the processor is left for it where there is not enough for both.
const NICER: i32 = 10;

/// Lowers the priority of this thread and of those that it starts from now on, a driver's among them, below that of those of [`start`].
///
/// # Errors
/// If the system has no thread for it, or refuses.
pub fn lower_priority() -> io::Result<()> {
    let (sender, receiver) = channel::<Work>();
    let starter = Builder::new().name("starter".into());
    starter.spawn(move || receiver.iter().for_each(|work| work()))?;
    if STARTER.set(Mutex::new(sender)).is_ok() {
        rustix::process::nice(NICER)?;
    }
    Ok(())
}

/// Starts a thread that computes.
///
/// # Errors
/// If the system has no thread for it.
pub fn start<T: Send + 'static>(
    name: &'static str,
    compute: impl FnOnce() -> T + Send + 'static,
) -> io::Result<JoinHandle<T>> {
    let spawn = move || Builder::new().name(name.into()).spawn(compute);
    let Some(starter) = STARTER.get() else {
        return spawn();
    };
    let (sender, receiver) = channel();
    let work = move || {
        let _ = sender.send(spawn());
    };
    let ended = || io::Error::other("the thread that starts others has ended");
    let asked = starter.lock().unwrap_or_else(PoisonError::into_inner);
    asked.send(Box::new(work)).map_err(|_| ended())?;
    drop(asked);
    receiver.recv().map_err(|_| ended())?
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thread that computes has the priority of before, one that draws a lower one.
    #[test]
    fn computing_goes_before_drawing() {
        let own = || rustix::process::nice(0).expect("the priority of a thread");
        let before = own();
        let window = std::thread::spawn(move || {
            lower_priority().expect("a lower priority");
            let drawing = std::thread::spawn(own).join().expect("no panic");
            let computing = start("computing", own).expect("a thread");
            (drawing, computing.join().expect("no panic"))
        });
        let (drawing, computing) = window.join().expect("no panic");
        assert_eq!(computing, before);
        // 19 is the most there is.
        assert_eq!(drawing, (before + NICER).min(19));
        assert_eq!(own(), before);
    }
}
