//! The page and the table of all runs.

use microsim_tests::hands::cost::Costs;
use microsim_tests::hands::played::{Ended, Guard, Outcome, Solver};
use microsim_tests::hands::stage::Stage;
use microsim_tests::hands::{Player, Profile};
use microsim_tests::trainees::ABSURD_FORCE;
use std::fmt::Write as _;

const PAGE: &str = include_str!("page.md");

/// A picture may take so long \[ms\], by `p99.9` of all.
const PICTURE: f64 = 16.0;
/// Fraction of ticks that may go over their budget.
const OVER_BUDGET: f64 = 1e-3;
/// A profile does what it is named for: on tissue so often an hour, or in contact for so large a fraction of the ticks.
const ACTS: f64 = 100.0;
const CONTACT: f64 = 0.05;
/// Cases that are named.
const WORST: usize = 10;

/// Runs added up.
#[derive(Default)]
struct Sum {
    runs: usize,
    simulated: f64,
    cpu: f64,
    ticks: u64,
    contact: u64,
    acts: [u64; 2],
    closures: [u64; 2],
    cuts: u64,
    solver: Option<Solver>,
    without_report: usize,
    peak: f64,
    too_strong: u64,
    costs: Costs,
    stalled: usize,
    broken: usize,
    passed: usize,
    tools_touched: Option<u64>,
}

impl Sum {
    fn of<'a>(outcomes: impl Iterator<Item = &'a Outcome>, tick: f64) -> Self {
        let mut sum = Self::default();
        for outcome in outcomes {
            sum.runs += 1;
            sum.simulated += outcome.simulated;
            sum.cpu += outcome.cpu;
            sum.ticks += (outcome.simulated / tick).round() as u64;
            sum.contact += outcome.contact;
            for at in 0..2 {
                sum.acts[at] += outcome.acts[at];
                sum.closures[at] += outcome.closures[at];
            }
            sum.cuts += outcome.cuts;
            if let Some(solver) = &outcome.solver {
                let total = sum.solver.get_or_insert_default();
                total.ticks += solver.ticks;
                total.held += solver.held;
                total.unconverged += solver.unconverged;
                total.invalid += solver.invalid;
                total.repeated += solver.repeated;
                total.worst_residual = total.worst_residual.max(solver.worst_residual);
                if let Some(over) = solver.over_budget {
                    *total.over_budget.get_or_insert_default() += over;
                }
            }
            sum.without_report += usize::from(outcome.verdict.is_empty());
            sum.peak = sum.peak.max(outcome.peak());
            sum.too_strong += outcome.too_strong;
            sum.costs.append(&outcome.costs);
            sum.stalled += usize::from(outcome.ended == Ended::Stalled);
            sum.broken += usize::from(matches!(outcome.ended, Ended::Broken(_)));
            sum.passed += usize::from(outcome.verdict == "passed");
            if let Some(touched) = outcome.tools_touched {
                *sum.tools_touched.get_or_insert_default() += touched;
            }
        }
        sum
    }

    fn contact_share(&self) -> f64 {
        self.contact as f64 / self.ticks.max(1) as f64
    }

    /// Times an hour.
    fn hourly(&self, count: u64) -> f64 {
        3600.0 * count as f64 / self.simulated.max(1e-9)
    }
}

fn is_of(outcome: &Outcome, stage: &Stage) -> bool {
    outcome.player.module == stage.module && outcome.player.level == stage.level
}

