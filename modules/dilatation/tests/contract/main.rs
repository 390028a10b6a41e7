//! The verdicts of the module, in-process and without physics: snapshots, elements, forces and tears in, the result out. The host moves the
//! module to a fresh instance in every tick.

mod stage;

use microsim_sdk::TestHost;
use microsim_sdk::message::{LevelEvent, TrainingResult};
use serde_json::{Value, json};
use stage::{
    AROUND, Apart, Dilator, INSERTION, RADIUS, STAY, Scene, WIDE, config, end, host, limit,
    started, tear, tick, ticks, value,
};
use std::f64::consts::PI;

type Host = TestHost<microsim_module_dilatation::Module>;

/// Forces of a grip of the adventitia alone \[N\].
const HELD: [f64; 2] = [0.0, 0.01];

/// The opening 20 % wider than at rest in all directions, nothing at it.
const SPREAD: Scene = Scene {
    dilator: None,
    grip: [0.0; 2],
    wider: [1.2; 2],
    stretch: 1.0,
    apart: Apart::Whole,
    away: 0.0,
    valid: true,
};

/// Closed, in the lumen, deep enough.
const INSIDE: Dilator = Dilator {
    depth: 1.0e-3,
    aside: 0.0,
    opening: 0.0,
    force: 0.0,
    spread: 0.0,
    direction: 0.0,
};

fn with(dilator: Dilator) -> Scene {
    Scene {
        dilator: Some(dilator),
        ..Scene::default()
    }
}

/// Enters closed while the adventitia is held, spreads across and along, and withdraws.
fn spread(host: &mut Host) {
    let held = |dilator: Dilator| Scene {
        grip: HELD,
        ..with(dilator)
    };
    let caught = Dilator {
        force: 0.5e-3,
        ..INSIDE
    };
    assert!(ticks(host, &held(caught), 5).is_none());
    for direction in [0.0, 0.5 * PI] {
        let open = Dilator {
            opening: 0.5,
            force: 2e-3,
            spread: 20e-3,
            direction,
            ..INSIDE
        };
        let stretched = Scene {
            stretch: 1.8,
            ..held(open)
        };
        assert!(ticks(host, &stretched, 5).is_none());
    }
    assert!(ticks(host, &held(INSIDE), 5).is_none());
}

#[track_caller]
fn measured(result: &TrainingResult, metric: &str, expected: f64, tolerance: f64) {
    let found = value(result, metric).expect(metric);
    assert!(
        (found - expected).abs() <= tolerance,
        "{metric}: {found}, not {expected}"
    );
}

/// Diameter of the circle with the area of an opening whose half axes are so many times those at rest: a polygon of n corners on an ellipse has n/2 sin(2π/n) a b.
fn diameter([a, b]: [f64; 2]) -> f64 {
    let n = AROUND as f64;
    let area = 0.5 * n * libm::sin(2.0 * PI / n) * a * b * RADIUS * RADIUS;
    2.0 * (area / PI).sqrt()
}

fn no_limits() -> Value {
    json!([])
}

fn events(host: &mut Host, scene: &Scene) -> Vec<String> {
    let events: Vec<LevelEvent> = tick(host, scene).all();
    events.into_iter().map(|event| event.id).collect()
}

/// A regular polygon of n corners has 4πA/L² = π/(n tan(π/n)). A quarter of the media by volume was beyond 1.7; forces and times are those of the stage. What both jaws do to the wall is
/// 20 mN, and what they do to the vessel as a whole 2 mN: the peak is of the latter, as the module states.
#[test]
fn what_stays_while_nothing_touches_the_vessel_is_judged() {
    let mut host = started(json!([
        limit("diameter", [Some(WIDE), None], "not-wide-enough"),
        limit("spread-angle", [Some(1.0), None], "one-direction"),
        limit("held", [Some(0.9), None], "not-held"),
        limit("media-grip", [None, Some(1e-4)], "media-gripped"),
        limit("push", [None, Some(2e-3)], "wall-caught"),
    ]));
    spread(&mut host);
    assert!(
        ticks(&mut host, &SPREAD, STAY - 1).is_none(),
        "a tick too early"
    );
    let result = tick(&mut host, &SPREAD)
        .last::<TrainingResult>()
        .expect("the verdict");
    assert!(result.passed, "{:?}", result.failed);
    measured(&result, "diameter", diameter([1.2, 1.2]), 1e-12);
    let n = AROUND as f64;
    measured(&result, "roundness", PI / (n * libm::tan(PI / n)), 1e-9);
    measured(&result, "spread-angle", 0.5 * PI, 1e-12);
    measured(&result, "overstretch", 0.25, 1e-12);
    measured(&result, "torn", 0.0, 0.0);
    measured(&result, "push", 0.5e-3, 0.0);
    measured(&result, "peak-force", 2e-3, 0.0);
    measured(&result, "peak-grip", 0.01, 0.0);
    measured(&result, "media-grip", 0.0, 0.0);
    measured(&result, "held", 1.0, 1e-12);
}

