//! The parallel loop that the host offers to physics.

use microsim_abi::{ParallelBody, ParallelFor};
use rayon::prelude::*;
use std::ffi::c_void;

/// A pool of threads, behind a pointer that plugins may hold.
#[derive(Clone, Copy, Debug)]
pub struct Parallel {
    pool: &'static rayon::ThreadPool,
}

struct Data(*const c_void);
// SAFETY: the plugin passes data that its body may use from several threads (see `microsim_abi::ParallelFor`).
unsafe impl Sync for Data {}

impl Data {
    fn get(&self) -> *const c_void {
        self.0
    }
}

unsafe extern "C" fn run(
    context: *const c_void,
    parts: u32,
    body: ParallelBody,
    data: *const c_void,
) {
    // SAFETY: `context` is the pool of a `Parallel`, which is never freed.
    let pool = unsafe { &*context.cast::<rayon::ThreadPool>() };
    let data = Data(data);
    pool.install(|| {
        (0..parts).into_par_iter().for_each(|part| {
            // SAFETY: the plugin guarantees `body` and `data` until `run` returns; `body` does not unwind.
            unsafe { (body.call)(data.get(), part) }
        });
    });
}

impl Parallel {
    /// A pool of `threads` threads.
    pub fn new(threads: usize) -> Result<Self, String> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|i| format!("microsim-{i}"))
            .build()
            .map_err(|e| format!("cannot start {threads} threads: {e}"))?;
        // Lives as long as the process, like the libraries: a plugin may keep the service wherever it likes.
        Ok(Self {
            pool: Box::leak(Box::new(pool)),
        })
    }

    /// What crosses to a plugin; valid until the process ends.
    pub fn service(&self) -> ParallelFor {
        let context: *const rayon::ThreadPool = self.pool;
        ParallelFor {
            context: context.cast(),
            run,
        }
    }
}