/// The page.
pub fn page(
    stages: &[(Stage, Vec<Profile>)],
    outcomes: &[Outcome],
    seconds: f64,
    seed: u64,
    guard: Guard,
    length: f64,
) -> String {
    let all = Sum::of(outcomes.iter(), tick(stages));
    let touched = match all.tools_touched {
        None => "not reported by the simulator: tools pass through each other".to_owned(),
        Some(count) => format!(
            "reported: {count} ticks, of levels whose tools touch each other (`tools_touch`); in others they pass through each other"
        ),
    };
    let simulated = format!("{:.0}", all.simulated);
    let values: [(&str, String); 13] = [
        ("seconds", seconds.to_string()),
        ("seed", seed.to_string()),
        ("runs", outcomes.len().to_string()),
        ("length", length.to_string()),
        ("simulated", simulated),
        ("guard_cpu", guard.cpu.to_string()),
        ("guard_wall", guard.wall.to_string()),
        ("limit", ABSURD_FORCE.to_string()),
        ("tools_touched", touched),
        ("not_met", not_met(stages, outcomes, &all)),
        ("worst", worst(outcomes)),
        ("table", table(stages, outcomes)),
        ("passed", passed(outcomes)),
    ];
    let mut page = PAGE.to_owned();
    for (key, value) in values {
        page = page.replace(&format!("{{{key}}}"), value.trim_end());
    }
    page
}

/// The tick that all levels have.
fn tick(stages: &[(Stage, Vec<Profile>)]) -> f64 {
    stages.first().map_or(f64::NAN, |(stage, _)| stage.tick)
}

/// What is expected of all runs, and what came out.
fn not_met(stages: &[(Stage, Vec<Profile>)], outcomes: &[Outcome], all: &Sum) -> String {
    let solver = all.solver.unwrap_or_default();
    let mut list = Vec::new();
    let mut check = |met: bool, expected: String, found: String| {
        if !met {
            list.push(format!("- {expected}: {found}."));
        }
    };
    let held = format!("{} of {} ticks with tissue", solver.held, solver.ticks);
    check(solver.held == 0, "no held tick".into(), held);
    match solver.over_budget {
        Some(over) => check(
            over as f64 <= OVER_BUDGET * solver.ticks as f64,
            format!(
                "over budget in at most {} % of the ticks",
                100.0 * OVER_BUDGET
            ),
            format!("{over} of {}", solver.ticks),
        ),
        None => check(
            false,
            "ticks over their budget".into(),
            "the simulator has no budget and does not report any".into(),
        ),
    }
    let p999 = all.costs.percentile(0.999);
    check(
        p999 <= PICTURE,
        format!("p99.9 of CPU time per 16 ms at most {PICTURE} ms"),
        format!(
            "{p999:.1} ms over all levels, {:.0} ms at most",
            all.costs.most
        ),
    );
    let strong = format!(
        "{} ticks and tools, the worst {:.2} N",
        all.too_strong, all.peak
    );
    check(
        all.too_strong == 0,
        format!("no force above {ABSURD_FORCE} N"),
        strong,
    );
    let finite = outcomes.iter().filter(|outcome| !outcome.is_finite).count();
    check(
        finite == 0,
        "forces are finite".into(),
        format!("not in {finite} runs"),
    );
    check(
        all.stalled == 0,
        "no run is too slow to wait for".into(),
        format!("{} of {} stalled", all.stalled, all.runs),
    );
    check(
        all.broken == 0,
        "every run ends with a report".into(),
        format!("{} broke off", all.broken),
    );
    check(
        all.tools_touched.is_some(),
        "contacts of tool with tool are counted".into(),
        "not reported".into(),
    );
    for (stage, permitted) in stages.iter().filter(|(stage, _)| stage.tissue.is_some()) {
        for profile in permitted {
            let of = |o: &&Outcome| is_of(o, stage) && o.player.profile == *profile;
            let sum = Sum::of(outcomes.iter().filter(of), stage.tick);
            let acts = sum.hourly(sum.acts[1]);
            check(
                sum.runs == 0 || acts >= ACTS || sum.contact_share() >= CONTACT,
                format!(
                    "{}, level {}, {} does what it is named for",
                    stage.module,
                    stage.level,
                    profile.name()
                ),
                format!(
                    "{acts:.0} {} an hour on tissue, contact in {:.1} % of the ticks",
                    profile.act(),
                    100.0 * sum.contact_share()
                ),
            );
        }
    }
    if list.is_empty() {
        return "Nothing.".into();
    }
    list.join("\n")
}

