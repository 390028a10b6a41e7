//! Forces of a tool on a body that grow faster than a hand.

use crate::force_window::WindowTick;
use crate::spec::Jaw;
use crate::tool::squeeze;
use nalgebra::Vector3;

/// A force or grip of a tool that is at least this \[N\] and [`RATIO`] times that of the tick before has jumped: what levels count as excess.
const FORCE: f64 = 0.03;

/// No hand is so fast within the 8 ms of a tick.
const RATIO: f64 = 3.0;

/// From where on the force and the grip of a tool on a body have jumped since the last valid tick.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct JumpLimit {
    /// \[N\].
    force: f64,
    /// \[N\].
    grip: f64,
}

impl JumpLimit {
    /// The limit after a tick; where there was none nothing acted.
    pub fn new(last: Option<&WindowTick>) -> Self {
        let [force, grip] = last.map_or([0.0; 2], |last| [last.force.norm(), last.grip]);
        let limit = |last: f64| FORCE.max(RATIO * last);
        Self {
            force: limit(force),
            grip: limit(grip),
        }
    }

    /// Whether a size of the force or a grip \[N\] has jumped.
    pub fn is_reached(&self, force: f64, grip: f64) -> bool {
        force >= self.force || grip >= self.grip
    }
}

/// A tool that acts on a body in a step, and the limit of its forces.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct JumpWatch {
    pub limit: JumpLimit,
    /// The x axis of the tool, along which its jaws close.
    pub axis: Vector3<f64>,
    /// Of each capsule of the tool.
    pub jaws: Vec<Option<Jaw>>,
}

/// Sums of the forces of a tool on a body in a step \[N\].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StepForces {
    force: Vector3<f64>,
    /// How each jaw pushes, without friction.
    pushes: [Vector3<f64>; 2],
}

impl StepForces {
    /// Adds the force of a contact, with its part along the normal, of a capsule of the tool.
    pub fn add(
        &mut self,
        watch: &JumpWatch,
        capsule: u32,
        force: Vector3<f64>,
        push: Vector3<f64>,
    ) {
        self.force += force;
        if let Some(Some(jaw)) = watch.jaws.get(capsule as usize) {
            self.pushes[*jaw as usize] += push;
        }
    }

    /// Whether the force or the grip has jumped.
    pub fn have_jumped(&self, watch: &JumpWatch) -> bool {
        let grip = squeeze(self.pushes, watch.axis);
        watch.limit.is_reached(self.force.norm(), grip)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three times the tick before and 30 mN: both, for force and grip alike.
    #[test]
    fn jumps_are_large_and_sudden() {
        let jumps = |last: Option<&WindowTick>, force: f64, grip: f64| {
            JumpLimit::new(last).is_reached(force, grip)
        };
        assert!(jumps(None, 0.03, 0.0) && !jumps(None, 0.029, 0.0));
        let last = WindowTick {
            length: 0.008,
            force: Vector3::z() * 0.012,
            grip: 0.024,
        };
        assert!(!jumps(Some(&last), 0.035, 0.07));
        assert!(jumps(Some(&last), 0.037, 0.0) && jumps(Some(&last), 0.0, 0.073));
    }

    /// Jaws that close on a body with 40 mN each have jumped; the same forces of one jaw whose contacts lie on both sides of an edge, or of a shaft, grip nothing.
    #[test]
    fn only_jaws_that_close_grip() {
        let watch = JumpWatch {
            limit: JumpLimit::new(None),
            axis: Vector3::x(),
            jaws: vec![Some(Jaw::Left), Some(Jaw::Right), None],
        };
        let jumps = |capsules: [u32; 2]| {
            let push = Vector3::x() * 0.04;
            let mut forces = StepForces::default();
            forces.add(&watch, capsules[0], -push, -push);
            forces.add(&watch, capsules[1], push, push);
            forces.have_jumped(&watch)
        };
        assert!(jumps([0, 1]));
        assert!(!jumps([0, 0]) && !jumps([1, 0]) && !jumps([2, 2]));
    }
}
