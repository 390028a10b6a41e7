//! The direction of an iteration of a quick step: one factor of everything but the contacts, and these among themselves.
//!
//! With the factored matrix K of a positive tangent, which is positive definite without any contact, the ways y of the contacts are those without their
//! forces and G p, G = J K⁻¹ Jᵀ. So the forces p follow from small dense systems ([`interior`](super::interior)), and the direction from
//! them by one more solution: all forces are in balance to rounding at its end, which a light free piece in a firm grip needs: a
//! thousandth of the grip is many times its weight.
//!
//! Contacts that had a force are taken in first; those that the direction closes then join them, a few times. Bounds of friction are those of the
//! forces along the normals of the solution before, twice in an iteration: Coulomb's law is met as iterations converge.
//!
//! # Limitations
//! Contacts between two bodies that both can move are not here: their steps are not quick. What closes only with the last contacts that joined pushes
//! as a spring until the next iteration.

use super::interior::{Cone, Interior};
use super::row::{Row, Told};
use super::{Gaps, Member, along, frame, scatter};
use crate::contact::Contact;
use crate::system::System;
use microsim_sparse::NotPositive;
use nalgebra::Vector3;

/// How often contacts join, and how often bounds of friction are those of the forces of last time.
const ROUNDS: u32 = 4;
const UPDATES: u32 = 2;

/// A solution is as exact as the factor, which has double numbers.
const EXACT: f64 = 1e-9;

/// Gaps that are further below their floors than this share of an edge take part: what does not would push as a spring.
const CLOSED: f64 = 1e-6;

/// Contacts that hold the same nodes leave open which has how much of a force, and friction bounds each by itself. So each has a small
/// compliance of its own against the change of its force, a share of 1/ρ along the normal and across: they keep what they had.
const OWN: [f64; 2] = [1e-3, 1e-2];

/// The change of a bound of friction that may be left, as a share of the largest force.
const SETTLED: f64 = 1e-3;

/// Working memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Quick {
    members: Vec<Member>,
    cones: Vec<Cone>,
    /// J.
    directions: Vec<[(u32, Vector3<f64>); 4]>,
    /// G, and what each has of its own \[m/N\].
    compliance: Vec<f64>,
    own: Vec<f64>,
    /// The forces before \[N\].
    before: Vec<f64>,
    /// The ways without forces \[m\], less what forces as they were before have of their own, and the forces \[N\].
    ways: Vec<f64>,
    forces: Vec<f64>,
    interior: Interior,
}

impl Gaps {
    /// Adds to `direction` what is missing of it, and sets the multipliers, with the factor of a matrix in which no contact is.
    pub(super) fn set_quick_direction(
        &mut self,
        fixed: &[bool],
        system: &mut System,
        direction: &mut [Vector3<f64>],
    ) -> Result<(), NotPositive> {
        let Self {
            contacts,
            rows,
            others,
            inner,
            quick,
            edge,
            ..
        } = self;
        let slack = CLOSED * *edge;
        // Without any contact.
        inner.copy_from_slice(others);
        solve(system, fixed, inner)?;
        direction.iter_mut().zip(&*inner).for_each(|(d, i)| *d += i);
        inner.fill(Vector3::zeros());
        quick.clear();
        for _ in 0..ROUNDS {
            if !quick.join(contacts, rows, direction, inner, slack) {
                break;
            }
            let known = system.set_compliance(&quick.directions, &mut quick.compliance);
            debug_assert!(known, "a quick step has a factor");
            quick.balance(contacts, rows, direction);
            inner.fill(Vector3::zeros());
            for member in &quick.members {
                scatter(
                    &contacts[member.contact],
                    &member.vector(&quick.forces),
                    inner,
                );
            }
            solve(system, fixed, inner)?;
        }
        direction.iter_mut().zip(&*inner).for_each(|(d, i)| *d += i);
        for (contact, row) in contacts.iter().zip(&mut *rows) {
            *row = row.with_force(contact, &contact.interpolate(direction), Told::NONE);
        }
        for (member, cone) in quick.members.iter().zip(&quick.cones) {
            let (contact, row) = (&contacts[member.contact], &mut rows[member.contact]);
            let normal = contact.normal * quick.forces[member.first];
            let told = Told {
                normal_force: quick.forces[member.first],
                friction_force: member.vector(&quick.forces) - normal,
                is_sliding: !cone.sticks,
            };
            row.bound = cone.bound;
            *row = row.with_force(contact, &contact.interpolate(direction), told);
        }
        Ok(())
    }
}

