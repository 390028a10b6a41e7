//! The verdicts of the module, in-process and without physics: snapshots, elements and forces in, the result out. The host moves the module to a
//! fresh instance in every tick.

mod stage;

use microsim_sdk::TestHost;
use microsim_sdk::message::{LevelEvent, ObjectSet, TrainingResult};
use serde_json::{Value, json};
use stage::{
    BARE, EVEN, LENGTH, STAY, Scene, Touch, chord, config, end, host, limit, started, tick, ticks,
    value,
};

type Host = TestHost<microsim_module_trim_blunt::Module>;

/// A push along the vessel, without a grip.
const PUSH: Touch = Touch {
    force: 3e-3,
    grip: [0.0; 2],
};

/// Somebody is there and touches nothing.
const WAITING: Touch = Touch {
    force: 0.0,
    grip: [0.0; 2],
};

fn pushed(bare: f64, uneven: f64, tool: Touch) -> Scene {
    Scene {
        bare,
        uneven,
        tool: Some(tool),
        ..Scene::default()
    }
}

fn no_limits() -> Value {
    json!([])
}

#[track_caller]
fn measured(result: &TrainingResult, metric: &str, expected: f64, tolerance: f64) {
    let found = value(result, metric).expect(metric);
    assert!(
        (found - expected).abs() <= tolerance,
        "{metric}: {found}, not {expected}"
    );
}

fn events(host: &mut Host, scene: &Scene) -> Vec<String> {
    let events: Vec<LevelEvent> = tick(host, scene).all();
    events.into_iter().map(|event| event.id).collect()
}

/// The adventitia ends in a plane across the vessel, turned about y: bare by b (1 + e cos θ). The mean around is b, as sixteen cosines cancel; the least, downwards, is b (1 - e).
/// Both are read off straight edges between corners, which lie within a chord of that. Forces are those of the stage: of a grip of 4 mN a quarter acts on the media.
#[test]
fn an_end_that_stays_bare_is_judged() {
    let mut host = started(json!([
        limit("peak-force", 4e-3, "pushed-too-hard"),
        limit("media-grip", 2e-3, "media-gripped"),
        limit("media-injury", 0.3, "media-injured"),
    ]));
    let gripping = Touch {
        grip: [1e-3, 3e-3],
        ..PUSH
    };
    let stretched = Scene {
        stretch: 1.4,
        ..pushed(0.4e-3, 0.1, gripping)
    };
    assert!(ticks(&mut host, &stretched, 5).is_none());
    let (bare, uneven) = (0.8e-3, 0.1);
    assert_eq!(events(&mut host, &pushed(bare, uneven, PUSH)), ["bare"]);
    // As long as something presses on it, it is not left alone.
    assert!(ticks(&mut host, &pushed(bare, uneven, PUSH), 2 * STAY).is_none());
    let left = pushed(bare, uneven, WAITING);
    assert!(ticks(&mut host, &left, STAY - 1).is_none(), "too early");
    let result = tick(&mut host, &left)
        .last::<TrainingResult>()
        .expect("the verdict");
    assert!(result.passed, "{:?}", result.failed);
    let tolerance = bare * uneven * chord();
    measured(&result, "free-length", bare, tolerance);
    measured(&result, "evenness", 1.0 - uneven, 2.0 * tolerance / bare);
    measured(&result, "peak-force", 3e-3, 0.0);
    measured(&result, "media-grip", 1e-3, 1e-15);
    measured(&result, "media-injury", 0.25, 1e-12);
}

/// The mark is a ring as far from the end as the level asks for.
#[test]
fn the_mark_lies_around_the_vessel() {
    let mut host = started(no_limits());
    let marks: Vec<ObjectSet> = tick(&mut host, &Scene::default()).all();
    let mark = marks.iter().find(|of| of.name == "mark-1").expect("a mark");
    let place = mark.pose.expect("it is placed").position;
    let expected = [LENGTH - BARE, 0.0, 0.0];
    for k in 0..3 {
        assert!((place[k] - expected[k]).abs() < 1e-12, "{place:?}");
    }
    assert_eq!(mark.active, Some(true));
}

/// What is missing when the input ends, each for its reason.
#[test]
fn what_was_not_done_is_named() {
    for (scene, reason) in [
        (pushed(0.9 * BARE, 0.0, WAITING), "not-bare"),
        (pushed(1.2 * BARE, 1.2 * (1.0 - EVEN), WAITING), "uneven"),
        (pushed(1.2 * BARE, 0.0, PUSH), "not-left"),
        // It hangs over the end.
        (pushed(-0.3e-3, 0.0, PUSH), "not-bare"),
    ] {
        let mut host = started(no_limits());
        assert!(ticks(&mut host, &scene, 2 * STAY).is_none(), "{reason}");
        let result = end(&mut host, &scene);
        assert_eq!(result.failed, [reason]);
        assert_eq!((result.targets_done, result.score), (0, 0.0));
    }
    let mut idle = started(no_limits());
    ticks(&mut idle, &Scene::default(), 3);
    assert_eq!(idle.end().failed, ["targets-missed"]);
}

