//! A sample of the soak of random hands (`cargo xtask soak hands`): players that keep to no script, on levels of every module. What is asked of all of them
//! in the end stands in the limits below; what the simulator does not keep yet has the value of today beside it, and may only become stricter.

use microsim_tests::hands::hand::script;
use microsim_tests::hands::played::{Ended, Guard, Outcome, play};
use microsim_tests::hands::stage::{LevelName, Stage};
use microsim_tests::hands::{Player, Profile, stages};
use microsim_tests::trainees::ABSURD_FORCE;
use microsim_tests::{assert_verified, scratch};
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::path::PathBuf;

/// The sample: module, level, profile, all of one seed and length; and what is allowed today.
const SAMPLE: [(&str, &str, Profile, Today); 18] = [
    ("guide-path", "5", Profile::Clumsy, MET),
    ("touch-spheres", "5", Profile::Outliers, MET),
    ("push-strip", "3", Profile::Dragging, MET),
    ("push-strip", "3", Profile::Swapping, MET),
    ("push-strip", "4", Profile::Calm, MET),
    ("coordination", "1", Profile::Stabbing, MET),
    ("coordination", "1", Profile::Jittery, MET),
    ("coordination", "1", Profile::Snipping, MET),
    ("coordination", "2", Profile::Violent, WITH_ALL_FORCE),
    ("coordination", "3", Profile::Closing, MET),
    ("coordination", "6", Profile::Clumsy, MET),
    ("trim-sharp", "1", Profile::Closing, MET),
    // Held for 17 ticks while tries with tools that stand or touch nothing were cut short by what was reserved for tries before them.
    ("trim-blunt", "2", Profile::Violent, MET),
    ("trim-blunt", "3", Profile::Clumsy, MET),
    ("diagonal-cut", "2", Profile::Dragging, MET),
    ("dilatation", "1", Profile::Snipping, MET),
    (
        "push-strip",
        "2.dissertation",
        Profile::Violent,
        IN_ONE_STEP,
    ),
    (
        "coordination",
        "2.dissertation",
        Profile::Clumsy,
        IN_ONE_STEP,
    ),
];
const SEED: u64 = 1;
/// Length of each run \[s\].
const SECONDS: f64 = 3.0;
/// Those whose sessions are verified: they cost least.
const VERIFIED: usize = 2;

/// What a run may do at most.
#[derive(Clone, Copy)]
struct Today {
    /// Fraction of ticks in which the bodies are held.
    held: f64,
    /// Ticks and tools with a force above the limit.
    too_strong: u64,
    /// Whether it may be ended because it is too slow.
    stalled: bool,
}

/// What is wanted of all.
const MET: Today = Today {
    held: 0.0,
    too_strong: 0,
    stalled: false,
};
/// With forces of the dissertation, which bring a node out of a tool within one step, however short that is. The bound is what was seen, not derived: 1.19 N in 2 of 217 ticks in contact of thrusts on push-strip, none before tools
/// stopped within their budget; why is not known.
const IN_ONE_STEP: Today = Today {
    too_strong: 2,
    ..MET
};
/// Thrusts push with all of the force that a hand has, `hand_force` of levels, 1 N, and with what they set in motion: 1.05 N at most. The bound is what was seen, not derived: 12 of 165 ticks in contact.
const WITH_ALL_FORCE: Today = Today {
    too_strong: 12,
    ..MET
};
/// Fraction of ticks over their budget. Wanted: 0.001.
const OVER_BUDGET: Option<f64> = None;

fn player(module: &str, level: &LevelName, profile: Profile) -> Player {
    Player {
        module: module.to_owned(),
        level: level.clone(),
        profile,
        seed: SEED,
        seconds: SECONDS,
    }
}

