//! The contacts of an iteration among themselves, where they are few.
//!
//! The factored matrix is A = K + Σ wᵀ F w with what of the contacts is in it. From a direction with the ways y of the contacts, their
//! forces f(y) and the forces r left with these, what is missing of the direction is δ with
//!
//! ```text
//! A δ = r + Jᵀ (p − f(y))        p = f(y + J δ) + F J δ        so η = J δ = J A⁻¹ r + G (p − f(y))        G = J A⁻¹ Jᵀ
//! ```
//!
//! where J gives the ways of the contacts: one number for each without friction, three with. So once G is known the multipliers, and
//! what is closed and what slides, are found in small dense systems. It is Newton's method for the same energy, now a function of p,
//! whose gradient is G (p − f − F η).

use super::row::Row;
use super::{
    Gaps, INNER, Member, UPDATES, add_forces_along, along, frame, lowest, multiply_others, scatter,
};
use crate::contact::Contact;
use crate::system::System;
use microsim_sparse::NotPositive;
use nalgebra::{Matrix3, Vector3};

/// Most directions: beyond, conjugate gradients take less time.
const MOST: usize = 96;
/// Most solutions, each with the contacts that the one before has closed.
const ROUNDS: u32 = 4;

/// What may be left of what is missing at the start, and the share of what may be left in the end to which the parts are solved.
const LEAST: f64 = 0.1;
const SHARE: f64 = 0.25;

/// A contact where a direction is sought.
#[derive(Clone, Copy, Debug)]
struct Start {
    of: Member,
    /// y of the direction so far.
    base: Vector3<f64>,
    /// f(y) there.
    force: Vector3<f64>,
}

/// Working memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Reduced {
    members: Vec<Start>,
    /// J.
    directions: Vec<[(u32, Vector3<f64>); 4]>,
    /// G \[m/N\].
    compliance: Vec<f64>,
    /// η \[m\] and p \[N\].
    ways: Vec<f64>,
    forces: Vec<f64>,
    /// p − f − F η, then its change; and that of the ways.
    force_step: Vec<f64>,
    way_step: Vec<f64>,
    /// The directions whose second derivative is not that in A, and the matrix of their equations with the right-hand side.
    changed: Vec<usize>,
    matrix: Vec<f64>,
}

impl Gaps {
    /// Adds to `direction` what is missing of it, and sets the multipliers, if there are few contacts enough, none between two bodies that
    /// can move, and the system has a factor;
    /// returns what may be left of all forces then \[N\], else none. There may be more, if the factor has too few digits.
    pub(super) fn settle(
        &mut self,
        fixed: &[bool],
        system: &mut System,
        [tolerance, rough, slack]: [f64; 3],
        scale: f64,
        direction: &mut [Vector3<f64>],
    ) -> Result<Option<f64>, NotPositive> {
        self.reduced.members.clear();
        self.reduced.directions.clear();
        // Contacts between two bodies that can move are soft here, and a stack of them does not come to its last digits.
        if self.rows.iter().any(|row| row.joint) {
            return Ok(None);
        }
        let rough = rough.max(tolerance);
        let mut most = None;
        for _ in 0..ROUNDS {
            self.inner.copy_from_slice(&self.others);
            let (contacts, rows) = (&self.contacts, &mut self.rows);
            let pushed = add_forces_along(contacts, rows, direction, &mut self.inner);
            let missing = size(&self.inner, fixed);
            let largest = scale.max(pushed);
            if missing <= most.map_or(0.0, |most: f64| most.min(rough * largest)) {
                break;
            }
            let reduced = &mut self.reduced;
            let joined = reduced.join(contacts, rows);
            if (joined || most.is_none())
                && (reduced.directions.len() > MOST
                    || !system.set_compliance(&reduced.directions, &mut reduced.compliance))
            {
                return Ok(None);
            }
            let most = *most.get_or_insert(LEAST * missing);
            let enough = most.min(rough * largest.max(missing));
            solve(system, fixed, SHARE * enough, &mut self.inner)?;
            reduced.begin(contacts, rows, direction, &self.inner);
            let goals = [most, rough, slack * self.edge];
            let enough = reduced.balance(contacts, rows, scale, goals);
            self.product.fill(Vector3::zeros());
            for member in &reduced.members {
                let force = member.of.vector(&reduced.forces) - member.force;
                scatter(&contacts[member.of.contact], &force, &mut self.product);
            }
            solve(system, fixed, SHARE * enough, &mut self.product)?;
            for ((step, more), d) in self
                .inner
                .iter_mut()
                .zip(&self.product)
                .zip(&mut *direction)
            {
                *step += more;
                *d += *step;
            }
            multiply_others(system, contacts, rows, &self.inner, &mut self.product);
            for (left, product) in self.others.iter_mut().zip(&self.product) {
                *left -= product;
            }
        }
        Ok(most)
    }
}

