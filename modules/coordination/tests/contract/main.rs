//! The verdicts of the module, in-process and without physics: snapshots, forces and cuts in, the result out. The host moves the
//! module to a fresh instance in every tick.

mod stage;

use microsim_sdk::message::{
    LevelControl, LevelEvent, ObjectSet, Pose, ToolSample, TrainingResult,
};
use serde_json::{Value, json};
use stage::{
    ACROSS, DROP, FREE, HELD, IN_TRAY, STAY, Scene, Touch, both_cut, config, cut, host, limit,
    object, started, tick, tick_with, ticks, value,
};

#[test]
fn a_piece_cut_out_at_the_marks_that_lies_in_the_tray_passes() {
    let mut host = both_cut(
        "deliver",
        0.0003,
        ACROSS,
        json!([limit("cut-distance", 0.0004, "cut-beside-the-mark")]),
    );
    assert!(ticks(&mut host, &FREE, 3).is_none());
    let held = Scene {
        held: true,
        ..IN_TRAY
    };
    assert!(ticks(&mut host, &held, 2 * STAY).is_none(), "held");
    assert!(
        ticks(&mut host, &IN_TRAY, STAY - 1).is_none(),
        "a tick too early"
    );
    let result = tick(&mut host, &IN_TRAY).last::<TrainingResult>();
    let result = result.expect("the verdict");
    assert!(result.passed, "{:?}", result.failed);
    // The larger of 0.3 mm and 0; tolerance: rounding.
    let distance = value(&result, "cut-distance").expect("measured");
    assert!((distance - 0.0003).abs() < 1e-12, "{distance}");
    assert_eq!(value(&result, "steadied"), Some(1.0));
    assert_eq!(value(&result, "drops"), Some(0.0));
    // 10 mN in every tick, and a grip of 10 mN.
    assert_eq!(value(&result, "peak-force"), Some(0.01));
    assert_eq!(value(&result, "peak-grip"), Some(0.01));
}

#[test]
fn only_the_piece_itself_that_was_carried_lies_in_the_tray_or_is_held_above_it() {
    let deliver = || {
        let mut host = both_cut("deliver", 0.0, ACROSS, json!([]));
        assert!(ticks(&mut host, &FREE, 3).is_none());
        host
    };
    let stump = Scene {
        stump: true,
        ..IN_TRAY
    };
    assert!(
        ticks(&mut deliver(), &stump, 2 * STAY).is_none(),
        "the stump touches the tray, the piece does not"
    );
    // A piece that no forceps have had since it came off was pushed there, or fell.
    let mut pushed = both_cut("deliver", 0.0, ACROSS, json!([]));
    let let_go = Scene {
        held: false,
        ..FREE
    };
    assert!(ticks(&mut pushed, &let_go, 3).is_none());
    assert!(ticks(&mut pushed, &IN_TRAY, 2 * STAY).is_none(), "pushed");
    // So was one that was dropped beside it; picked up again and let go in the tray it is delivered.
    let mut again = deliver();
    let beside = Scene {
        by: [0.0, -0.02, -0.0035],
        ..IN_TRAY
    };
    assert!(ticks(&mut again, &beside, DROP).is_none());
    assert!(ticks(&mut again, &IN_TRAY, 2 * STAY).is_none(), "pushed");
    assert!(ticks(&mut again, &FREE, 1).is_none());
    let result = ticks(&mut again, &IN_TRAY, 2 * STAY).expect("the verdict");
    assert_eq!(value(&result, "drops"), Some(1.0));
    // Forceps that have gone on to a stump have let the piece go.
    let elsewhere = Scene {
        held: true,
        touch: Touch::Stump,
        ..IN_TRAY
    };
    let result = ticks(&mut deliver(), &elsewhere, 2 * STAY).expect("the verdict");
    assert!(result.passed, "{:?}", result.failed);
    // While they hold a stump, a piece outside of the tray is dropped.
    let beside = Scene {
        by: [0.0, -0.02, -0.0035],
        ..elsewhere
    };
    let mut lost = deliver();
    ticks(&mut lost, &beside, DROP);
    assert_eq!(value(&lost.end(), "drops"), Some(1.0));
}

