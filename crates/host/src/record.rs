//! What the host writes into a session, and how it is read back. The file format itself is the crate `session`'s.

use crate::engine::{Checkpoint, StateDigest};
use crate::fault::Failure;
use crate::plan::RunPlan;
use microsim_message::{DecodeError, decode_bytes, encode};
use microsim_session::{Ending, Frame, KIND_END, NotASession, read};
use microsim_settings::Clock;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Kinds of records in a session file.
pub mod kind {
    /// [`super::Header`]: the first record.
    pub const HEADER: u8 = 1;
    /// [`super::TickRecord`].
    pub const TICK: u8 = 2;
    /// [`super::Checkpoint`]: the run went on from there.
    pub const CHECKPOINT: u8 = 3;
    /// [`super::Failure`]: a plugin failed.
    pub const FAILURE: u8 = 4;
}

/// Version of the records that this host writes and recomputes.
pub const RECORD_FORMAT: u32 = 2;

/// Longest simulated time of a run that is computed again \[ns\]: a year.
const LONGEST_NS: u64 = 365 * 86_400 * 1_000_000_000;

/// The oldest version of the records that this host reads: their results can be shown, not recomputed.
pub const OLDEST_FORMAT: u32 = 1;

/// The first record: all that a replay needs besides the inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Version of the records.
    pub format: u32,
    /// Version of MicroSim.
    pub version: String,
    /// Wall clock at the start, seconds since 1970; for people only.
    pub started: u64,
    /// Who trains.
    pub trainee: Option<String>,
    /// Whether ticks were paced by the wall clock.
    pub realtime: bool,
    /// What was loaded and computed. Input files are not in it: their samples are in the ticks.
    pub plan: RunPlan,
}

/// One tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TickRecord {
    /// When the inputs of the tick arrived, since the start \[ns\]; simulated time where ticks are not paced.
    pub arrival_ns: u64,
    /// All messages.
    #[serde(with = "serde_bytes")]
    pub log: Vec<u8>,
    /// The running hash after the tick's messages and blocks.
    #[serde(with = "serde_bytes")]
    pub chain: Vec<u8>,
    /// Digests of all saved states, at fixed intervals.
    pub states: Option<Vec<StateDigest>>,
    /// A plugin failed in this tick: `log` is what was published until then, and `chain` is that of the tick before.
    pub failed: bool,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ended {
    /// The module gave its result.
    Result,
    /// A plugin failed.
    Failure,
    /// Stopped at the tick that was asked for.
    Checkpoint,
}

/// The last record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EndRecord {
    /// How it ended.
    pub ended: Ended,
    /// Digests of all saved states at the end.
    pub states: Vec<StateDigest>,
    /// The state hash: the running hash over everything.
    #[serde(with = "serde_bytes")]
    pub chain: Vec<u8>,
    /// Ticks that began late (paced runs).
    pub late_ticks: u64,
}

/// A record with its kind and tick, ready for the file.
pub fn record<T: Serialize>(kind: u8, tick: u64, content: &T) -> microsim_message::SessionRecord {
    microsim_message::SessionRecord {
        kind,
        tick,
        bytes: encode(content),
    }
}

/// Hexadecimal text of a hash.
pub fn hex(hash: &[u8]) -> String {
    hash.iter().map(|b| format!("{b:02x}")).collect()
}

/// A session as it was read.
#[derive(Clone, Debug)]
pub struct Session {
    /// The first record.
    pub header: Header,
    /// Where the run went on from, if it did.
    pub resumed: Option<Checkpoint>,
    /// The ticks: index and record.
    pub ticks: Vec<(u64, TickRecord)>,
    /// The tick in which a plugin failed, up to the failure.
    pub failed_tick: Option<(u64, TickRecord)>,
    /// Plugin failures.
    pub failures: Vec<Failure>,
    /// The last record; `None`: the process was killed or the file is cut.
    pub end: Option<EndRecord>,
    /// Whether bytes in the file are wrong, not merely missing at its end.
    pub damaged: bool,
    /// What the end of the file looks like, if it is not a clean one.
    pub complaint: Option<String>,
}

/// A file that cannot be used at all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionError(pub String);

impl fmt::Display for SessionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for SessionError {}

impl From<NotASession> for SessionError {
    fn from(error: NotASession) -> Self {
        Self(error.to_string())
    }
}

