//! What passes a level passes because the tissue answers: a sample of `cargo xtask soak matrix`, and what holds for all of it.

use microsim_tests::matrix::{Entry, Lever, PASSED, entries, passes};
use microsim_tests::{run, scratch, tree};
use std::collections::BTreeSet;
use std::sync::Mutex;

/// Levels of the sample, by module: those that cost least and have each of [`Lever::ALL`] where it decides. Levels of push-strip and coordination are in `modules.rs`.
const SAMPLE: [(&str, u32); 4] = [
    ("trim-blunt", 1),
    ("diagonal-cut", 3),
    ("diagonal-cut", 4),
    ("dilatation", 2),
];

fn sample() -> Vec<Entry> {
    let is_in = |entry: &Entry| SAMPLE.contains(&(entry.module.as_str(), entry.level));
    entries().into_iter().filter(is_in).collect()
}

#[test]
fn what_a_level_uses_it_is_not_passed_without() {
    let folder = scratch();
    let sample = sample();
    let levers: BTreeSet<Lever> = sample.iter().map(|entry| entry.without).collect();
    assert_eq!(levers, Lever::ALL.into(), "the sample has all of them");
    let open = Mutex::new(sample);
    let work = || {
        loop {
            let next = open.lock().expect("no thread panics with it").pop();
            let Some(entry) = next else {
                return;
            };
            let found = entry.play(folder.path());
            println!("{}: {found:?}", entry.name());
            assert_eq!(
                found.verdict == "passed",
                passes(&entry).is_some(),
                "{}: {found:?}",
                entry.name()
            );
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
}

/// Levels without tissue have nothing to be played without, and come out the same whatever is left out.
#[test]
fn a_level_without_tissue_does_not_depend_on_it() {
    let folder = scratch();
    assert!(entries().iter().all(|of| of.module != "guide-path"));
    let script = tree().join("modules/guide-path/scripts/level1-pass.toml");
    let input = format!("script:{}", script.display());
    let play = |name: &str, more: &[&str]| {
        let session = folder.path().join(format!("{name}.session"));
        let args = ["--level", "1", "--no-pictures", "--input", &input];
        run("guide-path", &session, &[&args[..], more].concat())
    };
    let whole = play("whole", &[]);
    let args = ["physics", "friction", "lonor"].map(|what| ["--without", what]);
    let without = play("without", &args.concat());
    assert_eq!(without["counts"], false);
    for key in ["verdict", "score", "failed", "ticks", "physics_digest"] {
        assert_eq!(whole[key], without[key], "{key}");
    }
    assert_eq!(whole["verdict"], "passed");
}

/// What is known to be passed is there.
#[test]
fn what_is_passed_all_the_same_is_something_that_a_level_has() {
    let entries = entries();
    for (module, levels, without, _) in PASSED {
        for level in *levels {
            let entry = Entry {
                module: (*module).to_owned(),
                level: *level,
                without: *without,
            };
            assert!(entries.contains(&entry), "{}", entry.name());
        }
    }
}
