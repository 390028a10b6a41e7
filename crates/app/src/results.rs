//! `microsim results`.

use crate::cli::{Place, ResultsArgs};
use crate::date;
use crate::evaluation::{is_better, learning_curve, pairs, same_level, standings};
use crate::names::name_or_id;
use crate::output::{Exit, Problem, print, print_json, print_long};
use crate::records::{find, must_read, text};
use crate::result_table;
use microsim_settings::unwritable;
use microsim_store::{Filter, Measured, NamedSession, PopulationRecord, Session, Store, Verdict};
use microsim_table::Format;
use microsim_training::{CusumCurve, CusumDecision, CusumPlan, Standing};
use serde_json::{Value, json};
use std::path::Path;

/// Finds results.
pub fn results(place: &Place, args: &ResultsArgs) -> Result<Exit, Problem> {
    let store = must_read(place)?;
    if let [a, b] = &args.compare[..] {
        return compare(&store, [a, b], args.json);
    }
    let trainee = args.trainee.as_deref();
    let filter = Filter {
        trainee: trainee
            .map(|who| Ok::<_, Problem>(find(&store, who)?.id))
            .transpose()?,
        group: args.group.clone(),
        module: args.module.clone(),
        level: args.level,
        since: args.since,
    };
    if let Some(path) = &args.export {
        return export(&store, &filter, args, path);
    }
    let found = store.results(&filter, args.json)?;
    let one_level = filter.trainee.is_some() && filter.module.is_some() && filter.level.is_some();
    let curve = one_level.then(|| learning_curve(&found));
    if args.json {
        let populations = match (&filter.module, filter.level) {
            (Some(module), Some(level)) => store.populations(Some((module, level)))?,
            _ => store.populations(None)?,
        };
        let results: Vec<Value> = found
            .iter()
            .map(|named| document(named, &populations))
            .collect();
        print_json(&json!({
            "results": results,
            "learning_curve": curve.as_ref().map(curve_document),
        }))?;
        return Ok(Exit::Done);
    }
    print_long(|out| {
        for named in &found {
            writeln!(out, "{}", line(named))?;
        }
        write!(out, "{} sessions", found.len())
    })?;
    if let Some(curve) = curve {
        print(curve_line(&curve))?;
    }
    Ok(Exit::Done)
}

fn export(
    store: &Store,
    filter: &Filter,
    args: &ResultsArgs,
    path: &Path,
) -> Result<Exit, Problem> {
    let format = Format::of(path)
        .ok_or_else(|| unwritable(path, std::io::ErrorKind::InvalidInput.into()))?;
    let sessions = result_table::write(store, filter, !args.no_names, format, path)?;
    match args.json {
        true => print_json(&json!({ "sessions": sessions, "file": path }))?,
        false => print(format!("{sessions} sessions are in {}", path.display()))?,
    }
    Ok(Exit::Done)
}

/// A session on one line.
fn line(named: &NamedSession) -> String {
    let session = &named.session;
    let score = session
        .score
        .map_or_else(|| "   –".into(), |score| format!("{score:5.1}"));
    let verdict = match (session.counts, session.verdict) {
        (true, verdict)
        | (false, verdict @ (Verdict::Aborted | Verdict::NotJudged | Verdict::Incomplete)) => {
            verdict.name().to_owned()
        }
        (false, verdict) => format!("({})", verdict.name()),
    };
    let synthetic = if session.synthetic.is_some() {
        "  synthetic"
    } else {
        ""
    };
    let failed = match session.failed.is_empty() {
        true => String::new(),
        false => format!("  {}", session.failed.join(", ")),
    };
    format!(
        "{}  {}  {:<18} {verdict:<11} score {score}  {:6.1} s  {}{synthetic}{failed}",
        date::shown(session.started),
        session.id.short(),
        format!("{} {}", session.module, session.level),
        session.duration,
        name_or_id(named.name.as_deref(), session.trainee),
    )
}

fn decision_word(decision: CusumDecision) -> &'static str {
    match decision {
        CusumDecision::Acceptable => "acceptable",
        CusumDecision::Unacceptable => "unacceptable",
    }
}

fn curve_document(curve: &CusumCurve) -> Value {
    let plan = CusumPlan::published();
    let [acceptable, unacceptable] = plan.rates();
    json!({
        "acceptable_failure_rate": acceptable,
        "unacceptable_failure_rate": unacceptable,
        "step": plan.step(),
        "lower_limit": plan.lower(),
        "upper_limit": plan.upper(),
        "values": curve.values,
        "decision": curve.decision.map(|(_, decision)| decision_word(decision)),
        "decided_with_attempt": curve.decision.map(|(attempt, _)| attempt + 1),
    })
}

fn curve_line(curve: &CusumCurve) -> String {
    let plan = CusumPlan::published();
    let [acceptable, unacceptable] = plan.rates().map(|rate| 100.0 * rate);
    let decided = match curve.decision {
        Some((attempt, CusumDecision::Acceptable)) => format!(
            "from attempt {} on closer to {acceptable:.0} % of failures than to {unacceptable:.0} %",
            attempt + 1
        ),
        Some((attempt, CusumDecision::Unacceptable)) => format!(
            "from attempt {} on closer to {unacceptable:.0} % of failures than to {acceptable:.0} %",
            attempt + 1
        ),
        None => "not decided yet".to_owned(),
    };
    format!(
        "Learning curve: CUSUM {:.2} after {} attempts (limits {:.2} and {:.2}): {decided}",
        curve.values.last().copied().unwrap_or_default(),
        curve.values.len(),
        plan.lower(),
        plan.upper()
    )
}

