use super::*;
use crate::catalogue::{MOTION_METRICS, id};
use microsim_vocabulary::LocalText;
use std::borrow::Cow;

const NONE: [&str; 0] = [];
const ALL_DONE: TargetCount = TargetCount { done: 4, total: 4 };

fn at_most(metric: &str, max: f64, zero: f64, full: f64) -> Limit {
    let source = "a test".to_string();
    Limit {
        metric: metric.into(),
        min: None,
        max: Some(max),
        zero,
        full,
        reason: None,
        source,
        provisional: true,
        decides: true,
    }
}

fn measured(metric: &str, value: f64) -> Measurement {
    Measurement {
        metric: metric.into(),
        tool: None,
        value: MetricValue::Value(value),
    }
}

/// A module's own metric.
fn angle_error(direction: Direction) -> MetricDefinition {
    MetricDefinition {
        id: Cow::Borrowed("angle-error"),
        title: LocalText::fixed("Winkelfehler", "Angle error"),
        category: Category::Target,
        direction,
        ..MOTION_METRICS[3].clone()
    }
}

/// Time: 10 s is full, 50 s is zero, 30 s is the limit; path: 0.1 m, 0.5 m, 0.4 m; tremor: 0, 200 µm, 100 µm.
fn rules() -> Rules {
    let limits = vec![
        Limit {
            reason: Some("too-slow".into()),
            ..at_most(id::TIME, 30.0, 50.0, 10.0)
        },
        at_most(id::PATH_LENGTH, 0.4, 0.5, 0.1),
        at_most(id::TREMOR, 100e-6, 200e-6, 0.0),
    ];
    Rules::new(&MOTION_METRICS, limits).expect("rules that fit")
}

fn scores(assessment: &Assessment) -> Vec<(Category, f64)> {
    assessment
        .categories
        .iter()
        .map(|score| (score.category, score.score))
        .collect()
}

#[test]
fn a_pass_and_its_score() {
    let run = [
        measured(id::TIME, 20.0),
        measured(id::PATH_LENGTH, 0.2),
        measured(id::TREMOR, 50e-6),
    ];
    let assessment = rules().assess(ALL_DONE, &run, NONE);
    assert!(assessment.passed && assessment.failed.is_empty());
    // (50 − 20)/40 = 75 %, (0.5 − 0.2)/0.4 = 75 %, (200 − 50)/200 = 75 %.
    for (category, score) in scores(&assessment) {
        let expected = if category == Category::Target {
            100.0
        } else {
            75.0
        };
        assert!((score - expected).abs() < 1e-12, "{category:?} {score}");
    }
    let categories: Vec<Category> = scores(&assessment)
        .into_iter()
        .map(|(category, _)| category)
        .collect();
    let present = [Category::Target, Category::Efficiency, Category::Handling];
    assert_eq!(categories, present, "no tissue, no score for it");
    assert!((assessment.total - 250.0 / 3.0).abs() < 1e-12);
    let record = &assessment.records[2];
    assert_eq!(
        (record.unit.as_str(), record.formula.as_str()),
        ("m", "tremor-hann-rms/1")
    );
    assert_eq!(
        (record.within, record.limit.max),
        (Some(true), Some(100e-6))
    );
}

/// Selvander & Åsman: nothing makes up for a limit that is violated.
#[test]
fn the_verdict_does_not_compensate() {
    let run = [
        measured(id::TIME, 5.0),
        measured(id::PATH_LENGTH, 0.05),
        measured(id::TREMOR, 101e-6),
    ];
    let assessment = rules().assess(ALL_DONE, &run, NONE);
    assert!(!assessment.passed);
    assert_eq!(assessment.failed, ["tremor"]);
    assert!(
        assessment.total > 80.0,
        "in spite of a good score: {}",
        assessment.total
    );
}

#[test]
fn reasons_are_exactly_those_that_occurred() {
    let good = [
        measured(id::TIME, 20.0),
        measured(id::PATH_LENGTH, 0.2),
        measured(id::TREMOR, 50e-6),
    ];
    let bad = [
        measured(id::TIME, 60.0),
        measured(id::PATH_LENGTH, 0.6),
        measured(id::TREMOR, 50e-6),
    ];
    let half = TargetCount { done: 2, total: 4 };
    let failed = |targets, run: &[Measurement], reasons: &[&str]| {
        rules().assess(targets, run, reasons.iter().copied()).failed
    };
    assert_eq!(failed(ALL_DONE, &bad, &[]), ["path-length", "too-slow"]);
    assert_eq!(
        failed(ALL_DONE, &bad, &["too-slow"]),
        ["path-length", "too-slow"],
        "each once"
    );
    assert_eq!(failed(half, &good, &[]), ["targets-missed"]);
    assert_eq!(failed(half, &good, &["wrong-angle"]), ["wrong-angle"]);
    assert_eq!(
        failed(half, &bad, &[]),
        ["path-length", "targets-missed", "too-slow"]
    );
}

