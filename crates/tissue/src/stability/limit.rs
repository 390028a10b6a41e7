//! Exact limits of the linear model x'' + c x' + λ x = 0 (NUMERICS 3.1).

use crate::method::Method;

/// The step \[s\] at which `method` becomes unstable for one mode of eigenvalue `lambda` > 0 \[1/s²\] with the drag `drag` ≥ 0 per
/// mass \[1/s\]; infinite for a method without a limit.
///
/// With q = h²λ and δ = hc, stable is (Jury conditions on the update matrix):
///
/// | method | stable |
/// |---|---|
/// | explicit Euler | q < δ and δ < 2 + q/2: never without drag |
/// | symplectic Euler | q < 4 − 2δ |
/// | Störmer–Verlet, velocity Verlet, exact drag factor | q < 4 |
/// | lagged velocity Verlet | q < 2 − δ; q < 4 without drag |
/// | implicit, quasi-static, position-based | always |
///
/// Of all modes of a body the one of the largest eigenvalue has the shortest limit, except with explicit Euler: there the slow
/// modes bound the step by 2/c.
pub fn limit(method: &Method, lambda: f64, drag: f64) -> f64 {
    let (c, discriminant) = (drag, drag * drag - 4.0 * lambda);
    match method {
        // Overdamped, the real roots leave at −1 (δ = 2 + q/2); else the complex pair leaves the circle (q = δ).
        Method::ExplicitEuler if discriminant > 0.0 => 4.0 / (c + discriminant.sqrt()),
        Method::ExplicitEuler => c / lambda,
        Method::SymplecticEuler => 4.0 / (c + (c * c + 4.0 * lambda).sqrt()),
        Method::StoermerVerlet | Method::VelocityVerlet => 2.0 / lambda.sqrt(),
        Method::VelocityVerletLagged if drag == 0.0 => 2.0 / lambda.sqrt(),
        Method::VelocityVerletLagged => 4.0 / (c + (c * c + 8.0 * lambda).sqrt()),
        Method::ImplicitEuler(_)
        | Method::ImplicitMidpoint(_)
        | Method::GuardedMidpoint(_)
        | Method::Sdirk2(_)
        | Method::QuasiStatic(_)
        | Method::Xpbd { .. } => f64::INFINITY,
    }
}

/// What a mode may take up in a step of an explicit method: stable is h²λ + `viscosity` hΛ + `drag` hc < `room`, Λ the eigenvalue of
/// viscous forces \[1/s\] and c the drag per mass \[1/s\], both taken from a known velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Budget {
    pub room: f64,
    pub viscosity: f64,
    pub drag: f64,
}

/// The budget of a method for a body with viscosity or drag (`damped`) or without; `None` where there is none: a method that is stable at every step,
/// or explicit Euler, which needs damping in proportion to the stiffness.
pub(super) fn budget(method: &Method, damped: bool) -> Option<Budget> {
    let of = |room, viscosity, drag| Budget {
        room,
        viscosity,
        drag,
    };
    match method {
        Method::StoermerVerlet => Some(of(4.0, 2.0, 0.0)),
        Method::SymplecticEuler => Some(of(4.0, 2.0, 2.0)),
        Method::VelocityVerlet => Some(of(4.0, 4.0, 0.0)),
        Method::VelocityVerletLagged if damped => Some(of(2.0, 1.0, 1.0)),
        Method::VelocityVerletLagged => Some(of(4.0, 0.0, 0.0)),
        Method::ExplicitEuler
        | Method::ImplicitEuler(_)
        | Method::ImplicitMidpoint(_)
        | Method::GuardedMidpoint(_)
        | Method::Sdirk2(_)
        | Method::QuasiStatic(_)
        | Method::Xpbd { .. } => None,
    }
}

/// Delingette's estimate k_c = m/(π² h²) of the largest stiffness of a spring \[N/m\] between nodes of `mass` \[kg\] at the step
/// `h` \[s\] (3.21).
///
/// It means h·ω ≤ 1/π for one oscillator, and is 2.8 to 3.7 times below the limit in a block of tetrahedra (NUMERICS 3.3). It
/// knows nothing of volume forces and of unequal masses: a sanity check, not a bound.
pub fn delingette_stiffness(mass: f64, h: f64) -> f64 {
    mass / (std::f64::consts::PI * std::f64::consts::PI * h * h)
}
