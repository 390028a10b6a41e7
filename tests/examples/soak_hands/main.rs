//! `cargo xtask soak hands [-- SECONDS SEED SLOWEST]`: random players ([`microsim_tests::hands`]) of every level and every profile that it permits, SECONDS of simulated time
//! in all, 36,000 if not given, each in a process of its own, one at a time. What the solver reported, forces, CPU time per picture, and what was really done. Writes
//! `tests/results/hands.md` and `hands.csv`.
//!
//! A run that takes more than SLOWEST times real time in CPU time, 20 if not given, is ended and counts as stalled.
//!
//! It may be stopped: what was played lies beside the built tree, the page is that of the levels so far, and the same SECONDS and SEED with the same tree go on from there.
//!
//! `-- --script MODULE LEVEL PROFILE SEED SECONDS` prints the script of one player, which `microsim run MODULE --level LEVEL --input script:FILE` plays; on a variant,
//! `LEVEL.NAME` here and `--variant NAME` there, players move as on the level.
//!
//! Ends with status 1 if a run breaks off without a report; what else is not met stands in the page.

mod page;

use microsim_tests::hands::played::{Ended, Guard, Outcome, play};
use microsim_tests::hands::stage::Stage;
use microsim_tests::hands::{Player, Profile, hand, stages};
use microsim_tests::{repository, scratch, tree};
use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Simulated time if none is given \[s\]: ten hours.
const SECONDS: f64 = 36_000.0;
/// A player plays no longer \[s\], and then another one does: levels are given a minute.
const LONGEST: f64 = 40.0;
/// And no shorter \[s\]: a reach and a grip.
const SHORTEST: f64 = 3.0;

/// What is asked for.
enum Order {
    Soak(f64, u64, Guard),
    Script(Player),
}

