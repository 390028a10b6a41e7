//! The iteration of Newton's method.

use super::equation::{Equation, EquationContact, Problem};
use super::line_search::LineSearchOutcome;
use super::options::Newton;
use super::workspace::NewtonSolver;
use crate::elements::Tangent;
use crate::executor::Executor;
use crate::model::TissueModel;
use crate::solver::{StepFailure, StepReport};
use crate::state::Control;
use microsim_contact_solver::Tolerances;
use nalgebra::Vector3;

impl NewtonSolver {
    /// Solves an equation from the best one of these guesses; `ends` are the places of the nodes marked in `fixed`. The solution
    /// is in `trial`, with the velocities of the equation.
    #[expect(clippy::too_many_arguments, reason = "the types of a step stay apart")]
    pub fn solve(
        &mut self,
        model: &TissueModel,
        control: &Control,
        equation: &Equation,
        fixed: &[bool],
        ends: &[Vector3<f64>],
        guesses: &[&[Vector3<f64>]],
        mut contact: Option<EquationContact<'_>>,
        newton: &Newton,
        exec: &dyn Executor,
    ) -> Result<StepReport, StepFailure> {
        let problem = Problem {
            model,
            control,
            equation,
            fixed,
            exec,
        };
        let options = self.options;
        self.start(&problem, guesses);
        self.searches = 0;
        self.backtracks = 0;
        self.forget_operations();
        self.work = 0.0;
        self.allowed_work = match newton.must_converge {
            true => f64::INFINITY,
            false => self.most_work,
        };
        self.contacts.failures = 0;
        self.contacts.prefers_interior_point =
            equation.rate > 0.0 && !newton.must_converge && !self.effort.augmented_lagrangian;
        self.find(&problem, contact.as_mut());
        let may_end_early = !newton.must_converge && equation.rate > 0.0;
        let moves_on = contact.as_ref().is_some_and(|of| of.source.moves_on());
        if may_end_early && moves_on && !self.contacts.is_empty() {
            for guess in guesses {
                self.start_in_contact(&problem, guess, contact.as_mut());
            }
        }
        if self.contacts.is_empty() && fixed.iter().all(|fixed| *fixed) {
            // No equation for any node.
            self.place(&problem, ends);
            let residual = self.evaluate(&problem, 0.0);
            self.publish(&problem);
            return Ok(StepReport {
                residual,
                ..StepReport::without_residual(0)
            });
        }
        let tolerances = Tolerances {
            residual: newton.tolerance,
            changes: match newton.must_converge {
                true => 0.0,
                false => options.contact.friction_tolerance,
            },
            multipliers: options.contact.multiplier_tolerances[usize::from(!newton.must_converge)],
        };
        let mut report = StepReport {
            residual: self.evaluate(&problem, 0.0),
            ..StepReport::without_residual(0)
        };
        // In statics a body that has come to rest takes no work; a step of time always has its iteration.
        let moved = |node: usize| ends[node] != self.trial.positions[node];
        if equation.rate == 0.0
            && report.residual <= newton.tolerance.min(options.rest_tolerance)
            && self.contacts.multiplier_residual() <= tolerances.multipliers
            && !(0..fixed.len()).any(|node| fixed[node] && moved(node))
        {
            report.force_residual = self.force_residual;
            report.contact_residual = self.contacts.multiplier_residual();
            self.publish(&problem);
            return Ok(report);
        }
        (self.retains_matrix, self.has_bare_factor) = (false, false);
        report.converged = false;
        let mut tangent = Tangent::Exact;
        let (mut least, mut least_force, mut stagnated) = (f64::INFINITY, f64::INFINITY, 0);
        let most = newton.iterations.saturating_mul(self.effort.iterations);
        // Where hardly any force is left, the residual relative to them is no measure.
        let least_scale = match may_end_early {
            true => options.least_scale,
            false => 0.0,
        };
        let more = most.saturating_add(options.contact.more_iterations);
        while report.iterations < most
            || report.iterations < more
                && (self.needs_more(&report, may_end_early)
                    || may_end_early && self.has_unsolved_jump(&report, contact.as_ref()))
        {
            // What must converge fails if it is cut short, and takes more in the end.
            if report.iterations > 0 && self.work >= self.allowed_work {
                report.is_cut_short = true;
                break;
            }
            report.iterations += 1;
            if !report.residual.is_finite() {
                return Err(StepFailure::NotFinite);
            }
            self.from.copy_from_slice(&self.trial.positions);
            self.set_loads(&problem);
            let before = report.residual;
            let early = self.takes_interior_point();
            if early {
                tangent = Tangent::Positive;
            }
            let mut outcome = self.iterate(&problem, ends, &mut tangent, before, tolerances)?;
            match &mut outcome {
                LineSearchOutcome::Step { length, is_full } => {
                    let ahead = self.find_ahead(&problem, contact.as_mut(), *length);
                    *is_full &= ahead == *length;
                }
                LineSearchOutcome::Prescribed | LineSearchOutcome::NoDescent => {
                    self.find(&problem, contact.as_mut());
                }
            }
            self.count_iteration();
            report.work = self.work;
            report.residual = self.evaluate(&problem, self.noise(fixed));
            report.force_residual = self.force_residual;
            report.contact_residual = self.contacts.multiplier_residual();
            report.backtracks = self.backtracks;
            report.contact_failures = self.contacts.failures;
            let enough = report.residual <= newton.tolerance
                || report.force_residual <= newton.tolerance * least_scale;
            if enough
                && report.residual.is_finite()
                && report.contact_residual <= tolerances.multipliers
            {
                report.converged = true;
                self.publish(&problem);
                return Ok(report);
            }
            let full = matches!(outcome, LineSearchOutcome::Step { is_full: true, .. });
            let full_early = full && early && self.takes_interior_point();
            // Where forces are small the residual relative to them means little.
            let overlaps = self.contacts.overlap() > options.contact.overlap;
            let admissible = report.residual.is_finite() && !overlaps;
            if full_early
                && admissible
                && self.is_short(options.contact.still)
                && !self.has_unsolved_jump(&report, contact.as_ref())
            {
                self.publish(&problem);
                return Ok(report);
            }
            self.retains_matrix = full_early && self.is_short(options.contact.short);
            // What means nothing yet goes on as long as it falls noticeably.
            let decrease = match may_end_early && self.means_nothing(&report) {
                true => options.slow_decrease,
                false => options.decrease,
            };
            let falls = report.residual < decrease * least
                || (may_end_early && report.force_residual < decrease * least_force);
            stagnated = if falls { 0 } else { stagnated + 1 };
            least = least.min(report.residual);
            least_force = least_force.min(report.force_residual);
            let stagnates = stagnated >= options.stagnation;
            if stagnates && self.takes_interior_point() && !overlaps {
                break;
            }
            if outcome == LineSearchOutcome::NoDescent {
                break;
            }
            if full && report.residual < options.decrease * before {
                tangent = Tangent::Exact;
            }
        }
        if !report.residual.is_finite() {
            return Err(StepFailure::NotFinite);
        }
        let enough = match self.contacts.is_empty() {
            true => newton.tolerance,
            false => options.stagnated_tolerance * newton.tolerance,
        };
        if newton.must_converge && report.residual > enough {
            return Err(StepFailure::NotConverged {
                iterations: report.iterations,
                residual: report.residual,
            });
        }
        self.publish(&problem);
        Ok(report)
    }

