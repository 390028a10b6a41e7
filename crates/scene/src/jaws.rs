//! Jaws that cut against each other: couples of lines of no return that go on from one to the next, from the tips to the hinge.
//!
//! A place along them is the number of a couple and a parameter along its lines. Of each couple one part is closed; where the part of one goes to its end and
//! that of the next begins at its start they are one. Such a part has two ends, and what they sweep is what is cut: one sheet, whatever the
//! lines are made of.

use crate::spec::{CapsuleSpec, Jaw};
use crate::tool::Lonor;
use microsim_cutting::Sweep;
use nalgebra::Vector3;

/// Sine of the angle from which on two lines of a jaw are not one straight one: far above rounding, and a blade off by no more than a millionth of its
/// length below it.
const BENT: f64 = 1e-6;

/// A place along jaws: couple, and parameter along its lines from `a` to `b`.
type Place = (usize, f64);

/// The couples of a tool's lines, in its order.
#[derive(Clone, Debug)]
pub(crate) struct Jaws<'a>(Vec<Couple<'a>>);

/// Lines of both jaws that cut against each other.
#[derive(Clone, Copy, Debug)]
struct Couple<'a>([&'a Lonor; 2]);

/// Whether lines of both jaws can be paired: as many on the left as on the right, each going on where the one before it ends.
pub(crate) fn fit(capsules: &[CapsuleSpec]) -> bool {
    let of = |jaw| -> Vec<&CapsuleSpec> {
        let lines = capsules.iter();
        lines
            .filter(|part| part.lonor && part.jaw == Some(jaw) && part.edge.is_none())
            .collect()
    };
    let goes_on = |pair: &[&CapsuleSpec]| {
        let offset = Vector3::from(pair[1].a) - Vector3::from(pair[0].b);
        offset.norm() < pair[0].radius + pair[1].radius
    };
    let [left, right] = [of(Jaw::Left), of(Jaw::Right)];
    left.len() == right.len() && left.windows(2).chain(right.windows(2)).all(goes_on)
}

/// The parts of jaws that are closed, from those of the couples.
pub(crate) fn parts(closed: &[Option<[f64; 2]>]) -> Vec<[Place; 2]> {
    let mut parts: Vec<[Place; 2]> = Vec::new();
    for (couple, closed) in closed.iter().enumerate() {
        let Some([first, last]) = *closed else {
            continue;
        };
        match parts.last_mut() {
            Some([_, end]) if first <= 0.0 && end.0 + 1 == couple && end.1 >= 1.0 => {
                *end = (couple, last);
            }
            _ => parts.push([(couple, first), (couple, last)]),
        }
    }
    parts
}

