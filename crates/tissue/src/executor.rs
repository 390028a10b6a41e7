//! Where parallel loops run.

use std::sync::{Mutex, PoisonError};

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

/// Sets `out[i] = value(i)` for all `i`, in `parts` pieces of equal size.
pub(crate) fn fill<T: Send>(
    exec: &dyn Executor,
    parts: usize,
    out: &mut [T],
    value: impl Fn(usize) -> T + Sync,
) {
    let fill_piece = |first: usize, piece: &mut [T]| {
        for (offset, slot) in piece.iter_mut().enumerate() {
            *slot = value(first + offset);
        }
    };
    if parts <= 1 || out.is_empty() {
        fill_piece(0, out);
        return;
    }
    // Each piece is locked once, by the one part that owns it: the lock only proves to the compiler that they are disjoint.
    let size = out.len().div_ceil(parts);
    let pieces: Vec<Mutex<&mut [T]>> = out.chunks_mut(size).map(Mutex::new).collect();
    exec.for_each(pieces.len(), &|part| {
        let mut piece = pieces[part].lock().unwrap_or_else(PoisonError::into_inner);
        fill_piece(part * size, &mut piece);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_index_is_filled_once_for_any_number_of_parts() {
        for length in [0, 1, 7, 100] {
            for parts in [1, 2, 3, 16, 200] {
                let mut out = vec![usize::MAX; length];
                fill(&Serial, parts, &mut out, |i| i * i);
                assert!(
                    out.iter().enumerate().all(|(i, &v)| v == i * i),
                    "{length} {parts}"
                );
            }
        }
    }
}
