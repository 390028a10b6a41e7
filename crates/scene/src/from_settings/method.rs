//! Methods.

use microsim_settings as settings;
use microsim_tissue::{Method, Newton};

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
    let substeps = method.substeps.unwrap_or(SUBSTEPS);
    let iterations = method.iterations.unwrap_or(ITERATIONS);
    Method::named(method.name, newton, substeps, iterations)
}
