//! Heat maps of the recovery of the beam.

use super::heat_map::{Field, HeatMap};
use super::recovery::{Damage, Outcome, Recovery, Scheme, StepLength};
use super::{Atlas, Substance, method_name};
use microsim_drawing::{percent, significant, time};
use microsim_tissue::Method;

impl Atlas {
    /// How much each substance recovers from with each method and step; those methods alone that are computed on several
    /// substances.
    pub fn recovery_overview(&self) -> HeatMap {
        let mut columns: Vec<(String, String)> = Vec::new();
        let mut rows: Vec<Substance> = Vec::new();
        let runs: Vec<&[Recovery]> = self
            .recoveries
            .chunk_by(|a, b| a.scheme == b.scheme)
            .collect();
        let substances = |column: &(String, String)| {
            runs.iter()
                .filter(|run| column_of(&run[0].scheme) == *column)
                .count()
        };
        for run in &runs {
            let column = column_of(&run[0].scheme);
            if substances(&column) > 1 && !columns.contains(&column) {
                columns.push(column);
            }
        }
        // Groups together, in the order in which they come.
        let first = |columns: &[(String, String)], group: &str| {
            columns.iter().position(|(g, _)| g == group)
        };
        let order = columns.clone();
        columns.sort_by_key(|(group, _)| first(&order, group));
        for run in runs
            .iter()
            .filter(|run| columns.contains(&column_of(&run[0].scheme)))
        {
            if !rows.contains(&run[0].scheme.substance) {
                rows.push(run[0].scheme.substance);
            }
        }
        let field = |substance: &Substance, column: &(String, String)| {
            let of = |run: &&&[Recovery]| {
                run[0].scheme.substance == *substance && column_of(&run[0].scheme) == *column
            };
            runs.iter().find(of).map(|run| overview_field(run))
        };
        HeatMap {
            name: "recovery-overview".into(),
            title: "Number of damages from which the beam recovers, and largest CPU time".into(),
            rows: rows.iter().map(Substance::name).collect(),
            fields: rows
                .iter()
                .map(|row| columns.iter().map(|column| field(row, column)).collect())
                .collect(),
            columns,
            size: (56.0, 34.0),
        }
    }

    /// Which scheme recovers from what.
    pub fn recovery_figure(&self) -> HeatMap {
        let mut schemes: Vec<&Scheme> = Vec::new();
        for recovery in &self.recoveries {
            if !schemes.contains(&&recovery.scheme) {
                schemes.push(&recovery.scheme);
            }
        }
        let of = |scheme: &Scheme, damage: Damage| {
            self.recoveries
                .iter()
                .find(|r| r.scheme == *scheme && r.damage == damage)
        };
        let row = |scheme: &&Scheme| {
            let step = Damage::ALL
                .into_iter()
                .find_map(|damage| of(scheme, damage))
                .map_or(f64::NAN, |r| r.step);
            scheme_label(scheme, step)
        };
        HeatMap {
            name: "recovery".into(),
            title: "Recovery of the beam S within 1.2 s: simulated time until then, and CPU time of the 1.2 s".into(),
            columns: Damage::ALL.map(|damage| (String::new(), damage.name().to_string())).to_vec(),
            rows: schemes.iter().map(row).collect(),
            fields: schemes
                .iter()
                .map(|scheme| Damage::ALL.map(|damage| of(scheme, damage).map(recovery_field)).to_vec())
                .collect(),
            size: (112.0, 34.0),
        }
    }
}

/// Group and label of the column of a scheme.
fn column_of(scheme: &Scheme) -> (String, String) {
    let mut group = match scheme.method {
        Method::Xpbd { .. } => "xpbd, sub-steps × iterations".into(),
        // Short, for it stands over few columns.
        Method::ImplicitEuler(newton) if newton.iterations == 1 => "implicit-euler ×1".into(),
        ref method => method_name(method),
    };
    if scheme.relaxation_time > 0.0 {
        group += ", τ";
    }
    let label = match (scheme.method, scheme.step) {
        (
            Method::Xpbd {
                substeps,
                iterations,
            },
            _,
        ) => format!("{substeps} × {iterations}"),
        (_, StepLength::LimitFraction(fraction)) => format!("s {fraction}"),
        (_, StepLength::Seconds(seconds)) => time(seconds),
    };
    (group, label)
}