#[test]
fn a_wound_beside_a_good_cut_is_stray() {
    let limits = json!([
        limit("cut-distance", 0.0004, "cut-beside-the-mark"),
        limit("stray-cut", 1e-8, "stray-cut")
    ]);
    // 0.7 mm beside the first mark, and within its reach.
    let mut host = started("cut", limits.clone());
    tick(&mut host, &HELD);
    cut(&mut host, "right", -0.0013, ACROSS);
    tick(&mut host, &HELD);
    for _ in 0..2 {
        cut(&mut host, "right", -0.002, ACROSS);
        tick(&mut host, &HELD);
    }
    cut(&mut host, "right", 0.002, ACROSS);
    let result = tick(&mut host, &FREE)
        .last::<TrainingResult>()
        .expect("the verdict");
    assert_eq!(result.failed, ["stray-cut"]);
    assert_eq!(value(&result, "stray-cut"), Some(1e-6));

    let mut whole = both_cut("cut", 0.0007, ACROSS, limits);
    let result = tick(&mut whole, &FREE)
        .last::<TrainingResult>()
        .expect("the verdict");
    assert_eq!(
        result.failed,
        ["cut-beside-the-mark"],
        "all of it, only at the wrong place"
    );
}

#[test]
fn tissue_that_lies_on_jaws_or_slides_along_them_is_not_held() {
    for touch in [Touch::Hook, Touch::Slide] {
        let touched = Scene { touch, ..HELD };
        let within = Scene {
            by: [0.0, 0.0, 0.003],
            ..touched
        };
        let mut hold = started("hold", json!([]));
        assert!(ticks(&mut hold, &within, 2 * STAY).is_none());
        let result = hold.end();
        assert_eq!(result.failed, ["not-gripped"]);
        assert_eq!(value(&result, "drops"), None, "nothing was ever gripped");

        let mut loose = started("cut", json!([]));
        tick(&mut loose, &touched);
        cut(&mut loose, "right", -0.002, ACROSS);
        tick(&mut loose, &touched);
        assert_eq!(value(&loose.end(), "steadied"), Some(0.0));
    }
}

/// 1 mm² at each mark. What holds a stump steadies the cut next to it, and no other one, also while all is one piece; a grip that lets go
/// for less than 0.1 s has not let go.
#[test]
fn only_what_is_cut_can_be_steadied() {
    let stump = Scene {
        touch: Touch::Stump,
        ..HELD
    };
    let far_stump = Scene {
        touch: Touch::FarStump,
        ..HELD
    };
    let first_is_through = Scene {
        pieces: [0, 1, 1],
        ..HELD
    };
    let far_after = Scene {
        touch: Touch::FarStump,
        ..first_is_through
    };
    let elsewhere = Scene {
        touch: Touch::Stump,
        ..first_is_through
    };
    let loose = Scene {
        held: false,
        ..first_is_through
    };
    for (before, between, waits, steadied) in [
        (HELD, first_is_through, DROP, 1.0),
        (stump, first_is_through, DROP, 1.0),
        (stump, elsewhere, DROP, 0.5),
        (stump, stump, DROP, 0.5),
        (far_stump, far_after, DROP, 0.5),
        (Scene::default(), elsewhere, DROP, 0.0),
        (HELD, loose, DROP - 2, 1.0),
        (HELD, loose, DROP, 0.5),
    ] {
        let mut host = started("cut", json!([]));
        cut(&mut host, "right", -0.002, ACROSS);
        tick(&mut host, &before);
        ticks(&mut host, &between, waits - 1);
        cut(&mut host, "right", 0.002, ACROSS);
        tick(&mut host, &between);
        assert_eq!(value(&host.end(), "steadied"), Some(steadied));
    }
}

/// The scissors begin at the origin: to the marks, 2 mm away on either side, are 1 + 2 mm, with the reach of 1 mm once and twice. The
/// forceps begin 3 mm above the line between the clamps, 2 mm beyond the reach, or are there already, or never hold tissue, or
/// never come into view. Nothing has
/// moved, so that no run has an economy; of a run of 1 mm it is so many.
#[test]
fn the_economy_is_that_of_the_shortest_path_of_the_task() {
    for (moves, forceps, held, expected) in [
        (false, Some(0.0), true, 0.0),
        (true, Some(0.0), true, 3.0),
        (true, Some(0.003), true, 5.0),
        (true, Some(0.003), false, 3.0),
        (true, None, false, 3.0),
    ] {
        let before = Scene { held, ..HELD };
        let after = Scene { held, ..FREE };
        let host = host(config("cut", json!([]))).expect("a complete set-up");
        let mut host = host.moving();
        host.send(&LevelControl::Start);
        tick_with(&mut host, &before, &[]);
        let tools = [("left", forceps), ("right", Some(0.0))];
        for step in 0..2 {
            host.send(&ToolSample {
                tool: "right".into(),
                time: 0.01 * f64::from(step),
                tracked: true,
                pose: Pose {
                    position: [if moves { 0.001 } else { 0.0 } * f64::from(step), 0.0, 0.0],
                    ..Pose::default()
                },
                opening: 0.0,
            });
        }
        cut(&mut host, "right", -0.002, ACROSS);
        cut(&mut host, "right", 0.002, ACROSS);
        tick_with(&mut host, &before, &tools);
        let result = tick_with(&mut host, &after, &tools)
            .last::<TrainingResult>()
            .expect("the verdict");
        match value(&result, "economy") {
            Some(economy) => assert!(moves && (economy - expected).abs() < 1e-9, "{economy}"),
            None => assert!(!moves),
        }
    }
}

