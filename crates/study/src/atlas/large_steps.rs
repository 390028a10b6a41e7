//! Methods without a limit at steps far beyond that of the explicit ones: what they do to a motion instead of blowing up.
//!
//! The block swings for one period from a small bend that is nearly its first mode, without any damping of its own: what is left
//! of its energy is what the method leaves. And it starts from random offsets of a fifth of a cell, in which every mode and all
//! nonlinearity takes part: how far its energy grows.

use super::limits::run;
use super::subject::{CELL, Subject, Substance, disturbed};
use microsim_tissue::law::LawName;
use microsim_tissue::{Control, Discretisation, Method, Newton, Serial, State, TissueModel};
use nalgebra::Vector3;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Steps per period of the first mode.
const PER_PERIOD: [u32; 5] = [200, 50, 20, 5, 2];
/// Weight that bends the block for the first mode \[m/s²\]: it sags by some 10⁻⁴ of its length.
const WEIGHT: f64 = 0.01;
/// Random offsets, as a fraction of a cell.
const OFFSET: f64 = 0.2;
/// Steps from random offsets.
const RANDOM_STEPS: u32 = 400;

/// The start of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Bent as in the first mode; small.
    Bent,
    /// All nodes at random; large.
    Random,
}

impl Start {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Bent, Self::Random];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bent => "small bend",
            Self::Random => "random offsets",
        }
    }
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct LargeStep {
    /// The method.
    pub method: Method,
    /// What the block is made of.
    pub substance: Substance,
    /// How it starts.
    pub start: Start,
    /// Steps per period of the first mode.
    pub per_period: u32,
    /// Length of a step \[s\].
    pub step: f64,
    /// The step over the limit of Störmer–Verlet.
    pub over_limit: f64,
    /// Energy as a fraction of that at the start: after one period, from random offsets the largest of 400 steps. `None` where the
    /// solver gave up.
    pub energy: Option<f64>,
    /// What is left after a period by linear theory, where there is a closed form.
    pub predicted: Option<f64>,
}

/// The methods of these runs.
fn methods() -> Vec<Method> {
    let newton = Newton {
        iterations: 20,
        tolerance: 1e-8,
        must_converge: false,
    };
    let xpbd = |iterations| Method::Xpbd {
        substeps: 1,
        iterations,
    };
    vec![
        Method::ImplicitEuler(newton),
        Method::ImplicitMidpoint(newton),
        Method::GuardedMidpoint(newton),
        Method::Sdirk2(newton),
        xpbd(1),
        xpbd(10),
    ]
}

/// The substances of these runs.
pub fn substances() -> Vec<Substance> {
    let tetrahedra = |law| Substance::Continuum(law, Discretisation::Tetrahedra);
    vec![
        Substance::SpringsVolumes,
        tetrahedra(LawName::Corotational),
        tetrahedra(LawName::StableNeoHookean),
        tetrahedra(LawName::NeoHookeanPolynomial),
    ]
}

/// All runs of one substance.
pub fn large_steps(substance: Substance, subject: &Subject, starts: &[Start]) -> Vec<LargeStep> {
    let model = &subject.model;
    let Some((bent, omega)) = first_mode(model) else {
        return Vec::new();
    };
    let period = 2.0 * PI / omega;
    let mut runs = Vec::new();
    for method in methods() {
        // A body of this substance may be none for the method.
        if method.solver(model).is_err() {
            continue;
        }
        for &start in starts {
            for per_period in PER_PERIOD {
                let step = period / f64::from(per_period);
                let energy = match start {
                    Start::Bent => energy_left(&method, model, &bent, step, per_period),
                    Start::Random => largest_energy(&method, model, step),
                };
                runs.push(LargeStep {
                    method,
                    substance,
                    start,
                    per_period,
                    step,
                    over_limit: 0.5 * step * subject.lambda().sqrt(),
                    energy,
                    predicted: match start {
                        Start::Bent => predicted(&method, per_period),
                        Start::Random => None,
                    },
                });
            }
        }
    }
    runs
}

/// The block bent by its weight, and the frequency of that shape by Rayleigh's quotient ω² = 2E/Σ m u² \[1/s\].
fn first_mode(model: &TissueModel) -> Option<(State, f64)> {
    let newton = Newton {
        iterations: 50,
        tolerance: 1e-10,
        must_converge: true,
    };
    let mut state = State::at_rest(model);
    let control = Control {
        gravity: Vector3::new(0.0, 0.0, -WEIGHT),
        ..Control::default()
    };
    let mut solver = Method::QuasiStatic(newton).solver(model).ok()?;
    solver
        .step(model, &mut state, &control, &[], 1.0, &Serial)
        .ok()?;
    let moved = state.positions.iter().zip(model.rest_positions());
    let inertia: f64 = moved
        .zip(model.masses())
        .map(|((p, r), m)| m * (p - r).norm_squared())
        .sum();
    let omega = (2.0 * state.energies(model).elastic() / inertia).sqrt();
    Some((state, omega))
}

/// Fraction of the energy that is left after a period.
fn energy_left(
    method: &Method,
    model: &TissueModel,
    start: &State,
    h: f64,
    steps: u32,
) -> Option<f64> {
    let whole = start.energies(model).total();
    let mut left = whole;
    run(method, model, start.clone(), h, steps, |state| {
        left = state.energies(model).total();
        true
    })
    .then_some(left / whole)
}

/// Largest energy from random offsets as a fraction of that at the start.
fn largest_energy(method: &Method, model: &TissueModel, h: f64) -> Option<f64> {
    let start = disturbed(model, OFFSET * CELL);
    let whole = start.energies(model).total();
    let mut largest = 0.0f64;
    run(method, model, start, h, RANDOM_STEPS, |state| {
        let now = state.energies(model).total();
        largest = largest.max(now);
        now.is_finite()
    })
    .then_some(largest / whole)
}

/// Fraction of the energy of one mode that a method leaves after a period of `steps` steps: |R(iy)|² of each, y = 2π/steps.
fn predicted(method: &Method, steps: u32) -> Option<f64> {
    let y = 2.0 * PI / f64::from(steps);
    let per_step = match method {
        Method::ImplicitEuler(_) => 1.0 / (1.0 + y * y),
        // Small bending distorts no element, so the guard never acts.
        Method::ImplicitMidpoint(_) | Method::GuardedMidpoint(_) => 1.0,
        Method::Sdirk2(_) => {
            // R(z) = (1 + (1 − 2γ) z)/(1 − γ z)² (Alexander 1977).
            let gamma = 1.0 - FRAC_1_SQRT_2;
            let numerator = 1.0 + (1.0 - 2.0 * gamma) * (1.0 - 2.0 * gamma) * y * y;
            let root = 1.0 + gamma * gamma * y * y;
            numerator / (root * root)
        }
        _ => return None,
    };
    Some((0..steps).fold(1.0, |left, _| left * per_step))
}
