//! From the messages of a session to its report.

use crate::arrival::ArrivalCollector;
use crate::device::DeviceCollector;
use crate::force::ForceCollector;
use crate::implausible::ImplausibleCollector;
use crate::input::ReportInput;
use crate::marker::MarkerCollector;
use crate::moment::MomentCollector;
use crate::motion::{MotionCollector, PresenceCollector};
use crate::report::{EventRecord, MetricEntry, RecoveryRecord, Report, Verdict, Warning};
use crate::solver::SolverCollector;
use microsim_bus::{Frame, Frames};
use microsim_message::{
    ContactForces, DecodeError, ImplausibleSample, InputSample, InputTiming, LevelEvent,
    LevelState, Log, LogLevel, MarkerTracking, Message, SolverTick, TissueCut, TissueRecovery,
    ToolSample, ToolStates, TrainingResult, decode,
};
use std::collections::BTreeMap;

impl Report {
    /// Reads the messages of a session: for each tick, in order, its index and its frames one after another. Kinds that
    /// the report does not show are skipped; what cannot be read is a line among the warnings.
    pub fn build<'a>(
        input: &ReportInput,
        ticks: impl IntoIterator<Item = (u64, &'a [u8])>,
    ) -> Self {
        let mut builder = ReportBuilder::new(input);
        for (tick, log) in ticks {
            builder.add(tick, log);
        }
        builder.finish()
    }

    /// The report as one JSON document; field names as in the structs.
    pub fn to_json(&self) -> String {
        // Plain data with string keys cannot fail.
        serde_json::to_string_pretty(self).expect("plain data")
    }

    /// The same, written as it is made: that of a long session is long.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn write_json(&self, out: impl std::io::Write) -> std::io::Result<()> {
        serde_json::to_writer_pretty(out, self).map_err(std::io::Error::from)
    }
}

/// Makes a report tick by tick, as a session is read.
pub struct ReportBuilder<'a> {
    input: &'a ReportInput,
    reading: Reading<'a>,
    ticks_end: u64,
}

impl<'a> ReportBuilder<'a> {
    /// The report of a session of which this is known besides its messages.
    pub fn new(input: &'a ReportInput) -> Self {
        Self {
            input,
            reading: Reading::new(input),
            ticks_end: 0,
        }
    }

    /// The messages of the next tick: its index and its frames one after another.
    pub fn add(&mut self, tick: u64, log: &[u8]) {
        self.ticks_end = tick.saturating_add(1);
        let now = tick as f64 * self.input.tick_s;
        for frame in Frames::new(log) {
            let read = match frame {
                Ok(frame) => self
                    .reading
                    .take(tick, now, &frame)
                    .map_err(|e| e.to_string()),
                Err(error) => Err(error.to_string()),
            };
            if let Err(text) = read {
                self.reading.warn(now, LogLevel::Error, text);
            }
        }
    }

    /// The report of all ticks.
    pub fn finish(self) -> Report {
        self.reading.finish(self.input, self.ticks_end)
    }
}

/// What has been read so far.
struct Reading<'a> {
    devices: DeviceCollector,
    arrivals: ArrivalCollector,
    markers: MarkerCollector,
    implausible: ImplausibleCollector,
    motion: MotionCollector,
    presence: PresenceCollector,
    forces: ForceCollector,
    solver: SolverCollector,
    moments: MomentCollector<'a>,
    state: LevelState,
    result: Option<TrainingResult>,
    events: Vec<EventRecord>,
    recoveries: Vec<RecoveryRecord>,
    warnings: Vec<Warning>,
    /// Place in `warnings` of each text, errors and warnings apart.
    warned: BTreeMap<(bool, String), usize>,
}

