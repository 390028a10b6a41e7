//! Contact in explicit and position-based methods: non-penetration by sequential impulses, and the undoing of old overlaps.
//!
//! A step without contact would bring the nodes to x̃; [`GaussSeidel`] moves them on by forces, with a compliance per node that depends on
//! the scheme (h²/m with symplectic Euler).
//!
//! # Old overlaps
//! What was inside before the step must not go deeper, and that is all the force there is about it. The rest is undone by positions alone,
//! without velocity and force: components that no clamp holds are taken out as a whole, which costs no elastic energy, and what then
//! remains is pushed out at a speed that tissue follows (Guendelman, Bridson, Fedkiw 2003 push bodies in the same manner).

use crate::contact::{Contact, ContactStep, Response};
use crate::gauss_seidel::{GapConstraint, GaussSeidel, NodalResponse};
use crate::nodal::{NodalCompliance, NodalRow};
use crate::options::ContactOptions;
use crate::rigid_components::RigidComponents;
use crate::solver::ContactSolver;
use nalgebra::Vector3;

/// Working memory for one body.
#[derive(Clone, Debug)]
pub struct Projection {
    edge: f64,
    /// Bound of the highest frequency \[1/s\].
    frequency: f64,
    options: ContactOptions,
    solver: GaussSeidel,
    compliance: NodalCompliance,
    components: RigidComponents,
    /// Sums of pseudo-forces.
    pushes: Vec<f64>,
    closed: Vec<Contact>,
    /// Values before they were changed, then their changes.
    before: Vec<Vector3<f64>>,
}

impl Projection {
    /// Working memory for a body of so many nodes with the mean edge length `edge` \[m\] and a bound of its highest frequency \[1/s\].
    pub fn new(
        nodes: usize,
        edge: f64,
        frequency: f64,
        components: RigidComponents,
        options: &ContactOptions,
    ) -> Self {
        Self {
            edge,
            frequency,
            options: *options,
            solver: GaussSeidel::new(edge, options.gauss_seidel),
            compliance: NodalCompliance::default(),
            components,
            pushes: Vec::new(),
            closed: Vec::new(),
            before: vec![Vector3::zeros(); nodes],
        }
    }

    /// Updates it after an edit of the body.
    pub fn follow(&mut self, nodes: usize, components: RigidComponents) {
        self.components = components;
        self.before.resize(nodes, Vector3::zeros());
    }

    /// The options.
    pub fn options(&self) -> &ContactOptions {
        &self.options
    }

    /// Most sweeps over the contacts.
    pub fn sweeps(&self) -> u32 {
        self.options.gauss_seidel.sweeps
    }

    /// Enforces non-penetration where a step without contact brings the nodes to `positions`, from `start`; afterwards they are where the
    /// step ends, and [`changes`](Self::changes) holds their displacements by forces. `compliance` as in [`begin`](Self::begin). Returns
    /// whether there is any contact; where there is none nothing is moved.
    pub fn project(
        &mut self,
        step: &mut ContactStep<'_>,
        start: &[Vector3<f64>],
        compliance: impl Fn(usize) -> f64,
        h: f64,
        positions: &mut [Vector3<f64>],
    ) -> bool {
        step.source.find(1.0, positions, &mut step.contacts);
        if step.contacts.is_empty() {
            self.before.fill(Vector3::zeros());
            return false;
        }
        self.before.copy_from_slice(positions);
        self.begin(&mut step.contacts, &compliance);
        self.respond_singly(&mut step.contacts, positions);
        let constraint = GapConstraint::Positions { start };
        self.enforce(constraint, self.sweeps(), &mut step.contacts, positions);
        for (change, x) in self.before.iter_mut().zip(&*positions) {
            *change = x - *change;
        }
        let held = |node| compliance(node) == 0.0;
        self.undo_overlaps(&step.contacts, held, h, positions);
        true
    }

    /// Moves `positions` by the forces of contacts that are no constraints, each found from where the step without contact ends, as if it were
    /// alone; nothing else moves them then.
    fn respond_singly(&mut self, contacts: &mut [Contact], positions: &mut [Vector3<f64>]) {
        let rows = &mut self.compliance.rows;
        for (contact, row) in contacts.iter_mut().zip(&*rows) {
            contact.normal_force = match contact.response {
                Response::Constraint => continue,
                Response::Penalty { stiffness } => {
                    let own = match contact.other_side() {
                        Some(_) => 0.5,
                        None => 1.0,
                    };
                    (-stiffness * own * contact.start_gap).max(0.0)
                }
                Response::TargetForce if row.compliance > 0.0 => {
                    let missing = contact.floor - contact.gap(positions);
                    (missing / row.compliance).max(0.0)
                }
                Response::TargetForce => 0.0,
            };
        }
        for (contact, row) in contacts.iter_mut().zip(rows) {
            if contact.response != Response::Constraint {
                row.shift(contact, &(contact.normal * contact.normal_force), positions);
                *row = NodalRow::INERT;
                contact.floor = f64::NEG_INFINITY;
            }
        }
    }

