//! Parallel loops on a pool of threads.

use microsim_scene::Executor;
use rayon::prelude::*;

/// A pool of threads.
#[derive(Debug)]
pub struct Pool(rayon::ThreadPool);

impl Pool {
    /// A pool of `threads` threads.
    pub fn new(threads: usize) -> Result<Self, String> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map(Self)
            .map_err(|e| format!("cannot start {threads} threads: {e}"))
    }
}

impl Executor for Pool {
    fn for_each(&self, parts: usize, body: &(dyn Fn(usize) + Sync)) {
        self.0.install(|| (0..parts).into_par_iter().for_each(body));
    }
}
