//! Session files that are cut, damaged, or none: what was complete is recovered, and what is wrong is placed.

use crate::tree::Tree;
use crate::{run, tree};
use microsim_host::record::{Session, kind};
use microsim_session::{Frame, KIND_END};

/// Bytes before the first frame, as the crate `session` documents them.
const PRELUDE: usize = 21;
/// Ticks of the short script: see there.
const TICKS: usize = 7;

/// The session of a short run, and its installation.
fn small() -> (Tree, Vec<u8>) {
    let tree = tree();
    run(&tree, "script:short.toml", &[]).expect(0);
    let bytes = std::fs::read(tree.path("x.session")).expect("read");
    (tree, bytes)
}

/// The frames, and behind them the length of the file.
fn frames(bytes: &[u8]) -> Vec<Frame<'_>> {
    let frames = microsim_session::read(bytes).expect("a session").frames;
    assert_eq!(frames[0].kind, kind::HEADER);
    assert_eq!(
        frames.iter().filter(|f| f.kind == kind::TICK).count(),
        TICKS
    );
    let last = [frames[TICKS + 1].kind, frames[TICKS + 2].kind];
    assert_eq!((frames.len(), last), (TICKS + 3, [kind::CLOSE, KIND_END]));
    frames
}

#[test]
fn every_prefix_gives_what_was_complete() {
    let (_tree, bytes) = small();
    let frames = frames(&bytes);
    let whole = Session::read(&bytes).expect("a session");
    assert_eq!(whole.complaint, None);
    for cut in 0..bytes.len() {
        let complete = frames.iter().skip(1).filter(|f| f.offset <= cut).count();
        let Ok(session) = Session::read(&bytes[..cut]) else {
            assert_eq!(complete, 0, "cut at {cut}");
            continue;
        };
        // A frame is complete where the next one begins.
        assert!(complete >= 1, "cut at {cut}: the header is torn");
        assert_eq!(session.header, whole.header);
        assert!(
            session.ticks == whole.ticks[..TICKS.min(complete - 1)],
            "cut at {cut}"
        );
        assert!(session.end.is_none() && session.failures.is_empty());
        let complaint = session.complaint.expect("something is missing");
        if frames.iter().any(|f| f.offset == cut) {
            assert_eq!(complaint, "the session has no end: its process was killed");
        } else {
            let begins = frames[complete].offset;
            let last = frames[complete - 1].tick;
            let lost = cut - begins;
            let expected = format!(
                "the session breaks off inside a frame at byte {begins}, after tick {last}: {lost} bytes are incomplete"
            );
            assert_eq!(complaint, expected, "cut at {cut}");
        }
    }
}

#[test]
fn a_flipped_bit_in_any_byte_is_noticed_and_placed() {
    let (_tree, mut bytes) = small();
    let original = bytes.clone();
    let frames = frames(&original);
    let whole = Session::read(&original).expect("a session");
    for at in 0..bytes.len() {
        bytes[at] ^= 1 << (at % 8);
        let read = Session::read(&bytes);
        let hit = frames.iter().rposition(|f| f.offset <= at);
        match (hit, read) {
            (None, Err(error)) => {
                assert!(at < PRELUDE, "byte {at}");
                let magic = error
                    .0
                    .starts_with("not a session file: it does not begin with the line");
                let version = error.0.starts_with("a session file of format version ");
                assert!(
                    magic == (at < PRELUDE - 4) && version != magic,
                    "byte {at}: {error}"
                );
            }
            (Some(0), Err(error)) => {
                let place = "it has no complete header, so that nothing can be read: the session is damaged at byte 21, \
                             before its first frame: ";
                assert!(error.0.starts_with(place), "byte {at}: {error}");
            }
            (Some(frame @ 1..), Ok(session)) => {
                let (begins, last) = (frames[frame].offset, frames[frame - 1].tick);
                let place = format!("the session is damaged at byte {begins}, after tick {last}: ");
                let complaint = session.complaint.expect("something is wrong");
                assert!(complaint.starts_with(&place), "byte {at}: {complaint}");
                assert!(
                    session.ticks == whole.ticks[..TICKS.min(frame - 1)],
                    "byte {at}"
                );
            }
            (hit, read) => panic!("byte {at} in frame {hit:?}: {read:?}"),
        }
        bytes[at] = original[at];
    }
}

