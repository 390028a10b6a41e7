//! How a body diverges, and the error of a tick that cannot be recovered from it.

use crate::cut_report::CutReport;
use microsim_tissue::StepFailure;

/// How a body diverged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Divergence {
    /// A number is not finite.
    NotFinite,
    /// The energy grew by more than gravity and tools can explain.
    EnergyGrowth,
    /// An element is inverted beyond recovery.
    Inversion,
    /// A node is further away than anything that holds together could be.
    Escape,
    /// A point of contact presses harder than anything of its stiffness could be pressed.
    Overpressed,
    /// It has stiffened as it stretched, so that the step has become too long.
    Stiffened {
        /// The longest step with safety factor as it is now \[s\].
        longest_step_s: f64,
    },
    /// The solver could not make a step.
    Step(StepFailure),
}

/// A body that diverged, whatever the sub-steps. The scene is at the start of the tick, its last good state.
#[derive(Clone, Debug, PartialEq)]
pub struct Diverged {
    /// Index of the body.
    pub body: usize,
    /// Name of the body.
    pub body_name: String,
    /// The step of the last try at which it was found; one beyond the last when at the end of the tick.
    pub step: u32,
    /// Simulated time of it \[s\].
    pub time: f64,
    /// How.
    pub what: Divergence,
    /// How often the tick was computed again.
    pub repetitions: u32,
    /// Shreds that were taken away meanwhile, and remain so.
    pub ruptured: u32,
    /// What these laid open.
    pub cuts: Vec<CutReport>,
}

impl Divergence {
    /// Whether it is only that an implicit step did not converge: what there was is as good as before.
    pub fn is_unconverged(&self) -> bool {
        matches!(self, Self::Step(StepFailure::NotConverged { .. }))
    }
}

impl std::fmt::Display for Divergence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Divergence::NotFinite => f.write_str("has numbers that are not finite"),
            Divergence::EnergyGrowth => f.write_str("gains energy without cause"),
            Divergence::Escape => f.write_str("has a node that flew away"),
            Divergence::Overpressed => f.write_str("is pressed harder than its material allows"),
            Divergence::Inversion => f.write_str("has an element inverted beyond recovery"),
            Divergence::Stiffened { longest_step_s } => write!(
                f,
                "has stiffened as it stretched, and allows steps of {:.3} us only",
                longest_step_s * 1e6
            ),
            Divergence::Step(failure) => write!(f, "cannot be advanced: {failure}"),
        }
    }
}

impl std::fmt::Display for Diverged {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let what = self.what;
        write!(
            f,
            "body '{}' {what} at {:.6} s, step {} of the tick",
            self.body_name, self.time, self.step
        )
    }
}

impl std::error::Error for Diverged {}
