//! Contact in Newton's method: the forces of gaps, and the direction of an iteration that keeps them.
//!
//! A contact whose sides have come closer by y since the start of an iteration has the energy
//!
//! ```text
//! ψ(y) = 1/(2ρ) max(0, λ − ρ (g − floor))²  +  H(t − k u)/k          g = g₀ + n·y     u = u₀ + (1 − n nᵀ) y
//! ```
//!
//! with the multipliers λ and t, the way u that the sides have slid since the start of the step, and Huber's function H(t) = ½ t²,
//! linear where |t| > μ λ: the augmented Lagrangian of Alart and Curnier (1991; Simo and Laursen 1992), but that the bound μ λ is the
//! one of the last update. The multipliers of the last step are the first guess of those of this one.
//!
//! With the matrix K and the forces r of everything else the direction d of an iteration is the lowest point of
//! ½ dᵀK d − r·d + Σ ψ(Σ w d), which is convex and piecewise quadratic (but for H). It is found without any further work at elements:
//! inner iterations of Newton's method, each by conjugate gradients on K and the contacts that are closed now, with the factor of K and
//! the contacts that were closed first; then multipliers and bounds are updated, until the gaps are kept and nothing slides that sticks.
//!
//! Where contacts are few all of this is done among them alone first (`reduced`), and conjugate gradients only see to what is left.
//!
//! In steps of time that need not converge, of bodies of a few hundred nodes, the matrix has no contact, is positive and factored with
//! double numbers: all contacts are settled among themselves with that (`quick`), whatever opens, closes, sticks and slides. Then the
//! multipliers are set such that the potential has the forces found at the end of the direction. All forces are in balance there, which
//! a light free piece in a firm grip needs: a thousandth of the grip is many times its weight.
//!
//! Contacts between two bodies that both can move are not in the factor: their blocks are not in its pattern. They have a softer ρ
//! and more updates.

mod interior;
mod quick;
mod reduced;
mod row;

use crate::contact::Contact;
use crate::system::System;
use microsim_sparse::NotPositive;
use nalgebra::{Matrix3, Vector3};
use quick::Quick;
use reduced::{Reduced, size};
use row::{Row, Told};

/// ρ and k over the stiffness of the nodes at a contact by themselves: where the factor has it, and where not. Stiffer contacts need
/// fewer updates, which cost next to nothing among few, and lose digits of a factor of single numbers: with 100 a vessel between jaws
/// takes twice the rounds of solutions.
const STIFF: f64 = 10.0;
const SOFT: f64 = 8.0;
/// Most inner iterations with the same multipliers, and most updates of those.
const INNER: u32 = 12;
const UPDATES: u32 = 12;
/// Most steps of the search along an inner direction: each halves what is unknown.
const HALVES: u32 = 30;
/// Sweeps over the contacts in which single nodes are put on surfaces that have moved, to begin with.
const SWEEPS: u32 = 4;

/// Working memory: the contacts of an iteration.
#[derive(Clone, Debug)]
pub(super) struct Gaps {
    pub contacts: Vec<Contact>,
    /// Whether the equation is of a step of time that need not converge.
    pub need_not_converge: bool,
    /// Whether contacts keep bounds, multipliers and the law they have when they are set for new positions.
    pub keeps_laws: bool,
    rows: Vec<Row>,
    /// The contacts that were found before in this step, as they were told.
    told: Vec<Contact>,
    /// Contacts that may be found to have been left too far.
    checkpoint: Vec<Contact>,
    /// Whether the contacts were restored: what was found since has its pressures from those in between.
    is_restored: bool,
    edge: f64,
    /// Positions that the contacts were found for \[m\].
    base: Vec<Vector3<f64>>,
    /// What is left along the direction of the forces that no contact has \[N\].
    others: Vec<Vector3<f64>>,
    /// What is left of all forces \[N\], then an inner direction \[m\].
    inner: Vec<Vector3<f64>>,
    product: Vec<Vector3<f64>>,
    reduced: Reduced,
    quick: Quick,
}

