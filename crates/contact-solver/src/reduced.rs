//! The contacts of an iteration among themselves, where they are few.
//!
//! The factored matrix is A = K + Σ wᵀ F w with what of the contacts is in it. From a displacement with the motions y of the contacts,
//! their forces f(y) and the forces r left with these, what is missing of the displacement is δ with
//!
//! ```text
//! A δ = r + Jᵀ (p − f(y))        p = f(y + J δ) + F J δ        so η = J δ = J A⁻¹ r + G (p − f(y))        G = J A⁻¹ Jᵀ
//! ```
//!
//! where J gives the motions of the contacts: one number for each without friction, three with. So once the Delassus operator G is known
//! the multipliers, and what is closed and what slides, are found in small dense systems. It is Newton's method for the same energy, now
//! a function of p, whose gradient is G (p − f − F η).
//!
//! The step of a round is shortened where the energy of the step, with all contacts, rises along it; its multipliers remain. It does where contacts that had no part in it close far
//! behind their surfaces: a shred that a blade lets go flies on until something is in its path. And it does where nothing but contacts holds a
//! shred: without them its response, by its mass alone, is a difference of almost equal numbers of the factor, and what comes of that is no
//! direction of descent. Then the round is dropped.

use crate::contact::Contact;
use crate::directions::{self, Member};
use crate::energy_line::EnergyLine;
use crate::options::AugmentedLagrangianOptions;
use crate::row::Row;
use crate::solver::{LinearSystem, Tolerances};
use crate::system_forces::{add_forces_along, multiply_without_contacts};
use crate::vectors::{clear_fixed, convex_search, norm_of_free, scatter};
use microsim_sparse::NotPositive;
use nalgebra::{Matrix3, Vector3};

/// Changes of an energy below this fraction of its terms are within the digits of an f32 factor's response.
const FACTOR_ROUNDING: f64 = 1e-6;

/// What an operation of an elimination that is not blocked takes, over one of the dense kernels of a factor. A judgement by the numbers that it loads and stores; not measured.
const UNBLOCKED: f64 = 4.0;

/// A contact where a displacement is sought.
#[derive(Clone, Copy, Debug)]
struct Start {
    of: Member,
    /// y of the displacement so far.
    base: Vector3<f64>,
    /// f(y) there.
    force: Vector3<f64>,
}

/// Working memory.
#[derive(Clone, Debug)]
pub(crate) struct Reduced {
    options: AugmentedLagrangianOptions,
    members: Vec<Start>,
    /// J.
    directions: Vec<directions::Row>,
    /// G \[m/N\].
    delassus: Vec<f64>,
    /// η \[m\] and p \[N\].
    motions: Vec<f64>,
    forces: Vec<f64>,
    /// p − f − F η, then its change; and that of the motions.
    force_step: Vec<f64>,
    motion_step: Vec<f64>,
    /// The directions whose curvature is not that in A, and the matrix of their equations with the right-hand side.
    changed: Vec<usize>,
    matrix: Vec<f64>,
    /// The rows at the start of a round.
    before: Vec<Row>,
    /// Operations since they were asked for last.
    pub operations: f64,
}

impl Reduced {
    pub fn new(options: AugmentedLagrangianOptions) -> Self {
        Self {
            options,
            members: Vec::new(),
            directions: Vec::new(),
            delassus: Vec::new(),
            motions: Vec::new(),
            forces: Vec::new(),
            force_step: Vec::new(),
            motion_step: Vec::new(),
            changed: Vec::new(),
            matrix: Vec::new(),
            before: Vec::new(),
            operations: 0.0,
        }
    }

