//! A run at the edge: pacing, controls, recording, pictures, the end. The only place of the host that reads the wall
//! clock.
//!
//! **Rule for late ticks** (paced runs): no tick is skipped or shortened. A tick that begins late is counted, and the next
//! ones follow without a pause until the lag is made up; a lag beyond [`Realtime::give_up`] moves the schedule, so that
//! the simulation falls behind the wall clock instead of racing after it.

pub use crate::error::RunError;

use crate::engine::{Checkpoint, Engine, Feed, HostState, StateDigest, TickOutput};
use crate::fault::Failure;
use crate::loader::load;
use crate::parallel::Parallel;
use crate::picture::{PicturePlan, PictureReport, Pictures, start_pictures};
use crate::plan::{PluginKind, RunPlan};
use crate::record::{EndRecord, Ended, Header, RECORD_FORMAT, TickRecord, hex, kind, record};
use crate::recorder::Recorder;
use crate::span;
use crate::subscriptions::{HostSubscriptions, print_log};
use microsim_bus::Block;
use microsim_message::{LevelControl, Progress, TrainingResult, push};
use microsim_session::{Chain, KIND_END, StationKey};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};

/// Simulated time that a module has for its result once it has to end \[ns\].
const ENDING_NS: u64 = 2_000_000_000;

/// Pacing by the wall clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Realtime {
    /// A tick that begins later than this is counted as late.
    pub tolerance: Duration,
    /// Behind by more than this, the schedule moves.
    pub give_up: Duration,
}

/// How to run a plan.
pub struct RunOptions<'a> {
    /// Threads of the parallel loop.
    pub threads: usize,
    /// Pace ticks by the wall clock.
    pub realtime: Option<Realtime>,
    /// Pictures, if wanted.
    pub pictures: Option<PicturePlan>,
    /// Go on from here.
    pub resume: Option<Checkpoint>,
    /// Stop after this many ticks with a checkpoint.
    pub stop_at: Option<u64>,
    /// Set from outside (Ctrl-C, SIGTERM): the level is aborted, the session closed.
    pub stop: &'a AtomicBool,
    /// Who trains: an id of the store.
    pub trainee: Option<String>,
    /// Id of the session.
    pub session_id: Option<String>,
    /// Whether the session stays out of the store.
    pub unlisted: bool,
    /// What the session is signed with; without a key it is not.
    pub key: Option<StationKey>,
    /// Who sits at the run, if anybody does.
    pub operator: Option<&'a mut dyn Operator>,
    /// Called after every tick with the simulated time \[s\] and the progress that plugins report.
    pub progress: &'a mut dyn FnMut(f64, Option<&Progress>),
}

/// Somebody in front of a live run: a window. What it sends is recorded as all that comes from outside; what it sees changes nothing.
pub trait Operator {
    /// Appends the frames that the host publishes at the start of the next tick: mouse and keyboard, the microscope.
    fn send(&mut self, frames: &mut Vec<u8>);

    /// Whether no further tick is to begin for now. Simulated time stands meanwhile.
    fn is_paused(&self) -> bool;

    /// Sees the messages of a tick and the blocks that are the latest then.
    fn see(&mut self, seen: Seen<'_>);
}

/// What an [`Operator`] sees of a tick.
pub struct Seen<'a> {
    /// The tick.
    pub tick: u64,
    /// Simulated time at its end \[s\].
    pub time: f64,
    /// All messages, stamped, in the order of their publication.
    pub log: &'a [u8],
    /// From the begin of the tick to its snapshot \[s\].
    pub duration: f64,
    /// How much later than its time it began \[s\]; 0 for one that waited for its time, or that is not paced.
    pub lateness: f64,
    /// Ticks that began late so far.
    pub late_ticks: u64,
    engine: &'a mut Engine,
}

impl Seen<'_> {
    /// What pictures of the computation show of bodies: computed where it is asked for, and neither published nor recorded.
    pub fn fields(&mut self) -> Vec<Block> {
        self.engine.fields()
    }

    /// The latest blocks: shared, not copied.
    pub fn blocks(&self) -> Vec<Block> {
        self.engine.blocks()
    }
}

