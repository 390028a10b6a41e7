//! A session that is played for a viewer, forth and back: what `microsim replay` computes and finds, whatever was shown before.

use crate::{PUSH_STRIP, pushed_strip, recorded_hand, session};
use microsim_host::assemble::{Installation, locate};
use microsim_host::playback::{Moment, Playback, PlaybackOptions};
use microsim_host::record::{Session, kind};
use microsim_host::run::RunError;
use microsim_message::{InputSample, Message, ObjectScene, TissueCut, ToolStates};
use microsim_random::SplitMix64;
use microsim_session::digest;
use microsim_tests::alter::{
    change_message, change_tick, last_bit_flipped, rewrite, ticks_with_samples,
};
use microsim_tests::{run, scratch, tree, verify};
use serde_json::Value;
use std::cell::RefCell;
use std::fs;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::rc::Rc;
use std::sync::atomic::AtomicBool;

type Played<R = Cursor<Vec<u8>>> = Playback<R>;

const SHOWN: [&str; 3] = [ToolStates::KIND, ObjectScene::KIND, TissueCut::KIND];
/// Much, and so little that the first and the newest checkpoint have to do.
const MUCH: usize = 256 << 20;
const LITTLE: usize = 1;

fn played(bytes: &[u8], memory: usize) -> Played {
    opened(Cursor::new(bytes.to_vec()), memory, false).unwrap_or_else(|e| panic!("{e}"))
}

fn opened<R: Read + Seek>(source: R, memory: usize, stop: bool) -> Result<Played<R>, RunError> {
    let installation = Installation::open(&tree(), None).expect("the built tree");
    let options = PlaybackOptions {
        threads: 1,
        shown: &SHOWN,
        memory,
        stop: &AtomicBool::new(stop),
    };
    Playback::open(source, &options, |planned| {
        locate(&installation, planned).map_err(|e| RunError::Host(e.to_string()))
    })
}

/// All that is shown of a tick, to the bit.
fn bits(moment: &Moment) -> [u8; 32] {
    let messages = moment.messages.values().map(|bytes| bytes.to_vec());
    let words = |block: &microsim_bus::Block| {
        let words = block.words().iter();
        words.flat_map(|word| word.to_le_bytes()).collect()
    };
    let blocks = moment.blocks.iter().map(words);
    let parts: Vec<Vec<u8>> = messages.chain(blocks).collect();
    digest(parts.iter().map(Vec::as_slice))
}

/// Plays to the end: what is shown of each tick.
fn to_the_end(playback: &mut Played) -> Vec<[u8; 32]> {
    let mut all = Vec::new();
    while let Some(moment) = playback.step().expect("a tick") {
        assert_eq!(moment.tick, all.len() as u64);
        all.push(bits(&moment));
    }
    all
}

/// What is shown of a tick, wherever the playback was before, and how many ticks were computed for it.
fn show(playback: &mut Played, tick: u64) -> ([u8; 32], u64) {
    playback.seek(tick).expect("a checkpoint");
    for computed in 1.. {
        let moment = playback.step().expect("a tick").expect("not the end");
        if moment.tick == tick {
            return (bits(&moment), computed);
        }
    }
    unreachable!("ticks come in order")
}

/// What `microsim replay` finds.
fn replayed(bytes: &[u8], code: i32) -> Value {
    let folder = scratch();
    let path = folder.path().join("a.session");
    fs::write(&path, bytes).expect("a file");
    verify(&path, &[]).expect(code).json()
}

