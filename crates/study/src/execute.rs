//! The runs of a group: the exact solution on the mesh, then every planned run, each within its budget.
//!
//! The measures of the chart take the place of the scene's expectations, so that the scene's own features are used. CPU time
//! is taken around the steps alone, from the first to the last; the samples between them belong to it, they cost less than a
//! step.

use crate::eigen::eigenvalues;
use crate::plan::{Group, PlannedRun, PlannedStep, RunKey, group_overrides, run_overrides};
use crate::row::{GroupResult, Measured, Row, Status};
use microsim_drawing::{significant, time};
use microsim_scene::{BodyView, End, Executor, Runner, Scene, SceneSpec};
use microsim_settings::{self as settings, Chart, ChartScene, ExactKind};
use microsim_tissue::stability;

/// Runs shorter than this are repeated, and the fastest counts \[s\].
const SHORT: f64 = 0.05;
/// How often a short run is made.
const REPETITIONS: usize = 3;
/// An exact solution may take this many times the budget of a run.
const EXACT_BUDGET: f64 = 20.0;
/// The modes of bodies of up to so many nodes are looked at, which takes seconds.
const MODES_NODES: usize = 500;
/// Eigenvalues of a stiffness below this fraction of the largest are rounding.
const MODES_ROUNDING: f64 = 1e-9;
/// Name of the probe for the energy of a body; no name in a file is like it.
const ENERGY_PROBE: &str = "the energy of body";

/// A scene with its settings, overrides applied.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The settings as the file has them.
    pub settings: settings::Scene,
    /// What the scene is made of.
    pub spec: SceneSpec,
}

/// Loads a scene: its file from the folder of the plan, and overrides `KEY=VALUE`. The error is a sentence.
pub type LoadScene<'a> = dyn Fn(&str, &[String]) -> Result<LoadedScene, String> + 'a;

/// All that runs need.
pub struct Context<'a> {
    /// The plan.
    pub chart: &'a Chart,
    /// Loads scenes.
    pub load: &'a LoadScene<'a>,
    /// CPU time of this thread \[s\].
    pub clock: &'a dyn Fn() -> f64,
    /// CPU time allowed for a run \[s\].
    pub budget: f64,
    /// Time that is left for everything \[s\]; infinite without a limit.
    pub remaining: &'a dyn Fn() -> f64,
    /// Runs parallel loops.
    pub exec: &'a dyn Executor,
    /// Called after each sample of a run with the part of its duration that is over.
    pub progress: &'a dyn Fn(f64),
}