impl<'a> Reading<'a> {
    fn new(input: &'a ReportInput) -> Self {
        Self {
            devices: DeviceCollector::default(),
            arrivals: ArrivalCollector::default(),
            markers: MarkerCollector::default(),
            implausible: ImplausibleCollector::default(),
            motion: MotionCollector::default(),
            presence: PresenceCollector::default(),
            forces: ForceCollector::default(),
            solver: SolverCollector::default(),
            moments: MomentCollector::new(input),
            state: LevelState::default(),
            result: None,
            events: Vec::new(),
            recoveries: Vec::new(),
            warnings: Vec::new(),
            warned: BTreeMap::new(),
        }
    }

    fn take(&mut self, tick: u64, now: f64, frame: &Frame<'_>) -> Result<(), DecodeError> {
        if let Some(sample) = read::<InputSample>(frame)? {
            self.arrivals.add_sample(&sample);
            self.devices.add(sample);
        } else if let Some(sample) = read::<ToolSample>(frame)? {
            self.implausible.add_sample(&sample);
            self.motion.add(now, sample);
        } else if let Some(sample) = read::<ImplausibleSample>(frame)? {
            self.implausible.add(now, &sample);
        } else if let Some(timing) = read::<InputTiming>(frame)? {
            self.arrivals.add(&timing);
        } else if let Some(tracking) = read::<MarkerTracking>(frame)? {
            self.markers.add(tracking);
        } else if let Some(states) = read::<ToolStates>(frame)? {
            self.presence.add(tick, states);
        } else if let Some(forces) = read::<ContactForces>(frame)? {
            self.moments.add_forces(tick, now, &forces);
            self.forces.add(tick, now, forces);
        } else if let Some(solver) = read::<SolverTick>(frame)? {
            self.forces.add_tick(tick, &solver);
            self.solver.add(&solver);
        } else if let Some(cut) = read::<TissueCut>(frame)? {
            self.moments.add_cut(tick, now, &cut);
        } else if let Some(state) = read::<LevelState>(frame)? {
            self.moments.add_state(tick, now, &state);
            self.state = state;
        } else if let Some(result) = read::<TrainingResult>(frame)? {
            self.result = Some(result);
        } else if let Some(event) = read::<LevelEvent>(frame)? {
            self.moments.add_event(tick, now, &event);
            self.events.push(EventRecord {
                id: event.id,
                time: event.time,
                session_time: now,
                text: event.text,
            });
        } else if let Some(recovery) = read::<TissueRecovery>(frame)? {
            self.recoveries.push(RecoveryRecord {
                session_time: now,
                body: recovery.body,
                cause: recovery.cause,
                substeps: recovery.substeps,
            });
        } else if let Some(log) = read::<Log>(frame)?
            && matches!(log.level, LogLevel::Error | LogLevel::Warn)
        {
            self.warn(now, log.level, log.text);
        }
        Ok(())
    }

    fn warn(&mut self, session_time: f64, level: LogLevel, text: String) {
        let key = (level == LogLevel::Error, text.clone());
        let at = *self.warned.entry(key).or_insert_with(|| {
            self.warnings.push(Warning {
                session_time,
                level,
                text,
                count: 0,
            });
            self.warnings.len() - 1
        });
        self.warnings[at].count += 1;
    }

