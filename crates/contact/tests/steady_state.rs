//! Finding points takes no memory once the scene was seen at its fullest.

#![allow(unsafe_code, reason = "an allocator that counts")]

use microsim_contact::{
    CapsuleMotion, ContactPair, ContactSurface, Detector, Frame, ObstaclePart, ObstacleShape, Sides,
};
use microsim_geometry::{Capsule, Pose};
use microsim_mesh::{Block, CellSplit};
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

/// Two blocks sink into one another, a plane and a tool, and come out again, twice.
#[test]
fn no_allocation_in_the_steady_state() {
    let block = |z: f64| {
        let block = Block {
            center: [0.1 * z, 0.2 * z, z],
            size: [3.0, 3.0, 2.0],
            cells: [3, 3, 2],
            split: CellSplit::Kuhn,
        };
        block.mesh().expect("a block")
    };
    let (lower, upper) = (block(1.0), block(3.0));
    let count = lower.positions.len();
    let rest: Vec<_> = lower
        .positions
        .iter()
        .chain(&upper.positions)
        .copied()
        .collect();
    let surfaces = vec![
        ContactSurface::new(&lower, 0),
        ContactSurface::new(&upper, count as u32),
    ];
    let plane = ObstaclePart {
        shape: ObstacleShape::HalfSpace,
        pose: Pose::identity(),
    };
    let cuboid = ObstaclePart {
        shape: ObstacleShape::Cuboid {
            half_size: [1.0, 0.3, 0.5],
            rounding: 0.1,
        },
        pose: Pose::identity(),
    };
    let pairs = vec![
        ContactPair::Bodies {
            body: 0,
            with: 1,
            ends: None,
        },
        ContactPair::Itself { body: 1 },
        ContactPair::Obstacle { body: 0, part: 0 },
        ContactPair::Obstacle { body: 0, part: 1 },
        ContactPair::Tool { body: 1, tool: 0 },
    ];
    let mut detector = Detector::new(surfaces, vec![plane, cuboid], pairs);
    let capsule = Capsule {
        a: Vector3::new(-1.0, 0.0, 4.2),
        b: Vector3::new(1.0, 0.2, 4.2),
        radius: 0.5,
    };
    let tools = [Some(vec![CapsuleMotion {
        start: capsule,
        end: capsule,
    }])];
    let (mut start, mut now) = (rest.clone(), rest.clone());
    let (mut sides, mut points) = (Sides::new(), Vec::new());
    let mut counts = Vec::with_capacity(40);
    let mut most = 0;
    for step in 0..40 {
        let phase = f64::from(step % 20);
        let depth = 0.05 * (10.0 - (phase - 10.0).abs());
        start.copy_from_slice(&now);
        for (p, rest) in now.iter_mut().zip(&rest) {
            *p = rest - Vector3::z() * depth * (1.0 + rest.z);
        }
        let before = COUNT.load(Ordering::Relaxed);
        for reach in [0.0, 0.2] {
            let frame = Frame {
                start: &start,
                now: &now,
                tools: &tools,
                fraction: 1.0,
                reach,
                sides: &sides,
            };
            detector.find(&frame, &mut points);
        }
        sides.remember(&points);
        most = most.max(points.len());
        counts.push(COUNT.load(Ordering::Relaxed) - before);
    }
    assert!(most > 50 && counts[0] > 0, "the counter counts");
    assert_eq!(counts[21..], [0; 19], "{counts:?}");
}
