//! `microsim report`, and the files that `run` writes beside a session.

use crate::cli::{Place, ReportArgs};
use crate::key_pictures::{key_pictures, not_asked};
use crate::output::{Exit, Problem, print, print_long};
use crate::records;
use crate::replace_file::replace;
use crate::series_table;
use crate::session_file::{find, installation, read_around, report_of, verdict_word};
use crate::sessions::files_beside;
use microsim_report::{Language, Page, Report, Verdict};
use microsim_table::Format;
use std::path::{Path, PathBuf};

/// Shows the result of a session.
pub fn report(place: &Place, args: &ReportArgs) -> Result<Exit, Problem> {
    let path = find(place, &args.session);
    let session = read_around(&path)?;
    let report = report_of(&session, &path)?;
    let same = |other: &PathBuf| other.canonicalize().ok() == path.canonicalize().ok();
    if [&args.html, &args.csv, &args.series, &args.table]
        .into_iter()
        .flatten()
        .any(same)
    {
        return Err("the report would overwrite the session; give it another name".into());
    }
    if let Some(html) = &args.html {
        let installation = installation(place)?;
        let page = Page {
            language: args
                .lang
                .as_deref()
                .and_then(Language::from_name)
                .unwrap_or(installation.host.report.language),
            pictures: match args.pictures {
                true => key_pictures(&installation, &path, &report, 1),
                false => not_asked(),
            },
        };
        replace(html, report.to_html(&page).as_bytes())?;
    }
    if let Some(path) = &args.csv {
        replace(path, report.metrics_csv().as_bytes())?;
    }
    if let Some(path) = &args.series {
        replace(path, report.series_csv().as_bytes())?;
    }
    if let (Some(path), Some(format)) = (&args.table, args.table.as_deref().and_then(Format::of)) {
        series_table::write(&report, format, path)?;
    }
    let written = [&args.html, &args.csv, &args.series, &args.table];
    let written: Vec<&Path> = written
        .into_iter()
        .flatten()
        .map(PathBuf::as_path)
        .collect();
    records::attach(place, &session, &path, &written);
    if args.json {
        print_long(|out| report.write_json(out))?;
    } else {
        print(summary(&report))?;
        if let Some(name) = records::name_of(place, &session) {
            print(format!("  trainee {name}"))?;
        }
    }
    Ok(Exit::Done)
}

/// Writes the files beside a session. Returns the page's path.
pub fn write_beside(report: &Report, content: &Page, session: &Path) -> Result<PathBuf, Problem> {
    let [page, json, metrics, series] = files_beside(session);
    replace(&page, report.to_html(content).as_bytes())?;
    replace(&json, report.to_json().as_bytes())?;
    replace(&metrics, report.metrics_csv().as_bytes())?;
    replace(&series, report.series_csv().as_bytes())?;
    Ok(page)
}

/// Writes the page beside a session again.
pub fn write_page(report: &Report, content: &Page, session: &Path) -> Result<(), Problem> {
    let [page, ..] = files_beside(session);
    replace(&page, report.to_html(content).as_bytes())
}

/// The report in a few lines.
pub fn summary(report: &Report) -> String {
    let s = &report.session;
    let mut lines = vec![format!(
        "{}, level {}: {}",
        s.module_title.en, s.level, s.level_title.en
    )];
    lines.push(format!(
        "  {}{}, {} of {} targets, {:.1} s",
        verdict_word(report.verdict).to_uppercase(),
        if report.counts { "" } else { " (no result)" },
        report.targets_done,
        report.targets,
        report.duration
    ));
    if let Some(made) = &s.synthetic {
        lines.push(format!("    synthetic trainee: {made}"));
    }
    if s.mirrored {
        lines.push("    left-handed: the level was mirrored".into());
    }
    if !s.changed_files.is_empty() {
        lines.push(format!(
            "    not the level that was installed: {}",
            s.changed_files.join(", ")
        ));
    }
    for (id, text) in report.failed.iter().zip(&report.reasons) {
        lines.push(format!("    {id}: {}", text.en));
    }
    if let (Verdict::Failed, Some(text)) = (report.verdict, s.foreign_hand()) {
        lines.push(format!("    {}", text.en));
    }
    if let Some(text) = report.left_out() {
        lines.push(format!("    {}", text.en));
    }
    if report.verdict == Verdict::NotJudged {
        let reasons = report.reasons.iter();
        lines.extend(reasons.map(|why| format!("    {}", why.en)));
    }
    for failure in &s.failures {
        lines.push(format!("    {failure}"));
    }
    if let Some(complaint) = &s.complaint {
        lines.push(format!("    {complaint}"));
    }
    if let Some(score) = report.score {
        let categories: Vec<String> = report
            .categories
            .iter()
            .map(|c| format!("{} {:.1}", c.title.en, c.score))
            .collect();
        lines.push(format!("  score {score:.1} ({})", categories.join(", ")));
    }
    for metric in &report.metrics {
        let Some(value) = metric.display_value else {
            continue;
        };
        let record = &metric.record;
        let limit = match (metric.display_min, metric.display_max) {
            (None, None) => String::new(),
            (min, max) => {
                let bound = |sign: &str, v: Option<f64>| {
                    v.map(|v| format!(" {sign} {v:.4}")).unwrap_or_default()
                };
                let decides = record.limit.as_ref().is_none_or(|limit| limit.decides);
                let (name, mark) = match (decides, record.within) {
                    (true, Some(false)) => ("limit", "  OUTSIDE"),
                    (true, _) => ("limit", ""),
                    (false, Some(false)) => ("reference value", "  outside"),
                    (false, _) => ("reference value", ""),
                };
                format!(
                    "  ({name}{}{}){mark}",
                    bound("at least", min),
                    bound("at most", max)
                )
            }
        };
        lines.push(format!(
            "  {:<28} {value:>12.4} {}{limit}",
            record.title.en, record.display_unit
        ));
    }
    for device in &report.input {
        lines.push(format!(
            "  input \"{}\": {} samples, {} segments, {} gaps, path {:.3} mm",
            device.device, device.samples, device.segments, device.gaps, device.path_mm
        ));
    }
    for tool in report.presence.iter().filter(|tool| tool.lost() > 0.0) {
        lines.push(format!(
            "  tool \"{}\": tracked {:.1} s, occluded {:.1} s, stale {:.1} s, never seen {:.1} s",
            tool.tool, tool.tracked, tool.occluded, tool.stale, tool.never_seen
        ));
    }
    lines.extend(
        report
            .markers
            .iter()
            .map(|markers| format!("  {}", markers.words())),
    );
    lines.extend(
        report
            .arrivals
            .iter()
            .map(|arrivals| format!("  {}", arrivals.words())),
    );
    if let Some(hash) = &s.state_hash {
        lines.push(format!("  state hash {hash}"));
    }
    lines.join("\n")
}
