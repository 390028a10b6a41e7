use super::*;
use crate::plan::groups;
use crate::row::Against;
use crate::testing::{beam, in_context};
use microsim_scene::scene_spec;
use microsim_settings::Override;
use std::path::Path;

fn run_all(budget: f64, remaining: &dyn Fn() -> f64) -> (GroupResult, Vec<String>) {
    in_context(budget, remaining, |context| {
        let mut steps = Vec::new();
        let group = &groups(context.chart, false, &[])[0];
        let result = run_group(context, group, &mut |step| {
            steps.push(match step {
                Step::Exact => "exact".into(),
                Step::Run(row) => row.status.name().into(),
                Step::LeftOut(_) => "left out".into(),
            });
        });
        (result, steps)
    })
}

#[test]
fn every_run_of_the_plan_ends_in_the_table() {
    let (result, steps) = run_all(1e3, &|| f64::INFINITY);
    assert_eq!(steps, ["exact", "ok", "diverged", "ok", "not applicable"]);
    assert_eq!(result.elements, 24);
    let exact = result.exact[0].value.expect("a peak");
    let [verlet, diverged, midpoint, xpbd] = result.rows.as_slice() else {
        panic!("four runs");
    };
    // Verlet at half the limit against a quarter: errors of (hω)²/24 of the modes that matter, whose frequency is far below
    // the limit's. The midpoint rule at 2 ms errs by (hω)²/12 with ω of about 40 per second: 5e-4.
    let error = |row: &Row| row.error(Against::SameMesh).expect("an error");
    assert!(error(verlet) < 1e-3, "{}", error(verlet));
    assert!(error(midpoint) < 5e-3, "{}", error(midpoint));
    assert_eq!(verlet.measures[0].exact, Some(exact));
    // What diverges stays, with its time.
    let Status::Diverged { time, .. } = diverged.status else {
        panic!("{:?}", diverged.status);
    };
    assert!(time > 0.0 && time <= 0.2 && diverged.error(Against::SameMesh).is_none());
    assert!(
        matches!(&xpbd.status, Status::NotApplicable { reason } if reason.contains("constraints"))
    );
    // Nothing takes energy from the undamped beam: drift is that of the methods.
    for row in [verlet, midpoint] {
        let drift = row.energy_drift.expect("it should conserve");
        assert!(drift.abs() < 0.02, "{drift}");
    }
    assert!(midpoint.iterations.is_some_and(|i| i > 1.0) && verlet.iterations == Some(1.0));
}

#[test]
fn runs_over_budget_are_cut_off_and_kept() {
    // 5 ms on a clock of 1 ms per sample: five of 100 samples.
    let (result, _) = run_all(5e-3, &|| f64::INFINITY);
    let row = &result.rows[0];
    let Status::OverBudget { time } = row.status else {
        panic!("{:?}", row.status);
    };
    assert!(time > 0.0 && time < 0.05, "{time}");
    assert!(row.cost().is_some(), "what it costs is known nevertheless");
}

#[test]
fn without_time_runs_are_left_out_and_said_to_be() {
    let (result, steps) = run_all(1e3, &|| 0.0);
    assert_eq!(steps, ["left out"; 4]);
    assert!(result.rows.is_empty() && result.exact.is_empty());
}

#[test]
fn steps_of_a_share_are_those_of_the_plan() {
    let (result, _) = run_all(1e3, &|| f64::INFINITY);
    // 0.5 and 1.5 of one limit, each shortened to a whole number in the scene's duration: by less than one sample in 100.
    let ratio = result.rows[1].step / result.rows[0].step;
    assert!((ratio - 3.0).abs() < 0.05, "{ratio}");
}

/// Explicit Euler amplifies every undamped vibration at any step: its limit is 2ζ/ω = 0 (NUMERICS 3), and no fraction of it is a step.
#[test]
fn a_method_that_is_unstable_at_every_step_is_not_applicable() {
    let loaded = beam(&["method={name=\"explicit-euler\"}".into()]).expect("a scene");
    let refused = ready(loaded, Some(PlannedStep::LimitFraction(0.5))).err();
    let reason = refused.expect("no step");
    assert!(reason.contains("unstable at every step"), "{reason}");
}

