//! The return mapping against closed forms; what no flow may do; ranges.

use super::*;
use crate::law::{
    Corotational, Lame, MooneyRivlin, NeoHookean, NeoHookeanPolynomial, StVenantKirchhoff,
    StableNeoHookean, TransverselyIsotropic,
};
use crate::testing::numbers;
use nalgebra::Vector3;

const WALL: ContinuumPlasticity = ContinuumPlasticity {
    yield_strain: 0.05,
    yield_growth: 0.4,
    creep_rate: None,
    max_strain: 2.0,
    hardening: 0.0,
    max_stiffening: 1.0,
};

/// Without any bound but the last one, that of the energy.
const STIFFENING: ContinuumPlasticity = ContinuumPlasticity {
    hardening: 500.0,
    max_stiffening: 1e9,
    ..WALL
};

/// Two logarithms, two exponentials, an eigenvalue problem and a root, each to a few roundings of numbers of order one.
const ROUNDING: f64 = 1e-14;

fn lame() -> Lame {
    Lame::from_young_poisson(1.0, 0.45)
}

fn rotation(next: &mut impl FnMut() -> f64) -> Matrix3<f64> {
    SignedSvd::new(&Matrix3::from_fn(|_, _| next())).rotation()
}

/// Logarithmic strain `strain` along an axis at constant volume.
fn uniaxial(strain: f64) -> Matrix3<f64> {
    let across = libm::exp(-0.5 * strain);
    Matrix3::from_diagonal(&Vector3::new(libm::exp(strain), across, across))
}

fn equivalent(f: &Matrix3<f64>) -> f64 {
    let logs = SignedSvd::new(f).stretches.map(libm::log);
    let deviator = logs.add_scalar(-logs.sum() / 3.0);
    (deviator.norm_squared() * (2.0 / 3.0)).sqrt()
}

/// What flows in an element that is held at `f` for `time` in `steps` steps.
fn hold(
    plasticity: &ContinuumPlasticity,
    f: &Matrix3<f64>,
    time: f64,
    steps: usize,
) -> PlasticState {
    let mut state = PlasticState::START;
    let flow = plasticity.over(time / steps as f64);
    for _ in 0..steps {
        flow.apply::<NeoHookean>(f, &lame(), &mut state);
    }
    state
}

/// Held at a logarithmic strain ε at constant volume, in any axes: p = (ε − e_y)/(1 + K) (1 − e^(−r (1 + K) t)), all at once without a
/// rate; F_p has the strain p along the axis.
#[test]
fn flow_is_the_closed_form_in_any_number_of_steps() {
    let mut next = numbers();
    for (strain, growth) in [(0.3, 0.0), (-0.2, 0.4), (1.1, 2.5)] {
        let axes = rotation(&mut next);
        let f = rotation(&mut next) * axes * uniaxial(strain) * axes.transpose();
        for rate in [None, Some(3.0)] {
            let plasticity = ContinuumPlasticity {
                yield_growth: growth,
                creep_rate: rate,
                ..WALL
            };
            for (time, steps) in [(0.1, 1), (0.1, 7), (0.9, 1), (0.9, 300)] {
                let end = (f64::abs(strain) - 0.05) / (1.0 + growth);
                let passed =
                    rate.map_or(1.0, |rate| 1.0 - libm::exp(-rate * (1.0 + growth) * time));
                let expected = end * passed;
                let state = hold(&plasticity, &f, time, steps);
                let bound = ROUNDING * (1.0 + steps as f64);
                assert!(
                    (state.strain - expected).abs() < bound,
                    "{state:?} {expected}"
                );
                let shape = axes * uniaxial(-expected.copysign(strain)) * axes.transpose();
                assert!((state.inverse - shape).amax() < 2.0 * bound, "{state:?}");
            }
        }
    }
}

/// Stretched far beyond yield along axes that turn, after each step without a rate the elastic strain is that of yielding, to rounding, and
/// the plastic stretch has no volume however often it flowed.
#[test]
fn the_return_is_exact_and_flow_has_no_volume() {
    let mut next = numbers();
    let perfect = ContinuumPlasticity {
        yield_growth: 0.0,
        max_strain: 1e9,
        ..WALL
    };
    let mut state = PlasticState::START;
    let mut flowed = 0;
    for _ in 0..5000 {
        let f = Matrix3::identity() + Matrix3::from_fn(|_, _| next()) * 0.4;
        let before = equivalent(&(f * state.inverse));
        flowed += usize::from(
            perfect
                .over(1e-3)
                .apply::<NeoHookean>(&f, &lame(), &mut state)
                != Flowed::Not,
        );
        let after = equivalent(&(f * state.inverse));
        // Stretches reach 10 here, and logarithms have their relative errors: of C_p⁻¹ some hundred roundings.
        assert!((after - before.min(0.05)).abs() < 1e-12, "{before} {after}");
        assert!((state.inverse.determinant() - 1.0).abs() < 1e-13);
        assert_eq!(state.inverse, state.inverse.transpose());
    }
    assert!(flowed > 4900, "{flowed}");
}

