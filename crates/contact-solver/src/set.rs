//! The contacts of an iteration of Newton's method: their multipliers, energy and forces.
//!
//! A contact whose sides have come closer by y since the start of an iteration has the energy
//!
//! ```text
//! ψ(y) = 1/(2ρ) max(0, λ − ρ (g − floor))²  +  H(t − k u)/k          g = g₀ + n·y     u = u₀ + (1 − n nᵀ) y
//! ```
//!
//! with the multipliers λ and t, the slip u since the start of the step, and Huber's function H(t) = ½ t², linear where |t| > μ λ: the
//! augmented Lagrangian of Alart and Curnier (1991; Simo and Laursen 1992), but that the bound μ λ is the one of the last update. The
//! multipliers of the last step are the first guess of those of this one.

use crate::contact::Contact;
use crate::nodal::is_held;
use crate::options::AugmentedLagrangianOptions;
use crate::row::{ContactForce, Row};
use crate::solver::LinearSystem;
use crate::vectors::scatter;
use nalgebra::{Matrix3, Vector3};

/// The contacts of an iteration, linearised at its start.
#[derive(Clone, Debug)]
pub struct ContactSet {
    /// The contacts.
    pub contacts: Vec<Contact>,
    /// Whether the interior-point method is taken where it can be, and the step may stop before it has converged.
    pub prefers_interior_point: bool,
    /// Whether contacts retain multipliers, bounds and penalties when they are linearised again.
    pub retains_multipliers: bool,
    /// Solutions whose forces were not found and remained those of before, since the caller last set it to 0.
    pub failures: u32,
    options: AugmentedLagrangianOptions,
    rows: Vec<Row>,
    /// The contacts that were found before in this step, as they were published.
    published: Vec<Contact>,
    /// Contacts that the caller may come back to.
    checkpoint: Vec<Contact>,
    /// Whether the contacts were restored: what was found since has its normal forces from those in between.
    is_restored: bool,
    edge: f64,
    /// Positions that the contacts were linearised at \[m\].
    base: Vec<Vector3<f64>>,
}

impl ContactSet {
    /// Working memory for so many nodes, with the mean edge length `edge` \[m\].
    pub fn new(nodes: usize, edge: f64, options: AugmentedLagrangianOptions) -> Self {
        Self {
            contacts: Vec::new(),
            prefers_interior_point: false,
            retains_multipliers: false,
            failures: 0,
            options,
            rows: Vec::new(),
            published: Vec::new(),
            checkpoint: Vec::new(),
            is_restored: false,
            edge,
            base: vec![Vector3::zeros(); nodes],
        }
    }

    /// Whether there are no contacts.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Removes all contacts.
    pub fn clear(&mut self) {
        self.contacts.clear();
        self.rows.clear();
        self.published.clear();
    }

    /// Linearises the contacts that were found at `positions` in a step from `start`; `stiffness` is that of a node by itself \[N/m\], 0
    /// for a prescribed one. Contacts with less than a hundredth of their weight on nodes that can move, move nothing and have no force. In statics old overlaps are undone by force, else they are only prevented from going deeper.
    pub fn linearise(
        &mut self,
        start: &[Vector3<f64>],
        positions: &[Vector3<f64>],
        statics: bool,
        stiffness: impl Fn(usize) -> f64,
    ) {
        self.base.copy_from_slice(positions);
        if self.retains_multipliers && self.rows.len() == self.contacts.len() {
            self.linearise_retained(start, positions);
            return;
        }
        self.rows.clear();
        // Both lists have the same order, but for what came and went.
        let mut next = 0;
        let restored = std::mem::take(&mut self.is_restored);
        for contact in &mut self.contacts {
            let same = |published: &Contact| {
                published.nodes == contact.nodes
                    && published.first == contact.first
                    && published.normal.dot(&contact.normal) > 0.0
            };
            let from = self.published.iter().skip(next).position(same);
            let found = from
                .map(|k| k + next)
                .or_else(|| self.published.iter().position(same));
            next = found.map_or(next, |k| k + 1);
            if restored {
                contact.normal_force = found.map_or(0.0, |k| self.published[k].normal_force);
            }
            let last = found.map_or(&*contact, |k| &self.published[k]);
            let (friction, is_sliding) = (last.friction_force, last.is_sliding);
            let slip = contact.interpolate(positions) - contact.interpolate(start) - contact.drift;
            let mut compliances = [0.0; 2];
            let mut responses = [0.0; 4];
            let stiffnesses = contact.nodes.map(|node| stiffness(node as usize));
            let is_held = is_held(&contact.weights, stiffnesses.map(|of| of > 0.0));
            for (k, (stiffness, weight)) in stiffnesses.into_iter().zip(contact.weights).enumerate()
            {
                if stiffness > 0.0 && !is_held {
                    responses[k] = weight / stiffness;
                    let side = usize::from(k >= usize::from(contact.first));
                    compliances[side] += weight * weight / stiffness;
                }
            }
            let is_between_bodies = compliances[0] > 0.0 && compliances[1] > 0.0;
            let ratio = match is_between_bodies {
                true => self.options.penalty_between_bodies,
                false => self.options.penalty,
            };
            let compliance = compliances[0] + compliances[1];
            let penalty = if compliance > 0.0 {
                ratio / compliance
            } else {
                0.0
            };
            let force = match penalty > 0.0 {
                true => ContactForce {
                    normal: contact.normal_force,
                    friction: friction - contact.normal * contact.normal.dot(&friction),
                    is_sliding,
                },
                // Nothing would update it: it would stay what it was.
                false => ContactForce::OPEN,
            };
            self.rows.push(Row {
                force,
                penalty,
                tangential_penalty: self.options.tangential_penalty * penalty,
                is_between_bodies,
                multiplier: force.normal,
                friction_multiplier: force.friction,
                friction_bound: contact.friction * force.normal,
                has_fixed_bound: false,
                floor: match statics {
                    true => contact.floor,
                    false => contact.floor.min(contact.start_gap),
                },
                gap: contact.gap(positions),
                slip: slip - contact.normal * contact.normal.dot(&slip),
                responses,
                compliance,
                factored: None,
                hessian: Matrix3::zeros(),
            });
        }
    }