#[test]
fn doing_nothing_scores_nothing() {
    let run = [
        measured(id::TIME, 1.0),
        measured(id::PATH_LENGTH, 0.0),
        measured(id::TREMOR, 0.0),
    ];
    for targets in [
        TargetCount { done: 0, total: 4 },
        TargetCount { done: 0, total: 0 },
    ] {
        let assessment = rules().assess(targets, &run, NONE);
        assert_eq!(assessment.failed, ["targets-missed"]);
        assert!(scores(&assessment).iter().all(|(_, score)| *score == 0.0));
        assert_eq!(assessment.total, 0.0);
    }
    let half = rules().assess(TargetCount { done: 2, total: 4 }, &run, NONE);
    assert!(
        scores(&half).iter().all(|(_, score)| *score == 50.0),
        "full points for half of the targets"
    );
}

#[test]
fn what_is_not_applicable_is_stated_and_neither_fails_nor_passes() {
    let slow = NotApplicable::SampleRateTooLow;
    let of_one_tool = Measurement {
        tool: Some("forceps".into()),
        ..measured(id::PATH_LENGTH, 9.0)
    };
    let tremor = Measurement {
        metric: id::TREMOR.into(),
        tool: None,
        value: MetricValue::NotApplicable(slow.clone()),
    };
    let assessment = rules().assess(
        ALL_DONE,
        &[measured(id::TIME, 30.0), of_one_tool, tremor],
        NONE,
    );
    assert!(!assessment.passed && assessment.failed.is_empty());
    assert_eq!(assessment.unmeasured, [id::PATH_LENGTH, id::TREMOR]);
    let values: Vec<_> = assessment
        .records
        .iter()
        .map(|record| record.value.clone())
        .collect();
    let none = |reason| MetricValue::NotApplicable(reason);
    assert_eq!(
        values,
        [
            MetricValue::Value(30.0),
            none(NotApplicable::NotMeasured),
            none(slow)
        ]
    );
    assert_eq!(assessment.records[2].within, None);
    let expected = [(Category::Target, 100.0), (Category::Efficiency, 50.0)];
    assert_eq!(
        scores(&assessment),
        expected,
        "time alone; no handling to evaluate"
    );
}

#[test]
fn a_module_joins_with_its_own_metric() {
    let own = angle_error(Direction::Lower);
    let rules = Rules::new(
        MOTION_METRICS.iter().chain([&own]),
        vec![at_most("angle-error", 0.2, 0.4, 0.0)],
    )
    .expect("rules that fit");
    let assessment = rules.assess(
        TargetCount { done: 1, total: 2 },
        &[measured("angle-error", 0.3)],
        NONE,
    );
    assert_eq!(assessment.failed, ["angle-error", "targets-missed"]);
    let [(Category::Target, score)] = scores(&assessment)[..] else {
        panic!("{assessment:?}")
    };
    assert!(
        (score - 12.5).abs() < 1e-12,
        "a quarter of the points for half of the targets: {score}"
    );
}

#[test]
fn points_run_linearly_and_stop_at_the_ends() {
    let limit = at_most("m", 1.0, 4.0, 2.0);
    for (value, lower, range) in [
        (1.0, 100.0, 50.0),
        (2.0, 100.0, 100.0),
        (3.0, 50.0, 50.0),
        (9.0, 0.0, 0.0),
    ] {
        assert_eq!(points(&limit, Direction::Lower, value), lower, "{value}");
        assert_eq!(points(&limit, Direction::Range, value), range, "{value}");
    }
    let both = Limit {
        min: Some(1.0),
        max: Some(3.0),
        ..limit
    };
    for (value, expected) in [(0.9, false), (1.0, true), (3.0, true), (3.1, false)] {
        assert_eq!(within(&both, value), expected, "{value}");
    }
}

