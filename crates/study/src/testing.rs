//! A small plan with results by hand, for tests of what is made of them, and a small scene to run.

use crate::execute::{Context, LoadedScene};
use crate::plan::{Group, PlannedRun, RunKey, groups};
use crate::results::Results;
use crate::row::{GroupResult, Measured, Row, Status};
use microsim_scene::scene_spec;
use microsim_settings::{Chart, Override, read_chart, read_scene};
use std::cell::Cell;

/// Two scenes, one of them at three of Poisson's ratios.
pub const PLAN: &str = r#"
[budget]
run = "20 s"
quick_run = "2 s"
quick_total = "100 s"
[exact]
rest = ["method.name=quasi-static"]
motion = ["method.name=stoermer-verlet"]
[tune]
scales = [1.0]
reference_scale = 2.0
level_scales = [[1, 1, 1]]
level_reference_scale = 2.0
discretisations = ["tetrahedra"]
methods = ["verlet"]
[[material]]
name = "linear"
title = "linear tetrahedra"
set = ["body.0.material.0.discretisation=linear"]
[[material]]
name = "patches"
title = "F-bar <patches>"
set = ["body.0.material.0.discretisation=patches"]
[[method]]
name = "verlet"
title = "Störmer–Verlet"
set = ["method.name=stoermer-verlet"]
fractions = [0.5, 1.5]
[[method]]
name = "implicit"
title = "implicit Euler"
set = ["method.name=implicit-euler"]
steps = ["1 ms", "10 ms"]
iterations = [1, 4]
[[scene]]
name = "beam"
title = "Beam at rest"
file = "scenes/beam.toml"
exact = "rest"
measure = [{ title = "sag", probe = "sag", what = "at-end" }]
resolution = [{ name = "S", set = ["body.0.cells=[4,1,1]"] }, { name = "M", set = ["body.0.cells=[8,2,2]"] }]
variant = [
  { name = "ν = 0.3", poisson_ratio = 0.3, reference = [0.0345], source = "another code, \"refined\"" },
  { name = "ν = 0.49", poisson_ratio = 0.49, reference = [0.0337], set = ["body.0.material.0.poisson_ratio=0.49"] },
]
[[scene.sweep]]
quick = true
resolutions = ["S"]
materials = ["linear"]
methods = ["implicit"]
steps = ["10 ms"]
iterations = [1]
[[scene.sweep]]
resolutions = ["S", "M"]
materials = ["linear", "patches"]
methods = ["verlet", "implicit"]
[[scene]]
name = "swing"
title = "Swing"
file = "scenes/swing.toml"
exact = "motion"
measure = [{ title = "first peak", probe = "sag", what = "first-peak" }, { title = "its time", probe = "sag", what = "first-peak-time" }]
resolution = [{ name = "S" }]
variant = [{ name = "as it is" }]
[[scene.sweep]]
quick = true
resolutions = ["S"]
materials = ["linear"]
methods = ["verlet"]
"#;

pub fn chart() -> Chart {
    read_chart(PLAN, "chart.toml").expect("a plan").settings
}

/// Results by a formula: the run at place k of its group costs 2^k/8 and errs by 8 % / 2^k; what runs beyond the stability
/// limit diverges, the finest implicit one is over budget.
pub fn results() -> Results {
    let chart = chart();
    let groups = groups(&chart, false, &[])
        .iter()
        .map(|g| result(&chart, g))
        .collect();
    Results { chart, groups }
}

fn result(chart: &Chart, group: &Group) -> GroupResult {
    let scene = &chart.scene[group.key.scene];
    let references = &scene.variant[group.key.variant].reference;
    let measured = |error: f64| -> Vec<Measured> {
        let one = |k: usize| Measured {
            value: Some((1.0 + error) * references.get(k).copied().unwrap_or(2.0)),
            reference: references.get(k).copied(),
            exact: Some(references.get(k).copied().unwrap_or(2.0)),
        };
        (0..scene.measure.len()).map(one).collect()
    };
    let locks = group.key.material == 0 && group.key.variant == 1;
    GroupResult {
        key: group.key,
        elements: 24 << (3 * group.key.resolution),
        exact: measured(if locks { -0.6 } else { -0.01 }),
        exact_failure: None,
        rows: group
            .runs
            .iter()
            .enumerate()
            .map(|(k, run)| row(chart, group, k, run, &measured))
            .collect(),
    }
}

