//! What the tools did to the tissue.

use microsim_message::{ContactForces, SolverTick};
use serde::{Deserialize, Serialize};

/// Force of one tool on one body: lists of equal length, one entry for each tick in contact.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ForceSeries {
    /// Tool slot of the level.
    pub tool: String,
    /// Body.
    pub body: String,
    /// Simulated time since the session began \[s\].
    pub time: Vec<f64>,
    /// Number of the contact, from 0; between two contacts there is at least one tick without.
    pub contact: Vec<u32>,
    /// Whether the forces of the tick mean anything; no metric takes others, and plots leave them out. True in sessions without this record.
    pub valid: Vec<bool>,
    /// Magnitude of the force, mean over the tick \[N\].
    pub force: Vec<f64>,
    /// Largest magnitude within the tick \[N\].
    pub peak: Vec<f64>,
    /// Size of the mean force over the last 50 ms, which metrics take \[N\]; zeros in sessions of before.
    pub sustained: Vec<f64>,
    /// The grip: force with which both jaws squeeze the tissue between them, mean over the tick \[N\].
    pub grip: Vec<f64>,
    /// Deepest penetration that was left after a step \[m\].
    pub depth: Vec<f64>,
    /// Largest displacement of a touched node from its rest position along the force \[m\].
    pub indentation: Vec<f64>,
}

impl ForceSeries {
    /// Those of the ticks whose forces mean anything.
    pub fn meaningful(&self) -> Self {
        let mut all = Self {
            tool: self.tool.clone(),
            body: self.body.clone(),
            ..Self::default()
        };
        for (k, valid) in self.valid.iter().enumerate() {
            if *valid {
                all.time.push(self.time[k]);
                all.contact.push(self.contact[k]);
                all.valid.push(true);
                all.force.push(self.force[k]);
                all.peak.push(self.peak[k]);
                all.sustained.push(self.sustained[k]);
                all.grip.push(self.grip[k]);
                all.depth.push(self.depth[k]);
                all.indentation.push(self.indentation[k]);
            }
        }
        all
    }

    /// Whether the session has forces on the time scale of a hand.
    pub fn has_sustained(&self) -> bool {
        self.sustained.iter().any(|force| *force > 0.0)
    }
}

/// Gathers the contacts of each pair, pairs in the order of their first contact.
#[derive(Default)]
pub(crate) struct ForceCollector {
    /// Each pair with the tick of its last entry.
    pairs: Vec<(ForceSeries, u64)>,
    /// The last tick whose forces mean nothing.
    invalid: Option<u64>,
}

impl ForceCollector {
    /// Takes over whether the forces of a tick, which come after, mean anything.
    pub fn add_tick(&mut self, tick: u64, solver: &SolverTick) {
        if !solver.valid {
            self.invalid = Some(tick);
        }
    }

    pub fn add(&mut self, tick: u64, now: f64, forces: ContactForces) {
        for contact in forces.contacts {
            let same =
                |(s, _): &(ForceSeries, u64)| s.tool == contact.partner && s.body == contact.body;
            let at = match self.pairs.iter().position(same) {
                Some(at) => at,
                None => {
                    let series = ForceSeries {
                        tool: contact.partner,
                        body: contact.body,
                        ..ForceSeries::default()
                    };
                    self.pairs.push((series, tick));
                    self.pairs.len() - 1
                }
            };
            let (series, last) = &mut self.pairs[at];
            let number = series.contact.last().copied().unwrap_or(0);
            let [x, y, z] = contact.force;
            series.time.push(now);
            series.valid.push(self.invalid != Some(tick));
            series
                .contact
                .push(number + u32::from(tick > last.saturating_add(1)));
            series.force.push((x * x + y * y + z * z).sqrt());
            series.peak.push(contact.peak_force);
            series.grip.push(contact.grip_force);
            series.sustained.push(contact.sustained_force);
            series.depth.push(contact.depth);
            series.indentation.push(contact.indentation);
            *last = tick;
        }
    }

    pub fn finish(self) -> Vec<ForceSeries> {
        self.pairs.into_iter().map(|(series, _)| series).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::Report;
    use crate::testing::{contact, input, log};
    use microsim_message::{ContactForces, SolverTick};

    /// Forces (3, 4, 0) and (0, 0, 2) have the magnitudes 5 and 2; ticks 2 and 3 are one contact, tick 5 is another.
    #[test]
    fn contacts_of_a_pair_are_numbered() {
        let forces = |force| {
            log(&[&ContactForces {
                contacts: vec![contact("right", "strip", force)],
                ..ContactForces::default()
            }])
        };
        let logs = [
            (2, forces([3.0, 4.0, 0.0])),
            (3, forces([0.0, 0.0, 2.0])),
            (4, log(&[&ContactForces::default()])),
            (5, forces([0.0, 0.0, 2.0])),
        ];
        let report = Report::build(&input(), logs.iter().map(|(tick, log)| (*tick, &log[..])));
        let [series] = &report.forces[..] else {
            panic!("{:?}", report.forces)
        };
        assert_eq!(series.force, [5.0, 2.0, 2.0]);
        assert_eq!(series.contact, [0, 0, 1]);
        assert_eq!(series.valid, [true; 3]);
        assert_eq!(series.meaningful(), *series);
        assert_eq!(series.time, [0.25, 0.375, 0.625]);
    }

    /// Of three ticks in contact the second means nothing.
    #[test]
    fn ticks_that_mean_nothing_are_marked() {
        let tick = |force, valid| {
            log(&[
                &SolverTick {
                    valid,
                    ..crate::testing::solver_tick()
                },
                &ContactForces {
                    contacts: vec![contact("right", "strip", force)],
                    ..ContactForces::default()
                },
            ])
        };
        let logs = [
            (2, tick([0.0, 0.0, 1.0], true)),
            (3, tick([0.0, 0.0, 70.0], false)),
            (4, tick([0.0, 0.0, 2.0], true)),
        ];
        let report = Report::build(&input(), logs.iter().map(|(tick, log)| (*tick, &log[..])));
        let [series] = &report.forces[..] else {
            panic!("{:?}", report.forces)
        };
        assert_eq!(series.force, [1.0, 70.0, 2.0]);
        assert_eq!(series.valid, [true, false, true]);
        assert_eq!(series.meaningful().force, [1.0, 2.0]);
    }
}