/// The shipped tube of node-smoothed elements at ν = 0.45: it drifts away for want of stiffness, and was 27,986 % off with
/// the status "ok". Its body is named, whatever the method;
/// the same mesh of tetrahedra is as it was.
#[test]
fn a_body_without_stiffness_in_some_mode_is_named() {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
    let chart = settings::load_chart(&config.join("chart.toml"));
    let chart = chart.expect("the shipped plan").settings;
    let load = |file: &str, set: &[String]| {
        let set: Result<Vec<_>, _> = set.iter().map(|text| Override::parse(text)).collect();
        let scene = settings::load_scene(&config.join(file), &set?);
        let settings = scene.map_err(|e| e.to_string())?.settings;
        let spec = scene_spec(&settings, &mut |_| unreachable!("the tube has no file"));
        let spec = spec.map_err(|e| e.to_string())?.spec;
        Ok(LoadedScene { settings, spec })
    };
    let result = |material: &str| {
        let all = groups(&chart, true, &["tube-pressure".into()]);
        let wanted = |group: &&Group| {
            let scene = &chart.scene[group.key.scene];
            chart.material[group.key.material].name == material
                && scene.variant[group.key.variant].poisson_ratio == Some(0.45)
        };
        let context = Context {
            chart: &chart,
            load: &load,
            clock: &|| 0.0,
            budget: 1.0,
            remaining: &|| f64::INFINITY,
            exec: &microsim_scene::Serial,
            progress: &|_| {},
        };
        run_group(
            &context,
            all.iter().find(wanted).expect("in the plan"),
            &mut |_| {},
        )
    };
    let soft = result("node-smoothed");
    let failure = soft.exact_failure.expect("no solution");
    assert!(
        failure.contains("body \"tube\" is not at rest after 1 s"),
        "{failure}"
    );
    assert!(soft.exact.is_empty() && !soft.rows.is_empty() && soft.elements == 1152);
    for row in &soft.rows {
        let named = matches!(&row.status, Status::NotApplicable { reason } if *reason == failure);
        assert!(named && row.error(Against::Reference).is_none(), "{row:?}");
    }
    let stiff = result("tetrahedra");
    assert!(stiff.exact_failure.is_none() && stiff.rows.iter().all(|r| r.status == Status::Ok));
}

/// A cube that nothing holds moves and turns along three axes each without any stiffness; one that is clamped at an end has some in every
/// mode.
#[test]
fn modes_without_stiffness_are_counted() {
    let described = |clamp: &str| {
        let text = format!(
            "{clamp}\n[title]\nen = \"Cube\"\n[summary]\nen = \"A cube.\"\n[run]\nduration = \"10 ms\"\nstep = \"1 ms\"\n[method]\nname = \"implicit-euler\"\n"
        );
        let scene = microsim_settings::read_scene(&text, "cube.toml", &[]).expect("a scene");
        let spec = scene_spec(&scene.settings, &mut |_| unreachable!()).expect("a body");
        let scene = Scene::new(&spec.spec).expect("a scene");
        cause(scene.body(0))
    };
    let body = "[[body]]\nname = \"cube\"\ngenerator = \"block\"\nsize = [\"2 mm\", \"2 mm\", \"2 mm\"]\ncells = [2, 2, 2]\n[[body.material]]\nlaw = \"neo-hookean\"\nyoungs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\ndensity = \"1000 kg/m^3\"\n";
    assert_eq!(
        described(body),
        "as it lies, 6 of its 81 modes have no stiffness"
    );
    let clamp = "[[body.clamp]]\nnodes = { min = [\"-2 mm\", \"-2 mm\", \"-2 mm\"], max = [\"-0.9 mm\", \"2 mm\", \"2 mm\"] }\n";
    let clamped = described(&format!("{body}{clamp}"));
    assert!(
        clamped.starts_with("all of its modes have stiffness"),
        "{clamped}"
    );
}