    /// Adds to `direction` what is missing of it, and sets the multipliers, if there are few enough contacts, none between two bodies that
    /// can move, the system has a factor and its response leads to less energy; returns what may be left of all forces then \[N\], else none;
    /// rounds before one that does not descend count.
    /// There may be more, if the factor has too few digits, or if more operations are taken than `most_operations`, counted with those of the system. `scale` is the norm of the forces that no contact has \[N\]; of `work`, the first is what is left of
    /// them.
    pub fn solve(
        &mut self,
        (contacts, rows, edge): (&[Contact], &mut [Row], f64),
        (system, fixed, tolerances): (&mut dyn LinearSystem, &[bool], Tolerances),
        most_operations: f64,
        scale: f64,
        [left, inner, product]: [&mut [Vector3<f64>]; 3],
        direction: &mut [Vector3<f64>],
    ) -> Result<Option<f64>, NotPositive> {
        self.members.clear();
        self.directions.clear();
        // Contacts between two bodies that can move have a small penalty here, and a stack of them does not come to its last digits.
        if rows.iter().any(|row| row.is_between_bodies) {
            return Ok(None);
        }
        let options = self.options.reduced;
        let limits = self.options.linear_tolerances;
        let rough = tolerances.changes.max(tolerances.residual);
        let mut most = None;
        for _ in 0..options.rounds {
            inner.copy_from_slice(left);
            let pushed = add_forces_along(contacts, rows, direction, inner);
            let missing = norm_of_free(inner, fixed);
            let largest = scale.max(pushed);
            let is_spent = system.operations() + self.operations >= most_operations;
            if missing <= most.map_or(0.0, |most: f64| most.min(rough * largest))
                || (most.is_some() && is_spent)
            {
                break;
            }
            let joined = self.join(contacts, rows);
            if (joined || most.is_none())
                && (self.directions.len() > options.directions
                    || !system.set_delassus(&self.directions, &mut self.delassus))
            {
                return Ok(None);
            }
            let most = *most.get_or_insert(options.decrease * missing);
            let enough = most.min(rough * largest.max(missing));
            solve(system, fixed, options.inexactness * enough, limits, inner)?;
            self.before.clear();
            self.before.extend_from_slice(rows);
            self.begin(contacts, rows, direction, inner);
            let goals = [most, rough, tolerances.multipliers * edge];
            let most_operations = most_operations - system.operations();
            let enough = self.balance(contacts, rows, scale, goals, most_operations);
            product.fill(Vector3::zeros());
            for member in &self.members {
                let force = member.of.vector(&self.forces) - member.force;
                scatter(&contacts[member.of.contact], &force, product);
            }
            solve(system, fixed, options.inexactness * enough, limits, product)?;
            for (step, more) in inner.iter_mut().zip(&*product) {
                *step += more;
            }
            multiply_without_contacts(system, contacts, rows, inner, product);
            let line = EnergyLine::new((contacts, rows), [direction, inner], [left, product]);
            let mut length = 1.0;
            if line.rises(FACTOR_ROUNDING) {
                let slope = line.slope_at(0.0);
                if slope.is_nan() || slope >= 0.0 || !line.slope_at(1.0).is_finite() {
                    rows.copy_from_slice(&self.before);
                    return Ok(None);
                }
                let (flat, bisections) = (self.options.flat_slope, self.options.bisections);
                length = line.lowest(slope, flat, bisections);
            }
            let of_nodes = direction.iter_mut().zip(left.iter_mut());
            for ((d, left), (step, product)) in of_nodes.zip(inner.iter().zip(&*product)) {
                *d += step * length;
                *left -= product * length;
            }
        }
        Ok(most)
    }

    /// Takes in the contacts that have forces or are in the matrix and were not there; returns whether there are any.
    fn join(&mut self, contacts: &[Contact], rows: &[Row]) -> bool {
        let before = self.members.len();
        for (index, (contact, row)) in contacts.iter().zip(rows).enumerate() {
            let acts =
                row.factored.is_some() || row.multiplier > 0.0 || row.hessian != Matrix3::zeros();
            let known = self.members[..before].iter().any(|m| m.of.contact == index);
            if row.penalty == 0.0 || !acts || known {
                continue;
            }
            self.members.push(Start {
                of: Member::new(index, contact, &mut self.directions),
                base: Vector3::zeros(),
                force: Vector3::zeros(),
            });
        }
        self.members.len() > before
    }

    /// Sets y, p = f(y) and η, for the displacements of the nodes with these forces as they are.
    fn begin(
        &mut self,
        contacts: &[Contact],
        rows: &[Row],
        direction: &[Vector3<f64>],
        inner: &[Vector3<f64>],
    ) {
        let count = self.directions.len();
        for numbers in [
            &mut self.motions,
            &mut self.forces,
            &mut self.force_step,
            &mut self.motion_step,
        ] {
            numbers.clear();
            numbers.resize(count, 0.0);
        }
        for member in &mut self.members {
            let contact = &contacts[member.of.contact];
            member.base = contact.interpolate(direction);
            member.force = rows[member.of.contact].force_at(contact, &member.base);
            let motion = contact.interpolate(inner);
            for k in 0..member.of.count {
                self.forces[member.of.first + k] = member.of.frame.column(k).dot(&member.force);
                self.motions[member.of.first + k] = member.of.frame.column(k).dot(&motion);
            }
        }
    }

