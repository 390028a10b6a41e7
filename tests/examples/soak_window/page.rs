//! The page of a soak.

use crate::account::{Shown, slope};
use crate::{Event, Soak};
use std::fmt::Write as _;

/// Late ticks that may be, of all ticks of levels that need no more than their tick.
const LATE: f64 = 1e-3;

/// Why ticks of a run were late, by the log's own numbers.
fn cause(run: &Shown) -> String {
    let of = |name| run.number(name);
    if of("late") == 0.0 {
        return String::new();
    }
    let [p50, p99] = [of("tick_p50"), of("tick_p99")];
    if is_heavy(run) {
        format!(
            "physics: a tick of {:.0} ms takes {p50:.1} ms, at p99 {p99:.1} ms",
            run.tick
        )
    } else {
        format!("machine: ticks take {p50:.1} ms, at p99 {p99:.1} ms")
    }
}

/// Whether one tick in a hundred takes longer than it may.
fn is_heavy(run: &Shown) -> bool {
    run.number("tick_p99") > run.tick
}

/// The page, and whether all of it is as it should be.
pub fn of(soak: &Soak, words: &[String]) -> (String, bool) {
    let mut faults = soak.faults.clone();
    let sum = |runs: &[&Shown], name: &str| {
        runs.iter()
            .map(|run| run.number(name))
            .fold(0.0, |sum, n| sum + n)
    };
    let (heavy, light): (Vec<&Shown>, Vec<&Shown>) =
        soak.shown.iter().partition(|run| is_heavy(run));
    let [ticks, late] = ["ticks", "late"].map(|name| sum(&light, name));
    let [heavy_ticks, heavy_late] = ["ticks", "late"].map(|name| sum(&heavy, name));
    if late > LATE * ticks {
        faults.push(format!(
            "{late:.0} of {ticks:.0} ticks are late where the physics has time for them"
        ));
    }
    let recording = soak.recorded as f64 / 1e6 / soak.sessions.max(1) as f64;
    let rests = &soak.memory.resting;
    let span = rests.last().map_or(f64::NAN, |last| last.0 - rests[0].0) / 60.0;
    // If each level left its recording in memory.
    let bound = recording * (rests.len() as f64 - 1.0) / span;
    let mut memory = format!(
        "Memory: {} measurements in the launcher are too few for a slope.",
        rests.len()
    );
    if let Some((slope, error)) = slope(rests) {
        let peak = soak.memory.all.iter().map(|p| p.1).fold(0.0, f64::max);
        let [first, last] = [rests[rests.len() / 3].1, rests[rests.len() - 1].1];
        memory = format!(
            "Resident memory in the launcher, after each level: {first:.0} MB after a third, {last:.0} MB at the end; slope over the last two thirds {slope:+.2} ± {error:.2} MB/min. \
             It would be {bound:.2} MB/min if each level left its recording behind ({recording:.2} MB each), and is to be less, by more than twice its error or within it. Peak {peak:.0} MB."
        );
        if slope - 2.0 * error > 0.0 && slope + 2.0 * error > bound {
            faults.push(format!("memory grows by {slope:.2} ± {error:.2} MB/min"));
        }
    }
    let arguments = match words.is_empty() {
        true => String::new(),
        false => format!(" -- {}", words.join(" ")),
    };
    let happened = |event: Event| soak.slots.iter().filter(|slot| slot.2 == event).count();
    let mut text = format!(
        "# The window over {} minutes\n\nCommand: `cargo xtask soak window{arguments}`. One process, moved from outside by keys and mouse (seed {}), 1280 × 720 pixels at first, on a display and with a driver of the processor. \
         {} levels were begun; in their middle the window was given other sizes {} times, minimised {} and unmapped {} times, moved to scales of 1.5 and 1.25 {} times, filled the screen {} times, \
         lost its graphics device {} times, changed quality and panels {} times; {} levels were begun anew.\n\n",
        soak.minutes,
        soak.seed,
        soak.slots.len(),
        happened(Event::Resized),
        happened(Event::Minimised),
        happened(Event::Unmapped),
        happened(Event::Scaled),
        happened(Event::FullScreen),
        happened(Event::DriverLost),
        happened(Event::QualityAndPanels),
        happened(Event::BegunAnew),
    );
    let _ = writeln!(
        text,
        "- Sessions: {} recorded, all read again; {} of them computed again by `replay --verify`.\n\
         - Late by more than the tolerance of the station (2 ms, less than a tick): {late:.0} of {ticks:.0} ticks where at most one in a hundred takes longer than it may; \
         {heavy_late:.0} of {heavy_ticks:.0} where more do ({}).\n- {memory}\n- Faults: {}.\n",
        soak.sessions,
        soak.replayed,
        names(&heavy),
        match faults.is_empty() {
            true => "none".into(),
            false => faults.join("; "),
        }
    );
    text += "Each run, in the order of play; times in ms, of the last thousand. From a motion to the picture: to its tick, the tick, and from its end to the picture.\n\n\
         | level | min | ticks | late | cause | unconverged | pictures in a second | quality | to the tick, p50 | p99 | tick, p50 | p99 | to the picture, p50 | p99 |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    for run in &soak.shown {
        let of = |name: &str| run.number(name);
        let quality = run.values.get("quality").map_or("", String::as_str);
        let _ = write!(
            text,
            "| {} {} | {:.2} | {:.0} | {:.0} | {} | {:.0} | {:.1} | {quality} |",
            run.module,
            run.level,
            of("seconds") / 60.0,
            of("ticks"),
            of("late"),
            cause(run),
            of("unconverged"),
            of("rate"),
        );
        for stage in ["to_tick", "tick", "to_picture"] {
            let [p50, p99] = ["p50", "p99"].map(|part| of(&format!("{stage}_{part}")));
            let _ = write!(text, " {p50:.1} | {p99:.1} |");
        }
        text.push('\n');
    }
    text += "\nThe loss of the device is that of a layer below the program (`tests/peers/lost_device/`): it answers as a driver does that was reset, while the driver itself is alive. What a card does that is \
         really reset or unplugged is not tested.\n";
    (text, faults.is_empty())
}

fn names(runs: &[&Shown]) -> String {
    let mut names: Vec<String> = runs
        .iter()
        .map(|run| format!("{} {}", run.module, run.level))
        .collect();
    names.dedup();
    match names.is_empty() {
        true => "no level".into(),
        false => names.join(", "),
    }
}
