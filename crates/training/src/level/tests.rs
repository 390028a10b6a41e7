use super::*;
use proptest::prelude::*;

fn level() -> LevelMachine {
    LevelMachine::new(["a", "b"]).expect("two targets")
}

const NONE: [&str; 0] = [];

fn failed(reasons: &[&str]) -> LevelPhase {
    LevelPhase::Failed {
        reasons: reasons.iter().map(|reason| reason.to_string()).collect(),
    }
}

#[test]
fn a_level_that_is_passed() {
    let mut level = level();
    assert_eq!(
        level.running_time(5.0),
        0.0,
        "the introduction does not count"
    );
    level.start(10.0).expect("legal");
    level.target_done(11.0, "b").expect("legal");
    level.pause(12.0).expect("legal");
    assert_eq!(level.running_time(19.0), 2.0, "a pause does not count");
    level.resume(20.0).expect("legal");
    level.target_done(21.5, "a").expect("legal");
    assert_eq!(level.running_time(22.0), 4.0);
    assert_eq!(level.finish(22.0, NONE), Ok(&LevelPhase::Passed));
    assert_eq!(level.running_time(100.0), 4.0, "stands still after the end");
    let times: Vec<_> = level
        .targets()
        .iter()
        .map(|target| target.done_at_s)
        .collect();
    assert_eq!(times, [Some(3.5), Some(1.0)], "in running time");
}

#[test]
fn reasons_are_exactly_those_that_occurred() {
    let finish = |done: &[&str], reasons: &[&str]| {
        let mut level = level();
        level.start(0.0).expect("legal");
        for id in done {
            level.target_done(1.0, id).expect("legal");
        }
        level
            .finish(2.0, reasons.iter().copied())
            .expect("legal")
            .clone()
    };
    assert_eq!(finish(&["a", "b"], &[]), LevelPhase::Passed);
    assert_eq!(finish(&["a", "b"], &["time"]), failed(&["time"]));
    assert_eq!(finish(&["a"], &[]), failed(&[REASON_TARGETS_MISSED]));
    assert_eq!(
        finish(&["a"], &["wrong-angle"]),
        failed(&["wrong-angle"]),
        "the cause, not its consequence"
    );
    assert_eq!(
        finish(&[], &["time", "force", "time"]),
        failed(&["force", "time"])
    );
}

#[test]
fn refused_events_change_nothing() {
    let mut level = level();
    let introduction = level.clone();
    let illegal = |event, phase| Err(LevelError::Illegal { event, phase });
    assert_eq!(
        level.pause(0.0),
        illegal(LevelEvent::Pause, LevelPhase::Introduction)
    );
    assert_eq!(
        level.target_done(0.0, "a"),
        illegal(LevelEvent::TargetDone, LevelPhase::Introduction)
    );
    assert!(level.finish(0.0, NONE).is_err());
    assert_eq!(level.start(f64::NAN), Err(LevelError::TimeNotFinite));
    assert_eq!(level, introduction);

    level.start(5.0).expect("legal");
    level.target_done(6.0, "a").expect("legal");
    let running = level.clone();
    assert_eq!(
        level.start(7.0),
        illegal(LevelEvent::Start, LevelPhase::Running)
    );
    assert_eq!(
        level.resume(7.0),
        illegal(LevelEvent::Resume, LevelPhase::Running)
    );
    assert_eq!(
        level.pause(5.5),
        Err(LevelError::TimeBackwards {
            last: 6.0,
            now: 5.5
        })
    );
    assert_eq!(
        level.target_done(7.0, "c"),
        Err(LevelError::UnknownTarget("c".into()))
    );
    assert_eq!(
        level.target_done(7.0, "a"),
        Err(LevelError::TargetAlreadyDone("a".into()))
    );
    assert_eq!(level, running);

    level.pause(7.0).expect("legal");
    assert_eq!(
        level.target_done(8.0, "b"),
        illegal(LevelEvent::TargetDone, LevelPhase::Paused)
    );
    level.abort(8.0).expect("legal");
    assert_eq!(level.phase(), &failed(&[REASON_ABORTED]));
    assert_eq!(
        level.abort(9.0),
        illegal(LevelEvent::Abort, failed(&[REASON_ABORTED]))
    );
}

