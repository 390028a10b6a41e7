//! Contact by sequential impulses: what explicit and position-based methods do.
//!
//! A step without contact would bring the nodes to x̃. Forces at the contacts move them on by `mobility`·force each, a number per
//! node that depends on the scheme (h²/m with symplectic Euler), so that for each contact
//!
//! ```text
//! g(x) ≥ floor     λ ≥ 0     λ (g − floor) = 0          along the normal
//! |t| ≤ μ λ        t against the way u across the normal that the sides have slid in the step; |t| < μ λ only for u = 0
//! ```
//!
//! found by projected Gauss–Seidel over the contacts in their order, with sums of force that are bounded as a whole (Moreau 1988;
//! Guendelman, Bridson, Fedkiw 2003). Both sides of a contact get the same force, so momentum is kept to rounding; where two bodies
//! share a gap each goes its part by inverse mass. Restitution is 0.
//!
//! # Old overlaps
//! What was inside before the step must not go deeper, and that is all the force there is about it. The rest is undone by places alone,
//! without velocity and force: parts that no clamp holds are taken out as a whole, which costs no elastic energy, and what then
//! remains is pushed out at a speed that tissue follows (Guendelman et al. push bodies in the same way).
//!
//! # Limitations
//! Gaps are linear here; what a turn of the normal leaves of an overlap is undone in the next step. Many contacts on top of one another
//! through light nodes converge slowly: after [`SWEEPS`] what is left is left.

use crate::contact::{Contact, ContactStep};
use crate::model::TissueModel;
use crate::parts::Parts;
use nalgebra::Vector3;

/// Most sweeps over the contacts.
pub(crate) const SWEEPS: u32 = 50;
/// The largest change in a sweep that is none, as a share of an edge.
const DONE: f64 = 1e-10;
/// How far an old overlap is undone where that strains the tissue, as a share of an edge: in the time that the fastest mode takes
/// for a third of its period, in which waves go about an edge, and in any step. Faster, it adds energy: two tubes that collide had 0.6 %
/// more at most with twice the speed, 23 % with twenty times.
const UNDONE: f64 = 1e-3;
const MOST_UNDONE: f64 = 0.2;

/// A contact with the mobilities of its nodes.
#[derive(Clone, Copy, Debug)]
struct Row {
    /// Weight times mobility of each node \[m/N\].
    response: [f64; 4],
    /// How far the sides part for a force \[m/N\].
    compliance: f64,
}

/// Working memory for one model.
#[derive(Clone, Debug)]
pub(crate) struct Projection {
    edge: f64,
    /// Bound of the highest frequency \[1/s\].
    frequency: f64,
    rows: Vec<Row>,
    parts: Parts,
    /// Sums of pseudo-forces.
    pushes: Vec<f64>,
    closed: Vec<Contact>,
    /// Values before they were changed, then their changes.
    before: Vec<Vector3<f64>>,
}

/// What [`Projection::keep`] is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kept<'a> {
    /// Gaps of positions after a step from these.
    Gaps(&'a [Vector3<f64>]),
    /// Speeds of gaps that are closed, after a step of this length \[s\].
    Speeds(f64),
}

impl Projection {
    /// Working memory for `model`.
    pub fn new(model: &TissueModel) -> Self {
        Self {
            edge: model.mean_edge_length(),
            frequency: model.rate_bound().sqrt(),
            rows: Vec::new(),
            parts: Parts::new(model),
            pushes: Vec::new(),
            closed: Vec::new(),
            before: vec![Vector3::zeros(); model.node_count()],
        }
    }

    /// Follows an edit of the model.
    pub fn follow(&mut self, model: &TissueModel) {
        self.parts = Parts::new(model);
        self.before.resize(model.node_count(), Vector3::zeros());
    }

    /// Keeps gaps where a step without contact brings the nodes to `positions`, from `start`; afterwards they are where the step
    /// ends, and [`ways`](Self::ways) holds what forces had to do with it. `mobility` as in [`begin`](Self::begin). Returns whether
    /// there is any contact; where there is none nothing is moved.
    pub fn touch(
        &mut self,
        touching: &mut ContactStep<'_>,
        start: &[Vector3<f64>],
        mobility: impl Fn(usize) -> f64,
        h: f64,
        positions: &mut [Vector3<f64>],
    ) -> bool {
        touching.source.find(1.0, positions, &mut touching.contacts);
        if touching.contacts.is_empty() {
            self.before.fill(Vector3::zeros());
            return false;
        }
        self.before.copy_from_slice(positions);
        self.begin(&mut touching.contacts, &mobility);
        self.keep(Kept::Gaps(start), SWEEPS, &mut touching.contacts, positions);
        for (way, x) in self.before.iter_mut().zip(&*positions) {
            *way = x - *way;
        }
        self.undo(
            &touching.contacts,
            |node| mobility(node) == 0.0,
            h,
            positions,
        );
        true
    }

    /// How far the forces of the last [`touch`](Self::touch) have moved each node \[m\].
    pub fn ways(&self) -> &[Vector3<f64>] {
        &self.before
    }

    /// Gives the contacts that were closed in the last [`touch`](Self::touch) the speeds with which they stay so, in a step of `h`
    /// \[s\]; afterwards [`ways`](Self::ways) holds the changes of the velocities. `inverse_mass` is 0 for a prescribed node.
    pub fn settle(
        &mut self,
        contacts: &[Contact],
        h: f64,
        inverse_mass: impl Fn(usize) -> f64,
        velocities: &mut [Vector3<f64>],
    ) {
        self.before.copy_from_slice(velocities);
        let mut closed = std::mem::take(&mut self.closed);
        closed.clear();
        closed.extend(contacts.iter().filter(|contact| contact.normal_force > 0.0));
        self.begin(&mut closed, inverse_mass);
        self.keep(Kept::Speeds(h), SWEEPS, &mut closed, velocities);
        self.closed = closed;
        for (change, v) in self.before.iter_mut().zip(&*velocities) {
            *change = v - *change;
        }
    }

