//! Export, import, rebuild.

use crate::*;

/// Everything goes out and comes in again; a second import adds nothing.
#[test]
fn an_export_is_the_whole_store() {
    let scratch = scratch();
    let store = full(&scratch, 40);
    let (document, losses) = store.export();
    assert_eq!(losses, [""; 0]);
    assert_eq!(document.sessions.len(), 40);
    assert_eq!(
        document
            .sessions
            .iter()
            .map(|s| s.values.len())
            .sum::<usize>(),
        80
    );
    let other = crate::scratch();
    let mut copy = open(&other);
    let imported = copy.import(&document).expect("imported");
    assert_eq!(
        (imported.trainees, imported.sessions, imported.courses),
        (5, 40, 1)
    );
    assert_eq!(copy.export().0, document);
    let again = copy.import(&document).expect("imported");
    assert_eq!((again.trainees, again.sessions, again.courses), (0, 0, 0));
    let of = document.clone().of_trainee(id(3));
    assert_eq!(
        (of.trainees.len(), of.groups.len(), of.sessions.len()),
        (1, 0, 8)
    );
    assert_eq!(of.courses[0].unlocked.len(), 1);
}

/// After a rebuild from sessions alone names are missing; the export gives them back.
#[test]
fn names_come_back_from_an_export() {
    let scratch = scratch();
    let (document, _) = full(&scratch, 10).export();
    let other = crate::scratch();
    let mut store = open(&other);
    let sessions: Vec<Session> = (0..10)
        .map(|n| session(n, Some(n % 5 + 1), n % 3 > 0))
        .collect();
    assert_eq!(store.rebuild(&sessions), Ok(0));
    assert!(
        store
            .trainees(None)
            .expect("a list")
            .iter()
            .all(|t| t.trainee.name.is_none())
    );
    let imported = store.import(&document).expect("imported");
    assert_eq!((imported.trainees, imported.sessions), (5, 0));
    let names: Vec<_> = store
        .trainees(None)
        .expect("a list")
        .into_iter()
        .filter_map(|t| t.trainee.name)
        .collect();
    assert_eq!(names[0], "Trainee 1");
    // Another trainee has one of the names meanwhile.
    let third = crate::scratch();
    let mut store = open(&third);
    store.add_trainee(&trainee(77, "Trainee 2")).expect("added");
    assert!(matches!(
        store.import(&document),
        Err(StoreError::Refused(_))
    ));
    assert_eq!(store.trainees(None).expect("a list").len(), 1);
}

#[test]
fn a_rebuild_leaves_results_whose_files_are_gone() {
    let scratch = scratch();
    let mut store = full(&scratch, 10);
    let (before, _) = store.export();
    let sessions: Vec<Session> = (3..10)
        .map(|n| session(n, Some(n % 5 + 1), n % 3 > 0))
        .collect();
    assert_eq!(store.rebuild(&sessions), Ok(3));
    assert_eq!(store.export().0, before);
    // Another session lies at the path of one now.
    let mut other = session(3, Some(4), true);
    other.id = id(999);
    assert_eq!(store.rebuild(&[other]), Ok(9));
}

#[test]
fn runs_that_begin_are_known_until_they_are_entered() {
    let scratch = scratch();
    let mut store = open(&scratch);
    let run = |number: u64| Pending {
        path: format!("/sessions/{number}.session"),
        process: 7,
        process_started: 8,
    };
    store.begin(&run(1)).expect("noted");
    store.begin(&run(2)).expect("noted");
    assert_eq!(store.pending(), Ok(vec![run(1), run(2)]));
    store.enter(&[session(1, None, true)]).expect("entered");
    assert_eq!(store.pending(), Ok(vec![run(2)]));
    store.forget_pending(&[run(2).path]).expect("forgotten");
    assert_eq!(store.pending(), Ok(Vec::new()));
}

#[test]
fn names_of_any_kind_are_stored_as_they_are() {
    let scratch = scratch();
    let mut store = open(&scratch);
    for (number, name) in awkward().iter().enumerate() {
        store
            .add_trainee(&trainee(number as u64, name))
            .expect(name);
        store
            .change_group(&format!("group {number} ';--"), &[id(number as u64)], &[])
            .expect(name);
    }
    for (number, name) in awkward().iter().enumerate() {
        let found = store.find_trainee(name).expect("found");
        assert_eq!(found, Found::One(trainee(number as u64, name)), "{name:?}");
    }
    let (document, losses) = store.export();
    assert!(losses.is_empty(), "{losses:?}");
    let text = serde_json::to_string(&document).expect("JSON");
    let read = serde_json::from_str(&text).expect("the same");
    assert_eq!(document, read);
    let other = crate::scratch();
    let mut copy = open(&other);
    copy.import(&read).expect("imported");
    assert_eq!(copy.export().0, document);
}
