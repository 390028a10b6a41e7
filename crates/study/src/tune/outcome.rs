//! What tuning does and finds: trials, and the one that was chosen.

use std::fmt::Write;

/// What `tune` does.
#[derive(Clone, Copy, Debug)]
pub enum TuneStep<'a> {
    /// A computation begins that may take long.
    Begins(&'a str),
    /// A trial is done.
    Done(&'a Trial),
    /// This part of what may have to be tried is over, by number: what it costs is known afterwards only.
    Over(f64),
}

/// A run that was tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Mesh, elements, method, parameters in words.
    pub description: String,
    /// Method with elements: what sentences are about.
    pub kind: String,
    /// Overrides of the file, the step not among them.
    pub overrides: Vec<String>,
    /// Name of the method in files.
    pub method: String,
    /// Step \[s\].
    pub step: f64,
    /// Number of tetrahedra.
    pub elements: usize,
    /// Relative error.
    pub error: Option<f64>,
    /// Cost, in the unit of the goal.
    pub cost: Option<f64>,
    /// Largest multiple of the step at which it was seen to be stable.
    pub margin: Option<f64>,
    /// Why it was rejected; `None` for the one that was chosen.
    pub rejected: Option<String>,
}

/// What came out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tuning {
    /// All runs, in the order in which they were tried.
    pub trials: Vec<Trial>,
    /// Index of the chosen one.
    pub chosen: Option<usize>,
    /// Values of the exact solution on a fine mesh, where they were the measure; else empty.
    pub measure: Vec<f64>,
    /// How far that measure may be off: the largest relative difference to a mesh of two thirds of its cells.
    pub doubt: Option<f64>,
    /// Error of linear tetrahedra on the chosen mesh.
    pub locking: Option<f64>,
    /// Why there is nothing to compare with.
    pub no_measure: Option<String>,
}

impl Tuning {
    /// The chosen run.
    pub fn choice(&self) -> Option<&Trial> {
        Some(&self.trials[self.chosen?])
    }

    /// Why the others were rejected: a sentence for each method with its elements, about its best run.
    pub fn sentences(&self) -> Vec<String> {
        let mut kinds: Vec<&str> = Vec::new();
        for trial in &self.trials {
            if !kinds.contains(&trial.kind.as_str()) {
                kinds.push(&trial.kind);
            }
        }
        let sentence = |kind: &&str| {
            let of = || {
                self.trials
                    .iter()
                    .filter(|t| t.kind == **kind && t.rejected.is_some())
            };
            // The one that came nearest: it met the error at the least cost, or had the least error.
            let rank = |t: &&Trial| {
                (
                    t.error.unwrap_or(f64::INFINITY),
                    t.cost.unwrap_or(f64::INFINITY),
                )
            };
            let best = of().min_by(|a, b| {
                let (a, b) = (rank(a), rank(b));
                a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
            })?;
            let reason = best.rejected.as_deref()?;
            let others = of().count() - 1;
            let mut text = format!("{}: {reason}", best.description);
            if others > 0 {
                let _ = write!(text, " (the nearest of {} runs)", others + 1);
            }
            Some(text)
        };
        kinds.iter().filter_map(sentence).collect()
    }
}