/// What holds for every run, whatever the hands did.
fn check(outcome: &Outcome, stage: &Stage, today: Today) {
    let name = outcome.player.name();
    assert!(
        !matches!(outcome.ended, Ended::Broken(_)),
        "{name}: {:?}",
        outcome.ended
    );
    assert!(!outcome.verdict.is_empty(), "{name}: no report");
    assert!(outcome.is_finite, "{name}: a force is not finite");
    assert!(outcome.costs.count() > 0, "{name}: no CPU times");
    assert_eq!(outcome.solver.is_some(), stage.tissue.is_some(), "{name}");
    if let Some(solver) = outcome.solver {
        assert!(solver.worst_residual.is_finite(), "{name}");
        // One record a tick.
        assert_eq!(solver.ticks, outcome.ticks(stage), "{name}");
        let share = |count: u64| count as f64 / solver.ticks as f64;
        let held = solver.held;
        assert!(share(held) <= today.held, "{name}: {held} held");
        if let Some(most) = OVER_BUDGET {
            let over = solver.over_budget;
            assert!(
                over.is_some_and(|over| share(over) <= most),
                "{name}: {over:?}"
            );
        }
    }
    assert!(
        outcome.too_strong <= today.too_strong,
        "{name}: {} forces above {ABSURD_FORCE} N",
        outcome.too_strong
    );
    let is_stalled = outcome.ended == Ended::Stalled;
    assert!(!is_stalled || today.stalled, "{name}: too slow");
    // What passes has done the task.
    if outcome.verdict == "passed" {
        assert_eq!(outcome.targets[0], outcome.targets[1], "{name}");
        let by = &outcome.passed_by;
        assert!(!by.contains("cut-distance not measured"), "{name}: {by}");
    }
}

/// Every run ends with a report, its forces are finite, the solver speaks in every tick, and sessions verify.
#[test]
fn random_hands_end_with_a_report() {
    for (number, (module, level, profile, today)) in SAMPLE.into_iter().enumerate() {
        let level: LevelName = level.parse().expect("a level");
        let player = player(module, &level, profile);
        let stage = Stage::read(module, &level).expect("a level");
        let folder = scratch();
        let (outcome, session): (Outcome, PathBuf) =
            play(&player, &stage, folder.path(), Guard::default()).expect("a run");
        eprintln!("{outcome:?}");
        check(&outcome, &stage, today);
        // A player that hovers shows nothing. One that has ended its level may do so in an act.
        let has_acted = outcome.acts[1] > 0 || outcome.simulated < SECONDS;
        let has_touched = outcome.contact > 0 && has_acted;
        assert_eq!(has_touched, stage.tissue.is_some(), "{}", player.name());
        if number < VERIFIED {
            assert_verified(&session);
        }
    }
}

/// The box about a block is that of its file; that about a tube of ten sides is its outer radius (0.4 + 0.1 + 0.06 mm) across, and its length along.
#[test]
fn players_see_where_the_tissue_lies() {
    let half = |module: &str| {
        let level = "4".parse().expect("a level");
        let stage = Stage::read(module, &level).expect("a level");
        stage.tissue.expect("tissue")[1] * 1e3
    };
    let block = half("push-strip");
    assert!(
        (block - Vector3::new(4.0, 1.0, 0.3)).amax() < 1e-9,
        "{block}"
    );
    let tube = half("diagonal-cut");
    let within = |half: f64| (0.56 * libm::cos(0.1 * PI) - 1e-9..=0.56 + 1e-9).contains(&half);
    assert!(
        within(tube.y) && within(tube.z) && (tube.x - 2.0).abs() < 1e-9,
        "{tube}"
    );
}

/// Every level with tools has its players; the same player writes the same script, another seed another one, and full closures are
/// where jaws close.
#[test]
fn players_are_functions_of_their_seed() {
    let stages = stages().expect("levels");
    let mut modules: Vec<&str> = stages
        .iter()
        .map(|(stage, _)| stage.module.as_str())
        .collect();
    modules.dedup();
    assert_eq!(
        modules,
        [
            "coordination",
            "diagonal-cut",
            "dilatation",
            "guide-path",
            "push-strip",
            "touch-spheres",
            "trim-blunt",
            "trim-sharp"
        ]
    );
    for (stage, permitted) in &stages {
        for profile in permitted {
            let player = player(&stage.module, &stage.level, *profile);
            let (text, tracks) = script(&player, stage);
            assert!(text == script(&player, stage).0, "{}", player.name());
            let other = Player {
                seed: SEED + 1,
                ..player.clone()
            };
            assert!(text != script(&other, stage).0, "{}", player.name());
            let acts: usize = tracks.iter().map(|track| track.acts.len()).sum();
            assert!(acts > 0, "{}: it does nothing", player.name());
            let closures: usize = tracks.iter().map(|track| track.closures.len()).sum();
            assert!(
                *profile != Profile::Closing || closures > 0,
                "{}",
                player.name()
            );
        }
    }
}