/// It was bare and came forward again before it had been left alone for long enough: what was interrupted begins again.
#[test]
fn an_end_that_is_covered_again_was_not_left() {
    let mut host = started(no_limits());
    let bare = pushed(1.2 * BARE, 0.0, WAITING);
    let covered = pushed(0.5 * BARE, 0.0, WAITING);
    for _ in 0..3 {
        assert!(ticks(&mut host, &bare, STAY - 1).is_none());
        assert!(ticks(&mut host, &covered, 2).is_none());
    }
    let result = end(&mut host, &covered);
    assert_eq!(result.failed, ["not-left"]);
    measured(&result, "free-length", 0.5 * BARE, 1e-12);
}

/// The jaws are around the vessel in the first tick, and pinch the media: what they do counts from there on.
#[test]
fn a_wall_that_is_gripped_at_once_is_named() {
    let mut host = started(json!([
        limit("peak-force", 4e-3, "pushed-too-hard"),
        limit("media-grip", 2e-3, "media-gripped"),
    ]));
    let pinching = Touch {
        force: 50e-3,
        grip: [30e-3, 10e-3],
    };
    assert!(ticks(&mut host, &pushed(0.0, 0.0, pinching), 1).is_none());
    let result = ticks(&mut host, &pushed(1.2 * BARE, 0.0, WAITING), 2 * STAY);
    let result = result.expect("the verdict: the end is bare");
    let failed: std::collections::BTreeSet<&str> =
        result.failed.iter().map(String::as_str).collect();
    assert_eq!(failed, ["media-gripped", "pushed-too-hard"].into());
    measured(&result, "peak-force", 50e-3, 0.0);
    measured(&result, "media-grip", 30e-3, 1e-15);
}

/// Torn off the clamp and carried away along itself the vessel is what it was: bare or not. Carried off aside it does not lie around its axis any more, so that nothing can
/// be measured of it: the level goes on, and its target is missed.
#[test]
fn a_vessel_that_is_carried_off_ends_with_a_reason() {
    let mut host = started(no_limits());
    tick(&mut host, &pushed(0.0, 0.0, PUSH));
    let along = Scene {
        moved: [1.0, 0.0],
        ..pushed(1.2 * BARE, 0.0, WAITING)
    };
    let result = ticks(&mut host, &along, 2 * STAY).expect("it stays bare");
    measured(&result, "free-length", 1.2 * BARE, 1e-12);

    for aside in [2e-3, 1.0] {
        let mut host = started(no_limits());
        tick(&mut host, &pushed(0.0, 0.0, PUSH));
        let lost = Scene {
            moved: [0.0, aside],
            ..pushed(1.2 * BARE, 0.0, WAITING)
        };
        assert!(ticks(&mut host, &lost, 2 * STAY).is_none(), "{aside} m");
        let result = end(&mut host, &lost);
        assert_eq!(result.failed, ["targets-missed"], "{aside} m");
        assert_eq!(result.score, 0.0);
    }
}

/// No metric takes forces that mean nothing; more than one such tick, and more than 2 % of those with contact, and nothing is judged.
#[test]
fn forces_that_mean_nothing_are_not_measured() {
    let wild = Touch {
        force: 9.0,
        grip: [5.0, 5.0],
    };
    let invalid = Scene {
        valid: false,
        stretch: 9.0,
        ..pushed(0.1e-3, 0.0, wild)
    };
    let bare = pushed(1.2 * BARE, 0.0, WAITING);
    let mut host = started(no_limits());
    ticks(&mut host, &pushed(0.0, 0.0, PUSH), 5);
    tick(&mut host, &invalid);
    let result = ticks(&mut host, &bare, 2 * STAY).expect("the verdict");
    assert!(result.passed, "{:?}", result.failed);
    measured(&result, "peak-force", 3e-3, 0.0);
    measured(&result, "media-grip", 0.0, 0.0);
    measured(&result, "media-injury", 0.0, 0.0);

    let mut host = started(no_limits());
    ticks(&mut host, &pushed(0.0, 0.0, PUSH), 5);
    assert!(ticks(&mut host, &invalid, 5).is_none());
    let result = ticks(&mut host, &bare, 2 * STAY).expect("an end");
    assert!(!result.passed && result.failed.is_empty(), "{result:?}");
    assert!(!result.not_judged.is_empty(), "{result:?}");
}

#[test]
fn levels_that_lack_something_are_refused() {
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut config = config(no_limits());
        change(&mut config);
        host(config).err().expect("it lacks something").to_string()
    };
    let text = refused(&|config| config["bodies"] = json!([]));
    assert!(text.contains("[[body]]"), "{text}");
    let text = refused(&|config| config["objects"][0]["name"] = json!("clamps"));
    assert!(text.contains("\"clamp\""), "{text}");
    let text = refused(&|config| config["objects"][1]["name"] = json!("ring"));
    assert!(text.contains("\"mark"), "{text}");
}
