//! What a level demands, metrics, limits and reasons, and the words of its result.

use crate::fault::Fault;
use microsim_message::{CategoryScore, LimitRecord, LocalText, MetricRecord};
use microsim_settings::{self as settings, ModuleConfig};
use microsim_training as training;
use std::collections::{BTreeMap, BTreeSet};
use training::{Assessment, Measurement, MetricDefinition, MetricValue, MotionLog, TargetCount};

/// Id of the metric whose upper limit ends a level.
const TIME: &str = training::id::TIME;

/// What a level demands.
#[derive(Debug)]
pub(crate) struct LevelRules {
    parameters: training::MetricParameters,
    definitions: Vec<MetricDefinition>,
    limits: Vec<training::Limit>,
    /// The time limit \[s\], and the reason that a result names when it is exceeded.
    pub time_limit: Option<(f64, String)>,
    reason_texts: BTreeMap<String, LocalText>,
}

fn own_definition(metric: &settings::ModuleMetric) -> MetricDefinition {
    let symbol = metric
        .display_unit
        .clone()
        .unwrap_or_else(|| metric.unit.symbol().into());
    MetricDefinition {
        id: metric.id.clone().into(),
        title: metric.title.clone(),
        unit: metric.unit.symbol().into(),
        display_factor: metric.unit.from_si(1.0, &symbol).unwrap_or(1.0),
        display_unit: shown(&symbol).into(),
        decimals: 2,
        direction: metric.direction,
        category: metric.category,
        formula: metric.formula.clone().into(),
        source: metric.source.clone().into(),
        advice: metric.advice.clone(),
    }
}

/// A unit's symbol as people read it; files keep to plain letters.
fn shown(symbol: &str) -> String {
    match symbol {
        "deg" => "°".into(),
        "deg/s" => "°/s".into(),
        "1" | "count" => String::new(),
        symbol => match symbol.strip_prefix('u') {
            Some(rest) => format!("µ{rest}"),
            None => symbol.replace("^2", "²").replace("^3", "³"),
        },
    }
}

/// A level may leave out where 0 and 100 points lie: 100 at the limit, 0 at twice the limit (or at nothing, for a lower
/// limit).
fn limit(limit: &settings::Limit) -> training::Limit {
    let bound = limit.max.or(limit.min).unwrap_or_default();
    training::Limit {
        metric: limit.metric.clone(),
        min: limit.min,
        max: limit.max,
        full: limit.full.unwrap_or(bound),
        zero: limit.zero.unwrap_or(if limit.max.is_some() {
            2.0 * bound
        } else {
            0.0
        }),
        reason: limit.reason.clone(),
        source: limit.source.clone(),
        provisional: limit.provisional,
        decides: limit.decides,
    }
}

fn direction_id(direction: training::Direction) -> &'static str {
    match direction {
        training::Direction::Lower => "lower-is-better",
        training::Direction::Higher => "higher-is-better",
        training::Direction::Range => "range",
        training::Direction::Inform => "informative",
    }
}

impl LevelRules {
    /// Of a level. Limits and parameters are checked here, so that the end of a level has nothing left to refuse.
    pub fn new(config: &ModuleConfig) -> Result<Self, Fault> {
        let fault = |e: &dyn std::error::Error| Fault::new(e.to_string());
        let mut definitions: Vec<MetricDefinition> = training::MOTION_METRICS.to_vec();
        definitions.extend(config.own_metrics.iter().map(own_definition));
        let limits: Vec<_> = config.limits.iter().map(limit).collect();
        training::Rules::new(&definitions, limits.clone()).map_err(|e| fault(&e))?;
        let given = &config.metrics;
        let parameters = training::MetricParameters {
            gap_s: given.gap,
            resample_hz: given.resample_rate,
            idle_speed_m_s: given.idle_speed,
            movement_speed_m_s: given.movement_speed,
            smoothing_s: given.smoothing,
            idle_smoothing_s: given.idle_smoothing,
            ..training::MetricParameters::default()
        };
        parameters.check().map_err(|e| fault(&e))?;
        let time = config.limits.iter().find(|l| l.metric == TIME);
        let reasons = config.reasons.iter();
        Ok(Self {
            parameters,
            definitions,
            limits,
            time_limit: time
                .and_then(|l| Some((l.max?, l.reason.clone().unwrap_or_else(|| TIME.into())))),
            reason_texts: reasons.map(|r| (r.id.clone(), r.text.clone())).collect(),
        })
    }

    /// The values of all metrics: those of motion from the logs of the tools, and the module's own.
    pub fn measure(
        &self,
        logs: &[(&str, &MotionLog)],
        duration: f64,
        shortest_path: Option<f64>,
        own: &BTreeMap<String, f64>,
    ) -> Result<Vec<Measurement>, Fault> {
        let mut measured =
            training::motion_metrics(logs, duration, shortest_path, &self.parameters)
                .map_err(|e| Fault::new(e.to_string()))?;
        measured.extend(own.iter().map(|(metric, value)| Measurement {
            metric: metric.clone(),
            tool: None,
            value: MetricValue::Value(*value),
        }));
        Ok(measured)
    }

