//! Contact by projected Gauss–Seidel iterations on sums of force.
//!
//! Forces at the contacts move the nodes by the compliance of each times force, so that for each contact
//!
//! ```text
//! g(x) ≥ floor     λ ≥ 0     λ (g − floor) = 0          along the normal
//! |t| ≤ μ λ        t against the slip u across the normal in the step; |t| < μ λ only for u = 0
//! ```
//!
//! holds, contact after contact in their order, with sums of force that are bounded as a whole (Moreau 1988; Guendelman, Bridson,
//! Fedkiw 2003). Both sides of a contact get the same force, so momentum is conserved to rounding; where two bodies close a gap each
//! moves by a fraction of it according to its inverse mass. Restitution is 0.
//!
//! # Limitations
//! Gaps are linear here; what a turn of the normal leaves of an overlap is undone in the next step. Many contacts on top of one another
//! through light nodes converge slowly: after [`GaussSeidelOptions::sweeps`] what is left stays.

use crate::contact::Contact;
use crate::nodal::{NodalCompliance, NodalRow};
use crate::options::GaussSeidelOptions;
use crate::solver::ContactSolver;
use microsim_sparse::NotPositive;
use nalgebra::Vector3;

/// The method.
///
/// ```
/// use microsim_contact_solver::{
///     Contact, ContactSolver, GapConstraint, GaussSeidel, GaussSeidelOptions, NodalCompliance, NodalResponse,
/// };
/// use nalgebra::Vector3;
///
/// // Without contact a node that moves by 1 mm per newton would be 2 mm below the floor at the end of the step.
/// let start = [Vector3::z() * 1e-3];
/// let mut positions = [Vector3::z() * -2e-3];
/// let mut contacts = [Contact { start_gap: 1e-3, ..Contact::of_node(0, Vector3::z(), 0.0) }];
/// let mut compliance = NodalCompliance::default();
/// compliance.set(&contacts, |_| 1e-3);
/// let response = NodalResponse {
///     compliance: &compliance,
///     constraint: GapConstraint::Positions { start: &start },
///     sweeps: 50,
/// };
/// GaussSeidel::new(1e-2, GaussSeidelOptions::default()).solve(&mut contacts, response, &mut positions)?;
/// assert!((contacts[0].normal_force - 2.0).abs() < 1e-12 && positions[0].norm() < 1e-15);
/// # Ok::<(), microsim_sparse::NotPositive>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct GaussSeidel {
    edge: f64,
    options: GaussSeidelOptions,
}

/// Bodies whose nodes respond to forces each by itself.
#[derive(Clone, Copy, Debug)]
pub struct NodalResponse<'a> {
    /// Of the contacts.
    pub compliance: &'a NodalCompliance,
    /// What is enforced.
    pub constraint: GapConstraint<'a>,
    /// Most sweeps over the contacts.
    pub sweeps: u32,
}

/// What is enforced on the values at the nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GapConstraint<'a> {
    /// Gaps of positions \[m\].
    Positions {
        /// Positions at the start of the step, since which sliding counts.
        start: &'a [Vector3<f64>],
    },
    /// Rates of gaps that are closed, of velocities \[m/s\].
    Velocities {
        /// Length of the step \[s\].
        h: f64,
    },
}

impl GaussSeidel {
    /// For bodies with this mean edge length \[m\].
    pub fn new(edge: f64, options: GaussSeidelOptions) -> Self {
        Self { edge, options }
    }

    /// The options.
    pub fn options(&self) -> &GaussSeidelOptions {
        &self.options
    }
}

impl ContactSolver<NodalResponse<'_>> for GaussSeidel {
    type Contacts = [Contact];

    /// Adds to the forces of the contacts, which are those of the sweeps before or zero. Never fails.
    fn solve(
        &mut self,
        contacts: &mut [Contact],
        response: NodalResponse<'_>,
        motion: &mut [Vector3<f64>],
    ) -> Result<(), NotPositive> {
        let tolerance = match response.constraint {
            GapConstraint::Positions { .. } => self.options.tolerance * self.edge,
            GapConstraint::Velocities { h } => self.options.tolerance * self.edge / h,
        };
        for _ in 0..response.sweeps {
            let mut largest = 0.0f64;
            for (contact, row) in contacts.iter_mut().zip(&response.compliance.rows) {
                if row.compliance > 0.0 {
                    largest = largest.max(relax(response.constraint, contact, row, motion));
                }
            }
            if largest <= tolerance {
                break;
            }
        }
        Ok(())
    }
}

/// Corrects one contact; returns the size of the change.
fn relax(
    constraint: GapConstraint<'_>,
    contact: &mut Contact,
    row: &NodalRow,
    values: &mut [Vector3<f64>],
) -> f64 {
    let missing = match constraint {
        GapConstraint::Positions { .. } => {
            contact.floor.min(contact.start_gap) - contact.gap(values)
        }
        GapConstraint::Velocities { h } => contact
            .normal
            .dot(&(contact.drift / h - contact.interpolate(values))),
    };
    let normal_force = (contact.normal_force + missing / row.compliance).max(0.0);
    let change = normal_force - contact.normal_force;
    contact.normal_force = normal_force;
    row.shift(contact, &(contact.normal * change), values);
    let mut largest = (change * row.compliance).abs();
    if contact.friction > 0.0 {
        let slip = contact.interpolate(values)
            - match constraint {
                GapConstraint::Positions { start } => contact.interpolate(start) + contact.drift,
                GapConstraint::Velocities { h } => contact.drift / h,
            };
        let slip = slip - contact.normal * contact.normal.dot(&slip);
        let friction_force = contact.friction_force - slip / row.compliance;
        let bound = contact.friction * contact.normal_force;
        let ratio = bound / friction_force.norm().max(f64::MIN_POSITIVE);
        contact.is_sliding = ratio < 1.0;
        let friction_force = friction_force * ratio.min(1.0);
        let change = friction_force - contact.friction_force;
        contact.friction_force = friction_force;
        row.shift(contact, &change, values);
        largest = largest.max(change.norm() * row.compliance);
    }
    largest
}
