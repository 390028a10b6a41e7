//! Ten shipped runs give the recorded physics, state hash and result to the bit, on this machine as on the one that recorded them.
//!
//! Expected values: `tests/results/digests.csv`, which `cargo xtask soak digests -- --record` writes. Here are all modules, cuts,
//! explicit, implicit and static methods, one thread and two, bodies that are large enough for forces to be computed in parts
//! (4,096 tetrahedra: `two-tubes-fine`, explicit, and `tube-pressure`, implicit), and one run with both numbers of threads.

use microsim_tests::digests::{Row, Subject, file, from_csv};
use microsim_tests::scratch;
use std::sync::Mutex;

/// What is run, and with how many threads; the long ones first.
const RUNS: [(&str, usize); 10] = [
    ("coordination/level4-pass", 1),
    ("coordination/level4-pass", 2),
    ("push-strip/level4-pass", 1),
    ("push-strip/level3-pass", 2),
    ("scenes/cut-moving", 1),
    ("scenes/cantilever-dynamic", 1),
    ("scenes/two-tubes-fine", 2),
    ("scenes/vessel-two-tools", 2),
    ("scenes/tube-pressure", 2),
    ("touch-spheres/level5-pass", 1),
];

/// Runs at the same time.
const WORKERS: usize = 2;

/// What is wrong with a run, if anything is, and the command that accepts it.
fn complaint(recorded: &Row, found: &Row, threads: usize) -> Option<String> {
    let name = found.subject.name();
    let accept = format!("`cargo xtask soak digests -- --record {name}`");
    if recorded.physics_digest != found.physics_digest || recorded.result != found.result {
        return Some(format!(
            "{name}, {threads} threads: other physics: {} ({}), recorded are {} ({}). Physics must not change without a reason: \
             find the change that did this; if it is meant, {accept} accepts it, and the commit gives the reason",
            found.physics_digest, found.result, recorded.physics_digest, recorded.result
        ));
    }
    (recorded.state_hash != found.state_hash).then(|| {
        format!(
            "{name}, {threads} threads: the same physics, but state hash {} where {} is recorded: what is saved or published has other \
             names or another encoding; if that is meant, {accept} accepts it, and sessions recorded before need their own version",
            found.state_hash, recorded.state_hash
        )
    })
}

#[test]
fn ten_runs_are_as_recorded() {
    let path = file();
    let recorded =
        std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let recorded = from_csv(&recorded)
        .unwrap_or_else(|line| panic!("{}, line {line}: not a row of digests", path.display()));
    let folder = scratch();
    let open = Mutex::new(RUNS.iter().rev().copied().collect::<Vec<_>>());
    let complaints = Mutex::new(Vec::new());
    let work = || {
        while let Some((name, threads)) = { open.lock().expect("no panic").pop() } {
            let subject = Subject::from_name(name).expect("a folder and a name");
            let row = recorded.iter().find(|row| row.subject == subject);
            let row = row.unwrap_or_else(|| panic!("{name} is not in {}", path.display()));
            let found = subject.run(folder.path(), threads);
            let complaint = complaint(row, &found, threads);
            complaints.lock().expect("no panic").extend(complaint);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..WORKERS {
            scope.spawn(work);
        }
    });
    let complaints = complaints.into_inner().expect("no panic");
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

/// The comparison finds each difference, and names it.
#[test]
fn a_difference_is_found() {
    let row = Row {
        subject: Subject::Scene("drop".into()),
        physics_digest: "a".into(),
        state_hash: "b".into(),
        result: "ok".into(),
    };
    assert_eq!(complaint(&row, &row, 1), None);
    let mut other = row.clone();
    other.state_hash = "c".into();
    let found = complaint(&row, &other, 1).expect("another state hash");
    assert!(
        found.contains("same physics") && found.contains("--record scenes/drop"),
        "{found}"
    );
    let changes: [fn(&mut Row); 2] = [
        |row| row.physics_digest = "c".into(),
        |row| row.result = "diverged".into(),
    ];
    for change in changes {
        let mut other = row.clone();
        change(&mut other);
        let found = complaint(&row, &other, 2).expect("other physics");
        assert!(
            found.contains("must not change without a reason"),
            "{found}"
        );
    }
}
