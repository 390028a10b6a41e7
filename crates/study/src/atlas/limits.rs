//! The largest stable step, measured and predicted.
//!
//! Measured: bisection between steps that keep a tiny random disturbance small and steps that blow it up, with the solver
//! itself. The disturbance is a billionth of a cell, so that the body is linear and the limit is that of NUMERICS 3.1; with
//! [`Variation::Amplitude`] it is as large as stated, and the limit is that of the nonlinear body.
//!
//! Predicted: the limit of the method for the largest eigenvalue, which is exact, or from a bound or estimate of it.

use super::subject::{CELL, Subject, Substance, Variation, disturbed};
use microsim_tissue::elements::{ElementMatrix, EnergyKind, Tangent};
use microsim_tissue::stability::{self, Part};
use microsim_tissue::{Control, Method, MethodName, Newton, Serial, State, TissueModel};

/// The methods with a limit: all that are explicit.
pub fn methods() -> impl Iterator<Item = Method> {
    // No explicit method has parameters.
    let all = MethodName::ALL.into_iter();
    all.map(|name| Method::named(name, Newton::default(), 1, 1))
        .filter(Method::is_explicit)
}

/// Size of the disturbance of a linear body, as a fraction of a cell.
const TINY: f64 = 1e-9;
/// A disturbance that has grown by this factor has blown up.
const BLOWN_UP: f64 = 1e4;
/// A finite motion whose energy has grown by this factor has blown up.
const ENERGY_BLOWN_UP: f64 = 10.0;
/// Steps of a trial of a finite motion.
const FINITE_STEPS: u32 = 2000;
/// Accuracy of a limit, as a fraction of it: of a linear body, of a finite motion.
const ACCURACY: [f64; 2] = [2e-3, 0.02];
/// The shortest step that is tried, as a fraction of 2/ω_max.
const SHORTEST: f64 = 0.02;
/// Steps of the power iteration (NUMERICS 3.2).
const POWER_STEPS: usize = 20;

/// A limit as it was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measured {
    /// Stable up to this step \[s\].
    Step(f64),
    /// Unstable at every step that was tried, down to this one \[s\].
    Never(f64),
}

impl Measured {
    /// The step \[s\]; `None` where none is stable.
    pub fn step(&self) -> Option<f64> {
        match self {
            Self::Step(step) => Some(*step),
            Self::Never(_) => None,
        }
    }
}

/// The limit of one method on one body.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// The method.
    pub method: Method,
    /// What the body is made of.
    pub substance: Substance,
    /// In which respect it differs.
    pub variation: Variation,
    /// What was measured.
    pub measured: Measured,
    /// From the exact largest eigenvalue \[s\]; 0 for a method that is never stable.
    pub exact: f64,
    /// From the Gershgorin bound (G) of NUMERICS 3.2 \[s\].
    pub gershgorin: f64,
    /// From 20 steps of power iteration without margin \[s\].
    pub power: f64,
    /// From k_c of 3.21: the step at which the stiffest spring for its masses has that stiffness \[s\]; `None` without springs.
    pub delingette: Option<f64>,
}

impl Limit {
    /// Measures and predicts the limit of `method` on `subject`; `None` for a finite motion with a method that is not even stable for
    /// the smallest one.
    pub fn find(
        method: Method,
        substance: Substance,
        variation: Variation,
        subject: &Subject,
    ) -> Option<Self> {
        let model = &subject.model;
        // The fastest mode sets the limit, but for explicit Euler, where it may be the slowest.
        let each = subject.eigenvalues.iter().map(|&lambda| {
            predicted(
                &method,
                lambda,
                subject.drag,
                subject.relaxation_time * lambda,
            )
        });
        let exact = each.fold(f64::INFINITY, f64::min);
        let from = |bound: &dyn Fn(Part) -> f64| {
            let viscous = subject.relaxation_time > 0.0;
            let damping = if viscous { bound(Part::Damping) } else { 0.0 };
            predicted(&method, bound(Part::Stiffness), subject.drag, damping)
        };
        if exact == 0.0 && matches!(variation, Variation::Amplitude(_)) {
            return None;
        }
        Some(Self {
            method,
            substance,
            variation,
            measured: measure(&method, variation, subject, exact),
            exact,
            gershgorin: from(&|part| stability::gershgorin_bound(model, part)),
            power: from(&|part| stability::power_iteration(model, part, POWER_STEPS)),
            delingette: delingette_step(model),
        })
    }