/// Solves with the factored matrix, with no forces at the nodes that are fixed.
fn solve(system: &mut System, fixed: &[bool], x: &mut [Vector3<f64>]) -> Result<(), NotPositive> {
    for (x, fixed) in x.iter_mut().zip(fixed) {
        if *fixed {
            *x = Vector3::zeros();
        }
    }
    system.solve(x, EXACT)
}

impl Quick {
    fn clear(&mut self) {
        self.members.clear();
        self.directions.clear();
        self.own.clear();
        self.before.clear();
        self.forces.clear();
    }

    /// Takes in contacts: at first those that had a force, later, or where there are none, those whose gaps are below their floors by more
    /// than `slack` where the nodes go `direction` and `more`. Says whether there are any.
    fn join(
        &mut self,
        contacts: &[Contact],
        rows: &[Row],
        direction: &[Vector3<f64>],
        more: &[Vector3<f64>],
        slack: f64,
    ) -> bool {
        let before = self.members.len();
        let had = |row: &Row| row.told.normal_force > 0.0 || row.bound > 0.0;
        if before == 0 {
            self.take(contacts, rows, |_, row| had(row));
        }
        if self.members.len() == before {
            self.take(contacts, rows, |contact, row| {
                let way = contact.interpolate(direction) + contact.interpolate(more);
                row.gap + contact.normal.dot(&way) < row.floor - slack
            });
        }
        self.members.len() > before
    }

    /// Takes in the contacts that can move something and are to be taken, but for those that are there.
    fn take(
        &mut self,
        contacts: &[Contact],
        rows: &[Row],
        is_taken: impl Fn(&Contact, &Row) -> bool,
    ) {
        let before = self.members.len();
        for (index, (contact, row)) in contacts.iter().zip(rows).enumerate() {
            let known = self.members[..before].iter().any(|m| m.contact == index);
            if row.stiffness == 0.0 || known || !is_taken(contact, row) {
                continue;
            }
            let member = Member {
                contact: index,
                first: self.directions.len(),
                count: if contact.friction > 0.0 { 3 } else { 1 },
                frame: frame(contact),
            };
            let force = contact.normal * row.told.normal_force + row.told.friction_force;
            for k in 0..member.count {
                self.directions.push(along(contact, &member.frame, k));
                self.own.push(OWN[k.min(1)] / row.stiffness);
                self.before.push(member.frame.column(k).dot(&force));
            }
            self.members.push(member);
        }
    }

    /// Sets the forces, with the bounds of friction of the rows or, where these do not stay, of the forces themselves.
    fn balance(&mut self, contacts: &[Contact], rows: &[Row], direction: &[Vector3<f64>]) {
        self.ways.clear();
        self.cones.clear();
        for member in &self.members {
            let (contact, row) = (&contacts[member.contact], &rows[member.contact]);
            let way = contact.interpolate(direction);
            self.ways
                .push(row.gap + contact.normal.dot(&way) - row.floor);
            let slid = row.slide + way;
            let across = (1..member.count).map(|k| member.frame.column(k).dot(&slid));
            self.ways.extend(across);
            self.cones.push(Cone::new(member.first, row.bound));
        }
        for ((way, own), before) in self.ways.iter_mut().zip(&self.own).zip(&self.before) {
            *way -= own * before;
        }
        self.forces.clone_from(&self.before);
        for update in 0..UPDATES {
            for (member, cone) in self.members.iter().zip(&self.cones) {
                if cone.bound == 0.0 {
                    self.forces[member.first + 1..][..member.count - 1].fill(0.0);
                }
            }
            let Self {
                compliance,
                own,
                ways,
                cones,
                forces,
                interior,
                ..
            } = &mut *self;
            let found = interior.solve(compliance, own, ways, cones, forces);
            if !found || update + 1 == UPDATES || self.is_settled(contacts, rows) {
                break;
            }
            for (member, cone) in self.members.iter().zip(&mut self.cones) {
                if !rows[member.contact].keeps_bound {
                    cone.bound = contacts[member.contact].friction * self.forces[member.first];
                }
            }
        }
    }

    /// Whether no bound is far from what its force says.
    fn is_settled(&self, contacts: &[Contact], rows: &[Row]) -> bool {
        let largest = |most: f64, member: &Member| most.max(self.forces[member.first]);
        let enough = SETTLED * self.members.iter().fold(0.0, largest);
        let mut all = self.members.iter().zip(&self.cones);
        all.all(|(member, cone)| {
            let bound = contacts[member.contact].friction * self.forces[member.first];
            rows[member.contact].keeps_bound || (bound - cone.bound).abs() <= enough
        })
    }
}
