use super::*;
use crate::testing::Points;
use microsim_random::SplitMix64;

/// A motion of random features: in general position or degenerate, at any scale and place.
fn random_motion<const A: usize, const B: usize>(
    random: &mut SplitMix64,
) -> (Motion<A>, Motion<B>) {
    let points: [Vector3<f64>; 10] = random.points();
    let mut next = points.into_iter();
    let mut take = || next.next().unwrap_or_default();
    let first = Motion {
        start: std::array::from_fn(|_| take()),
        end: std::array::from_fn(|_| take()),
    };
    let second = Motion {
        start: std::array::from_fn(|_| take()),
        end: std::array::from_fn(|_| take()),
    };
    (first, second)
}

/// The slow method: the distance changes by no more than the largest relative speed, so a part of the step in whose middle it is
/// larger than that allows has no contact; others are halved until that is rounding. The first part that cannot be ruled out;
/// `Err` when too many parts were looked at.
fn slow<const A: usize, const B: usize>(
    first: &Motion<A>,
    second: &Motion<B>,
    least: f64,
    closest: &impl Fn(&[Vector3<f64>; A], &[Vector3<f64>; B]) -> Closest<A, B>,
) -> Result<Option<f64>, ()> {
    let origins = [second.start[0], second.end[0]];
    let (first, second) = (first.seen_from(&origins), second.seen_from(&origins));
    let speed = |m: &Motion<A>| {
        (0..A)
            .map(|k| (m.end[k] - m.start[k]).norm())
            .fold(0.0, f64::max)
    };
    let other = (0..B)
        .map(|k| (second.end[k] - second.start[k]).norm())
        .fold(0.0, f64::max);
    let speed = speed(&first) + other;
    let mut parts = vec![(0.0, 1.0)];
    for _ in 0..3_000 {
        let Some((from, to)) = parts.pop() else {
            return Ok(None);
        };
        let middle = 0.5 * (from + to);
        let half = 0.5 * (to - from);
        if closest(&first.at(middle), &second.at(middle)).apart.norm() > least + speed * half {
            continue;
        }
        if half < 2f64.powi(-51) {
            return Ok(Some(to));
        }
        parts.extend([(middle, to), (from, middle)]);
    }
    Err(())
}

/// 10,000 configurations of one pair of features against the slow method: no contact is missed or late, none is reported where
/// the features are further apart than the tolerance allows.
fn agree<const A: usize, const B: usize>(
    seed: u64,
    closest: impl Fn(&[Vector3<f64>; A], &[Vector3<f64>; B]) -> Closest<A, B>,
) {
    let mut random = SplitMix64(seed);
    let (mut contacts, mut undecided, mut given_up, mut total) = (0, 0, 0, 0);
    for _ in 0..10_000 {
        let (first, second) = random_motion::<A, B>(&mut random);
        let origins = [second.start[0], second.end[0]];
        let (a, b) = (first.seen_from(&origins), second.seen_from(&origins));
        let extent = a.largest().max(b.largest());
        let least = [0.0, 0.01, 0.1][random.below(3) as usize] * extent;
        let (found, steps) = search(&first, &second, least, &closest);
        total += steps;
        if let Some(found) = &found {
            contacts += 1;
            assert!((0.0..1.0).contains(&found.time));
            let gap = closest(&a.at(found.time), &b.at(found.time)).apart.norm();
            let beyond = gap > least + CONTACT_TOLERANCE * extent;
            given_up += u32::from(beyond);
            // Of two parts whose distances are equal to rounding r, about 32 half units of the extent E, the wrong one turns the direction at
            // a gap g by √(2 r / g), which costs E times that: more than g below g³ = 2 r E².
            let hidden = gap <= least + 2e-5 * extent;
            assert!(
                !beyond || hidden || steps == STEPS,
                "{found:?} {first:?} {second:?}"
            );
            assert_eq!(gap, found.gap);
            // The weights give the points whose distance it is.
            let p: Vector3<f64> = (0..A).map(|k| a.at(found.time)[k] * found.first[k]).sum();
            let q: Vector3<f64> = (0..B).map(|k| b.at(found.time)[k] * found.second[k]).sum();
            assert!(((p - q).norm() - gap).abs() < 3e-7 * extent);
            if let Some(normal) = found.normal {
                assert!((normal.norm() - 1.0).abs() < 1e-15);
            }
        }
        match slow(&first, &second, least, &closest) {
            Ok(Some(by)) => {
                let found = found.unwrap_or_else(|| panic!("missed: {first:?} {second:?} {by}"));
                assert!(
                    found.time <= by,
                    "{} > {by}: {first:?} {second:?}",
                    found.time
                );
            }
            Ok(None) => {}
            Err(()) => undecided += 1,
        }
    }
    assert!(
        contacts > 1_500 && undecided < 200,
        "{contacts} {undecided}"
    );
    // On average few steps, and an end without a contact for less than one in a thousand.
    assert!(given_up < 10 && total < 100_000, "{given_up} {total}");
}

#[test]
fn point_and_triangle_agree_with_the_slow_way() {
    agree(8, of_point_triangle);
}