#[test]
fn cut_sessions_through_the_command_line() {
    let (tree, bytes) = small();
    let frames = frames(&bytes);
    // On and around some borders of frames, and within them.
    let mut cuts: Vec<usize> = frames[1..]
        .iter()
        .step_by(3)
        .flat_map(|f| [f.offset - 1, f.offset, f.offset + 40])
        .collect();
    cuts.push(bytes.len() - 1);
    for cut in cuts {
        let file = format!("cut-{cut}.session");
        let path = tree.write(&file, &bytes[..cut]);
        let session = match Session::read(&bytes[..cut]) {
            Ok(session) => session,
            Err(error) => {
                let printed = tree.microsim(&["report", &file]).expect(2);
                assert_eq!(
                    (printed.out, printed.err),
                    (
                        String::new(),
                        format!("microsim: session {file}: {error}\n")
                    )
                );
                continue;
            }
        };
        let complaint = session.complaint.expect("cut");
        let ticks = session.ticks.len();
        let report = tree.microsim(&["report", &file, "--json"]).expect(0).json();
        assert_eq!(report["session"]["complaint"], complaint);
        let complete = ticks == TICKS;
        // The module's result is in the last tick.
        assert_eq!(
            report["verdict"],
            if complete { "failed" } else { "incomplete" },
            "cut at {cut}"
        );
        assert!(
            tree.microsim(&["report", &file])
                .expect(0)
                .out
                .contains(&complaint)
        );
        let check = tree.microsim(&["check", &file]).expect(1);
        assert!(
            check
                .out
                .contains(&format!("{complaint}; {ticks} complete ticks can be used")),
            "{check:?}"
        );
        let replay = tree
            .microsim(&["replay", &file, "--verify", "--json"])
            // Without a single tick nothing is proven.
            .expect(if ticks == 0 { 1 } else { 0 })
            .json();
        assert_eq!(
            (replay["ticks"].as_u64(), &replay["verified"]),
            (Some(ticks as u64), &(ticks > 0).into())
        );
        assert_eq!(replay["complaint"], complaint);
        let bus = tree.microsim(&["bus", &file, "--json"]).expect(0).json();
        let last = bus
            .as_array()
            .and_then(|rows| rows.last())
            .map(|row| row["tick"].clone());
        assert_eq!(last, session.ticks.last().map(|(tick, _)| (*tick).into()));
        assert_eq!(
            std::fs::read(&path).expect("read"),
            &bytes[..cut],
            "nobody repairs a recording"
        );
    }
}

#[test]
fn files_that_are_no_sessions() {
    let (tree, bytes) = small();
    let mut newer = bytes.clone();
    newer[PRELUDE - 4] += 1;
    // Bytes of a linear congruence: any garbage will do, and the same in each run.
    let mut seed = 1_u32;
    let mut garbage = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 24) as u8
    };
    let random: Vec<u8> = (0..5000).map(|_| garbage()).collect();
    let behind: Vec<u8> = bytes[..PRELUDE]
        .iter()
        .copied()
        .chain(random.iter().copied())
        .collect();
    let none = "not a session file: it does not begin with the line \"MicroSim session\"";
    let cases = [
        (
            Vec::new(),
            "not a session file: it has 0 bytes and ends before its first frame, nothing was recorded",
        ),
        (random, none),
        (crate::SHORT.as_bytes().to_vec(), none),
        (
            newer,
            "a session file of format version 2; this program reads version 1",
        ),
        (
            behind,
            "it has no complete header, so that nothing can be read: the session is damaged at byte 21",
        ),
    ];
    for (content, complaint) in cases {
        tree.write("bad.session", content);
        for command in ["report", "replay", "bus"] {
            let printed = tree.microsim(&[command, "bad.session", "--json"]).expect(2);
            let expected = format!("microsim: session bad.session: {complaint}");
            assert!(
                printed.err.starts_with(&expected) && printed.out.is_empty(),
                "{printed:?}"
            );
        }
        let check = tree.microsim(&["check", "bad.session"]).expect(1);
        assert!(
            check.out.starts_with(&format!("bad.session: {complaint}")),
            "{check:?}"
        );
    }
    let printed = tree.microsim(&["report", "no.session"]).expect(2);
    assert!(
        printed
            .err
            .starts_with("microsim: session no.session: there is no such file"),
        "{printed:?}"
    );
    tree.write("bad.checkpoint", "no checkpoint");
    std::fs::remove_file(tree.path("x.session")).expect("removed");
    let printed = run(&tree, "script:short.toml", &["--resume", "bad.checkpoint"]).expect(2);
    assert!(
        printed
            .err
            .starts_with("microsim: checkpoint bad.checkpoint: "),
        "{printed:?}"
    );
    assert!(!tree.path("x.session").exists());
}

/// A session as input of another run: the samples before the cut are played.
#[test]
fn a_cut_session_as_input() {
    let (tree, bytes) = small();
    let cut = frames(&bytes)[5].offset;
    std::fs::remove_file(tree.path("x.session")).expect("removed");
    tree.write("cut.session", &bytes[..cut]);
    let printed = run(&tree, "recording:cut.session", &["--json"])
        .expect(0)
        .json();
    assert_eq!(printed["verdict"], "failed");
    let again =
        Session::read(&std::fs::read(tree.path("x.session")).expect("read")).expect("a session");
    assert_eq!(again.complaint, None);
    tree.write("none.session", &bytes[..PRELUDE]);
    let printed = tree.microsim(&[
        "run",
        "touch-spheres",
        "--input",
        "recording:none.session",
        "--session",
        "y.session",
    ]);
    assert_eq!(printed.code, Some(2));
    assert!(
        printed
            .err
            .starts_with("microsim: none.session: it has no complete header"),
        "{printed:?}"
    );
}
