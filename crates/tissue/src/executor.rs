//! Where parallel loops run.

/// Runs the parts of a loop, in any order and on any threads; returns when all are done.
///
/// The parts of a loop never depend on the executor, and each writes to places of its own: so the result has the same
/// bits on every executor.
pub trait Executor {
    /// Calls `body(part)` once for each part in `0..parts`.
    fn for_each(&self, parts: usize, body: &(dyn Fn(usize) + Sync));
}

/// Runs the parts one after another on the calling thread.
#[derive(Clone, Copy, Debug, Default)]
pub struct Serial;

impl Executor for Serial {
    fn for_each(&self, parts: usize, body: &(dyn Fn(usize) + Sync)) {
        (0..parts).for_each(body);
    }
}
