//! The course of a level: what every training module shares. Phases, targets, limits, motion of the tools, the result.
//!
//! A module calls [`Course::hear`] first and [`Course::conclude`] last in its `process`; between them it says which
//! targets are done, which reasons speak against a pass and what its own metrics are. The mathematics is the crate
//! `training`'s.

use crate::{Fault, Tick};
use microsim_message::{
    CategoryScore, LevelControl, LevelEvent, LevelPhase, LevelState, LimitRecord, LocalText,
    MetricRecord, ToolSample, TrainingResult,
};
use microsim_settings::{self as settings, ModuleConfig};
use microsim_training as training;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use training::{Measurement, MetricDefinition, MetricValue, MotionLog, TargetCount};

/// Ids of metrics that the course itself gives a meaning.
const TIME: &str = training::id::TIME;

/// What evolves.
#[derive(Serialize, Deserialize)]
struct State {
    level: training::LevelState,
    logs: Vec<serde_bytes::ByteBuf>,
    own: BTreeMap<String, f64>,
    reasons: BTreeSet<String>,
    input_ended: bool,
    aborted: bool,
    finished: bool,
    told: Option<(LevelPhase, u32)>,
    shortest_path: Option<f64>,
    refused: u64,
}

/// The course of one level.
#[derive(Debug)]
pub struct Course {
    targets: Vec<String>,
    machine: training::LevelMachine,
    logs: Vec<(String, MotionLog)>,
    parameters: training::MetricParameters,
    given_shortest_path: Option<f64>,
    shortest_path: Option<f64>,
    definitions: Vec<MetricDefinition>,
    limits: Vec<training::Limit>,
    /// The time limit \[s\], and the reason that a result names when it is not kept.
    time_limit: Option<(f64, String)>,
    reason_texts: BTreeMap<String, LocalText>,
    own: BTreeMap<String, f64>,
    reasons: BTreeSet<String>,
    input_ended: bool,
    aborted: bool,
    finished: bool,
    told: Option<(LevelPhase, u32)>,
    /// Samples that could not be used.
    refused: u64,
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

impl Course {
    /// The course of a level with these targets.
    pub fn new(config: &ModuleConfig, targets: Vec<String>) -> Result<Self, Fault> {
        let fault = |e: &dyn std::error::Error| Fault::new(e.to_string());
        let machine = training::LevelMachine::new(targets.clone()).map_err(|e| fault(&e))?;
        let mut definitions: Vec<MetricDefinition> = training::MOTION_METRICS.to_vec();
        definitions.extend(config.own_metrics.iter().map(own_definition));
        let limits: Vec<_> = config.limits.iter().map(limit).collect();
        // Checked here once, so that the end of a level has nothing left to refuse.
        training::Rules::new(&definitions, limits.clone()).map_err(|e| fault(&e))?;
        let given = &config.metrics;
        let parameters = training::MetricParameters {
            gap_s: given.gap,
            resample_hz: given.resample_rate,
            idle_speed_m_s: given.idle_speed,
            movement_speed_m_s: given.movement_speed,
            smoothing_s: given.smoothing,
            ..training::MetricParameters::default()
        };
        parameters.check().map_err(|e| fault(&e))?;
        let time = config.limits.iter().find(|l| l.metric == TIME);
        Ok(Self {
            logs: config
                .tools
                .iter()
                .map(|t| (t.name.clone(), MotionLog::new()))
                .collect(),
            machine,
            parameters,
            given_shortest_path: given.shortest_path,
            shortest_path: given.shortest_path,
            definitions,
            limits,
            time_limit: time
                .and_then(|l| Some((l.max?, l.reason.clone().unwrap_or_else(|| TIME.into())))),
            reason_texts: config
                .reasons
                .iter()
                .map(|r| (r.id.clone(), r.text.clone()))
                .collect(),
            targets,
            own: BTreeMap::new(),
            reasons: BTreeSet::new(),
            input_ended: false,
            aborted: false,
            finished: false,
            told: None,
            refused: 0,
        })
    }

    /// Back to the start.
    pub fn reset(&mut self) -> Result<(), Fault> {
        let machine = training::LevelMachine::new(self.targets.clone());
        self.machine = machine.map_err(|e| Fault::new(e.to_string()))?;
        for (_, log) in &mut self.logs {
            *log = MotionLog::new();
        }
        self.own.clear();
        self.reasons.clear();
        (self.input_ended, self.aborted, self.finished) = (false, false, false);
        self.told = None;
        self.shortest_path = self.given_shortest_path;
        self.refused = 0;
        Ok(())
    }