#[test]
fn edges_agree_with_the_slow_way() {
    agree(9, of_edges);
}

#[test]
fn segment_and_triangle_agree_with_the_slow_way() {
    agree(10, of_segment_triangle);
}

/// A number with few bits in −1..1: sums and differences of such are exact.
fn coarse(random: &mut SplitMix64) -> Vector3<f64> {
    random.vector().map(|x| (x * 64.0).round() / 64.0)
}

/// Weights of corners with few bits, some of them 0.
fn coarse_shares<const N: usize>(random: &mut SplitMix64) -> [f64; N] {
    let mut weights = [0.0; N];
    let mut left = 8;
    for fraction in &mut weights[1..] {
        let part = random.below(left + 1);
        *fraction = part as f64 / 8.0;
        left -= part;
    }
    weights[0] = left as f64 / 8.0;
    weights
}

/// Two motions that meet exactly at the time 2⁻ᵏ, in given points of both: every number is exact, so there is a contact.
fn meeting<const A: usize, const B: usize>(random: &mut SplitMix64) -> (Motion<A>, Motion<B>, f64) {
    let power = 1 << random.below(5);
    let (first_shares, second_shares) = (coarse_shares::<A>(random), coarse_shares::<B>(random));
    let mut start_first = [0; A].map(|_| coarse(random));
    let start_second = [0; B].map(|_| coarse(random));
    let mut met_first = [0; A].map(|_| coarse(random));
    let met_second = [0; B].map(|_| coarse(random));
    if random.below(4) == 0 {
        // All in one plane, at all times.
        start_first
            .iter_mut()
            .chain(&mut met_first)
            .for_each(|p| p.z = 0.0);
    }
    let flatten = start_first.iter().all(|p| p.z == 0.0);
    let flat = |p: Vector3<f64>| {
        if flatten {
            Vector3::new(p.x, p.y, 0.0)
        } else {
            p
        }
    };
    let (start_second, met_second) = (start_second.map(flat), met_second.map(flat));
    let point = |corners: &[Vector3<f64>], weights: &[f64]| -> Vector3<f64> {
        corners.iter().zip(weights).map(|(p, s)| p * *s).sum()
    };
    let shift = point(&met_second, &second_shares) - point(&met_first, &first_shares);
    let met_first = met_first.map(|p| p + shift);
    // Where the path from the start to the meeting ends when it goes on to the end of the step.
    let end = |start: &Vector3<f64>, met: &Vector3<f64>| start + (met - start) * f64::from(power);
    let first = Motion {
        start: start_first,
        end: std::array::from_fn(|k| end(&start_first[k], &met_first[k])),
    };
    let second = Motion {
        start: start_second,
        end: std::array::from_fn(|k| end(&start_second[k], &met_second[k])),
    };
    (first, second, 1.0 / f64::from(power))
}

fn finds_meetings<const A: usize, const B: usize>(
    seed: u64,
    closest: impl Fn(&[Vector3<f64>; A], &[Vector3<f64>; B]) -> Closest<A, B>,
) {
    let mut random = SplitMix64(seed);
    for _ in 0..10_000 {
        let (first, second, time) = meeting::<A, B>(&mut random);
        let found = search(&first, &second, 0.0, &closest).0;
        let found = found.unwrap_or_else(|| panic!("missed: {first:?} {second:?} at {time}"));
        assert!(
            found.time <= time,
            "late: {first:?} {second:?}, {} > {time}",
            found.time
        );
    }
}

#[test]
fn no_exact_meeting_is_missed() {
    finds_meetings(11, of_point_triangle);
    finds_meetings(12, of_edges);
    finds_meetings(13, of_segment_triangle);
}

fn still<const N: usize>(corners: [[f64; 3]; N]) -> Motion<N> {
    moved(corners, [0.0; 3])
}

fn moved<const N: usize>(corners: [[f64; 3]; N], shift: [f64; 3]) -> Motion<N> {
    let start = corners.map(Vector3::from);
    Motion {
        start,
        end: start.map(|p| p + Vector3::from(shift)),
    }
}

