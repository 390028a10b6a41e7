//! What evolves, what drives it, what touches it.

use crate::energies::{length_energy, volume_energy};
use crate::model::TissueModel;
use nalgebra::Vector3;

/// The evolving part of a body. Its bytes are all that is needed to continue exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Node positions p_n [m].
    pub positions: Vec<Vector3<f64>>,
    /// (p_n − p_{n−1}) / (length of that step) [m/s]: the velocity in the middle of the last step. With `step` it is
    /// the Δ of NUMERICS 2.2, in a form that survives a change of step.
    pub velocities: Vec<Vector3<f64>>,
    /// Length of the last step [s]; 0 before the first one, when `velocities` are those at the start.
    pub step: f64,
}

impl State {
    /// The rest shape at rest.
    pub fn at_rest(model: &TissueModel) -> Self {
        Self {
            positions: model.rest_positions().to_vec(),
            velocities: vec![Vector3::zeros(); model.node_count()],
            step: 0.0,
        }
    }

    /// Energy by kind [J]. The elastic kinds are those of the positions, the kinetic energy that of the velocities in the
    /// middle of the last step: their sum oscillates by up to h·ω/2 of the energy in a mode of frequency ω. Clamped nodes
    /// have no kinetic energy.
    pub fn energies(&self, model: &TissueModel) -> Energies {
        let p = &self.positions;
        let kinetic = self
            .velocities
            .iter()
            .zip(model.masses())
            .map(|(v, m)| 0.5 * m * v.norm_squared())
            .sum();
        let length = model
            .springs()
            .iter()
            .map(|s| {
                length_energy(
                    s.nodes.map(|node| &p[node as usize]),
                    s.rest_length,
                    s.stiffness,
                )
            })
            .sum();
        let volume = model
            .volumes()
            .iter()
            .map(|v| {
                volume_energy(
                    v.nodes.map(|node| &p[node as usize]),
                    v.rest_volume,
                    v.stiffness,
                )
            })
            .sum();
        Energies {
            kinetic,
            length,
            volume,
        }
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Control {
    /// Acceleration of gravity [m/s²].
    pub gravity: Vector3<f64>,
}

/// Where contact wants one node after the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeTarget {
    /// The node.
    pub node: u32,
    /// Its target position p* [m].
    pub target: Vector3<f64>,
    /// The share of the way to the target that only undoes an overlap from before the step [m]. It moves the node but
    /// leaves no velocity behind (restitution 0), and counts in no force.
    pub overlap: Vector3<f64>,
}

/// The contacts of one step: at most one target per node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contacts {
    /// The nodes that are led. A target of a clamped node is ignored.
    pub targets: Vec<NodeTarget>,
}

/// Energy of a body by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// Kinetic energy [J].
    pub kinetic: f64,
    /// Energy of the springs (4.1) [J].
    pub length: f64,
    /// Energy of the volume elements (4.2) [J].
    pub volume: f64,
}

impl Energies {
    /// Sum of all kinds [J].
    pub fn total(&self) -> f64 {
        self.kinetic + self.length + self.volume
    }
}