/// How bad a run is: broken and stalled ones first, then by the factor by which it misses what is expected, added up on a logarithmic scale.
fn badness(outcome: &Outcome) -> f64 {
    let solver = outcome.solver.unwrap_or_default();
    let excess = |ratio: f64| libm::log(ratio.max(1.0));
    let ended = match outcome.ended {
        Ended::Report => 0.0,
        Ended::Stalled => 10.0,
        Ended::Broken(_) => 20.0,
    };
    ended
        + excess(1.0 + solver.held as f64)
        + excess(outcome.peak() / ABSURD_FORCE)
        + excess(outcome.costs.percentile(0.999) / PICTURE)
        + excess(1.0 / outcome.real_time_factor())
}

fn worst(outcomes: &[Outcome]) -> String {
    let mut sorted: Vec<&Outcome> = outcomes.iter().filter(|o| badness(o) > 0.0).collect();
    sorted.sort_by(|a, b| badness(b).total_cmp(&badness(a)));
    let mut text = String::from(
        "| `--script` … | ended | held | worst force [N] | grip [N] | CPU per 16 ms: p99.9, most [ms] | factor |\n|---|---|---|---|---|---|---|\n",
    );
    for outcome in sorted.iter().take(WORST) {
        let Player {
            module,
            level,
            profile,
            seed,
            seconds,
        } = &outcome.player;
        let _ = writeln!(
            text,
            "| `{module} {level} {} {seed} {seconds}` | {} | {} | {:.2} | {:.2} | {:.1}, {:.0} | {:.2} |",
            profile.name(),
            ended(&outcome.ended),
            outcome.solver.map_or("–".into(), |s| s.held.to_string()),
            outcome.peak(),
            outcome.grip,
            outcome.costs.percentile(0.999),
            outcome.costs.most,
            outcome.real_time_factor()
        );
    }
    text
}

fn ended(ended: &Ended) -> String {
    match ended {
        Ended::Report => "report".into(),
        Ended::Stalled => "stalled".into(),
        Ended::Broken(why) => format!("broken: {}", why.replace('|', "/")),
    }
}

fn table(stages: &[(Stage, Vec<Profile>)], outcomes: &[Outcome]) -> String {
    let mut text = String::from(
        "| level | profile | runs, s | contact | acts an hour, on tissue | closures | cuts | held | over budget | unconverged | worst residual | worst force [N] | > 1 N | \
         CPU per 16 ms: p50, p99, p99.9, most [ms] | factor | stalled | passed |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (stage, permitted) in stages {
        for profile in Profile::ALL {
            let level = format!("{} {}", stage.module, stage.level);
            if !permitted.contains(&profile) {
                let _ = writeln!(
                    text,
                    "| {level} | {} | not permitted: {} |{}",
                    profile.name(),
                    match profile {
                        Profile::Swapping => "one tool",
                        _ => "no jaws",
                    },
                    " |".repeat(14)
                );
                continue;
            }
            let of = |o: &&Outcome| is_of(o, stage) && o.player.profile == profile;
            let sum = Sum::of(outcomes.iter().filter(of), stage.tick);
            let solver =
                |of: &dyn Fn(&Solver) -> String| sum.solver.as_ref().map_or("–".to_owned(), of);
            let cost = |share: f64| sum.costs.percentile(share);
            let tissue = |value: String| {
                if stage.tissue.is_some() {
                    value
                } else {
                    "–".into()
                }
            };
            let _ = writeln!(
                text,
                "| {level} | {} | {}, {:.0} | {} | {:.0}, {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.2}, {:.1}, {:.1}, {:.0} | {:.2} | {} | {} |",
                profile.name(),
                sum.runs,
                sum.simulated,
                tissue(format!("{:.0} %", 100.0 * sum.contact_share())),
                sum.hourly(sum.acts[0]),
                tissue(format!("{:.0}", sum.hourly(sum.acts[1]))),
                tissue(format!("{}/{}", sum.closures[1], sum.closures[0])),
                tissue(sum.cuts.to_string()),
                solver(&|s| s.held.to_string()),
                solver(&|s| s
                    .over_budget
                    .map_or("not reported".into(), |n| n.to_string())),
                solver(&|s| format!(
                    "{:.0} %",
                    100.0 * s.unconverged as f64 / s.ticks.max(1) as f64
                )),
                solver(&|s| format!("{:.1e}", s.worst_residual)),
                tissue(format!("{:.3}", sum.peak)),
                tissue(sum.too_strong.to_string()),
                cost(0.5),
                cost(0.99),
                cost(0.999),
                sum.costs.most,
                sum.simulated / sum.cpu,
                sum.stalled + sum.broken,
                sum.passed
            );
        }
    }
    text
}

