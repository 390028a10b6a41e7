//! Contact by an interior-point method: one factor of everything but the contacts, and these among themselves.
//!
//! With the factored matrix K of a positive tangent, which is positive definite without any contact, the motions y of the contacts are
//! those without their forces and G p, with the Delassus operator G = J K⁻¹ Jᵀ. So the forces p follow from small dense problems
//! (`cone_program`), and the displacement from them by one more solution: all forces are in equilibrium to rounding at its end, which a
//! light free piece in a firm grip needs: a thousandth of the grip is many times its weight.
//!
//! Contacts that had a force are taken in first; those that the displacement closes then join them, a few times. Friction bounds are those
//! of the normal forces of the solution before, twice in an iteration: Coulomb's law is met as iterations converge. In the end the
//! multipliers of the augmented Lagrangian ([`ContactSet`]) are set such that its forces are these.
//!
//! # Limitations
//! Contacts between two bodies that both can move are not here. What closes only with the last contacts that joined pushes as a spring
//! until the next iteration.

use crate::cone_program::{Cone, ConeProgram};
use crate::contact::Contact;
use crate::directions::{self, Member};
use crate::options::InteriorPointOptions;
use crate::row::{ContactForce, Row};
use crate::set::ContactSet;
use crate::solver::{ContactSolver, LinearSystem, SystemResponse};
use crate::vectors::{clear_fixed, scatter};
use microsim_sparse::NotPositive;
use nalgebra::Vector3;

/// Factors that the forces of a round usually take.
const USUAL_FACTORS: f64 = 24.0;

/// The method, with its working memory. The matrix must not hold any contact, and must have an f64 Cholesky factor.
///
/// ```
/// use microsim_contact_solver::{
///     AugmentedLagrangianOptions, Contact, ContactSet, ContactSolver, InteriorPoint, InteriorPointOptions,
///     NodalSystem, SystemResponse, Tolerances,
/// };
/// use nalgebra::Vector3;
///
/// // A node with a stiffness of 100 N/m on a floor with friction is pushed down by 0.3 N and along by 0.2 N.
/// let positions = [Vector3::zeros()];
/// let mut contacts = ContactSet::new(1, 1e-2, AugmentedLagrangianOptions::default());
/// contacts.contacts.push(Contact {
///     friction: 0.5,
///     normal_force: 0.3,
///     ..Contact::of_node(0, Vector3::z(), 0.0)
/// });
/// contacts.linearise(&positions, &positions, true, |_| 100.0);
/// let mut system = NodalSystem::new(vec![100.0]);
/// let mut displacement = [Vector3::zeros()];
/// let response = SystemResponse {
///     system: &mut system,
///     forces: &[Vector3::new(0.2, 0.0, -0.3)],
///     fixed: &[false],
///     tolerances: Tolerances { residual: 1e-9, changes: 1e-9, multipliers: 1e-9 },
///     most_operations: f64::INFINITY,
/// };
/// InteriorPoint::new(1, InteriorPointOptions::default()).solve(&mut contacts, response, &mut displacement)?;
/// contacts.publish();
/// // It slides: friction takes 0.5 · 0.3 N of the 0.2 N, the stiffness the rest.
/// assert!(contacts.contacts[0].is_sliding);
/// assert!((displacement[0] - Vector3::x() * 5e-4).norm() < 1e-6);
/// # Ok::<(), microsim_sparse::NotPositive>(())
/// ```
#[derive(Clone, Debug)]
pub struct InteriorPoint {
    options: InteriorPointOptions,
    /// Residual of the forces that no contact has \[N\].
    left: Vec<Vector3<f64>>,
    /// Response to contact forces \[m\].
    inner: Vec<Vector3<f64>>,
    members: Vec<Member>,
    /// The contacts that are to join.
    candidates: Vec<usize>,
    cones: Vec<Cone>,
    /// J.
    directions: Vec<directions::Row>,
    /// G, and its regularisation \[m/N\].
    delassus: Vec<f64>,
    regularisation: Vec<f64>,
    /// The forces before \[N\].
    before: Vec<f64>,
    /// The motions without forces \[m\], less what the regularisation makes of the forces before, and the forces \[N\].
    motions: Vec<f64>,
    forces: Vec<f64>,
    program: ConeProgram,
}

