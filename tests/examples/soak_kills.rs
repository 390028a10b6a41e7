//! `cargo xtask soak kills`: runs killed by SIGKILL at moments spread evenly over the measured length of the run; what can
//! be read of each session, and how much simulated time is lost. Writes `tests/results/kills.csv` and `kills.md`.
//!
//! `-- --runs N` for another number of paced runs (200). How the loss is measured stands in `microsim_tests::kill`.

use microsim_tests::kill::{Moment, Remains, Target, moments};
use microsim_tests::repository;
use microsim_tests::statistics::percentile;
use std::fmt::Write as _;
use std::fs;
use std::process::ExitCode;
use std::time::Duration;

/// Most simulated time that a killed run may lose \[s\].
const MAX_LOSS: f64 = 0.1;
/// Time for which the source of a run gives samples \[s\].
const LENGTH: f64 = 1.5;

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
    let runs = match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => 200,
        ["--runs", n] if n.parse::<usize>().is_ok_and(|n| n > 0) => n.parse().unwrap_or(200),
        _ => {
            eprintln!("usage: cargo xtask soak kills [-- --runs N]");
            return ExitCode::from(2);
        }
    };
    let paced = Series::measure(true, runs);
    let fast = Series::measure(false, runs);
    let text = report(&paced, &fast);
    println!("{text}");
    let mut csv = String::from(
        "series,run,killed_after_ms,moment,readable,ticks_begun,ticks_on_file,ticks_lost,lost_ms,last_write_to_kill_ms,verified,end_of_file\n",
    );
    paced.csv(&mut csv);
    fast.csv(&mut csv);
    let folder = repository().join("tests").join("results");
    let written = fs::create_dir_all(&folder)
        .and_then(|()| fs::write(folder.join("kills.md"), text))
        .and_then(|()| fs::write(folder.join("kills.csv"), csv));
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
    if enough && paced.is_good() && fast.is_good() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
