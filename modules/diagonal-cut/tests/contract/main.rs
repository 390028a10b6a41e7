//! The verdicts of the module, in-process and without physics: snapshots, elements, forces and cuts in, the result out. The host moves the
//! module to a fresh instance in every tick.

mod stage;

use microsim_sdk::message::TrainingResult;
use serde_json::{Value, json};
use stage::{LARGER, SMALLER, STAY, Scene, config, cut, host, limit, started, tick, ticks, value};
use std::f64::consts::PI;

/// What is left after a cut 0.6 mm from the end.
const OFF: Scene = Scene {
    angle: 0.0,
    cut: Some(0.6e-3),
    wider: 0.0,
    stretch: 1.0,
    grip: 0.0,
    opening: 0.0,
};

fn measured(result: &TrainingResult, metric: &str, expected: f64, tolerance: f64) {
    let found = value(result, metric).expect(metric);
    assert!(
        (found - expected).abs() <= tolerance,
        "{metric}: {found}, not {expected}"
    );
}

/// At 45 degrees the circumference is 1.2160067 times that of a straight cut (`site.rs`), and the larger vessel has 1.25 times: 2.719 % short. The area is √2 times
/// that of a circle, the wanted one 1.25² times. Polygons of 96 corners are short of ellipse and circle by 2e-4 each, which cancels but for the ellipse's form.
#[test]
fn an_oblique_cut_is_compared_with_the_larger_vessel() {
    let limits = json!([limit("circumference-mismatch", 0.05, "wrong-size")]);
    let mut host = started("cut", limits);
    let gripped = Scene {
        grip: 0.02,
        ..Scene::default()
    };
    assert!(ticks(&mut host, &gripped, 3).is_none());
    cut(&mut host, "smaller", "right");
    let off = Scene {
        angle: PI / 4.0,
        ..OFF
    };
    // As long as something touches what is left, it is not judged.
    assert!(ticks(&mut host, &Scene { grip: 0.02, ..off }, 2 * STAY).is_none());
    assert!(
        ticks(&mut host, &off, STAY - 1).is_none(),
        "a tick too early"
    );
    let result = tick(&mut host, &off)
        .last::<TrainingResult>()
        .expect("the verdict");
    assert!(result.passed, "{:?}", result.failed);
    let ratio = LARGER / SMALLER;
    measured(
        &result,
        "circumference-mismatch",
        1.0 - 1.216_006_7 / ratio,
        1e-4,
    );
    measured(
        &result,
        "area-mismatch",
        1.0 - 2f64.sqrt() / (ratio * ratio),
        1e-9,
    );
    // The angle at which an ellipse has 1.25 times the circumference is 47.75 degrees, by bisection with the arithmetic-geometric mean.
    let wanted = angle_of(ratio);
    measured(&result, "angle-error", wanted - PI / 4.0, 1e-3);
    measured(&result, "length-lost", 0.6e-3, 1e-9);
    measured(&result, "unevenness", 0.0, 1e-9);
    measured(&result, "raggedness", 0.0, 1e-9);
    measured(&result, "facing-error", 0.0, 1e-6);
    measured(&result, "bites", 1.0, 0.0);
    measured(&result, "steadied", 1.0, 0.0);
    // A quarter of a grip of 20 mN.
    measured(&result, "media-grip", 0.005, 1e-12);
    measured(&result, "peak-grip", 0.02, 1e-12);
    measured(&result, "other-vessel", 0.0, 0.0);
}

/// The angle at which an ellipse has so many times the circumference of the circle: its circumference by the arithmetic-geometric mean, 2π/M (a² − Σ 2ⁿ⁻¹ cₙ²).
fn angle_of(ratio: f64) -> f64 {
    let circumference = |long: f64| {
        let (mut a, mut b) = (long, 1.0);
        let mut sum = 0.5 * (a * a - b * b);
        let mut weight = 1.0;
        for _ in 0..6 {
            let c = 0.5 * (a - b);
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
            sum += weight * c * c;
            weight *= 2.0;
        }
        (long * long - sum) / a
    };
    let (mut low, mut high) = (0.0, 1.4);
    for _ in 0..60 {
        let middle: f64 = 0.5 * (low + high);
        match circumference(1.0 / libm::cos(middle)) < ratio {
            true => low = middle,
            false => high = middle,
        }
    }
    low
}

