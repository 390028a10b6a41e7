//! The broad phases take no memory once they have seen the scene at its fullest.

#![allow(unsafe_code, reason = "an allocator that counts")]

use microsim_geometry::{Aabb, BroadPhase, Bvh, SpatialHash};
use nalgebra::Vector3;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts how often memory was asked for.
struct Counted;

static COUNT: AtomicUsize = AtomicUsize::new(0);

// SAFETY: everything is handed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`, and `alloc` handed out the system's memory.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTED: Counted = Counted;

/// A sheet of 40 × 40 boxes, flat at `time` 0 and torn apart later.
fn sheet(time: f64, boxes: &mut Vec<Aabb>) {
    boxes.clear();
    for i in 0..40 {
        for j in 0..40 {
            let corner = Vector3::new(f64::from(i), f64::from(j), time * f64::from((i * j) % 7));
            boxes.push(Aabb::of(&[corner, corner + Vector3::repeat(1.0)]));
        }
    }
}

#[test]
fn no_allocation_in_the_steady_state() {
    let (mut hash, mut refitted, mut rebuilt) = (SpatialHash::new(), Bvh::new(), Bvh::new());
    let (mut boxes, mut pairs, mut found) = (Vec::new(), Vec::new(), Vec::new());
    let mut counts = Vec::with_capacity(20);
    for step in 0..20 {
        let before = COUNT.load(Ordering::Relaxed);
        sheet(0.1 * f64::from(step % 10), &mut boxes);
        hash.rebuild(1.0, &boxes);
        hash.self_pairs(&mut pairs);
        hash.query(&boxes[7], &mut found);
        refitted.refit(&boxes);
        refitted.self_pairs(&mut pairs);
        rebuilt.rebuild(&boxes);
        rebuilt.pairs(&boxes, &mut pairs);
        counts.push(COUNT.load(Ordering::Relaxed) - before);
    }
    assert!(counts[0] > 0, "the counter counts");
    // The second round of the ten phases is the first once more.
    assert_eq!(counts[10..], [0; 10], "{counts:?}");
}