fn forth_and_back(bytes: &[u8], seed: u64) {
    let mut playback = played(bytes, MUCH);
    let all = to_the_end(&mut playback);
    let standing = playback.standing().clone();
    assert!(
        standing.is_complete && standing.difference.is_none(),
        "{standing:?}"
    );
    let replay = replayed(bytes, 0);
    assert_eq!(replay["ticks"], all.len() as u64, "{replay}");
    assert_eq!(
        replay["state_hash"].as_str(),
        playback.state_hash().as_deref()
    );
    assert_eq!(
        replay["recorded_hash"].as_str(),
        playback.state_hash().as_deref()
    );

    let last = all.len() as u64 - 1;
    let mut random = SplitMix64(seed);
    let mut ticks: Vec<u64> = (0..12).map(|_| random.below(last + 1)).collect();
    // The last one, one back from it, and both ends.
    ticks.extend([last, last - 1, 0, last, 0]);
    for tick in &ticks {
        let (shown, computed) = show(&mut playback, *tick);
        assert_eq!(shown, all[*tick as usize], "tick {tick}");
        // A quarter of a second is 31 ticks of 8 ms.
        assert!(computed <= 32, "{computed} ticks for tick {tick}");
    }
    // From the beginning to the end once more, in the same engine, which ends with the same hash.
    show(&mut playback, 0);
    while playback.step().expect("a tick").is_some() {}
    assert_eq!(*playback.standing(), standing);
    let memory = playback.memory();
    assert!(memory > 0 && memory <= MUCH, "{memory}");

    // With next to no memory more is computed, and the same is shown.
    let mut playback = played(bytes, LITTLE);
    assert_eq!(to_the_end(&mut playback), all);
    assert!(
        playback.memory() <= memory,
        "{} of {memory}",
        playback.memory()
    );
    for tick in [last / 2, last / 3, last] {
        assert_eq!(
            show(&mut playback, tick).0,
            all[tick as usize],
            "tick {tick}"
        );
    }
}

#[test]
fn a_played_hand_is_the_same_forth_and_back() {
    forth_and_back(recorded_hand(), 1);
}

#[test]
fn played_tissue_is_the_same_forth_and_back() {
    forth_and_back(pushed_strip(), 2);
}

/// Back over a cut the tissue is whole again.
#[test]
fn a_played_cut_is_the_same_forth_and_back() {
    let args = ["--level", "2", "--input", "script:level2-pass.toml"];
    let bytes = session("coordination", &args);
    let mut playback = played(&bytes, MUCH);
    let cut = loop {
        let moment = playback.step().expect("a tick").expect("it is cut");
        let kind = microsim_bus::kind_id(TissueCut::KIND);
        if moment.messages.contains_key(&kind) {
            break moment.tick;
        }
    };
    println!("the first cut is in tick {cut}");
    assert!(cut > 10);
    forth_and_back(&bytes, 3);
}

/// The first difference is that of `microsim replay`; it goes on with what was recorded from outside, and does not forget it.
#[test]
fn an_altered_session_is_named_by_its_tick() {
    let bytes = recorded_hand();
    let of_plugin = change_tick(bytes, 1234, |record| {
        change_message(&mut record.log, |states: &mut ToolStates| {
            states.tools[0].opening = 0.5
        });
    });
    let session = Session::read(bytes).expect("a session");
    let samples = ticks_with_samples(&session);
    let with_sample = samples[samples.len() / 3];
    let of_input = change_tick(bytes, with_sample, |record| {
        change_message(&mut record.log, |sample: &mut InputSample| {
            sample.pose.position[0] = last_bit_flipped(sample.pose.position[0]);
        });
    });
    for (bytes, tick) in [(of_plugin, 1234), (of_input, with_sample)] {
        let mut playback = played(&bytes, MUCH);
        for _ in 0..tick {
            playback.step().expect("a tick").expect("not the end");
        }
        assert_eq!(playback.standing().difference, None);
        let (_, end) = playback.range();
        let mut ticks = tick;
        while playback.step().expect("a tick").is_some() {
            ticks += 1;
        }
        assert_eq!(ticks, end, "all of it is computed");
        let difference = &replayed(&bytes, 1)["first_difference"];
        let found = playback
            .standing()
            .difference
            .clone()
            .expect("a difference");
        assert_eq!(difference["tick"], found.tick);
        assert_eq!(difference["what"], found.what.as_str());
        assert_eq!(found.tick, tick);
        assert!(!playback.standing().is_complete);
        show(&mut playback, 100);
        assert_eq!(playback.standing().difference, Some(found));
    }
}

/// Where a tick is missing nothing can be computed from there on; what comes before can be shown still.
#[test]
fn a_missing_tick_ends_what_can_be_shown() {
    let bytes = rewrite(pushed_strip(), |record_kind, tick, payload| {
        let is_missing = record_kind == kind::TICK && tick == 200;
        (!is_missing).then(|| payload.to_vec())
    });
    let mut playback = played(&bytes, MUCH);
    let all = to_the_end(&mut playback);
    assert_eq!((all.len(), playback.range()), (200, (0, 200)));
    let found = playback
        .standing()
        .difference
        .clone()
        .expect("a difference");
    let difference = &replayed(&bytes, 1)["first_difference"];
    assert_eq!(difference["tick"], found.tick);
    assert_eq!(difference["what"], found.what.as_str());
    assert!(found.what.contains("tick 200 is missing"), "{found:?}");
    // The engine has not computed a tick in vain: from the same bits on it goes back.
    for tick in [199, 50, 0] {
        assert_eq!(show(&mut playback, tick).0, all[tick as usize]);
    }
}

