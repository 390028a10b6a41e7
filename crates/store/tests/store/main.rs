//! The store as its callers see it. Expected values are counted by hand, or are what was put in.

mod damage;
mod documents;

use microsim_store::{
    Course, Enrolled, Filter, Found, Id, Measured, Metric, Pending, PopulationRecord, Role,
    Session, Step, Store, StoreError, Trainee, Verdict,
};
use std::path::PathBuf;

/// An id that a number names.
fn id(number: u64) -> Id {
    let mut bytes = [0; 16];
    bytes[..8].copy_from_slice(&number.to_be_bytes());
    // Spread, so that ids are not in the order of numbers.
    bytes[8..].copy_from_slice(&number.wrapping_mul(0x9e37_79b9_7f4a_7c15).to_be_bytes());
    bytes.rotate_left(8);
    Id::from_random(bytes)
}

fn trainee(number: u64, name: &str) -> Trainee {
    Trainee {
        id: id(number),
        name: Some(name.into()),
        role: Role::Trainee,
        created: 1_000,
    }
}

fn measured(name: &str, value: Option<f64>) -> Measured {
    Measured {
        metric: Metric {
            id: name.into(),
            title: format!("The {name}"),
            unit: "m".into(),
            display_unit: "mm".into(),
            display_factor: 1e3,
            direction: "lower-is-better".into(),
            category: "efficiency".into(),
            formula: format!("{name}/1"),
        }
        .into(),
        value,
        min: None,
        max: Some(0.5),
        decides: Some(true),
        within: value.map(|v| v <= 0.5),
        score: value.map(|v| 100.0 - v),
    }
}

fn session(number: u64, trainee: Option<u64>, passed: bool) -> Session {
    Session {
        id: id(1_000_000 + number),
        path: format!("/sessions/{number}.session"),
        trainee: trainee.map(id),
        module: "touch-spheres".into(),
        level: 1,
        started: 10_000 + number as i64,
        started_subsec_ns: 0,
        simulated: 12.5,
        finished: true,
        seed: u64::MAX - number,
        input: "script:a.toml".into(),
        version: "0.3.0".into(),
        realtime: false,
        synthetic: None,
        state_hash: Some("00ff".into()),
        verdict: if passed {
            Verdict::Passed
        } else {
            Verdict::Failed
        },
        counts: true,
        failed: if passed {
            Vec::new()
        } else {
            vec!["too-slow".into(), "depth".into()]
        },
        duration: 12.0,
        targets_done: 5,
        targets: 6,
        score: Some(81.25),
        categories: vec![("efficiency".into(), 80.0), ("target".into(), 82.5)],
        metrics: vec![
            measured("path-length", Some(0.1 + 0.2)),
            measured("tremor", None),
        ],
    }
}