impl Gaps {
    /// Working memory for so many nodes, with the characteristic length `edge` \[m\].
    pub fn new(nodes: usize, edge: f64) -> Self {
        let zeros = vec![Vector3::zeros(); nodes];
        Self {
            contacts: Vec::new(),
            need_not_converge: false,
            keeps_laws: false,
            rows: Vec::new(),
            told: Vec::new(),
            checkpoint: Vec::new(),
            is_restored: false,
            edge,
            base: zeros.clone(),
            others: zeros.clone(),
            inner: zeros.clone(),
            product: zeros,
            reduced: Reduced::default(),
            quick: Quick::default(),
        }
    }

    /// Whether there are no contacts.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Forgets all contacts.
    pub fn clear(&mut self) {
        self.contacts.clear();
        self.rows.clear();
        self.told.clear();
    }

    /// Takes over the contacts that were found at `positions` in a step from `start`; `stiffness` is that of a node by itself \[N/m\], 0
    /// for a prescribed one. In statics old overlaps are pushed out by force, else they are only kept from going deeper.
    pub fn set(
        &mut self,
        start: &[Vector3<f64>],
        positions: &[Vector3<f64>],
        statics: bool,
        stiffness: impl Fn(usize) -> f64,
    ) {
        self.base.copy_from_slice(positions);
        if self.keeps_laws && self.rows.len() == self.contacts.len() {
            for (contact, row) in self.contacts.iter().zip(&mut self.rows) {
                let slide =
                    contact.interpolate(positions) - contact.interpolate(start) - contact.drift;
                row.gap = contact.gap(positions);
                row.slide = slide - contact.normal * contact.normal.dot(&slide);
                row.keeps_bound = true;
                // What has opened drags nothing, and what has closed since has its friction.
                let normal_force = row.told.normal_force;
                if normal_force <= 0.0 {
                    (row.bound, row.friction_force) = (0.0, Vector3::zeros());
                } else if row.bound == 0.0 {
                    row.bound = contact.friction * normal_force;
                }
            }
            return;
        }
        self.rows.clear();
        // Both lists have the same order, but for what came and went.
        let mut next = 0;
        let restored = std::mem::take(&mut self.is_restored);
        for contact in &mut self.contacts {
            let same = |told: &Contact| {
                told.nodes == contact.nodes
                    && told.first == contact.first
                    && told.normal.dot(&contact.normal) > 0.0
            };
            let from = self.told.iter().skip(next).position(same);
            let found = from
                .map(|k| k + next)
                .or_else(|| self.told.iter().position(same));
            next = found.map_or(next, |k| k + 1);
            if restored {
                contact.normal_force = found.map_or(0.0, |k| self.told[k].normal_force);
            }
            let last = found.map_or(&*contact, |k| &self.told[k]);
            let (friction_force, is_sliding) = (last.friction_force, last.is_sliding);
            let slide = contact.interpolate(positions) - contact.interpolate(start) - contact.drift;
            let mut compliances = [0.0; 2];
            let mut responses = [0.0; 4];
            for (k, (&node, weight)) in contact.nodes.iter().zip(contact.weights).enumerate() {
                let stiffness = stiffness(node as usize);
                if stiffness > 0.0 {
                    responses[k] = weight / stiffness;
                    let side = usize::from(k >= usize::from(contact.first));
                    compliances[side] += weight * weight / stiffness;
                }
            }
            let joint = compliances[0] > 0.0 && compliances[1] > 0.0;
            let share = if joint { SOFT } else { STIFF };
            let compliance = compliances[0] + compliances[1];
            let stiffness = if compliance > 0.0 {
                share / compliance
            } else {
                0.0
            };
            let across = friction_force - contact.normal * contact.normal.dot(&friction_force);
            self.rows.push(Row {
                told: Told {
                    normal_force: contact.normal_force,
                    friction_force: across,
                    is_sliding,
                },
                stiffness,
                joint,
                multiplier: contact.normal_force,
                friction_force: across,
                bound: contact.friction * contact.normal_force,
                keeps_bound: false,
                floor: match statics {
                    true => contact.floor,
                    false => contact.floor.min(contact.start_gap),
                },
                gap: contact.gap(positions),
                slide: slide - contact.normal * contact.normal.dot(&slide),
                responses,
                compliance,
                factored: None,
                hessian: Matrix3::zeros(),
            });
        }
    }

