//! What the host writes into a session, and how it is read back. The file format itself is the crate `session`'s.

use crate::engine::{Checkpoint, StateDigest};
use crate::fault::Failure;
use crate::plan::RunPlan;
use microsim_message::{DecodeError, decode_bytes, encode};
use microsim_session::{Ending, Frame, History, KIND_END, NotASession, Reader, Station};
use microsim_settings::Clock;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::io::Read;

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
    /// A [`Seal`](microsim_session::Seal) over all records before it: the session may yet be killed.
    pub const SIGNATURE: u8 = 5;
    /// [`super::EndRecord`]: how the run ended. Behind it comes only the record that closes the file: a seal over everything, or nothing
    /// where there was no key.
    pub const CLOSE: u8 = 6;
}

/// Version of the records that this host writes and recomputes.
pub const RECORD_FORMAT: u32 = 4;

/// The first version with signatures.
const SIGNED_FORMAT: u32 = 3;

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
    /// Nanoseconds within that second, so that short runs have an order; 0 in sessions of before 2026-11-26.
    #[serde(default)]
    pub started_subsec_ns: u32,
    /// Who trains: an id of the store. In sessions of before 2026-11-25 a name.
    pub trainee: Option<String>,
    /// Random id of the session; sessions of before 2026-11-25 have none.
    #[serde(default)]
    pub id: Option<String>,
    /// Whether it was left out of the store on purpose.
    #[serde(default)]
    pub unlisted: bool,
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

/// What the signatures of a session show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signatures {
    /// There is none.
    Missing,
    /// Every byte is as this station signed it.
    Whole(Station),
    /// All up to this tick is as this station signed it; what is behind has no signature: the session was cut off.
    Until(Station, u64),
    /// A signature does not fit what stands before it: something was changed after it was signed.
    Broken,
}

impl Signatures {
    /// With one more seal behind these records.
    fn and(self, history: &History, frame: &Frame<'_>) -> Self {
        let closes = frame.kind == KIND_END;
        let signed = history.signed_by(frame.kind, frame.tick, frame.payload);
        match (self, signed) {
            // Closed without a key, as it was written all along.
            (Self::Missing, None) if closes && frame.payload.is_empty() => Self::Missing,
            (Self::Until(before, _), Some(station)) if before != station => Self::Broken,
            (Self::Missing | Self::Until(..), Some(station)) if closes => Self::Whole(station),
            (Self::Missing | Self::Until(..), Some(station)) => Self::Until(station, frame.tick),
            _ => Self::Broken,
        }
    }
}

/// How the run ended: the last record but the one that closes the file.
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
    /// From the begin of a tick to its snapshot: p50, p99 and the longest (paced runs) \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tick_times: Option<[f64; 3]>,
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
    /// What its signatures show.
    pub signatures: Signatures,
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
        let mut reader = SessionReader::open(bytes)?;
        let mut ticks = Vec::new();
        while let Some(tick) = reader.next_tick()? {
            ticks.push(tick);
        }
        Ok(Self {
            ticks,
            ..reader.session
        })
    }
}

/// Reads a session tick by tick: what is in memory is one of them, however long the session is.
#[derive(Debug)]
pub struct SessionReader<R> {
    frames: Reader<R>,
    /// All but the ticks, as far as the file has been read.
    session: Session,
    history: History,
    /// The first tick: the record before it had to be read first.
    pending: Option<(u64, TickRecord)>,
    closing: Option<EndRecord>,
    /// Where the tick lies that was read last.
    place: Place,
}

/// Where a record lies in its file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Place {
    /// Its first byte.
    pub offset: usize,
    /// Its number, from 0.
    pub sequence: u64,
}