/// A run that ended.
#[derive(Clone, Debug)]
pub struct RunOutcome {
    /// The module's result, if it came to one.
    pub result: Option<TrainingResult>,
    /// The state hash, hexadecimal.
    pub state_hash: String,
    /// The physics digest, hexadecimal: a chain over the values of plugins at every state hash and at the end, then metrics and score,
    /// all as raw numbers. Unlike the state hash it does not change with names and encodings. Empty where a plugin failed.
    pub physics_digest: String,
    /// Ticks done.
    pub ticks: u64,
    /// The plugin that ended the run, if one failed.
    pub failure: Option<Failure>,
    /// Failures that did not end it (while stopping, for example).
    pub complaints: Vec<String>,
    /// What came of the pictures.
    pub pictures: Option<PictureReport>,
    /// Ticks that began late.
    pub late_ticks: u64,
    /// From the begin of a tick to its snapshot: p50, p99 and the longest (paced runs) \[s\].
    pub tick_times: Option<[f64; 3]>,
    /// The checkpoint that was asked for.
    pub checkpoint: Option<Checkpoint>,
}

/// Paces ticks by the wall clock.
struct Pace {
    rule: Realtime,
    start: Instant,
    next: Instant,
    tick: Duration,
    late: u64,
}

impl Pace {
    /// Waits for the next tick. Returns how much later than its time it begins.
    fn wait(&mut self) -> Duration {
        let now = Instant::now();
        if now < self.next {
            std::thread::sleep(self.next - now);
        }
        let lateness = now.saturating_duration_since(self.next);
        if lateness > self.rule.tolerance {
            self.late += 1;
        }
        if lateness > self.rule.give_up.max(self.rule.tolerance) {
            self.next = now;
        }
        self.next += self.tick;
        lateness
    }

    /// Moves the schedule past a pause, so that arrivals go on where they were.
    fn skip(&mut self, pause: Duration) {
        self.start += pause;
        self.next = Instant::now();
    }
}

/// Between two looks at whether a pause has ended.
const PAUSE_LOOK: Duration = Duration::from_millis(5);

/// Runs a plan to its end. `Err`: it did not begin, and no session was written (beyond its header, if that could not be
/// written).
pub fn run(plan: &RunPlan, options: RunOptions<'_>) -> Result<RunOutcome, RunError> {
    let parallel = match options.threads {
        0 | 1 => None,
        n => Some(Parallel::new(n).map_err(RunError::Host)?),
    };
    let mut engine = Engine::new(plan, plan.limits(), parallel, |p| {
        load(p).map(Some).map_err(RunError::from)
    })?;
    if let Some(checkpoint) = &options.resume {
        engine.resume(checkpoint)?;
    }
    let mut pictures = start_pictures(plan, options.pictures.clone(), options.realtime.is_none())?;
    let recorder = plan.plugins.iter().find(|p| p.kind == PluginKind::Recorder);
    let recorder = recorder.ok_or_else(|| RunError::Host("the plan has no recorder".into()))?;
    // Last, so that a run that cannot begin leaves no file.
    let mut recorder = Recorder::start(recorder, options.key.clone())?;
    let started = SystemTime::now()
        .duration_since(SystemTime::UNIX_EPOCH)
        .unwrap_or_default();
    recorder.write(&record(
        kind::HEADER,
        0,
        &Header {
            format: RECORD_FORMAT,
            version: env!("CARGO_PKG_VERSION").into(),
            started: started.as_secs(),
            started_subsec_ns: started.subsec_nanos(),
            trainee: options.trainee.clone(),
            id: options.session_id.clone(),
            unlisted: options.unlisted,
            realtime: options.realtime.is_some(),
            plan: recorded_plan(plan),
        },
    ))?;
    if let Some(checkpoint) = &options.resume {
        recorder.write(&record(kind::CHECKPOINT, checkpoint.tick, checkpoint))?;
    }
    let mut run_loop = RunLoop {
        engine: &mut engine,
        recorder: &mut recorder,
        pictures: &mut pictures,
        values: Chain::new(),
    };
    let (mut outcome, stopped) = run_loop.run(plan, options);
    outcome
        .complaints
        .extend(engine.stop().iter().map(Failure::to_string));
    if !stopped {
        outcome
            .complaints
            .extend(recorder.stop(outcome.ticks).err().map(|f| f.to_string()));
    }
    outcome.pictures = pictures.map(Pictures::finish);
    Ok(outcome)
}

/// The plan as it goes into the session: input files stay outside, their samples are in the ticks.
fn recorded_plan(plan: &RunPlan) -> RunPlan {
    let mut plan = plan.clone();
    for plugin in plan
        .plugins
        .iter_mut()
        .filter(|p| p.kind == PluginKind::Source)
    {
        plugin.setup.files.clear();
    }
    plan
}

/// Median, 99th percentile and the longest of times, each the smallest that as many are not above.
fn spread(mut times: Vec<f32>) -> Option<[f64; 3]> {
    times.sort_by(f32::total_cmp);
    let last = times.len().checked_sub(1)?;
    let at = |fraction: f64| {
        let rank = (fraction * times.len() as f64).ceil() as usize;
        f64::from(times[rank.saturating_sub(1).min(last)])
    };
    Some([at(0.5), at(0.99), at(1.0)])
}