#[test]
fn nothing_flows_below_yield_nor_without_shape_nor_without_volume() {
    let none = |f: &Matrix3<f64>| assert_eq!(hold(&WALL, f, 1.0, 3), PlasticState::START, "{f}");
    none(&uniaxial(0.0499));
    none(&uniaxial(-0.0499));
    // Volume alone.
    none(&(Matrix3::identity() * 1.7));
    none(&(Matrix3::identity() * 0.4));
    for flat in [0.0, -0.3, f64::NAN] {
        none(&Matrix3::from_diagonal(&Vector3::new(1.4, 1.1, flat)));
    }
    assert_ne!(hold(&WALL, &uniaxial(0.0501), 1.0, 1), PlasticState::START);
    let rigid = ContinuumPlasticity {
        max_strain: 0.0,
        ..WALL
    };
    assert_eq!(hold(&rigid, &uniaxial(0.7), 1.0, 3), PlasticState::START);
}

#[test]
fn plastic_strain_and_stiffness_are_bounded() {
    let bounded = ContinuumPlasticity {
        max_strain: 0.2,
        hardening: 30.0,
        max_stiffening: 1.5,
        ..WALL
    };
    let state = hold(&bounded, &uniaxial(0.9), 1.0, 4);
    assert!((state.strain - 0.2).abs() < 1e-15, "{state:?}");
    // Of the strain 0.9 a flow of 0.2 sets more free than half of the energy that is left: ½ (0.9² − 0.7²)/0.7² at small strain.
    assert!(
        state.stiffening > 1.0 && state.stiffening <= 1.5,
        "{state:?}"
    );
    let hardly = ContinuumPlasticity {
        hardening: 0.5,
        ..bounded
    };
    let state = hold(&hardly, &uniaxial(0.9), 1.0, 4);
    assert!((state.stiffening - 1.1).abs() < 1e-15, "{state:?}");
}

/// That the bound that spares the decomposition lets nothing through: e itself, of many shapes, against the bound at e; compression meets it.
#[test]
fn the_elastic_bound_is_the_least_trace_of_a_strain() {
    let mut next = numbers();
    for strain in [1e-3, 0.05, 0.4, 2.0] {
        let bound = elastic_bound(strain);
        let trace = |d: &Vector3<f64>| d.map(|d| libm::exp(2.0 * d)).sum();
        for _ in 0..500 {
            let d = Vector3::from_fn(|_, _| next());
            let d = d.add_scalar(-d.sum() / 3.0);
            let d: Vector3<f64> = d * (strain * 1.5_f64.sqrt() / d.norm());
            let least: f64 = trace(&d);
            assert!(least.powi(3) >= bound * (1.0 - ROUNDING), "{d}");
        }
        let compressed = Vector3::new(-strain, 0.5 * strain, 0.5 * strain);
        let least: f64 = trace(&compressed);
        assert!((least.powi(3) / bound - 1.0).abs() < ROUNDING);
    }
}

/// What leaves the elastic energy is what is counted as dissipated, whatever the law, and never negative; with strong hardening, too, which
/// without its bound would store more than flow sets free.
#[test]
fn the_energy_that_flow_takes_is_counted() {
    fn check<L: Law>(plasticity: &ContinuumPlasticity, held_back: &mut bool) {
        let constants =
            L::constants(&lame(), &L::Parameters::default()).along([Vector3::x(), Vector3::y()]);
        let mut next = numbers();
        for _ in 0..40 {
            let mut state = PlasticState::START;
            for _ in 0..12 {
                let f = Matrix3::identity() + Matrix3::from_fn(|_, _| next()) * 0.3;
                let energy =
                    |state: &PlasticState| state.energy::<L>(&(f * state.inverse), &constants);
                let before = state;
                plasticity.over(0.01).apply::<L>(&f, &constants, &mut state);
                let taken = state.dissipated - before.dissipated;
                assert!(taken >= 0.0 && state.stiffening >= before.stiffening);
                let scale = energy(&before).abs().max(state.dissipated).max(1.0);
                let freed = energy(&before) - energy(&state);
                assert!(
                    (freed - taken).abs() < 10.0 * ROUNDING * scale,
                    "{freed} {taken}"
                );
                *held_back |= state.stiffening < 1.0 + plasticity.hardening * state.strain;
            }
        }
    }
    let mut held_back = false;
    for plasticity in [WALL, STIFFENING] {
        check::<NeoHookean>(&plasticity, &mut held_back);
        check::<StableNeoHookean>(&plasticity, &mut held_back);
        check::<NeoHookeanPolynomial>(&plasticity, &mut held_back);
        check::<MooneyRivlin>(&plasticity, &mut held_back);
        check::<TransverselyIsotropic>(&plasticity, &mut held_back);
        check::<StVenantKirchhoff>(&plasticity, &mut held_back);
        check::<Corotational>(&plasticity, &mut held_back);
    }
    assert!(held_back, "the bound was reached");
}