    fn linearise_retained(&mut self, start: &[Vector3<f64>], positions: &[Vector3<f64>]) {
        for (contact, row) in self.contacts.iter().zip(&mut self.rows) {
            let slip = contact.interpolate(positions) - contact.interpolate(start) - contact.drift;
            row.gap = contact.gap(positions);
            row.slip = slip - contact.normal * contact.normal.dot(&slip);
            row.has_fixed_bound = true;
            // What has opened drags nothing, and what has closed since has its friction.
            let normal = row.force.normal;
            if normal <= 0.0 {
                (row.friction_bound, row.friction_multiplier) = (0.0, Vector3::zeros());
            } else if row.friction_bound == 0.0 {
                row.friction_bound = contact.friction * normal;
            }
        }
    }

    /// The contacts that can move something.
    fn active(&self) -> impl Iterator<Item = (&Contact, &Row)> {
        let all = self.contacts.iter().zip(&self.rows);
        all.filter(|(_, row)| row.penalty > 0.0)
    }

    /// Their energy at `positions` \[J\].
    pub fn energy(&self, positions: &[Vector3<f64>]) -> f64 {
        let energy = |(contact, row): (&Contact, &Row)| {
            let y = contact.interpolate(positions) - contact.interpolate(&self.base);
            row.law(contact, &y).1
        };
        self.active().map(energy).sum()
    }

    /// Adds their forces at `positions` to those of the nodes \[N\].
    pub fn add_forces(&self, positions: &[Vector3<f64>], forces: &mut [Vector3<f64>]) {
        for (contact, row) in self.active() {
            let y = contact.interpolate(positions) - contact.interpolate(&self.base);
            scatter(contact, &row.force_at(contact, &y), forces);
        }
    }

    /// How far λ is from its update where the contacts were linearised, as a length over the mean edge length: gaps below their floors, and
    /// forces across open ones.
    pub fn multiplier_residual(&self) -> f64 {
        let residual = |(contact, row): (&Contact, &Row)| {
            let normal = row.law(contact, &Vector3::zeros()).0.normal;
            (normal - row.multiplier).abs() / row.penalty
        };
        self.active().map(residual).fold(0.0, f64::max) / self.edge
    }

    /// How far a gap is below its floor at most, over the mean edge length.
    pub fn overlap(&self) -> f64 {
        let overlap = |(_, row): (&Contact, &Row)| row.floor - row.gap;
        self.active().map(overlap).fold(0.0, f64::max) / self.edge
    }

    /// Adds to a direction, of prescribed nodes so far, the displacement of single nodes with surfaces that have moved: contacts that had a
    /// force stay closed, and none is deeper than its floor. Only a guess, but with the right contacts closed, and forces of the right
    /// size.
    pub fn predict(&self, direction: &mut [Vector3<f64>]) {
        for _ in 0..self.options.prediction_sweeps {
            for (contact, row) in self.active() {
                let gap = row.gap + contact.normal.dot(&contact.interpolate(direction));
                if gap < row.floor || row.multiplier > 0.0 {
                    let force = contact.normal * ((row.floor - gap) / row.compliance);
                    for (&node, response) in contact.nodes.iter().zip(row.responses) {
                        direction[node as usize] += force * response;
                    }
                }
            }
        }
    }

    /// Adds the contacts that are closed after the displacement `direction` to the matrix.
    pub fn stiffen(&mut self, direction: &[Vector3<f64>], system: &mut dyn LinearSystem) {
        let without = self.takes_interior_point(system);
        for (contact, row) in self.contacts.iter().zip(&mut self.rows) {
            row.factored = None;
            if row.penalty == 0.0 || row.is_between_bodies || without {
                continue;
            }
            let curvature = row.curvature(contact, &contact.interpolate(direction));
            if curvature != Matrix3::zeros() && system.add_contact(contact, &curvature) {
                row.factored = Some(curvature);
            }
        }
    }

