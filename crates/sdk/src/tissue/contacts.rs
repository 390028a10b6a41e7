//! What tools do to a body: whether they hold it, how hard, for how long too hard; and how often it was let go.

use super::{MarkLine, Probes, distance, place_of};
use crate::fault::Fault;
use crate::tick::Tick;
use microsim_bus::BlockView;
use microsim_message::{ContactForce, ContactForces, GRIP_MIN, SolverTick};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Time without a grip after which tissue has been let go \[s\]. A grip that trembles for a tick has not let go.
const LET_GO: f64 = 0.1;

/// Fraction of the normal force that has to act where nothing slides, for tissue to move with the jaws. Tissue that is held at rest
/// under tension may be at the limit of its friction over more than half of the grip, and what sticks holds it nevertheless.
const HELD_STICK: f64 = 0.25;

/// What a tool has in its jaws.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grip {
    /// Where it acts \[m\].
    pub place: [f64; 3],
    /// Numbers of the pieces that it holds.
    pub pieces: Vec<u32>,
}

/// The contacts of a body, tick by tick.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contacts {
    /// Whether anything of a tool has touched it so far, also before it counts: from then on it no longer lies as it lay.
    pub touched: bool,
    /// Whether a tool that holds has had it so far, while it counted.
    pub was_held: bool,
    /// The grips of each of the tools that hold in the last tick; none where it held nothing.
    pub held: Vec<Vec<Grip>>,
    /// Rigid obstacles and bodies that it touched in the last tick, each with the pieces of it that did.
    pub on: Vec<(String, Vec<u32>)>,
    /// Largest sustained force of a tool on it \[N\]: see [`ContactForce::sustained_force`].
    pub peak_force: f64,
    /// Largest sustained force with which the jaws of a tool that holds squeezed it \[N\].
    pub peak_grip: f64,
    /// Time in which a tool's sustained force was above the limit of its pair \[s\], and whether it was in the last tick.
    pub excess: f64,
    /// See [`Contacts::excess`].
    pub too_hard: bool,
}

impl Contacts {
    /// Takes over the contacts of a tick, unless its forces mean nothing. `holders` are the tools that hold it; while `counts` is false, nothing is added up.
    pub fn update(
        &mut self,
        tick: &Tick<'_>,
        body: &str,
        holders: &[String],
        counts: bool,
    ) -> Result<(), Fault> {
        let Some(forces) = valid_forces(tick)? else {
            // All stays as it was in the last tick that means something.
            return Ok(());
        };
        let of_it = |contact: &&ContactForce| contact.body == body;
        let contacts: Vec<&ContactForce> = forces
            .iter()
            .flat_map(|f| &f.contacts)
            .filter(of_it)
            .collect();
        self.touched |= !contacts.is_empty();
        let held = |tool: &String| {
            let held = contacts.iter().filter(|c| c.partner == *tool && holds(c));
            let grip = |c: &&ContactForce| Grip {
                place: c.point,
                pieces: c.pieces.clone(),
            };
            held.map(grip).collect()
        };
        self.held = holders.iter().map(held).collect();
        self.was_held |= counts && self.held_by_any();
        let between = forces.iter().flat_map(|f| &f.between).filter(of_it);
        self.on = between
            .map(|contact| (contact.partner.clone(), contact.pieces.clone()))
            .collect();
        let excess = contacts
            .iter()
            .map(|c| c.time_over_limit)
            .fold(0.0, f64::max);
        self.too_hard = excess > 0.0;
        if counts {
            self.excess += excess;
            for contact in contacts {
                self.peak_force = self.peak_force.max(contact.sustained_force);
                if holders.contains(&contact.partner) {
                    self.peak_grip = self.peak_grip.max(contact.sustained_grip);
                }
            }
        }
        Ok(())
    }

    /// Whether every tool that holds has it.
    pub fn held_by_all(&self) -> bool {
        !self.held.is_empty() && self.held.iter().all(|grips| !grips.is_empty())
    }

    /// Whether some tool has it.
    pub fn held_by_any(&self) -> bool {
        self.held.iter().any(|grips| !grips.is_empty())
    }

    /// Whether some tool has a piece of it.
    pub fn holds(&self, piece: u32) -> bool {
        let mut grips = self.held.iter().flatten();
        grips.any(|grip| grip.pieces.contains(&piece))
    }

    /// Whether a piece of it touches a rigid obstacle or body.
    pub fn is_on(&self, name: &str, piece: u32) -> bool {
        let mut on = self.on.iter();
        on.any(|(other, pieces)| other == name && pieces.contains(&piece))
    }
}