/// A step of a group that is done.
#[derive(Clone, Debug, PartialEq)]
pub enum Step<'a> {
    /// The exact solution.
    Exact,
    /// A run.
    Run(&'a Row),
    /// A run for which there was no time.
    LeftOut(&'a PlannedRun),
}

/// Makes the runs of a group; `after` is called after each step, for progress.
pub fn run_group(
    context: &Context<'_>,
    group: &Group,
    after: &mut dyn FnMut(Step<'_>),
) -> GroupResult {
    let mut result = GroupResult {
        key: group.key,
        elements: 0,
        exact: Vec::new(),
        exact_failure: None,
        rows: Vec::new(),
    };
    let scene = &context.chart.scene[group.key.scene];
    let variant = &scene.variant[group.key.variant];
    let mut soft = None;
    if (context.remaining)() > 0.0 {
        match exact(context, group) {
            Ok((elements, values)) => {
                result.elements = elements;
                result.exact = values
                    .iter()
                    .enumerate()
                    .map(|(k, value)| Measured {
                        value: *value,
                        reference: variant.reference.get(k).copied(),
                        exact: *value,
                    })
                    .collect();
            }
            Err(NoExact { reason, of_body }) => {
                if let Some(elements) = of_body {
                    result.elements = elements;
                    soft = Some(reason.clone());
                }
                result.exact_failure = Some(reason);
            }
        }
        after(Step::Exact);
    }
    let exact: Vec<Option<f64>> = result.exact.iter().map(|m| m.value).collect();
    for planned in &group.runs {
        if (context.remaining)() <= 0.0 {
            after(Step::LeftOut(planned));
            continue;
        }
        let row = match &soft {
            Some(reason) => Row {
                elements: result.elements,
                status: Status::NotApplicable {
                    reason: reason.clone(),
                },
                ..empty_row(group, planned)
            },
            None => run(context, group, planned, &exact),
        };
        result.elements = result.elements.max(row.elements);
        after(Step::Run(&row));
        result.rows.push(row);
    }
    result
}

/// Why a mesh has no exact solution.
struct NoExact {
    reason: String,
    /// The number of elements, where it is the body itself, so that no method has a solution.
    of_body: Option<usize>,
}

/// The exact solution on the mesh of a group: number of elements and a value per measure.
fn exact(context: &Context<'_>, group: &Group) -> Result<(usize, Vec<Option<f64>>), NoExact> {
    let scene = &context.chart.scene[group.key.scene];
    let mut overrides = group_overrides(context.chart, &group.key);
    let (set, step) = exact_way(context.chart, scene.exact, Some(scene));
    overrides.extend_from_slice(set);
    let prepared = prepare(context, scene, &overrides, step).map_err(|reason| NoExact {
        reason,
        of_body: None,
    })?;
    let elements = prepared.elements;
    let outcome = advance(context, prepared, EXACT_BUDGET * context.budget);
    match outcome.status {
        Status::Ok => match outcome.restless {
            None => Ok((elements, outcome.values)),
            // Where each step is solved for the rest state, only a mode without stiffness goes on moving.
            Some(reason) => Err(NoExact {
                of_body: (scene.exact == ExactKind::Rest).then_some(elements),
                reason,
            }),
        },
        status => Err(NoExact {
            reason: format!("{}, the exact solution on the mesh", reason(&status)),
            of_body: None,
        }),
    }
}

/// Overrides and step of an exact solution; a scene of the plan may have its own.
pub(crate) fn exact_way<'a>(
    chart: &'a Chart,
    kind: ExactKind,
    scene: Option<&'a ChartScene>,
) -> (&'a [String], Option<PlannedStep>) {
    let fraction = PlannedStep::LimitFraction(chart.exact.fraction);
    let (set, step) = match kind {
        ExactKind::Rest => (&chart.exact.rest, Some(PlannedStep::Sample)),
        ExactKind::Motion => (&chart.exact.motion, Some(fraction)),
    };
    let Some(scene) = scene else {
        return (set, step);
    };
    let own = if scene.exact_set.is_empty() {
        set
    } else {
        &scene.exact_set
    };
    (own, scene.exact_step.map(PlannedStep::Seconds).or(step))
}

/// A status in words.
fn reason(status: &Status) -> String {
    match status {
        Status::Ok => "ok".into(),
        Status::Diverged { reason, .. } | Status::NotApplicable { reason } => reason.clone(),
        Status::OverBudget { time } => format!("cut off at {time} s"),
    }
}

/// The row of a run that was not made.
fn empty_row(group: &Group, planned: &PlannedRun) -> Row {
    Row {
        key: RunKey {
            group: group.key,
            method: planned.method,
        },
        step: f64::NAN,
        iteration_limit: planned.iterations,
        elements: 0,
        status: Status::Ok,
        measures: Vec::new(),
        energy_drift: None,
        simulated: 0.0,
        cpu: 0.0,
        iterations: None,
    }
}

/// One planned run; `exact` are the values of the exact solution, if there is one.
fn run(context: &Context<'_>, group: &Group, planned: &PlannedRun, exact: &[Option<f64>]) -> Row {
    let scene = &context.chart.scene[group.key.scene];
    let variant = &scene.variant[group.key.variant];
    let mut row = empty_row(group, planned);
    let overrides = run_overrides(context.chart, &group.key, planned);
    let measured = |values: &[Option<f64>]| -> Vec<Measured> {
        let one = |k: usize| Measured {
            value: values.get(k).copied().flatten(),
            reference: variant.reference.get(k).copied(),
            exact: exact.get(k).copied().flatten(),
        };
        (0..scene.measure.len()).map(one).collect()
    };
    match prepare(context, scene, &overrides, Some(planned.step)) {
        Err(reason) => {
            row.measures = measured(&[]);
            row.status = Status::NotApplicable { reason };
        }
        Ok(prepared) => {
            row.step = prepared.runner.step();
            row.elements = prepared.elements;
            let outcome = advance(context, prepared, context.budget);
            row.measures = measured(&outcome.values);
            row.status = match outcome.restless {
                Some(reason) if outcome.status == Status::Ok => Status::NotApplicable { reason },
                _ => outcome.status,
            };
            row.energy_drift = outcome.energy_drift;
            row.simulated = outcome.simulated;
            row.cpu = outcome.cpu;
            row.iterations = outcome.iterations;
        }
    }
    row
}

/// A scene that is ready to run.
pub(crate) struct Prepared {
    pub runner: Runner,
    pub elements: usize,
    /// Whether its energy should stay.
    conserves: bool,
    /// Whether it is to end at rest.
    rests: bool,
}

fn prepare(
    context: &Context<'_>,
    scene: &ChartScene,
    overrides: &[String],
    step: Option<PlannedStep>,
) -> Result<Prepared, String> {
    let mut loaded = (context.load)(&scene.file, overrides)?;
    loaded.settings.expect = scene
        .measure
        .iter()
        .map(|measure| settings::Expect {
            regression: false,
            probe: measure.probe.clone(),
            what: measure.what,
            // Only what is found is used.
            value: 1.0,
            tolerance: 1.0,
            scale: None,
            fall_time: measure.fall_time,
            source: String::new(),
        })
        .collect();
    ready(loaded, step)
}

/// Builds a scene with a step.
pub(crate) fn ready(
    mut loaded: LoadedScene,
    step: Option<PlannedStep>,
) -> Result<Prepared, String> {
    let conserves = conserves(&loaded.settings);
    if conserves {
        add_energy_probes(&mut loaded.settings);
    }
    loaded.spec.containment = false;
    loaded.spec.repeat_unconverged = false;
    let scene = Scene::new(&loaded.spec).map_err(|e| e.to_string())?;
    let elements = (0..scene.body_count())
        .map(|b| scene.body(b).element_count())
        .sum();
    let run = &mut loaded.settings.run;
    match step {
        None => {}
        Some(PlannedStep::Seconds(step)) => run.step = step,
        Some(PlannedStep::Sample) => run.step = run.sample,
        Some(PlannedStep::LimitFraction(fraction)) => {
            let limit = stability_limit(&scene);
            if !limit.is_finite() {
                return Err("no step is planned for a method without a stability limit".into());
            }
            if limit == 0.0 {
                return Err("the method is unstable at every step without damping".into());
            }
            run.step = fraction * limit;
        }
    }
    // Samples are made of whole steps, so that steps are those of the plan; a step longer than a sample makes samples longer.
    run.sample = run.step * (run.sample / run.step).round().max(1.0);
    if run.step > run.duration {
        return Err("the step is longer than the scene".into());
    }
    let runner = Runner::new(&loaded.settings, scene).map_err(|e| e.to_string())?;
    Ok(Prepared {
        runner,
        elements,
        conserves,
        rests: loaded.settings.run.end == settings::End::Rest,
    })
}

/// The estimated stability limit of a scene \[s\], without a safety factor; infinite for a method without one.
pub(crate) fn stability_limit(scene: &Scene) -> f64 {
    let steps = (0..scene.body_count()).map(|body| scene.body(body).stable_step());
    steps.fold(f64::INFINITY, f64::min) / stability::SAFETY
}

/// The same where tissue stiffens at the stretch at work: the limit at that stretch, up to which no run needs shorter steps.
pub(crate) fn working_limit(scene: &Scene) -> f64 {
    let steps = scene.bodies().map(|body| body.planned_step());
    steps.fold(f64::INFINITY, f64::min) / stability::SAFETY
}

/// Whether nothing brings or takes energy: no drag, no viscosity, no flow, nothing that moves or presses.
fn conserves(scene: &settings::Scene) -> bool {
    scene.run.end == settings::End::Time
        && scene.body.iter().all(|body| {
            let still =
                |clamp: &settings::Clamp| clamp.motion.is_empty() && clamp.release.is_none();
            let lossless = |material: &settings::Material| {
                material.viscosity.unwrap_or(0.0) == 0.0
                    && material.relaxation_time.unwrap_or(0.0) == 0.0
                    && material.plasticity.is_none()
            };
            body.drag == 0.0
                && body.load.is_empty()
                && body.clamp.iter().all(still)
                && body.material.iter().all(lossless)
        })
}

fn add_energy_probes(scene: &mut settings::Scene) {
    for body in &scene.body {
        scene.probe.push(settings::Probe {
            name: ENERGY_PROBE.into(),
            body: body.name.clone(),
            nodes: settings::Nodes::default(),
            with: None,
            quantity: settings::Quantity::Energy,
            direction: None,
            point: None,
            axis: None,
        });
    }
}

/// What came out of a run.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    pub status: Status,
    /// One per expectation.
    pub values: Vec<Option<f64>>,
    pub energy_drift: Option<f64>,
    /// Which body still moves where all should be at rest, in words.
    pub restless: Option<String>,
    pub simulated: f64,
    pub cpu: f64,
    pub iterations: Option<f64>,
}

