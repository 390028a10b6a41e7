//! Whether the forces of a tick mean anything.

use crate::force_window::{ForceWindow, WindowTick};
use crate::jump::{JumpLimit, JumpWatch};
use crate::pairs::{Pair, PairPartner};
use crate::report::{ContactPartner, ContactReport, SolverReport};
use crate::scene::Scene;
use crate::tool::ToolMotion;
use microsim_tissue::{ResidualBounds, SolutionBounds};
use nalgebra::Vector3;

/// Up to where the forces of a tick mean something. The bounds of residuals were set before any run was judged by them but that of jumps, which replaced the tolerance
/// of the method: what was solved to 0.3 % of all forces was not taken for half a second, as the last tick before it had a smaller force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverBounds {
    /// Of residuals.
    pub residual: ResidualBounds,
    /// Multiplier residual of contacts, relative to the mean edge length. By default a tenth.
    pub contact_residual: f64,
    /// What has jumped is what the equations have as their solution where no more is left of them than this.
    pub jump: SolutionBounds,
    /// A force of a tool so many times that of the hand is one that no hand has pushed with. By default two: a hand yields a step later.
    pub hand_ratio: f64,
}

impl Default for SolverBounds {
    fn default() -> Self {
        Self {
            residual: ResidualBounds::default(),
            contact_residual: 0.1,
            jump: SolutionBounds::default(),
            hand_ratio: 2.0,
        }
    }
}

impl SolverReport {
    /// Whether the forces mean something: the residual is within its bounds, and no contact is deeper below its floor than its own.
    pub fn is_within(&self, bounds: &SolverBounds) -> bool {
        bounds.residual.hold(self.residual, self.force_residual)
            && self.contact_residual <= bounds.contact_residual
    }

    /// Whether even a force that has jumped is what the equations have as their solution.
    fn is_solved(&self, bounds: &SolverBounds) -> bool {
        let [relative, force] = [self.residual, self.force_residual];
        let is_near = bounds.jump.hold(relative, force, self.contact_residual);
        self.unconverged == 0 || is_near
    }
}

impl Scene {
    /// Whether what an attempt of a tick found means anything: its residuals are within the bounds, no hand has pushed harder than it does, and no force of a tool has
    /// jumped where a residual leaves open whether that is what the equations have as their solution.
    pub(crate) fn is_meaningful(&self, solver: &SolverReport, contacts: &[ContactReport]) -> bool {
        let bounds = SolverBounds::default();
        let of_tools = || {
            let tools = self.pair_reports(contacts);
            tools.filter(|(_, found)| matches!(found.with, ContactPartner::Tool(_)))
        };
        let is_pushed = |(_, found): (usize, &ContactReport)| {
            Vector3::from(found.force_on_tissue).norm() > bounds.hand_ratio * self.hand_force
        };
        let jumps = || {
            of_tools().any(|(pair, found)| {
                let force = Vector3::from(found.force_on_tissue).norm();
                let limit = JumpLimit::new(self.state.windows[pair].ticks.last());
                limit.is_reached(force, found.grip_n)
            })
        };
        solver.is_within(&bounds)
            && !of_tools().any(is_pushed)
            && (solver.is_solved(&bounds) || !jumps())
    }

    /// Of each pair with a tool that makes one of these motions, what its forces are held against.
    pub(crate) fn jump_watches(&self, motions: &[ToolMotion]) -> Vec<Option<JumpWatch>> {
        let watch = |(pair, window): (&Pair, &ForceWindow)| {
            let PairPartner::Tool(tool) = pair.with else {
                return None;
            };
            let motion = motions.iter().find(|motion| motion.tool == tool)?;
            Some(JumpWatch {
                limit: JumpLimit::new(window.ticks.last()),
                axis: motion.to.orientation * Vector3::x(),
                jaws: self.tools[tool].jaws(),
            })
        };
        self.pairs
            .iter()
            .zip(&self.state.windows)
            .map(watch)
            .collect()
    }

    /// Adds the forces of a tick of `length` \[s\] to the windows of their pairs, unless they mean nothing, and writes the means over these windows
    /// into the reports.
    pub(crate) fn update_windows(
        &mut self,
        contacts: &mut [ContactReport],
        length: f64,
        valid: bool,
    ) {
        let mut windows = std::mem::take(&mut self.state.windows);
        if valid {
            let mut forces = vec![(Vector3::zeros(), 0.0); windows.len()];
            for (pair, found) in self.pair_reports(contacts) {
                forces[pair] = match found.with {
                    // Forces of a body on itself have no direction.
                    ContactPartner::Itself => (Vector3::x() * (found.impulse_ns / length), 0.0),
                    _ => (Vector3::from(found.force_on_tissue), found.grip_n),
                };
            }
            for (window, (force, grip)) in windows.iter_mut().zip(forces) {
                window.push(WindowTick {
                    length,
                    force,
                    grip,
                });
            }
        }
        let pairs: Vec<usize> = self.pair_reports(contacts).map(|(pair, _)| pair).collect();
        for (found, pair) in contacts.iter_mut().zip(pairs) {
            (found.sustained_force_n, found.sustained_grip_n) = windows[pair].mean();
            let over = found.sustained_force_n > self.pairs[pair].force_limit;
            found.over_limit_s = if over && valid { length } else { 0.0 };
        }
        self.state.windows = windows;
    }

    /// Reports, which come in the order of the pairs, with the indices of these.
    fn pair_reports<'a>(
        &'a self,
        contacts: &'a [ContactReport],
    ) -> impl Iterator<Item = (usize, &'a ContactReport)> {
        let mut pairs = 0..self.pairs.len();
        contacts.iter().filter_map(move |found| {
            let pair = pairs.find(|pair| self.pair(*pair) == (found.body, found.with))?;
            Some((pair, found))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Large forces are judged by the relative residual, small ones by the residual itself, and what is not finite by neither.
    #[test]
    fn forces_mean_something_within_the_bounds() {
        let bounds = SolverBounds::default();
        let within = |residual: f64, force_residual: f64, contact_residual: f64| {
            let report = SolverReport {
                residual,
                force_residual,
                contact_residual,
                ..SolverReport::default()
            };
            report.is_within(&bounds)
        };
        assert!(within(0.05, 0.1, 0.0) && within(0.9, 1e-4, 0.0));
        assert!(!within(0.2, 2e-3, 0.0) && !within(0.05, 1e-4, 0.2));
        assert!(!within(f64::NAN, f64::NAN, 0.0) && !within(0.0, 0.0, f64::NAN));
    }

    /// A jump counts with residuals of a hundredth and 3 mN, or of any size to which the method was to converge.
    #[test]
    fn what_has_jumped_is_to_be_solved() {
        let bounds = SolverBounds::default();
        let solved =
            |unconverged: u32, residual: f64, force_residual: f64, contact_residual: f64| {
                let report = SolverReport {
                    unconverged,
                    residual,
                    force_residual,
                    contact_residual,
                    ..SolverReport::default()
                };
                report.is_solved(&bounds)
            };
        assert!(solved(1, 0.01, 3e-3, 0.01) && solved(0, 0.05, 0.1, 0.05));
        assert!(!solved(1, 0.011, 0.0, 0.0) && !solved(1, f64::NAN, 0.0, 0.0));
        assert!(!solved(1, 0.0, 3.1e-3, 0.0) && !solved(1, 0.0, 0.0, 0.011));
    }
}
