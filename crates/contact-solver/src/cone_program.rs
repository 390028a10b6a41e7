//! The forces of contacts among themselves, with friction bounds that are given, by an interior-point method.
//!
//! With the Delassus operator W and the motions h of the contacts without forces, the forces p = (λ, t) of all are the lowest point of
//!
//! ```text
//! ½ pᵀ W p + h·p        λ ≥ 0        |t| ≤ b
//! ```
//!
//! where no gap is below its floor, none with a force above it, and what slides does so against its whole bound: Signorini's and Tresca's
//! conditions are those of this convex problem. With s ≥ 0 the gaps above their floors and z ≥ 0 the slip over its force,
//!
//! ```text
//! (W p + h)_n = s     (W p + h)_t = −z t     λ s = τ     z (b² − |t|²)/2 = τ
//! ```
//!
//! is solved by Newton's method while τ goes to zero, with Mehrotra's predictor and corrector (1992). It takes ten to twenty small
//! factors, however many contacts open, close, stick or slide: a method that follows these one by one takes one for each, and may cycle.

use crate::options::InteriorPointOptions;
use microsim_sparse::DenseFactor;

/// A contact among the forces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    /// The place of λ among the forces; that of t is behind it where there is friction.
    pub first: usize,
    /// b \[N\]; 0 for none.
    pub bound: f64,
    /// Whether the force across is less than the bound at the end.
    pub sticks: bool,
    /// s \[m\], z \[m/N\], and their steps.
    gap: f64,
    slip: f64,
    gap_step: f64,
    slip_step: f64,
    /// The place of λ among the unknowns.
    at: usize,
}

/// Working memory.
#[derive(Clone, Debug)]
pub(crate) struct ConeProgram {
    options: InteriorPointOptions,
    /// The direction of each unknown.
    unknowns: Vec<usize>,
    /// W of the unknowns, and with what conditions add, row after row; the factor of the latter.
    compliance: Vec<f64>,
    matrix: Vec<f64>,
    factor: DenseFactor,
    /// h, p, W p + h, and a step of p.
    base: Vec<f64>,
    forces: Vec<f64>,
    motions: Vec<f64>,
    step: Vec<f64>,
    /// Operations of the factors since they were asked for last.
    pub operations: f64,
    /// The largest motion without forces \[m\], and the largest force at the start \[N\].
    reach: f64,
    scale: f64,
}

impl Cone {
    /// With this bound \[N\].
    pub fn new(first: usize, bound: f64) -> Self {
        Self {
            first,
            bound,
            sticks: false,
            gap: 0.0,
            slip: 0.0,
            gap_step: 0.0,
            slip_step: 0.0,
            at: 0,
        }
    }

    /// (b² − |t|²)/2 \[N²\] for these forces.
    fn reserve(&self, forces: &[f64]) -> f64 {
        let [a, b] = self.across(forces);
        0.5 * (self.bound * self.bound - a * a - b * b)
    }

    /// The numbers of the two unknowns across.
    fn across(&self, numbers: &[f64]) -> [f64; 2] {
        [numbers[self.at + 1], numbers[self.at + 2]]
    }
}

impl ConeProgram {
    pub fn new(options: InteriorPointOptions) -> Self {
        Self {
            options,
            unknowns: Vec::new(),
            compliance: Vec::new(),
            matrix: Vec::new(),
            factor: DenseFactor::default(),
            base: Vec::new(),
            forces: Vec::new(),
            motions: Vec::new(),
            step: Vec::new(),
            operations: 0.0,
            reach: 0.0,
            scale: 0.0,
        }
    }

