//! The host's parallel loop, safe.

use crate::panic::{Caught, caught};
use microsim_abi::{ParallelBody, ParallelFor};
use std::ffi::c_void;
use std::sync::Mutex;

/// Runs the parts of a loop on the host's threads, or one after the other where the host gives none.
///
/// What a part computes must not depend on which thread does it: sums belong to fixed parts and are added in a fixed order.
///
/// ```
/// use microsim_sdk::Parallel;
/// use std::sync::atomic::{AtomicU64, Ordering};
///
/// let sums: [AtomicU64; 4] = Default::default();
/// // The host's loop is in [`Services`](crate::Services); this one is serial.
/// Parallel::default().for_each(4, &|part| sums[part].store(part as u64, Ordering::Relaxed));
/// let total: u64 = sums.iter().map(|sum| sum.load(Ordering::Relaxed)).sum();
/// assert_eq!(total, 6);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Parallel(Option<Host>);

#[derive(Clone, Copy)]
struct Host(ParallelFor);

impl std::fmt::Debug for Host {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("host")
    }
}

struct Job<'a> {
    body: &'a (dyn Fn(usize) + Sync),
    panic: Mutex<Option<Caught>>,
}

unsafe extern "C" fn call_part(data: *const c_void, part: u32) {
    // SAFETY: `data` is the `Job` that `for_each` keeps alive until `run` returns.
    let job = unsafe { &*data.cast::<Job<'_>>() };
    if let Err(panic) = caught(|| (job.body)(part as usize)) {
        let mut first = job.panic.lock().unwrap_or_else(|e| e.into_inner());
        match &*first {
            None => *first = Some(panic),
            // Not dropped: a destructor that panics must not unwind into the host.
            Some(_) => std::mem::forget(panic),
        }
    }
}

impl Parallel {
    /// One part after the other.
    pub fn serial() -> Self {
        Self(None)
    }

    pub(crate) fn from_host(parallel: Option<ParallelFor>) -> Self {
        Self(parallel.map(Host))
    }

    /// Calls `body(part)` for every part in `0..parts` and returns when all are done. A panic of a part comes out here.
    pub fn for_each(&self, parts: usize, body: &(dyn Fn(usize) + Sync)) {
        let Some(Host(host)) = self.0 else {
            (0..parts).for_each(body);
            return;
        };
        let job = Job {
            body,
            panic: Mutex::new(None),
        };
        // SAFETY: the host calls `call_part` with this pointer only until `run` returns; `job` lives longer, and `body`
        // may be called from several threads.
        unsafe {
            (host.run)(
                host.context,
                u32::try_from(parts).expect("fewer than 2^32 parts"),
                ParallelBody { call: call_part },
                (&raw const job).cast(),
            );
        }
        let panic = job.panic.into_inner().unwrap_or_else(|e| e.into_inner());
        if let Some(panic) = panic {
            panic.resume();
        }
    }
}