/// Closed forms. A time may be early by the tolerance over the speed: the extent is at most 4, the speeds at least 1.
#[test]
fn times_of_known_contacts() {
    let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let early = 4.0 * CONTACT_TOLERANCE;
    let check = |found: Option<f64>, expected: Option<f64>| match (found, expected) {
        (Some(found), Some(expected)) => {
            assert!(
                found <= expected && found > expected - early,
                "{found} {expected}"
            );
        }
        (found, expected) => assert_eq!(found, expected),
    };
    // A point falls onto the face from either side, beside it, with a thickness of 0.25, along it, within its plane onto an edge.
    for (start, shift, distance, expected) in [
        ([0.25, 0.25, 1.0], [0.0, 0.0, -2.0], 0.0, Some(0.5)),
        ([0.25, 0.25, -1.0], [0.0, 0.0, 4.0], 0.0, Some(0.25)),
        ([0.75, 0.75, 1.0], [0.0, 0.0, -2.0], 0.0, None),
        ([0.25, 0.25, 1.0], [0.0, 0.0, -2.0], 0.25, Some(0.375)),
        ([-2.0, 0.25, 0.125], [4.0, 0.0, 0.0], 0.0, None),
        ([-2.0, 0.25, 0.0], [4.0, 0.0, 0.0], 0.0, Some(0.5)),
        ([0.25, 0.25, 0.0], [0.0, 0.0, 1.0], 0.0, Some(0.0)),
        ([0.25, 0.25, 1.0], [0.0, 0.0, 1.0], 0.0, None),
    ] {
        let found =
            first_contact_point_triangle(&moved([start], shift), &still(triangle), distance);
        check(found.map(|contact| contact.time), expected);
        if let Some(FirstContact {
            normal: Some(normal),
            ..
        }) = found
        {
            // Towards the side from which the point came.
            assert!(normal.dot(&Vector3::from(shift)) < 0.0);
        }
    }
    // Crossed edges; parallel ones; the second turns about its middle through the first's end at 45°: (1, 1) from (1, 0).
    let bar = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    let crossed = moved([[0.0, -1.0, 1.0], [0.0, 1.0, 1.0]], [0.0, 0.0, -2.0]);
    let parallel = moved([[-0.5, 0.0, 1.0], [2.0, 0.0, 1.0]], [0.0, 0.0, -4.0]);
    let edges = |a: &Motion<2>, b: &Motion<2>, distance| {
        first_contact_edges(a, b, distance).map(|c| c.time)
    };
    check(edges(&crossed, &still(bar), 0.0), Some(0.5));
    check(edges(&parallel, &still(bar), 0.5), Some(0.125));
    let turning = Motion {
        start: [Vector3::x(), -Vector3::x()],
        end: [Vector3::new(1.0, 2.0, 0.0), Vector3::new(-1.0, -2.0, 0.0)],
    };
    check(
        edges(&still([[1.0, 1.0, 0.0], [3.0, 1.0, 0.0]]), &turning, 0.0),
        Some(0.5),
    );
    // An axis of radius 0.25 comes down flat, and with an end first; a fast one passes a wall 10,000 times thinner than its path.
    let flat = moved([[-1.0, 0.25, 1.0], [1.0, 0.25, 1.0]], [0.0, 0.0, -2.0]);
    let upright = moved([[0.25, 0.25, 1.0], [0.25, 0.25, 2.0]], [0.0, 0.0, -2.0]);
    for axis in [flat, upright] {
        let found = first_contact_segment_triangle(&axis, &still(triangle), 0.25);
        check(found.map(|contact| contact.time), Some(0.375));
        assert_eq!(found.and_then(|contact| contact.normal), Some(Vector3::z()));
    }
    let fast = moved([[0.25, 0.25, 1.0], [0.25, 0.25, 2.0]], [0.0, 0.0, -1e4]);
    let found = first_contact_segment_triangle(&fast, &still(triangle), 1e-3);
    assert!(found.is_some_and(|contact| contact.time < 1e-4));
}

/// A power of two, a place and a common velocity that round nothing change no bit of the time.
#[test]
fn times_depend_on_neither_scale_nor_place_nor_common_motion() {
    let mut random = SplitMix64(14);
    let mut contacts = 0;
    for _ in 0..10_000 {
        let mut motion = || {
            let start = [0; 3].map(|_| coarse(&mut random));
            Motion {
                start,
                end: start.map(|p| p + coarse(&mut random)),
            }
        };
        let (first, second) = (motion(), motion());
        let edge = Motion {
            start: [first.start[0], first.start[1]],
            end: [first.end[0], first.end[1]],
        };
        let expected = first_contact_segment_triangle(&edge, &second, 0.125);
        contacts += u32::from(expected.is_some());
        let (place, shift) = (
            coarse(&mut random) * 1e6f64.round(),
            coarse(&mut random) * 1024.0,
        );
        let carried = |p: Vector3<f64>| p + place;
        let gone = |p: Vector3<f64>| p + place + shift;
        let found = first_contact_segment_triangle(
            &Motion {
                start: edge.start.map(carried),
                end: edge.end.map(gone),
            },
            &Motion {
                start: second.start.map(carried),
                end: second.end.map(gone),
            },
            0.125,
        );
        assert_eq!(found, expected);
        let scale = 2f64.powi(-20);
        let scaled = |p: Vector3<f64>| p * scale;
        let found = first_contact_segment_triangle(
            &Motion {
                start: edge.start.map(scaled),
                end: edge.end.map(scaled),
            },
            &Motion {
                start: second.start.map(scaled),
                end: second.end.map(scaled),
            },
            0.125 * scale,
        );
        assert_eq!(
            found.map(|c| (c.time, c.first, c.second)),
            expected.map(|c| (c.time, c.first, c.second))
        );
    }
    assert!(contacts > 1_000, "{contacts}");
}

#[test]
fn what_is_not_a_number_is_a_contact() {
    let triangle = still([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let found = first_contact_point_triangle(&still([[f64::NAN, 5.0, 5.0]]), &triangle, 0.0);
    assert!(found.is_some_and(|contact| contact.time == 0.0));
}
