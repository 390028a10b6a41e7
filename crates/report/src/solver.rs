//! How far the solver of the tissue came, over a session.

use microsim_message::SolverTick;
use serde::{Deserialize, Serialize};

/// How far the solver of the tissue came in the ticks of a session.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolverRecord {
    /// Ticks that were computed.
    pub ticks: u32,
    /// Ticks with a step that ended above the tolerance of the method.
    pub unconverged: u32,
    /// Ticks whose forces mean nothing, so that no metric took one from them.
    pub invalid: u32,
    /// Ticks in which the bodies were held at their last good state.
    pub held: u32,
    /// Ticks that could only be computed with the tools where they were before, or touching nothing.
    #[serde(default)]
    pub tools_stood: u32,
    /// Ticks whose work was bounded by their budget.
    #[serde(default)]
    pub over_budget: u32,
    /// Ticks in which two tools touched each other.
    #[serde(default)]
    pub tool_contacts: u32,
    /// Ticks that were computed again, because a body diverged or their forces meant nothing.
    pub repeated: u32,
    /// Shreds of cut tissue that were taken away so that forces mean anything.
    #[serde(default)]
    pub ruptured: u32,
    /// Iterations of all steps.
    pub iterations: u64,
    /// Halvings of iterations after which surfaces had turned too far.
    pub backtracks: u64,
    /// Iterations in which contact forces could not be found and remained those of before.
    pub contact_failures: u64,
    /// Residuals relative to the forces, of the worst step of each tick: not exceeded in half of the ticks, in 99 of 100, and in any.
    pub residual: Quantiles,
    /// The residuals themselves \[N\], with the same quantiles.
    pub force_residual: Quantiles,
    /// Multiplier residuals of contacts, relative to the mean edge length, with the same quantiles.
    pub contact_residual: Quantiles,
}

/// What is not exceeded in half of the ticks, in 99 of 100, and in any.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
    /// Median.
    pub p50: f64,
    /// 99th percentile.
    pub p99: f64,
    /// Largest value.
    pub max: f64,
}

impl Quantiles {
    fn of(mut values: Vec<f64>) -> Self {
        values.sort_unstable_by(f64::total_cmp);
        let Some(last) = values.len().checked_sub(1) else {
            return Self::default();
        };
        // Nearest rank.
        let at = |percent: usize| values[(values.len() * percent).div_ceil(100).max(1) - 1];
        Self {
            p50: at(50),
            p99: at(99),
            max: values[last],
        }
    }
}

/// Gathers what the solver publishes in every tick.
#[derive(Default)]
pub(crate) struct SolverCollector {
    record: SolverRecord,
    residuals: Vec<f64>,
    force_residuals: Vec<f64>,
    contact_residuals: Vec<f64>,
}

impl SolverCollector {
    pub fn add(&mut self, tick: &SolverTick) {
        let record = &mut self.record;
        record.ticks += 1;
        record.unconverged += u32::from(tick.unconverged > 0);
        record.invalid += u32::from(!tick.valid);
        record.held += u32::from(tick.steps == 0);
        record.tools_stood += u32::from(tick.tools_stood);
        record.over_budget += u32::from(tick.over_budget);
        record.tool_contacts += u32::from(tick.tool_contacts > 0);
        record.repeated += u32::from(tick.repetitions > 0);
        record.ruptured += tick.ruptured;
        record.iterations += u64::from(tick.iterations);
        record.backtracks += u64::from(tick.backtracks);
        record.contact_failures += u64::from(tick.contact_failures);
        if tick.steps > 0 {
            self.residuals.push(tick.residual);
            self.force_residuals.push(tick.force_residual);
            self.contact_residuals.push(tick.contact_residual);
        }
    }

    /// The record; `None` of a session without tissue, or of before the solver published anything.
    pub fn finish(mut self) -> Option<SolverRecord> {
        self.record.residual = Quantiles::of(self.residuals);
        self.record.force_residual = Quantiles::of(self.force_residuals);
        self.record.contact_residual = Quantiles::of(self.contact_residuals);
        (self.record.ticks > 0).then_some(self.record)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(residual: f64) -> SolverTick {
        SolverTick {
            steps: 2,
            unconverged: u32::from(residual > 0.5),
            iterations: 3,
            residual,
            force_residual: 1e-3 * residual,
            contact_residual: 0.0,
            backtracks: 0,
            contact_failures: 0,
            repetitions: 0,
            ruptured: 1,
            tools_stood: false,
            over_budget: false,
            tool_contacts: u32::from(residual > 150.5),
            valid: true,
        }
    }

    /// Of the residuals 1 … 200 the nearest ranks are 100 and 198.
    #[test]
    fn quantiles_are_nearest_ranks() {
        let mut collector = SolverCollector::default();
        for residual in (1..=200).rev() {
            collector.add(&tick(f64::from(residual)));
        }
        let record = collector.finish().unwrap();
        let Quantiles { p50, p99, max } = record.residual;
        assert_eq!([p50, p99, max], [100.0, 198.0, 200.0]);
        assert_eq!(
            (
                record.ticks,
                record.iterations,
                record.ruptured,
                record.tool_contacts
            ),
            (200, 600, 200, 50)
        );
    }

    #[test]
    fn held_ticks_have_no_residual_and_a_session_without_tissue_no_record() {
        assert_eq!(SolverCollector::default().finish(), None);
        let mut collector = SolverCollector::default();
        collector.add(&tick(0.25));
        collector.add(&SolverTick {
            steps: 0,
            residual: 0.0,
            valid: false,
            ..tick(0.0)
        });
        let record = collector.finish().unwrap();
        assert_eq!((record.held, record.invalid, record.unconverged), (1, 1, 0));
        assert_eq!(record.residual.p50, 0.25);
    }
}