/// Solves with the factored matrix until no more than `allowed` \[N\] is left; 0 at the nodes that are fixed.
fn solve(
    system: &mut System,
    fixed: &[bool],
    allowed: f64,
    x: &mut [Vector3<f64>],
) -> Result<(), NotPositive> {
    for (x, fixed) in x.iter_mut().zip(fixed) {
        if *fixed {
            *x = Vector3::zeros();
        }
    }
    let missing = size(x, fixed);
    if missing <= allowed {
        x.fill(Vector3::zeros());
        return Ok(());
    }
    system.solve(x, (allowed / missing).clamp(1e-9, 0.1))
}

/// The size of the forces at the nodes that are not fixed \[N\].
pub(super) fn size(forces: &[Vector3<f64>], fixed: &[bool]) -> f64 {
    let free = forces.iter().zip(fixed).filter(|(_, fixed)| !**fixed);
    free.map(|(f, _)| f.norm_squared()).sum::<f64>().sqrt()
}

/// What of a contact is in the matrix.
fn factored(row: &Row) -> Matrix3<f64> {
    row.factored.unwrap_or_else(Matrix3::zeros)
}

impl Reduced {
    /// Takes in the contacts that have forces or are in the matrix and were not there; says whether there are any.
    fn join(&mut self, contacts: &[Contact], rows: &[Row]) -> bool {
        let before = self.members.len();
        for (index, (contact, row)) in contacts.iter().zip(rows).enumerate() {
            let acts =
                row.factored.is_some() || row.multiplier > 0.0 || row.hessian != Matrix3::zeros();
            let known = self.members[..before].iter().any(|m| m.of.contact == index);
            if row.stiffness == 0.0 || !acts || known {
                continue;
            }
            let frame = frame(contact);
            let count = if contact.friction > 0.0 { 3 } else { 1 };
            self.members.push(Start {
                of: Member {
                    contact: index,
                    first: self.directions.len(),
                    count,
                    frame,
                },
                base: Vector3::zeros(),
                force: Vector3::zeros(),
            });
            for k in 0..count {
                self.directions.push(along(contact, &frame, k));
            }
        }
        self.members.len() > before
    }

    /// Sets y, p = f(y) and η, for the ways that nodes go with these forces as they are.
    fn begin(
        &mut self,
        contacts: &[Contact],
        rows: &[Row],
        direction: &[Vector3<f64>],
        ways: &[Vector3<f64>],
    ) {
        let count = self.directions.len();
        for numbers in [
            &mut self.ways,
            &mut self.forces,
            &mut self.force_step,
            &mut self.way_step,
        ] {
            numbers.clear();
            numbers.resize(count, 0.0);
        }
        for member in &mut self.members {
            let contact = &contacts[member.of.contact];
            member.base = contact.interpolate(direction);
            member.force = rows[member.of.contact]
                .law(contact, &member.base)
                .force(contact);
            let way = contact.interpolate(ways);
            for k in 0..member.of.count {
                self.forces[member.of.first + k] = member.of.frame.column(k).dot(&member.force);
                self.ways[member.of.first + k] = member.of.frame.column(k).dot(&way);
            }
        }
    }

    /// Finds the p that the laws of the contacts say, and the multipliers: until what p is wrong by, and what these change, is small
    /// against all forces, of which all others have the size `scale` \[N\], and the miss of gaps too \[m\]. Returns what may be left in the
    /// end \[N\], no more than `most`.
    fn balance(
        &mut self,
        contacts: &[Contact],
        rows: &mut [Row],
        scale: f64,
        [most, rough, slack]: [f64; 3],
    ) -> f64 {
        let mut enough = most;
        for _ in 0..UPDATES {
            for _ in 0..INNER {
                self.changed.clear();
                let mut pushed = 0.0;
                for member in &self.members {
                    let (contact, row) =
                        (&contacts[member.of.contact], &mut rows[member.of.contact]);
                    let way = member.of.vector(&self.ways);
                    let y = member.base + way;
                    let mut force = row.law(contact, &y).force(contact);
                    pushed += force.norm_squared();
                    force += factored(row) * way;
                    row.hessian = row.curvature(contact, &y);
                    for k in 0..member.of.count {
                        let at = member.of.first + k;
                        self.force_step[at] =
                            self.forces[at] - member.of.frame.column(k).dot(&force);
                        if row.hessian != factored(row) {
                            self.changed.push(at);
                        }
                    }
                }
                let wrong = self.force_step.iter().map(|g| g * g).sum::<f64>().sqrt();
                enough = most.min(rough * scale.max(pushed.sqrt()));
                if wrong <= SHARE * enough {
                    break;
                }
                self.newton(rows);
                let share = self.search(contacts, rows);
                for (force, step) in self.forces.iter_mut().zip(&self.force_step) {
                    *force += step * share;
                }
                for (way, step) in self.ways.iter_mut().zip(&self.way_step) {
                    *way += step * share;
                }
            }
            let (mut worst, mut changes) = (0.0f64, 0.0);
            for member in &self.members {
                let y = member.base + member.of.vector(&self.ways);
                let (_, [miss, change]) =
                    rows[member.of.contact].updated(&contacts[member.of.contact], &y);
                worst = worst.max(miss);
                changes += change;
            }
            if worst <= slack && changes.sqrt() <= enough {
                break;
            }
            for member in &self.members {
                let y = member.base + member.of.vector(&self.ways);
                let row = &mut rows[member.of.contact];
                *row = row.updated(&contacts[member.of.contact], &y).0;
            }
        }
        enough
    }

