//! The page of a soak.

use crate::account::{Shown, slope};
use crate::{Event, Soak};
use std::fmt::Write as _;

/// Ticks late by more than a tick that may be, of all.
const OVERDUE: f64 = 1e-3;

/// Why ticks of a run were late by more than a tick: after a tick that took longer than its length, or without.
fn cause(run: &Shown) -> String {
    let [all, by_work] = ["overdue", "overdue_by_work"].map(|name| run.number(name));
    if all == 0.0 {
        return String::new();
    }
    let mut causes = Vec::new();
    if by_work > 0.0 {
        causes.push(format!(
            "{by_work:.0} after ticks longer than {:.0} ms",
            run.tick
        ));
    }
    if all > by_work {
        causes.push(format!("{:.0} not begun in time", all - by_work));
    }
    causes.join(", ")
}

fn what_happened(event: Event) -> &'static str {
    match event {
        Event::Resized => "other sizes",
        Event::Minimised => "minimised",
        Event::Unmapped => "unmapped",
        Event::Scaled => "other scales",
        Event::DriverLost => "the graphics device lost",
        Event::FullScreen => "the full screen",
        Event::BegunAnew => "begun anew",
        Event::QualityAndPanels => "quality and panels",
    }
}

/// Whether a run has more ticks late by more than a tick than may be.
pub fn is_late(run: &Shown) -> bool {
    run.number("overdue") > OVERDUE * run.number("ticks")
}

/// The page, and whether all of it is as it should be.
pub fn of(soak: &Soak) -> (String, bool) {
    let mut faults = soak.faults.clone();
    let sum = |name: &str| soak.shown.iter().map(|run| run.number(name)).sum::<f64>();
    let [ticks, late, overdue, by_work] = ["ticks", "late", "overdue", "overdue_by_work"].map(sum);
    if overdue > OVERDUE * ticks {
        faults.push(format!(
            "{overdue:.0} of {ticks:.0} ticks are late by more than a tick"
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
    let last_two_thirds = &rests[rests.len() / 3..];
    let per_minute = slope(last_two_thirds).map(|(slope, error)| (60.0 * slope, 60.0 * error));
    if let Some((slope, error)) = per_minute {
        let peak = soak.memory.all.iter().map(|p| p.1).fold(0.0, f64::max);
        let [first, last] = [last_two_thirds[0].1, rests[rests.len() - 1].1];
        memory = format!(
            "Resident memory in the launcher, after each level: {first:.0} MB after a third, {last:.0} MB at the end; slope over the last two thirds {slope:+.2} ± {error:.2} MB/min. \
             It would be {bound:.2} MB/min if each level left its recording behind ({recording:.2} MB each), and is to be less, by more than twice its error or within it. Peak {peak:.0} MB."
        );
        if slope - 2.0 * error > 0.0 && slope + 2.0 * error > bound {
            faults.push(format!("memory grows by {slope:.2} ± {error:.2} MB/min"));
        }
    }
    let happened = |event: Event| soak.slots.iter().filter(|slot| slot.2 == event).count();
    let mut text = format!(
        "# The window over {} minutes\n\nCommand: `cargo xtask soak window -- {} {}`. One process, moved from outside by keys and mouse, 1280 × 720 pixels at first, on a display and with a driver of the processor. \
         Every quality of pictures was drawn in, and every level that is played was shown, once before. {} levels were begun; in their middle the window was given other sizes {} times, minimised {} and unmapped {} times, moved to scales of 1.5 and 1.25 {} times, filled the screen {} times, \
         lost its graphics device {} times, changed quality and panels {} times; {} levels were begun anew.\n\n",
        soak.minutes,
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
         - Late by more than a tick (8 or 16 ms, by level): {overdue:.0} of {ticks:.0} ticks, {by_work:.0} of them after a tick that took longer than its length; \
         by more than the tolerance of the station (2 ms): {late:.0}.\n- {memory}\n- Faults: {}.\n",
        soak.sessions,
        soak.replayed,
        match faults.is_empty() {
            true => "none".into(),
            false => faults.join("; "),
        }
    );
    text += "Each run, in the order of play; times in ms, of the last thousand. From a motion to the picture: to its tick, the tick, and from its end to the picture.\n\n\
         | level | min | ticks | late by 2 ms | by a tick | cause | unconverged | pictures in a second | quality | to the tick, p50 | p99 | tick, p50 | p99 | to the picture, p50 | p99 |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    for run in &soak.shown {
        let of = |name: &str| run.number(name);
        let quality = run.values.get("quality").map_or("", String::as_str);
        let _ = write!(
            text,
            "| {} {} | {:.2} | {:.0} | {:.0} | {:.0} | {} | {:.0} | {:.1} | {quality} |",
            run.module,
            run.level,
            of("seconds") / 60.0,
            of("ticks"),
            of("late"),
            of("overdue"),
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
    text += "\n| level | in its middle | resident memory in the launcher after it \\[MB\\] |\n|---|---|---|\n";
    for ((module, level, event), (_, memory)) in soak.slots.iter().zip(rests) {
        let _ = writeln!(
            text,
            "| {module} {level} | {} | {memory:.0} |",
            what_happened(*event)
        );
    }
    text += "\nThe loss of the device is that of a layer below the program (`tests/peers/lost_device/`): it answers as a driver does that was reset, while the driver itself is alive. What a card does that is \
         really reset or unplugged is not tested.\n";
    (text, faults.is_empty())
}