impl<R: Read> SessionReader<R> {
    /// Reads the header, and from where the run went on, if it did.
    pub fn open(source: R) -> Result<Self, SessionError> {
        let mut frames = Reader::open(source)?;
        let mut history = History::new();
        let header = match frames.next_frame().map_err(unreadable)? {
            Some(frame) if frame.kind == kind::HEADER => {
                check_format(&frame)?;
                history.add(frame.kind, frame.tick, frame.payload);
                parse::<Header>(&frame).map_err(|e| SessionError(e.to_string()))?
            }
            _ => {
                let ending = frames.ending().map(|ending| format!(": {ending}"));
                return Err(SessionError(format!(
                    "it has no complete header, so that nothing can be read{}",
                    ending.unwrap_or_default()
                )));
            }
        };
        let mut reader = Self {
            frames,
            session: Session {
                header,
                resumed: None,
                ticks: Vec::new(),
                failed_tick: None,
                failures: Vec::new(),
                end: None,
                damaged: false,
                complaint: None,
                signatures: Signatures::Missing,
            },
            history,
            pending: None,
            closing: None,
            place: Place::default(),
        };
        reader.pending = reader.next_tick()?;
        Ok(reader)
    }

    /// All but the ticks. What stands behind them is known when [`SessionReader::next_tick`] has come to the end.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Where the tick lies that was given last.
    pub(crate) fn place(&self) -> Place {
        self.place
    }

    /// The session and its source, wherever that stands.
    pub(crate) fn into_parts(self) -> (Session, R) {
        (self.session, self.frames.into_source())
    }

    /// The next tick that was computed to its end; `None` when there is no more that can be read.
    pub fn next_tick(&mut self) -> Result<Option<(u64, TickRecord)>, SessionError> {
        if let Some(tick) = self.pending.take() {
            return Ok(Some(tick));
        }
        if self.session.damaged {
            return Ok(None);
        }
        while let Some(frame) = self.frames.next_frame().map_err(unreadable)? {
            let place = Place {
                offset: frame.offset,
                sequence: frame.sequence,
            };
            let taken = take(&mut self.session, &mut self.closing, &self.history, &frame);
            self.history.add(frame.kind, frame.tick, frame.payload);
            match taken {
                Ok(None) => {}
                Ok(Some(record)) => {
                    let tick = frame.tick;
                    self.place = place;
                    return Ok(Some((tick, record)));
                }
                Err(error) => {
                    self.session.damaged = true;
                    self.session.complaint = Some(format!(
                        "record at byte {} (tick {}): {error}",
                        frame.offset, frame.tick
                    ));
                    return Ok(None);
                }
            }
        }
        let ending = self.frames.ending();
        let ending = ending.filter(|ending| *ending != Ending::Clean);
        self.session.damaged = matches!(ending, Some(Ending::Damaged { .. }));
        self.session.complaint = ending.map(|ending| ending.to_string());
        Ok(None)
    }
}

pub(crate) fn unreadable(error: std::io::Error) -> SessionError {
    SessionError(error.to_string())
}

/// Takes one record; a tick that was computed to its end comes back.
fn take(
    session: &mut Session,
    closing: &mut Option<EndRecord>,
    history: &History,
    frame: &Frame<'_>,
) -> Result<Option<TickRecord>, DecodeError> {
    let signed = session.header.format >= SIGNED_FORMAT;
    if closing.is_some() && frame.kind != KIND_END {
        return Err(DecodeError("nothing may follow how the run ended".into()));
    }
    match frame.kind {
        kind::TICK => match parse::<TickRecord>(frame)? {
            record if record.failed => session.failed_tick = Some((frame.tick, record)),
            record => return Ok(Some(record)),
        },
        kind::CHECKPOINT => session.resumed = Some(parse(frame)?),
        kind::FAILURE => session.failures.push(parse(frame)?),
        kind::SIGNATURE if signed => session.signatures = session.signatures.and(history, frame),
        kind::CLOSE if signed => *closing = Some(parse(frame)?),
        KIND_END if signed => {
            let end = closing.take();
            session.end = Some(end.ok_or_else(|| {
                DecodeError("the file is closed and does not state how the run ended".into())
            })?);
            session.signatures = session.signatures.and(history, frame);
        }
        KIND_END => session.end = Some(parse(frame)?),
        // Records of a later version: skipped.
        _ => {}
    }
    Ok(None)
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

pub(crate) fn parse<T: serde::de::DeserializeOwned>(frame: &Frame<'_>) -> Result<T, DecodeError> {
    decode_bytes(frame.payload)
}
