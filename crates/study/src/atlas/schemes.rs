//! The schemes with which the recovery of the beam is computed.

use super::method_name;
use super::recovery::{Scheme, StepLength};
use super::subject::Substance;
use microsim_tissue::law::LawName;
use microsim_tissue::{Discretisation, Method, Newton};

/// Drag of all schemes \[1/s\]: half of the critical damping of the first bending mode, which takes some 0.28 s.
const DRAG: f64 = 20.0;

impl Scheme {
    /// Its name in reports.
    pub fn name(&self) -> String {
        format!("{}, {}", method_name(&self.method), self.substance.name())
    }
}

const SPRINGS: Substance = Substance::SpringsVolumes;
const ST_VENANT: Substance = tetrahedra(LawName::StVenantKirchhoff);
const COROTATIONAL: Substance = tetrahedra(LawName::Corotational);
const STABLE: Substance = tetrahedra(LawName::StableNeoHookean);
const POLYNOMIAL: Substance = tetrahedra(LawName::NeoHookeanPolynomial);
const SELECTIVE: Substance =
    Substance::Continuum(LawName::StableNeoHookean, Discretisation::Selective);
const NODAL_PRESSURE: Substance =
    Substance::Continuum(LawName::StableNeoHookean, Discretisation::NodalPressure);
const PATCH_PRESSURE: Substance =
    Substance::Continuum(LawName::StableNeoHookean, Discretisation::PatchPressure);
const COROTATIONAL_SELECTIVE: Substance =
    Substance::Continuum(LawName::Corotational, Discretisation::Selective);

/// All substances of the beam: fitted springs, every law on tetrahedra, and what keeps from locking.
fn substances() -> Vec<Substance> {
    let laws = LawName::ALL.into_iter().map(tetrahedra);
    let others = [
        SELECTIVE,
        NODAL_PRESSURE,
        PATCH_PRESSURE,
        COROTATIONAL_SELECTIVE,
    ];
    std::iter::once(SPRINGS).chain(laws).chain(others).collect()
}

const fn tetrahedra(law: LawName) -> Substance {
    Substance::Continuum(law, Discretisation::Tetrahedra)
}

const fn scheme(method: Method, substance: Substance, step: StepLength) -> Scheme {
    Scheme {
        method,
        substance,
        step,
        drag: DRAG,
        relaxation_time: 0.0,
    }
}

/// Newton's method up to `iterations`; a step that has not converged is made all the same.
const fn newton(iterations: u32) -> Newton {
    Newton {
        iterations,
        tolerance: 1e-4,
        must_converge: false,
    }
}

/// Newton's method of the quasi-static solver, which has no fallback.
const STATIC: Newton = Newton {
    iterations: 50,
    tolerance: 1e-4,
    must_converge: true,
};

const fn xpbd(substeps: u32, iterations: u32) -> Method {
    Method::Xpbd {
        substeps,
        iterations,
    }
}

const fn milliseconds(ms: f64) -> StepLength {
    StepLength::Seconds(1e-3 * ms)
}

/// Every method, law and discretisation, at several steps.
pub fn all() -> Vec<Scheme> {
    let mut schemes = Vec::new();
    // Explicit: one method on every material, the others on one.
    for substance in substances() {
        for fraction in [0.9, 0.6, 0.3, 0.1] {
            schemes.push(scheme(
                Method::StoermerVerlet,
                substance,
                StepLength::LimitFraction(fraction),
            ));
        }
    }
    for method in [
        Method::SymplecticEuler,
        Method::VelocityVerlet,
        Method::VelocityVerletLagged,
        Method::ExplicitEuler,
    ] {
        schemes.push(scheme(method, COROTATIONAL, StepLength::LimitFraction(0.6)));
    }
    for substance in [SPRINGS, COROTATIONAL, STABLE] {
        schemes.push(Scheme {
            relaxation_time: 1e-4,
            ..scheme(
                Method::StoermerVerlet,
                substance,
                StepLength::LimitFraction(0.6),
            )
        });
    }
    // Implicit.
    for substance in substances() {
        for ms in [5.0, 20.0] {
            schemes.push(scheme(
                Method::ImplicitEuler(newton(1)),
                substance,
                milliseconds(ms),
            ));
            schemes.push(scheme(
                Method::ImplicitEuler(newton(20)),
                substance,
                milliseconds(ms),
            ));
            schemes.push(scheme(
                Method::GuardedMidpoint(newton(1)),
                substance,
                milliseconds(ms),
            ));
            schemes.push(scheme(
                Method::Sdirk2(newton(20)),
                substance,
                milliseconds(ms),
            ));
        }
        schemes.push(scheme(
            Method::QuasiStatic(STATIC),
            substance,
            milliseconds(100.0),
        ));
    }
    for substance in [SPRINGS, COROTATIONAL, STABLE] {
        schemes.push(scheme(
            Method::ImplicitMidpoint(newton(20)),
            substance,
            milliseconds(5.0),
        ));
        schemes.push(Scheme {
            relaxation_time: 5e-3,
            ..scheme(
                Method::ImplicitMidpoint(newton(20)),
                substance,
                milliseconds(5.0),
            )
        });
    }
    // Position-based: sub-steps of 0.1, 0.25, 0.5 and 5 ms.
    for substance in [SPRINGS, POLYNOMIAL] {
        for method in [
            xpbd(50, 1),
            xpbd(20, 1),
            xpbd(10, 1),
            xpbd(1, 1),
            xpbd(1, 20),
        ] {
            schemes.push(scheme(method, substance, milliseconds(5.0)));
        }
    }
    schemes
}

/// One or two of each kind.
pub fn few() -> Vec<Scheme> {
    vec![
        scheme(
            Method::StoermerVerlet,
            SPRINGS,
            StepLength::LimitFraction(0.6),
        ),
        scheme(
            Method::StoermerVerlet,
            COROTATIONAL,
            StepLength::LimitFraction(0.6),
        ),
        scheme(
            Method::StoermerVerlet,
            STABLE,
            StepLength::LimitFraction(0.6),
        ),
        scheme(
            Method::StoermerVerlet,
            STABLE,
            StepLength::LimitFraction(0.3),
        ),
        scheme(Method::ImplicitEuler(newton(1)), SPRINGS, milliseconds(5.0)),
        scheme(Method::ImplicitEuler(newton(1)), STABLE, milliseconds(5.0)),
        scheme(
            Method::ImplicitEuler(newton(20)),
            ST_VENANT,
            milliseconds(20.0),
        ),
        scheme(
            Method::ImplicitEuler(newton(20)),
            STABLE,
            milliseconds(20.0),
        ),
        scheme(
            Method::GuardedMidpoint(newton(1)),
            STABLE,
            milliseconds(20.0),
        ),
        scheme(Method::Sdirk2(newton(20)), STABLE, milliseconds(20.0)),
        scheme(
            Method::ImplicitMidpoint(newton(20)),
            SPRINGS,
            milliseconds(20.0),
        ),
        scheme(Method::QuasiStatic(STATIC), STABLE, milliseconds(100.0)),
        scheme(xpbd(10, 1), POLYNOMIAL, milliseconds(5.0)),
    ]
}