fn order(words: &[String]) -> Option<Order> {
    if let [flag, module, level, profile, seed, seconds] = words
        && flag == "--script"
    {
        return Some(Order::Script(Player {
            module: module.clone(),
            level: level.parse().ok()?,
            profile: Profile::of(profile)?,
            seed: seed.parse().ok()?,
            seconds: seconds.parse().ok()?,
        }));
    }
    let seconds = words
        .first()
        .map_or(Some(SECONDS), |word| word.parse().ok())?;
    let seed = words.get(1).map_or(Some(1), |word| word.parse().ok())?;
    let mut guard = Guard::default();
    if let Some(word) = words.get(2) {
        guard.cpu = word.parse().ok()?;
    }
    (words.len() <= 3 && seconds > 0.0).then_some(Order::Soak(seconds, seed, guard))
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let done = match order(&words) {
        Some(Order::Script(player)) => print_script(&player).map(|()| true),
        Some(Order::Soak(seconds, seed, guard)) => soak(seconds, seed, guard),
        None => {
            eprintln!(
                "expected [SECONDS SEED SLOWEST], or --script MODULE LEVEL PROFILE SEED SECONDS"
            );
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn print_script(player: &Player) -> Result<(), String> {
    let stage = Stage::read(&player.module, &player.level)?;
    print!("{}", hand::script(player, &stage).0);
    Ok(())
}

/// Plays all players; whether every run ended with a report or was ended for being slow.
fn soak(seconds: f64, first_seed: u64, guard: Guard) -> Result<bool, String> {
    let stages = stages()?;
    let pairs: usize = stages.iter().map(|(_, permitted)| permitted.len()).sum();
    let each = seconds / pairs as f64;
    let rounds = (each / LONGEST).ceil().max(1.0) as u64;
    // A whole number of milliseconds, so that the commands of the page name it exactly.
    let length = (1e3 * each / rounds as f64).round() / 1e3;
    let length = length.max(SHORTEST);
    let mut outcomes = Played::open(seconds, first_seed)?;
    let all = pairs * rounds as usize;
    for round in 0..rounds {
        for (stage, permitted) in &stages {
            for profile in permitted {
                let player = Player {
                    module: stage.module.clone(),
                    level: stage.level.clone(),
                    profile: *profile,
                    seed: first_seed + round,
                    seconds: length,
                };
                if outcomes.has(&player) {
                    continue;
                }
                let folder = scratch();
                let (outcome, _) = play(&player, stage, folder.path(), guard)?;
                outcomes.add(outcome, all)?;
            }
            // So that a soak that is stopped leaves a page.
            let page = page::page(
                &stages,
                &outcomes.outcomes,
                seconds,
                first_seed,
                guard,
                length,
            );
            let csv = page::csv(&outcomes.outcomes);
            write("hands.md", &page)?;
            write("hands.csv", &csv)?;
        }
    }
    let outcomes = outcomes.outcomes;
    let is_broken = |outcome: &&Outcome| matches!(outcome.ended, Ended::Broken(_));
    Ok(!outcomes.iter().any(|outcome| is_broken(&outcome)))
}

/// Writes a file of the results.
fn write(name: &str, text: &str) -> Result<(), String> {
    let path = repository().join("tests/results").join(name);
    fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))
}

/// What was played, also in a file: one outcome a line, below the digest of the tree that played it.
struct Played {
    outcomes: Vec<Outcome>,
    path: PathBuf,
}

impl Played {
    fn open(seconds: f64, seed: u64) -> Result<Self, String> {
        let path = tree().with_file_name(format!("hands-{seconds}-{seed}.jsonl"));
        let error = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        let digest = format!("{:016x}", digest(&tree())?);
        let text = fs::read_to_string(&path).unwrap_or_default();
        let mut lines = text.lines();
        let mut outcomes = Vec::new();
        if lines.next() == Some(&digest) {
            // The last line may be half of one.
            outcomes.extend(lines.filter_map(|line| serde_json::from_str(line).ok()));
        }
        let mut text = digest + "\n";
        for outcome in &outcomes {
            text += &serde_json::to_string(outcome).map_err(|e| error(&e))?;
            text.push('\n');
        }
        fs::write(&path, text).map_err(|e| error(&e))?;
        eprintln!("{} runs are in {} already", outcomes.len(), path.display());
        Ok(Self { outcomes, path })
    }

    fn has(&self, player: &Player) -> bool {
        self.outcomes
            .iter()
            .any(|outcome| outcome.player == *player)
    }

    fn add(&mut self, outcome: Outcome, all: usize) -> Result<(), String> {
        let error = |e: &dyn std::fmt::Display| format!("{}: {e}", self.path.display());
        let mut line = serde_json::to_string(&outcome).map_err(|e| error(&e))?;
        line.push('\n');
        let file = OpenOptions::new().append(true).open(&self.path);
        let written = file.and_then(|mut file| file.write_all(line.as_bytes()));
        written.map_err(|e| error(&e))?;
        self.outcomes.push(outcome);
        let outcome = self.outcomes.last().expect("it was added");
        eprintln!(
            "{}/{all} {}: {:?}, {} {:?}, held {}, peak {:.0} mN, most {:.0} ms, real-time factor {:.2}",
            self.outcomes.len(),
            outcome.player.name(),
            outcome.ended,
            outcome.verdict,
            outcome.failed,
            outcome.solver.map_or(0, |solver| solver.held),
            1e3 * outcome.peak(),
            outcome.costs.most,
            outcome.real_time_factor()
        );
        Ok(())
    }
}

/// Of all that decides a run: the program, plugins, modules and settings of the built tree, as the tree lists and holds them (FNV-1a).
fn digest(tree: &Path) -> Result<u64, String> {
    let mut files = Vec::new();
    for name in ["microsim", "plugins", "modules", "config"] {
        collect(&tree.join(name), &mut files).map_err(|e| format!("{name}: {e}"))?;
    }
    files.sort();
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for file in files {
        let bytes = fs::read(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        for byte in bytes {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    Ok(hash)
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    if !path.is_dir() {
        files.push(path.to_path_buf());
        return Ok(());
    }
    for entry in fs::read_dir(path)? {
        collect(&entry?.path(), files)?;
    }
    Ok(())
}
