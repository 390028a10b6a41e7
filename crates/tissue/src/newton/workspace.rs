//! The working memory of Newton's method for one model.

use super::known_forces::{KnownEnergy, KnownForces};
use super::options::NewtonOptions;
use crate::components::rigid_components;
use crate::model::TissueModel;
use crate::solver::Effort;
use crate::state::State;
use crate::system::System;
use crate::work;
use microsim_contact_solver::{
    AugmentedLagrangian, Contact, ContactSet, InteriorPoint, RigidComponents,
};
use nalgebra::Vector3;

/// Newton's method with its working memory for one model.
#[derive(Clone, Debug)]
pub(crate) struct NewtonSolver {
    pub(super) options: NewtonOptions,
    /// What an equation may take.
    pub effort: Effort,
    /// The work that an equation may take \[s\]: beyond it no further iteration begins, unless it must converge.
    pub most_work: f64,
    /// What the present one may take \[s\]: any where it must converge.
    pub(super) allowed_work: f64,
    /// What the present one has taken \[s\].
    pub(super) work: f64,
    /// What the elements take in an iteration \[s\].
    pub(super) element_work: f64,
    pub(super) system: System,
    pub(super) forces: KnownForces,
    pub(super) energy: KnownEnergy,
    pub(super) viscous: bool,
    /// Drag per mass of each node \[1/s\].
    pub(super) drags: Vec<f64>,
    /// Where the equation is being evaluated; its positions are the solution in the end.
    pub trial: State,
    /// Sum of all forces at `trial` minus the left side \[N\].
    pub(super) residual: Vec<Vector3<f64>>,
    /// Its norm where it was evaluated last \[N\].
    pub(super) force_residual: f64,
    pub(super) direction: Vec<Vector3<f64>>,
    /// c of the path x + α d + α² c \[m\].
    pub(super) second_order: Vec<Vector3<f64>>,
    /// Positions at the start of an iteration.
    pub(super) from: Vec<Vector3<f64>>,
    /// n: the forces without energy at the start of an iteration \[N\].
    pub(super) loads: Vec<Vector3<f64>>,
    pub(super) scratch: Vec<Vector3<f64>>,
    pub(super) contacts: ContactSet,
    pub(super) augmented_lagrangian: AugmentedLagrangian,
    pub(super) interior_point: InteriorPoint,
    pub(super) components: RigidComponents,
    /// Whether the momentum of free components is conserved to rounding.
    pub(super) balanced: bool,
    /// How often contacts were found for this equation.
    pub(super) searches: u32,
    /// How often iterations of this equation were halved because surfaces had turned too far.
    pub(super) backtracks: u32,
    /// Bound of the highest frequency \[1/s\].
    pub(super) frequency: f64,
    /// Mean edge length \[m\].
    pub(super) edge: f64,
    /// The residual without the forces of contacts \[N\].
    pub(super) others: Vec<Vector3<f64>>,
    /// The stiffness of each node by itself at rest \[N/m\].
    pub(super) stiffness: Vec<f64>,
    /// Whether the matrix of the last iteration is good for the next one.
    pub(super) retains_matrix: bool,
    /// Whether the factor is one in f64 of a positive matrix without any contact.
    pub(super) has_bare_factor: bool,
    /// The residual at the start of an iteration, while others are computed \[N\].
    pub(super) stored: Vec<Vector3<f64>>,
}

impl NewtonSolver {
    /// Working memory for `model`.
    pub fn new(model: &TissueModel, options: &NewtonOptions) -> Self {
        Self::with_system(model, System::new(model), options)
    }

    /// That for the model of the same body after an edit, or with elements that have slid. That happens in the middle of a tick as well, whose bounds of work remain.
    pub fn following(&self, model: &TissueModel) -> Self {
        Self {
            effort: self.effort,
            most_work: self.most_work,
            ..Self::with_system(model, self.system.following(model), &self.options)
        }
    }