/// Runs to the end or to the end of the budget \[s\].
pub(crate) fn advance(context: &Context<'_>, prepared: Prepared, budget: f64) -> Outcome {
    let budget = budget.min((context.remaining)());
    let mut best: Option<Outcome> = None;
    for _ in 0..REPETITIONS {
        let outcome = advance_once(context, &prepared, budget);
        let repeat = outcome.cpu < SHORT && outcome.status == Status::Ok;
        if best.as_ref().is_none_or(|best| outcome.cpu < best.cpu) {
            best = Some(outcome);
        }
        if !repeat {
            break;
        }
    }
    best.unwrap_or_else(|| unreachable!("there is at least one repetition"))
}

fn advance_once(context: &Context<'_>, prepared: &Prepared, budget: f64) -> Outcome {
    let mut runner = prepared.runner.clone();
    let (mut cpu, mut cut) = (0.0, false);
    loop {
        let start = (context.clock)();
        let sampled = runner.compute(context.exec);
        cpu += (context.clock)() - start;
        (context.progress)(runner.progress());
        // What is measured of a scene is not what it costs.
        if !sampled || !runner.observe() {
            break;
        }
        if cpu > budget {
            cut = true;
            break;
        }
    }
    let time = runner.scene().time();
    let steps = runner.steps() * runner.scene().group_count() as u64;
    let status = match runner.end() {
        _ if cut => Status::OverBudget { time },
        Some(End::Diverged(diverged)) => Status::Diverged {
            time: diverged.time,
            reason: diverged.what.to_string(),
        },
        _ => match runner.energy_growth() {
            Some(growth) => Status::Diverged {
                time: growth.since,
                reason: "gains energy though nothing does work on it".into(),
            },
            None => Status::Ok,
        },
    };
    let values = match status {
        Status::Ok => runner.verdicts().iter().map(|v| v.found).collect(),
        _ => Vec::new(),
    };
    let energy_drift = (prepared.conserves && status == Status::Ok)
        .then(|| energy_drift(&runner))
        .flatten();
    Outcome {
        // What diverged in the first sample has no time behind it but cost what it cost.
        simulated: match &status {
            Status::Diverged { time, .. } => time.max(runner.step()),
            _ => time,
        },
        restless: restless(&runner, prepared.rests),
        iterations: (steps > 0).then(|| runner.scene().iterations() as f64 / steps as f64),
        status,
        values,
        energy_drift,
        cpu,
    }
}