    /// The contacts that can move something.
    fn active(&self) -> impl Iterator<Item = (&Contact, &Row)> {
        let all = self.contacts.iter().zip(&self.rows);
        all.filter(|(_, row)| row.stiffness > 0.0)
    }

    /// Their energy at `positions` \[J\].
    pub fn energy(&self, positions: &[Vector3<f64>]) -> f64 {
        let energy = |(contact, row): (&Contact, &Row)| {
            let y = contact.interpolate(positions) - contact.interpolate(&self.base);
            row.law(contact, &y).energy
        };
        self.active().map(energy).sum()
    }

    /// Adds their forces at `positions` to those of the nodes \[N\].
    pub fn add_forces(&self, positions: &[Vector3<f64>], forces: &mut [Vector3<f64>]) {
        for (contact, row) in self.active() {
            let y = contact.interpolate(positions) - contact.interpolate(&self.base);
            let law = row.law(contact, &y);
            scatter(contact, &law.force(contact), forces);
        }
    }

    /// How far λ is from what it should be at the positions of the contacts, as a share of an edge: gaps below their floors, and forces
    /// across open ones.
    pub fn miss(&self) -> f64 {
        let miss = |(contact, row): (&Contact, &Row)| {
            let normal_force = row.law(contact, &Vector3::zeros()).told.normal_force;
            (normal_force - row.multiplier).abs() / row.stiffness
        };
        self.active().map(miss).fold(0.0, f64::max) / self.edge
    }

    /// How far a gap is below its floor at most, as a share of an edge.
    pub fn overlap(&self) -> f64 {
        let overlap = |(_, row): (&Contact, &Row)| row.floor - row.gap;
        self.active().map(overlap).fold(0.0, f64::max) / self.edge
    }

    /// Whether no node goes further in a direction than the share `most` of an edge.
    pub fn is_short(&self, direction: &[Vector3<f64>], most: f64) -> bool {
        let most = most * self.edge;
        direction.iter().all(|d| d.norm_squared() <= most * most)
    }