    /// Sets `forces` \[N\], which holds a guess of them, for the compliance `compliance` \[m/N\], row after row, with `regularisation` \[m/N\] that each
    /// contact has by itself, and the motions `motions` \[m\] without forces: along a normal the gap above its floor. A cone publishes what became
    /// of it. Returns whether the forces are found; if not, as where numbers are not finite, they stay the guess.
    pub fn solve(
        &mut self,
        compliance: &[f64],
        regularisation: &[f64],
        motions: &[f64],
        cones: &mut [Cone],
        forces: &mut [f64],
    ) -> bool {
        self.begin(compliance, regularisation, motions, cones, forces);
        // From a guess on the boundary iterates may stick to it.
        let found = self.iterate(cones) || {
            self.forces.fill(0.0);
            self.iterate(cones)
        };
        if found {
            self.finish(cones, forces);
        }
        found
    }

    /// Iterates from the forces as a guess; returns whether the conditions are met.
    fn iterate(&mut self, cones: &mut [Cone]) -> bool {
        self.enter(cones);
        for _ in 0..self.options.iterations {
            self.set_motions();
            if self.residual(cones) <= self.options.tolerance {
                return true;
            }
            if !self.advance(cones) {
                break;
            }
        }
        // Rounding ends some before the tolerance, as the compliances of light and heavy pieces differ by many powers of ten.
        self.set_motions();
        self.residual(cones) <= self.options.rounding
    }

    /// Takes over the part of the problem that has unknowns.
    fn begin(
        &mut self,
        compliance: &[f64],
        regularisation: &[f64],
        motions: &[f64],
        cones: &mut [Cone],
        forces: &[f64],
    ) {
        self.unknowns.clear();
        for cone in cones {
            cone.sticks = false;
            cone.at = self.unknowns.len();
            let count = if cone.bound > 0.0 { 3 } else { 1 };
            self.unknowns.extend(cone.first..cone.first + count);
        }
        let all = motions.len();
        for (part, numbers) in [(&mut self.base, motions), (&mut self.forces, forces)] {
            part.clear();
            part.extend(self.unknowns.iter().map(|k| numbers[*k]));
        }
        self.compliance.clear();
        for (row, &direction) in self.unknowns.iter().enumerate() {
            let entries = &compliance[direction * all..][..all];
            self.compliance
                .extend(self.unknowns.iter().map(|column| entries[*column]));
            let diagonal = row * self.unknowns.len() + row;
            self.compliance[diagonal] += regularisation[direction];
        }
        self.motions.resize(self.unknowns.len(), 0.0);
        self.step.resize(self.unknowns.len(), 0.0);
    }

    /// Starts inside of all conditions.
    fn enter(&mut self, cones: &mut [Cone]) {
        let count = self.unknowns.len();
        let reach = self.base.iter().fold(0.0, |most: f64, h| most.max(h.abs()));
        // Any motion at all where there is none: the forces are 0 then.
        let reach = if reach == 0.0 {
            f64::MIN_POSITIVE.sqrt()
        } else {
            reach
        };
        (self.reach, self.scale) = (reach, 0.0);
        for cone in cones {
            let own = self.compliance[cone.at * count + cone.at].max(f64::MIN_POSITIVE);
            self.forces[cone.at] = self.forces[cone.at].max(reach / own);
            self.scale = self.scale.max(self.forces[cone.at]);
            cone.gap = reach;
            if cone.bound > 0.0 {
                self.forces[cone.at + 1..cone.at + 3].fill(0.0);
                cone.slip = reach / cone.bound;
            }
        }
    }

    fn set_motions(&mut self) {
        let count = self.unknowns.len();
        self.motions.copy_from_slice(&self.base);
        for (row, force) in self.compliance.chunks_exact(count).zip(&self.forces) {
            let entries = self.motions.iter_mut().zip(row);
            entries.for_each(|(motion, entry)| *motion += entry * force);
        }
    }