impl ContactSolver<SystemResponse<'_>> for InteriorPoint {
    type Contacts = ContactSet;

    fn solve(
        &mut self,
        contacts: &mut ContactSet,
        response: SystemResponse<'_>,
        motion: &mut [Vector3<f64>],
    ) -> Result<(), NotPositive> {
        let SystemResponse {
            system,
            forces,
            fixed,
            ..
        } = response;
        let direction = motion;
        let set = contacts;
        let (contacts, rows, edge) = set.parts();
        let mut failed = false;
        self.left.copy_from_slice(forces);
        if direction.iter().any(|d| *d != Vector3::zeros()) {
            system.multiply(direction, &mut self.inner);
            let product = self.left.iter_mut().zip(&self.inner);
            product.for_each(|(l, p)| *l -= p);
        }
        let gap_tolerance = self.options.gap_tolerance * edge;
        let linear_tolerance = self.options.linear_tolerance;
        // Without any contact.
        self.inner.copy_from_slice(&self.left);
        solve(system, fixed, linear_tolerance, &mut self.inner)?;
        let both = direction.iter_mut().zip(&self.inner);
        both.for_each(|(d, i)| *d += i);
        self.inner.fill(Vector3::zeros());
        self.clear();
        for _ in 0..self.options.rounds {
            if !self.join(contacts, rows, direction, gap_tolerance) {
                break;
            }
            let known = system.set_delassus(&self.directions, &mut self.delassus);
            debug_assert!(known, "there is an f64 Cholesky factor");
            failed |= !self.balance(contacts, rows, direction);
            self.inner.fill(Vector3::zeros());
            for member in &self.members {
                let force = member.vector(&self.forces);
                scatter(&contacts[member.contact], &force, &mut self.inner);
            }
            solve(system, fixed, linear_tolerance, &mut self.inner)?;
        }
        let both = direction.iter_mut().zip(&self.inner);
        both.for_each(|(d, i)| *d += i);
        for (contact, row) in contacts.iter().zip(&mut *rows) {
            let y = contact.interpolate(direction);
            *row = row.with_force(contact, &y, ContactForce::OPEN);
        }
        for (member, cone) in self.members.iter().zip(&self.cones) {
            let (contact, row) = (&contacts[member.contact], &mut rows[member.contact]);
            let normal = contact.normal * self.forces[member.first];
            let force = ContactForce {
                normal: self.forces[member.first],
                friction: member.vector(&self.forces) - normal,
                is_sliding: !cone.sticks,
            };
            row.friction_bound = match member.count {
                // Friction joins when there is room.
                1 if !is_frictionless(row) => {
                    contacts[member.contact].friction * self.forces[member.first]
                }
                _ => cone.bound,
            };
            *row = row.with_force(contact, &contact.interpolate(direction), force);
        }
        set.failures += u32::from(failed);
        Ok(())
    }
}

/// Whether a contact is to have no friction, as where old overlaps are undone.
fn is_frictionless(row: &Row) -> bool {
    row.has_fixed_bound && row.friction_bound == 0.0
}

/// Solves with the factored matrix, with no forces at the nodes that are fixed. Where overlaps are undone there are none but those of contacts.
fn solve(
    system: &mut dyn LinearSystem,
    fixed: &[bool],
    tolerance: f64,
    x: &mut [Vector3<f64>],
) -> Result<(), NotPositive> {
    clear_fixed(x, fixed);
    match x.iter().all(|x| *x == Vector3::zeros()) {
        true => Ok(()),
        false => system.solve(x, tolerance),
    }
}

impl InteriorPoint {
    /// Working memory for so many nodes.
    pub fn new(nodes: usize, options: InteriorPointOptions) -> Self {
        let zeros = vec![Vector3::zeros(); nodes];
        Self {
            options,
            left: zeros.clone(),
            inner: zeros,
            members: Vec::new(),
            candidates: Vec::new(),
            cones: Vec::new(),
            directions: Vec::new(),
            delassus: Vec::new(),
            regularisation: Vec::new(),
            before: Vec::new(),
            motions: Vec::new(),
            forces: Vec::new(),
            program: ConeProgram::new(options),
        }
    }

    /// Pairs of an addition and a multiplication in the problems of contacts among themselves since this was asked for last.
    pub fn take_operations(&mut self) -> f64 {
        std::mem::take(&mut self.program.operations)
    }

    /// About as many in a step with so many directions.
    pub fn operations_of(&self, directions: usize) -> f64 {
        let count = directions.min(self.options.directions);
        USUAL_FACTORS * ConeProgram::operations_of_a_factor(count)
    }

    fn clear(&mut self) {
        self.members.clear();
        self.directions.clear();
        self.regularisation.clear();
        self.before.clear();
        self.forces.clear();
    }

    /// Takes in contacts: at first those that had a force, later, or where there are none, those whose gaps are below their floors by more
    /// than `gap_tolerance` after the displacement `direction` and the response to the forces so far. Returns whether there are any.
    fn join(
        &mut self,
        contacts: &[Contact],
        rows: &[Row],
        direction: &[Vector3<f64>],
        gap_tolerance: f64,
    ) -> bool {
        let before = self.members.len();
        if before == 0 {
            self.take(contacts, rows, direction, |_, _, row| {
                row.force.normal > 0.0 || row.friction_bound > 0.0
            });
        }
        if self.members.len() == before {
            self.take(contacts, rows, direction, |inner, contact, row| {
                let motion = contact.interpolate(direction) + contact.interpolate(inner);
                row.gap + contact.normal.dot(&motion) < row.floor - gap_tolerance
            });
        }
        self.members.len() > before
    }