/// A limit without a finite value is neither met nor broken: no pass, and no failure that it alone would be the reason of.
#[test]
fn a_limit_that_nobody_measured_is_no_pass() {
    let run = |tremor: Option<f64>| {
        let mut run = vec![measured(id::TIME, 20.0), measured(id::PATH_LENGTH, 0.2)];
        run.extend(tremor.map(|value| measured(id::TREMOR, value)));
        run
    };
    for tremor in [None, Some(f64::NAN), Some(f64::INFINITY)] {
        let assessment = rules().assess(ALL_DONE, &run(tremor), NONE);
        assert!(!assessment.passed && assessment.failed.is_empty());
        assert_eq!(assessment.unmeasured, ["tremor"], "{tremor:?}");
        let record = &assessment.records[2];
        assert_eq!((record.within, record.points), (None, None));
    }
    let assessment = rules().assess(ALL_DONE, &run(Some(50e-6)), NONE);
    assert!(assessment.passed && assessment.unmeasured.is_empty());
}

#[test]
fn limits_that_do_not_fit_are_refused() {
    let time = || at_most(id::TIME, 30.0, 50.0, 10.0);
    let id = |id: &str| id.to_string();
    let cases = [
        (vec![time(), time()], LimitError::DuplicateLimit(id("time"))),
        (
            vec![at_most("colour", 1.0, 1.0, 0.0)],
            LimitError::UnknownMetric(id("colour")),
        ),
        (
            vec![at_most(id::SPEED_CORRELATION, 1.0, 1.0, 0.0)],
            LimitError::Informative(id("speed-correlation")),
        ),
        (
            vec![Limit {
                zero: f64::NAN,
                ..time()
            }],
            LimitError::NotFinite(id("time")),
        ),
        (
            vec![Limit {
                max: Some(f64::INFINITY),
                ..time()
            }],
            LimitError::NotFinite(id("time")),
        ),
        (
            vec![Limit {
                max: None,
                ..time()
            }],
            LimitError::Unlimited(id("time")),
        ),
        (
            vec![Limit {
                min: Some(31.0),
                ..time()
            }],
            LimitError::Empty(id("time")),
        ),
        (
            vec![Limit {
                zero: 10.0,
                full: 50.0,
                ..time()
            }],
            LimitError::Ramp(id("time")),
        ),
        (
            vec![Limit {
                zero: 10.0,
                ..time()
            }],
            LimitError::Ramp(id("time")),
        ),
        (
            vec![at_most(id::SPARC, 0.0, -1.0, -5.0)],
            LimitError::Ramp(id("sparc")),
        ),
    ];
    for (limits, error) in cases {
        assert_eq!(Rules::new(&MOTION_METRICS, limits), Err(error));
    }
    let own = [angle_error(Direction::Range), angle_error(Direction::Range)];
    assert_eq!(
        Rules::new(&own, vec![]),
        Err(LimitError::DuplicateDefinition(id("angle-error")))
    );
}

#[test]
fn results_and_definitions_are_plain_data() {
    let run = [measured(id::TIME, 20.0)];
    let assessment = rules().assess(ALL_DONE, &run, ["wrong-angle"]);
    let text = serde_json::to_string(&assessment).expect("plain data");
    assert_eq!(
        serde_json::from_str::<Assessment>(&text).expect("own text"),
        assessment
    );
    let text = serde_json::to_string(&MOTION_METRICS[..]).expect("plain data");
    assert_eq!(
        serde_json::from_str::<Vec<MetricDefinition>>(&text).expect("own text"),
        MOTION_METRICS
    );
}

/// A metric that depends on the computation counts for the score as before, and neither its value nor its absence for the verdict.
#[test]
fn a_reference_value_is_scored_and_decides_nothing() {
    let rules = |decides| {
        let tremor = Limit {
            decides,
            ..at_most(id::TREMOR, 100e-6, 200e-6, 0.0)
        };
        let limits = vec![at_most(id::TIME, 30.0, 50.0, 10.0), tremor];
        Rules::new(&MOTION_METRICS, limits).expect("rules that fit")
    };
    let assess = |decides, tremor: &[f64]| {
        let tremor = tremor.iter().map(|value| measured(id::TREMOR, *value));
        let run: Vec<_> = [measured(id::TIME, 20.0)]
            .into_iter()
            .chain(tremor)
            .collect();
        rules(decides).assess(ALL_DONE, &run, NONE)
    };
    let (limited, referred) = (assess(true, &[150e-6]), assess(false, &[150e-6]));
    assert_eq!(
        (limited.passed, &limited.failed[..]),
        (false, &["tremor".to_owned()][..])
    );
    assert!(referred.passed && referred.failed.is_empty());
    assert_eq!(referred.records[1].within, Some(false));
    assert_eq!(scores(&limited), scores(&referred));
    let (limited, referred) = (assess(true, &[]), assess(false, &[]));
    assert_eq!(limited.unmeasured, ["tremor"]);
    assert!(!limited.passed && referred.passed && referred.unmeasured.is_empty());
}
