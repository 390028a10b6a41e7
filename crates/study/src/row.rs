//! One line of the table: a run with all its figures.

use crate::plan::RunKey;
use microsim_drawing::significant;

/// Against what an error is stated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// The closed form, or the external reference.
    Reference,
    /// The exact solution on the same mesh with the same material: what is left is the solver's own.
    SameMesh,
}

impl Against {
    /// Both, the one that matters to a user first.
    pub const ALL: [Self; 2] = [Self::Reference, Self::SameMesh];
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Status {
    /// It came to its end.
    Ok,
    /// It diverged at this simulated time \[s\].
    Diverged {
        /// Simulated time \[s\].
        time: f64,
        /// How.
        reason: String,
    },
    /// It was cut off at this simulated time \[s\].
    OverBudget {
        /// Simulated time \[s\].
        time: f64,
    },
    /// The method or the material cannot be used here.
    NotApplicable {
        /// Why.
        reason: String,
    },
}

impl Status {
    /// Its name in tables.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Diverged { .. } => "diverged",
            Self::OverBudget { .. } => "over budget",
            Self::NotApplicable { .. } => "not applicable",
        }
    }
}

/// A value with what it should be; all in SI.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// What came out; `None` where the run did not get there.
    pub value: Option<f64>,
    /// The closed form or external reference.
    pub reference: Option<f64>,
    /// The exact solution on the same mesh.
    pub exact: Option<f64>,
}

impl Measured {
    /// What the value should be.
    fn right(&self, against: Against) -> Option<f64> {
        match against {
            Against::Reference => self.reference,
            Against::SameMesh => self.exact,
        }
    }

    /// The relative error.
    pub fn error(&self, against: Against) -> Option<f64> {
        let right = self.right(against)?;
        let error = (self.value? - right).abs() / right.abs();
        error.is_finite().then_some(error)
    }
}

/// A run.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What was run.
    pub key: RunKey,
    /// Step of the solver \[s\]; NaN if the scene could not be built.
    pub step: f64,
    /// Largest number of iterations in a step, where the plan sets it.
    pub iteration_limit: Option<u32>,
    /// Number of tetrahedra.
    pub elements: usize,
    /// How it ended.
    pub status: Status,
    /// One per measure of the scene.
    pub measures: Vec<Measured>,
    /// Energy gained over the run as a fraction of the largest kinetic energy, where the energy should stay.
    pub energy_drift: Option<f64>,
    /// Simulated time \[s\].
    pub simulated: f64,
    /// CPU time \[s\].
    pub cpu: f64,
    /// Mean number of iterations in a step.
    pub iterations: Option<f64>,
}

impl Row {
    /// CPU time per simulated time; below 1 is faster than real time.
    pub fn cost(&self) -> Option<f64> {
        (self.simulated > 0.0 && self.cpu > 0.0).then(|| self.cpu / self.simulated)
    }

    /// The largest error of all measures of which the right value is known; `None` without any, and for a run that has no value
    /// for one of them.
    pub fn error(&self, against: Against) -> Option<f64> {
        if self.status != Status::Ok {
            return None;
        }
        largest_error(&self.measures, against)
    }
}

fn largest_error(measures: &[Measured], against: Against) -> Option<f64> {
    let mut largest: Option<f64> = None;
    for measure in measures.iter().filter(|m| m.right(against).is_some()) {
        let error = measure.error(against)?;
        largest = Some(error.max(largest.unwrap_or(0.0)));
    }
    largest
}

/// The runs on one mesh with one material, and their exact solution.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupResult {
    /// Which.
    pub key: crate::plan::GroupKey,
    /// Number of tetrahedra; 0 if the scene could not be built.
    pub elements: usize,
    /// The measures of the exact solution against the reference; empty where there is none.
    pub exact: Vec<Measured>,
    /// Why there is no exact solution.
    pub exact_failure: Option<String>,
    /// The runs, in the order of the plan.
    pub rows: Vec<Row>,
}

impl GroupResult {
    /// The largest error of the exact solution against the reference: what mesh and material do, whatever the solver.
    pub fn exact_error(&self) -> Option<f64> {
        largest_error(&self.exact, Against::Reference)
    }
}

/// CPU time per simulated time in words: how many times faster or slower than real time.
pub fn real_time(cost: f64) -> String {
    if cost <= 1.0 {
        format!("{}× real time", significant(1.0 / cost, 2))
    } else {
        format!("{}× too slow", significant(cost, 2))
    }
}

#[cfg(test)]
mod tests {
    use super::real_time;

    #[test]
    fn speed_in_words() {
        assert_eq!(real_time(0.125), "8.0× real time");
        assert_eq!(real_time(12.0), "12× too slow");
    }
}