impl Session {
    /// Refuses a session that another version has to recompute: its messages have other names or forms.
    pub fn check_recomputable(&self) -> Result<(), SessionError> {
        let Header {
            format, version, ..
        } = &self.header;
        if *format == RECORD_FORMAT {
            return self.check_bounds();
        }
        Err(SessionError(format!(
            "recorded with MicroSim {version} (record format {format}), which recomputes it; this is MicroSim {} (record format \
             {RECORD_FORMAT}); `microsim report` shows its result",
            env!("CARGO_PKG_VERSION")
        )))
    }

    /// Refuses numbers that no run can have had, and that would keep a replay busy for ever.
    fn check_bounds(&self) -> Result<(), SessionError> {
        let plan = &self.header.plan;
        let refuse = |what: String| {
            Err(SessionError(format!(
                "no run has {what}; nothing is computed"
            )))
        };
        let [shortest, longest] = Clock::TICK.map(|tick| (tick * 1e9) as u64);
        let [fewest, most] = Clock::STEPS;
        if !(shortest..=longest).contains(&plan.tick_ns) {
            return refuse(format!(
                "ticks of {} ns ({shortest} to {longest})",
                plan.tick_ns
            ));
        }
        if !(fewest..=most).contains(&plan.steps) {
            return refuse(format!(
                "{} steps in a tick ({fewest} to {most})",
                plan.steps
            ));
        }
        let of_plan = (plan.seed, plan.tick_ns, plan.steps, plan.level);
        let other = plan.plugins.iter().find(|plugin| {
            let setup = &plugin.setup;
            (setup.seed, setup.tick_ns, setup.steps, setup.level) != of_plan
        });
        if let Some(plugin) = other {
            let name = &plugin.name;
            return refuse(format!(
                "another seed, level, tick or number of steps for \"{name}\""
            ));
        }
        match &self.resumed {
            Some(checkpoint) if checkpoint.tick > LONGEST_NS / plan.tick_ns => {
                refuse(format!("a checkpoint at tick {}", checkpoint.tick))
            }
            _ => Ok(()),
        }
    }

    /// Reads all that is complete; what is wrong with the rest stands in `complaint`.
    pub fn read(bytes: &[u8]) -> Result<Self, SessionError> {
        let reading = read(bytes)?;
        let mut frames = reading.frames.iter();
        let header = match frames.next() {
            Some(frame) if frame.kind == kind::HEADER => {
                check_format(frame)?;
                parse::<Header>(frame).map_err(|e| SessionError(e.to_string()))?
            }
            _ => {
                return Err(SessionError(format!(
                    "it has no complete header, so that nothing can be read: {}",
                    reading.ending
                )));
            }
        };
        let mut session = Self {
            header,
            resumed: None,
            ticks: Vec::new(),
            failed_tick: None,
            damaged: matches!(reading.ending, Ending::Damaged { .. }),
            failures: Vec::new(),
            end: None,
            complaint: match &reading.ending {
                Ending::Clean => None,
                other => Some(other.to_string()),
            },
        };
        for frame in frames {
            if let Err(error) = session.take(frame) {
                session.damaged = true;
                session.complaint = Some(format!(
                    "record at byte {} (tick {}): {error}",
                    frame.offset, frame.tick
                ));
                break;
            }
        }
        Ok(session)
    }

    fn take(&mut self, frame: &Frame<'_>) -> Result<(), DecodeError> {
        match frame.kind {
            kind::TICK => match parse::<TickRecord>(frame)? {
                record if record.failed => self.failed_tick = Some((frame.tick, record)),
                record => self.ticks.push((frame.tick, record)),
            },
            kind::CHECKPOINT => self.resumed = Some(parse(frame)?),
            kind::FAILURE => self.failures.push(parse(frame)?),
            KIND_END => self.end = Some(parse(frame)?),
            // Records of a later version: skipped.
            _ => {}
        }
        Ok(())
    }
}

/// The format stands in the header itself, and is looked at before the rest, which another format may spell otherwise.
fn check_format(frame: &Frame<'_>) -> Result<(), SessionError> {
    #[derive(Deserialize)]
    struct Format {
        format: u32,
    }
    match parse::<Format>(frame) {
        Ok(Format { format }) if !(OLDEST_FORMAT..=RECORD_FORMAT).contains(&format) => {
            Err(SessionError(format!(
                "its records have format {format}, this version reads formats {OLDEST_FORMAT} to {RECORD_FORMAT}"
            )))
        }
        _ => Ok(()),
    }
}

fn parse<T: serde::de::DeserializeOwned>(frame: &Frame<'_>) -> Result<T, DecodeError> {
    decode_bytes(frame.payload)
}