/// The paths of the ends of all parts during a step, from the jaws as they were to those as they are: of the parts that were closed, what of these still is,
/// and those that are closed now, which hold that.
pub(crate) fn sweeps(
    jaws: &[Jaws<'_>; 2],
    [closed, still, now]: &[Vec<[Place; 2]>; 3],
) -> Vec<Sweep> {
    let mut sweeps = Vec::new();
    let mut lead = |from: Place, to: Place| {
        let is_end = |parts: &[[Place; 2]]| parts.iter().any(|part| part.contains(&from));
        // An end that goes back as the jaws open cuts nothing.
        if is_end(still) && !is_end(closed) {
            return;
        }
        // All ends sweep one sheet, so they have one positive side: as if all went to the tips.
        let is_reversed = from < to;
        let mut sweep = |from, to| {
            let mut sweep = Sweep {
                before: jaws[0].across(from),
                now: jaws[1].across(to),
            };
            if is_reversed {
                sweep.before.reverse();
                sweep.now.reverse();
            }
            sweeps.push(sweep);
        };
        // Around a bend the path is not straight: it stops there, and the bend itself is swept along with the jaws.
        let mut from = from;
        for bend in jaws[1].bends(from, to) {
            sweep(from, bend);
            sweep(bend, bend);
            from = bend;
        }
        sweep(from, to);
    };
    for &[first, last] in now {
        let within = |part: &&[Place; 2]| first <= part[0] && part[1] <= last;
        let mut held = still.iter().filter(within);
        // What closes for the first time does so from one end to the other.
        let &[start, mut end] = held.next().unwrap_or(&[first; 2]);
        lead(start, first);
        for &[next, last] in held {
            lead(end, next);
            lead(next, next);
            end = last;
        }
        lead(end, last);
    }
    sweeps
}

impl<'a> Jaws<'a> {
    /// The first line of the left jaw with the first of the right one, and so on; single edges are in no couple.
    pub fn new(lines: &'a [Lonor]) -> Self {
        let of = |jaw| {
            lines
                .iter()
                .filter(move |line| line.jaw == Some(jaw) && line.edge.is_none())
        };
        let both = of(Jaw::Left).zip(of(Jaw::Right));
        Self(both.map(|(left, right)| Couple([left, right])).collect())
    }

    /// The capsule by which they are known; `None` where there are no jaws.
    pub fn line(&self) -> Option<u32> {
        self.0.first().map(|couple| couple[0].capsule)
    }

    /// The capsules of each couple.
    pub fn capsules(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.0.iter().map(|couple| couple.0.map(|l| l.capsule))
    }

    /// The part of each couple along which the gap is below `pinch` times the sum of the radii.
    pub fn closed(&self, pinch: f64) -> Vec<Option<[f64; 2]>> {
        let couples = self.0.iter();
        couples
            .map(|couple| couple.closed_part(pinch * (couple[0].radius + couple[1].radius)))
            .collect()
    }

    /// The places between two where a line goes on in another direction, in the order of the path from the first to the second.
    fn bends(&self, from: Place, to: Place) -> Vec<Place> {
        let (first, last) = if from > to { (to, from) } else { (from, to) };
        let direction = |couple: usize, jaw: usize| {
            let line = self.0[couple][jaw];
            (line.b - line.a).normalize()
        };
        let is_bent = |couple: usize| {
            let turn = |jaw| direction(couple - 1, jaw).cross(&direction(couple, jaw));
            [0, 1].into_iter().any(|jaw| turn(jaw).norm() > BENT)
        };
        let joints = (first.0 + 1..=last.0).filter(|couple| is_bent(*couple));
        let joints = joints.map(|couple| (couple, 0.0));
        let mut bends: Vec<Place> = joints.filter(|joint| *joint != last).collect();
        if from > to {
            bends.reverse();
        }
        bends
    }

    /// The segment across both jaws at a place; closed to an end, the jaws' caps there are closed too.
    fn across(&self, (couple, along): Place) -> [Vector3<f64>; 2] {
        let segment = self.0[couple].across(along);
        let cap = if couple == 0 && along <= 0.0 {
            -1.0
        } else if couple + 1 == self.0.len() && along >= 1.0 {
            1.0
        } else {
            return segment;
        };
        [0, 1].map(|jaw| {
            let line = self.0[couple][jaw];
            // No line is without length.
            segment[jaw] + (line.b - line.a).normalize() * (cap * line.radius)
        })
    }
}

impl std::ops::Index<usize> for Couple<'_> {
    type Output = Lonor;

    fn index(&self, jaw: usize) -> &Lonor {
        self.0[jaw]
    }
}