fn row(
    chart: &Chart,
    group: &Group,
    k: usize,
    run: &PlannedRun,
    measured: &dyn Fn(f64) -> Vec<Measured>,
) -> Row {
    use crate::plan::PlannedStep;
    let power = (1u32 << k) as f64;
    let status = match run.step {
        PlannedStep::LimitFraction(fraction) if fraction > 1.0 => Status::Diverged {
            time: 0.02,
            reason: "gains energy, \"much\"".into(),
        },
        PlannedStep::Seconds(step) if step < 2e-3 && group.key.resolution == 1 => {
            Status::OverBudget { time: 0.3 }
        }
        _ => Status::Ok,
    };
    let failed = status != Status::Ok;
    Row {
        key: RunKey {
            group: group.key,
            method: run.method,
        },
        step: match run.step {
            PlannedStep::Seconds(step) => step,
            PlannedStep::LimitFraction(fraction) => fraction * 1e-4,
            PlannedStep::Sample => unreachable!("no method of the plan has such a step"),
        },
        iteration_limit: run.iterations,
        elements: chart.scene[group.key.scene].resolution.len(),
        status,
        measures: measured(if failed { f64::NAN } else { 0.08 / power }),
        energy_drift: (!failed && group.key.scene == 1).then_some(-0.001),
        simulated: 1.0,
        cpu: 0.125 * power,
        iterations: run.iterations.map(f64::from),
    }
}

/// A beam of 24 tetrahedra that swings, 0.2 s long.
const BEAM: &str = r#"
title = { de = "Balken", en = "Beam" }
summary = { de = "Er schwingt.", en = "It swings." }
run = { duration = "0.2 s", step = "1 ms", sample = "2 ms" }
method = { name = "stoermer-verlet" }
[[body]]
name = "beam"
generator = "block"
size = ["40 mm", "10 mm", "10 mm"]
cells = [4, 1, 1]
[[body.material]]
law = "stable-neo-hookean"
youngs_modulus = "20 kPa"
poisson_ratio = 0.3
density = "1000 kg/m^3"
[[body.clamp]]
nodes = { min = ["-20 mm", "-5 mm", "-5 mm"], max = ["-20 mm", "5 mm", "5 mm"] }
[[probe]]
name = "sag"
body = "beam"
nodes = { min = ["20 mm", "-5 mm", "-5 mm"], max = ["20 mm", "5 mm", "5 mm"] }
quantity = "displacement"
direction = [0, 0, -1]
"#;

/// One group of four runs on the beam: one that ends, one beyond the stability limit, an implicit one, one that cannot be made.
const BEAM_PLAN: &str = r#"
[budget]
run = "20 s"
quick_run = "2 s"
quick_total = "100 s"
[exact]
rest = ['method={name="quasi-static"}']
motion = ['method={name="stoermer-verlet"}']
[tune]
scales = [0.1, 1, 2]
reference_scale = 3
level_scales = [[1, 1, 1]]
level_reference_scale = 2
discretisations = ["selective", "tetrahedra"]
methods = ["verlet", "midpoint", "xpbd"]
[[material]]
name = "as-it-is"
title = "as it is"
[[method]]
name = "verlet"
title = "Verlet"
set = ['method={name="stoermer-verlet"}']
fractions = [0.5, 1.5]
[[method]]
name = "midpoint"
title = "midpoint"
set = ['method={name="implicit-midpoint"}']
steps = ["2 ms"]
[[method]]
name = "xpbd"
title = "XPBD"
set = ['method={name="xpbd"}']
steps = ["2 ms"]
[[scene]]
name = "beam"
title = "Beam"
file = "beam.toml"
exact = "motion"
measure = [{ title = "first peak", probe = "sag", what = "first-peak", fall_time = "20 ms" }]
resolution = [{ name = "S" }]
variant = [{ name = "as it is" }]
[[scene.sweep]]
resolutions = ["S"]
materials = ["as-it-is"]
methods = ["verlet", "midpoint", "xpbd"]
"#;

/// The plan of the beam.
pub fn beam_plan() -> Chart {
    read_chart(BEAM_PLAN, "chart.toml")
        .expect("a plan")
        .settings
}

/// The beam with overrides.
pub fn beam(set: &[String]) -> Result<LoadedScene, String> {
    let set: Vec<Override> = set
        .iter()
        .map(|s| Override::parse(s))
        .collect::<Result<_, _>>()?;
    let settings = read_scene(BEAM, "beam.toml", &set)
        .map_err(|e| e.to_string())?
        .settings;
    let no_file = |_: &std::path::Path| Err(std::io::ErrorKind::NotFound.into());
    let spec = scene_spec(&settings, &mut { no_file })
        .map_err(|e| e.to_string())?
        .spec;
    Ok(LoadedScene { settings, spec })
}

/// Calls `run` with the plan of the beam on a clock on which each reading takes a millisecond: runs are as long as they have
/// samples.
pub fn in_context<R>(
    budget: f64,
    remaining: &dyn Fn() -> f64,
    run: impl FnOnce(&Context<'_>) -> R,
) -> R {
    let chart = beam_plan();
    let ticks = Cell::new(0.0);
    run(&Context {
        chart: &chart,
        load: &|_, set| beam(set),
        clock: &|| {
            ticks.set(ticks.get() + 1e-3);
            ticks.get()
        },
        budget,
        remaining,
        exec: &microsim_scene::Serial,
        progress: &|_| {},
    })
}
