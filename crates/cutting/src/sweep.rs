//! A blade that moves through tissue that moves: a segment against edges.
//!
//! During a step both ends of the blade's segment and all nodes move on straight lines. An edge is crossed where the two
//! segments meet: their four ends lie in one plane, which is a cubic equation in time, and there the lines meet within both.
//! This is the sheet that the blade sweeps in the frame that moves with the tissue, of each edge its own; no old blade
//! has to be carried along with tissue, and a blade at rest cuts what is pulled through it.
//!
//! Steps join: the sign at the end of a step is computed from the same numbers as that at the start of the next, zero
//! counts as positive, and what crosses twice in a step is not crossed. The blade is displaced by a fraction of 1e-9 of the mesh's edge
//! in a general direction, always the same: what touches exactly (a blade guided through nodes) is decided alike for
//! all edges at a node, instead of by rounding.

use crate::crossing::{Crossing, displacement};
use microsim_geometry::Aabb;
use nalgebra::Vector3;

/// Halvings of a bracket around a meeting: down to rounding.
const HALVINGS: usize = 60;

/// A segment that moves on straight lines during a step: the line of no return of an instrument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Its ends before the step \[m\].
    pub before: [Vector3<f64>; 2],
    /// Its ends after it \[m\].
    pub now: [Vector3<f64>; 2],
}

impl Sweep {
    /// The blade as it is tested against a mesh with this mean edge \[m\].
    pub(crate) fn displaced(&self, mean_edge: f64) -> Self {
        let by = displacement(mean_edge);
        Self {
            before: self.before.map(|p| p + by),
            now: self.now.map(|p| p + by),
        }
    }

    /// Box around all that it passes.
    pub(crate) fn bounds(&self) -> Aabb {
        Aabb::of(self.before.iter().chain(&self.now))
    }

    /// Its direction × the displacement of its middle relative to tissue that is displaced by `tissue` \[m\].
    pub(crate) fn displacement_across(&self, tissue: &Vector3<f64>) -> Vector3<f64> {
        let [before, now] = [&self.before, &self.now].map(|[a, b]| (b - a, (a + b) * 0.5));
        let direction = (before.0 + now.0).try_normalize(0.0).unwrap_or_default();
        direction.cross(&(now.1 - before.1 - tissue))
    }

    fn at(&self, time: f64) -> [Vector3<f64>; 2] {
        [0, 1].map(|k| self.before[k] + (self.now[k] - self.before[k]) * time)
    }

    /// Where the edge that moves as `edge` meets the blade.
    pub(crate) fn crossing(&self, edge: &Sweep) -> Option<Crossing> {
        let coefficients = self.coefficients(edge);
        let (least, most) = coefficients
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), &c| {
                (l.min(c), m.max(c))
            });
        // A polynomial lies between its Bernstein coefficients.
        if least >= 0.0 || most < 0.0 {
            return None;
        }
        let mut found: Option<Crossing> = None;
        let mut count = 0;
        let mut from = 0.0;
        for to in turning_points(&coefficients).into_iter().chain([1.0]) {
            if to <= from {
                continue;
            }
            if let Some(time) = root(&coefficients, from, to)
                && let Some(hit) = self.meeting(edge, time)
            {
                count += 1;
                found = found.or(Some(hit));
            }
            from = to;
        }
        found.filter(|_| count % 2 == 1)
    }

    /// Bernstein coefficients over the step of six times the volume between blade and edge.
    fn coefficients(&self, edge: &Sweep) -> [f64; 4] {
        // Direction of the blade, of the edge, and from the edge to the blade, at both ends of the step.
        let ends = [(&self.before, &edge.before), (&self.now, &edge.now)];
        let [[d0, e0, r0], [d1, e1, r1]] =
            ends.map(|(blade, edge)| [blade[1] - blade[0], edge[1] - edge[0], blade[0] - edge[0]]);
        let volume = |d: &Vector3<f64>, e: &Vector3<f64>, r: &Vector3<f64>| d.cross(e).dot(r);
        [
            volume(&d0, &e0, &r0),
            (volume(&d1, &e0, &r0) + volume(&d0, &e1, &r0) + volume(&d0, &e0, &r1)) / 3.0,
            (volume(&d0, &e1, &r1) + volume(&d1, &e0, &r1) + volume(&d1, &e1, &r0)) / 3.0,
            volume(&d1, &e1, &r1),
        ]
    }

    /// The crossing at `time`, when the lines of blade and edge meet; `None` where they meet outside one of them.
    fn meeting(&self, edge: &Sweep, time: f64) -> Option<Crossing> {
        let (blade_at, edge_at) = (self.at(time), edge.at(time));
        let d = blade_at[1] - blade_at[0];
        let e = edge_at[1] - edge_at[0];
        let r = blade_at[0] - edge_at[0];
        let across = e.cross(&d);
        let square = across.norm_squared();
        let fraction = r.cross(&d).dot(&across) / square;
        let along = r.cross(&e).dot(&across) / square;
        // Written so that what is not a number is no crossing.
        if !((0.0..=1.0).contains(&fraction) && (0.0..=1.0).contains(&along)) {
            return None;
        }
        let moved = |sweep: &Sweep, at: f64| {
            let [from, to] = [0, 1].map(|k| sweep.now[k] - sweep.before[k]);
            from + (to - from) * at
        };
        let length = d.norm();
        let unit = if length > 0.0 { d / length } else { d };
        let normal = unit.cross(&(moved(self, along) - moved(edge, fraction)));
        Some(Crossing {
            fraction,
            positive: e.dot(&normal) >= 0.0,
            is_certain: true,
            normal,
        })
    }
}

/// Value of the cubic with these Bernstein coefficients; exactly the first and last of them at 0 and 1.
fn value(c: &[f64; 4], t: f64) -> f64 {
    let s = 1.0 - t;
    s * s * s * c[0] + 3.0 * s * s * t * c[1] + 3.0 * s * t * t * c[2] + t * t * t * c[3]
}

/// Times within 0..1 at which the cubic turns round, ascending.
fn turning_points(c: &[f64; 4]) -> Vec<f64> {
    let [a, b, d] = [c[1] - c[0], c[2] - c[1], c[3] - c[2]];
    // a (1 − t)² + 2 b t (1 − t) + d t² = 0.
    let (square, linear) = (a - 2.0 * b + d, b - a);
    let under_root = linear * linear - square * a;
    if under_root < 0.0 {
        return Vec::new();
    }
    let q = -(linear + under_root.sqrt().copysign(linear));
    let mut times = vec![q / square, a / q];
    times.retain(|t| *t > 0.0 && *t < 1.0);
    times.sort_unstable_by(f64::total_cmp);
    times
}

/// The time within a part in which the cubic does not turn round and at which its sign changes.
fn root(c: &[f64; 4], mut from: f64, mut to: f64) -> Option<f64> {
    let is_positive = |t: f64| value(c, t) >= 0.0;
    let at_start = is_positive(from);
    if is_positive(to) == at_start {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        if is_positive(middle) == at_start {
            from = middle;
        } else {
            to = middle;
        }
    }
    Some(to)
}

#[cfg(test)]
mod tests;