    /// Whether the interior-point method is the one for these contacts: where it is preferred, for small bodies with no contact between
    /// two of them that can move.
    pub fn takes_interior_point(&self, system: &dyn LinearSystem) -> bool {
        self.prefers_interior_point
            && system.is_small()
            && !self.rows.iter().any(|row| row.is_between_bodies)
    }

    /// Publishes and stores the contacts for [`restore`](Self::restore).
    pub fn store(&mut self) {
        self.publish();
        self.checkpoint.clone_from(&self.contacts);
    }

    /// Sets the contacts to those that were stored.
    pub fn restore(&mut self) {
        self.contacts.clone_from(&self.checkpoint);
        self.rows.clear();
        self.is_restored = true;
    }

    /// Publishes the forces in the contacts.
    pub fn publish(&mut self) {
        for (contact, row) in self.contacts.iter_mut().zip(&self.rows) {
            let force = row.force;
            contact.normal_force = force.normal;
            let ratio = row.friction_bound / force.friction.norm().max(f64::MIN_POSITIVE);
            contact.friction_force = force.friction * ratio.min(1.0);
            contact.is_sliding = force.is_sliding || ratio <= 1.0;
        }
        self.published.clone_from(&self.contacts);
    }

    /// Replaces the laws of the published contacts by those that undo old overlaps at `positions`, without friction and force; returns
    /// whether any is larger than `gap_tolerance`. At most `most` is undone; both over the mean edge length.
    pub fn undo_overlaps(
        &mut self,
        positions: &[Vector3<f64>],
        gap_tolerance: f64,
        most: f64,
    ) -> bool {
        self.base.copy_from_slice(positions);
        let mut any = false;
        for (contact, row) in self.contacts.iter().zip(&mut self.rows) {
            row.multiplier = 0.0;
            (row.friction_bound, row.has_fixed_bound) = (0.0, true);
            row.force = ContactForce::OPEN;
            row.floor = contact.floor.min(contact.start_gap + most * self.edge);
            row.gap = contact.gap(positions);
            any |= row.penalty > 0.0 && row.gap < row.floor - gap_tolerance * self.edge;
        }
        any
    }

    /// The contacts with their rows, and the mean edge length \[m\].
    pub(crate) fn parts(&mut self) -> (&[Contact], &mut [Row], f64) {
        (&self.contacts, &mut self.rows, self.edge)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One side lies between a free node and a prescribed one, the other is a point: with a 128th of the weight on the free one it has nothing to move, and
    /// the force that it had is gone; with a 64th it has.
    #[test]
    fn contacts_on_prescribed_nodes_have_no_force() {
        let positions = [Vector3::zeros(); 2];
        for (free, moves) in [(1.0 / 128.0, false), (1.0 / 64.0, true)] {
            let mut set = ContactSet::new(2, 1e-3, AugmentedLagrangianOptions::default());
            set.contacts = vec![Contact {
                nodes: [0, 1, 0, 0],
                weights: [free, 1.0, 0.0, 0.0],
                normal_force: 0.1,
                friction: 0.5,
                ..Contact::of_node(0, Vector3::z(), 0.0)
            }];
            set.linearise(&positions, &positions, false, |node| {
                if node == 0 { 100.0 } else { 0.0 }
            });
            assert_eq!(set.rows[0].penalty > 0.0, moves);
            set.publish();
            let expected = if moves { 0.1 } else { 0.0 };
            assert_eq!(set.contacts[0].normal_force, expected);
        }
    }

    /// A source gives normal forces by what it found last: after a step back these are not what is restored.
    #[test]
    fn restored_contacts_have_their_own_forces() {
        let positions = [Vector3::zeros(); 2];
        let on = |node, normal_force| Contact {
            normal_force,
            ..Contact::of_node(node, Vector3::z(), 0.0)
        };
        let mut set = ContactSet::new(2, 1e-3, AugmentedLagrangianOptions::default());
        let find = |set: &mut ContactSet, found: &[Contact]| {
            set.publish();
            set.contacts = found.to_vec();
            set.linearise(&positions, &positions, false, |_| 100.0);
        };
        find(&mut set, &[on(0, 0.1), on(1, 0.2)]);
        set.store();
        find(&mut set, &[on(1, 0.1)]);
        set.restore();
        find(&mut set, &[on(0, 7.0), on(1, 7.0)]);
        let forces = set.contacts.iter().map(|c| c.normal_force);
        assert_eq!(forces.collect::<Vec<_>>(), [0.1, 0.2]);
        let multipliers = set.rows.iter().map(|row| row.multiplier);
        assert_eq!(multipliers.collect::<Vec<_>>(), [0.1, 0.2]);
        // The next time it is what the source states.
        find(&mut set, &[on(0, 0.3)]);
        assert_eq!(set.rows[0].multiplier, 0.3);
    }
}
