//! Contact constraints: linear inequalities for the gaps between surfaces, with Coulomb friction.
//!
//! A [`Contact`] is a point of contact, linearised where a [`ContactSource`] found it. With the normal n, weights w_i of its nodes
//! and the offset o, its gap is g(x) = n·Σ w_i x_i − o. A solver enforces g ≥ [`floor`](Contact::floor) with a force λ ≥ 0 along n that
//! is zero where g is larger (Signorini), and a force t across n on the first side with |t| ≤ μ λ that opposes the sliding
//! (Coulomb). How it gets there depends on the solver.

use nalgebra::Vector3;

/// Where the force of a contact comes from. All but [`Response::Constraint`] are for explicit methods, without friction, and are here to be compared with it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Response {
    /// All such contacts of a step together: no gap below its floor, no force where one is above it.
    #[default]
    Constraint,
    /// A spring between each side and the surface midway between them, by the gap g at the start of the step (dissertation 4.3): λ = −½ k g; where the
    /// other side is rigid, one spring to it: λ = −k g.
    Penalty {
        /// k \[N/m\], above 0.
        stiffness: f64,
    },
    /// The force that by itself brings the gap to its floor at the end of the step (Gissler, Becker, Teschner 2006; dissertation 4.9, 4.10; NUMERICS 2).
    /// Contacts that have nodes in common do not know of each other.
    TargetForce,
}

/// A point of contact between a side that is made of nodes and another one, of nodes or rigid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Its nodes; those that are not used have the weight 0 and repeat the first one.
    pub nodes: [u32; 4],
    /// Their weights: of the first side positive with the sum 1; of the other side negative with the sum −1, or none where it is
    /// rigid.
    pub weights: [f64; 4],
    /// How many of the nodes are of the first side. Nodes of one side are corners of one surface triangle.
    pub first: u8,
    /// Unit normal, from the other side to the first.
    pub normal: Vector3<f64>,
    /// o \[m\].
    pub offset: f64,
    /// The least gap that is admissible \[m\]: 0, or below it where an old overlap is only to be undone in part in this step.
    pub floor: f64,
    /// The gap at the start of the step \[m\], for the same nodes, weights and normal; below 0 for an old overlap, whose undoing leaves
    /// no velocity and counts in no force.
    pub start_gap: f64,
    /// Where its force comes from.
    pub response: Response,
    /// μ, ≥ 0.
    pub friction: f64,
    /// Displacement of a rigid other side at the point from the start of the step to the time the contact was found for \[m\].
    pub drift: Vector3<f64>,
    /// λ \[N\], ≥ 0: on entry a guess (that of the last step), on exit what the solver found.
    pub normal_force: f64,
    /// t on the first side \[N\], across the normal: on entry that of the end of the last step, on exit what the solver found.
    pub friction_force: Vector3<f64>,
    /// Whether the sides slide: |t| is the friction bound, which a solver may have formed with a λ from before its last iterations. An
    /// open contact slides.
    pub is_sliding: bool,
}

impl Contact {
    /// A frictionless contact without force of a single node with a rigid obstacle, whose gap is n·x − o and is to be at least 0.
    pub fn of_node(node: u32, normal: Vector3<f64>, offset: f64) -> Self {
        Self {
            nodes: [node; 4],
            weights: [1.0, 0.0, 0.0, 0.0],
            first: 1,
            normal,
            offset,
            floor: 0.0,
            start_gap: 0.0,
            response: Response::Constraint,
            friction: 0.0,
            drift: Vector3::zeros(),
            normal_force: 0.0,
            friction_force: Vector3::zeros(),
            is_sliding: false,
        }
    }

    /// The gap at `positions` \[m\].
    #[inline]
    pub fn gap(&self, positions: &[Vector3<f64>]) -> f64 {
        self.normal.dot(&self.interpolate(positions)) - self.offset
    }

    /// Σ w_i v_i: the value on the first side minus that on the other one.
    #[inline]
    pub fn interpolate(&self, values: &[Vector3<f64>]) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        for (&node, &weight) in self.nodes.iter().zip(&self.weights) {
            sum += values[node as usize] * weight;
        }
        sum
    }

    /// A node of the other side; none where that is rigid.
    pub fn other_side(&self) -> Option<u32> {
        let first = usize::from(self.first).min(4);
        let mut others = self.nodes[first..].iter().zip(&self.weights[first..]);
        others.find(|(_, w)| **w != 0.0).map(|(node, _)| *node)
    }

    /// The force on the first side \[N\].
    #[inline]
    pub fn force(&self) -> Vector3<f64> {
        self.normal * self.normal_force + self.friction_force
    }
}

/// Where contacts come from.
pub trait ContactSource {
    /// Finds the contacts near `positions` \[m\], linearised there, with what is rigid at `step_fraction` of the step, in (0, 1].
    ///
    /// On entry `contacts` holds those found before in this step, with the forces that the solver found; on exit the new ones, in an
    /// order that depends on the geometry alone, with the last [`normal_force`](Contact::normal_force) of each and its
    /// [`friction_force`](Contact::friction_force) at the start of the step.
    fn find(&mut self, step_fraction: f64, positions: &[Vector3<f64>], contacts: &mut Vec<Contact>);

    /// Whether the forces of these contacts, those found last, are so much larger than those of a moment ago that they count only where the equation is solved.
    fn has_jumped(&self, _contacts: &[Contact]) -> bool {
        false
    }

    /// Whether what touches goes on within the motion of the step before, so that what it moves may go on, too.
    fn moves_on(&self) -> bool {
        false
    }
}

/// Contact in a step of time or load.
pub struct ContactStep<'a> {
    /// Where contacts come from.
    pub source: &'a mut dyn ContactSource,
    /// After the step: its contacts, with their forces.
    pub contacts: Vec<Contact>,
}