/// The contacts of a tick; `None` where its forces mean nothing.
pub(super) fn valid_forces(tick: &Tick<'_>) -> Result<Option<Vec<ContactForces>>, Fault> {
    let forces = tick.messages::<ContactForces>()?;
    let solver = tick.messages::<SolverTick>()?;
    if !forces.is_empty() && solver.is_empty() {
        return Err(Fault::new(
            "contact.forces without tissue.solver, which tells whether they mean anything: the manifest has to subscribe to both",
        ));
    }
    let valid = solver.iter().all(|solver| solver.valid);
    Ok(valid.then_some(forces))
}

/// Whether jaws hold tissue: they grip it, and it moves with them. Tissue that lies on jaws is not gripped, and what slides along
/// them is not held.
fn holds(contact: &ContactForce) -> bool {
    contact.grip_force >= GRIP_MIN
        && contact.sticking_fraction >= HELD_STICK
        && !contact.pieces.is_empty()
}

/// Counts how often something was let go for good.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Releases {
    /// How often so far.
    pub count: u32,
    since: Option<f64>,
    reported: bool,
}

impl Releases {
    /// Whether it counts as let go from `time` \[s\] on; `loose` is whether nobody has it where somebody should.
    pub fn watch(&mut self, time: f64, loose: bool) -> bool {
        if !loose {
            (self.since, self.reported) = (None, false);
            return false;
        }
        let since = *self.since.get_or_insert(time);
        let gone = !self.reported && time - since >= LET_GO;
        self.reported |= gone;
        self.count += u32::from(gone);
        gone
    }
}

/// Which marks of a body are steadied: something holds it next to them. What was held a moment ago still is, as a grip that trembles for a
/// tick has not let go.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Grasp {
    /// Nodes by their ids, ascending, each with the number of marks between it and the first end of the tissue.
    parts: Vec<(u32, usize)>,
    /// When each mark was steadied last \[s\].
    last: Vec<Option<f64>>,
}

impl Grasp {
    /// Of marks that divide tissue into parts, as it lies now; `first` lies in the first of them \[m\]. `None` if the snapshot has no
    /// nodes.
    pub fn between(marks: &[MarkLine], first: [f64; 3], block: &BlockView<'_>) -> Option<Self> {
        let (ids, positions) = (block.u32s("node_id")?, block.f64s("position")?);
        let part = |row: usize| {
            let place = place_of(positions, row);
            let passed = marks.iter().filter(|mark| {
                let [there, here] = [place, first].map(|p| {
                    let offset = Vector3::from(p) - Vector3::from(mark.middle);
                    offset.dot(&Vector3::from(mark.across))
                });
                there * here < 0.0
            });
            passed.count()
        };
        let mut parts: Vec<(u32, usize)> =
            (0..ids.len()).map(|row| (ids[row], part(row))).collect();
        parts.sort_unstable();
        Some(Self {
            parts,
            last: vec![None; marks.len()],
        })
    }

    /// Looks at all marks in a tick, at `time` \[s\]. `probes` has one node in each of the parts, in their order. A mark is steadied by a grip
    /// on a part beside it, as it was divided at first: a cut that is not yet through leaves far parts in one piece. The piece in the grip
    /// has to be that of the part as well, not a shred of it.
    pub fn watch(
        &mut self,
        time: f64,
        contacts: &Contacts,
        probes: &Probes,
        block: &BlockView<'_>,
    ) {
        for grip in contacts.held.iter().flatten() {
            let Some(part) = self.part_at(grip, block) else {
                continue;
            };
            for (mark, last) in self.last.iter_mut().enumerate() {
                let beside = [mark, mark + 1];
                let has = |part| {
                    let piece = probes.number(part, block);
                    piece.is_some_and(|piece| grip.pieces.contains(&piece))
                };
                if beside.contains(&part) && beside.into_iter().any(has) {
                    *last = Some(time);
                }
            }
        }
    }

    /// The part of the node nearest to a grip, of the pieces in it. Nodes that cuts have made belong to none.
    fn part_at(&self, grip: &Grip, block: &BlockView<'_>) -> Option<usize> {
        let (ids, positions) = (block.u32s("node_id")?, block.f64s("position")?);
        let pieces = block.u32s("piece")?;
        let rows = (0..ids.len()).filter(|row| grip.pieces.contains(&pieces[*row]));
        let known = rows.filter_map(|row| {
            let known = self.parts.binary_search_by_key(&ids[row], |(id, _)| *id);
            let (_, part) = self.parts[known.ok()?];
            Some((distance(place_of(positions, row), grip.place), part))
        });
        let nearest = known.min_by(|(a, _), (b, _)| a.total_cmp(b));
        nearest.map(|(_, part)| part)
    }

    /// Whether a mark is steadied at `time` \[s\].
    pub fn steadies(&self, mark: usize, time: f64) -> bool {
        let last = self.last.get(mark).copied().flatten();
        last.is_some_and(|last| time - last < LET_GO)
    }
}