    /// By how much the conditions are missed at most: displacements relative to the largest motion, products relative to those at the start.
    /// Infinite where anything is not a number.
    fn residual(&self, cones: &[Cone]) -> f64 {
        let mut worst = 0.0;
        let mut is = |missed: f64| {
            worst = match missed <= worst {
                true => worst,
                false if missed.is_nan() => f64::INFINITY,
                false => missed,
            };
        };
        for cone in cones {
            is((self.motions[cone.at] - cone.gap).abs() / self.reach);
            is(self.forces[cone.at] * cone.gap / (self.reach * self.scale));
            if cone.bound > 0.0 {
                let [a, b] = cone.across(&self.forces);
                let [x, y] = cone.across(&self.motions);
                is((x + cone.slip * a).abs() / self.reach);
                is((y + cone.slip * b).abs() / self.reach);
                is(cone.slip * cone.reserve(&self.forces) / (self.reach * cone.bound));
            }
        }
        worst
    }

    /// One step of predictor and corrector; returns whether there was one.
    fn advance(&mut self, cones: &mut [Cone]) -> bool {
        if !self.factorise(cones) {
            return false;
        }
        self.set_step(cones, 0.0, 0.0);
        let now = self.mean_product(cones, 0.0);
        let ahead = self.mean_product(cones, self.longest_step(cones));
        let centred = ahead / now;
        let target = now * centred * centred * centred;
        self.set_step(cones, target, 1.0);
        let length = (self.options.step_to_boundary * self.longest_step(cones)).min(1.0);
        if !length.is_finite() {
            return false;
        }
        for cone in cones {
            cone.gap += length * cone.gap_step;
            cone.slip += length * cone.slip_step;
        }
        for (force, step) in self.forces.iter_mut().zip(&self.step) {
            *force += length * step;
        }
        true
    }