/// Compressed to 0.3 along one axis St Venant–Kirchhoff has less energy than in the round shape of the same volume: with ν = 0 that is
/// μ E:E, 0.455² = 0.207 against 3 · ((0.3^(2/3) − 1)/2)² = 0.229 (times μ). So it does not flow there, while a law whose stress grows with
/// the strain does.
#[test]
fn a_flow_that_would_raise_the_energy_does_not_happen() {
    let f = Matrix3::from_diagonal(&Vector3::new(0.3, 1.0, 1.0));
    let lame = Lame::from_young_poisson(1.0, 0.0);
    let perfect = ContinuumPlasticity {
        yield_strain: 0.0,
        yield_growth: 0.0,
        ..WALL
    };
    let mut state = PlasticState::START;
    let flowed = perfect
        .over(1.0)
        .apply::<StVenantKirchhoff>(&f, &lame, &mut state);
    assert_eq!((flowed, state), (Flowed::Not, PlasticState::START));
    let flowed = perfect.over(1.0).apply::<NeoHookean>(&f, &lame, &mut state);
    assert_eq!(flowed, Flowed::Shape);
}

/// What was turned before flow turns with it, now and, where there are no fibres, at rest: F_p⁻¹ with the rest, p and energies not at all.
#[test]
fn flow_is_objective() {
    let mut next = numbers();
    for _ in 0..50 {
        let f = Matrix3::identity() + Matrix3::from_fn(|_, _| next()) * 0.4;
        let (left, right) = (rotation(&mut next), rotation(&mut next));
        let mut states = [PlasticState::START; 2];
        for shear in [0.2, -0.3] {
            let mut f = f;
            f[(0, 1)] += shear;
            let turned = left * f * right.transpose();
            for (state, f) in states.iter_mut().zip([f, turned]) {
                STIFFENING.over(1.0).apply::<NeoHookean>(&f, &lame(), state);
            }
        }
        let [plain, turned] = states;
        let back = right.transpose() * turned.inverse * right;
        assert!((plain.inverse - back).amax() < 100.0 * ROUNDING);
        assert!((plain.strain - turned.strain).abs() < 100.0 * ROUNDING);
        assert!((plain.dissipated - turned.dissipated).abs() < 100.0 * ROUNDING);
    }
}

/// The mean of two extensions at right angles, of strain 1 at constant volume each, has a determinant of 1; the plain mean has 1.68.
#[test]
fn means_have_no_volume() {
    let along = |axis: usize| {
        let mut stretches = Vector3::repeat(libm::exp(-0.5));
        stretches[axis] = libm::exp(1.0);
        PlasticState {
            inverse: Matrix3::from_diagonal(&stretches),
            strain: 1.0 + axis as f64,
            ..PlasticState::START
        }
    };
    let mean = PlasticState::mean([along(0), along(1)].into_iter()).unwrap();
    // Equal along both axes, a third of 1/√e, scaled to determinant 1.
    let (a, b) = (0.5 * (libm::exp(1.0) + libm::exp(-0.5)), libm::exp(-0.5));
    let size = libm::cbrt(a * a * b);
    assert!(size > 1.1, "{size}");
    let expected = Matrix3::from_diagonal(&Vector3::new(a / size, a / size, b / size));
    assert!((mean.inverse - expected).amax() < ROUNDING);
    assert_eq!((mean.strain, mean.stiffening), (1.5, 1.0));
    assert_eq!(PlasticState::mean(std::iter::empty()), None);
}

#[test]
fn values_out_of_range_are_refused_by_name() {
    assert_eq!(WALL.check(), Ok(()));
    type Change = fn(&mut ContinuumPlasticity);
    let cases: [(&str, Change); 6] = [
        ("yield_strain", |p| p.yield_strain = -0.1),
        ("yield_growth", |p| p.yield_growth = f64::NAN),
        ("creep_rate", |p| p.creep_rate = Some(-1.0)),
        ("max_strain", |p| p.max_strain = f64::INFINITY),
        ("hardening", |p| p.hardening = -1.0),
        ("max_stiffening", |p| p.max_stiffening = 0.9),
    ];
    for (name, change) in cases {
        let mut wrong = WALL;
        change(&mut wrong);
        assert_eq!(wrong.check().unwrap_err().value_name, name);
    }
}
