//! What evolves, what drives it, what touches it.

use crate::elements::{Configuration, EnergyKind};
use crate::model::TissueModel;
use nalgebra::Vector3;
use std::sync::Arc;

/// The evolving part of a body. Its bytes are all that is needed to continue exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Node positions p_n \[m\].
    pub positions: Vec<Vector3<f64>>,
    /// Node velocities \[m/s\]: at the end of the last step, for Störmer–Verlet in its middle, (p_n − p_{n−1}) / (length of
    /// that step). With `step` this is the Δ of NUMERICS 2.2, in a form that survives a change of step.
    pub velocities: Vec<Vector3<f64>>,
    /// Length of the last step \[s\]; 0 before the first one, when `velocities` are those at the start.
    pub step: f64,
    /// Accelerations that a method carries from step to step \[m/s²\]; empty for a method without.
    pub accelerations: Vec<Vector3<f64>>,
    /// Internal variables of the elements (plasticity), set after set.
    pub internal: Vec<f64>,
}

impl State {
    /// The rest shape at rest.
    pub fn at_rest(model: &TissueModel) -> Self {
        Self {
            positions: model.rest_positions().to_vec(),
            velocities: vec![Vector3::zeros(); model.node_count()],
            step: 0.0,
            accelerations: Vec::new(),
            internal: model
                .sets()
                .iter()
                .flat_map(|set| set.initial_internal())
                .collect(),
        }
    }

    /// The configuration as set `set` of `model` sees it.
    pub fn configuration<'a>(&'a self, model: &TissueModel, set: usize) -> Configuration<'a> {
        Configuration {
            positions: &self.positions,
            velocities: &self.velocities,
            internal: &self.internal[model.internal_range(set)],
        }
    }

    /// Energy by kind \[J\]. The elastic kinds are those of the positions, the kinetic energy that of `velocities`; with
    /// Störmer–Verlet their sum oscillates by up to h·ω/2 of the energy in a mode of frequency ω. Clamped nodes have no
    /// kinetic energy.
    pub fn energies(&self, model: &TissueModel) -> Energies {
        let mut energies = Energies::default();
        for (node, v) in self.velocities.iter().enumerate() {
            if !model.is_clamped(node) {
                energies.kinetic += 0.5 * model.inertia(node) * v.norm_squared();
            }
        }
        for (set, elements) in model.sets().iter().enumerate() {
            let at = self.configuration(model, set);
            *energies.of_kind(elements.kind()) += elements.energy(&at);
            energies.dissipated += elements.dissipated(at.internal);
        }
        energies
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        // A sum is finite only if all its terms are; one test at the end keeps the loop free of branches. A velocity is a
        // difference of positions, so a wrong one shows in the positions one step later at most.
        let sum: Vector3<f64> = self
            .positions
            .iter()
            .zip(&self.velocities)
            .map(|(p, v)| p + v)
            .sum();
        sum.iter().all(|c| c.is_finite())
    }
}

/// What drives a body during a step.
///
/// Loads and clamps are given once, for the end of the step, and loads are taken as they are there: a load that changes is
/// followed to first order in the step, whatever the order of the method. Only velocity Verlet, where it carries accelerations,
/// has the loads of both ends.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Control {
    /// Acceleration of gravity \[m/s²\].
    pub gravity: Vector3<f64>,
    /// Where each of the model's clamped nodes is at the end of the step \[m\]; empty while they stay where they are.
    pub clamped_positions: Vec<Vector3<f64>>,
    /// Forces on single nodes that do not depend on the shape \[N\].
    pub forces: Vec<(u32, Vector3<f64>)>,
    /// Pressures on surfaces.
    pub pressures: Vec<Pressure>,
    /// Pressures on single triangles.
    pub pressed: Vec<PressedTriangle>,
    /// Places to which a force brings nodes by the end of the step, whatever else acts on them but contact, which may move them on \[m\]; of explicit
    /// methods but explicit Euler.
    pub carried: Vec<(u32, Vector3<f64>)>,
}

/// A pressure on part of a surface; it follows the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Pressure {
    /// Outward triangles.
    pub triangles: Arc<[[u32; 3]]>,
    /// Pressure against the outward normal \[Pa\].
    pub pressure: f64,
}

/// A pressure on a triangle of a surface; it follows the triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressedTriangle {
    /// Its nodes, outward.
    pub nodes: [u32; 3],
    /// Pressure against the outward normal \[Pa\].
    pub pressure: f64,
}

impl Control {
    /// Every triangle with a pressure on it.
    pub(crate) fn pressed_triangles(&self) -> impl Iterator<Item = PressedTriangle> + '_ {
        let of_surfaces = self.pressures.iter().flat_map(|load| {
            let pressure = load.pressure;
            let triangles = load.triangles.iter();
            triangles.map(move |&nodes| PressedTriangle { nodes, pressure })
        });
        of_surfaces.chain(self.pressed.iter().copied())
    }

    /// Adds the forces of loads at these positions to the nodes \[N\].
    pub fn add_loads(&self, positions: &[Vector3<f64>], forces: &mut [Vector3<f64>]) {
        for (node, force) in &self.forces {
            forces[*node as usize] += force;
        }
        for PressedTriangle { nodes, pressure } in self.pressed_triangles() {
            let [a, b, c] = nodes.map(|node| &positions[node as usize]);
            // −p·A·n, a third to each corner.
            let corner = (b - a).cross(&(c - a)) * (-pressure / 6.0);
            for node in nodes {
                forces[node as usize] += corner;
            }
        }
    }
}

/// The position that a node is to reach at the end of a step, by a grip or another constraint that prescribes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeTarget {
    /// The node.
    pub node: u32,
    /// Its target position p* \[m\].
    pub target: Vector3<f64>,
    /// The part of the displacement to the target that only undoes an overlap from before the step \[m\]. It moves the node but
    /// leaves no velocity behind (restitution 0), and counts in no force.
    pub overlap: Vector3<f64>,
}

/// Energy of a body by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// Kinetic energy \[J\].
    pub kinetic: f64,
    /// Energy of springs (4.1) \[J\].
    pub length: f64,
    /// Energy of triangles \[J\].
    pub area: f64,
    /// Energy of volumes (4.2) \[J\].
    pub volume: f64,
    /// Strain energy of continua \[J\].
    pub strain: f64,
    /// Energy of couplings \[J\].
    pub coupling: f64,
    /// Dissipated energy \[J\]: what plastic flow of continua, softening of bonds and friction of ties have taken, of elements that are still
    /// there. No energy that a body holds, and in no sum.
    pub dissipated: f64,
}

impl Energies {
    /// Sum of all kinds that a body holds \[J\].
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic()
    }

    /// Sum of all kinds but the kinetic one \[J\].
    pub fn elastic(&self) -> f64 {
        self.length + self.area + self.volume + self.strain + self.coupling
    }

    fn of_kind(&mut self, kind: EnergyKind) -> &mut f64 {
        match kind {
            EnergyKind::Length => &mut self.length,
            EnergyKind::Area => &mut self.area,
            EnergyKind::Volume => &mut self.volume,
            EnergyKind::Strain => &mut self.strain,
            EnergyKind::Coupling => &mut self.coupling,
        }
    }
}