    /// Measured over predicted; `None` where one of both is zero.
    pub fn ratio(&self) -> Option<f64> {
        let ratio = self.measured.step()? / self.exact;
        ratio.is_finite().then_some(ratio)
    }

    /// Whether theory and measurement agree: both have no stable step, or they differ by at most `tolerance`. `None` for a
    /// finite motion, for which there is no exact prediction.
    pub fn agrees(&self, tolerance: f64) -> Option<bool> {
        if matches!(self.variation, Variation::Amplitude(_)) {
            return None;
        }
        Some(match self.ratio() {
            Some(ratio) => (ratio - 1.0).abs() <= tolerance,
            None => self.exact == 0.0 && self.measured.step().is_none(),
        })
    }
}

/// The step \[s\] at which `method` becomes unstable for a mode of eigenvalue `lambda` \[1/s²\] with `drag` \[1/s\] and viscous forces
/// of the rate `viscous` \[1/s\] (NUMERICS 3.1; at most one of the two above zero).
///
/// Viscous forces come from a known velocity in every explicit method, without the exact factor that drag enjoys. For
/// Störmer–Verlet it is (p_n − p_{n−1})/h, as in symplectic Euler. Velocity Verlet takes them at v_n + h a_n, with a_n carried over
/// from the step before: its update of (p, v, a) has the characteristic polynomial
///
/// ```text
/// z³ − (2 − q − 3δ/2) z² + (1 − 2δ) z + δ/2        q = h²λ, δ = h·viscous
/// ```
///
/// and the first root to leave the circle does so at −1, where q = 4 − 4δ.
pub fn predicted(method: &Method, lambda: f64, drag: f64, viscous: f64) -> f64 {
    match method {
        _ if viscous == 0.0 => stability::limit(method, lambda, drag),
        Method::StoermerVerlet => stability::limit(&Method::SymplecticEuler, lambda, viscous),
        Method::VelocityVerlet => 2.0 / (viscous + (viscous * viscous + lambda).sqrt()),
        _ => stability::limit(method, lambda, viscous),
    }
}

/// The step \[s\] at which the first spring reaches k_c = m/(π² h²), m the smaller mass of its free ends.
fn delingette_step(model: &TissueModel) -> Option<f64> {
    let state = State::at_rest(model);
    let mut shortest: Option<f64> = None;
    let mut matrix = ElementMatrix::new();
    for (index, set) in model.sets().iter().enumerate() {
        if set.kind() != EnergyKind::Length {
            continue;
        }
        let at = state.configuration(model, index);
        for element in 0..set.count() {
            set.stiffness(element, &at, Tangent::Exact, &mut matrix);
            let ends = set.nodes(element).iter().map(|&node| node as usize);
            let free = ends.filter(|&node| !model.is_clamped(node));
            let mass = free
                .map(|node| model.masses()[node])
                .fold(f64::INFINITY, f64::min);
            if mass.is_finite() {
                // The block of a node is k u uᵀ; k_c(1 s) ∝ 1/h².
                let step =
                    (stability::delingette_stiffness(mass, 1.0) / matrix.block(0, 0).norm()).sqrt();
                shortest = Some(shortest.map_or(step, |s| s.min(step)));
            }
        }
    }
    shortest
}