    fn finish(self, input: &ReportInput, ticks_end: u64) -> Report {
        let verdict = match &self.result {
            None => Verdict::Incomplete,
            Some(result) if result.aborted => Verdict::Aborted,
            Some(result) if !result.not_judged.is_empty() => Verdict::NotJudged,
            Some(result) if result.passed => Verdict::Passed,
            Some(_) => Verdict::Failed,
        };
        let has_result = matches!(verdict, Verdict::Passed | Verdict::Failed);
        let mut report = Report {
            format: 1,
            session: input.clone(),
            verdict,
            counts: has_result && input.without.is_empty(),
            failed: Vec::new(),
            reasons: Vec::new(),
            duration: self.state.running,
            simulated: ticks_end as f64 * input.tick_s,
            phase: self.state.phase,
            targets_done: self.state.targets_done,
            targets: self.state.targets,
            score: None,
            categories: Vec::new(),
            metrics: Vec::new(),
            input: self.devices.finish(),
            arrivals: self.arrivals.finish(input.tick_times),
            markers: self.markers.finish(),
            implausible: self.implausible.finish(),
            presence: self.presence.finish(ticks_end, input.tick_s),
            series: self.motion.finish(),
            forces: self.forces.finish(),
            solver: self.solver.finish(),
            events: self.events,
            moments: self
                .moments
                .finish(ticks_end, ticks_end as f64 * input.tick_s),
            recoveries: self.recoveries,
            warnings: self.warnings,
        };
        if let Some(result) = self.result {
            report.failed = result.failed;
            report.reasons = match verdict {
                Verdict::NotJudged => result.not_judged,
                _ => result.reasons,
            };
            report.duration = result.duration;
            report.targets_done = result.targets_done;
            report.targets = result.targets;
            report.score = (verdict != Verdict::NotJudged).then_some(result.score);
            report.categories = result.categories;
            report.metrics = result.metrics.into_iter().map(MetricEntry::from).collect();
        }
        report
    }
}

/// The message in a frame if it is an `M`.
fn read<M: Message>(frame: &Frame<'_>) -> Result<Option<M>, DecodeError> {
    decode(frame).transpose()
}

#[cfg(test)]
mod tests {
    use crate::testing::{failed_result, input, log};
    use crate::{Report, Verdict};
    use microsim_bus::push_frame;
    use microsim_message::{Log, LogLevel};

    /// The JSON form comes back as it was, and a program finds the ids of the reasons as one plain list.
    #[test]
    fn json_comes_back_with_exactly_the_failed_ids() {
        let log = log(&[&failed_result(&["depth", "dwell-too-short"])]);
        let report = Report::build(&input(), [(0, &log[..])]);
        let json = report.to_json();
        let value: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        assert_eq!(
            value["failed"],
            serde_json::json!(["depth", "dwell-too-short"])
        );
        assert_eq!(value["verdict"], "failed");
        assert_eq!(value["counts"], true);
        // 0.75 m, shown in mm.
        assert_eq!(value["metrics"][1]["value"], 0.75);
        assert_eq!(value["metrics"][1]["display_value"], 750.0);
        assert_eq!(value["metrics"][1]["limit"]["provisional"], true);
        assert_eq!(value["session"]["module"], "touch-spheres");
        let back: Report = serde_json::from_str(&json).expect("the report");
        assert_eq!(back, report);
    }

    #[test]
    fn an_aborted_run_does_not_count() {
        let mut result = failed_result(&["aborted"]);
        result.aborted = true;
        let log = log(&[&result]);
        let report = Report::build(&input(), [(0, &log[..])]);
        assert_eq!((report.verdict, report.counts), (Verdict::Aborted, false));
    }

    /// Unknown kinds are skipped; a payload that is no log line, and a cut frame, become warnings; equal lines are counted; what
    /// is not a warning is left out.
    #[test]
    fn what_cannot_be_read_is_said() {
        let line = |level| Log {
            level,
            text: "late".into(),
        };
        let mut bytes = log(&[
            &line(LogLevel::Warn),
            &line(LogLevel::Info),
            &line(LogLevel::Warn),
        ]);
        push_frame(&mut bytes, 1, 1, b"a kind of a module's own");
        push_frame(&mut bytes, microsim_bus::kind_id("host.log"), 1, b"junk");
        bytes.extend_from_slice(b"cut");
        let report = Report::build(&input(), [(0, &[][..]), (1, &bytes[..])]);
        let lines: Vec<_> = report
            .warnings
            .iter()
            .map(|w| (w.level, w.count, w.session_time))
            .collect();
        assert_eq!(
            lines,
            [
                (LogLevel::Warn, 2, 0.125),
                (LogLevel::Error, 1, 0.125),
                (LogLevel::Error, 1, 0.125)
            ]
        );
        assert!(report.warnings[1].text.contains("host.log"));
    }
}