/// Of an opening 1.5 times as wide and 0.8 times as high as before, by its area alone 9.5 % wider. Its circumference by the chords between corners.
#[test]
fn a_flat_opening_is_as_wide_as_the_circle_of_its_area() {
    let mut host = started(no_limits());
    spread(&mut host);
    let flat = Scene {
        wider: [1.5, 0.8],
        ..SPREAD
    };
    let result = ticks(&mut host, &flat, 2 * STAY).expect("the verdict");
    let found = diameter([1.5, 0.8]);
    measured(&result, "diameter", found, 1e-12);
    let corner = |k: usize| {
        let angle = 2.0 * PI * k as f64 / AROUND as f64;
        [
            1.5 * RADIUS * libm::sin(angle),
            0.8 * RADIUS * libm::cos(angle),
        ]
    };
    let chords = (0..AROUND).map(|k| {
        let (a, b) = (corner(k), corner(k + 1));
        libm::hypot(a[0] - b[0], a[1] - b[1])
    });
    let circumference: f64 = chords.sum();
    let roundness = (PI * found / circumference) * (PI * found / circumference);
    measured(&result, "roundness", roundness, 1e-9);
}

/// Neither a dilator in the opening nor a grip leaves it as it stays; what was interrupted begins again.
#[test]
fn nothing_is_judged_while_something_touches_the_vessel() {
    let mut host = started(no_limits());
    spread(&mut host);
    let holding = Scene {
        grip: HELD,
        ..SPREAD
    };
    let inside = Scene {
        dilator: Some(INSIDE),
        ..SPREAD
    };
    let closed = Scene {
        wider: [1.0; 2],
        ..SPREAD
    };
    for scene in [holding, inside, closed] {
        assert!(ticks(&mut host, &scene, 2 * STAY).is_none(), "{scene:?}");
        assert!(ticks(&mut host, &SPREAD, STAY - 1).is_none(), "{scene:?}");
    }
    let mut again = started(no_limits());
    spread(&mut again);
    ticks(&mut again, &holding, STAY);
    assert_eq!(end(&mut again, &holding).failed, ["not-withdrawn"]);
    let mut left_in = started(no_limits());
    spread(&mut left_in);
    assert_eq!(end(&mut left_in, &inside).failed, ["not-withdrawn"]);
    let mut too_small = started(no_limits());
    spread(&mut too_small);
    ticks(&mut too_small, &closed, 2 * STAY);
    let result = end(&mut too_small, &closed);
    assert_eq!(result.failed, ["not-wide-enough"]);
    measured(&result, "diameter", diameter([1.0, 1.0]), 1e-12);
    assert_eq!(
        result.targets_done, 1,
        "it was entered, and that is all of it"
    );
}

/// A millimetre deep and beside the axis by more than the opening's radius is outside; so is before its plane, and what is not deep enough has not entered yet. A dilator that
/// is opened there spreads nothing, whatever it presses on, and is not closed either.
#[test]
fn a_dilator_that_is_opened_outside_has_not_entered() {
    for (depth, aside) in [
        (1e-3, 1.2 * RADIUS),
        (-1e-3, 0.0),
        (0.5 * INSERTION, 1.2 * RADIUS),
    ] {
        let mut host = started(no_limits());
        let outside = Dilator {
            depth,
            aside,
            opening: 1.0,
            force: 4e-3,
            spread: 20e-3,
            direction: 0.0,
        };
        assert!(events(&mut host, &with(outside)).is_empty());
        assert!(ticks(&mut host, &with(outside), 5).is_none());
        let result = ticks(&mut host, &SPREAD, 2 * STAY);
        assert!(result.is_none(), "nobody was in it");
        let result = host.end();
        assert_eq!((result.targets_done, result.score), (0, 0.0));
        assert_eq!(result.failed, ["not-entered"]);
        assert_eq!(value(&result, "spread-angle"), None);
        assert_eq!(value(&result, "diameter"), None);
        measured(&result, "peak-force", 4e-3, 0.0);
        measured(&result, "push", 0.0, 0.0);
    }
}

/// Nobody was seen; somebody was, and never found the lumen.
#[test]
fn a_lumen_that_was_never_found_is_named() {
    let mut idle = started(no_limits());
    ticks(&mut idle, &Scene::default(), 5);
    assert_eq!(idle.end().failed, ["targets-missed"]);
    let mut searching = started(no_limits());
    let before = Dilator {
        depth: -2e-3,
        ..INSIDE
    };
    ticks(&mut searching, &with(before), 5);
    assert_eq!(searching.end().failed, ["not-entered"]);
    let mut shallow = started(no_limits());
    let shallow_by = Dilator {
        depth: 0.9 * INSERTION,
        ..INSIDE
    };
    ticks(&mut shallow, &with(shallow_by), 5);
    assert_eq!(shallow.end().failed, ["not-entered"]);
}

