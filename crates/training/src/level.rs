//! The states of a level, from the introduction to the verdict.
//!
//! ```text
//! Introduction --start--> Running --pause--> Paused --resume--> Running
//!                         Running --finish--> Passed | Failed
//! Introduction, Running, Paused --abort--> Failed
//! ```
//!
//! Everything else is an error and changes nothing. There is no clock: each event brings its time, and times do not
//! decrease. Time spent in the introduction or paused does not count.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Reason of a level that ended without all targets and without another reason to explain it.
pub const REASON_TARGETS_MISSED: &str = "targets-missed";

/// Reason of a level that was broken off.
pub const REASON_ABORTED: &str = "aborted";

/// Where a level stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LevelPhase {
    /// The task is being explained.
    Introduction,
    /// The trainee works.
    Running,
    /// The work rests.
    Paused,
    /// Ended with all targets achieved and no reason against it.
    Passed,
    /// Ended otherwise.
    Failed {
        /// Ids of the reasons, sorted, each once, never none.
        reasons: Vec<String>,
    },
    /// Ended without a verdict: what was computed or measured is no ground for one.
    NotJudged,
}

/// Something to be achieved.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Unique name within the level.
    pub id: String,
    /// Running time \[s\] at which it was achieved, if it was.
    pub done_at_s: Option<f64>,
}

/// All that a level machine knows: plain data, to be saved and restored.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LevelState {
    /// Where the level stands.
    pub phase: LevelPhase,
    /// The targets, in the order in which the level names them.
    pub targets: Vec<Target>,
    /// Running time \[s\] before the present stretch of running.
    pub elapsed_s: f64,
    /// Begin \[s\] of the present stretch of running; `None` unless running.
    pub running_since_s: Option<f64>,
    /// Time \[s\] of the last event; `None` in the introduction.
    pub last_event_s: Option<f64>,
}

/// What can happen to a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LevelEvent {
    /// The trainee begins.
    Start,
    /// The work is interrupted.
    Pause,
    /// The work goes on.
    Resume,
    /// A target is achieved.
    TargetDone,
    /// The level ends by its own rules.
    Finish,
    /// The level is broken off.
    Abort,
}

/// Why an event, or a saved state, was refused.
#[derive(Debug, Clone, PartialEq)]
pub enum LevelError {
    /// The event does not exist in this phase.
    Illegal {
        /// What was asked for.
        event: LevelEvent,
        /// Where the level stands.
        phase: LevelPhase,
    },
    /// The time is NaN or infinite.
    TimeNotFinite,
    /// The event is earlier than the last one.
    TimeBackwards {
        /// Time of the last event \[s\].
        last: f64,
        /// Time of the refused one \[s\].
        now: f64,
    },
    /// The level has no target of this id.
    UnknownTarget(String),
    /// The target has been achieved before.
    TargetAlreadyDone(String),
    /// Two targets have this id.
    DuplicateTarget(String),
    /// A level must have a target: without one, doing nothing would pass.
    NoTargets,
    /// A saved state contradicts itself; the text names the place.
    Contradiction(&'static str),
}

impl fmt::Display for LevelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LevelError::Illegal { event, phase } => {
                write!(f, "level: {event:?} is not possible in phase {phase:?}")
            }
            LevelError::TimeNotFinite => {
                write!(f, "level: the time of an event is not a finite number")
            }
            LevelError::TimeBackwards { last, now } => {
                write!(f, "level: an event at {now} s after one at {last} s")
            }
            LevelError::UnknownTarget(id) => write!(f, "level: no target is called {id:?}"),
            LevelError::TargetAlreadyDone(id) => {
                write!(f, "level: target {id:?} was achieved before")
            }
            LevelError::DuplicateTarget(id) => write!(f, "level: two targets are called {id:?}"),
            LevelError::NoTargets => write!(f, "level: there is no target"),
            LevelError::Contradiction(what) => {
                write!(f, "level: the saved state contradicts itself: {what}")
            }
        }
    }
}

impl std::error::Error for LevelError {}

/// The state machine of one level.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelMachine {
    state: LevelState,
}