    /// Takes over the contacts of a step, and how far a force moves each node \[m/N\]; 0 for a prescribed one.
    pub fn begin(&mut self, contacts: &mut [Contact], mobility: impl Fn(usize) -> f64) {
        self.rows.clear();
        for contact in contacts {
            contact.normal_force = 0.0;
            contact.friction_force = Vector3::zeros();
            contact.is_sliding = true;
            let mut row = Row {
                response: [0.0; 4],
                compliance: 0.0,
            };
            for ((response, &node), weight) in row
                .response
                .iter_mut()
                .zip(&contact.nodes)
                .zip(contact.weights)
            {
                *response = weight * mobility(node as usize);
                row.compliance += weight * *response;
            }
            self.rows.push(row);
        }
    }

    /// Moves `values` – positions, or velocities – and adds to the forces of the contacts until all is kept, at most
    /// in so many sweeps.
    pub fn keep(
        &self,
        kept: Kept<'_>,
        sweeps: u32,
        contacts: &mut [Contact],
        values: &mut [Vector3<f64>],
    ) {
        let done = match kept {
            Kept::Gaps(_) => DONE * self.edge,
            Kept::Speeds(h) => DONE * self.edge / h,
        };
        for _ in 0..sweeps {
            let mut largest = 0.0f64;
            for (contact, row) in contacts.iter_mut().zip(&self.rows) {
                if row.compliance > 0.0 {
                    largest = largest.max(relax(kept, contact, row, values));
                }
            }
            if largest <= done {
                break;
            }
        }
    }

    /// Undoes old overlaps in a step of `h` \[s\]: moves `positions` where gaps are below their floors. `held` says of a node whether
    /// it is prescribed.
    pub fn undo(
        &mut self,
        contacts: &[Contact],
        held: impl Fn(usize) -> bool,
        h: f64,
        positions: &mut [Vector3<f64>],
    ) {
        let tolerance = DONE * self.edge;
        let deep = |positions: &[Vector3<f64>], contact: &Contact| {
            contact.start_gap < 0.0 && contact.gap(positions) < contact.floor - tolerance
        };
        if !contacts.iter().any(|contact| deep(positions, contact)) {
            return;
        }
        self.parts.separate(contacts, held, h, positions);
        let share = undone(self.frequency, h);
        self.pushes.clear();
        self.pushes.resize(contacts.len(), 0.0);
        for _ in 0..SWEEPS {
            let mut largest = 0.0f64;
            for ((contact, row), push) in contacts.iter().zip(&self.rows).zip(&mut self.pushes) {
                if row.compliance == 0.0 {
                    continue;
                }
                let floor = contact.floor.min(contact.start_gap + share * self.edge);
                let missing = floor - contact.gap(positions);
                let pushed = (*push + missing / row.compliance).max(0.0);
                let change = pushed - *push;
                *push = pushed;
                largest = largest.max((change * row.compliance).abs());
                shift(contact, row, &(contact.normal * change), positions);
            }
            if largest <= tolerance {
                break;
            }
        }
    }
}

/// How far an old overlap is undone in a step of `h` \[s\], as a share of an edge; `frequency` is that of the fastest mode \[1/s\].
pub(crate) fn undone(frequency: f64, h: f64) -> f64 {
    (0.5 * h * frequency * UNDONE).clamp(0.0, MOST_UNDONE)
}

/// Corrects one contact; returns the size of the change.
fn relax(kept: Kept<'_>, contact: &mut Contact, row: &Row, values: &mut [Vector3<f64>]) -> f64 {
    let missing = match kept {
        Kept::Gaps(_) => contact.floor.min(contact.start_gap) - contact.gap(values),
        Kept::Speeds(h) => contact
            .normal
            .dot(&(contact.drift / h - contact.interpolate(values))),
    };
    let normal_force = (contact.normal_force + missing / row.compliance).max(0.0);
    let change = normal_force - contact.normal_force;
    contact.normal_force = normal_force;
    shift(contact, row, &(contact.normal * change), values);
    let mut largest = (change * row.compliance).abs();
    if contact.friction > 0.0 {
        let slide = contact.interpolate(values)
            - match kept {
                Kept::Gaps(start) => contact.interpolate(start) + contact.drift,
                Kept::Speeds(h) => contact.drift / h,
            };
        let slide = slide - contact.normal * contact.normal.dot(&slide);
        let friction_force = contact.friction_force - slide / row.compliance;
        let most = contact.friction * contact.normal_force;
        let share = most / friction_force.norm().max(f64::MIN_POSITIVE);
        contact.is_sliding = share < 1.0;
        let friction_force = friction_force * share.min(1.0);
        let change = friction_force - contact.friction_force;
        contact.friction_force = friction_force;
        shift(contact, row, &change, values);
        largest = largest.max(change.norm() * row.compliance);
    }
    largest
}

/// Moves the nodes of a contact by a force.
fn shift(contact: &Contact, row: &Row, force: &Vector3<f64>, values: &mut [Vector3<f64>]) {
    for (&node, response) in contact.nodes.iter().zip(row.response) {
        values[node as usize] += force * response;
    }
}