    /// Hears controls and tool samples; call it first.
    pub fn hear(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let now = tick.time();
        for control in tick.messages::<LevelControl>()? {
            let done = match control {
                LevelControl::Start => self.machine.start(now),
                LevelControl::Pause => self.machine.pause(now),
                LevelControl::Resume => self.machine.resume(now),
                LevelControl::InputEnded => {
                    self.input_ended = true;
                    Ok(())
                }
                LevelControl::Abort => {
                    self.aborted = true;
                    Ok(())
                }
            };
            if let Err(error) = done {
                tick.log(crate::LogLevel::Warn, error.to_string());
            }
        }
        let running = self.running();
        for sample in tick.messages::<ToolSample>()? {
            let Some((_, log)) = self.logs.iter_mut().find(|(tool, _)| *tool == sample.tool) else {
                continue;
            };
            if !(running && sample.tracked) {
                log.mark_gap();
                continue;
            }
            let pushed = log.push(training::Sample {
                time: sample.time,
                position: sample.pose.position,
                orientation: sample.pose.orientation,
                opening: Some(sample.opening),
            });
            if let Err(error) = pushed {
                // A flood of bad samples must not become a flood of log lines.
                self.refused += 1;
                if self.refused % 1000 == 1 {
                    let text = format!(
                        "tool \"{}\": {error} (refused so far: {})",
                        sample.tool, self.refused
                    );
                    tick.log(crate::LogLevel::Warn, text);
                }
            }
        }
        Ok(())
    }

    /// Whether the trainee works now.
    pub fn running(&self) -> bool {
        *self.machine.phase() == training::LevelPhase::Running
    }

    /// Whether the result has been published.
    pub fn finished(&self) -> bool {
        self.finished
    }

    /// Running time of the level \[s\].
    pub fn time(&self, tick: &Tick<'_>) -> f64 {
        self.machine.running_time(tick.time())
    }

    /// Whether a target has been reached.
    pub fn is_done(&self, target: &str) -> bool {
        self.machine
            .targets()
            .iter()
            .any(|t| t.id == target && t.done_at_s.is_some())
    }

    /// A target is reached; says so in the report.
    pub fn target_done(
        &mut self,
        tick: &mut Tick<'_>,
        target: &str,
        said: LocalText,
    ) -> Result<(), Fault> {
        let done = self.machine.target_done(tick.time(), target);
        done.map_err(|e| Fault::new(e.to_string()))?;
        self.event(tick, "target-done", said);
        Ok(())
    }

    /// A line for the report.
    pub fn event(&self, tick: &mut Tick<'_>, id: &str, said: LocalText) {
        let time = self.time(tick);
        tick.publish(&LevelEvent {
            id: id.into(),
            time,
            text: said,
        });
    }

    /// Something speaks against a pass; `reason` is declared in the manifest.
    pub fn speaks_against(&mut self, reason: &str) {
        self.reasons.insert(reason.into());
    }

    /// Sets a metric of the module's own, declared in the manifest, in its SI unit.
    pub fn measure(&mut self, metric: &str, value: f64) {
        self.own.insert(metric.into(), value);
    }

    /// Length of the shortest sensible path of all tools \[m\], for the economy of motion.
    pub fn set_shortest_path(&mut self, length: f64) {
        self.shortest_path = Some(length);
    }

    /// Ends the level where it has to end (all targets reached, time over, no more input, aborted), and publishes what
    /// has changed; call it last. `reasons_at_end` is asked once, at the end, for what only then is known, unless the time is over.
    pub fn conclude(
        &mut self,
        tick: &mut Tick<'_>,
        reasons_at_end: impl FnOnce(&mut Self),
    ) -> Result<(), Fault> {
        if self.finished {
            return Ok(());
        }
        let time = self.time(tick);
        let over = self.time_limit.clone().filter(|(limit, _)| time > *limit);
        let all_done = self.running() && self.machine.all_targets_done();
        if all_done || over.is_some() || self.input_ended || self.aborted {
            match over {
                // Whoever ran out of time missed targets for that reason alone.
                Some((_, reason)) => {
                    self.reasons.insert(reason);
                }
                None => reasons_at_end(self),
            }
            let result = self.result(tick)?;
            self.tell(tick);
            tick.publish(&result);
            self.finished = true;
        } else {
            self.tell(tick);
        }
        Ok(())
    }

    fn tell(&mut self, tick: &mut Tick<'_>) {
        let phase = match self.machine.phase() {
            training::LevelPhase::Introduction => LevelPhase::Introduction,
            training::LevelPhase::Running => LevelPhase::Running,
            training::LevelPhase::Paused => LevelPhase::Paused,
            training::LevelPhase::Passed => LevelPhase::Passed,
            training::LevelPhase::Failed { .. } => LevelPhase::Failed,
        };
        let targets_done = self.machine.targets_done() as u32;
        if self.told != Some((phase, targets_done)) {
            self.told = Some((phase, targets_done));
            let (running, targets) = (self.time(tick), self.targets.len() as u32);
            tick.publish(&LevelState {
                phase,
                running,
                targets_done,
                targets,
            });
        }
    }