impl Couple<'_> {
    /// The lines' points at a place along them.
    fn points(&self, along: f64) -> [Vector3<f64>; 2] {
        self.0.map(|line| line.a.lerp(&line.b, along))
    }

    /// Between the capsules at a place along them \[m\].
    fn gap(&self, along: f64) -> f64 {
        let [left, right] = self.points(along);
        (left - right).norm() - self[0].radius - self[1].radius
    }

    /// The part along which the gap is below `reach` \[m\]; `None` if it is nowhere. The distance of two points that move linearly is convex,
    /// so it is one part.
    fn closed_part(&self, reach: f64) -> Option<[f64; 2]> {
        let [left, right] = [self.points(0.0), self.points(1.0)];
        let (start, turn) = (
            left[1] - left[0],
            (right[1] - right[0]) - (left[1] - left[0]),
        );
        let square = turn.norm_squared();
        let nearest = if square > 0.0 {
            (-start.dot(&turn) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        if self.gap(nearest) >= reach {
            return None;
        }
        let bound = |end: f64| {
            if self.gap(end) < reach {
                return end;
            }
            let (mut closed, mut open) = (nearest, end);
            for _ in 0..f64::MANTISSA_DIGITS {
                let middle = 0.5 * (closed + open);
                match self.gap(middle) < reach {
                    true => closed = middle,
                    false => open = middle,
                }
            }
            closed
        };
        Some([bound(0.0), bound(1.0)])
    }

    /// The segment from beyond one line to beyond the other at a place along them: as far as their capsules reach.
    fn across(&self, along: f64) -> [Vector3<f64>; 2] {
        let [left, right] = self.points(along);
        let across = right - left;
        let length = across.norm();
        if length == 0.0 {
            return [left, right];
        }
        let across = across / length;
        [
            left - across * self[0].radius,
            right + across * self[1].radius,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Straight lines along y, 1 m long each, one behind the other, on both sides of x = 0.
    fn lines(count: usize) -> Vec<Lonor> {
        let line = |index: usize| {
            let (couple, jaw) = (index / 2, [Jaw::Left, Jaw::Right][index % 2]);
            let x = if jaw == Jaw::Left { -1e-2 } else { 1e-2 };
            Lonor {
                capsule: index as u32,
                a: Vector3::new(x, couple as f64, 0.0),
                b: Vector3::new(x, couple as f64 + 1.0, 0.0),
                radius: 1e-3,
                edge: None,
                jaw: Some(jaw),
            }
        };
        (0..2 * count).map(line).collect()
    }

    /// The paths of ends along y.
    fn paths(
        couples: usize,
        closed: &[Option<[f64; 2]>],
        still: &[Option<[f64; 2]>],
        now: &[Option<[f64; 2]>],
    ) -> Vec<[f64; 2]> {
        let lines = lines(couples);
        let jaws = [Jaws::new(&lines), Jaws::new(&lines)];
        let sweeps = sweeps(&jaws, &[closed, still, now].map(parts));
        for sweep in &sweeps {
            // From beyond one capsule to beyond the other.
            // To the hinge from right to left.
            let left = if sweep.before[0].y < sweep.now[0].y {
                1.1e-2
            } else {
                -1.1e-2
            };
            for [a, b] in [sweep.before, sweep.now] {
                assert!((a.x - left).abs() < 1e-15 && (b.x + left).abs() < 1e-15);
                assert_eq!(a.y, b.y);
            }
        }
        sweeps.iter().map(|s| [s.before[0].y, s.now[0].y]).collect()
    }

    /// Where lines meet, two closed parts are one: no end stays there, and what closes across goes from end to end.
    #[test]
    fn ends_go_on_from_one_couple_to_the_next() {
        let hinge = [None, Some([0.5, 1.0])];
        let whole = [None, Some([0.0, 1.0])];
        let both = [Some([0.75, 1.0]), Some([0.0, 1.0])];
        // Behind the hinge is a cap as thick as the line.
        let last = 2.0 + 1e-3;
        assert_eq!(
            paths(2, &[None; 2], &[None; 2], &hinge),
            [[1.5, 1.5], [1.5, last]]
        );
        assert_eq!(paths(2, &hinge, &hinge, &whole), [[1.5, 1.0], [last, last]]);
        assert_eq!(paths(2, &whole, &whole, &both), [[1.0, 0.75], [last, last]]);
        assert_eq!(paths(2, &hinge, &hinge, &both), [[1.5, 0.75], [last, last]]);
    }

    /// Of two closed parts that grow together the gap is swept by one end, and the other rests.
    #[test]
    fn parts_that_meet_sweep_what_was_between_them() {
        let apart = [Some([0.25, 0.5]), Some([0.25, 0.5])];
        let one = [Some([0.25, 1.0]), Some([0.0, 0.5])];
        let expected = [[0.25, 0.25], [0.5, 1.25], [1.25, 1.25], [1.5, 1.5]];
        assert_eq!(paths(2, &apart, &apart, &one), expected);
    }

    /// Around a bend an end passes it, in either direction, however many couples are passed in one step.
    #[test]
    fn ends_go_around_bends() {
        let mut lines = lines(3);
        for line in &mut lines {
            // Up behind the first couple.
            let place = |y: f64| if y > 1.0 { [1.0, y - 1.0] } else { [y, 0.0] };
            for end in [&mut line.a, &mut line.b] {
                [end.y, end.z] = place(end.y);
            }
        }
        let jaws = [Jaws::new(&lines), Jaws::new(&lines)];
        let paths = |still: &[Option<[f64; 2]>], now: &[Option<[f64; 2]>]| -> Vec<[[f64; 2]; 2]> {
            let sweeps = sweeps(&jaws, &[still, still, now].map(parts));
            let ends = sweeps.iter().map(|s| [s.before[0], s.now[0]]);
            ends.map(|offset| offset.map(|p| [p.y, p.z])).collect()
        };
        // From the hinge over the straight joint and the bent one.
        let hinge = [None, None, Some([0.5, 1.0])];
        let most = [Some([0.25, 1.0]), Some([0.0, 1.0]), Some([0.0, 1.0])];
        let (start, bend, end, cap) = ([1.0, 1.5], [1.0, 0.0], [0.25, 0.0], [1.0, 2.0 + 1e-3]);
        assert_eq!(
            paths(&hinge, &most),
            [[start, bend], [bend, bend], [bend, end], [cap, cap]]
        );
        // From the tips to the bend and beyond.
        let tips = [Some([0.0, 0.5]), None, None];
        let more = [Some([0.0, 1.0]), Some([0.0, 0.25]), None];
        let (tip, start, end) = ([-1e-3, 0.0], [0.5, 0.0], [1.0, 0.25]);
        assert_eq!(
            paths(&tips, &more),
            [[tip, tip], [start, bend], [bend, bend], [bend, end]]
        );
    }

    /// As jaws open an end goes back and cuts nothing on its path, nor where it comes to in that step.
    #[test]
    fn an_end_that_goes_back_sweeps_nothing() {
        let (closed, still) = ([Some([0.25, 0.75])], [Some([0.5, 0.75])]);
        assert_eq!(paths(1, &closed, &still, &still), [[0.75, 0.75]]);
    }
}
