use super::*;
use crate::execute::stability_limit;
use crate::testing::{beam, beam_plan, in_context};
use microsim_settings::{ExactKind, Feature};

fn goal(error: f64, value: f64) -> Goal {
    Goal {
        expect: vec![Expect {
            regression: false,
            probe: "sag".into(),
            what: Feature::FirstPeak,
            value,
            tolerance: 1.0,
            scale: None,
            fall_time: 0.02,
            source: String::new(),
        }],
        error,
        margin: 1.5,
        cost: f64::INFINITY,
        ends_at_rest: false,
    }
}

fn run(goal: &Goal) -> Tuning {
    let scene = beam(&[]).expect("a scene").settings;
    in_context(1e3, &|| f64::INFINITY, |context| {
        let candidates = candidates(context.chart, &scene, ExactKind::Motion, None, None);
        tune(context, goal, &candidates, &mut |_| {})
    })
}

#[test]
fn the_choice_keeps_the_error_and_the_margin_and_the_others_have_reasons() {
    let tuning = run(&goal(0.2, f64::NAN));
    assert_eq!(tuning.measure.len(), 1, "the fine mesh was the measure");
    let choice = tuning.choice().expect("something keeps 20 %");
    assert!(choice.error.is_some_and(|e| e <= 0.2) && choice.margin.is_some_and(|m| m >= 1.5));
    assert!(choice.rejected.is_none() && choice.cost.is_some());
    let without = tuning.trials.iter().filter(|t| t.rejected.is_none());
    assert_eq!(without.count(), 1, "every other trial has a reason");
    // On the clock of the test a run costs what it has samples: no other run that met all requirements has fewer.
    let rejected = tuning.sentences().join("\n");
    assert!(
        rejected.contains("0.6 of the stability limit"),
        "{rejected}"
    );
    assert!(rejected.contains("no sum of constraints"), "{rejected}");
}

/// What rests sooner would else look dearer: the same work over less time.
#[test]
fn a_scene_that_ends_at_rest_costs_what_its_run_costs() {
    let outcome = |simulated| Outcome {
        status: Status::Ok,
        values: Vec::new(),
        restless: None,
        energy_drift: None,
        simulated,
        cpu: 3.0,
        iterations: None,
    };
    let mut goal = goal(0.1, 1.0);
    assert_eq!(goal.cost_of(&outcome(2.0)), Some(1.5));
    assert_eq!(goal.cost_of(&outcome(0.0)), None);
    goal.ends_at_rest = true;
    assert_eq!(goal.cost_of(&outcome(2.0)), Some(3.0));
    assert_eq!(goal.cost_of(&outcome(0.5)), Some(3.0));
}

/// Whatever takes long is announced before it begins, the measure first.
#[test]
fn what_takes_long_is_announced() {
    let scene = beam(&[]).expect("a scene").settings;
    let mut announced = Vec::new();
    in_context(1e3, &|| f64::INFINITY, |context| {
        let candidates = candidates(context.chart, &scene, ExactKind::Motion, None, None);
        tune(context, &goal(0.2, f64::NAN), &candidates, &mut |step| {
            if let TuneStep::Begins(what) = step {
                announced.push(what.to_owned());
            }
        });
    });
    assert!(announced[0].contains("on a fine mesh"), "{announced:?}");
    assert!(announced[1].contains("how far the measure may be off"));
    assert!(
        announced[2..]
            .iter()
            .any(|what| what.starts_with("the exact solution of"))
    );
}

#[test]
fn what_no_mesh_can_keep_is_refused_for_every_method_at_once() {
    // The beam is 40 mm long: half a metre is out of its reach.
    let tuning = run(&goal(0.01, 0.5));
    assert!(tuning.choice().is_none() && tuning.measure.is_empty());
    assert!(tuning.trials.iter().all(|t| t.method == "exact"));
    assert!(tuning.sentences()[0].contains("an exact solver would already be off"));
}

#[test]
fn meshes_are_scaled_and_named_once() {
    let chart = beam_plan();
    let scene = beam(&[]).expect("a scene").settings;
    let found = candidates(&chart, &scene, ExactKind::Motion, None, None);
    // Scales 0.1, 1 and 2 of 4 × 1 × 1 cells; 0.1 leaves one cell.
    let sets: Vec<&str> = found.meshes.iter().map(|m| m.set[0].as_str()).collect();
    assert_eq!(
        sets,
        [
            "body.0.cells=[1,1,1]",
            "body.0.cells=[4,1,1]",
            "body.0.cells=[8,2,2]"
        ]
    );
    assert_eq!(
        found.elements[0].set,
        ["body.0.material.0.discretisation=selective"]
    );
}

/// On tissue that hardly stiffens steps are planned by the limit at rest; on a wall of collagen by that at the working stretch, with what a fraction
/// of it gives accepted and a step that only does at rest refused.
#[test]
fn steps_are_of_the_limit_at_work() {
    let wall = [
        "law='holzapfel-gasser-ogden'",
        "fibre_stiffness=20000",
        "fibre_exponent=0.84",
        "fibre_dispersion=0",
        "fibres={direction=[1,0,0],second_direction=[1,0,0]}",
    ];
    let wall = wall.map(|set| format!("body.0.material.0.{set}"));
    let scene = |set: &[String]| Scene::new(&beam(set).expect("a scene").spec).expect("a scene");
    let soft = scene(&[]);
    assert_eq!(working_limit(&soft), stability_limit(&soft));
    let stiffens = scene(&wall);
    let (at_rest, at_work) = (stability_limit(&stiffens), working_limit(&stiffens));
    assert!(at_work < 0.6 * at_rest, "{at_work} {at_rest}");

    let run = |step: PlannedStep| {
        in_context(1e3, &|| f64::INFINITY, |context| {
            let settings = beam(&[]).expect("a scene").settings;
            let mut candidates =
                candidates(context.chart, &settings, ExactKind::Motion, None, None);
            let mut method = candidates.methods[0].clone();
            method.set.extend(wall.iter().cloned());
            candidates.methods = vec![method];
            let choices = Choices {
                mesh: &candidates.meshes[0],
                elements: &candidates.elements[0],
                method: &candidates.methods[0],
                step,
                iterations: None,
            };
            let scene = load(context, &goal(1.0, 0.01), &choices.overrides());
            let scene = Scene::new(&scene.expect("a scene").spec).expect("a scene");
            let trial = attempt(context, &goal(1.0, 0.01), &candidates, &choices, None);
            (trial, stability_limit(&scene), working_limit(&scene))
        })
    };
    // Samples are made of whole steps, and the run of whole samples, some ten or more of each.
    let (trial, at_rest, at_work) = run(PlannedStep::LimitFraction(0.5));
    let planned = 0.5 * at_work;
    assert!(trial.step <= planned * (1.0 + 1e-9) && trial.step > 0.9 * planned);
    let (trial, _, _) = run(PlannedStep::Seconds(0.5 * at_rest));
    let reason = trial.rejected.expect("too long at work");
    assert!(reason.contains("0.6 of the stability limit"), "{reason}");
}
