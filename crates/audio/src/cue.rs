//! Which messages of a run have which tone.

use crate::tone::Tone;
use microsim_message::{ContactForces, TissueCut};
use std::collections::BTreeMap;

/// A tool that was off the tissue for longer touches it again \[s\]: below it a touch that trembles would rattle.
const APART: f64 = 0.2;
/// Cuts and tears go on from tick to tick; so long after the last tone they have the next one \[s\].
const APART_CUTS: f64 = 0.15;

/// Finds what is to be played, from the messages of a run in their order.
#[derive(Clone, Debug, Default)]
pub struct Cues {
    /// Largest force of the level \[N\], beside those of its pairs.
    limit: Option<f64>,
    /// When each tool touched each body last \[s\].
    touched: BTreeMap<(String, String), f64>,
    /// When each tool cut last, and tissue tore (without a tool) \[s\].
    cut: BTreeMap<String, f64>,
}

impl Cues {
    /// For a level whose forces are to be below a limit \[N\], or only below those of its pairs.
    pub fn new(limit: Option<f64>) -> Self {
        Self {
            limit,
            ..Self::default()
        }
    }

    /// Of forces at a time of the run \[s\].
    pub fn of_forces(&mut self, forces: &ContactForces, time: f64) -> Vec<Tone> {
        let mut tones = Vec::new();
        for contact in &forces.contacts {
            let size = contact.force.iter().map(|f| f * f).sum::<f64>().sqrt();
            if size > 0.0 {
                let pair = (contact.partner.clone(), contact.body.clone());
                let before = self.touched.insert(pair, time);
                if before.is_none_or(|before| time - before > APART) {
                    tones.push(Tone::Touch);
                }
            }
            let is_above = self
                .limit
                .is_some_and(|most| contact.sustained_force > most);
            if contact.time_over_limit > 0.0 || is_above {
                tones.push(Tone::Warning);
            }
        }
        tones.sort_unstable();
        tones.dedup();
        tones
    }

    /// Of tissue that came apart at a time of the run \[s\].
    pub fn of_cut(&mut self, cut: &TissueCut, time: f64) -> Option<Tone> {
        let before = self.cut.get(&cut.tool);
        if before.is_some_and(|before| time - before <= APART_CUTS) {
            return None;
        }
        self.cut.insert(cut.tool.clone(), time);
        Some(match cut.tool.is_empty() {
            true => Tone::Tear,
            false => Tone::Cut,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_message::ContactForce;

    fn contact(partner: &str, newtons: f64, sustained: f64, over: f64) -> ContactForce {
        ContactForce {
            partner: partner.into(),
            body: "strip".into(),
            force: [0.0, 0.0, -newtons],
            sustained_force: sustained,
            time_over_limit: over,
            ..ContactForce::default()
        }
    }

    fn forces(contacts: Vec<ContactForce>) -> ContactForces {
        ContactForces {
            contacts,
            between: Vec::new(),
        }
    }

    #[test]
    fn the_first_touch_ticks_and_a_trembling_one_does_not_rattle() {
        let mut cues = Cues::default();
        let touch = forces(vec![contact("left", 1e-3, 1e-3, 0.0)]);
        let mut at = |forces: &ContactForces, time| cues.of_forces(forces, time);
        assert_eq!(at(&forces(vec![contact("left", 0.0, 0.0, 0.0)]), 0.9), []);
        assert_eq!(at(&touch, 1.0), [Tone::Touch]);
        assert_eq!(at(&touch, 1.008), []);
        assert_eq!(at(&forces(Vec::new()), 1.016), []);
        assert_eq!(at(&touch, 1.1), [], "0.092 s apart");
        assert_eq!(at(&touch, 1.5), [Tone::Touch], "0.4 s apart");
        let both = forces(vec![
            contact("left", 1e-3, 1e-3, 0.0),
            contact("right", 1e-3, 1e-3, 0.0),
        ]);
        assert_eq!(at(&both, 1.508), [Tone::Touch], "the other hand");
    }

    /// Above the limit of the pair, as the physics states, or above that of the level; a force at the limit is none.
    #[test]
    fn too_much_force_warns() {
        let mut cues = Cues::new(Some(8e-3));
        let mut warns = |sustained, over| {
            let forces = forces(vec![contact("left", 1e-3, sustained, over)]);
            cues.of_forces(&forces, 1.0).contains(&Tone::Warning)
        };
        assert!(!warns(8e-3, 0.0) && warns(8.1e-3, 0.0) && warns(1e-3, 0.004));
        let mut cues = Cues::new(None);
        let forces = forces(vec![contact("left", 1.0, 1.0, 0.0)]);
        assert_eq!(cues.of_forces(&forces, 1.0), [Tone::Touch]);
    }

    #[test]
    fn cuts_and_tears_have_their_tones() {
        let mut cues = Cues::default();
        let cut = |tool: &str| TissueCut {
            tool: tool.into(),
            ..TissueCut::default()
        };
        assert_eq!(cues.of_cut(&cut("right"), 1.0), Some(Tone::Cut));
        assert_eq!(cues.of_cut(&cut("right"), 1.1), None, "the same one");
        assert_eq!(cues.of_cut(&cut(""), 1.1), Some(Tone::Tear));
        assert_eq!(cues.of_cut(&cut("right"), 1.2), Some(Tone::Cut));
    }
}
