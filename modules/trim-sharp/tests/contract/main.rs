//! The verdicts of the module, in-process and without physics: snapshots, elements, forces and cuts in, the result out. The host moves the
//! module to a fresh instance in every tick.

mod stage;

use microsim_sdk::message::TrainingResult;
use serde_json::json;
use stage::{
    BARE, STAY_TICKS, Scene, TICK, config, cut, host, limit, opened_area, started, tick, ticks,
    value,
};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

fn measured(result: &TrainingResult, metric: &str, expected: f64, tolerance: f64) {
    let found = value(result, metric).expect(metric);
    assert!(
        (found - expected).abs() <= tolerance,
        "{metric}: {found}, not {expected}"
    );
}

const GRIPPED: Scene = Scene {
    top: 0.5e-3,
    adventitia_cut: false,
    grip: 0.02,
    ..BARE
};

/// Gripped, cut, let go: the end is bare by what the adventitia was drawn back, and the level is done once nothing has touched it for the time of the level.
#[test]
fn an_end_that_stays_bare_is_trimmed() {
    let mut host = started(1e-4, json!([]));
    assert!(ticks(&mut host, &GRIPPED, 3).is_none());
    cut(&mut host, "right");
    // Still in the forceps.
    let held = Scene { grip: 0.02, ..BARE };
    assert!(ticks(&mut host, &held, 2 * STAY_TICKS).is_none());
    assert!(
        ticks(&mut host, &BARE, STAY_TICKS - 1).is_none(),
        "a tick too early"
    );
    let result = tick(&mut host, &BARE)
        .last::<TrainingResult>()
        .expect("the verdict");
    assert!(result.passed, "{:?}", result.failed);
    measured(&result, "free-length", 0.2e-3, 1e-9);
    measured(&result, "overhang", 0.0, 0.0);
    measured(&result, "cuts", 1.0, 0.0);
    measured(&result, "held", 1.0, 0.0);
    measured(&result, "scissors-tilt", 0.0, 1e-12);
    measured(&result, "media-cut", 0.0, 0.0);
    // A quarter of a grip of 20 mN.
    measured(&result, "media-grip", 0.005, 1e-12);
    measured(&result, "peak-grip", 0.02, 1e-12);
}

/// What is left to do when the input ends is named; of who has touched nothing only that targets were missed.
#[test]
fn what_was_not_done_is_named() {
    for (free_length, scene, reason) in [
        (
            1e-4,
            Scene {
                top: 0.2e-3,
                ..BARE
            },
            "overhang-left",
        ),
        (
            1e-4,
            Scene {
                top: -0.05e-3,
                ..BARE
            },
            "drawn-too-little",
        ),
        (
            -1e-4,
            Scene {
                top: 0.05e-3,
                grip: 0.02,
                ..BARE
            },
            "not-left",
        ),
        (
            -1e-4,
            Scene {
                top: 0.15e-3,
                ..BARE
            },
            "overhang-left",
        ),
    ] {
        let mut host = started(free_length, json!([]));
        ticks(&mut host, &GRIPPED, 2);
        assert!(ticks(&mut host, &scene, 2 * STAY_TICKS).is_none());
        assert_eq!(host.end().failed, [reason]);
    }
    let mut idle = started(1e-4, json!([]));
    ticks(&mut idle, &Scene::default(), 3);
    let result = idle.end();
    assert_eq!(result.failed, ["targets-missed"]);
    measured(&result, "overhang", 0.5e-3, 1e-9);
}

/// Two bites: one with the handle raised by 45 degrees, one along the wall; the second without a grip since half a second.
#[test]
fn the_worst_bite_and_what_was_cut_without_a_grip_count() {
    let limits = json!([
        limit("cuts", 1.0, "too-many-cuts"),
        limit("scissors-tilt", 0.5, "towards-the-vessel")
    ]);
    let mut host = started(1e-4, limits);
    ticks(&mut host, &GRIPPED, 3);
    cut(&mut host, "right");
    let raised = Scene {
        handle: [0.0, -FRAC_1_SQRT_2, FRAC_1_SQRT_2],
        adventitia_cut: true,
        ..GRIPPED
    };
    tick(&mut host, &raised);
    let open = Scene {
        top: 0.5e-3,
        opening: 0.5,
        ..BARE
    };
    ticks(&mut host, &open, 60);
    cut(&mut host, "right");
    let result = ticks(&mut host, &BARE, 2 * STAY_TICKS).expect("the verdict");
    let failed: std::collections::BTreeSet<&str> =
        result.failed.iter().map(String::as_str).collect();
    assert_eq!(failed, ["too-many-cuts", "towards-the-vessel"].into());
    measured(&result, "cuts", 2.0, 0.0);
    measured(&result, "scissors-tilt", FRAC_PI_4, 1e-9);
    // The second one opened nothing in the adventitia.
    measured(&result, "held", 1.0, 0.0);

    let mut host = started(1e-4, json!([]));
    ticks(&mut host, &GRIPPED, 2);
    ticks(&mut host, &Scene::default(), 60);
    cut(&mut host, "right");
    let result = ticks(&mut host, &BARE, 2 * STAY_TICKS).expect("the verdict");
    measured(&result, "held", 0.0, 0.0);
}

/// 4 mm/s over half a second in the grip, be it that the vessel slides through it, and 40 mm/s without one.
#[test]
fn the_speed_counts_while_the_vessel_is_gripped() {
    for slides in [false, true] {
        let mut host = started(1e-4, json!([limit("draw-speed", 3e-3, "too-fast")]));
        // Held at first, as without that the vessel is not worked on.
        tick(&mut host, &GRIPPED);
        let drawn = Scene { slides, ..GRIPPED };
        for (speed, scene) in [(4e-3, drawn), (40e-3, Scene::default())] {
            for k in 0..60_u32 {
                let forceps = -speed * TICK * f64::from(k);
                tick(&mut host, &Scene { forceps, ..scene });
            }
        }
        let result = ticks(&mut host, &BARE, 2 * STAY_TICKS).expect("the verdict");
        assert_eq!(result.failed, ["too-fast"]);
        measured(&result, "draw-speed", 4e-3, 1e-12);
    }
}

/// A triangle of the media is opened by scissors, and half of it was stretched beyond 1.3.
#[test]
fn the_media_is_not_to_be_cut() {
    let limits = json!([
        limit("media-cut", 1e-12, "media-cut"),
        limit("media-injury", 0.4, "media-injured")
    ]);
    let mut host = started(1e-4, limits);
    ticks(
        &mut host,
        &Scene {
            stretch: 1.4,
            ..GRIPPED
        },
        2,
    );
    cut(&mut host, "right");
    let result = ticks(
        &mut host,
        &Scene {
            media_cut: true,
            ..BARE
        },
        2 * STAY_TICKS,
    )
    .expect("the verdict");
    let failed: std::collections::BTreeSet<&str> =
        result.failed.iter().map(String::as_str).collect();
    assert_eq!(failed, ["media-cut", "media-injured"].into());
    measured(&result, "media-cut", opened_area(0), 1e-18);
    measured(&result, "media-injury", 0.5, 1e-12);
}

#[test]
fn levels_without_a_vessel_in_a_clamp_are_refused() {
    for (object, missing) in [(0, "clamp"), (1, "mark-")] {
        let mut config = config(1e-4, json!([]));
        config["objects"][object]["name"] = json!("other");
        let text = host(config).err().expect("it lacks something").to_string();
        assert!(text.contains(missing), "{text}");
    }
}
