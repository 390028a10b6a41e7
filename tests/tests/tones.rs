//! Tones of recorded runs: what the window would have played.

use microsim_audio::{Cues, Tone};
use microsim_bus::Frames;
use microsim_host::record::Session;
use microsim_message::{ContactForces, TissueCut, decode};
use std::path::Path;

/// Length of a tick of the module's levels \[s\].
const TICK: f64 = 0.008;

/// The tones of a session, each with its time \[s\].
fn tones(session: &Path) -> Vec<(f64, Tone)> {
    let bytes = std::fs::read(session).expect("a session");
    let session = Session::read(&bytes).expect("a session");
    let mut cues = Cues::new(None);
    let mut tones = Vec::new();
    for (tick, record) in &session.ticks {
        let time = *tick as f64 * TICK;
        for frame in Frames::new(&record.log) {
            let frame = frame.expect("a good log");
            if let Some(forces) = decode::<ContactForces>(&frame) {
                let found = cues.of_forces(&forces.expect("forces"), time);
                tones.extend(found.into_iter().map(|tone| (time, tone)));
            } else if let Some(cut) = decode::<TissueCut>(&frame) {
                let found = cues.of_cut(&cut.expect("a cut"), time);
                tones.extend(found.map(|tone| (time, tone)));
            }
        }
    }
    tones
}

fn first(tones: &[(f64, Tone)], of: Tone) -> Option<f64> {
    tones
        .iter()
        .find(|(_, tone)| *tone == of)
        .map(|(time, _)| *time)
}

/// "One cut", passed: the scissors touch, then cut, and nothing presses too hard. "Grip and hold" with too much force: a touch, no cut, and a warning in as many ticks as
/// make the time for which the report has the force above the limit (`excess-time`), up to a tick at its beginning and end.
#[test]
fn a_run_has_the_tones_of_what_happened() {
    let folder = microsim_tests::scratch();
    let session = folder.path().join("cut.session");
    let script = "script:level2-pass.toml";
    microsim_tests::run(
        "coordination",
        &session,
        &["--level", "2", "--input", script],
    );
    let cut = tones(&session);
    let (touch, snip) = (first(&cut, Tone::Touch), first(&cut, Tone::Cut));
    assert!(touch.is_some() && touch < snip, "{cut:?}");
    assert_eq!(first(&cut, Tone::Warning), None);

    let session = folder.path().join("hard.session");
    let script = "script:level1-fail-too-hard.toml";
    microsim_tests::run(
        "coordination",
        &session,
        &["--level", "1", "--input", script],
    );
    let hard = tones(&session);
    let (touch, warning) = (first(&hard, Tone::Touch), first(&hard, Tone::Warning));
    assert!(touch.is_some() && touch < warning, "{hard:?}");
    assert_eq!(first(&hard, Tone::Cut), None);
    let warnings = hard.iter().filter(|(_, tone)| *tone == Tone::Warning);
    let warned = warnings.count() as f64 * TICK;
    let report = microsim_tests::report_beside(&session);
    let mut metrics = report["metrics"].as_array().expect("a list").iter();
    let excess = metrics.find(|metric| metric["id"] == "excess-time");
    let excess = excess.and_then(|metric| metric["value"].as_f64());
    let excess = excess.expect("it is measured");
    assert!(
        excess > 0.1 && (warned - excess).abs() < 2.0 * TICK,
        "{warned} s, {excess} s"
    );
}