/// Mirrored, the opening faces away from the trainee: half a turn off.
#[test]
fn an_opening_on_the_other_side_faces_half_a_turn_away() {
    let mut host = started("cut", json!([limit("facing-error", 0.5, "wrong-side")]));
    let off = Scene {
        angle: -PI / 4.0,
        ..OFF
    };
    let result = ticks(&mut host, &off, 2 * STAY).expect("the verdict");
    assert_eq!(result.failed, ["wrong-side"]);
    measured(&result, "facing-error", PI, 1e-6);
    // Nothing was cut by a tool: there is no bite, and nothing to steady.
    assert_eq!(
        (value(&result, "bites"), value(&result, "steadied")),
        (None, None)
    );
}

#[test]
fn every_bite_and_cuts_elsewhere_count() {
    let limits = json!([
        limit("bites", 1.0, "jagged"),
        limit("other-vessel", 1e-8, "other-vessel-cut")
    ]);
    let mut host = started("cut", limits);
    for opening in [0.4, 0.8, 0.3] {
        if opening < 0.5 {
            cut(&mut host, "smaller", "right");
        }
        tick(
            &mut host,
            &Scene {
                opening,
                ..Scene::default()
            },
        );
    }
    cut(&mut host, "larger", "right");
    cut(&mut host, "smaller", "");
    let result = ticks(&mut host, &OFF, 2 * STAY).expect("the verdict");
    let failed: std::collections::BTreeSet<&str> =
        result.failed.iter().map(String::as_str).collect();
    assert_eq!(failed, ["jagged", "other-vessel-cut"].into());
    measured(&result, "bites", 2.0, 0.0);
    measured(&result, "steadied", 0.0, 0.0);
    measured(&result, "other-vessel", 1e-6, 0.0);
    measured(&result, "torn", 1e-6, 0.0);
    // It was as wide as ever until it was off.
    measured(&result, "needless-spread", 0.0, 1e-12);
}

/// Spread by 25 %, within the tolerance of 3 % of it, the openings match; a cut there is needless, and half of the media was beyond its stretch.
#[test]
fn a_small_difference_is_spread() {
    let limits = json!([
        limit("overstretched", 0.6, "overstretched"),
        limit("needless-cut", 1e-7, "wrong-choice")
    ]);
    let mut host = started("dilate", limits.clone());
    let spread = |wider: f64| Scene {
        wider,
        stretch: 1.7,
        ..Scene::default()
    };
    assert!(
        ticks(&mut host, &spread(0.2), 2 * STAY).is_none(),
        "too little"
    );
    assert!(
        ticks(&mut host, &spread(0.3), 2 * STAY).is_none(),
        "too much"
    );
    let result = ticks(&mut host, &spread(0.23), 2 * STAY).expect("the verdict");
    assert!(result.passed, "{:?}", result.failed);
    measured(&result, "circumference-mismatch", 0.02 / 1.25, 1e-9);
    measured(&result, "overstretched", 0.5, 1e-12);
    assert_eq!(value(&result, "unevenness"), None);

    let mut host = started("dilate", limits);
    cut(&mut host, "smaller", "right");
    let result = ticks(&mut host, &spread(0.25), 2 * STAY).expect("the verdict");
    assert_eq!(result.failed, ["wrong-choice"]);
}

/// Where something is left to do when the input ends, its reason is named; of who has touched nothing only that targets were missed.
#[test]
fn what_was_not_done_is_named() {
    let gripped = Scene {
        grip: 0.02,
        ..Scene::default()
    };
    for (solution, scene, reason) in [
        ("cut", gripped, "not-cut"),
        ("dilate", gripped, "not-matched"),
        ("cut", Scene { grip: 0.02, ..OFF }, "still-touched"),
    ] {
        let mut host = started(solution, json!([]));
        ticks(&mut host, &scene, 3);
        assert_eq!(host.end().failed, [reason]);
    }
    let mut idle = started("cut", json!([]));
    ticks(&mut idle, &Scene::default(), 3);
    assert_eq!(idle.end().failed, ["targets-missed"]);
}

#[test]
fn levels_without_two_vessels_in_clamps_are_refused() {
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut config = config("cut", json!([]));
        change(&mut config);
        host(config).err().expect("it lacks something").to_string()
    };
    let text = refused(&|config| config["bodies"] = json!(["smaller"]));
    assert!(text.contains("two [[body]]"), "{text}");
    let text = refused(&|config| config["objects"][1]["name"] = json!("clamp"));
    assert!(text.contains("clamp-larger"), "{text}");
}
