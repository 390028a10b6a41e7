//! The section of a level: verdicts that change, and the spread of each metric beside the difference of the groups.

use super::super::limits::Limits;
use microsim_tests::changed_levels::CHANGES;
use microsim_tests::sensitivity::{Dependence, MOST_SPREAD, Outcome, Runs};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// What is known of a metric.
pub struct Metric {
    pub title: String,
    pub limited: bool,
}

/// With the runs of before, if there are any, beside those of now.
pub fn section(
    title: &str,
    runs: &Runs,
    before: Option<&Runs>,
    metrics: &BTreeMap<String, Metric>,
    limits: &Limits,
) -> String {
    let mut out = title.to_owned();
    if !limits.taken_off.is_empty() {
        let list = limits.taken_off.join(", ");
        let _ = write!(out, " Not limited any more: {list}.");
    }
    if !limits.moved.is_empty() {
        let list = limits.moved.join(", ");
        let _ = write!(out, " Limited otherwise now: {list}.");
    }
    out.push_str(
        "\n\n| level | passed | failed | not judged | other verdict than as shipped | other reasons | other verdict without limits taken off |\n|---|---|---|---|---|---|---|\n",
    );
    for (name, _) in CHANGES {
        verdicts(&mut out, name, runs, name, limits);
    }
    for (name, _) in CHANGES {
        if let Some(before) = before {
            verdicts(&mut out, &format!("before: {name}"), before, name, limits);
        }
    }
    out.push_str("\n| metric | limited | experts | novices | difference |");
    for (name, _) in &CHANGES[1..] {
        let _ = write!(out, " spread: {name} |");
    }
    out.push_str(" largest spread over difference |");
    let mut columns = 6 + CHANGES.len() - 1;
    if before.is_some() {
        out.push_str(" of the changes that before was played at | before |");
        columns += 2;
    }
    let _ = writeln!(out, "\n|{}", "---|".repeat(columns));
    for (id, metric) in metrics {
        spreads(&mut out, runs, before, id, metric);
    }
    out
}

/// The row of what came of the runs at a change, as `title`.
fn verdicts(out: &mut String, title: &str, runs: &Runs, change: &str, limits: &Limits) {
    let of_change = runs.iter().filter(|((.., level), _)| level == change);
    // Each with the run of the same trainee, the level as shipped.
    let pairs: Vec<(&Outcome, &Outcome)> = of_change
        .map(|((kind, seed, _), run)| {
            let shipped = (kind.clone(), *seed, CHANGES[0].0.to_owned());
            (run, &runs[&shipped])
        })
        .collect();
    if pairs.is_empty() {
        let _ = writeln!(out, "| {title} | not played | | | | | |");
        return;
    }
    let with = |verdict: &str| {
        let with = pairs.iter().filter(|(run, _)| run.verdict == verdict);
        with.count()
    };
    let differ = |differ: &dyn Fn(&Outcome, &Outcome) -> bool| {
        let differ = pairs.iter().filter(|(run, shipped)| differ(run, shipped));
        differ.count()
    };
    let now = |run: &Outcome| limits.verdict_now(&run.verdict, &run.failed).to_owned();
    let percent = |count: usize| {
        let percent = 100.0 * count as f64 / pairs.len() as f64;
        format!("{count} of {} ({percent:.0} %)", pairs.len())
    };
    let _ = writeln!(
        out,
        "| {title} | {} | {} | {} | {} | {} | {} |",
        with("passed"),
        with("failed"),
        with("not-judged"),
        percent(differ(&|run, shipped| run.verdict != shipped.verdict)),
        differ(&|run, shipped| run.failed != shipped.failed),
        percent(differ(&|run, shipped| now(run) != now(shipped))),
    );
}

/// The row of a metric.
fn spreads(out: &mut String, runs: &Runs, before: Option<&Runs>, id: &str, metric: &Metric) {
    let limited = if metric.limited { "yes" } else { "" };
    let _ = write!(out, "| {} | {limited} |", metric.title);
    let shown = |ratio: f64| match (metric.limited, ratio > MOST_SPREAD) {
        (true, true) => format!("**{ratio:.2}**"),
        _ => format!("{ratio:.2}"),
    };
    match Dependence::of(runs, id) {
        None => {
            out.push_str(&" – |".repeat(3 + CHANGES.len()));
        }
        Some(found) => {
            let [experts, novices] = found.means;
            let difference = found.difference();
            let _ = write!(out, " {experts:.4} | {novices:.4} | {difference:.4} |");
            for spread in found.spreads {
                let spread = spread.map_or("–".into(), |spread| format!("{spread:.4}"));
                let _ = write!(out, " {spread} |");
            }
            let _ = write!(out, " {} |", shown(found.ratio()));
        }
    }
    if let Some(before) = before {
        let played = |level: &str| before.keys().any(|(.., of)| of == level);
        let same = runs.iter().filter(|((.., level), _)| played(level));
        let same: Runs = same.map(|(key, run)| (key.clone(), run.clone())).collect();
        for runs in [&same, before] {
            let ratio = Dependence::of(runs, id).map(|found| shown(found.ratio()));
            let _ = write!(out, " {} |", ratio.unwrap_or_else(|| "–".into()));
        }
    }
    out.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(of: &[(&str, u64, usize, &str, f64)]) -> Runs {
        let run = |(kind, seed, change, verdict, value): &(&str, u64, usize, &str, f64)| {
            let outcome = Outcome {
                verdict: (*verdict).to_owned(),
                failed: String::new(),
                values: [("torn".to_owned(), *value)].into(),
            };
            let change = CHANGES[*change].0.to_owned();
            (((*kind).to_owned(), *seed, change), outcome)
        };
        of.iter().map(run).collect()
    }

    /// By hand: the groups differ by 5; the run of expert 1 changes by 3 at twice the iterations and by 10 on the finer mesh, before by 4.
    #[test]
    fn runs_of_before_stand_beside_those_of_now() {
        let shipped = [
            ("expert", 1, 0, "passed", 1.0),
            ("expert", 2, 0, "passed", 3.0),
            ("novice", 1, 0, "passed", 6.0),
            ("novice", 2, 0, "passed", 8.0),
        ];
        let with = |more: &[_]| runs(&[&shipped[..], more].concat());
        let before = with(&[("expert", 1, 1, "failed", 5.0)]);
        let now = with(&[
            ("expert", 1, 1, "passed", 4.0),
            ("expert", 1, 3, "passed", 11.0),
        ]);
        let metric = Metric {
            title: "Torn area".into(),
            limited: true,
        };
        let metrics = [("torn".to_owned(), metric)].into();
        let limits = Limits::compared(None, "").expect("limits");
        let page = section("## title", &now, Some(&before), &metrics, &limits);
        let row = |start: &str| {
            let row = page.lines().find(|line| line.starts_with(start));
            row.unwrap_or_else(|| panic!("no {start} in {page}"))
        };
        assert_eq!(
            row("| twice the iterations |"),
            "| twice the iterations | 1 | 0 | 0 | 0 of 1 (0 %) | 0 | 0 of 1 (0 %) |"
        );
        assert_eq!(
            row("| before: twice the iterations |"),
            "| before: twice the iterations | 0 | 1 | 0 | 1 of 1 (100 %) | 0 | 1 of 1 (100 %) |"
        );
        assert!(row("| before: finer mesh |").contains("not played"));
        assert_eq!(
            row("| Torn area |"),
            "| Torn area | yes | 2.0000 | 7.0000 | 5.0000 | 3.0000 | – | 10.0000 | **2.00** | **0.60** | **0.80** |"
        );
    }
}
