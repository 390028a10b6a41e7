//! Continuous collision detection: when do two moving features first come as close as a given distance?
//!
//! Corners move on straight lines in a step. While there is a direction along which all corners of one feature stay further than
//! the distance from all of the other, the features cannot be closer; along a fixed direction every corner's coordinate
//! is linear in time, so how long that lasts is a quotient. The search takes the direction of the closest points, goes to
//! the time at which it fails, and repeats there: conservative advancement (Mirtich 1996) with a bound by direction in place of one by
//! speed, which passes a slide along a surface in one step. It never goes past a contact: at every step of it the features are shown to
//! be separate until then, with the rounding of that proof on the safe side, and where it comes to no end it reports a contact.
//! No cubic equation is solved, so parallel edges, flat triangles and motion within a plane, where it degenerates, are cases like others;
//! and a minimum separation costs nothing (the two reasons for which Wang, Ferguson, Schneider, Jiang, Attene, Panozzo 2021 leave
//! root finding).
//!
//! Limitations: straight lines; the arc of a turning tool is one only in parts that are short against its radius. Features that
//! nearly roll on one another take tens of steps.

use crate::crossing::closest_segment_triangle;
use crate::segment::closest_segments;
use crate::triangle::closest_on_triangle;
use nalgebra::Vector3;

/// Features count as in contact when they are closer than the distance that is asked for plus this fraction of their extent: the
/// largest coordinate of any corner, before or after the step, from the second feature's first corner, which is taken to rest.
///
/// The direction between closest points at a gap g has an error of rounding · extent / g, which costs a bound up to the extent
/// times that: 2e-16 / 1e-6 = 2e-10 of the extent, against a gap of 1e-6 of it.
pub const CONTACT_TOLERANCE: f64 = 1e-6;

/// Along a direction a corner's coordinate is off by 4 half units of up to √3 extents (a difference, a product and two sums), the gap of
/// two corners by twice that and its own half unit, 9 units of the extent; the time at which it ends, of a change of up to
/// 4√3 extents, by 3 half units of that, 10 more.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// Steps of the search, at most. It takes this many only where features turn about one another at a gap of hardly more than the
/// tolerance: one in a thousand of the degenerate pairs of the tests.
const STEPS: usize = 1_000;

/// Corners that move on straight lines during a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<const N: usize> {
    /// The corners before the step \[m\].
    pub start: [Vector3<f64>; N],
    /// The corners after the step \[m\].
    pub end: [Vector3<f64>; N],
}

/// The first contact of two moving features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstContact<const A: usize, const B: usize> {
    /// Step fraction, 0..1. Up to here the features are further apart than the distance that was asked for; here
    /// they are closer than that plus the tolerance ([`CONTACT_TOLERANCE`]), or the search came to its end (see `gap`).
    pub time: f64,
    /// Distance of the features at that time \[m\]. It is larger than the distance that was asked for plus the tolerance only when the
    /// search took all its steps, or (up to 2e-5 of the extent) when rounding hides which parts are closest: then
    /// there may be a contact later, and none was before.
    pub gap: f64,
    /// The first feature's point of contact: weights of its corners, sum 1.
    pub first: [f64; A],
    /// The second feature's.
    pub second: [f64; B],
    /// Unit vector from the second feature to the first. `None` when they lie in one another from the start, which has no
    /// direction.
    pub normal: Option<Vector3<f64>>,
}

/// The first time at which a moving point is within `distance` \[m\] of a moving triangle; `None` when that is never in the step.
///
/// Features within the distance at the start are in contact at time 0, wherever they go. Coordinates that are no numbers
/// count as contact.
pub fn first_contact_point_triangle(
    point: &Motion<1>,
    triangle: &Motion<3>,
    distance: f64,
) -> Option<FirstContact<1, 3>> {
    search(point, triangle, distance, of_point_triangle).0
}

/// The same for two moving edges.
pub fn first_contact_edges(
    first: &Motion<2>,
    second: &Motion<2>,
    distance: f64,
) -> Option<FirstContact<2, 2>> {
    search(first, second, distance, of_edges).0
}

/// The same for a moving segment, such as a capsule's axis with its radius as the distance, and a moving triangle.
pub fn first_contact_segment_triangle(
    segment: &Motion<2>,
    triangle: &Motion<3>,
    distance: f64,
) -> Option<FirstContact<2, 3>> {
    search(segment, triangle, distance, of_segment_triangle).0
}