/// The loop of a run over its ticks.
struct RunLoop<'a> {
    engine: &'a mut Engine,
    recorder: &'a mut Recorder,
    pictures: &'a mut Option<Pictures>,
    /// The physics digest so far.
    values: Chain,
}

/// Waits while an operator pauses, or until the run is to stop: for how long. The level is informed of it with the next tick.
fn wait_for(operator: &mut dyn Operator, stop: &AtomicBool, host: &mut HostState) -> Duration {
    if !operator.is_paused() {
        return Duration::ZERO;
    }
    let begin = Instant::now();
    while operator.is_paused() && !stop.load(Ordering::Relaxed) {
        std::thread::sleep(PAUSE_LOOK);
    }
    push(&mut host.controls, &LevelControl::Pause);
    push(&mut host.controls, &LevelControl::Resume);
    begin.elapsed()
}

impl RunLoop<'_> {
    /// Ticks until the end. The second value: whether the recorder itself has failed, and must not be called again.
    fn run(&mut self, plan: &RunPlan, options: RunOptions<'_>) -> (RunOutcome, bool) {
        let mut outcome = RunOutcome {
            result: None,
            state_hash: String::new(),
            physics_digest: String::new(),
            ticks: self.engine.tick_index(),
            failure: None,
            complaints: Vec::new(),
            pictures: None,
            late_ticks: 0,
            tick_times: None,
            checkpoint: None,
        };
        let mut times = Vec::new();
        let ended = self.ticks(plan, options, &mut outcome, &mut times);
        outcome.tick_times = spread(times);
        let ended = ended.and_then(|ended| {
            self.add_values(outcome.result.as_ref())?;
            outcome.physics_digest = hex(&self.values.value());
            Ok((ended, self.engine.state_digests(&[])?))
        });
        outcome.state_hash = hex(&self.engine.chain());
        let (ended, states) = match ended {
            Ok(ended) => ended,
            Err(failure) => {
                let recorder_failed = failure.plugin == self.recorder.name();
                let record = record(kind::FAILURE, self.engine.tick_index(), &failure);
                outcome.failure = Some(failure);
                if recorder_failed || self.recorder.write(&record).is_err() {
                    return (outcome, true);
                }
                // States are what they are now: some may be unreadable, and nothing rests on them.
                (Ended::Failure, Vec::new())
            }
        };
        let closed = self.close(ended, states, &outcome);
        let recorder_failed = closed.is_err();
        outcome.failure = outcome.failure.or(closed.err());
        (outcome, recorder_failed)
    }

    fn ticks(
        &mut self,
        plan: &RunPlan,
        mut options: RunOptions<'_>,
        outcome: &mut RunOutcome,
        times: &mut Vec<f32>,
    ) -> Result<Ended, Failure> {
        let now = Instant::now();
        let tick = Duration::from_nanos(plan.tick_ns);
        let mut pace = options.realtime.map(|rule| Pace {
            rule,
            start: now,
            next: now,
            tick,
            late: 0,
        });
        let sources = plan
            .plugins
            .iter()
            .filter(|p| p.kind == PluginKind::Source)
            .count();
        let mut subscriptions = HostSubscriptions::default();
        let mut host = match options.resume {
            Some(checkpoint) => checkpoint.host,
            None => {
                let mut host = HostState::default();
                push(&mut host.controls, &LevelControl::Start);
                host
            }
        };
        let base_ns = self.engine.time_ns();
        loop {
            let tick = self.engine.tick_index();
            if options.stop_at == Some(tick) {
                let checkpoint = self.engine.checkpoint()?;
                outcome.checkpoint = Some(Checkpoint { host, ..checkpoint });
                return Ok(Ended::Checkpoint);
            }
            if let Some(operator) = &mut options.operator {
                let paused = wait_for(*operator, options.stop, &mut host);
                if let Some(pace) = pace.as_mut().filter(|_| !paused.is_zero()) {
                    pace.skip(paused);
                }
            }
            let mut lateness = Duration::ZERO;
            if let Some(pace) = &mut pace {
                lateness = pace.wait();
                outcome.late_ticks = pace.late;
            }
            if let Some(operator) = &mut options.operator {
                operator.send(&mut host.controls);
            }
            if options.stop.load(Ordering::Relaxed) && host.ending_since.is_none() {
                push(&mut host.controls, &LevelControl::Abort);
                host.ending_since = Some(self.engine.time_ns());
            }
            let arrival_ns = match &pace {
                Some(pace) => base_ns.saturating_add(pace.start.elapsed().as_nanos() as u64),
                None => self.engine.time_ns(),
            };
            let _tick = span::of_tick(tick);
            let controls = std::mem::take(&mut host.controls);
            let begin = Instant::now();
            let output = match self.engine.tick(Feed::Live { control: &controls }) {
                Ok(output) => output,
                Err(failure) => {
                    self.record_failed(tick, arrival_ns)?;
                    return Err(failure);
                }
            };
            let duration = begin.elapsed();
            if pace.is_some() {
                times.push(duration.as_secs_f32());
            }
            outcome.ticks = self.engine.tick_index();
            let time = self.engine.time_ns();
            self.record(plan, tick, arrival_ns, &output)?;
            let seconds = time as f64 * 1e-9;
            subscriptions.handle(self.engine, &output, &mut host, &mut |reported| {
                (options.progress)(seconds, Some(reported))
            })?;
            (options.progress)(seconds, None);
            if let Some(operator) = &mut options.operator {
                operator.see(Seen {
                    tick,
                    time: seconds,
                    log: &output.log,
                    duration: duration.as_secs_f64(),
                    lateness: lateness.as_secs_f64(),
                    late_ticks: outcome.late_ticks,
                    engine: self.engine,
                });
            }
            if let Some(result) = subscriptions.result.take() {
                outcome.result = Some(result);
                return Ok(Ended::Result);
            }
            match host.ending_since {
                Some(since) if time > since + ENDING_NS => {
                    let text = "was to end and gave no result within 2 s of simulated time";
                    return Err(Failure::found(&plan.module, "process", tick, text));
                }
                None if sources > 0 && host.ended_sources.len() == sources => {
                    push(&mut host.controls, &LevelControl::InputEnded);
                    host.ending_since = Some(time);
                }
                _ => {}
            }
        }
    }

    /// Adds the values of plugins, and those of a result, to the physics digest.
    fn add_values(&mut self, result: Option<&TrainingResult>) -> Result<(), Failure> {
        let mut parts = self.engine.value_digests()?;
        if let Some(result) = result {
            let values = result.metrics.iter().map(|metric| metric.value);
            let mut bytes = Vec::new();
            for value in values.chain([Some(result.score), Some(result.duration)]) {
                bytes.push(u8::from(value.is_some()));
                bytes.extend_from_slice(&value.unwrap_or_default().to_le_bytes());
            }
            bytes.push(u8::from(result.passed));
            parts.push(bytes);
        }
        let parts = parts.iter().map(Vec::as_slice);
        self.values.add(self.engine.tick_index(), parts);
        Ok(())
    }

    /// Hands a tick to the recorder and to the pictures.
    fn record(
        &mut self,
        plan: &RunPlan,
        tick: u64,
        arrival_ns: u64,
        output: &TickOutput,
    ) -> Result<(), Failure> {
        let states = match (tick + 1).is_multiple_of(plan.hash_every) {
            true => self.engine.state_digests(&[]).map(Some),
            false => Ok(None),
        };
        // The tick is recorded even if a state cannot be saved.
        let (states, failed) = states.map_or_else(|failure| (None, Err(failure)), |s| (s, Ok(())));
        self.recorder.write(&record(
            kind::TICK,
            tick,
            &TickRecord {
                arrival_ns,
                log: output.log.clone(),
                chain: output.chain.to_vec(),
                states,
                failed: false,
            },
        ))?;
        failed?;
        if (tick + 1).is_multiple_of(plan.hash_every) {
            self.recorder.sign(kind::SIGNATURE, tick)?;
            self.add_values(None)?;
        }
        if let Some(pictures) = self.pictures {
            pictures.handle(tick, plan.tick_ns, &output.log, self.engine);
        }
        Ok(())
    }

    /// Records what was published in a tick until a plugin failed: the inputs that it failed on, above all.
    fn record_failed(&mut self, tick: u64, arrival_ns: u64) -> Result<(), Failure> {
        let log = self.engine.take_log();
        print_log(self.engine, &log);
        let chain = self.engine.chain().to_vec();
        self.recorder.write(&record(
            kind::TICK,
            tick,
            &TickRecord {
                arrival_ns,
                log,
                chain,
                states: None,
                failed: true,
            },
        ))
    }

    fn close(
        &mut self,
        ended: Ended,
        states: Vec<StateDigest>,
        outcome: &RunOutcome,
    ) -> Result<(), Failure> {
        let chain = self.engine.chain().to_vec();
        let end = EndRecord {
            ended,
            states,
            chain,
            late_ticks: outcome.late_ticks,
            tick_times: outcome.tick_times,
        };
        let tick = self.engine.tick_index();
        self.recorder.write(&record(kind::CLOSE, tick, &end))?;
        self.recorder.sign(KIND_END, tick)
    }
}
