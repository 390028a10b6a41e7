//! Contact by the method of multipliers: a semismooth Newton method inside, updates of multipliers outside.
//!
//! With the matrix K and the forces r of everything else the displacement d of an iteration is the lowest point of
//! ½ dᵀK d − r·d + Σ ψ(Σ w d) with the energies ψ of the contacts ([`ContactSet`]), which is convex and piecewise quadratic (but for
//! friction). It is found without any further work at elements: inner Newton iterations, each by conjugate gradients on K and the
//! contacts that are closed now, preconditioned by the factor of K and the contacts that were closed first; then multipliers and bounds
//! are updated, until non-penetration is enforced and nothing slides that sticks (Alart and Curnier 1991; Simo and Laursen 1992).
//!
//! Where contacts are few all of this is done among them alone first (`reduced`), and conjugate gradients only see to what is left.
//!
//! Contacts between two bodies that both can move are not in the factor: their blocks are not in its pattern. They have a smaller penalty
//! and more updates.

use crate::energy_line::EnergyLine;
use crate::options::AugmentedLagrangianOptions;
use crate::reduced::Reduced;
use crate::set::ContactSet;
use crate::solver::{ContactSolver, SystemResponse};
use crate::system_forces::{add_contacts, add_forces_along, multiply_without_contacts};
use crate::vectors::{clear_fixed, dot, norm_of_free};
use microsim_sparse::NotPositive;
use nalgebra::Vector3;

/// The method, with its working memory.
///
/// ```
/// use microsim_contact_solver::{
///     AugmentedLagrangian, AugmentedLagrangianOptions, Contact, ContactSet, ContactSolver, NodalSystem,
///     SystemResponse, Tolerances,
/// };
/// use nalgebra::Vector3;
///
/// // A node with a stiffness of 100 N/m, 1 mm above a floor, is pushed down by 0.3 N.
/// let positions = [Vector3::z() * 1e-3];
/// let options = AugmentedLagrangianOptions::default();
/// let mut contacts = ContactSet::new(1, 1e-2, options);
/// contacts.contacts.push(Contact::of_node(0, Vector3::z(), 0.0));
/// contacts.linearise(&positions, &positions, true, |_| 100.0);
/// let mut system = NodalSystem::new(vec![100.0]);
/// let mut displacement = [Vector3::zeros()];
/// let response = SystemResponse {
///     system: &mut system,
///     forces: &[Vector3::z() * -0.3],
///     fixed: &[false],
///     tolerances: Tolerances { residual: 1e-9, changes: 1e-9, multipliers: 1e-9 },
///     most_operations: f64::INFINITY,
/// };
/// AugmentedLagrangian::new(1, options).solve(&mut contacts, response, &mut displacement)?;
/// contacts.publish();
/// // It stops at the floor, which carries what is left of the push: 0.3 N − 100 N/m · 1 mm.
/// assert!((displacement[0].z + 1e-3).abs() < 1e-8);
/// assert!((contacts.contacts[0].normal_force - 0.2).abs() < 1e-6);
/// # Ok::<(), microsim_sparse::NotPositive>(())
/// ```
#[derive(Clone, Debug)]
pub struct AugmentedLagrangian {
    options: AugmentedLagrangianOptions,
    /// Residual of the forces that no contact has, at the displacement so far \[N\].
    left: Vec<Vector3<f64>>,
    /// Residual of all forces \[N\], then an inner direction \[m\].
    inner: Vec<Vector3<f64>>,
    product: Vec<Vector3<f64>>,
    reduced: Reduced,
}

impl AugmentedLagrangian {
    /// Working memory for so many nodes.
    pub fn new(nodes: usize, options: AugmentedLagrangianOptions) -> Self {
        let zeros = vec![Vector3::zeros(); nodes];
        Self {
            options,
            left: zeros.clone(),
            inner: zeros.clone(),
            product: zeros,
            reduced: Reduced::new(options),
        }
    }

    /// Pairs of an addition and a multiplication in the problems of contacts among themselves since this was asked for last.
    pub fn take_operations(&mut self) -> f64 {
        std::mem::take(&mut self.reduced.operations)
    }
}

impl ContactSolver<SystemResponse<'_>> for AugmentedLagrangian {
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
            tolerances,
            most_operations,
        } = response;
        let direction = motion;
        let (contacts, rows, edge) = contacts.parts();
        let Self {
            options,
            left,
            inner,
            product,
            reduced,
        } = self;
        left.copy_from_slice(forces);
        if direction.iter().any(|d| *d != Vector3::zeros()) {
            multiply_without_contacts(system, contacts, rows, direction, product);
            left.iter_mut().zip(&*product).for_each(|(l, p)| *l -= p);
        }
        // Where nothing else acts, as when overlaps are undone, the forces of the guess are the measure.
        let scale = match norm_of_free(forces, fixed) {
            0.0 => norm_of_free(left, fixed),
            scale => scale,
        };
        let most = reduced.solve(
            (contacts, &mut *rows, edge),
            (&mut *system, fixed, tolerances),
            most_operations,
            scale,
            [&mut *left, &mut *inner, &mut *product],
            direction,
        )?;
        let mut first = most.is_none();
        let mut enough = 0.0;
        let (tolerance, rough) = (tolerances.residual, tolerances.changes);
        for _ in 0..options.updates {
            for _ in 0..options.inner_iterations {
                // What is left of all forces, and the curvature of contacts, at the displacement so far.
                inner.copy_from_slice(left);
                let pushed = add_forces_along(contacts, rows, direction, inner);
                let missing = norm_of_free(inner, fixed);
                let allowed = tolerance * scale.max(pushed);
                // What is left at the start may be little against all forces, and still all that a small load is to move.
                enough = rough.max(tolerance) / tolerance * allowed;
                enough = enough.min(most.unwrap_or(f64::INFINITY));
                let is_spent = system.operations() + reduced.operations >= most_operations;
                if (missing <= enough || is_spent) && (!first || missing == 0.0) {
                    break;
                }
                let goal = if first { allowed } else { enough };
                let [least, largest] = options.linear_tolerances;
                let inexact = (options.inexactness * goal / missing).clamp(least, largest);
                first = false;
                clear_fixed(inner, fixed);
                product.copy_from_slice(inner);
                let mut apply = |p: &[Vector3<f64>], q: &mut [Vector3<f64>]| {
                    add_contacts(contacts, rows, p, q);
                };
                system.solve_with(&mut apply, inner, inexact)?;
                let slope = -dot(product, inner);
                multiply_without_contacts(system, contacts, rows, inner, product);
                let line = EnergyLine::new((contacts, rows), [direction, inner], [left, product]);
                let step = line.lowest(slope, options.flat_slope, options.bisections);
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
                if row.penalty > 0.0 {
                    let (_, [residual, change]) =
                        row.updated(contact, &contact.interpolate(direction));
                    worst = worst.max(residual);
                    changes += change;
                }
            }
            // In short steps forces are the sharper measure.
            let done = worst <= tolerances.multipliers * edge && changes.sqrt() <= enough;
            for (contact, row) in contacts.iter().zip(&mut *rows) {
                if row.penalty > 0.0 {
                    let y = contact.interpolate(direction);
                    *row = row.updated(contact, &y).0;
                }
            }
            if done || system.operations() + reduced.operations >= most_operations {
                break;
            }
        }
        Ok(())
    }
}