    /// Sets the steps of Newton's method from p − f − F η =: g: (1 + (H − F) G) Δp = −g.
    fn newton(&mut self, rows: &[Row]) {
        let count = self.directions.len();
        let size = self.changed.len();
        // The others go by −g, which the changed ones see.
        multiply(&self.compliance, &self.force_step, &mut self.way_step);
        self.matrix.clear();
        self.matrix.resize(size * (size + 1), 0.0);
        let mut at = 0;
        for member in &self.members {
            let row = &rows[member.of.contact];
            let more = row.hessian - factored(row);
            if more == Matrix3::zeros() {
                continue;
            }
            let more = member.of.frame.tr_mul(&(more * member.of.frame));
            for a in 0..member.of.count {
                let equation = &mut self.matrix[at * (size + 1)..][..size + 1];
                equation[at] = 1.0;
                for b in 0..member.of.count {
                    let compliance = &self.compliance[(member.of.first + b) * count..][..count];
                    for (entry, &changed) in equation.iter_mut().zip(&self.changed) {
                        *entry += more[(a, b)] * compliance[changed];
                    }
                    // Δp = −g + Δq with (1 + (H − F) G) Δq = (H − F) G g.
                    equation[size] += more[(a, b)] * self.way_step[member.of.first + b];
                }
                at += 1;
            }
        }
        eliminate(&mut self.matrix, size);
        for (way, step) in self.way_step.iter_mut().zip(&mut self.force_step) {
            *way = -*way;
            *step = -*step;
        }
        for (k, &changed) in self.changed.iter().enumerate() {
            let more = self.matrix[k * (size + 1) + size];
            // G is symmetric.
            self.force_step[changed] += more;
            let compliance = &self.compliance[changed * count..][..count];
            for (way, compliance) in self.way_step.iter_mut().zip(compliance) {
                *way += compliance * more;
            }
        }
    }

    /// The share of a step at which the energy is lowest: all of it, but where contacts that it closes or opens say otherwise.
    fn search(&self, contacts: &[Contact], rows: &[Row]) -> f64 {
        let slope_at = |share: f64| {
            let mut slope = 0.0;
            for member in &self.members {
                let (contact, row) = (&contacts[member.of.contact], &rows[member.of.contact]);
                let step = member.of.vector(&self.way_step);
                let way = member.of.vector(&self.ways) + step * share;
                let force =
                    member.of.vector(&self.forces) + member.of.vector(&self.force_step) * share;
                let law = row.law(contact, &(member.base + way)).force(contact);
                slope += step.dot(&(force - factored(row) * way - law));
            }
            slope
        };
        lowest(slope_at(0.0), slope_at)
    }
}

/// y = G x, for a matrix that is symmetric.
fn multiply(matrix: &[f64], x: &[f64], y: &mut [f64]) {
    y.fill(0.0);
    for (row, x) in matrix.chunks_exact(x.len().max(1)).zip(x) {
        y.iter_mut().zip(row).for_each(|(y, entry)| *y += entry * x);
    }
}

/// Solves so many equations in place by elimination with the largest pivot of a column; each row ends with its right-hand side. A column
/// of zeros gives 0.
fn eliminate(matrix: &mut [f64], size: usize) {
    let length = size + 1;
    for column in 0..size {
        let pivot = (column..size)
            .max_by(|a, b| {
                let entry = |row: &usize| matrix[row * length + column].abs();
                entry(a).total_cmp(&entry(b))
            })
            .unwrap_or(column);
        for k in column..length {
            matrix.swap(pivot * length + k, column * length + k);
        }
        let (done, below) = matrix.split_at_mut((column + 1) * length);
        let row = &done[column * length..];
        if row[column] == 0.0 {
            continue;
        }
        for other in below.chunks_exact_mut(length) {
            let share = other[column] / row[column];
            if share != 0.0 {
                let others = other[column..].iter_mut().zip(&row[column..]);
                others.for_each(|(other, entry)| *other -= share * entry);
            }
        }
    }
    for column in (0..size).rev() {
        let pivot = matrix[column * length + column];
        let mut sum = matrix[column * length + size];
        for k in column + 1..size {
            sum -= matrix[column * length + k] * matrix[k * length + size];
        }
        matrix[column * length + size] = if pivot == 0.0 { 0.0 } else { sum / pivot };
    }
}