/// In the lumen and open in the first tick, as where a tracker begins with the tool on the bench: the level counts it as entered and goes on.
#[test]
fn a_dilator_that_begins_in_the_lumen_has_entered() {
    let mut host = started(json!([limit("held", [Some(0.9), None], "not-held")]));
    let inside = Dilator {
        opening: 1.0,
        spread: 20e-3,
        ..INSIDE
    };
    assert_eq!(events(&mut host, &with(inside)), ["target-done"]);
    assert!(ticks(&mut host, &with(inside), 5).is_none());
    let result = ticks(&mut host, &SPREAD, 2 * STAY).expect("the verdict");
    assert_eq!(result.failed, ["not-held"]);
    measured(&result, "held", 0.0, 0.0);
    measured(&result, "spread-angle", 0.0, 0.0);
}

/// The wall is gripped at once, before anything else: all of it on the media. The vessel is held then, but not by its adventitia.
#[test]
fn a_wall_that_is_gripped_at_once_is_not_held_by_its_adventitia() {
    let mut host = started(json!([
        limit("media-grip", [None, Some(1e-4)], "media-gripped"),
        limit("held", [Some(0.9), None], "not-held"),
    ]));
    let gripped = Scene {
        grip: [0.012, 0.0],
        ..with(INSIDE)
    };
    assert!(ticks(&mut host, &gripped, 5).is_none());
    let result = ticks(&mut host, &SPREAD, 2 * STAY).expect("the verdict");
    let failed: std::collections::BTreeSet<&str> =
        result.failed.iter().map(String::as_str).collect();
    assert_eq!(failed, ["media-gripped", "not-held"].into());
    measured(&result, "media-grip", 0.012, 1e-15);
    measured(&result, "held", 0.0, 0.0);
}

/// A torn wall has no ring for a rim: neither diameter nor roundness. The opening is wide, but the tear fails the level.
#[test]
fn a_torn_wall_is_named_and_has_no_diameter() {
    let mut host = started(json!([limit("torn", [None, Some(0.0)], "torn")]));
    spread(&mut host);
    let slit = Scene {
        apart: Apart::Slit,
        ..Scene::default()
    };
    tear(&mut host, 1e-6);
    assert_eq!(events(&mut host, &slit), ["tear"]);
    assert!(ticks(&mut host, &slit, 2 * STAY).is_none());
    let result = host.end();
    assert_eq!(result.failed, ["torn"]);
    assert!(value(&result, "torn").expect("it was measured") > 0.0);
    assert_eq!(value(&result, "diameter"), None);
}

/// The vessel is torn through, and what came off lies 1 mm, or 1 m, away: only what is still held counts, and a torn rim has no diameter.
#[test]
fn a_vessel_that_is_torn_off_ends_with_that_reason() {
    for away in [1e-3, 1.0] {
        let mut host = started(no_limits());
        spread(&mut host);
        let off = Scene {
            apart: Apart::InTwo,
            away,
            ..Scene::default()
        };
        tear(&mut host, 1e-6);
        assert!(ticks(&mut host, &off, 2 * STAY).is_none(), "{away} m");
        let result = host.end();
        assert_eq!(result.failed, ["torn"], "{away} m");
        assert_eq!(value(&result, "diameter"), None);
        assert!(result.score.is_finite());
    }
}

/// The whole vessel leaves the field with the tool.
#[test]
fn a_vessel_that_is_lost_leaves_the_level_running() {
    let mut host = started(no_limits());
    let lost = Scene {
        away: 1.0,
        ..with(INSIDE)
    };
    assert!(ticks(&mut host, &lost, STAY).is_none());
    assert_eq!(host.end().failed, ["not-entered"]);
}

/// Forces that mean nothing: no metric takes them, while the vessel counts as touched. More than one such tick, and more than 2 % of those with contact, and nothing is judged.
#[test]
fn forces_that_mean_nothing_are_not_measured() {
    let mut host = started(no_limits());
    spread(&mut host);
    let wild = Dilator {
        force: 50.0,
        spread: 70.0,
        direction: 0.3,
        ..INSIDE
    };
    let invalid = Scene {
        valid: false,
        stretch: 9.0,
        grip: [3.0, 3.0],
        ..with(wild)
    };
    tick(&mut host, &invalid);
    let result = ticks(&mut host, &SPREAD, 2 * STAY).expect("the verdict");
    measured(&result, "peak-force", 2e-3, 0.0);
    measured(&result, "push", 0.5e-3, 0.0);
    measured(&result, "peak-grip", 0.01, 0.0);
    measured(&result, "media-grip", 0.0, 0.0);
    measured(&result, "overstretch", 0.25, 1e-12);
    assert!(result.passed, "{:?}", result.failed);

    let mut host = started(no_limits());
    spread(&mut host);
    assert!(ticks(&mut host, &invalid, 5).is_none());
    let result = ticks(&mut host, &SPREAD, 2 * STAY).expect("an end");
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
    let text = refused(&|config| config["tools"][0]["model"] = json!("forceps"));
    assert!(text.contains("\"dilator\"; it has 0"), "{text}");
    let text = refused(&|config| config["tools"][1]["model"] = json!("dilator"));
    assert!(text.contains("it has 2"), "{text}");
    let text = refused(&|config| config["module"]["open_end"] = json!([0.0, 0.0, 0.0]));
    assert!(text.contains("open_end"), "{text}");
}
