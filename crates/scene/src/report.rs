//! What a tick tells.

use crate::containment::Divergence;

/// The report of one tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TickReport {
    /// One entry per contact pair that touched, in the order of the scene's pairs.
    pub contacts: Vec<ContactReport>,
    /// By how much the solver's step was divided so that no tool moves too far in one: 1 when it was not.
    pub substeps: u32,
    /// Whether a tool was so fast that more sub-steps than the limit were needed; it may then have passed through tissue.
    pub capped: bool,
    /// Whether plastic flow has made a body so stiff that it needs more steps than were asked for.
    pub stiffened: bool,
    /// Ticks that had to be repeated with more sub-steps.
    pub recoveries: Vec<Recovery>,
    /// Indices of motions that were left out: unknown tool, a second motion of one tool, or a number that is not finite.
    pub invalid_motions: Vec<usize>,
}

/// What one tool did to one body in a tick.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactReport {
    /// Index of the tool.
    pub tool: usize,
    /// Index of the body.
    pub body: usize,
    /// Force of the tool on the tissue, mean over the tick, in the world [N].
    pub force_on_tissue: [f64; 3],
    /// Largest size of the force in a solver's step [N]. A landing acts over one step: its peak grows as steps get shorter.
    pub peak_force_n: f64,
    /// Integral of the size of the force over the tick [N·s].
    pub impulse_ns: f64,
    /// Where the force acts, in the world: mean of the touched nodes' positions, weighted by their forces [m].
    pub point: [f64; 3],
    /// Depth of the deepest surface point that was still inside the tool after a step [m].
    pub max_depth_m: f64,
    /// Largest displacement of a touched node from its rest position along the mean force, at the end of the tick [m].
    pub indentation_m: f64,
    /// Number of different nodes that were touched.
    pub nodes: usize,
}

/// A tick that was repeated because a body diverged.
#[derive(Clone, Debug, PartialEq)]
pub struct Recovery {
    /// Index of the body that diverged.
    pub body: usize,
    /// How.
    pub what: Divergence,
    /// By how much the steps were divided in the next try: 2, 4 or 8.
    pub factor: u32,
}