/// A session that goes on at a checkpoint of another begins there.
#[test]
fn a_session_that_goes_on_is_played_from_there() {
    let folder = scratch();
    let path = |name: &str| folder.path().join(name);
    let checkpoint = path("there.checkpoint");
    let checkpoint = checkpoint.to_str().expect("UTF-8");
    let stop = ["--stop-at", "2.48", "--checkpoint", checkpoint];
    run(
        "push-strip",
        &path("first.session"),
        &[&PUSH_STRIP[..], &stop].concat(),
    );
    let second = path("second.session");
    let resume = ["--resume", checkpoint];
    run("push-strip", &second, &[&PUSH_STRIP[..], &resume].concat());
    let bytes = fs::read(second).expect("a session");
    let mut playback = played(&bytes, MUCH);
    let whole = to_the_end(&mut played(pushed_strip(), MUCH));
    let (first, end) = playback.range();
    assert_eq!((first, end), (310, whole.len() as u64));
    let moment = playback.step().expect("a tick").expect("not the end");
    assert_eq!(moment.tick, 310);
    while playback.step().expect("a tick").is_some() {}
    let standing = playback.standing();
    assert!(
        standing.is_complete && standing.difference.is_none(),
        "{standing:?}"
    );
    playback.seek(0).expect("the beginning");
    let moment = playback.step().expect("a tick").expect("not the end");
    assert_eq!(moment.tick, 310);
}

/// Where the file was cut off in a record, all before it is shown.
#[test]
fn a_torn_session_is_played_to_its_tear() {
    let bytes = pushed_strip();
    let mut playback = played(&bytes[..bytes.len() / 2], MUCH);
    let all = to_the_end(&mut playback);
    assert_eq!(playback.range(), (0, all.len() as u64));
    assert!(all.len() > 50);
    let standing = playback.standing();
    assert!(
        standing.is_complete && standing.difference.is_none(),
        "{standing:?}"
    );
    let complaint = standing.complaint.as_deref().expect("a complaint");
    assert_eq!(playback.session().complaint.as_deref(), Some(complaint));
    // A whole one has none.
    assert_eq!(played(pushed_strip(), MUCH).standing().complaint, None);
}

/// A file that somebody cuts.
#[derive(Clone)]
struct Cut(Rc<RefCell<Cursor<Vec<u8>>>>);

impl Read for Cut {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.0.borrow_mut().read(bytes)
    }
}

impl Seek for Cut {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.borrow_mut().seek(to)
    }
}

/// What stood behind the ticks is not compared with a state in the middle.
#[test]
fn a_session_that_is_cut_while_it_is_played_is_not_the_same_to_the_end() {
    let file = Cut(Rc::new(RefCell::new(Cursor::new(pushed_strip().to_vec()))));
    let mut playback = opened(file.clone(), MUCH, false).unwrap_or_else(|e| panic!("{e}"));
    let (_, whole) = playback.range();
    file.0
        .borrow_mut()
        .get_mut()
        .truncate(pushed_strip().len() / 2);
    while playback.step().expect("a tick").is_some() {}
    assert!(playback.step().expect("the end").is_none());
    let (_, end) = playback.range();
    assert!(end > 50 && end < whole, "{end} of {whole}");
    let standing = playback.standing();
    assert!(
        !standing.is_complete && standing.difference.is_none(),
        "{standing:?}"
    );
    let complaint = standing.complaint.as_deref().expect("a complaint");
    assert!(
        complaint.contains("was cut while it is played"),
        "{complaint}"
    );
}

#[test]
fn reading_a_session_is_stopped() {
    let source = Cursor::new(pushed_strip().to_vec());
    let stopped = opened(source, MUCH, true).err().expect("an error");
    assert!(stopped.to_string().contains("stopped"), "{stopped}");
}