#[test]
fn a_mark_that_is_cut_through_moves_no_more() {
    let mut host = both_cut("deliver", 0.0, ACROSS, json!([]));
    tick(&mut host, &FREE);
    let sets: Vec<ObjectSet> = tick(&mut host, &FREE).all();
    assert!(
        sets.iter().all(|set| !set.name.starts_with("mark-")),
        "{sets:?}"
    );
}

#[test]
fn a_cut_is_measured_by_its_plane_at_rest() {
    // A plane that holds the mark's middle, turned by asin(0.6) from its line.
    let mut host = both_cut(
        "cut",
        0.0,
        [0.8, 0.6, 0.0],
        json!([limit("cut-angle", 0.5, "cut-askew")]),
    );
    let result = tick(&mut host, &FREE)
        .last::<TrainingResult>()
        .expect("the verdict");
    assert_eq!(result.failed, ["cut-askew"]);
    let angle = value(&result, "cut-angle").expect("measured");
    assert!((angle - 0.6f64.asin()).abs() < 1e-12, "{angle}");
    assert!(value(&result, "cut-distance").expect("measured") < 1e-12);
    assert_eq!(value(&result, "drops"), None, "nothing was to be held");
}

#[test]
fn what_is_cut_elsewhere_and_what_tears_is_told_apart() {
    let limits = json!([
        limit("stray-cut", 1e-8, "stray-cut"),
        limit("torn", 1e-5, "torn")
    ]);
    let mut host = started("cut", limits);
    cut(&mut host, "right", 0.0, ACROSS);
    cut(&mut host, "", 0.0, ACROSS);
    let events: Vec<LevelEvent> = tick(&mut host, &Scene::default()).all();
    let ids: Vec<&str> = events.iter().map(|event| event.id.as_str()).collect();
    assert_eq!(ids, ["stray-cut", "tear"]);
    let separated = Scene {
        held: false,
        ..FREE
    };
    assert!(
        ticks(&mut host, &separated, 2).is_none(),
        "apart, but cut at no mark"
    );
    let result = host.end();
    assert_eq!(result.failed, ["not-cut", "stray-cut"]);
    assert_eq!(value(&result, "stray-cut"), Some(1e-6));
    assert_eq!(value(&result, "torn"), Some(1e-6));
    assert_eq!(value(&result, "steadied"), Some(0.0));
    assert_eq!(value(&result, "cut-distance"), None, "no cut at a mark");
}

/// Elsewhere 1 mm² is cut and 1 or 2 mm² tear; at the marks 1 mm² each is cut, which has to be half of that.
#[test]
fn a_mark_counts_only_if_at_least_half_as_much_was_cut_there_as_came_apart_elsewhere() {
    for (tears, counts) in [(1, true), (2, false)] {
        let mut host = both_cut("cut", 0.0, ACROSS, json!([]));
        cut(&mut host, "right", 0.0, ACROSS);
        for _ in 0..tears {
            cut(&mut host, "", 0.0, ACROSS);
        }
        let result = tick(&mut host, &FREE).last::<TrainingResult>();
        assert_eq!(result.is_some(), counts);
        if !counts {
            assert_eq!(host.end().failed, ["not-cut"]);
        }
    }
}

#[test]
fn each_reason_to_miss_a_target_comes_alone() {
    let mut uncut = started("deliver", json!([]));
    ticks(&mut uncut, &HELD, STAY);
    assert_eq!(uncut.end().failed, ["not-cut"]);

    let mut lost = both_cut("deliver", 0.0, ACROSS, json!([]));
    tick(&mut lost, &FREE);
    let beside = Scene {
        by: [0.0, -0.02, -0.0035],
        ..IN_TRAY
    };
    assert!(ticks(&mut lost, &beside, DROP - 1).is_none());
    let events: Vec<LevelEvent> = tick(&mut lost, &beside).all();
    assert!(events.iter().any(|event| event.id == "drop"), "{events:?}");
    let result = lost.end();
    assert_eq!(result.failed, ["not-in-tray"]);
    assert_eq!(value(&result, "drops"), Some(1.0));

    let mut late = started("deliver", json!([limit("time", 0.1, "too-slow")]));
    let result = ticks(&mut late, &HELD, STAY).expect("the time is over");
    assert_eq!(
        result.failed,
        ["too-slow"],
        "alone: what else is missed follows from it"
    );
}

