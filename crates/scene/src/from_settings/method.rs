//! Methods.

use microsim_settings as settings;
use microsim_tissue::{Method, Newton};
use settings::MethodName;

/// Sub-steps and iterations of position-based dynamics where a file has none: small steps rather than many iterations
/// (Macklin et al. 2019).
const SUBSTEPS: u32 = 10;
const ITERATIONS: u32 = 1;

/// A method with its parameters; those that the file does not give are the method's own.
pub(super) fn method(method: &settings::Method) -> Method {
    let own = Newton::default();
    let newton = Newton {
        iterations: method.iterations.unwrap_or(own.iterations),
        tolerance: method.tolerance.unwrap_or(own.tolerance),
        must_converge: method.must_converge.unwrap_or(own.must_converge),
    };
    match method.name {
        MethodName::StoermerVerlet => Method::StoermerVerlet,
        MethodName::ExplicitEuler => Method::ExplicitEuler,
        MethodName::SymplecticEuler => Method::SymplecticEuler,
        MethodName::VelocityVerlet => Method::VelocityVerlet,
        MethodName::VelocityVerletLagged => Method::VelocityVerletLagged,
        MethodName::ImplicitEuler => Method::ImplicitEuler(newton),
        MethodName::ImplicitMidpoint => Method::ImplicitMidpoint(newton),
        MethodName::GuardedMidpoint => Method::GuardedMidpoint(newton),
        MethodName::Sdirk2 => Method::Sdirk2(newton),
        MethodName::QuasiStatic => Method::QuasiStatic(newton),
        MethodName::Xpbd => Method::Xpbd {
            substeps: method.substeps.unwrap_or(SUBSTEPS),
            iterations: method.iterations.unwrap_or(ITERATIONS),
        },
    }
}
