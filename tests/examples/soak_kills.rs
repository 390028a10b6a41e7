//! `cargo xtask soak kills`: runs killed by SIGKILL at moments spread evenly over the measured length of the run; what can
//! be read of each session, and how much simulated time is lost. Writes `tests/results/kills.csv` and `kills.md`.
//!
//! `-- --runs N` for another number of paced runs (200). How the loss is measured stands in `microsim_tests::kill`. A third series kills a level of
//! scissors in ticks that cut, half as many times, and writes `kills_cutting.csv`; `-- --cutting N` prints it alone, with N runs.

use microsim_tests::kill::{Moment, Remains, Target, moments};
use microsim_tests::statistics::percentile;
use microsim_tests::{comb, repository};
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Most simulated time that a killed run may lose \[s\].
const MAX_LOSS: f64 = 0.1;
/// Time for which the source of a run gives samples \[s\].
const LENGTH: f64 = 1.5;

/// Where results are written.
fn results() -> PathBuf {
    repository().join("tests").join("results")
}

/// Snips of the comb.
const SNIPS: u32 = 101;
/// Longest time from the beginning of a tick to the kill \[ms\]: a tick that cuts takes about as long.
const INTO_TICK: f64 = 8.0;

/// Runs that were killed in ticks that cut.
struct Cutting {
    cuts: usize,
    snips: usize,
    whole_verified: bool,
    /// Per run: the tick that was waited for, the time from its beginning to the kill \[ms\], whether the kill fell into a tick that cuts.
    runs: Vec<(u64, f64, bool, Remains)>,
}

impl Cutting {
    fn measure(runs: usize) -> Self {
        let target = Target::comb(SNIPS);
        let session = target.whole("whole");
        let cuts = comb::cuts(&session);
        eprintln!("{} cuts; killing {runs} runs in ticks that cut", cuts.len());
        let whole_verified = target.verifies(&session);
        let killed = (0..runs).map(|n| {
            // Spread over all cuts and, by the golden ratio, over the tick.
            let (tick, _) = cuts[(2 * n + 1) * cuts.len() / (2 * runs)];
            let into = INTO_TICK * (n as f64 * 0.618_034).fract();
            let remains = target.kill_in(n, tick, Duration::from_secs_f64(1e-3 * into));
            let in_cut = |tick| cuts.iter().any(|(of, _)| *of == tick);
            let in_cut = remains.unfinished().is_some_and(in_cut);
            if n % 20 == 19 {
                eprintln!("  {} of {runs}", n + 1);
            }
            (tick, into, in_cut, remains)
        });
        Self {
            cuts: cuts.len(),
            snips: comb::snips(&cuts),
            whole_verified,
            runs: killed.collect(),
        }
    }

    fn count(&self, is: impl Fn(&Remains) -> bool) -> usize {
        self.runs.iter().filter(|(.., r)| is(r)).count()
    }

    fn in_cuts(&self) -> usize {
        self.runs.iter().filter(|(_, _, in_cut, _)| *in_cut).count()
    }

    /// Everything was preserved, and enough kills fell into ticks that cut.
    fn is_good(&self) -> bool {
        let sound = |r: &Remains| r.readable && r.verified && r.lost() <= 1;
        self.whole_verified
            && self.count(sound) == self.runs.len()
            && 4 * self.in_cuts() >= self.runs.len()
    }

    fn write(&self) -> std::io::Result<()> {
        let mut out = String::from(
            "run,killed_after_tick_began_ms,waited_for_tick,in_a_tick_that_cuts,readable,ticks_begun,ticks_on_file,ticks_lost,verified,end_of_file\n",
        );
        for (n, (tick, into, in_cut, r)) in self.runs.iter().enumerate() {
            let _ = writeln!(
                out,
                "{n},{into:.1},{tick},{in_cut},{},{},{},{},{},\"{}\"",
                r.readable,
                r.begun,
                r.on_file,
                r.lost(),
                r.verified,
                r.complaint.replace('"', "'")
            );
        }
        fs::write(results().join("kills_cutting.csv"), out)
    }