    /// Takes in the contacts that can move something and are to be taken, but for those that are there.
    fn take(
        &mut self,
        contacts: &[Contact],
        rows: &[Row],
        direction: &[Vector3<f64>],
        is_taken: impl Fn(&[Vector3<f64>], &Contact, &Row) -> bool,
    ) {
        self.candidates.clear();
        let mut wanted = self.directions.len();
        for (index, (contact, row)) in contacts.iter().zip(rows).enumerate() {
            let known = self.members.iter().any(|m| m.contact == index);
            if row.penalty > 0.0 && !known && is_taken(&self.inner, contact, row) {
                self.candidates.push(index);
                wanted += match is_frictionless(row) {
                    true => 1,
                    false => directions::directions(contact),
                };
            }
        }
        let most = self.options.directions;
        if wanted > most {
            let pressed = |index: &usize| {
                let (contact, row) = (&contacts[*index], &rows[*index]);
                let motion = contact.interpolate(direction) + contact.interpolate(&self.inner);
                let gap = row.gap + contact.normal.dot(&motion);
                row.force.normal.max((row.floor - gap) * row.penalty)
            };
            self.candidates
                .sort_by(|a, b| pressed(b).total_cmp(&pressed(a)));
            let room = most.saturating_sub(self.directions.len());
            self.candidates.truncate(room);
        }
        for k in 0..self.candidates.len() {
            let index = self.candidates[k];
            let (contact, row) = (&contacts[index], &rows[index]);
            let member = match wanted > most || is_frictionless(row) {
                true => Member::along_normal(index, contact, &mut self.directions),
                false => Member::new(index, contact, &mut self.directions),
            };
            let force = row.force.vector(contact);
            for k in 0..member.count {
                let own = self.options.regularisation[k.min(1)] / row.penalty;
                self.regularisation.push(own);
                self.before.push(member.frame.column(k).dot(&force));
            }
            self.members.push(member);
        }
    }

    /// Sets the forces, with the friction bounds of the rows or, where these are not fixed, of the forces themselves. Returns whether
    /// they were found; if not, they remain those of before.
    fn balance(&mut self, contacts: &[Contact], rows: &[Row], direction: &[Vector3<f64>]) -> bool {
        self.motions.clear();
        self.cones.clear();
        for member in &self.members {
            let (contact, row) = (&contacts[member.contact], &rows[member.contact]);
            let motion = contact.interpolate(direction);
            self.motions
                .push(row.gap + contact.normal.dot(&motion) - row.floor);
            let slip = row.slip + motion;
            let across = (1..member.count).map(|k| member.frame.column(k).dot(&slip));
            self.motions.extend(across);
            let bound = if member.count > 1 {
                row.friction_bound
            } else {
                0.0
            };
            self.cones.push(Cone::new(member.first, bound));
        }
        let motions = self.motions.iter_mut().zip(&self.regularisation);
        for ((motion, own), before) in motions.zip(&self.before) {
            *motion -= own * before;
        }
        self.forces.clone_from(&self.before);
        for update in 0..self.options.bound_updates {
            for (member, cone) in self.members.iter().zip(&self.cones) {
                if cone.bound == 0.0 {
                    self.forces[member.first + 1..][..member.count - 1].fill(0.0);
                }
            }
            let found = self.program.solve(
                &self.delassus,
                &self.regularisation,
                &self.motions,
                &mut self.cones,
                &mut self.forces,
            );
            let last = update + 1 == self.options.bound_updates;
            if !found {
                return false;
            }
            if last || self.has_consistent_bounds(contacts, rows) {
                break;
            }
            for (member, cone) in self.members.iter().zip(&mut self.cones) {
                if member.count > 1 && !rows[member.contact].has_fixed_bound {
                    cone.bound = contacts[member.contact].friction * self.forces[member.first];
                }
            }
        }
        true
    }

    /// Whether no friction bound is far from that of its normal force.
    fn has_consistent_bounds(&self, contacts: &[Contact], rows: &[Row]) -> bool {
        let largest = |most: f64, member: &Member| most.max(self.forces[member.first]);
        let enough = self.options.bound_tolerance * self.members.iter().fold(0.0, largest);
        let mut all = self.members.iter().zip(&self.cones);
        all.all(|(member, cone)| {
            let bound = contacts[member.contact].friction * self.forces[member.first];
            member.count == 1
                || rows[member.contact].has_fixed_bound
                || (bound - cone.bound).abs() <= enough
        })
    }
}
