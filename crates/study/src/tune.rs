//! The cheapest computation within a stated error: meshes, discretisations, methods and steps are tried, and each is chosen or rejected
//! for a reason.
//!
//! A mesh with a discretisation whose exact solution misses the error is rejected with every method: two errors that cancel are
//! luck. Once a mesh keeps the error, finer ones of the same elements are not tried: they only cost more. Of the others each run may take as long as the cheapest so far. What beats it must be stable at a longer step: an explicit
//! method at the stated margin, any other at twice the step at least, and after a node was yanked away by the size of the body.

mod candidates;
mod outcome;

pub use candidates::{AsLevel, Candidates, Choices, Elements, Mesh, candidates};
pub use outcome::{Trial, TuneStep, Tuning};

use crate::execute::{Context, LoadedScene, Outcome, advance, ready, working_limit};
use crate::plan::PlannedStep;
use crate::row::Status;
use microsim_drawing::{percent, significant, time};
use microsim_scene::{Method, Scene, Selection, StartSpec};
use microsim_settings::{ChartMethod, Expect};
use microsim_tissue::stability;
use std::fmt::Write;

/// Steps at which stability is tried, as multiples of the step of a run, ascending.
const FACTORS: [f64; 6] = [1.25, 1.5, 2.0, 3.0, 4.0, 8.0];
/// Methods without a stability limit must work at this multiple of the step.
const IMPLICIT_FACTOR: f64 = 2.0;
/// CPU time per tetrahedron that an explicit step takes at least: half of the least in `tests/results/bench_kernels.md` \[s\].
const LEAST: f64 = 5e-9;
/// A new run must be cheaper than the best one by this fraction: a smaller difference is noise.
const NOISE: f64 = 0.05;

/// The requirements.
#[derive(Clone, Debug)]
pub struct Goal {
    /// What is compared. Where a value is NaN nothing is known from outside: the exact solution on a fine mesh is the measure.
    pub expect: Vec<Expect>,
    /// Largest relative error.
    pub error: f64,
    /// Factor that must lie between the step and one at which it fails.
    pub margin: f64,
    /// Largest cost.
    pub cost: f64,
    /// Whether the scene ends at rest. Its cost is the CPU time of the whole run \[s\], as how soon it rests is no merit; that of others
    /// is CPU time per simulated time.
    pub ends_at_rest: bool,
}

impl Goal {
    /// The unit of costs in words.
    pub fn cost_unit(&self) -> &'static str {
        match self.ends_at_rest {
            true => "CPU s",
            false => "CPU s per simulated s",
        }
    }

    /// What a run cost; `None` if it simulated nothing.
    fn cost_of(&self, outcome: &Outcome) -> Option<f64> {
        let simulated = outcome.simulated > 0.0;
        simulated.then_some(match self.ends_at_rest {
            true => outcome.cpu,
            false => outcome.cpu / outcome.simulated,
        })
    }
}