    fn report(&self) -> String {
        let all = self.runs.len();
        format!(
            "
## Killed while cutting

Scissors cut a band of tissue into a comb: {} snips in {} ticks that cut (events `tissue.cut`), a run like every other to the
bit. `replay --verify` of the whole session: {}. Each run is killed when a tick that cuts has begun, up to {INTO_TICK:.0} ms later. That
the kill fell into an edit is known from the tick that the witness has and the session has not: it is one of those that cut in the whole
run, and nothing of its edit is on file. One row per run: [`kills_cutting.csv`](kills_cutting.csv).

| | |
|---|---|
| runs killed | {all} |
| … in a tick that cuts, before it was on file | {} |
| sessions readable | {} |
| … recomputed to the bit by `replay --verify` | {} |
| **ticks lost, largest** | **{}** |
",
            self.snips,
            self.cuts,
            if self.whole_verified { "verified" } else { "**not verified**" },
            self.in_cuts(),
            self.count(|r| r.readable),
            self.count(|r| r.verified),
            self.runs.iter().map(|(.., r)| r.lost()).max().unwrap_or(0),
        )
    }
}

/// Runs of one kind.
struct Series {
    paced: bool,
    tick: f64,
    length: Duration,
    runs: Vec<(Duration, Remains)>,
}

impl Series {
    fn measure(paced: bool, runs: usize) -> Self {
        let target = Target::new(LENGTH, paced);
        let length = target.length();
        let name = if paced { "paced" } else { "as fast as it can" };
        eprintln!(
            "{name}: a whole run lasts {:.3} s; killing {runs}",
            length.as_secs_f64()
        );
        let killed = moments(length, runs)
            .into_iter()
            .enumerate()
            .map(|(n, delay)| {
                let remains = target.kill(n, delay);
                if n % 20 == 19 {
                    eprintln!("  {} of {runs}", n + 1);
                }
                (delay, remains)
            });
        Self {
            paced,
            tick: target.tick,
            length,
            runs: killed.collect(),
        }
    }

    fn at(&self, moment: Moment) -> usize {
        self.runs.iter().filter(|(_, r)| r.moment == moment).count()
    }

    /// Those that were killed while running, and those that had just ended.
    fn begun(&self) -> impl Iterator<Item = &Remains> {
        self.runs
            .iter()
            .map(|(_, r)| r)
            .filter(|r| r.moment != Moment::Starting)
    }

    /// Lost simulated time of those killed while running \[ms\].
    fn losses(&self) -> Vec<f64> {
        let running = self.begun().filter(|r| r.moment == Moment::Running);
        running.map(|r| 1e3 * r.lost() as f64 * self.tick).collect()
    }

    /// Wall-clock time since the last write of those killed while running \[ms\].
    fn silences(&self) -> Vec<f64> {
        let running = self.begun().filter(|r| r.moment == Moment::Running);
        running.map(|r| 1e3 * r.silence).collect()
    }

    fn count(&self, is: impl Fn(&Remains) -> bool) -> usize {
        self.begun().filter(|r| is(r)).count()
    }

    fn is_good(&self) -> bool {
        let all = self.begun().count();
        let sound = self.count(|r| r.readable && r.verified && r.on_file <= r.begun);
        sound == all && self.losses().iter().all(|ms| *ms <= 1e3 * MAX_LOSS)
    }

    fn csv(&self, out: &mut String) {
        for (n, (delay, r)) in self.runs.iter().enumerate() {
            let moment = match r.moment {
                Moment::Starting => "starting",
                Moment::Running => "running",
                Moment::Ended => "ended",
            };
            let _ = writeln!(
                out,
                "{},{n},{:.1},{moment},{},{},{},{},{:.1},{:.2},{},\"{}\"",
                if self.paced { "paced" } else { "fast" },
                1e3 * delay.as_secs_f64(),
                r.readable,
                r.begun,
                r.on_file,
                r.lost(),
                1e3 * r.lost() as f64 * self.tick,
                1e3 * r.silence,
                r.verified,
                r.complaint.replace('"', "'")
            );
        }
    }
}

