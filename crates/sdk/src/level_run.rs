//! A run of a level: what all training modules have in common. Phases, targets, limits, motion of the tools, the result.
//!
//! A module calls [`LevelRun::handle`] first and [`LevelRun::conclude`] last in its `process`; between them it reports which
//! targets are done, for which reasons the level is failed and what its own metrics are. The mathematics is the crate
//! `training`'s.

use crate::fault::Fault;
use crate::level_rules::LevelRules;
use crate::tick::Tick;
use microsim_message::{
    ContactForces, LevelControl, LevelEvent, LevelPhase, LevelState, LocalText, SolverTick,
    ToolSample, TrainingResult,
};
use microsim_settings::ModuleConfig;
use microsim_training as training;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use training::{MotionLog, TargetCount};

/// Largest fraction of the ticks with contact whose forces mean nothing, in a run that has a verdict; one such tick is always allowed, as
/// contact may be short. Scripted runs of the shipped levels have at most 1.0 %, the same with one iteration and ticks six times as long
/// 2.8 % and more wherever tissue is worked on (`tests/results/convergence.md`).
const MOST_INVALID: f64 = 0.02;

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
    published: Option<(LevelPhase, u32)>,
    shortest_path: Option<f64>,
    refused: u64,
    solver_ticks: SolverTicks,
}

/// The ticks of the running level in which a tool touched tissue, or the tissue was held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct SolverTicks {
    all: u64,
    /// Those whose forces mean nothing.
    invalid: u64,
}

/// A run of one level: its phase, targets, limits and metrics up to the result. An [`Exercise`](crate::Exercise) reports to it.
#[derive(Debug)]
pub struct LevelRun {
    targets: Vec<String>,
    machine: training::LevelMachine,
    logs: Vec<(String, MotionLog)>,
    rules: LevelRules,
    given_shortest_path: Option<f64>,
    shortest_path: Option<f64>,
    own: BTreeMap<String, f64>,
    reasons: BTreeSet<String>,
    input_ended: bool,
    aborted: bool,
    finished: bool,
    published: Option<(LevelPhase, u32)>,
    /// Samples that could not be used.
    refused: u64,
    solver_ticks: SolverTicks,
    /// The first id of a metric or reason in this tick that nobody declared.
    undeclared: Option<Fault>,
}

impl LevelRun {
    /// The run of a level with these targets.
    pub fn new(config: &ModuleConfig, targets: Vec<String>) -> Result<Self, Fault> {
        let fault = |e: &dyn std::error::Error| Fault::new(e.to_string());
        let machine = training::LevelMachine::new(targets.clone()).map_err(|e| fault(&e))?;
        let given = config.metrics.shortest_path;
        Ok(Self {
            logs: config
                .tools
                .iter()
                .map(|t| (t.name.clone(), MotionLog::new()))
                .collect(),
            machine,
            rules: LevelRules::new(config)?,
            given_shortest_path: given,
            shortest_path: given,
            targets,
            own: BTreeMap::new(),
            reasons: BTreeSet::new(),
            input_ended: false,
            aborted: false,
            finished: false,
            published: None,
            refused: 0,
            solver_ticks: SolverTicks::default(),
            undeclared: None,
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
        self.published = None;
        self.shortest_path = self.given_shortest_path;
        self.refused = 0;
        self.solver_ticks = SolverTicks::default();
        self.undeclared = None;
        Ok(())
    }

    /// Handles controls and tool samples; call it first.
    pub fn handle(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
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
                tick.log(microsim_message::LogLevel::Warn, error.to_string());
            }
        }
        let running = self.is_running();
        self.count_solver(tick, running)?;
        for sample in tick.messages::<ToolSample>()? {
            let Some((_, log)) = self.logs.iter_mut().find(|(tool, _)| *tool == sample.tool) else {
                continue;
            };
            if !(running && sample.tracked) {
                log.mark_gap();
                continue;
            }
            let pushed = log.push(sample.at());
            if let Err(error) = pushed {
                // A flood of bad samples must not become a flood of log lines.
                self.refused += 1;
                if self.refused % 1000 == 1 {
                    let text = format!(
                        "tool \"{}\": {error} (refused so far: {})",
                        sample.tool, self.refused
                    );
                    tick.log(microsim_message::LogLevel::Warn, text);
                }
            }
        }
        Ok(())
    }

