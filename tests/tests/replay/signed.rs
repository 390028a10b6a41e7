//! Signatures: what a station signed is called unchanged, by whoever trusts it, and nothing else is.

use crate::forged::{failed, forged, passed, unchanged};
use microsim_host::plan::PluginKind;
use microsim_host::record::{Header, Session, kind};
use microsim_random::SplitMix64;
use microsim_session::{KIND_END, StationKey, Writer, read};
use microsim_tests::alter::{change_header, rewrite, signed_again};
use microsim_tests::{Finished, command, finish, scratch, station_key, verify};
use serde_json::{Value, json};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

/// Forgeries tried.
const FORGERIES: u64 = 100;

fn judged(bytes: &[u8], args: &[&str]) -> Finished {
    let folder = scratch();
    let path = folder.path().join("a.session");
    fs::write(&path, bytes).expect("a file");
    verify(&path, args)
}

/// Something that a person reads and no computation gives.
fn relabelled(bytes: &[u8], random: &mut SplitMix64) -> Vec<u8> {
    let other = format!("Other {}", random.below(1000));
    let days = 86_400 * (1 + random.below(300));
    let what = random.below(8);
    change_header(bytes, move |header: &mut Header| {
        let plan = &mut header.plan;
        match what {
            0 => header.trainee = Some(other.clone()),
            1 => plan.synthetic = Some(other.clone()),
            2 => plan.module_title.en = other.clone().into(),
            3 => plan.level_title.de = other.clone().into(),
            4 => plan.level_summary.en = other.clone().into(),
            5 => header.started += days,
            6 => plan.input = other.clone(),
            _ => header.realtime = !header.realtime,
        }
    })
}

/// One bit of the payload of a record that is not a signature, with its checksums computed again.
fn flipped_inside(bytes: &[u8], random: &mut SplitMix64) -> Vec<u8> {
    let frames = read(bytes).expect("a session").frames;
    let records: Vec<u64> = frames
        .iter()
        .filter(|f| ![KIND_END, kind::SIGNATURE].contains(&f.kind))
        .map(|f| f.sequence)
        .collect();
    let wanted = records[random.below(records.len() as u64) as usize];
    let bit = random.bits();
    let mut writer = Writer::create(Vec::new()).expect("memory");
    for frame in &frames {
        let mut payload = frame.payload.to_vec();
        if frame.sequence == wanted {
            let bit = (bit % (8 * payload.len() as u64)) as usize;
            payload[bit / 8] ^= 1 << (bit % 8);
        }
        writer
            .append(frame.kind, frame.tick, &payload)
            .expect("memory");
    }
    writer.into_inner()
}

/// The verdict, with all hashes computed again, and the module called a source or not.
fn verdict(bytes: &[u8], random: &mut SplitMix64) -> Vec<u8> {
    let hides = random.below(2) == 1;
    let header = move |header: &mut Header| {
        let plugins = header.plan.plugins.iter_mut();
        for plugin in plugins.filter(|p| hides && !p.kind.is_observer()) {
            plugin.kind = PluginKind::Source;
        }
    };
    forged(bytes, header, passed)
}

/// Any bit of the file, or a cut anywhere.
fn spoilt(bytes: &[u8], random: &mut SplitMix64) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let at = random.below(bytes.len() as u64) as usize;
    match random.below(2) {
        0 => bytes[at] ^= 1 << random.below(8),
        _ => bytes.truncate(at),
    }
    bytes
}

/// A tick or a signature less.
fn shortened(bytes: &[u8], random: &mut SplitMix64) -> Vec<u8> {
    let wanted = [kind::TICK, kind::SIGNATURE][random.below(2) as usize];
    let frames = read(bytes).expect("a session").frames;
    let count = frames.iter().filter(|f| f.kind == wanted).count() as u64;
    let (out, mut n) = (random.below(count), 0);
    rewrite(bytes, |record, _, payload| {
        let is_out = record == wanted && n == out;
        n += u64::from(record == wanted);
        (!is_out).then(|| payload.to_vec())
    })
}

/// Relabelled, flipped, cut, with another verdict, left with the old signatures, without any, or signed with a key of the forger's own: none is
/// called unchanged, and none is called recomputed whose messages are not those that were computed.
#[test]
fn a_hundred_forgeries_without_the_key_are_found_out() {
    let bytes = failed();
    let good = judged(bytes, &[]).expect(0).json();
    let keys = ["verified", "recomputed", "unchanged"];
    assert_eq!(
        keys.map(|key| good[key].clone()),
        [true, true, true],
        "{good}"
    );
    let computed = |bytes: &[u8]| -> Vec<(u64, Vec<u8>)> {
        let ticks = Session::read(bytes).expect("a session").ticks;
        ticks
            .into_iter()
            .map(|(tick, record)| (tick, record.log))
            .collect()
    };
    let history = computed(bytes);
    let kinds = [relabelled, flipped_inside, verdict, spoilt, shortened];
    let mut found = [0; 4];
    for seed in 0..FORGERIES {
        let mut random = SplitMix64(seed);
        let kind = kinds[(seed % 5) as usize];
        let mut altered = kind(bytes, &mut random);
        // What is spoilt is no session that could be signed again.
        if seed % 5 != 3 {
            altered = match random.below(3) {
                0 => altered,
                1 => signed_again(&altered, None),
                _ => signed_again(&altered, Some(&StationKey::from_seed(&[9; 32]))),
            };
        }
        assert!(altered != bytes, "seed {seed}");
        let printed = judged(&altered, &[]);
        if printed.code == Some(2) {
            found[3] += 1;
            assert!(printed.out.is_empty(), "seed {seed}: {printed:?}");
            continue;
        }
        let printed = printed.json();
        assert_eq!(printed["unchanged"], false, "seed {seed}: {printed}");
        let recomputed = printed["recomputed"] == true;
        if recomputed {
            let now = computed(&altered);
            assert!(history.starts_with(&now), "seed {seed}: {printed}");
            // A part is called a part.
            let is_whole = printed["complaint"] == Value::Null;
            assert!(
                !is_whole || now.len() == history.len(),
                "seed {seed}: {printed}"
            );
        }
        let state = printed["signature"]["state"].as_str().unwrap_or_default();
        let trusted = printed["signature"]["trusted"] == true;
        assert!(state != "whole" || !trusted, "seed {seed}: {printed}");
        found[0] += usize::from(state == "broken");
        found[1] += usize::from(state == "missing");
        found[2] += usize::from(state == "whole" || state == "until");
    }
    println!("broken, missing, of another or unfinished, refused: {found:?}");
    assert!(found.iter().all(|count| *count >= 5), "{found:?}");
}