/// Bisection; `exact` is the prediction \[s\].
fn measure(method: &Method, variation: Variation, subject: &Subject, exact: f64) -> Measured {
    let finite = match variation {
        Variation::Amplitude(fraction) => Some(fraction),
        _ => None,
    };
    let stable = |h: f64| match finite {
        Some(fraction) => survives(method, &subject.model, fraction, h),
        None => stays_small(method, subject, h),
    };
    let [linear_accuracy, finite_accuracy] = ACCURACY;
    let accuracy = if finite.is_some() {
        finite_accuracy
    } else {
        linear_accuracy
    };
    let shortest = SHORTEST * 2.0 / subject.lambda().sqrt();
    let guess = if exact > 0.0 { exact } else { 50.0 * shortest };
    // Outward from the prediction until one end is stable and the other is not.
    let (mut low, mut high) = (guess / 1.1, guess * 1.1);
    while !stable(low) {
        high = low;
        low /= 1.5;
        if low < shortest {
            return Measured::Never(high);
        }
    }
    while stable(high) {
        low = high;
        high *= 1.5;
    }
    while high / low > 1.0 + accuracy {
        let middle = (low * high).sqrt();
        if stable(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    Measured::Step((low * high).sqrt())
}

/// Whether a tiny disturbance stays small.
///
/// It has blown up when it is 10⁴ times as large, and also when it is still growing in the end: the largest value in the last
/// quarter of the run is twice that in the second. An undamped body that is stable keeps its size; near the limit the size
/// swings by up to 1/√(1 − q/4), less than 25 at the accuracy of the bisection, within some 100 steps.
fn stays_small(method: &Method, subject: &Subject, h: f64) -> bool {
    let model = &subject.model;
    let damped = subject.drag > 0.0 || subject.relaxation_time > 0.0;
    // Undamped, what is unstable grows by some 10 % a step right beyond the limit. Damped, the rate grows from zero.
    let steps = match method {
        Method::ExplicitEuler if damped => 12_000,
        Method::ExplicitEuler => 4000,
        _ if damped => 4000,
        _ => 800,
    };
    let start = disturbed(model, TINY * CELL);
    let size = |state: &State| -> f64 {
        let nodes = state.positions.iter().zip(model.rest_positions());
        let squares = nodes
            .zip(model.masses())
            .map(|((p, r), m)| m * (p - r).norm_squared());
        squares.sum::<f64>().sqrt()
    };
    let bound = BLOWN_UP * size(&start);
    let mut quarters = [0.0f64; 4];
    let mut step = 0;
    let bounded = run(method, model, start, h, steps, |state| {
        let now = size(state);
        let quarter = &mut quarters[(4 * step / steps) as usize];
        *quarter = quarter.max(now);
        step += 1;
        now < bound
    });
    bounded && quarters[3] < 2.0 * quarters[1]
}

/// Whether a body keeps its energy that starts from random offsets of a fraction of a cell.
pub(super) fn survives(method: &Method, model: &TissueModel, fraction: f64, h: f64) -> bool {
    let start = disturbed(model, fraction * CELL);
    let bound = ENERGY_BLOWN_UP * start.energies(model).total();
    let mut step = 0;
    run(method, model, start, h, FINITE_STEPS, |state| {
        step += 1;
        // The energy costs as much as a step.
        step % 10 != 0 || state.energies(model).total() < bound
    })
}

/// Makes up to `steps` steps while `go_on` is true; whether all were made.
pub(super) fn run(
    method: &Method,
    model: &TissueModel,
    mut state: State,
    h: f64,
    steps: u32,
    mut go_on: impl FnMut(&State) -> bool,
) -> bool {
    let Ok(mut solver) = method.solver(model) else {
        return false;
    };
    let control = Control::default();
    (0..steps).all(|_| {
        let done = solver.step(model, &mut state, &control, &[], h, &Serial);
        done.is_ok() && go_on(&state)
    })
}