    /// The mean of λ s and z (b² − |t|²)/2 after a step of this length.
    fn mean_product(&self, cones: &[Cone], length: f64) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        let after = |k: usize| self.forces[k] + length * self.step[k];
        for cone in cones {
            sum += after(cone.at) * (cone.gap + length * cone.gap_step);
            count += 1.0;
            if cone.bound > 0.0 {
                let (a, b) = (after(cone.at + 1), after(cone.at + 2));
                let reserve = 0.5 * (cone.bound * cone.bound - a * a - b * b);
                sum += reserve * (cone.slip + length * cone.slip_step);
                count += 1.0;
            }
        }
        sum / count
    }

    /// Pairs of an addition and a multiplication of a factor of so many unknowns, with its solutions and what is copied.
    pub fn operations_of_a_factor(count: usize) -> f64 {
        let size = count as f64;
        size * size * (size / 6.0 + 4.0)
    }

    /// Factors W + what the conditions add: s/λ along a normal, z 1 + z/w t tᵀ across it, w = (b² − |t|²)/2.
    fn factorise(&mut self, cones: &[Cone]) -> bool {
        let count = self.unknowns.len();
        self.operations += Self::operations_of_a_factor(count);
        self.matrix.clone_from(&self.compliance);
        for cone in cones {
            self.matrix[cone.at * (count + 1)] += cone.gap / self.forces[cone.at];
            if cone.bound > 0.0 {
                let t = cone.across(&self.forces);
                let more = cone.slip / cone.reserve(&self.forces);
                for (i, a) in t.into_iter().enumerate() {
                    let row = (cone.at + 1 + i) * count + cone.at + 1;
                    self.matrix[row + i] += cone.slip;
                    for (j, b) in t.into_iter().enumerate() {
                        self.matrix[row + j] += more * a * b;
                    }
                }
            }
        }
        self.factor.factorise(&self.matrix, count).is_ok()
    }

    /// Sets the step to products of `target`; with `curved` 1, that of the step before is a prediction of what is of second order.
    fn set_step(&mut self, cones: &mut [Cone], target: f64, curved: f64) {
        let Self {
            factor,
            forces,
            motions,
            step,
            ..
        } = self;
        for cone in &mut *cones {
            let along = goal_along(cone, step, target, curved);
            let mut across = 0.0;
            if cone.bound > 0.0 {
                let reserve = cone.reserve(forces);
                let (t, d, h) = (cone.across(forces), cone.across(step), cone.across(motions));
                across = goal_across(cone, &t, &d, target, curved) / reserve;
                for k in 0..2 {
                    let second = curved * cone.slip_step * d[k];
                    step[cone.at + 1 + k] = -h[k] - t[k] * across - second;
                }
            }
            step[cone.at] = along / forces[cone.at] - motions[cone.at];
            // What the conditions require, until the forces are known.
            cone.gap_step = along / forces[cone.at];
            cone.slip_step = across;
        }
        factor.solve(step);
        for cone in cones {
            let ratio = cone.gap / forces[cone.at];
            cone.gap_step -= cone.gap + ratio * step[cone.at];
            if cone.bound > 0.0 {
                let (t, d) = (cone.across(forces), cone.across(step));
                let more = cone.slip / cone.reserve(forces);
                cone.slip_step += more * (t[0] * d[0] + t[1] * d[1]) - cone.slip;
            }
        }
    }

    /// The step length at which the first condition is met with no reserve, at most 1 over [`InteriorPointOptions::step_to_boundary`].
    fn longest_step(&self, cones: &[Cone]) -> f64 {
        let mut length = 1.0 / self.options.step_to_boundary;
        let mut limit = |value: f64, step: f64| {
            if value + length * step < 0.0 {
                length = -value / step;
            }
        };
        for cone in cones {
            limit(self.forces[cone.at], self.step[cone.at]);
            limit(cone.gap, cone.gap_step);
            limit(cone.slip, cone.slip_step);
        }
        for cone in cones.iter().filter(|cone| cone.bound > 0.0) {
            // |t + α d|² = b².
            let (t, d) = (cone.across(&self.forces), cone.across(&self.step));
            let square = d[0] * d[0] + d[1] * d[1];
            let along = t[0] * d[0] + t[1] * d[1];
            let room = 2.0 * cone.reserve(&self.forces);
            if square > 0.0 {
                let root = (along * along + square * room).sqrt();
                length = length.min(room / (along + root));
            }
        }
        length
    }

    /// Gives the forces: none, all of the bound, or something between.
    fn finish(&self, cones: &mut [Cone], forces: &mut [f64]) {
        let count = self.unknowns.len();
        for cone in cones {
            let compliance_of = |k: usize| self.compliance[k * count + k];
            let force = self.forces[cone.at];
            let closed = force * compliance_of(cone.at) > cone.gap;
            forces[cone.first] = if closed { force } else { 0.0 };
            if cone.bound > 0.0 {
                let [a, b] = cone.across(&self.forces);
                let size = (a * a + b * b).sqrt();
                let compliance = compliance_of(cone.at + 1) + compliance_of(cone.at + 2);
                let reserve = cone.reserve(&self.forces) / (cone.bound * cone.bound);
                cone.sticks = cone.slip < reserve * compliance;
                let ratio = if cone.sticks || size == 0.0 {
                    1.0
                } else {
                    cone.bound / size
                };
                forces[cone.first + 1] = a * ratio;
                forces[cone.first + 2] = b * ratio;
            }
        }
    }
}

/// What λ s is to be, but for what is of second order.
fn goal_along(cone: &Cone, step: &[f64], target: f64, curved: f64) -> f64 {
    target - curved * step[cone.at] * cone.gap_step
}

/// What z (b² − |t|²)/2 is to be for these t and the step `d` of them, but for what is of second order.
fn goal_across(cone: &Cone, t: &[f64; 2], d: &[f64; 2], target: f64, curved: f64) -> f64 {
    let along = t[0] * d[0] + t[1] * d[1];
    let square = d[0] * d[0] + d[1] * d[1];
    target + curved * (cone.slip_step * along + 0.5 * cone.slip * square)
}

#[cfg(test)]
mod tests;