impl LevelMachine {
    /// A level in its introduction, with targets of these ids.
    pub fn new<S: Into<String>>(targets: impl IntoIterator<Item = S>) -> Result<Self, LevelError> {
        let targets = targets
            .into_iter()
            .map(|id| Target {
                id: id.into(),
                done_at_s: None,
            })
            .collect();
        Self::restore(LevelState {
            phase: LevelPhase::Introduction,
            targets,
            elapsed_s: 0.0,
            running_since_s: None,
            last_event_s: None,
        })
    }

    /// The machine that had this state. Refuses a state that contradicts itself.
    pub fn restore(state: LevelState) -> Result<Self, LevelError> {
        check(&state)?;
        Ok(LevelMachine { state })
    }

    /// The whole state, to be saved.
    pub fn state(&self) -> &LevelState {
        &self.state
    }

    /// Where the level stands.
    pub fn phase(&self) -> &LevelPhase {
        &self.state.phase
    }

    /// The targets, in the order in which the level names them.
    pub fn targets(&self) -> &[Target] {
        &self.state.targets
    }

    /// Number of targets achieved.
    pub fn targets_done(&self) -> usize {
        self.state
            .targets
            .iter()
            .filter(|target| target.done_at_s.is_some())
            .count()
    }

    /// Whether all targets are achieved.
    pub fn all_targets_done(&self) -> bool {
        self.targets_done() == self.state.targets.len()
    }

    /// Running time \[s\] up to `now`; after the end that of the whole level.
    pub fn running_time(&self, now: f64) -> f64 {
        let present = self
            .state
            .running_since_s
            .map_or(0.0, |since| (now - since).max(0.0));
        self.state.elapsed_s + present
    }

    /// The introduction ends, the work begins.
    pub fn start(&mut self, now: f64) -> Result<(), LevelError> {
        self.admit(LevelEvent::Start, now)?;
        self.run(now);
        Ok(())
    }

    /// The work is interrupted.
    pub fn pause(&mut self, now: f64) -> Result<(), LevelError> {
        self.admit(LevelEvent::Pause, now)?;
        self.rest(now, LevelPhase::Paused);
        Ok(())
    }

    /// The work goes on.
    pub fn resume(&mut self, now: f64) -> Result<(), LevelError> {
        self.admit(LevelEvent::Resume, now)?;
        self.run(now);
        Ok(())
    }

    /// A target is achieved. The level goes on running: the module decides when it ends.
    pub fn target_done(&mut self, now: f64, id: &str) -> Result<(), LevelError> {
        self.admit(LevelEvent::TargetDone, now)?;
        let running_time = self.running_time(now);
        let Some(target) = self.state.targets.iter_mut().find(|target| target.id == id) else {
            return Err(LevelError::UnknownTarget(id.to_string()));
        };
        if target.done_at_s.is_some() {
            return Err(LevelError::TargetAlreadyDone(id.to_string()));
        }
        target.done_at_s = Some(running_time);
        self.state.last_event_s = Some(now);
        Ok(())
    }

    /// The level ends: passed with all targets achieved and no reason against it, failed otherwise. A level that misses a
    /// target and names no reason fails with [`REASON_TARGETS_MISSED`].
    pub fn finish<S: Into<String>>(
        &mut self,
        now: f64,
        reasons: impl IntoIterator<Item = S>,
    ) -> Result<&LevelPhase, LevelError> {
        self.admit(LevelEvent::Finish, now)?;
        let reasons = sorted_reasons(
            reasons.into_iter().map(Into::into).collect(),
            self.all_targets_done(),
        );
        let phase = if reasons.is_empty() {
            LevelPhase::Passed
        } else {
            LevelPhase::Failed { reasons }
        };
        self.rest(now, phase);
        Ok(&self.state.phase)
    }

    /// The level ends without a verdict.
    pub fn end_without_verdict(&mut self, now: f64) -> Result<(), LevelError> {
        self.admit(LevelEvent::Finish, now)?;
        self.rest(now, LevelPhase::NotJudged);
        Ok(())
    }