    /// Finds the p of the laws of the contacts, and the multipliers: until the error of p, and what the updates of multipliers change, is
    /// small against all forces, of which all others have the norm `scale` \[N\], and the multiplier residual too \[m\]. Returns what may
    /// be left in the end \[N\], no more than `most`.
    fn balance(
        &mut self,
        contacts: &[Contact],
        rows: &mut [Row],
        scale: f64,
        [most, rough, gap_tolerance]: [f64; 3],
        most_operations: f64,
    ) -> f64 {
        let mut enough = most;
        for _ in 0..self.options.updates {
            for inner in 0..self.options.inner_iterations {
                self.changed.clear();
                let mut pushed = 0.0;
                for member in &self.members {
                    let (contact, row) =
                        (&contacts[member.of.contact], &mut rows[member.of.contact]);
                    let motion = member.of.vector(&self.motions);
                    let y = member.base + motion;
                    let mut force = row.force_at(contact, &y);
                    pushed += force.norm_squared();
                    force += row.factored() * motion;
                    row.hessian = row.curvature(contact, &y);
                    for k in 0..member.of.count {
                        let at = member.of.first + k;
                        self.force_step[at] =
                            self.forces[at] - member.of.frame.column(k).dot(&force);
                        if row.hessian != row.factored() {
                            self.changed.push(at);
                        }
                    }
                }
                let wrong = self.force_step.iter().map(|g| g * g).sum::<f64>().sqrt();
                enough = most.min(rough * scale.max(pushed.sqrt()));
                let is_spent = inner > 0 && self.operations >= most_operations;
                if wrong <= self.options.reduced.inexactness * enough || is_spent {
                    break;
                }
                self.newton(rows);
                let length = self.search(contacts, rows);
                for (force, step) in self.forces.iter_mut().zip(&self.force_step) {
                    *force += step * length;
                }
                for (motion, step) in self.motions.iter_mut().zip(&self.motion_step) {
                    *motion += step * length;
                }
            }
            let (mut worst, mut changes) = (0.0f64, 0.0);
            for member in &self.members {
                let y = member.base + member.of.vector(&self.motions);
                let (_, [residual, change]) =
                    rows[member.of.contact].updated(&contacts[member.of.contact], &y);
                worst = worst.max(residual);
                changes += change;
            }
            let is_spent = self.operations >= most_operations;
            if (worst <= gap_tolerance && changes.sqrt() <= enough) || is_spent {
                break;
            }
            for member in &self.members {
                let y = member.base + member.of.vector(&self.motions);
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
        self.operations += operations_of_a_step(count, size);
        // The others go by −g, which the changed ones see.
        multiply(&self.delassus, &self.force_step, &mut self.motion_step);
        self.matrix.clear();
        self.matrix.resize(size * (size + 1), 0.0);
        let mut at = 0;
        for member in &self.members {
            let row = &rows[member.of.contact];
            let more = row.hessian - row.factored();
            if more == Matrix3::zeros() {
                continue;
            }
            let more = member.of.frame.tr_mul(&(more * member.of.frame));
            for a in 0..member.of.count {
                let equation = &mut self.matrix[at * (size + 1)..][..size + 1];
                equation[at] = 1.0;
                for b in 0..member.of.count {
                    let compliance = &self.delassus[(member.of.first + b) * count..][..count];
                    for (entry, &changed) in equation.iter_mut().zip(&self.changed) {
                        *entry += more[(a, b)] * compliance[changed];
                    }
                    // Δp = −g + Δq with (1 + (H − F) G) Δq = (H − F) G g.
                    equation[size] += more[(a, b)] * self.motion_step[member.of.first + b];
                }
                at += 1;
            }
        }
        eliminate(&mut self.matrix, size);
        for (motion, step) in self.motion_step.iter_mut().zip(&mut self.force_step) {
            *motion = -*motion;
            *step = -*step;
        }
        for (k, &changed) in self.changed.iter().enumerate() {
            let more = self.matrix[k * (size + 1) + size];
            // G is symmetric.
            self.force_step[changed] += more;
            let compliance = &self.delassus[changed * count..][..count];
            for (motion, compliance) in self.motion_step.iter_mut().zip(compliance) {
                *motion += compliance * more;
            }
        }
    }

    /// The step length at which the energy is lowest: 1, but where contacts that it closes or opens matter.
    fn search(&self, contacts: &[Contact], rows: &[Row]) -> f64 {
        let slope_at = |length: f64| {
            let mut slope = 0.0;
            for member in &self.members {
                let (contact, row) = (&contacts[member.of.contact], &rows[member.of.contact]);
                let step = member.of.vector(&self.motion_step);
                let motion = member.of.vector(&self.motions) + step * length;
                let force =
                    member.of.vector(&self.forces) + member.of.vector(&self.force_step) * length;
                let law = row.force_at(contact, &(member.base + motion));
                slope += step.dot(&(force - row.factored() * motion - law));
            }
            slope
        };
        convex_search(
            slope_at(0.0),
            self.options.flat_slope,
            self.options.bisections,
            slope_at,
        )
    }
}

/// Operations of a step of Newton's method with so many directions, of which so many have changed.
fn operations_of_a_step(directions: usize, changed: usize) -> f64 {
    let [count, size] = [directions, changed].map(|of| of as f64);
    let eliminated = size * size * (size / 3.0 + 3.0) + count * (count + size);
    UNBLOCKED * eliminated
}

/// Solves with the factored matrix to a residual of at most `allowed` \[N\]; 0 at the nodes that are fixed.
fn solve(
    system: &mut dyn LinearSystem,
    fixed: &[bool],
    allowed: f64,
    [least, largest]: [f64; 2],
    x: &mut [Vector3<f64>],
) -> Result<(), NotPositive> {
    clear_fixed(x, fixed);
    let missing = norm_of_free(x, fixed);
    if missing <= allowed {
        x.fill(Vector3::zeros());
        return Ok(());
    }
    system.solve(x, (allowed / missing).clamp(least, largest))
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
            let ratio = other[column] / row[column];
            if ratio != 0.0 {
                let others = other[column..].iter_mut().zip(&row[column..]);
                others.for_each(|(other, entry)| *other -= ratio * entry);
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
