//! What is erased, damaged, or written by several at once.

use crate::*;
use std::fs;
use std::path::Path;

/// All bytes of the store's files.
fn bytes(path: &Path) -> Vec<u8> {
    let files = ["", "-wal", "-shm"].map(|end| {
        let mut name = path.as_os_str().to_owned();
        name.push(end);
        fs::read(name).unwrap_or_default()
    });
    files.concat()
}

fn holds(path: &Path, text: &str) -> bool {
    bytes(path)
        .windows(text.len())
        .any(|window| window == text.as_bytes())
}

#[test]
fn what_is_erased_is_in_no_byte_of_the_store() {
    let scratch = scratch();
    let mut store = full(&scratch, 50);
    store
        .add_trainee(&trainee(90, "Unforgettable Name"))
        .expect("added");
    store
        .enter(&[session(90, Some(90), true)])
        .expect("entered");
    let hex = id(90).to_string();
    let of_session = session(90, None, true).id.to_string();
    assert!(holds(&scratch.path, "Unforgettable") && holds(&scratch.path, &hex));
    store.erase(id(90), 5_000, 4).expect("erased");
    for gone in ["Unforgettable", &hex, &of_session] {
        assert!(!holds(&scratch.path, gone), "{gone}");
    }
    assert_eq!(store.trainee(id(90)), Ok(None));
    let erasures = store.erasures().expect("a log");
    assert_eq!(
        (erasures.len(), erasures[0].sessions, erasures[0].files),
        (1, 1, 4)
    );
    store.anonymise(id(1), 6_000).expect("anonymised");
    assert!(!holds(&scratch.path, "Trainee 1"));
    assert_eq!(
        store.trainee(id(1)).expect("there").map(|t| t.name),
        Some(None)
    );
    let filter = Filter {
        trainee: Some(id(1)),
        ..Filter::default()
    };
    assert_eq!(store.results(&filter, false).map(|r| r.len()), Ok(10));
    assert!(store.erase(id(90), 7_000, 0).is_err());
}

/// Two writers at once, each with a connection of its own, from an empty file: nothing is lost and nobody is turned away.
#[test]
fn writers_at_the_same_time_wait_for_each_other() {
    let scratch = scratch();
    std::thread::scope(|scope| {
        for writer in 0..4_u64 {
            let path = &scratch.path;
            scope.spawn(move || {
                for n in 0..25 {
                    let mut store = Store::open(path).expect("a store");
                    store
                        .enter(&[session(writer * 100 + n, Some(writer), true)])
                        .expect("entered");
                }
            });
        }
    });
    let store = open(&scratch);
    assert_eq!(
        store.results(&Filter::default(), false).map(|r| r.len()),
        Ok(100)
    );
    assert_eq!(store.check(), Ok(Vec::new()));
}

/// The first openings of a file at the same time: one makes the tables, and none takes the file of the other for somebody else's.
#[test]
fn a_store_that_another_is_making_is_waited_for() {
    for _ in 0..40 {
        let scratch = scratch();
        let opened = std::thread::scope(|scope| {
            let path = &scratch.path;
            let openings: Vec<_> = (0..8)
                .map(|_| scope.spawn(|| Store::open(path).map(|store| store.version())))
                .collect();
            openings
                .into_iter()
                .map(|opening| opening.join().expect("no panic"))
                .collect::<Vec<_>>()
        });
        for version in opened {
            assert_eq!(version, Ok(open(&scratch).version()));
        }
    }
}

/// Pages overwritten with noise, one after the other: the damage is found, or it fell on an unused page; nothing panics, and what can be read is as
/// it was. A quarter of the pages are tried.
#[test]
fn a_damaged_store_gives_what_is_intact() {
    let scratch = scratch();
    let mut store = full(&scratch, 300);
    store.vacuum().expect("written");
    let (whole, _) = store.export();
    drop(store);
    let good = fs::read(&scratch.path).expect("a file");
    let page = 4096;
    let pages = good.len() / page;
    assert!(pages > 20, "{pages}");
    let (mut found, mut partly, mut closed) = (0, 0, 0);
    for at in (1..pages).step_by(4) {
        let mut bad = good.clone();
        for (k, byte) in bad[at * page..(at + 1) * page].iter_mut().enumerate() {
            *byte = (k * 31 + at * 7) as u8 | 1;
        }
        let damaged = crate::scratch();
        fs::write(&damaged.path, &bad).expect("written");
        let store = match Store::open_to_read(&damaged.path) {
            Ok(Some(store)) => store,
            // It held what the tables are: no row can be found without.
            Err(StoreError::Damaged(_)) => {
                closed += 1;
                continue;
            }
            other => panic!("page {at}: {other:?}"),
        };
        let problems = store.check().expect("checked");
        assert!(!problems.is_empty(), "page {at} of {pages} was not missed");
        found += 1;
        let (document, losses) = store.export();
        for entry in &document.sessions {
            let original = whole
                .sessions
                .iter()
                .find(|s| s.session.id == entry.session.id);
            let original = original.expect("no session is made up");
            // Its trainee, scores or values may be lost, but none is another's.
            assert_eq!(entry.session.path, original.session.path);
            assert!(
                entry.session.trainee.is_none()
                    || entry.session.trainee == original.session.trainee
            );
            assert!(entry.values.iter().all(|v| original.values.contains(v)) || !losses.is_empty());
        }
        // Indices can be made again from the tables: what is only in them costs nothing.
        partly +=
            usize::from(losses.is_empty() == (document == whole) && !document.sessions.is_empty());
    }
    println!("{found} of {pages} pages damaged, {partly} exports complete or with stated losses");
    assert_eq!(found, partly);
    assert!(closed <= 2 && found > 4 * closed, "{closed} of {found}");
}

#[test]
fn a_file_that_is_no_database_is_called_damaged_and_stays() {
    let scratch = scratch();
    let text = "not a database, but long enough to have a header of one hundred bytes".repeat(4);
    fs::write(&scratch.path, &text).expect("written");
    for opened in [
        Store::open(&scratch.path).map(drop),
        Store::open_to_read(&scratch.path).map(drop),
    ] {
        assert!(matches!(opened, Err(StoreError::Damaged(_))), "{opened:?}");
    }
    assert_eq!(fs::read_to_string(&scratch.path).expect("a file"), text);
}