    /// The level is broken off: failed with [`REASON_ABORTED`] alone.
    pub fn abort(&mut self, now: f64) -> Result<(), LevelError> {
        self.admit(LevelEvent::Abort, now)?;
        self.rest(
            now,
            LevelPhase::Failed {
                reasons: vec![REASON_ABORTED.to_string()],
            },
        );
        Ok(())
    }

    /// Refuses an event that does not exist in this phase, or comes at an impossible time.
    fn admit(&self, event: LevelEvent, now: f64) -> Result<(), LevelError> {
        use {LevelEvent as Event, LevelPhase as Phase};
        let legal = match self.state.phase {
            Phase::Introduction => matches!(event, Event::Start | Event::Abort),
            Phase::Running => matches!(
                event,
                Event::Pause | Event::TargetDone | Event::Finish | Event::Abort
            ),
            Phase::Paused => matches!(event, Event::Resume | Event::Abort),
            Phase::Passed | Phase::Failed { .. } | Phase::NotJudged => false,
        };
        if !legal {
            return Err(LevelError::Illegal {
                event,
                phase: self.state.phase.clone(),
            });
        }
        if !now.is_finite() {
            return Err(LevelError::TimeNotFinite);
        }
        match self.state.last_event_s {
            Some(last) if now < last => Err(LevelError::TimeBackwards { last, now }),
            _ => Ok(()),
        }
    }

    fn run(&mut self, now: f64) {
        self.state.phase = LevelPhase::Running;
        self.state.running_since_s = Some(now);
        self.state.last_event_s = Some(now);
    }

    fn rest(&mut self, now: f64, phase: LevelPhase) {
        self.state.elapsed_s = self.running_time(now);
        self.state.phase = phase;
        self.state.running_since_s = None;
        self.state.last_event_s = Some(now);
    }
}

/// The reasons in the form in which they are reported: sorted, each once; targets missed without any other reason become one.
/// With another reason the missed targets are its consequence and not listed: a report names causes.
pub(crate) fn sorted_reasons(mut reasons: Vec<String>, all_targets_done: bool) -> Vec<String> {
    if reasons.is_empty() && !all_targets_done {
        reasons.push(REASON_TARGETS_MISSED.to_string());
    }
    reasons.sort_unstable();
    reasons.dedup();
    reasons
}

/// Refuses a state that contradicts itself.
fn check(state: &LevelState) -> Result<(), LevelError> {
    if state.targets.is_empty() {
        return Err(LevelError::NoTargets);
    }
    for (index, target) in state.targets.iter().enumerate() {
        if state.targets[..index]
            .iter()
            .any(|other| other.id == target.id)
        {
            return Err(LevelError::DuplicateTarget(target.id.clone()));
        }
    }
    let begun = state.phase != LevelPhase::Introduction;
    let running = state.phase == LevelPhase::Running;
    let times = [
        Some(state.elapsed_s),
        state.running_since_s,
        state.last_event_s,
    ];
    let done = || state.targets.iter().filter_map(|target| target.done_at_s);
    let rules = [
        (
            times.into_iter().flatten().all(f64::is_finite) && state.elapsed_s >= 0.0,
            "a time is impossible",
        ),
        (
            done().all(|time| time.is_finite() && time >= 0.0),
            "a target was achieved at an impossible time",
        ),
        (
            state.running_since_s.is_some() == running,
            "running without a begin, or a begin without running",
        ),
        (
            state.running_since_s <= state.last_event_s,
            "began to run after the last event",
        ),
        (
            state.last_event_s.is_some() == begun,
            "begun without an event, or an event before the begin",
        ),
        (
            begun || (state.elapsed_s == 0.0 && done().count() == 0),
            "work done in the introduction",
        ),
    ];
    if let Some((_, what)) = rules.into_iter().find(|(holds, _)| !holds) {
        return Err(LevelError::Contradiction(what));
    }
    match &state.phase {
        LevelPhase::Passed if done().count() < state.targets.len() => {
            Err(LevelError::Contradiction("passed without all targets"))
        }
        LevelPhase::Failed { reasons } if reasons.is_empty() => {
            Err(LevelError::Contradiction("failed without a reason"))
        }
        LevelPhase::Failed { reasons } if !reasons.is_sorted_by(|a, b| a < b) => {
            Err(LevelError::Contradiction("reasons out of order"))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