/// Who trusts the station calls it unchanged, by its fingerprint; who does not learns whose signature it is.
#[test]
fn another_station_trusts_by_fingerprint() {
    let folder = scratch();
    let path = folder.path().join("a.session");
    fs::write(&path, failed()).expect("a file");
    let elsewhere = |args: &[&str]| {
        let mut command = command(["replay", "--verify", "--json"]);
        command.env("MICROSIM_STATION_KEY", folder.path().join("none.key"));
        finish(command.arg(&path).args(args))
    };
    let printed = elsewhere(&[]).expect(0).json();
    assert_eq!(printed["unchanged"], false, "{printed}");
    let station = printed["signature"]["station"].as_str().expect("a station");
    let fingerprint = station.to_owned();
    let trusted = elsewhere(&["--station", &fingerprint]).expect(0).json();
    assert_eq!(trusted["unchanged"], true, "{trusted}");
    let other = elsewhere(&["--station", "0000-1111-2222-3333-4444-5555-6666-7777"]);
    assert_eq!(other.expect(1).json()["unchanged"], false);
    let doctor = finish(&mut command(["doctor"]));
    assert!(doctor.out.contains(&fingerprint), "{doctor:?}");
    assert!(
        !folder.path().join("none.key").exists(),
        "nothing is made to read"
    );
}

/// A killed session is as it was signed up to its last signature; what a forger adds behind is not.
#[test]
fn a_session_that_was_cut_off_is_signed_up_to_a_tick() {
    let bytes = failed();
    let frames = read(bytes).expect("a session").frames;
    let last = frames
        .iter()
        .rfind(|f| f.kind == kind::SIGNATURE)
        .expect("signed on the way");
    let behind = frames
        .iter()
        .find(|f| f.sequence == last.sequence + 1)
        .expect("a tick");
    let printed = judged(&bytes[..behind.offset], &[]).expect(0).json();
    let expected = json!({
        "state": "until", "station": printed["signature"]["station"], "trusted": true, "until_tick": last.tick,
    });
    assert_eq!(
        (&printed["signature"], &printed["unchanged"]),
        (&expected, &json!(false))
    );
    // The closing seal of nobody, in place of that of the station.
    let closed = rewrite(bytes, |record, _, payload| {
        Some(match record {
            KIND_END => Vec::new(),
            _ => payload.to_vec(),
        })
    });
    let printed = judged(&closed, &[]).expect(1).json();
    assert_eq!(printed["signature"]["state"], "broken", "{printed}");
    let report = {
        let folder = scratch();
        let path = folder.path().join("a.session");
        fs::write(&path, closed).expect("a file");
        finish(command(["report"]).arg(path)).expect(0)
    };
    assert!(
        report.out.contains("changed after it was signed"),
        "{report:?}"
    );
}

/// Where there is no place for a key, or it is no secret, the run goes on: one sentence, and a session without a signature.
#[test]
fn a_run_without_a_key_is_recorded_unsigned() {
    let folder = scratch();
    let open = folder.path().join("open.key");
    fs::copy(station_key(), &open).expect("the key of the tests");
    fs::set_permissions(&open, fs::Permissions::from_mode(0o644)).expect("set");
    let cases = [
        (Path::new("/dev/null/none/station.key"), "cannot be read"),
        (&open, "can be read or written by others (mode 644)"),
    ];
    for (n, (key, why)) in cases.into_iter().enumerate() {
        let session = folder.path().join(format!("{n}.session"));
        let mut run = command(["run", "touch-spheres", "--no-pictures", "--session"]);
        run.arg(&session)
            .args(["--input", "script:level1-pass.toml"]);
        let printed = finish(run.env("MICROSIM_STATION_KEY", key)).expect(0);
        let lines: Vec<&str> = printed.err.lines().collect();
        let [line] = lines[..] else {
            panic!("{printed:?}");
        };
        assert!(
            line.starts_with("microsim: the recording is not signed: "),
            "{line}"
        );
        assert!(line.contains(why), "{line}");
        let printed = verify(&session, &[]).expect(0).json();
        assert_eq!(printed["signature"]["state"], "missing", "{printed}");
        assert_eq!(
            (&printed["recomputed"], &printed["unchanged"]),
            (&json!(true), &json!(false))
        );
    }
}

/// A signature is no input of the run: neither its messages nor its hashes know of it.
#[test]
fn a_signature_changes_nothing_that_is_computed() {
    let plain = signed_again(failed(), None);
    let (plain, signed) = (Session::read(&plain), Session::read(failed()));
    let (plain, signed) = (plain.expect("a session"), signed.expect("a session"));
    assert!(plain.ticks == signed.ticks && plain.end == signed.end);
    assert!(forged(failed(), |_| (), unchanged) == failed());
}