    /// Adds to a direction, of prescribed nodes so far, what single nodes go with surfaces that have moved: contacts that had a force
    /// stay closed, and none is deeper than its floor. Only a guess, but with the right contacts closed, and forces of the right size.
    pub fn predict(&self, direction: &mut [Vector3<f64>]) {
        for _ in 0..SWEEPS {
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

    /// Adds the contacts that are closed when the nodes go `direction` to the matrix.
    pub fn stiffen(&mut self, direction: &[Vector3<f64>], system: &mut System) {
        let quick = self.is_quick(system);
        for (contact, row) in self.contacts.iter().zip(&mut self.rows) {
            row.factored = None;
            if row.stiffness == 0.0 || row.joint || quick {
                continue;
            }
            let curvature = row.curvature(contact, &contact.interpolate(direction));
            if curvature != Matrix3::zeros() && system.add_contact(contact, &curvature) {
                row.factored = Some(curvature);
            }
        }
    }

    /// Whether the contacts are settled among themselves alone.
    pub fn is_quick(&self, system: &System) -> bool {
        self.need_not_converge && system.is_small() && !self.rows.iter().any(|row| row.joint)
    }

    /// Sets `direction`, which holds the ways of the prescribed nodes and a guess for the others, to that of the iteration, for the forces `others` \[N\] that no contact
    /// has. `tolerance` is the share of all forces that may be left, and `rough` where contacts have opened, closed or begun to slide; `slack`
    /// is the miss of multipliers that may be left, as a share of an edge.
    pub fn set_direction(
        &mut self,
        others: &[Vector3<f64>],
        fixed: &[bool],
        system: &mut System,
        [tolerance, rough, slack]: [f64; 3],
        direction: &mut [Vector3<f64>],
    ) -> Result<(), NotPositive> {
        self.others.copy_from_slice(others);
        if direction.iter().any(|d| *d != Vector3::zeros()) {
            let (left, product) = (&mut self.others, &mut self.product);
            multiply_others(system, &self.contacts, &self.rows, direction, product);
            left.iter_mut().zip(&*product).for_each(|(l, p)| *l -= p);
        }
        if self.is_quick(system) {
            return self.set_quick_direction(fixed, system, direction);
        }
        // Where nothing else acts, as when overlaps are undone, the forces of the guess are the measure.
        let scale = match size(others, fixed) {
            0.0 => size(&self.others, fixed),
            scale => scale,
        };
        let most = self.settle(fixed, system, [tolerance, rough, slack], scale, direction)?;
        let mut first = most.is_none();
        let Self {
            contacts,
            rows,
            edge,
            others: left,
            inner,
            product,
            ..
        } = self;
        let mut enough = 0.0;
        for _ in 0..UPDATES {
            for _ in 0..INNER {
                // What is left of all forces, and the curvature of contacts, at the direction so far.
                inner.copy_from_slice(left);
                let pushed = add_forces_along(contacts, rows, direction, inner);
                let missing = size(inner, fixed);
                let allowed = tolerance * scale.max(pushed);
                // What is left at the start may be little against all forces, and still all that a small load is to move.
                enough = rough.max(tolerance) / tolerance * allowed;
                enough = enough.min(most.unwrap_or(f64::INFINITY));
                if missing <= enough && (!first || missing == 0.0) {
                    break;
                }
                let share = 0.5 * if first { allowed } else { enough } / missing;
                let share = share.clamp(1e-9, 0.1);
                first = false;
                for (f, fixed) in inner.iter_mut().zip(fixed) {
                    if *fixed {
                        *f = Vector3::zeros();
                    }
                }
                product.copy_from_slice(inner);
                let apply = |p: &[Vector3<f64>], q: &mut [Vector3<f64>]| {
                    add_contacts(contacts, rows, p, q);
                };
                system.solve_with(apply, inner, share)?;
                let slope = -dot(product, inner);
                multiply_others(system, contacts, rows, inner, product);
                let stiffness = dot(inner, product);
                let step = search(contacts, rows, direction, inner, slope, stiffness, left);
                for ((d, i), (l, p)) in direction
                    .iter_mut()
                    .zip(&*inner)
                    .zip(left.iter_mut().zip(&*product))
                {
                    *d += i * step;
                    *l -= p * step;
                }
            }
            let (mut worst, mut changes) = (0.0f64, 0.0);
            for (contact, row) in contacts.iter().zip(&*rows) {
                if row.stiffness > 0.0 {
                    let (_, [miss, change]) = row.updated(contact, &contact.interpolate(direction));
                    worst = worst.max(miss);
                    changes += change;
                }
            }
            // In short steps forces are the sharper measure.
            let done = worst <= slack * *edge && changes.sqrt() <= enough;
            for (contact, row) in contacts.iter().zip(&mut *rows) {
                if row.stiffness > 0.0 {
                    let y = contact.interpolate(direction);
                    *row = row.updated(contact, &y).0;
                }
            }
            if done {
                break;
            }
        }
        Ok(())
    }

    /// Keeps the contacts, as they have become, for [`restore`](Self::restore).
    pub fn keep(&mut self) {
        self.tell();
        self.checkpoint.clone_from(&self.contacts);
    }

    /// Makes the contacts those that were kept.
    pub fn restore(&mut self) {
        self.contacts.clone_from(&self.checkpoint);
        self.rows.clear();
        self.is_restored = true;
    }

    /// Tells the contacts what they have become.
    pub fn tell(&mut self) {
        for (contact, row) in self.contacts.iter_mut().zip(&self.rows) {
            let told = row.told;
            contact.normal_force = told.normal_force;
            let share = row.bound / told.friction_force.norm().max(f64::MIN_POSITIVE);
            contact.friction_force = told.friction_force * share.min(1.0);
            contact.is_sliding = told.is_sliding || share <= 1.0;
        }
        self.told.clone_from(&self.contacts);
    }

    /// Makes of the contacts, as they are told, those that undo old overlaps at `positions`; says whether any is larger than the share
    /// `slack` of an edge. Not more than the share `most` is undone.
    pub fn set_undoing(&mut self, positions: &[Vector3<f64>], [slack, most]: [f64; 2]) -> bool {
        self.base.copy_from_slice(positions);
        let mut any = false;
        for (contact, row) in self.contacts.iter().zip(&mut self.rows) {
            row.multiplier = 0.0;
            (row.bound, row.keeps_bound) = (0.0, true);
            row.told = Told::NONE;
            row.floor = contact.floor.min(contact.start_gap + most * self.edge);
            row.gap = contact.gap(positions);
            any |= row.stiffness > 0.0 && row.gap < row.floor - slack * self.edge;
        }
        any
    }
}

/// A contact among the directions in which contacts see each other.
#[derive(Clone, Copy, Debug)]
struct Member {
    contact: usize,
    /// Its first direction, and how many there are: one along the normal, two more across it where there is friction.
    first: usize,
    count: usize,
    frame: Matrix3<f64>,
}

impl Member {
    /// The vector of its numbers.
    fn vector(&self, numbers: &[f64]) -> Vector3<f64> {
        let mut vector = Vector3::zeros();
        for k in 0..self.count {
            vector += self.frame.column(k) * numbers[self.first + k];
        }
        vector
    }
}

/// The directions of a contact: its normal, and two across it.
fn frame(contact: &Contact) -> Matrix3<f64> {
    let n = contact.normal;
    let across = n.cross(&Vector3::ith(n.iamin(), 1.0)).normalize();
    Matrix3::from_columns(&[n, across, n.cross(&across)])
}

/// How its nodes have a part in the way along one of these.
fn along(contact: &Contact, frame: &Matrix3<f64>, k: usize) -> [(u32, Vector3<f64>); 4] {
    std::array::from_fn(|i| (contact.nodes[i], frame.column(k) * contact.weights[i]))
}

/// The share of an inner direction at which the energy is lowest: all of it, but where contacts that it closes or opens say otherwise.
fn search(
    contacts: &[Contact],
    rows: &[Row],
    direction: &[Vector3<f64>],
    inner: &[Vector3<f64>],
    slope: f64,
    stiffness: f64,
    others: &[Vector3<f64>],
) -> f64 {
    let along = dot(others, inner);
    let slope_at = |share: f64| {
        let mut slope = share * stiffness - along;
        for (contact, row) in contacts.iter().zip(rows) {
            if row.stiffness > 0.0 {
                let way = contact.interpolate(inner);
                let y = contact.interpolate(direction) + way * share;
                slope -= row.law(contact, &y).force(contact).dot(&way);
            }
        }
        slope
    };
    lowest(slope, slope_at)
}

/// Where an energy that is convex along a step is lowest, from 0 to 1, by its slope at the start and along the way; 1 where it hardly rises
/// there.
fn lowest(start: f64, slope_at: impl Fn(f64) -> f64) -> f64 {
    if slope_at(1.0) <= 0.1 * start.abs() {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVES {
        let middle = 0.5 * (low + high);
        if slope_at(middle) > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

/// q = (matrix without contacts) p.
fn multiply_others(
    system: &System,
    contacts: &[Contact],
    rows: &[Row],
    p: &[Vector3<f64>],
    q: &mut [Vector3<f64>],
) {
    system.matrix().multiply(p, q);
    for (contact, row) in contacts.iter().zip(rows) {
        if let Some(factored) = &row.factored {
            subtract(contact, factored, p, q);
        }
    }
}

/// Adds to q what the contacts now are beyond what of them is in the matrix, times p.
fn add_contacts(contacts: &[Contact], rows: &[Row], p: &[Vector3<f64>], q: &mut [Vector3<f64>]) {
    for (contact, row) in contacts.iter().zip(rows) {
        if row.stiffness > 0.0 {
            scatter(contact, &(row.hessian * contact.interpolate(p)), q);
            if let Some(factored) = &row.factored {
                subtract(contact, factored, p, q);
            }
        }
    }
}

/// Takes what of a contact is in the matrix, times p, off q: the blocks of each side with itself.
fn subtract(
    contact: &Contact,
    factored: &Matrix3<f64>,
    p: &[Vector3<f64>],
    q: &mut [Vector3<f64>],
) {
    let first = usize::from(contact.first);
    for side in [0..first, first..4] {
        let mut sum = Vector3::zeros();
        for k in side.clone() {
            sum += p[contact.nodes[k] as usize] * contact.weights[k];
        }
        let force = factored * sum;
        for k in side {
            q[contact.nodes[k] as usize] -= force * contact.weights[k];
        }
    }
}

/// Adds the forces of contacts, where the nodes go `direction`, to those of the nodes \[N\], and sets their second derivatives; returns
/// their size \[N\].
fn add_forces_along(
    contacts: &[Contact],
    rows: &mut [Row],
    direction: &[Vector3<f64>],
    forces: &mut [Vector3<f64>],
) -> f64 {
    let mut pushed = 0.0;
    for (contact, row) in contacts.iter().zip(rows) {
        if row.stiffness > 0.0 {
            let y = contact.interpolate(direction);
            let force = row.law(contact, &y).force(contact);
            row.hessian = row.curvature(contact, &y);
            pushed += force.norm_squared();
            scatter(contact, &force, forces);
        }
    }
    pushed.sqrt()
}

/// Adds a force on the first side, and its opposite on the other, to the nodes.
fn scatter(contact: &Contact, force: &Vector3<f64>, forces: &mut [Vector3<f64>]) {
    for (&node, weight) in contact.nodes.iter().zip(contact.weights) {
        forces[node as usize] += force * weight;
    }
}

fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A source gives pressures by what it found last: after a way back that is not what is restored.
    #[test]
    fn restored_contacts_have_their_own_forces() {
        let positions = [Vector3::zeros(); 2];
        let on = |node, normal_force| Contact {
            normal_force,
            ..Contact::of_node(node, Vector3::z(), 0.0)
        };
        let mut gaps = Gaps::new(2, 1e-3);
        let find = |gaps: &mut Gaps, found: &[Contact]| {
            gaps.tell();
            gaps.contacts = found.to_vec();
            gaps.set(&positions, &positions, false, |_| 100.0);
        };
        find(&mut gaps, &[on(0, 0.1), on(1, 0.2)]);
        gaps.keep();
        find(&mut gaps, &[on(1, 0.1)]);
        gaps.restore();
        find(&mut gaps, &[on(0, 7.0), on(1, 7.0)]);
        assert_eq!(
            gaps.contacts
                .iter()
                .map(|c| c.normal_force)
                .collect::<Vec<_>>(),
            [0.1, 0.2]
        );
        assert_eq!(
            gaps.rows
                .iter()
                .map(|row| row.multiplier)
                .collect::<Vec<_>>(),
            [0.1, 0.2]
        );
        // The next time it is what the source says.
        find(&mut gaps, &[on(0, 0.3)]);
        assert_eq!(gaps.rows[0].multiplier, 0.3);
    }
}