    fn with_system(model: &TissueModel, system: System, options: &NewtonOptions) -> Self {
        let nodes = model.node_count();
        let zeros = vec![Vector3::zeros(); nodes];
        let solvers = &options.contact_solvers;
        let edge = model.mean_edge_length();
        Self {
            options: *options,
            effort: Effort::default(),
            most_work: f64::INFINITY,
            allowed_work: f64::INFINITY,
            work: 0.0,
            element_work: work::of_iteration(model),
            stiffness: rest_stiffness(model),
            retains_matrix: false,
            has_bare_factor: false,
            contacts: ContactSet::new(nodes, edge, solvers.augmented_lagrangian),
            augmented_lagrangian: AugmentedLagrangian::new(nodes, solvers.augmented_lagrangian),
            interior_point: InteriorPoint::new(nodes, solvers.interior_point),
            others: zeros.clone(),
            components: rigid_components(model, solvers.rigid_components),
            balanced: false,
            searches: 0,
            backtracks: 0,
            frequency: model.rate_bound().sqrt(),
            edge,
            system,
            forces: KnownForces::new(model),
            energy: KnownEnergy::new(model),
            drags: {
                let runs = model.drags().iter();
                runs.flat_map(|(nodes, drag)| std::iter::repeat_n(*drag, nodes.len()))
                    .collect()
            },
            viscous: model.sets().iter().any(|set| set.is_viscous()),
            trial: State::at_rest(model),
            residual: zeros.clone(),
            force_residual: 0.0,
            direction: zeros.clone(),
            second_order: zeros.clone(),
            from: zeros.clone(),
            loads: zeros.clone(),
            scratch: zeros.clone(),
            stored: zeros,
        }
    }

    /// Takes over what elements see of `state` besides positions and velocities, and whether the momentum of free components is to be
    /// conserved to rounding, not only to the tolerance.
    pub fn begin(&mut self, state: &State, balanced: bool) {
        self.balanced = balanced;
        self.trial.internal.copy_from_slice(&state.internal);
        self.contacts.clear();
    }

    /// The contacts of the last solution.
    pub fn contacts(&mut self) -> &mut Vec<Contact> {
        &mut self.contacts.contacts
    }

    /// The stiffness of each node by itself at rest \[N/m\].
    pub fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// What a failed iteration or the undoing of overlaps has left is none of this equation: its work depends on the state alone.
    pub(super) fn forget_operations(&mut self) {
        self.take_operations();
    }

    fn take_operations(&mut self) -> f64 {
        self.system.take_operations()
            + self.interior_point.take_operations()
            + self.augmented_lagrangian.take_operations()
    }

    /// Adds what an iteration has taken.
    pub(super) fn count_iteration(&mut self) {
        let operations = self.take_operations();
        self.work += self.element_work + work::OPERATION * operations;
    }

    /// What an iteration in which so many contacts act takes at least, about: with friction, and found in one round \[s\].
    pub fn iteration_work(&self, contacts: usize) -> f64 {
        let among = self.interior_point.operations_of(3 * contacts);
        let operations =
            self.system.factor_operations() + self.system.delassus_operations(3 * contacts) + among;
        self.element_work + work::OPERATION * operations
    }

    /// Whether there are contacts, and the interior-point method is the one for them.
    pub(super) fn takes_interior_point(&self) -> bool {
        !self.contacts.is_empty() && self.contacts.takes_interior_point(&self.system)
    }

    /// Whether no node goes further in the direction than `most` \[mean edge length\].
    pub(super) fn is_short(&self, most: f64) -> bool {
        let most = most * self.edge;
        self.direction
            .iter()
            .all(|d| d.norm_squared() <= most * most)
    }

    /// How far nodes go in the direction at most \[mean edge length\].
    pub(super) fn reach(&self) -> f64 {
        let squares = self.direction.iter().map(|d| d.norm_squared());
        squares.fold(0.0, f64::max).sqrt() / self.edge
    }
}

/// The stiffness of each node by itself at rest \[N/m\]: the mean of its directions.
fn rest_stiffness(model: &TissueModel) -> Vec<f64> {
    let mut stiffness = vec![0.0; model.node_count()];
    let mut traces = Vec::new();
    for set in model.sets() {
        for element in 0..set.count() {
            set.rest_traces(element, model.rest_positions(), &mut traces);
            for (&node, trace) in set.nodes(element).iter().zip(&traces) {
                stiffness[node as usize] += trace / 3.0;
            }
        }
    }
    stiffness
}