    fn result(&mut self, tick: &Tick<'_>) -> Result<TrainingResult, Fault> {
        let now = tick.time();
        let fault = |e: &dyn std::error::Error| Fault::new(e.to_string());
        let duration = self.machine.running_time(now);
        let logs: Vec<(&str, &MotionLog)> =
            self.logs.iter().map(|(t, l)| (t.as_str(), l)).collect();
        // The way of a task that was left half done is not comparable with the shortest way of the whole.
        let shortest_path = self
            .shortest_path
            .filter(|_| self.machine.all_targets_done());
        let mut measured =
            training::motion_metrics(&logs, duration, shortest_path, &self.parameters)
                .map_err(|e| fault(&e))?;
        measured.extend(self.own.iter().map(|(metric, value)| Measurement {
            metric: metric.clone(),
            tool: None,
            value: MetricValue::Value(*value),
        }));
        let targets = TargetCount {
            done: self.machine.targets_done(),
            total: self.targets.len(),
        };
        let rules =
            training::Rules::new(&self.definitions, self.limits.clone()).map_err(|e| fault(&e))?;
        let verdict = rules.assess(targets, &measured, self.reasons.iter().cloned());
        let mut failed = verdict.failed.clone();
        if self.aborted {
            failed = vec![training::REASON_ABORTED.into()];
            self.machine.abort(now).map_err(|e| fault(&e))?;
        } else {
            if *self.machine.phase() == training::LevelPhase::Paused {
                self.machine.resume(now).map_err(|e| fault(&e))?;
            }
            self.machine
                .finish(now, failed.clone())
                .map_err(|e| fault(&e))?;
        }
        Ok(TrainingResult {
            passed: failed.is_empty(),
            aborted: self.aborted,
            reasons: failed
                .iter()
                .map(|reason| self.reason_text(reason))
                .collect(),
            failed,
            duration,
            targets_done: targets.done as u32,
            targets: targets.total as u32,
            metrics: self.metric_records(&measured, &verdict),
            categories: verdict
                .categories
                .iter()
                .map(|c| CategoryScore {
                    id: c.category.name().into(),
                    title: c.category.title(),
                    score: c.score,
                })
                .collect(),
            score: verdict.total,
        })
    }

    fn metric_records(
        &self,
        measured: &[Measurement],
        verdict: &training::Assessment,
    ) -> Vec<MetricRecord> {
        let records = self.definitions.iter().map(|definition| {
            let own = measured
                .iter()
                .find(|m| m.metric == definition.id && m.tool.is_none());
            let judged = verdict
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
                limit: judged.map(|r| LimitRecord {
                    min: r.limit.min,
                    max: r.limit.max,
                    source: r.limit.source.clone(),
                    provisional: r.limit.provisional,
                }),
                within: judged.and_then(|r| r.within),
                score: judged.and_then(|r| r.points),
            }
        });
        records.collect()
    }

    fn reason_text(&self, reason: &str) -> LocalText {
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
            // Otherwise the reason is a limit that was not kept: the metric's name says which.
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

    /// All that evolves, as bytes.
    pub fn save(&self) -> Vec<u8> {
        microsim_message::encode(&State {
            level: self.machine.state().clone(),
            logs: self
                .logs
                .iter()
                .map(|(_, log)| log.to_bytes().into())
                .collect(),
            own: self.own.clone(),
            reasons: self.reasons.clone(),
            input_ended: self.input_ended,
            aborted: self.aborted,
            finished: self.finished,
            told: self.told,
            shortest_path: self.shortest_path,
            refused: self.refused,
        })
    }

    /// The opposite of [`Course::save`], for the same level.
    pub fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        let state: State = microsim_message::decode_bytes(state)?;
        let machine = training::LevelMachine::restore(state.level);
        self.machine = machine.map_err(|e| Fault::new(e.to_string()))?;
        if state.logs.len() != self.logs.len() {
            return Err(Fault::new(
                "the saved state belongs to a level with other tools",
            ));
        }
        for ((_, log), bytes) in self.logs.iter_mut().zip(&state.logs) {
            *log = MotionLog::from_bytes(bytes).map_err(|e| Fault::new(e.to_string()))?;
        }
        self.own = state.own;
        self.reasons = state.reasons;
        (self.input_ended, self.aborted, self.finished) =
            (state.input_ended, state.aborted, state.finished);
        self.told = state.told;
        self.shortest_path = state.shortest_path;
        self.refused = state.refused;
        Ok(())
    }
}
