//! The methods by name: one list for files, reports and comparisons.

use crate::model::TissueModel;
use crate::newton::Newton;
use crate::solver::Solver;
use crate::solver_explicit::{Scheme, SolverExplicit};
use crate::solver_implicit::{ImplicitScheme, SolverImplicit};
use crate::solver_quasi_static::SolverQuasiStatic;
use crate::solver_verlet::SolverVerlet;
use crate::solver_xpbd::SolverXpbd;
use microsim_vocabulary::MethodName;

/// A method with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Störmer–Verlet in the joint form, drag by the exact factor.
    StoermerVerlet,
    /// Explicit Euler (3.12, 3.13).
    ExplicitEuler,
    /// Symplectic Euler.
    SymplecticEuler,
    /// Velocity Verlet in its standard form, drag by the exact factor.
    VelocityVerlet,
    /// Velocity Verlet as a loop with stored values of the step before (3.19, 3.20 as printed), drag from the old velocity.
    VelocityVerletLagged,
    /// Backward Euler.
    ImplicitEuler(Newton),
    /// Implicit midpoint.
    ImplicitMidpoint(Newton),
    /// Implicit midpoint that drops speed where a tetrahedron is distorted.
    GuardedMidpoint(Newton),
    /// Second-order L-stable Runge–Kutta method of two implicit stages.
    Sdirk2(Newton),
    /// Static equilibrium at the end of each step.
    QuasiStatic(Newton),
    /// Position-based dynamics with compliance.
    Xpbd {
        /// Sub-steps per step, at least 1.
        substeps: u32,
        /// Iterations per sub-step, at least 1.
        iterations: u32,
    },
}

/// Why a method cannot treat a model, or has parameters out of range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MethodError {
    /// Name of the method.
    pub method: &'static str,
    /// Why, with the remedy.
    pub reason: &'static str,
}

impl std::fmt::Display for MethodError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.method, self.reason)
    }
}

impl std::error::Error for MethodError {}

impl Method {
    /// The method of a name, with those of the parameters that it has. `substeps` and `iterations` are of position-based dynamics.
    pub fn named(name: MethodName, newton: Newton, substeps: u32, iterations: u32) -> Self {
        match name {
            MethodName::StoermerVerlet => Self::StoermerVerlet,
            MethodName::ExplicitEuler => Self::ExplicitEuler,
            MethodName::SymplecticEuler => Self::SymplecticEuler,
            MethodName::VelocityVerlet => Self::VelocityVerlet,
            MethodName::VelocityVerletLagged => Self::VelocityVerletLagged,
            MethodName::ImplicitEuler => Self::ImplicitEuler(newton),
            MethodName::ImplicitMidpoint => Self::ImplicitMidpoint(newton),
            MethodName::GuardedMidpoint => Self::GuardedMidpoint(newton),
            MethodName::Sdirk2 => Self::Sdirk2(newton),
            MethodName::QuasiStatic => Self::QuasiStatic(newton),
            MethodName::Xpbd => Self::Xpbd {
                substeps,
                iterations,
            },
        }
    }

    /// Which method it is, without its parameters.
    pub fn kind(&self) -> MethodName {
        match self {
            Self::StoermerVerlet => MethodName::StoermerVerlet,
            Self::ExplicitEuler => MethodName::ExplicitEuler,
            Self::SymplecticEuler => MethodName::SymplecticEuler,
            Self::VelocityVerlet => MethodName::VelocityVerlet,
            Self::VelocityVerletLagged => MethodName::VelocityVerletLagged,
            Self::ImplicitEuler(_) => MethodName::ImplicitEuler,
            Self::ImplicitMidpoint(_) => MethodName::ImplicitMidpoint,
            Self::GuardedMidpoint(_) => MethodName::GuardedMidpoint,
            Self::Sdirk2(_) => MethodName::Sdirk2,
            Self::QuasiStatic(_) => MethodName::QuasiStatic,
            Self::Xpbd { .. } => MethodName::Xpbd,
        }
    }

