//! What the tests of the narrow phase and the searches for first contacts cost: nanoseconds of CPU time per call, over random pairs
//! of features of size 1 whose middles are up to 1 apart, as a broad phase hands them over; moving ones go up to 0.2 in the step.
//!
//! `cargo run --release -p microsim-geometry --example narrow_phase`

use microsim_geometry::{
    Motion, closest_on_triangle, closest_segment_triangle, closest_segments, edge_through_triangle,
    first_contact_edges, first_contact_point_triangle, first_contact_segment_triangle,
    point_in_tetrahedron,
};
use microsim_random::SplitMix64;
use nalgebra::Vector3;
use rustix::time::{ClockId, clock_gettime};

type Point = Vector3<f64>;

/// Pairs of each kind.
const PAIRS: usize = 4096;

fn main() {
    let mut random = SplitMix64(1);
    let [still, moved]: [Vec<[Point; 6]>; 2] = [0.5, 0.1].map(|size| {
        let corners = |_| std::array::from_fn(|_| random.vector() * size);
        (0..PAIRS).map(corners).collect()
    });
    let motions: Vec<[Motion<1>; 6]> = still
        .iter()
        .zip(&moved)
        .map(|(start, shift)| {
            std::array::from_fn(|k| Motion {
                start: [start[k]],
                end: [start[k] + shift[k]],
            })
        })
        .collect();

    time("point in tetrahedron", &still, |[p, a, b, c, d, _]| {
        point_in_tetrahedron(p, &[*a, *b, *c, *d]).is_some()
    });
    time("edge through triangle", &still, |[p, q, a, b, c, _]| {
        edge_through_triangle(p, q, &[*a, *b, *c]).is_some()
    });
    // In the plane z = 0 every sign needs exact arithmetic.
    let flat: Vec<[Point; 6]> = still
        .iter()
        .map(|points| points.map(|p| Point::new(p.x, p.y, 0.1)))
        .collect();
    time(
        "edge through triangle, coplanar",
        &flat,
        |[p, q, a, b, c, _]| edge_through_triangle(p, q, &[*a, *b, *c]).is_some(),
    );
    time("segments, closest", &still, |[p, q, a, b, ..]| {
        closest_segments(p, q, a, b).distance_squared() < 0.01
    });
    time("point and triangle, closest", &still, |[p, a, b, c, ..]| {
        (closest_on_triangle(p, &[*a, *b, *c]).point - p).norm() < 0.1
    });
    time(
        "segment and triangle, closest",
        &still,
        |[p, q, a, b, c, _]| closest_segment_triangle(p, q, &[*a, *b, *c]).distance() < 0.1,
    );
    for distance in [0.0, 0.05] {
        time(
            &format!("point and triangle, first within {distance}"),
            &motions,
            |[p, a, b, c, ..]| {
                first_contact_point_triangle(p, &join([a, b, c]), distance).is_some()
            },
        );
        time(
            &format!("edges, first within {distance}"),
            &motions,
            |[p, q, a, b, ..]| {
                first_contact_edges(&join([p, q]), &join([a, b]), distance).is_some()
            },
        );
        time(
            &format!("segment and triangle, first within {distance}"),
            &motions,
            |[p, q, a, b, c, _]| {
                first_contact_segment_triangle(&join([p, q]), &join([a, b, c]), distance).is_some()
            },
        );
    }
}

/// Prints the time per call and the fraction of pairs for which it is true.
fn time<T>(name: &str, pairs: &[T], test: impl Fn(&T) -> bool) {
    let (mut best, mut hits) = (f64::INFINITY, 0);
    for _ in 0..20 {
        let before = now();
        hits = pairs.iter().filter(|pair| test(pair)).count();
        best = best.min(now() - before);
    }
    let each = best / pairs.len() as f64;
    let fraction = 100.0 * hits as f64 / pairs.len() as f64;
    println!("{name:<42}{each:>9.0} ns{fraction:>7.1} % of pairs");
}

/// CPU time of this thread \[ns\].
fn now() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e9 + time.tv_nsec as f64
}

fn join<const N: usize>(points: [&Motion<1>; N]) -> Motion<N> {
    Motion {
        start: points.map(|point| point.start[0]),
        end: points.map(|point| point.end[0]),
    }
}