/// The closest points of two features at one time.
struct Closest<const A: usize, const B: usize> {
    first: [f64; A],
    second: [f64; B],
    /// From the second to the first \[m\].
    apart: Vector3<f64>,
}

fn of_point_triangle([p]: &[Vector3<f64>; 1], triangle: &[Vector3<f64>; 3]) -> Closest<1, 3> {
    let closest = closest_on_triangle(p, triangle);
    Closest {
        first: [1.0],
        second: closest.barycentric,
        apart: p - closest.point,
    }
}

fn of_edges([a0, a1]: &[Vector3<f64>; 2], [b0, b1]: &[Vector3<f64>; 2]) -> Closest<2, 2> {
    let closest = closest_segments(a0, a1, b0, b1);
    Closest {
        first: [1.0 - closest.first.t, closest.first.t],
        second: [1.0 - closest.second.t, closest.second.t],
        apart: closest.first.point - closest.second.point,
    }
}

fn of_segment_triangle([a, b]: &[Vector3<f64>; 2], triangle: &[Vector3<f64>; 3]) -> Closest<2, 3> {
    let closest = closest_segment_triangle(a, b, triangle);
    Closest {
        first: [1.0 - closest.on_segment.t, closest.on_segment.t],
        second: closest.on_triangle.barycentric,
        apart: closest.on_segment.point - closest.on_triangle.point,
    }
}

/// The first contact and the number of steps to it.
fn search<const A: usize, const B: usize>(
    first: &Motion<A>,
    second: &Motion<B>,
    distance: f64,
    closest: impl Fn(&[Vector3<f64>; A], &[Vector3<f64>; B]) -> Closest<A, B>,
) -> (Option<FirstContact<A, B>>, usize) {
    // In the frame of one corner neither the place of the scene nor a common motion has a part in rounding.
    let origins = [second.start[0], second.end[0]];
    let (first, second) = (first.seen_from(&origins), second.seen_from(&origins));
    let extent = first.largest().max(second.largest());
    let tolerance = CONTACT_TOLERANCE * extent;
    let least = distance + ROUNDING * (extent + distance);

    let (mut time, mut normal) = (0.0, None);
    for step in 1.. {
        let Closest {
            first: first_shares,
            second: second_shares,
            apart,
        } = closest(&first.at(time), &second.at(time));
        let gap = apart.norm();
        // Written so that what is not a number is a contact.
        let separate = gap > distance + tolerance;
        let next = if separate {
            separate_until(&first, &second, &(apart / gap), least, time)
        } else {
            time
        };
        if next >= 1.0 {
            return (None, step);
        }
        if gap > tolerance {
            normal = Some(apart / gap);
        }
        if next > time && step < STEPS {
            time = next;
            continue;
        }
        let contact = FirstContact {
            time,
            gap,
            first: first_shares,
            second: second_shares,
            normal,
        };
        return (Some(contact), step);
    }
    (None, STEPS)
}

/// The time from `time` on until which all corners of the first feature are further than `least` from all of the second along
/// `direction`; a time of at least 1 when they stay so for the rest of the step, `time` when they are not now.
fn separate_until<const A: usize, const B: usize>(
    first: &Motion<A>,
    second: &Motion<B>,
    direction: &Vector3<f64>,
    least: f64,
    time: f64,
) -> f64 {
    let along = |corners: &[Vector3<f64>], k: usize| corners[k].dot(direction);
    let mut until = f64::INFINITY;
    for a in 0..A {
        let first = [along(&first.start, a), along(&first.end, a)];
        for b in 0..B {
            let start = first[0] - along(&second.start, b);
            let end = first[1] - along(&second.end, b);
            if start + (end - start) * time < least {
                return time;
            }
            if end < least {
                // start > least, as the value at `time` is not below it.
                until = until.min((start - least) / (start - end));
            }
        }
    }
    until
}

impl<const N: usize> Motion<N> {
    /// The corners at a time of the step, 0..1.
    pub fn at(&self, time: f64) -> [Vector3<f64>; N] {
        std::array::from_fn(|k| self.start[k] + (self.end[k] - self.start[k]) * time)
    }

    /// The motion relative to a point that moves from the first to the second of `origins`.
    fn seen_from(&self, origins: &[Vector3<f64>; 2]) -> Self {
        Self {
            start: self.start.map(|p| p - origins[0]),
            end: self.end.map(|p| p - origins[1]),
        }
    }

    /// The largest coordinate.
    fn largest(&self) -> f64 {
        let corners = self.start.iter().chain(&self.end);
        corners.map(Vector3::amax).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests;