    /// The displacement \[m\] of each node by the forces of the last [`project`](Self::project), or the change of its velocity \[m/s\] by
    /// the last [`match_velocities`](Self::match_velocities).
    pub fn changes(&self) -> &[Vector3<f64>] {
        &self.before
    }

    /// Gives the contacts that were closed in the last [`project`](Self::project) the velocities with which they stay so, in a step of `h`
    /// \[s\]. `inverse_mass` \[1/kg\] is 0 for a prescribed node.
    pub fn match_velocities(
        &mut self,
        contacts: &[Contact],
        h: f64,
        inverse_mass: impl Fn(usize) -> f64,
        velocities: &mut [Vector3<f64>],
    ) {
        self.before.copy_from_slice(velocities);
        let mut closed = std::mem::take(&mut self.closed);
        closed.clear();
        let is_closed = |contact: &&Contact| {
            contact.normal_force > 0.0 && contact.response == Response::Constraint
        };
        closed.extend(contacts.iter().filter(is_closed));
        self.begin(&mut closed, inverse_mass);
        let constraint = GapConstraint::Velocities { h };
        self.enforce(constraint, self.sweeps(), &mut closed, velocities);
        self.closed = closed;
        for (change, v) in self.before.iter_mut().zip(&*velocities) {
            *change = v - *change;
        }
    }

    /// Takes over the contacts of a step, without force so far; `compliance` is the displacement of a node per force \[m/N\], 0 for a
    /// prescribed one.
    pub fn begin(&mut self, contacts: &mut [Contact], compliance: impl Fn(usize) -> f64) {
        for contact in &mut *contacts {
            contact.normal_force = 0.0;
            contact.friction_force = Vector3::zeros();
            contact.is_sliding = true;
        }
        self.compliance.set(contacts, compliance);
    }

    /// Moves `values` – positions, or velocities – and adds to the forces of the contacts until the constraints hold, at most in so many
    /// sweeps.
    pub fn enforce(
        &mut self,
        constraint: GapConstraint<'_>,
        sweeps: u32,
        contacts: &mut [Contact],
        values: &mut [Vector3<f64>],
    ) {
        let response = NodalResponse {
            compliance: &self.compliance,
            constraint,
            sweeps,
        };
        let solved = self.solver.solve(contacts, response, values);
        debug_assert!(
            solved.is_ok(),
            "there is no system that could be indefinite"
        );
    }

    /// Undoes old overlaps in a step of `h` \[s\]: moves `positions` where gaps are below their floors. `held` is whether a node is
    /// prescribed.
    pub fn undo_overlaps(
        &mut self,
        contacts: &[Contact],
        held: impl Fn(usize) -> bool,
        h: f64,
        positions: &mut [Vector3<f64>],
    ) {
        let tolerance = self.options.gauss_seidel.tolerance * self.edge;
        let deep = |positions: &[Vector3<f64>], contact: &Contact| {
            contact.start_gap < 0.0 && contact.gap(positions) < contact.floor - tolerance
        };
        if !contacts.iter().any(|contact| deep(positions, contact)) {
            return;
        }
        self.components.separate(contacts, held, h, positions);
        let most = self.options.overlap.undone(self.frequency, h);
        self.pushes.clear();
        self.pushes.resize(contacts.len(), 0.0);
        let rows = &self.compliance.rows;
        for _ in 0..self.options.gauss_seidel.sweeps {
            let mut largest = 0.0f64;
            for ((contact, row), push) in contacts.iter().zip(rows).zip(&mut self.pushes) {
                if row.compliance == 0.0 {
                    continue;
                }
                let floor = contact.floor.min(contact.start_gap + most * self.edge);
                let missing = floor - contact.gap(positions);
                let pushed = (*push + missing / row.compliance).max(0.0);
                let change = pushed - *push;
                *push = pushed;
                largest = largest.max((change * row.compliance).abs());
                row.shift(contact, &(contact.normal * change), positions);
            }
            if largest <= tolerance {
                break;
            }
        }
    }
}