    /// Whether overlaps, or in a step that `may_end_early` forces that mean nothing, take more iterations than were asked for.
    fn needs_more(&self, report: &StepReport, may_end_early: bool) -> bool {
        let options = &self.options.contact;
        self.contacts.overlap() > options.overlap || may_end_early && self.means_nothing(report)
    }

    /// Whether a force of contact has jumped, and the step would end with one that the equation does not have as its solution.
    fn has_unsolved_jump(
        &mut self,
        report: &StepReport,
        contact: Option<&EquationContact<'_>>,
    ) -> bool {
        let bounds = &self.options.contact.jump;
        let [relative, force] = [report.residual, report.force_residual];
        if bounds.hold(relative, force, report.contact_residual) {
            return false;
        }
        // With the friction that it would end with.
        self.contacts.publish();
        contact.is_some_and(|of| of.source.has_jumped(&self.contacts.contacts))
    }

    /// Whether the forces of an early-terminated step would mean nothing if it ended here.
    fn means_nothing(&self, report: &StepReport) -> bool {
        let bounds = &self.options.contact.residual;
        !bounds.hold(report.residual, report.force_residual)
    }

    /// Makes one iteration from `trial`, whose residual is `residual` relative to the forces: with the matrix asked for in `tangent`, or with
    /// the positive one where that is indefinite or its direction does not descend. `tangent` becomes the one that was used.
    fn iterate(
        &mut self,
        problem: &Problem<'_>,
        ends: &[Vector3<f64>],
        tangent: &mut Tangent,
        residual: f64,
        tolerances: Tolerances,
    ) -> Result<LineSearchOutcome, StepFailure> {
        let [least, largest] = self.options.linear_tolerances;
        let inexact = self.options.linear_inexactness * tolerances.residual / residual;
        let tolerances = Tolerances {
            residual: inexact.clamp(least, largest),
            ..tolerances
        };
        loop {
            let exact = *tangent == Tangent::Exact;
            let moves = self.prescribe(problem.fixed, ends);
            let failures = self.contacts.failures;
            let direction = self
                .factorise(problem, *tangent)
                .and_then(|()| self.set_direction(problem.fixed, moves, tolerances));
            match direction {
                Ok(()) if moves => {
                    self.follow_prescribed(problem, ends);
                    return Ok(LineSearchOutcome::Prescribed);
                }
                Ok(()) => {
                    // A curved path would not enforce non-penetration.
                    let far = residual >= self.options.second_order.least_residual;
                    self.set_second_order(problem, exact && far && self.contacts.is_empty());
                    let first = match self.contacts.failures > failures {
                        true => (self.options.contact.without_forces / self.reach()).min(1.0),
                        false => 1.0,
                    };
                    let outcome = self.search(problem, first);
                    if outcome != LineSearchOutcome::NoDescent || (!exact && !self.retains_matrix) {
                        return Ok(outcome);
                    }
                    self.evaluate(problem, 0.0);
                }
                Err(_) if exact || self.retains_matrix => {}
                Err(failure) => return Err(self.why_not_positive(failure)),
            }
            *tangent = Tangent::Positive;
            self.retains_matrix = false;
        }
    }
}
