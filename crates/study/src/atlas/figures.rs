//! The heat maps of the atlas, made from its results.

use super::heat_map::{Field, HeatMap, ratio_field};
use super::large_steps::{LargeStep, Start};
use super::limits::{Limit, methods};
use super::subject::Variation;
use super::{Atlas, method_name};
use microsim_drawing::{percent, significant, time};
use microsim_tissue::Method;

/// Size of a field with a number \[px\].
const NUMBER: (f64, f64) = (47.0, 24.0);

impl Atlas {
    /// All heat maps.
    pub fn figures(&self) -> Vec<HeatMap> {
        let mut figures = self.limit_figures();
        figures.extend(self.prediction_figures());
        figures.extend(self.large_step_figures());
        figures.push(self.recovery_overview());
        figures.push(self.recovery_figure());
        figures.retain(|figure| !figure.rows.is_empty());
        figures
    }

    /// Measured over exactly predicted limit, one map per method.
    pub fn limit_figures(&self) -> Vec<HeatMap> {
        let each = methods().map(|method| {
            let limits: Vec<&Limit> = self
                .limits
                .iter()
                .filter(|limit| limit.method == method)
                .collect();
            self.limit_map(
                &format!("limits-{}", method.name()),
                &format!(
                    "{}: measured over predicted limit of the step",
                    method.name()
                ),
                &limits,
                |limit| Some(limit_field(limit)),
            )
        });
        each.collect()
    }

    /// Bounds and estimates over the measured limit of Störmer–Verlet.
    pub fn prediction_figures(&self) -> Vec<HeatMap> {
        let limits: Vec<&Limit> = self
            .limits
            .iter()
            .filter(|limit| {
                limit.method == Method::StoermerVerlet
                    && !matches!(limit.variation, Variation::Amplitude(_))
            })
            .collect();
        let map = |name: &str, title: &str, of: &dyn Fn(&Limit) -> Option<f64>| {
            self.limit_map(&format!("predictions-{name}"), title, &limits, |limit| {
                let (predicted, measured) = (of(limit)?, limit.measured.step()?);
                let tip = format!(
                    "{}: predicted {}, measured {}",
                    tip(limit),
                    time(predicted),
                    time(measured)
                );
                Some(ratio_field(predicted / measured, tip))
            })
        };
        vec![
            map(
                "gershgorin",
                "Gershgorin bound (G) over the measured limit",
                &|limit| Some(limit.gershgorin),
            ),
            map(
                "power-iteration",
                "20 steps of power iteration over the measured limit",
                &|limit| Some(limit.power),
            ),
            map(
                "delingette",
                "k_c of 3.21 over the measured limit",
                &|limit| limit.delingette,
            ),
        ]
    }

    /// A map of substances over variations, of the fields that `field` makes.
    fn limit_map(
        &self,
        name: &str,
        title: &str,
        limits: &[&Limit],
        field: impl Fn(&Limit) -> Option<Field>,
    ) -> HeatMap {
        // Rows and columns in the order of the measurements.
        let mut rows = Vec::new();
        let mut columns: Vec<Variation> = Vec::new();
        for limit in limits {
            if !rows.contains(&limit.substance) {
                rows.push(limit.substance);
            }
            if !columns.contains(&limit.variation) {
                columns.push(limit.variation);
            }
        }
        let rank = |variation: &Variation| Variation::ALL.iter().position(|one| one == variation);
        columns.sort_by_key(rank);
        let mut fields: Vec<Vec<Option<Field>>> = Vec::new();
        for substance in &rows {
            let of = |variation: &Variation| {
                let found = limits
                    .iter()
                    .find(|l| l.substance == *substance && l.variation == *variation);
                found.and_then(|limit| field(limit))
            };
            fields.push(columns.iter().map(of).collect());
        }
        let mut labels: Vec<String> = rows.iter().map(|substance| substance.name()).collect();
        // A prediction that concerns springs alone has no other rows.
        for index in (0..labels.len()).rev() {
            if fields[index].iter().all(Option::is_none) {
                fields.remove(index);
                labels.remove(index);
            }
        }
        HeatMap {
            name: name.into(),
            title: title.into(),
            columns: columns
                .iter()
                .map(|v| (v.names().0.to_string(), v.names().1))
                .collect(),
            rows: labels,
            fields,
            size: NUMBER,
        }
    }

    /// What methods without a limit leave of a motion, one map per start.
    pub fn large_step_figures(&self) -> Vec<HeatMap> {
        let each = Start::ALL.into_iter().map(|start| {
            let runs: Vec<&LargeStep> = self
                .large_steps
                .iter()
                .filter(|run| run.start == start)
                .collect();
            let mut rows: Vec<String> = Vec::new();
            let mut columns: Vec<u32> = Vec::new();
            for run in &runs {
                let row = large_step_row(run);
                if !rows.contains(&row) {
                    rows.push(row);
                }
                if !columns.contains(&run.per_period) {
                    columns.push(run.per_period);
                }
            }
            let field = |row: &String, per_period: u32| {
                let run = runs
                    .iter()
                    .find(|run| large_step_row(run) == *row && run.per_period == per_period)?;
                Some(large_step_field(run))
            };
            let (name, title) = match start {
                Start::Bent => (
                    "large-steps-bent",
                    "Energy left after one period of the first mode",
                ),
                Start::Random => (
                    "large-steps-random",
                    "Largest energy from random offsets of 20 % of a cell, over that at the start",
                ),
            };
            HeatMap {
                name: name.into(),
                title: title.into(),
                columns: columns
                    .iter()
                    .map(|n| ("steps per period".into(), n.to_string()))
                    .collect(),
                fields: rows
                    .iter()
                    .map(|row| columns.iter().map(|&n| field(row, n)).collect())
                    .collect(),
                rows,
                size: (64.0, NUMBER.1),
            }
        });
        each.collect()
    }
}

/// Where a limit belongs, in words.
fn tip(limit: &Limit) -> String {
    let (what, value) = limit.variation.names();
    format!(
        "{}, {}, {what} {value}",
        method_name(&limit.method),
        limit.substance.name()
    )
}

fn limit_field(limit: &Limit) -> Field {
    match (limit.measured.step(), limit.ratio()) {
        (Some(measured), Some(ratio)) => {
            let tip = format!(
                "{}: measured {}, predicted {}",
                tip(limit),
                time(measured),
                time(limit.exact)
            );
            ratio_field(ratio, tip)
        }
        (None, _) if limit.exact == 0.0 => Field {
            lines: vec!["never".into()],
            class: "never",
            tip: format!("{}: unstable at every step, as predicted", tip(limit)),
        },
        _ => Field {
            lines: vec!["?".into()],
            class: "above-4",
            tip: format!(
                "{}: measured and predicted have nothing in common",
                tip(limit)
            ),
        },
    }
}

fn large_step_row(run: &LargeStep) -> String {
    format!("{}, {}", run.substance.name(), method_name(&run.method))
}

fn large_step_field(run: &LargeStep) -> Field {
    let place = format!(
        "{}, {} per period: step {}, {} times the explicit limit",
        large_step_row(run),
        run.per_period,
        time(run.step),
        significant(run.over_limit, 2)
    );
    match run.energy {
        Some(energy) => {
            let expected = match run.predicted {
                Some(predicted) => format!("; one mode alone: {}", percent(predicted)),
                None => String::new(),
            };
            ratio_field(
                energy,
                format!("{place}; energy {}{expected}", percent(energy)),
            )
        }
        None => Field {
            lines: vec!["fails".into()],
            class: "above-4",
            tip: format!("{place}; the solver gave up"),
        },
    }
}