#[test]
fn marked_tissue_held_in_the_ring_passes_and_less_says_why() {
    // 0.3 mm below the middle of the ring, whose opening is 1 mm.
    let within = Scene {
        by: [0.0, 0.0, 0.0027],
        ..HELD
    };
    let mut host = started("hold", json!([]));
    assert!(
        ticks(&mut host, &within, STAY - 1).is_none(),
        "a tick too early"
    );
    let result = tick(&mut host, &within).last::<TrainingResult>();
    let result = result.expect("the verdict");
    assert!(result.passed, "{:?}", result.failed);
    let error = value(&result, "place-error").expect("measured");
    assert!((error - 0.0003).abs() < 1e-12, "{error}");

    let mut short = started("hold", json!([]));
    ticks(&mut short, &within, STAY - 2);
    tick(&mut short, &HELD);
    assert_eq!(short.end().failed, ["dwell-too-short"]);

    let mut loose = started("hold", json!([]));
    ticks(
        &mut loose,
        &Scene {
            held: false,
            ..within
        },
        2 * STAY,
    );
    assert_eq!(loose.end().failed, ["not-gripped"]);

    let mut low = started("hold", json!([]));
    ticks(&mut low, &HELD, 2 * STAY);
    assert_eq!(low.end().failed, ["not-in-ring"]);
}

#[test]
fn excess_force_is_timed_and_told_once() {
    let mut host = started("cut", json!([]));
    let hard = Scene {
        force: 0.03,
        ..HELD
    };
    let heard = tick(&mut host, &hard);
    let ids: Vec<String> = heard
        .all::<LevelEvent>()
        .into_iter()
        .map(|e| e.id)
        .collect();
    assert_eq!(ids, ["grip", "excess-force"]);
    assert!(tick(&mut host, &hard).all::<LevelEvent>().is_empty());
    tick(&mut host, &HELD);
    let result = host.end();
    // Two ticks of 8 ms.
    assert_eq!(value(&result, "excess-time"), Some(0.016));
    assert_eq!(value(&result, "peak-force"), Some(0.03));
}

/// Cuts and contacts are not evaluated before a snapshot has shown what there is: what was not measured is not zero.
#[test]
fn without_tissue_nothing_is_measured() {
    let host = host(config("cut", json!([]))).expect("a complete set-up");
    let mut host = host.moving();
    host.send(&LevelControl::Start);
    for _ in 0..2 {
        host.send_tools(&[("left", Pose::default()), ("right", Pose::default())]);
        cut(&mut host, "right", -0.002, ACROSS);
        host.tick().expect("a good tick");
    }
    let result = host.end();
    assert_eq!(result.failed, ["not-cut"]);
    for id in [
        "cut-distance",
        "stray-cut",
        "torn",
        "steadied",
        "peak-force",
    ] {
        assert_eq!(value(&result, id), None, "{id}");
    }
}

/// Each message names the key of the level's file that does not fit.
#[test]
fn a_level_that_does_not_fit_is_refused_by_its_key() {
    let refused = |key: &str, spoil: &dyn Fn(&mut Value)| {
        let mut config = config("cut", json!([]));
        spoil(&mut config);
        let fault = host(config).err().expect(key).to_string();
        assert!(fault.contains(key), "{fault}");
    };
    refused("[module] `task`", &|config| {
        config["module"]["task"] = json!("hold")
    });
    refused("\"clamp-left\"", &|config| {
        config["objects"][0]["name"] = json!("clamp");
    });
    refused("\"mark-1\": `shape`", &|config| {
        config["objects"][2] = object(
            "mark-1",
            json!({ "shape": "sphere", "radius": 0.001 }),
            [0.0; 3],
        );
    });
    refused("\"mark-1\": its `orientation`", &|config| {
        config["objects"][2]["orientation"] = json!([0.0, 0.0, 0.0, 1.0]);
    });
    refused("[[body]]", &|config| config["bodies"] = json!([]));
    // The second mark before the first, and behind the second clamp.
    for x in [-0.003, 0.005] {
        refused("\"mark-2\": its `position`", &|config| {
            config["objects"][4]["position"] = json!([x, 0.0, 0.0]);
        });
    }
    refused("[[tool]] that cuts", &|config| {
        config["models"]["scissors"]["sharpness"] = json!(0.0);
    });
    refused("[[tool]] that does not cut", &|config| {
        config["module"]["task"] = json!("deliver");
        config["models"]["forceps"]["sharpness"] = json!(1.0);
    });
}