fn table(series: &[&Series]) -> String {
    let mut rows = String::new();
    let mut row = |what: &str, value: &dyn Fn(&Series) -> String| {
        let cells: Vec<String> = series.iter().map(|s| value(s)).collect();
        let _ = writeln!(rows, "| {what} | {} |", cells.join(" | "));
    };
    row("a whole run, from start to exit, median of 5", &|s| {
        format!("{:.3} s", s.length.as_secs_f64())
    });
    row("runs killed", &|s| s.runs.len().to_string());
    row("… before the first tick (nothing to read)", &|s| {
        s.at(Moment::Starting).to_string()
    });
    row("… **while running**", &|s| {
        format!("**{}**", s.at(Moment::Running))
    });
    row("… after the end of the session", &|s| {
        s.at(Moment::Ended).to_string()
    });
    row("sessions readable, of those that had begun", &|s| {
        format!("{} of {}", s.count(|r| r.readable), s.begun().count())
    });
    row("… recomputed to the bit by `replay --verify`", &|s| {
        format!("{} of {}", s.count(|r| r.verified), s.begun().count())
    });
    row("… with a record torn in the middle", &|s| {
        s.count(|r| r.complaint.contains("breaks off")).to_string()
    });
    row("simulated time lost, median", &|s| {
        format!("{:.0} ms", percentile(&s.losses(), 0.5))
    });
    row("**simulated time lost, largest**", &|s| {
        format!("**{:.0} ms**", percentile(&s.losses(), 1.0))
    });
    row("wall-clock time from last write to kill, median", &|s| {
        format!("{:.1} ms", percentile(&s.silences(), 0.5))
    });
    row("wall-clock time from last write to kill, largest", &|s| {
        format!("{:.1} ms", percentile(&s.silences(), 1.0))
    });
    rows
}

fn report(paced: &Series, fast: &Series) -> String {
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    format!(
        "# Runs killed by `kill -9`

Command: `cargo xtask soak kills`, on a Linux machine with {cores} processor cores. One row per run: [`kills.csv`](kills.csv).

Level 1 of touch-spheres with live samples from a thread of their own, paced by the wall clock (`--realtime`), and once
more as fast as it can go. The moments of the kills are the middles of equal parts of the measured length.

| | paced | as fast as it can |
|---|---|---|
{}
How the lost time is measured: the source plugin, called first in every tick, writes the index of each tick that begins
into a file of its own before anything else of the tick is done. Ticks in this file and not in the session are lost; the
tick in the making counts as a whole ({:.0} ms). No clock is involved. As a cross-check for the paced runs, where simulated
time goes with the wall clock: the time from the last write to the session (its modification time) to the kill, in which
up to one tick of waiting is contained.

At most {:.0} ms may be lost: {}.
",
        table(&[paced, fast]),
        1e3 * paced.tick,
        1e3 * MAX_LOSS,
        if paced.is_good() && fast.is_good() { "kept in every run" } else { "**not kept**" }
    )
}

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |n: &str| n.parse::<usize>().ok().filter(|n| *n > 0);
    let runs = match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => Some(200),
        ["--runs", n] => number(n),
        ["--cutting", n] if number(n).is_some() => {
            let cutting = Cutting::measure(number(n).unwrap_or(1));
            println!("{}", cutting.report());
            return match cutting.write() {
                Ok(()) if cutting.is_good() => ExitCode::SUCCESS,
                Ok(()) => ExitCode::FAILURE,
                Err(error) => {
                    eprintln!("kills_cutting.csv: {error}");
                    ExitCode::from(2)
                }
            };
        }
        _ => None,
    };
    let Some(runs) = runs else {
        eprintln!("usage: cargo xtask soak kills [-- --runs N | --cutting N]");
        return ExitCode::from(2);
    };
    let paced = Series::measure(true, runs);
    let fast = Series::measure(false, runs);
    let text = report(&paced, &fast);
    let cutting = Cutting::measure(runs.div_ceil(2));
    let text = text + &cutting.report();
    println!("{text}");
    let mut csv = String::from(
        "series,run,killed_after_ms,moment,readable,ticks_begun,ticks_on_file,ticks_lost,lost_ms,last_write_to_kill_ms,verified,end_of_file\n",
    );
    paced.csv(&mut csv);
    fast.csv(&mut csv);
    let folder = results();
    let written = fs::create_dir_all(&folder)
        .and_then(|()| fs::write(folder.join("kills.md"), text))
        .and_then(|()| fs::write(folder.join("kills.csv"), csv))
        .and_then(|()| cutting.write());
    if let Err(error) = written {
        eprintln!("{}: {error}", folder.display());
        return ExitCode::from(2);
    }
    // Three quarters: 150 of 200.
    let enough = 4 * paced.at(Moment::Running) >= 3 * runs;
    if !enough {
        eprintln!(
            "only {} of {runs} were killed while running",
            paced.at(Moment::Running)
        );
    }
    if enough && paced.is_good() && fast.is_good() && cutting.is_good() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