fn overview_field(run: &[Recovery]) -> Field {
    let recovered = run.iter().filter(|one| one.outcome.is_recovered()).count();
    let slowest = run.iter().map(|one| one.cpu).fold(0.0, f64::max);
    let failed: Vec<&str> = run
        .iter()
        .filter(|one| !one.outcome.is_recovered())
        .map(|one| one.damage.name())
        .collect();
    let place = scheme_label(&run[0].scheme, run[0].step);
    if run
        .iter()
        .all(|one| matches!(one.outcome, Outcome::NotApplicable(_)))
    {
        return Field {
            lines: vec!["n/a".into()],
            class: "none",
            tip: format!("{place}: not applicable"),
        };
    }
    Field {
        lines: vec![
            format!("{recovered}/{}", run.len()),
            if slowest < 1e-3 {
                "< 1 ms".into()
            } else {
                format!("{} s", significant(slowest, 2))
            },
        ],
        class: match recovered {
            0 => "bad",
            n if n == run.len() => "good",
            _ => "stuck",
        },
        tip: match failed.as_slice() {
            [] => format!("{place}: recovers from everything"),
            failed => format!("{place}: does not recover from: {}", failed.join(", ")),
        },
    }
}

/// A scheme with its step in words.
pub(super) fn scheme_label(scheme: &Scheme, step: f64) -> String {
    let fraction = match scheme.step {
        StepLength::LimitFraction(fraction) => format!(" (s = {fraction})"),
        StepLength::Seconds(_) => String::new(),
    };
    let viscosity = match scheme.relaxation_time {
        t if t > 0.0 => format!(", τ {}", time(t)),
        _ => String::new(),
    };
    format!("{}, {}{fraction}{viscosity}", scheme.name(), time(step))
}

fn recovery_field(recovery: &Recovery) -> Field {
    let cpu = format!("CPU {} s", significant(recovery.cpu, 2));
    let place = format!(
        "{}, {}",
        scheme_label(&recovery.scheme, recovery.step),
        recovery.damage.name()
    );
    let field = |class, first: String, tip: String| Field {
        lines: vec![first, cpu.clone()],
        class,
        tip: format!("{place}: {tip}; {cpu}"),
    };
    match &recovery.outcome {
        Outcome::Recovered(at) => field(
            "good",
            format!("✓ {} s", significant(*at, 2)),
            format!("recovered at {}", time(*at)),
        ),
        Outcome::Elsewhere {
            distance,
            inverted,
            still,
        } => {
            let tip = format!(
                "{} of the length away, {inverted} elements inverted, {}",
                percent(*distance),
                if *still { "at rest" } else { "moving" }
            );
            let word = if *still { "stuck" } else { "moving" };
            let first = match inverted {
                0 => format!("✕ {word}, {} off", percent(*distance)),
                _ => format!("✕ {word}, {inverted} inv."),
            };
            field(if *still { "stuck" } else { "bad" }, first, tip)
        }
        Outcome::Failed { time: at, reason } => {
            let word = if reason.contains("not finite") || reason.contains("apart") {
                "blows up"
            } else {
                "no step"
            };
            field(
                "bad",
                format!("✕ {word}"),
                format!("fails at {}: {reason}", time(*at)),
            )
        }
        Outcome::TooSlow(at) => field(
            "slow",
            "✕ too slow".into(),
            format!("cut off at {}", time(*at)),
        ),
        Outcome::NotApplicable(reason) => Field {
            lines: vec!["n/a".into()],
            class: "none",
            tip: format!("{place}: {reason}"),
        },
    }
}