    /// The values against the limits.
    pub fn assess(
        &self,
        targets: TargetCount,
        measured: &[Measurement],
        reasons: &BTreeSet<String>,
    ) -> Result<Assessment, Fault> {
        let rules = training::Rules::new(&self.definitions, self.limits.clone());
        let rules = rules.map_err(|e| Fault::new(e.to_string()))?;
        Ok(rules.assess(targets, measured, reasons.iter().cloned()))
    }

    /// The scores by category.
    pub fn category_scores(verdict: &Assessment) -> Vec<CategoryScore> {
        let scores = verdict.categories.iter().map(|c| CategoryScore {
            id: c.category.name().into(),
            title: c.category.title(),
            score: c.score,
        });
        scores.collect()
    }

    /// The metrics as a result has them.
    pub fn metric_records(
        &self,
        measured: &[Measurement],
        verdict: &Assessment,
    ) -> Vec<MetricRecord> {
        let records = self.definitions.iter().map(|definition| {
            let own = measured
                .iter()
                .find(|m| m.metric == definition.id && m.tool.is_none());
            let assessed = verdict
                .records
                .iter()
                .find(|r| r.limit.metric == definition.id);
            let value = own.and_then(|m| m.value.number());
            let not_applicable = match own.map(|m| &m.value) {
                Some(MetricValue::Value(_)) => None,
                Some(MetricValue::NotApplicable(why)) => Some(why.text()),
                None => Some(LocalText::new(
                    "in diesem Lauf nicht gemessen",
                    "not measured in this run",
                )),
            };
            MetricRecord {
                id: definition.id.to_string(),
                title: definition.title.clone(),
                unit: definition.unit.to_string(),
                display_unit: definition.display_unit.to_string(),
                display_factor: definition.display_factor,
                direction: direction_id(definition.direction).into(),
                category: definition.category.name().into(),
                formula: definition.formula.to_string(),
                source: definition.source.to_string(),
                advice: definition.advice.clone(),
                value,
                not_applicable,
                limit: assessed.map(|r| LimitRecord {
                    min: r.limit.min,
                    max: r.limit.max,
                    source: r.limit.source.clone(),
                    provisional: r.limit.provisional,
                    decides: r.limit.decides,
                }),
                within: assessed.and_then(|r| r.within),
                score: assessed.and_then(|r| r.points),
            }
        });
        records.collect()
    }

    /// In words that a limited metric has no value.
    pub fn unmeasured_text(&self, metric: &str) -> LocalText {
        let definition = self.definitions.iter().find(|d| d.id == metric);
        let (de, en) = match definition.map(|d| &d.title) {
            Some(title) => (&*title.de, &*title.en),
            None => (metric, metric),
        };
        LocalText::new(
            format!("{de}: begrenzt, aber in diesem Lauf nicht gemessen."),
            format!("{en}: limited, but not measured in this run."),
        )
    }

    /// Refuses ids that neither the platform nor the manifest has.
    pub fn check_metric(&self, metric: &str) -> Result<(), Fault> {
        match self.definitions.iter().any(|d| d.id == metric) {
            true => Ok(()),
            false => Err(Fault::new(format!(
                "the manifest has no metric \"{metric}\""
            ))),
        }
    }

    /// Refuses reasons that neither the platform nor the manifest has, nor a limit names.
    pub fn check_reason(&self, reason: &str) -> Result<(), Fault> {
        let of_limit = |l: &training::Limit| l.reason.as_deref().unwrap_or(&l.metric) == reason;
        let known = [training::REASON_ABORTED, training::REASON_TARGETS_MISSED].contains(&reason)
            || self.reason_texts.contains_key(reason)
            || self.limits.iter().any(of_limit);
        match known {
            true => Ok(()),
            false => Err(Fault::new(format!(
                "the manifest has no reason \"{reason}\""
            ))),
        }
    }

    /// A reason in words.
    pub fn reason_text(&self, reason: &str) -> LocalText {
        if let Some(text) = self.reason_texts.get(reason) {
            return text.clone();
        }
        let (de, en) = match reason {
            training::REASON_ABORTED => (
                "Der Lauf wurde abgebrochen.".into(),
                "The run was aborted.".into(),
            ),
            training::REASON_TARGETS_MISSED => (
                "Nicht alle Ziele wurden erreicht.".into(),
                "Not all targets were reached.".into(),
            ),
            // Otherwise the reason is a limit that was broken: the name of the metric shows which.
            _ => {
                let broken = self
                    .limits
                    .iter()
                    .find(|l| l.reason.as_deref().unwrap_or(&l.metric) == reason);
                let definition =
                    broken.and_then(|l| self.definitions.iter().find(|d| d.id == l.metric));
                match definition.map(|d| &d.title) {
                    Some(title) => (
                        format!("{}: außerhalb der Grenze.", title.de),
                        format!("{}: outside the limit.", title.en),
                    ),
                    None => (reason.to_owned(), reason.to_owned()),
                }
            }
        };
        LocalText::new(de, en)
    }
}