/// Where a value stands in a population.
fn standing_document(record: &PopulationRecord, standing: Standing) -> Value {
    let (percent, bound) = match standing {
        Standing::At(percent) => (percent, "at"),
        Standing::Below(percent) => (percent, "below"),
        Standing::Above(percent) => (percent, "above"),
    };
    json!({
        "source": record.source,
        "n": record.n,
        "percentile": percent,
        "is": bound,
    })
}

fn measured_document(
    session: &Session,
    measured: &Measured,
    populations: &[PopulationRecord],
) -> Value {
    let standings = standings(session, measured, populations).into_iter();
    let standings = standings.map(|(record, standing)| standing_document(record, standing));
    let standings: Vec<Value> = standings.collect();
    json!({
        "id": measured.metric.id,
        "title": measured.metric.title,
        "unit": measured.metric.unit,
        "direction": measured.metric.direction,
        "category": measured.metric.category,
        "value": measured.value,
        "min": measured.min,
        "max": measured.max,
        "decides": measured.decides,
        "within": measured.within,
        "score": measured.score,
        "populations": standings,
    })
}

fn document(named: &NamedSession, populations: &[PopulationRecord]) -> Value {
    let session = &named.session;
    let metrics = session.metrics.iter();
    let metrics: Vec<Value> = metrics
        .map(|m| measured_document(session, m, populations))
        .collect();
    let categories = session.categories.iter();
    let categories: serde_json::Map<String, Value> = categories
        .map(|(id, score)| (id.clone(), json!(score)))
        .collect();
    json!({
        "session": session.id,
        "file": session.path,
        "trainee": session.trainee,
        "name": named.name,
        "module": session.module,
        "level": session.level,
        "started": date::iso(session.started),
        "finished": session.finished,
        "seed": session.seed,
        "input": session.input,
        "version": session.version,
        "realtime": session.realtime,
        "synthetic": session.synthetic,
        "state_hash": session.state_hash,
        "verdict": session.verdict.name(),
        "counts": session.counts,
        "failed": session.failed,
        "duration": session.duration,
        "targets_done": session.targets_done,
        "targets": session.targets,
        "score": session.score,
        "categories": categories,
        "metrics": metrics,
    })
}

/// A session by the beginning of its id, or by its file.
fn session(store: &Store, asked: &str) -> Result<NamedSession, Problem> {
    let path = Path::new(asked);
    Ok(match path.is_file() {
        true => store.find_session(&text(path))?,
        false => store.find_session(asked)?,
    })
}

/// What became of a number, in a word.
fn change(direction: &str, difference: f64) -> &'static str {
    match is_better(direction, difference) {
        Some(true) => "better",
        Some(false) => "worse",
        None => "",
    }
}

fn compare(store: &Store, asked: [&String; 2], as_json: bool) -> Result<Exit, Problem> {
    let [a, b] = [session(store, asked[0])?, session(store, asked[1])?];
    let same_level = same_level(&a.session, &b.session);
    let pairs = pairs(&a.session, &b.session);
    if as_json {
        let metrics = pairs.iter().map(|(of_a, of_b)| {
            let difference = of_a.value.zip(of_b.value).map(|(a, b)| b - a);
            json!({
                "id": of_a.metric.id,
                "title": of_a.metric.title,
                "unit": of_a.metric.unit,
                "a": of_a.value,
                "b": of_b.value,
                "difference": difference,
                "change": difference.map(|d| change(&of_a.metric.direction, d)),
            })
        });
        let metrics: Vec<Value> = metrics.collect();
        let without = |named: &NamedSession| {
            let mut document = document(named, &[]);
            if let Some(fields) = document.as_object_mut() {
                fields.remove("metrics");
            }
            document
        };
        print_json(&json!({
            "a": without(&a),
            "b": without(&b),
            "same_level": same_level,
            "score_difference": a.session.score.zip(b.session.score).map(|(a, b)| b - a),
            "metrics": metrics,
        }))?;
        return Ok(Exit::Done);
    }
    print(format!("A  {}", line(&a)))?;
    print(format!("B  {}", line(&b)))?;
    if !same_level {
        print("Not the same level: values of different tasks are side by side")?;
    }
    print(format!(
        "{:<34} {:>12} {:>12} {:>12}",
        "", "A", "B", "B - A"
    ))?;
    let row =
        |title: &str, values: [Option<f64>; 2], unit: &str, direction: &str, outside: [bool; 2]| {
            let number =
                |value: Option<f64>| value.map_or_else(|| "–".into(), |v| format!("{v:.4}"));
            let difference = values[0].zip(values[1]).map(|(a, b)| b - a);
            let mark = |outside: bool| if outside { "!" } else { " " };
            print(format!(
                "{title:<34} {:>12}{}{:>12}{}{:>12} {unit:<5} {}",
                number(values[0]),
                mark(outside[0]),
                number(values[1]),
                mark(outside[1]),
                number(difference),
                difference.map_or("", |d| change(direction, d)),
            ))
        };
    row(
        "score",
        [a.session.score, b.session.score],
        "",
        "higher",
        [false; 2],
    )?;
    for (id, of_a) in &a.session.categories {
        let of_b = b.session.categories.iter().find(|(other, _)| other == id);
        let values = [Some(*of_a), of_b.map(|(_, score)| *score)];
        row(&format!("  {id}"), values, "", "higher", [false; 2])?;
    }
    for (of_a, of_b) in pairs {
        if of_a.value.is_none() && of_b.value.is_none() {
            continue;
        }
        let metric = &of_a.metric;
        let values = [of_a, of_b].map(|m| m.value.map(|v| v * metric.display_factor));
        let outside = [of_a, of_b].map(|m| m.within == Some(false));
        row(
            &metric.title,
            values,
            &metric.display_unit,
            &metric.direction,
            outside,
        )?;
    }
    print("! outside the limit of the level")?;
    Ok(Exit::Done)
}