/// The body that moves fastest at the end of a scene that should have come to rest, and did not.
fn restless(runner: &Runner, rests: bool) -> Option<String> {
    if !rests || !matches!(runner.end(), Some(End::Duration)) {
        return None;
    }
    let scene = runner.scene();
    let speed = |body: usize| {
        let nodes = scene.body(body).velocities().iter();
        nodes.map(|v| v.norm()).fold(0.0, f64::max)
    };
    let fastest = (0..scene.body_count()).max_by(|a, b| speed(*a).total_cmp(&speed(*b)))?;
    Some(format!(
        "body \"{}\" is not at rest after {}, its fastest node has {} mm/s: {}",
        scene.body(fastest).name(),
        time(scene.time()),
        significant(1e3 * speed(fastest), 2),
        cause(scene.body(fastest))
    ))
}

/// Why a body does not come to rest, by the modes of its stiffness as it lies now.
fn cause(body: BodyView<'_>) -> String {
    let model = body.model();
    if model.node_count() > MODES_NODES {
        return "it has no stiffness in some mode, or too little damping".into();
    }
    let values = eigenvalues(model, body.state());
    let largest = values.last().copied().unwrap_or_default();
    let soft = values
        .iter()
        .filter(|value| **value <= MODES_ROUNDING * largest)
        .count();
    match soft {
        0 => {
            "all of its modes have stiffness: it has too little damping, or too little time".into()
        }
        soft => format!(
            "as it lies, {soft} of its {} modes have no stiffness",
            values.len()
        ),
    }
}

/// (mean total energy of the last fifth − that of the first fifth) / largest kinetic energy. Means, as the energy measured at
/// half steps oscillates.
fn energy_drift(runner: &Runner) -> Option<f64> {
    let series = runner.series();
    let bodies = runner.scene().body_count();
    let probes = &series.probes[series.probes.len().checked_sub(bodies)?..];
    let samples = series.time.len();
    let fifth = samples / 5;
    let total = |sample: usize| -> f64 { probes.iter().map(|probe| probe[sample]).sum() };
    let mean = |from: usize| (from..from + fifth).map(total).sum::<f64>() / fifth as f64;
    let largest = series.kinetic.iter().copied().fold(0.0, f64::max);
    (fifth > 0 && largest > 0.0).then(|| (mean(samples - fifth) - mean(0)) / largest)
}

#[cfg(test)]
mod tests;