    /// Counts a tick of tissue. One without contact means nothing for the hand, whatever was computed.
    fn count_solver(&mut self, tick: &Tick<'_>, running: bool) -> Result<(), Fault> {
        let forces = tick.messages::<ContactForces>()?;
        let touches = forces.iter().any(|forces| !forces.contacts.is_empty());
        for solver in tick.messages::<SolverTick>()? {
            let counts = running && (touches || solver.steps == 0);
            self.solver_ticks.all += u64::from(counts);
            self.solver_ticks.invalid += u64::from(counts && !solver.valid);
        }
        Ok(())
    }

    /// Whether the trainee works now.
    pub fn is_running(&self) -> bool {
        *self.machine.phase() == training::LevelPhase::Running
    }

    /// Whether the result has been published.
    pub fn is_finished(&self) -> bool {
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

    /// A target is reached; `text` is its line in the report.
    pub fn target_done(
        &mut self,
        tick: &mut Tick<'_>,
        target: &str,
        text: LocalText,
    ) -> Result<(), Fault> {
        let done = self.machine.target_done(tick.time(), target);
        done.map_err(|e| Fault::new(e.to_string()))?;
        self.event(tick, "target-done", text);
        Ok(())
    }

    /// A line for the report, at this moment: it stands in the course, and the page may show a picture of it. Of all moments a page draws
    /// twelve at most, those that decided first; so an event is for what a trainee should look at, not for every tick. A target that is
    /// done has its line already ([`Self::target_done`]).
    pub fn event(&self, tick: &mut Tick<'_>, id: &str, text: LocalText) {
        let time = self.time(tick);
        tick.publish(&LevelEvent {
            id: id.into(),
            time,
            text,
        });
    }

    /// The level is failed for this reason, which the manifest declares.
    pub fn add_reason(&mut self, reason: &str) {
        self.note(self.rules.check_reason(reason));
        self.reasons.insert(reason.into());
    }

    /// Sets a metric of the module's own, declared in the manifest, in its SI unit.
    pub fn measure(&mut self, metric: &str, value: f64) {
        self.note(self.rules.check_metric(metric));
        self.own.insert(metric.into(), value);
    }

    /// An id that nobody declared is a fault of the module, which [`conclude`](Self::conclude) returns.
    fn note(&mut self, checked: Result<(), Fault>) {
        if let Err(fault) = checked {
            self.undeclared.get_or_insert(fault);
        }
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
        if let Some(fault) = self.undeclared.take() {
            return Err(fault);
        }
        if self.finished {
            return Ok(());
        }
        let time = self.time(tick);
        let over = self
            .rules
            .time_limit
            .clone()
            .filter(|(limit, _)| time > *limit);
        let all_done = self.is_running() && self.machine.all_targets_done();
        if all_done || over.is_some() || self.input_ended || self.aborted {
            match over {
                // Whoever ran out of time missed targets for that reason alone.
                Some((_, reason)) => {
                    self.reasons.insert(reason);
                }
                None => reasons_at_end(self),
            }
            if let Some(fault) = self.undeclared.take() {
                return Err(fault);
            }
            let result = self.result(tick)?;
            self.publish_state(tick);
            tick.publish(&result);
            self.finished = true;
        } else {
            self.publish_state(tick);
        }
        Ok(())
    }

    fn publish_state(&mut self, tick: &mut Tick<'_>) {
        let phase = match self.machine.phase() {
            training::LevelPhase::Introduction => LevelPhase::Introduction,
            training::LevelPhase::Running => LevelPhase::Running,
            training::LevelPhase::Paused => LevelPhase::Paused,
            training::LevelPhase::Passed => LevelPhase::Passed,
            training::LevelPhase::Failed { .. } => LevelPhase::Failed,
            training::LevelPhase::NotJudged => LevelPhase::NotJudged,
        };
        let targets_done = self.machine.targets_done() as u32;
        if self.published != Some((phase, targets_done)) {
            self.published = Some((phase, targets_done));
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
        // The path of a task that was left half done is not comparable with the shortest path of the whole.
        let shortest_path = self
            .shortest_path
            .filter(|_| self.machine.all_targets_done());
        let measured = self
            .rules
            .measure(&logs, duration, shortest_path, &self.own)?;
        let targets = TargetCount {
            done: self.machine.targets_done(),
            total: self.targets.len(),
        };
        let verdict = self.rules.assess(targets, &measured, &self.reasons)?;
        let mut failed = verdict.failed.clone();
        let not_judged = match self.aborted {
            true => Vec::new(),
            false => self.why_not_judged(&verdict),
        };
        if self.aborted {
            failed = vec![training::REASON_ABORTED.into()];
            self.machine.abort(now).map_err(|e| fault(&e))?;
        } else {
            if *self.machine.phase() == training::LevelPhase::Paused {
                self.machine.resume(now).map_err(|e| fault(&e))?;
            }
            let ended = match not_judged.is_empty() {
                true => self.machine.finish(now, failed.clone()).map(|_| ()),
                false => {
                    failed.clear();
                    self.machine.end_without_verdict(now)
                }
            };
            ended.map_err(|e| fault(&e))?;
        }
        let mut metrics = self.rules.metric_records(&measured, &verdict);
        let mut categories = LevelRules::category_scores(&verdict);
        let mut score = verdict.total;
        if !not_judged.is_empty() {
            // What is no ground for a verdict is none for points or advice either.
            for metric in &mut metrics {
                (metric.within, metric.score) = (None, None);
            }
            categories.clear();
            score = 0.0;
        }
        Ok(TrainingResult {
            passed: failed.is_empty() && not_judged.is_empty(),
            aborted: self.aborted,
            not_judged,
            reasons: failed
                .iter()
                .map(|reason| self.rules.reason_text(reason))
                .collect(),
            failed,
            duration,
            targets_done: targets.done as u32,
            targets: targets.total as u32,
            metrics,
            categories,
            score,
        })
    }

    /// Why a run has no verdict: too much of its computation means nothing, or what would have to be met for a pass was not measured.
    fn why_not_judged(&self, verdict: &training::Assessment) -> Vec<LocalText> {
        let SolverTicks { all, invalid } = self.solver_ticks;
        let mut why = Vec::new();
        if invalid > 1 && invalid as f64 > MOST_INVALID * all as f64 {
            why.push(LocalText::new(
                format!(
                    "In {invalid} von {all} Schritten mit Kontakt bedeuten die berechneten Kräfte nichts."
                ),
                format!("In {invalid} of {all} ticks with contact the computed forces mean nothing."),
            ));
        }
        if verdict.failed.is_empty() {
            let unmeasured = verdict.unmeasured.iter();
            why.extend(unmeasured.map(|metric| self.rules.unmeasured_text(metric)));
        }
        why
    }

    /// All that evolves, as bytes.
    pub fn save(&self) -> Vec<u8> {
        self.state(|log| log.to_bytes())
    }

    /// What stands for all that evolves in the state hash: as [`LevelRun::save`], with a running digest in place of each tool's motion, which
    /// grows as long as the run lasts.
    pub fn hashed(&self) -> Vec<u8> {
        self.state(|log| log.digest().to_vec())
    }

    fn state(&self, log: impl Fn(&MotionLog) -> Vec<u8>) -> Vec<u8> {
        microsim_message::encode(&State {
            level: self.machine.state().clone(),
            logs: self.logs.iter().map(|(_, l)| log(l).into()).collect(),
            own: self.own.clone(),
            reasons: self.reasons.clone(),
            input_ended: self.input_ended,
            aborted: self.aborted,
            finished: self.finished,
            published: self.published,
            shortest_path: self.shortest_path,
            refused: self.refused,
            solver_ticks: self.solver_ticks,
        })
    }

    /// The opposite of [`LevelRun::save`], for the same level.
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
        self.published = state.published;
        self.shortest_path = state.shortest_path;
        self.refused = state.refused;
        self.solver_ticks = state.solver_ticks;
        Ok(())
    }
}