struct Scratch {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

fn scratch() -> Scratch {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("store.sqlite");
    Scratch {
        _folder: folder,
        path,
    }
}

fn open(scratch: &Scratch) -> Store {
    Store::open(&scratch.path).expect("a store")
}

/// Names of any script, with quotes, line ends, formulas, NUL, marks of direction, and very long ones.
fn awkward() -> Vec<String> {
    let mut names: Vec<String> = [
        "A. Muster",
        "李 小龍",
        "محمد بن سلمان",
        "Зоя \"Зойка\" О'Брайен",
        "Robert'); DROP TABLE trainee;--",
        "=HYPERLINK(\"http://x\")",
        "+49 30 1",
        "@SUM(A1)",
        "-2+3",
        "line\nbreak\r\nand\ttab",
        "nul\0inside",
        "\u{1b}]0;title\u{7}",
        "\u{202e}gnirts\u{2066}",
        "'leading apostrophe",
        "👩🏽‍⚕️ e\u{301} \u{feff}",
        "%_*?[a]",
    ]
    .map(String::from)
    .into();
    names.push("x".repeat(10_000));
    names
}

#[test]
fn what_is_entered_is_found_again_to_the_bit() {
    let scratch = scratch();
    let mut store = open(&scratch);
    store.add_trainee(&trainee(1, "A. Muster")).expect("added");
    let mut sessions = vec![
        session(1, Some(1), true),
        session(2, Some(2), false),
        session(3, None, true),
    ];
    sessions[2].synthetic = Some("novice, seed 3".into());
    store.enter(&sessions).expect("entered");
    let found = store.results(&Filter::default(), true).expect("results");
    let names: Vec<Option<&str>> = found.iter().map(|n| n.name.as_deref()).collect();
    assert_eq!(names, [Some("A. Muster"), None, None]);
    let found: Vec<Session> = found.into_iter().map(|n| n.session).collect();
    assert_eq!(found, sessions);
    // Entered once more with another verdict: it takes the place of the first.
    sessions[0].verdict = Verdict::Failed;
    sessions[0].metrics.truncate(1);
    store.enter(&sessions[..1]).expect("entered");
    let found = store.results(&Filter::default(), true).expect("results");
    assert_eq!((found.len(), &found[0].session), (3, &sessions[0]));
}

/// Sessions of one second are in the order of their starts, whatever their ids are.
#[test]
fn sessions_of_one_second_have_an_order() {
    let scratch = scratch();
    let mut store = open(&scratch);
    let mut sessions = vec![session(2, None, true), session(1, None, false)];
    sessions.sort_by_key(|session| std::cmp::Reverse(session.id));
    for (session, ns) in sessions.iter_mut().zip([1, 999_999_999]) {
        session.started = 10_000;
        session.started_subsec_ns = ns;
    }
    store.enter(&sessions).expect("entered");
    let found = store.results(&Filter::default(), true).expect("results");
    let found: Vec<Session> = found.into_iter().map(|n| n.session).collect();
    assert_eq!(found, sessions);
}

#[test]
fn filters_find_what_they_name() {
    let scratch = scratch();
    let mut store = open(&scratch);
    for (number, name) in [(1, "A"), (2, "B"), (3, "C")] {
        store.add_trainee(&trainee(number, name)).expect("added");
    }
    store
        .change_group("2026", &[id(1), id(3)], &[])
        .expect("a group");
    let mut sessions: Vec<Session> = (0..6).map(|n| session(n, Some(n % 3 + 1), true)).collect();
    sessions[3].level = 2;
    sessions[4].module = "push-strip".into();
    store.enter(&sessions).expect("entered");
    let count = |filter: Filter| store.results(&filter, false).map(|found| found.len());
    let all = Filter::default();
    assert_eq!(
        count(Filter {
            trainee: Some(id(1)),
            ..all.clone()
        }),
        Ok(2)
    );
    assert_eq!(
        count(Filter {
            group: Some("2026".into()),
            ..all.clone()
        }),
        Ok(4)
    );
    assert_eq!(
        count(Filter {
            module: Some("touch-spheres".into()),
            level: Some(1),
            ..all.clone()
        }),
        Ok(4)
    );
    assert_eq!(
        count(Filter {
            since: Some(10_004),
            ..all.clone()
        }),
        Ok(2)
    );
    assert_eq!(
        count(Filter {
            trainee: Some(id(9)),
            ..all.clone()
        }),
        Ok(0)
    );
    let unknown = count(Filter {
        group: Some("2025".into()),
        ..all
    })
    .expect_err("no such group");
    assert!(unknown.to_string().contains("there are: 2026"), "{unknown}");
    let text = sessions[2].id.to_string();
    assert_eq!(
        store.find_session(&text[..12]).map(|n| n.session.path),
        Ok("/sessions/2.session".into())
    );
    assert_eq!(
        store
            .find_session("/sessions/5.session")
            .map(|n| n.session.id),
        Ok(sessions[5].id)
    );
    assert!(store.find_session("%").is_err() && store.find_session("").is_err());
}

#[test]
fn trainees_are_found_by_name_and_id_or_named_nearly() {
    let scratch = scratch();
    let mut store = open(&scratch);
    store.add_trainee(&trainee(1, "A. Muster")).expect("added");
    assert_eq!(
        store.find_trainee("A. Muster"),
        Ok(Found::One(trainee(1, "A. Muster")))
    );
    assert_eq!(
        store.find_trainee(&id(1).to_string()),
        Ok(Found::One(trainee(1, "A. Muster")))
    );
    assert_eq!(
        store.find_trainee("a muster"),
        Ok(Found::Nobody(vec!["A. Muster".into()]))
    );
    assert_eq!(store.find_trainee("Z"), Ok(Found::Nobody(Vec::new())));
    for refused in [
        trainee(2, "A. Muster"),
        trainee(1, "B"),
        trainee(3, "  "),
        trainee(4, &id(7).to_string()),
    ] {
        assert!(
            matches!(store.add_trainee(&refused), Err(StoreError::Refused(_))),
            "{refused:?}"
        );
    }
    store.rename(id(1), "A. Beispiel").expect("renamed");
    store.set_role(id(1), Role::Instructor).expect("set");
    let listed = store.trainees(None).expect("a list");
    assert_eq!(listed.len(), 1);
    assert_eq!(listed[0].trainee.name.as_deref(), Some("A. Beispiel"));
    assert_eq!(listed[0].trainee.role, Role::Instructor);
}

fn course(passes: u32) -> Course {
    let step = |module: &str, level| Step {
        module: module.into(),
        level,
        passes,
    };
    Course {
        name: "basics".into(),
        title_en: "Basics".into(),
        title_de: "Grundlagen".into(),
        in_order: true,
        steps: vec![
            step("touch-spheres", 1),
            step("touch-spheres", 2),
            step("push-strip", 1),
        ],
    }
}

/// Fail, pass, pass: mastered with the third; an aborted run in between changes nothing, a synthetic one neither.
#[test]
fn a_course_opens_level_by_level() {
    let scratch = scratch();
    let mut store = open(&scratch);
    store.add_trainee(&trainee(1, "A")).expect("added");
    store.change_group("2026", &[id(1)], &[]).expect("a group");
    store.put_course(&course(2)).expect("a course");
    store
        .enrol("basics", &Enrolled::Group("2026".into()))
        .expect("enrolled");
    assert_eq!(store.participants("basics"), Ok(vec![id(1)]));
    assert_eq!(store.courses_of(id(1)), Ok(vec!["basics".into()]));
    let open_steps = |store: &Store| {
        let progress = store.progress("basics", id(1)).expect("progress");
        progress.steps.iter().map(|s| s.open).collect::<Vec<_>>()
    };
    assert_eq!(open_steps(&store), [true, false, false]);
    let mut aborted = session(3, Some(1), false);
    (aborted.verdict, aborted.counts) = (Verdict::Aborted, false);
    let mut synthetic = session(1, Some(1), true);
    synthetic.synthetic = Some("expert".into());
    store
        .enter(&[
            session(0, Some(1), false),
            synthetic,
            session(2, Some(1), true),
            aborted,
        ])
        .expect("entered");
    let progress = store.progress("basics", id(1)).expect("progress");
    assert_eq!(
        (
            progress.steps[0].attempts,
            progress.steps[0].row,
            progress.steps[0].mastered_with
        ),
        (2, 1, None)
    );
    store
        .enter(&[session(4, Some(1), true), session(5, Some(1), false)])
        .expect("entered");
    let progress = store.progress("basics", id(1)).expect("progress");
    assert_eq!(
        (progress.steps[0].attempts, progress.steps[0].mastered_with),
        (4, Some(3))
    );
    assert_eq!(open_steps(&store), [true, true, false]);
    assert_eq!(progress.next().map(|s| s.step.level), Some(2));
    store
        .unlock("basics", id(1), "push-strip", 1)
        .expect("unlocked");
    assert_eq!(open_steps(&store), [true, true, true]);
    assert!(store.unlock("basics", id(1), "push-strip", 9).is_err());
    // Put once more: who takes it and what is unlocked stays.
    store.put_course(&course(1)).expect("a course");
    assert_eq!(open_steps(&store), [true, true, true]);
    store
        .leave("basics", &Enrolled::Group("2026".into()))
        .expect("left");
    assert_eq!(store.participants("basics"), Ok(Vec::new()));
}

fn full(scratch: &Scratch, sessions: u64) -> Store {
    let mut store = open(scratch);
    for number in 1..=5 {
        store
            .add_trainee(&trainee(number, &format!("Trainee {number}")))
            .expect("added");
    }
    store
        .change_group("2026", &[id(1), id(2)], &[])
        .expect("a group");
    store.put_course(&course(2)).expect("a course");
    store
        .enrol("basics", &Enrolled::Group("2026".into()))
        .expect("enrolled");
    store
        .enrol("basics", &Enrolled::Trainee(id(3)))
        .expect("enrolled");
    store
        .unlock("basics", id(3), "push-strip", 1)
        .expect("unlocked");
    let population = PopulationRecord {
        module: "touch-spheres".into(),
        level: 1,
        metric: "path-length".into(),
        source: "experts".into(),
        n: 12,
        mean: Some(0.3),
        deviation: Some(0.1),
        percentiles: vec![(10.0, 0.2), (90.0, 0.4)],
    };
    store.put_populations(&[population]).expect("a population");
    let all: Vec<Session> = (0..sessions)
        .map(|n| session(n, Some(n % 5 + 1), n % 3 > 0))
        .collect();
    store.enter(&all).expect("entered");
    store
        .attach(all[0].id, &["/pictures".into()], &[])
        .expect("attached");
    store
}

/// By hand: each file has one session at any time, that which wrote it last, unless it lies beside that one.
#[test]
fn a_file_belongs_to_the_session_that_wrote_it_last() {
    let scratch = scratch();
    let mut store = open(&scratch);
    let sessions = [session(1, Some(1), true), session(2, Some(2), true)];
    store.enter(&sessions).expect("entered");
    let [a, b] = sessions.map(|session| session.id);
    let page = ["/page.html".to_owned()];
    store.attach(a, &page, &[]).expect("attached");
    store.attach(b, &page, &[]).expect("attached");
    assert_eq!(
        (store.attached(a), store.attached(b)),
        (Ok(Vec::new()), Ok(page.to_vec()))
    );
    assert_eq!(store.is_of_another(&page[0], id(1)), Ok(true));
    assert_eq!(store.is_of_another(&page[0], id(2)), Ok(false));
    store.attach(a, &page, &page).expect("attached");
    assert_eq!(store.attached(b), Ok(Vec::new()));
    assert_eq!(store.is_of_another(&page[0], id(1)), Ok(false));
}

#[test]
fn populations_are_held_to_what_a_distribution_is() {
    let scratch = scratch();
    let mut store = open(&scratch);
    let record = PopulationRecord {
        module: "a".into(),
        level: 1,
        metric: "time".into(),
        source: "x".into(),
        n: 3,
        mean: None,
        deviation: None,
        percentiles: vec![(10.0, 2.0), (90.0, 1.0)],
    };
    assert!(matches!(
        store.put_populations(&[record]),
        Err(StoreError::Refused(_))
    ));
    assert_eq!(store.populations(None), Ok(Vec::new()));
}
