//! What tools do to a body: whether they hold it, how hard, for how long too hard; and how often it was let go.

use super::{Probes, length};
use crate::{Fault, Tick};
use microsim_bus::BlockView;
use microsim_message::{ContactForce, ContactForces, GRIP_MIN};
use serde::{Deserialize, Serialize};

/// Time without a grip after which tissue has been let go \[s\]. A grip that trembles for a tick has not let go.
const LET_GO: f64 = 0.1;

/// Share of the normal force that has to act where nothing slides, for tissue to move with the jaws. Tissue that is held at rest
/// under tension may be at the limit of its friction over more than half of the grip, and what sticks holds it nevertheless.
const HELD_STICK: f64 = 0.25;

/// The contacts of a body, tick by tick.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contacts {
    /// Whether anything of a tool has touched it so far.
    pub touched: bool,
    /// Whether a tool that holds has had it so far.
    pub was_held: bool,
    /// The pieces of it that each of the tools that hold had in the last tick; none where it held nothing.
    pub held: Vec<Vec<u32>>,
    /// Rigid things and bodies that it touched in the last tick, each with the pieces of it that did.
    pub on: Vec<(String, Vec<u32>)>,
    /// Largest force of a tool on it, mean over a tick \[N\].
    pub peak_force: f64,
    /// Largest force with which the jaws of a tool that holds squeezed it, mean over a tick \[N\].
    pub peak_grip: f64,
    /// Time in which a tool's force was above the limit of its pair \[s\], and whether it was in the last tick.
    pub excess: f64,
    /// See [`Contacts::excess`].
    pub too_hard: bool,
}

impl Contacts {
    /// Hears the contacts of a tick. `holders` are the tools that hold it; while `counts` is false, nothing is added up.
    pub fn hear(
        &mut self,
        tick: &Tick<'_>,
        body: &str,
        holders: &[String],
        counts: bool,
    ) -> Result<(), Fault> {
        let forces = tick.messages::<ContactForces>()?;
        let of_it = |contact: &&ContactForce| contact.body == body;
        let contacts: Vec<&ContactForce> = forces
            .iter()
            .flat_map(|f| &f.contacts)
            .filter(of_it)
            .collect();
        self.touched |= !contacts.is_empty();
        let held = |tool: &String| {
            let held = contacts.iter().filter(|c| c.tool == *tool && holds(c));
            held.flat_map(|c| c.pieces.iter().copied()).collect()
        };
        self.held = holders.iter().map(held).collect();
        self.was_held |= self.held_by_any();
        let between = forces.iter().flat_map(|f| &f.between).filter(of_it);
        self.on = between
            .map(|contact| (contact.tool.clone(), contact.pieces.clone()))
            .collect();
        let excess = contacts.iter().map(|c| c.over_limit).fold(0.0, f64::max);
        self.too_hard = excess > 0.0;
        if counts {
            self.excess += excess;
            for contact in contacts {
                self.peak_force = self.peak_force.max(length(contact.force));
                if holders.contains(&contact.tool) {
                    self.peak_grip = self.peak_grip.max(contact.grip);
                }
            }
        }
        Ok(())
    }

    /// Whether every tool that holds has it.
    pub fn held_by_all(&self) -> bool {
        !self.held.is_empty() && self.held.iter().all(|pieces| !pieces.is_empty())
    }

    /// Whether some tool has it.
    pub fn held_by_any(&self) -> bool {
        self.held.iter().any(|pieces| !pieces.is_empty())
    }

    /// Whether some tool has a piece of it.
    pub fn holds(&self, piece: u32) -> bool {
        self.held.iter().any(|pieces| pieces.contains(&piece))
    }

    /// Whether a piece of it touches a rigid thing or body.
    pub fn is_on(&self, name: &str, piece: u32) -> bool {
        let mut on = self.on.iter();
        on.any(|(other, pieces)| other == name && pieces.contains(&piece))
    }
}

/// Whether jaws hold tissue: they grip it, and it moves with them. Tissue that lies on jaws is not gripped, and what slides along
/// them is not held.
fn holds(contact: &ContactForce) -> bool {
    contact.grip >= GRIP_MIN && contact.stick >= HELD_STICK
}

/// Counts how often something was let go for good.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Releases {
    /// How often so far.
    pub count: u32,
    since: Option<f64>,
    told: bool,
}

impl Releases {
    /// Whether it counts as let go from `time` \[s\] on; `loose` tells whether nobody has it where somebody should.
    pub fn watch(&mut self, time: f64, loose: bool) -> bool {
        if !loose {
            (self.since, self.told) = (None, false);
            return false;
        }
        let since = *self.since.get_or_insert(time);
        let gone = !self.told && time - since >= LET_GO;
        self.told |= gone;
        self.count += u32::from(gone);
        gone
    }
}

/// Which parts of a body are held, part by part of its [`Probes`]: what was held a moment ago still is, as a grip that trembles for a tick
/// has not let go.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Grasp {
    /// When the piece of each probe was held last \[s\].
    last: Vec<Option<f64>>,
}

impl Grasp {
    /// Looks at all parts in a tick, at `time` \[s\].
    pub fn watch(
        &mut self,
        time: f64,
        contacts: &Contacts,
        probes: &Probes,
        block: &BlockView<'_>,
    ) {
        self.last.resize(probes.count(), None);
        for (probe, last) in self.last.iter_mut().enumerate() {
            let piece = probes.number(probe, block);
            if piece.is_some_and(|piece| contacts.holds(piece)) {
                *last = Some(time);
            }
        }
    }

    /// Whether the piece of a probe is held at `time` \[s\].
    pub fn holds(&self, probe: usize, time: f64) -> bool {
        let last = self.last.get(probe).copied().flatten();
        last.is_some_and(|last| time - last < LET_GO)
    }
}