    /// Its name in files and reports.
    pub fn name(&self) -> &'static str {
        self.kind().name()
    }

    /// Whether its step is bounded by [`stability::stable_step`](crate::stability::stable_step); explicit Euler needs a shorter
    /// one, and drag ([`stability::limit`](crate::stability::limit)).
    pub fn is_explicit(&self) -> bool {
        match self {
            Self::StoermerVerlet
            | Self::ExplicitEuler
            | Self::SymplecticEuler
            | Self::VelocityVerlet
            | Self::VelocityVerletLagged => true,
            Self::ImplicitEuler(_)
            | Self::ImplicitMidpoint(_)
            | Self::GuardedMidpoint(_)
            | Self::Sdirk2(_)
            | Self::QuasiStatic(_)
            | Self::Xpbd { .. } => false,
        }
    }

    /// Whether it computes motion, and not only where it ends.
    pub fn has_inertia(&self) -> bool {
        !matches!(self, Self::QuasiStatic(_))
    }

    /// Whether a step fails that does not converge, and so takes what it needs of work.
    pub fn must_converge(&self) -> bool {
        match self {
            Self::ImplicitEuler(newton)
            | Self::ImplicitMidpoint(newton)
            | Self::GuardedMidpoint(newton)
            | Self::Sdirk2(newton)
            | Self::QuasiStatic(newton) => newton.must_converge,
            _ => false,
        }
    }

    /// Whether a node can be guided to a target within one step ([`NodeTarget`](crate::NodeTarget)).
    pub fn reaches_node_targets(&self) -> bool {
        match self {
            Self::StoermerVerlet
            | Self::SymplecticEuler
            | Self::VelocityVerlet
            | Self::VelocityVerletLagged
            | Self::ImplicitEuler(_)
            | Self::ImplicitMidpoint(_)
            | Self::GuardedMidpoint(_)
            | Self::Sdirk2(_)
            | Self::QuasiStatic(_)
            | Self::Xpbd { .. } => true,
            // Its force moves a node one step later only.
            Self::ExplicitEuler => false,
        }
    }

    /// Whether non-penetration is enforced by it ([`ContactStep`](crate::ContactStep)); where not, a step with contact fails with the reason.
    pub fn enforces_non_penetration(&self) -> bool {
        // As with nodes that are led: a force of explicit Euler moves a node one step later only.
        !matches!(self, Self::ExplicitEuler)
    }

    /// What is wrong with the parameters.
    fn out_of_range(&self) -> Option<&'static str> {
        match self {
            Self::ImplicitEuler(Newton { iterations: 0, .. })
            | Self::ImplicitMidpoint(Newton { iterations: 0, .. })
            | Self::GuardedMidpoint(Newton { iterations: 0, .. })
            | Self::Sdirk2(Newton { iterations: 0, .. })
            | Self::QuasiStatic(Newton { iterations: 0, .. })
            | Self::Xpbd { iterations: 0, .. } => Some("iterations must be at least 1"),
            Self::Xpbd { substeps: 0, .. } => Some("substeps must be at least 1"),
            _ => None,
        }
    }

    /// A solver for `model`.
    pub fn solver(&self, model: &TissueModel) -> Result<Box<dyn Solver>, MethodError> {
        if let Some(reason) = self.out_of_range() {
            return Err(MethodError {
                method: self.name(),
                reason,
            });
        }
        let explicit = |scheme| Box::new(SolverExplicit::new(model, scheme));
        let implicit = |scheme, newton| Box::new(SolverImplicit::new(model, scheme, newton));
        Ok(match self {
            Self::StoermerVerlet => Box::new(SolverVerlet::new(model)),
            Self::ExplicitEuler => explicit(Scheme::ExplicitEuler),
            Self::SymplecticEuler => explicit(Scheme::SymplecticEuler),
            Self::VelocityVerlet => explicit(Scheme::VelocityVerlet),
            Self::VelocityVerletLagged => explicit(Scheme::VelocityVerletLagged),
            Self::ImplicitEuler(newton) => implicit(ImplicitScheme::BackwardEuler, *newton),
            Self::ImplicitMidpoint(newton) => implicit(ImplicitScheme::Midpoint, *newton),
            Self::GuardedMidpoint(newton) => implicit(ImplicitScheme::GuardedMidpoint, *newton),
            Self::Sdirk2(newton) => implicit(ImplicitScheme::Sdirk2, *newton),
            Self::QuasiStatic(newton) => Box::new(SolverQuasiStatic::new(model, *newton)),
            Self::Xpbd {
                substeps,
                iterations,
            } => match SolverXpbd::new(model, *substeps, *iterations) {
                Some(solver) => Box::new(solver),
                None => {
                    let reason = match model.has_sliding() {
                        true => {
                            "layers of the body slide (a coupling with friction), which is no constraint; use another method, or a coupling that holds or clings"
                        }
                        false => {
                            "a material of the body is no sum of constraints; use springs or the law neo-hookean-polynomial, a continuum without plasticity"
                        }
                    };
                    return Err(MethodError {
                        method: self.name(),
                        reason,
                    });
                }
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{build, soft_block};

    /// Layers that slide are no constraints; those that hold or cling are.
    #[test]
    fn xpbd_refuses_layers_that_slide_and_states_why() {
        use crate::elements::{
            Bond, Cohesion, CouplingConstants, Elements, SlidingConstants, couple, couple_sliding,
        };
        use std::sync::Arc;
        let mut mesh = soft_block([2; 3]);
        let upper = mesh.tets.len() / 2;
        mesh.regions[upper..].fill(1);
        let mesh = mesh.detached(&[1]).mesh;
        let (from, to) = (1, 0);
        let stiffness_per_area = 1e8;
        let clings = CouplingConstants {
            stiffness_per_area,
            bond: Bond::Cohesive(Cohesion::new(stiffness_per_area, 500.0, 0.01)),
        };
        let slides = SlidingConstants {
            stiffness_per_area,
            friction: 0.2,
            shear_strength: 0.0,
        };
        let sets: [Arc<dyn Elements>; 2] = [
            Arc::new(couple(&mesh, from, to, &clings).unwrap()),
            Arc::new(couple_sliding(&mesh, from, to, &slides).unwrap()),
        ];
        let xpbd = Method::Xpbd {
            substeps: 1,
            iterations: 1,
        };
        let springs = crate::Material {
            density: 1060.0,
            relaxation_time: 0.0,
            behaviour: crate::Behaviour::Springs(crate::SpringConstants::scaled(25e3, 5e4)),
        };
        let [clings, slides] = sets.map(|set| {
            let clamped = vec![false; mesh.positions.len()];
            let materials = [(0, springs), (1, springs)];
            let model = crate::build_model(&mesh, &materials, &clamped, 0.0, vec![set]).unwrap();
            xpbd.solver(&model)
                .map(|_| ())
                .map_err(|error| error.reason)
        });
        assert_eq!(clings, Ok(()));
        assert!(slides.unwrap_err().contains("layers of the body slide"));
    }

    /// Without an iteration or a sub-step nothing would move, and no failure would show it.
    #[test]
    fn counts_below_one_are_refused_by_name() {
        let model = build(&soft_block([1; 3]), |p| p.x < -0.9e-3);
        let none = Newton {
            iterations: 0,
            must_converge: false,
            ..Newton::default()
        };
        let xpbd = |substeps, iterations| Method::Xpbd {
            substeps,
            iterations,
        };
        for (method, value) in [
            (Method::ImplicitEuler(none), Some("iterations")),
            (Method::ImplicitMidpoint(none), Some("iterations")),
            (Method::GuardedMidpoint(none), Some("iterations")),
            (Method::Sdirk2(none), Some("iterations")),
            (Method::QuasiStatic(none), Some("iterations")),
            (xpbd(1, 0), Some("iterations")),
            (xpbd(0, 1), Some("substeps")),
            (xpbd(1, 1), None),
            (Method::QuasiStatic(Newton::default()), None),
        ] {
            let refused = method.solver(&model).err();
            assert_eq!(
                refused.map(|error| (error.method, error.reason.split(' ').next())),
                value.map(|value| (method.name(), Some(value))),
            );
        }
    }
}