/// Tries the candidates; `watch` is called before whatever may take long, after each trial, and with how far it is.
pub fn tune(
    context: &Context<'_>,
    goal: &Goal,
    candidates: &Candidates,
    watch: &mut dyn FnMut(TuneStep<'_>),
) -> Tuning {
    let mut goal = goal.clone();
    let mut tuning = Tuning::default();
    if goal.expect.iter().any(|e| e.value.is_nan()) {
        let (mesh, elements) = &candidates.reference;
        watch(TuneStep::Begins(&format!(
            "the exact solution on a fine mesh, which is the measure: {}, {}",
            elements.title, mesh.title
        )));
        match measured_goal(context, &goal, candidates) {
            Ok(measured) => {
                watch(TuneStep::Begins(&format!(
                    "how far the measure may be off: {}",
                    candidates.second.title
                )));
                tuning.doubt = doubt(context, &measured, candidates);
                tuning.measure = measured.expect.iter().map(|e| e.value).collect();
                goal = measured;
            }
            Err(reason) => {
                tuning.no_measure = Some(reason);
                return tuning;
            }
        }
    }
    // With each mesh and elements, the exact solution and the runs of all methods.
    let runs = candidates.methods.iter().map(|m| parameters(m).len());
    let of_pair = 1 + runs.sum::<usize>();
    let all = (candidates.meshes.len() * candidates.elements.len() * of_pair).max(1);
    let mut keeping: Vec<&String> = Vec::new();
    let mut chosen_mesh = None;
    let pairs = candidates
        .meshes
        .iter()
        .flat_map(|mesh| candidates.elements.iter().map(move |e| (mesh, e)));
    for (index, (mesh, elements)) in pairs.enumerate() {
        let mut over = index * of_pair;
        watch(TuneStep::Over(over as f64 / all as f64));
        // From coarse to fine: more of the same elements only cost more.
        if keeping.contains(&&elements.title) {
            continue;
        }
        let of_mesh = format!("{}, {}", elements.title, mesh.title);
        watch(TuneStep::Begins(&format!(
            "the exact solution of {of_mesh}"
        )));
        let found = exact_values(context, &goal, candidates, &mesh.set, elements);
        let usable = match found {
            Ok((values, count)) => match error_of(&goal, &values) {
                Some(error) if error <= goal.error => Ok(()),
                Some(error) => Err((
                    count,
                    Some(error),
                    format!(
                        "an exact solver would already be off by {}, allowed are {}",
                        percent(error),
                        percent(goal.error)
                    ),
                )),
                None => Err((
                    count,
                    None,
                    "its exact solution does not hold what is expected".into(),
                )),
            },
            Err(reason) => Err((0, None, format!("no exact solution: {reason}"))),
        };
        match usable {
            Err((count, error, reason)) => {
                let trial = Trial {
                    description: of_mesh,
                    kind: elements.title.clone(),
                    overrides: Vec::new(),
                    method: "exact".into(),
                    step: f64::NAN,
                    elements: count,
                    error,
                    cost: None,
                    margin: None,
                    rejected: Some(reason),
                };
                watch(TuneStep::Done(&trial));
                tuning.trials.push(trial);
            }
            Ok(_) => {
                for method in &candidates.methods {
                    for (step, iterations) in parameters(method) {
                        let choices = Choices {
                            mesh,
                            elements,
                            method,
                            step,
                            iterations,
                        };
                        let best = tuning.choice().and_then(|t| t.cost);
                        over += 1;
                        watch(TuneStep::Over(over as f64 / all as f64));
                        let trial = attempt(context, &goal, candidates, &choices, best);
                        watch(TuneStep::Done(&trial));
                        if trial.error.is_some_and(|error| error <= goal.error) {
                            keeping.push(&elements.title);
                        }
                        if trial.rejected.is_none() {
                            if let Some(before) = tuning.chosen {
                                tuning.trials[before].rejected =
                                    Some(format!("{} is cheaper", trial.description));
                            }
                            tuning.chosen = Some(tuning.trials.len());
                            chosen_mesh = Some(mesh);
                        }
                        tuning.trials.push(trial);
                    }
                }
            }
        }
    }
    if let Some(mesh) = chosen_mesh {
        tuning.locking = locking(context, &goal, candidates, &mesh.set);
    }
    tuning
}

/// The error of linear tetrahedra, which lock, on the mesh with these overrides; `None` if there is no continuum or no solution.
pub fn locking(
    context: &Context<'_>,
    goal: &Goal,
    candidates: &Candidates,
    mesh: &[String],
) -> Option<f64> {
    let plain = candidates.plain.as_ref()?;
    let (values, _) = exact_values(context, goal, candidates, mesh, plain).ok()?;
    error_of(goal, &values)
}

/// How far a measure from the fine mesh is from that of one with two thirds of its cells along each edge; `None` if there is no
/// solution.
pub fn doubt(context: &Context<'_>, goal: &Goal, candidates: &Candidates) -> Option<f64> {
    let (mesh, elements) = (&candidates.second.set, &candidates.reference.1);
    let (values, _) = exact_values(context, goal, candidates, mesh, elements).ok()?;
    error_of(goal, &values)
}

/// The scene as its file has it; every value of the goal must be known.
pub fn measure(context: &Context<'_>, goal: &Goal) -> Result<Trial, String> {
    let prepared = ready(load(context, goal, &[])?, None)?;
    let (step, elements) = (prepared.runner.step(), prepared.elements);
    let outcome = advance(context, prepared, f64::INFINITY);
    Ok(Trial {
        description: "the file as it is".into(),
        kind: "the file as it is".into(),
        overrides: Vec::new(),
        method: String::new(),
        step,
        elements,
        error: error_of(goal, &outcome.values),
        cost: goal.cost_of(&outcome),
        margin: None,
        rejected: None,
    })
}

/// The goal with the exact solution on a fine mesh as the reference.
fn measured_goal(
    context: &Context<'_>,
    goal: &Goal,
    candidates: &Candidates,
) -> Result<Goal, String> {
    let (mesh, elements) = &candidates.reference;
    let (values, _) = exact_values(context, goal, candidates, &mesh.set, elements)?;
    let mut goal = goal.clone();
    for (expect, value) in goal.expect.iter_mut().zip(values) {
        expect.value = value.unwrap_or(f64::NAN);
    }
    Ok(goal)
}

/// The steps and iterations of a method.
fn parameters(method: &ChartMethod) -> Vec<(PlannedStep, Option<u32>)> {
    let steps = method.steps.iter().map(|step| PlannedStep::Seconds(*step));
    let fractions = method
        .fractions
        .iter()
        .map(|fraction| PlannedStep::LimitFraction(*fraction));
    let iterations: Vec<Option<u32>> = match &method.iterations[..] {
        [] => vec![None],
        list => list.iter().copied().map(Some).collect(),
    };
    let both = |step| iterations.iter().map(move |i| (step, *i));
    steps.chain(fractions).flat_map(both).collect()
}

/// The largest relative error of what is expected.
pub fn error_of(goal: &Goal, values: &[Option<f64>]) -> Option<f64> {
    let mut largest = None;
    for (expect, value) in goal.expect.iter().zip(values) {
        let scale = expect.scale.unwrap_or(expect.value.abs());
        let error = ((*value)? - expect.value).abs() / scale;
        if !error.is_finite() {
            return None;
        }
        largest = Some(error.max(largest.unwrap_or(0.0)));
    }
    largest
}

type Exact = Result<(Vec<Option<f64>>, usize), String>;

/// Values of the exact solution on a mesh with elements.
fn exact_values(
    context: &Context<'_>,
    goal: &Goal,
    candidates: &Candidates,
    mesh: &[String],
    elements: &Elements,
) -> Exact {
    let mut set = mesh.to_vec();
    set.extend_from_slice(&elements.set);
    set.extend_from_slice(&candidates.exact.0);
    let step = candidates.exact.1;
    let loaded = load(context, goal, &set)?;
    let prepared = ready(loaded, step)?;
    let count = prepared.elements;
    let outcome = advance(context, prepared, f64::INFINITY);
    match outcome.status {
        Status::Ok => Ok((outcome.values, count)),
        Status::Diverged { reason, .. } | Status::NotApplicable { reason } => Err(reason),
        Status::OverBudget { time } => Err(format!("cut off at {time} s")),
    }
}

fn load(context: &Context<'_>, goal: &Goal, set: &[String]) -> Result<LoadedScene, String> {
    let mut loaded = (context.load)("", set)?;
    loaded.settings.expect = goal.expect.clone();
    for expect in &mut loaded.settings.expect {
        // Only what is found is used.
        (expect.value, expect.tolerance) = (1.0, 1.0);
    }
    Ok(loaded)
}

/// One run with all that is demanded of it; `best` is the cost of the cheapest so far.
fn attempt(
    context: &Context<'_>,
    goal: &Goal,
    candidates: &Candidates,
    choices: &Choices<'_>,
    best: Option<f64>,
) -> Trial {
    let overrides = choices.overrides();
    let mut trial = Trial {
        description: String::new(),
        kind: format!("{} with {}", choices.method.title, choices.elements.title),
        overrides,
        method: String::new(),
        step: match choices.step {
            PlannedStep::Seconds(step) => step,
            // Known when the scene is built.
            PlannedStep::LimitFraction(_) | PlannedStep::Sample => f64::NAN,
        },
        elements: 0,
        error: None,
        cost: None,
        margin: None,
        rejected: None,
    };
    trial.rejected = verdict(context, goal, candidates, choices, best, &mut trial).err();
    let mut parameters = match trial.step.is_finite() {
        true => format!("step {}", time(trial.step)),
        false => "no step".into(),
    };
    if let Some(iterations) = choices.iterations {
        let plural = if iterations == 1 { "" } else { "s" };
        let _ = write!(parameters, ", {iterations} iteration{plural}");
    }
    trial.description = format!("{}, {}, {parameters}", trial.kind, choices.mesh.title);
    trial
}

fn verdict(
    context: &Context<'_>,
    goal: &Goal,
    candidates: &Candidates,
    choices: &Choices<'_>,
    best: Option<f64>,
    trial: &mut Trial,
) -> Result<(), String> {
    let loaded = load(context, goal, &trial.overrides)?;
    let scene = Scene::new(&loaded.spec).map_err(|e| e.to_string())?;
    trial.method = scene.method().name().into();
    if candidates.contact && !scene.method().reaches_node_targets() {
        return Err("it cannot lead nodes, which contact needs".into());
    }
    if let (Some(reason), Method::QuasiStatic(_)) = (candidates.motion, scene.method()) {
        return Err(reason.into());
    }
    let limit = working_limit(&scene);
    let limited = limit.is_finite();
    let free = yanked_node(&scene);
    // What a unit of cost is of a whole run, and the least that a run simulates [s].
    let (whole, least_time) = match goal.ends_at_rest {
        true => (1.0, loaded.settings.run.sample),
        false => (loaded.settings.run.duration, 1.0),
    };
    let budget = best.map_or(context.budget, |cost| (cost * whole).min(context.budget));
    let at = |loaded: &LoadedScene, step| -> Result<Outcome, String> {
        let prepared = ready(loaded.clone(), Some(step))?;
        Ok(advance(context, prepared, context.budget))
    };
    let prepared = ready(loaded.clone(), Some(choices.step.of_limit(limit)))?;
    trial.step = prepared.runner.step();
    trial.elements = prepared.elements;
    if trial.step > stability::SAFETY * limit * (1.0 + 1e-9) {
        return Err(format!(
            "a step beyond {} of the stability limit is not safe when the body is deformed",
            stability::SAFETY
        ));
    }
    // Its first sample alone could take minutes.
    let least = LEAST * trial.elements as f64 / trial.step * least_time;
    let most = goal.cost.min(budget / whole);
    if limited && least > most {
        return Err(format!(
            "so many steps need at least {} {}, {} are left",
            significant(least, 2),
            goal.cost_unit(),
            significant(most, 2)
        ));
    }
    let outcome = advance(context, prepared, budget);
    trial.cost = goal.cost_of(&outcome);
    match &outcome.status {
        Status::Ok => {}
        Status::Diverged { time: at, reason } => {
            return Err(format!("it diverged at {}: {reason}", time(*at)));
        }
        Status::OverBudget { .. } if best.is_some() => {
            return Err("it costs more than the best one so far".into());
        }
        Status::OverBudget { .. } => {
            return Err("it needs more CPU time than a run may take".into());
        }
        Status::NotApplicable { reason } => return Err(reason.clone()),
    }
    let error = error_of(goal, &outcome.values).ok_or("its run does not hold what is expected")?;
    trial.error = Some(error);
    if error > goal.error {
        return Err(format!(
            "off by {}, allowed are {}",
            percent(error),
            percent(goal.error)
        ));
    }
    let cost = trial.cost.unwrap_or(f64::INFINITY);
    if cost > goal.cost {
        return Err(format!(
            "{} {}, allowed are {}",
            significant(cost, 2),
            goal.cost_unit(),
            significant(goal.cost, 2)
        ));
    }
    if best.is_some_and(|best| cost > best * (1.0 - NOISE)) {
        return Err(format!(
            "{} {}, not less than the best one so far",
            significant(cost, 2),
            goal.cost_unit()
        ));
    }
    let demanded = if limited {
        goal.margin
    } else {
        goal.margin.max(IMPLICIT_FACTOR)
    };
    let mut factors: Vec<f64> = FACTORS.iter().copied().filter(|f| *f != demanded).collect();
    factors.push(demanded);
    factors.sort_by(f64::total_cmp);
    let mut margin = 1.0;
    for factor in factors {
        let longer = PlannedStep::Seconds(factor * trial.step);
        let stable = at(&loaded, longer).is_ok_and(|o| o.status == Status::Ok);
        if !stable {
            break;
        }
        margin = factor;
    }
    trial.margin = Some(margin);
    if margin < demanded {
        return Err(format!(
            "it fails at {} times its step, demanded are {}",
            significant(margin, 3)
                .trim_end_matches('0')
                .trim_end_matches('.'),
            significant(demanded, 2)
        ));
    }
    if limited {
        return Ok(());
    }
    let mut yanked = loaded.clone();
    for (body, (place, shift)) in yanked.spec.bodies.iter_mut().zip(free) {
        body.start.push(StartSpec {
            nodes: Selection::Nearest(place),
            matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            pivot: [0.0; 3],
            shift,
            velocity: [0.0; 3],
        });
    }
    match at(&yanked, PlannedStep::Seconds(trial.step))?.status {
        Status::Diverged { reason, .. } => {
            Err(format!("it diverges when a node is yanked away: {reason}"))
        }
        _ => Ok(()),
    }
}

/// For each body the free node that is farthest from all clamps, in the body's frame, and a displacement of the body's size upwards.
fn yanked_node(scene: &Scene) -> Vec<([f64; 3], [f64; 3])> {
    let of_body = |body: usize| {
        let rest = scene.body(body).rest_positions();
        let clamped = scene.body(body).clamped();
        let held: Vec<_> = rest
            .iter()
            .zip(&clamped)
            .filter(|(_, c)| **c)
            .map(|(p, _)| p)
            .collect();
        let from = held.first().copied().unwrap_or(&rest[0]);
        let free = rest
            .iter()
            .zip(&clamped)
            .filter(|(_, c)| !**c)
            .map(|(p, _)| p);
        let far = free.max_by(|a, b| (*a - from).norm().total_cmp(&(*b - from).norm()));
        let far = far.unwrap_or(&rest[0]);
        let size = rest.iter().map(|p| (p - from).norm()).fold(0.0, f64::max);
        ((far - scene.body(body).origin()).into(), [0.0, 0.0, size])
    };
    (0..scene.body_count()).map(of_body).collect()
}

#[cfg(test)]
mod tests;