#[test]
fn levels_and_states_that_cannot_be() {
    assert_eq!(LevelMachine::new(NONE), Err(LevelError::NoTargets));
    assert_eq!(
        LevelMachine::new(["a", "a"]),
        Err(LevelError::DuplicateTarget("a".into()))
    );

    let mut level = level();
    level.start(1.0).expect("legal");
    let good = level.state().clone();
    let cases = [
        LevelState {
            phase: LevelPhase::Passed,
            running_since_s: None,
            ..good.clone()
        },
        LevelState {
            phase: failed(&[]),
            running_since_s: None,
            ..good.clone()
        },
        LevelState {
            phase: failed(&["b", "a"]),
            running_since_s: None,
            ..good.clone()
        },
        LevelState {
            phase: LevelPhase::Paused,
            ..good.clone()
        },
        LevelState {
            running_since_s: None,
            ..good.clone()
        },
        LevelState {
            running_since_s: Some(2.0),
            ..good.clone()
        },
        LevelState {
            phase: LevelPhase::Introduction,
            running_since_s: None,
            ..good.clone()
        },
        LevelState {
            elapsed_s: f64::NAN,
            ..good.clone()
        },
        LevelState {
            elapsed_s: -1.0,
            ..good.clone()
        },
        LevelState {
            targets: vec![Target {
                id: "a".into(),
                done_at_s: Some(-1.0),
            }],
            ..good.clone()
        },
    ];
    for state in cases {
        assert!(
            matches!(
                LevelMachine::restore(state.clone()),
                Err(LevelError::Contradiction(_))
            ),
            "{state:?}"
        );
    }
    assert!(LevelMachine::restore(good).is_ok());
}

#[derive(Debug, Clone)]
struct Step {
    event: LevelEvent,
    target: &'static str,
    reason: Option<&'static str>,
    wait: f64,
}

fn any_step() -> impl Strategy<Value = Step> {
    use LevelEvent::{Abort, Finish, Pause, Resume, Start, TargetDone};
    // Targets often, endings seldom, so that long histories occur.
    let event = prop_oneof![
        4 => Just(Start), 3 => Just(Pause), 4 => Just(Resume), 6 => Just(TargetDone), 2 => Just(Finish), 1 => Just(Abort)
    ];
    let target = prop_oneof![Just("a"), Just("b"), Just("c")];
    let reason = prop::option::of(prop_oneof![Just("x"), Just("y")]);
    (event, target, reason, -0.2..2.0f64).prop_map(|(event, target, reason, wait)| Step {
        event,
        target,
        reason,
        wait,
    })
}

proptest! {
    /// Whatever happens: the phase follows the table, running time grows by waiting while running and by nothing else,
    /// each state is one that can be restored, and a refused event leaves no trace.
    #[test]
    fn random_events_never_lead_astray(steps in prop::collection::vec(any_step(), 0..40)) {
        let mut level = level();
        let mut now = 0.0;
        let mut expected_running_time = 0.0;
        for step in steps {
            let before = level.clone();
            let last = before.state().last_event_s;
            now += step.wait;
            let outcome = match step.event {
                LevelEvent::Start => level.start(now),
                LevelEvent::Pause => level.pause(now),
                LevelEvent::Resume => level.resume(now),
                LevelEvent::TargetDone => level.target_done(now, step.target),
                LevelEvent::Finish => level.finish(now, step.reason).map(|_| ()),
                LevelEvent::Abort => level.abort(now),
            };
            if outcome.is_err() {
                prop_assert_eq!(&level, &before);
            } else {
                use LevelPhase::{Introduction, Paused, Running};
                let all_done = before.all_targets_done();
                let right = match (before.phase(), step.event, level.phase()) {
                    (Introduction, LevelEvent::Start, Running)
                    | (Running, LevelEvent::Pause, Paused)
                    | (Paused, LevelEvent::Resume, Running)
                    | (Running, LevelEvent::TargetDone, Running) => true,
                    (Running, LevelEvent::Finish, LevelPhase::Passed) => all_done && step.reason.is_none(),
                    (Running, LevelEvent::Finish, LevelPhase::Failed { .. }) => !all_done || step.reason.is_some(),
                    (Introduction | Running | Paused, LevelEvent::Abort, LevelPhase::Failed { .. }) => true,
                    _ => false,
                };
                prop_assert!(right, "{:?} {:?} {:?}", before, step, level);
                if before.phase() == &Running {
                    expected_running_time += now - last.expect("an event before running");
                }
                // Forty additions of times below 80 s.
                let tolerance = 40.0 * 80.0 * f64::EPSILON;
                prop_assert!((level.running_time(now) - expected_running_time).abs() <= tolerance);
            }
            let text = serde_json::to_string(level.state()).expect("plain data");
            let restored = LevelMachine::restore(serde_json::from_str(&text).expect("own text"));
            prop_assert_eq!(restored.as_ref(), Ok(&level));
        }
    }
}