fn passed(outcomes: &[Outcome]) -> String {
    let lines = outcomes.iter().filter(|o| o.verdict == "passed").map(|o| {
        format!(
            "- `{} {} {} {} {}`: {} of {} targets; {}",
            o.player.module,
            o.player.level,
            o.player.profile.name(),
            o.player.seed,
            o.player.seconds,
            o.targets[0],
            o.targets[1],
            o.passed_by
        )
    });
    let lines: Vec<String> = lines.collect();
    if lines.is_empty() {
        return "None.".into();
    }
    lines.join("\n")
}

/// A row for each run.
pub fn csv(outcomes: &[Outcome]) -> String {
    let mut text = String::from(
        "module,level,profile,seed,seconds,ended,verdict,failed,targets_done,targets,simulated_s,ticks_of_solver,over_budget,held,unconverged,invalid,repeated,\
         residual_max,peaks_N,grip_N,above_limit,contact_ticks,acts,acts_on_tissue,closures,closures_on_tissue,cuts,tools_touched,cpu_s,process_cpu_s,p50_ms,p99_ms,p999_ms,max_ms\n",
    );
    for o in outcomes {
        let solver = |of: &dyn Fn(&Solver) -> String| o.solver.as_ref().map_or(String::new(), of);
        let number = |n: Option<u64>| n.map_or(String::new(), |n| n.to_string());
        let peaks: Vec<String> = o
            .peaks
            .iter()
            .map(|(tool, force)| format!("{tool} {force:.6}"))
            .collect();
        let cells = [
            o.player.module.clone(),
            o.player.level.to_string(),
            o.player.profile.name().to_owned(),
            o.player.seed.to_string(),
            o.player.seconds.to_string(),
            match o.ended {
                Ended::Report => "report",
                Ended::Stalled => "stalled",
                Ended::Broken(_) => "broken",
            }
            .to_owned(),
            o.verdict.clone(),
            o.failed.join(" "),
            o.targets[0].to_string(),
            o.targets[1].to_string(),
            format!("{:.3}", o.simulated),
            solver(&|s| s.ticks.to_string()),
            solver(&|s| number(s.over_budget)),
            solver(&|s| s.held.to_string()),
            solver(&|s| s.unconverged.to_string()),
            solver(&|s| s.invalid.to_string()),
            solver(&|s| s.repeated.to_string()),
            solver(&|s| format!("{:.2e}", s.worst_residual)),
            peaks.join(" "),
            format!("{:.6}", o.grip),
            o.too_strong.to_string(),
            o.contact.to_string(),
            o.acts[0].to_string(),
            o.acts[1].to_string(),
            o.closures[0].to_string(),
            o.closures[1].to_string(),
            o.cuts.to_string(),
            number(o.tools_touched),
            format!("{:.3}", o.cpu),
            format!("{:.2}", o.process_cpu),
            format!("{:.3}", o.costs.percentile(0.5)),
            format!("{:.3}", o.costs.percentile(0.99)),
            format!("{:.3}", o.costs.percentile(0.999)),
            format!("{:.3}", o.costs.most),
        ];
        text += &cells.join(",");
        text.push('\n');
    }
    text
}
