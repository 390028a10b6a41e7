//! One connection: which samples come of a message, and what is answered. Knows no socket and no clock.

use microsim_igtl::{
    Matrix, Message, NotRigid, Pose, Position, Received, Start, Status, Stream, Timestamp, Tracked,
    encode,
};
use microsim_sdk::message::{self, InputSample};
use microsim_settings::{LinkClock, LinkRole, OpenIgtLink, TrackedStream};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// Types of messages that this program understands, for CAPABILITY.
const TYPES: [&str; 7] = [
    "TRANSFORM",
    "POSITION",
    "TDATA",
    "QTDATA",
    "STRING",
    "STATUS",
    "CAPABILITY",
];
/// Name of this device in messages that it sends.
const DEVICE: &str = "MicroSim";
/// Code of a STATUS without a fault.
const GOOD: u16 = 1;

/// A place on the wire: its position, and its pose if it has one.
#[derive(Clone, Copy, Debug)]
struct Place {
    position: Result<Vector3<f64>, NotRigid>,
    pose: Result<Pose, NotRigid>,
}

impl From<&Matrix> for Place {
    fn from(matrix: &Matrix) -> Self {
        Self {
            position: matrix.place(),
            pose: matrix.pose(),
        }
    }
}

impl From<&Position> for Place {
    fn from(position: &Position) -> Self {
        Self {
            position: position.place(),
            pose: position.pose(),
        }
    }
}

/// What came of a message.
#[derive(Debug, Default, PartialEq)]
pub struct Arrived {
    pub samples: Vec<InputSample>,
    /// For the operator; whether each is a warning.
    pub notes: Vec<(bool, String)>,
    /// Bytes to send.
    pub answer: Option<Vec<u8>>,
}

/// One connection.
#[derive(Debug)]
pub struct Conversation {
    config: OpenIgtLink,
    /// Devices that were seen on it.
    seen: BTreeSet<String>,
    /// Those of them that come in streams, where a tool that is not seen is left out.
    streamed: BTreeSet<String>,
    /// What was complained about, once each.
    complained: BTreeSet<String>,
    /// Version of the header that the peer has sent; 1 until it has sent any.
    version: u16,
    /// Openings that came by themselves, by device.
    openings: BTreeMap<String, f64>,
    /// Time of the first sample, where times count from it \[ns\].
    start: Option<u64>,
}

impl Conversation {
    pub fn new(config: OpenIgtLink) -> Self {
        Self {
            config,
            seen: BTreeSet::new(),
            streamed: BTreeSet::new(),
            complained: BTreeSet::new(),
            version: 1,
            openings: BTreeMap::new(),
            start: None,
        }
    }

    /// What a client asks for first.
    pub fn begin(&self) -> Option<Vec<u8>> {
        let start = Start {
            // At most a second.
            interval: (self.config.interval * 1e3).round() as u32,
            coordinates: String::new(),
        };
        self.bytes(&Message::Start(self.stream()?, start))
    }

    /// What a client sends last.
    pub fn end(&self) -> Option<Vec<u8>> {
        self.bytes(&Message::Stop(self.stream()?))
    }

    fn stream(&self) -> Option<Stream> {
        match (self.config.role, self.config.stream) {
            (LinkRole::Server, _) | (_, TrackedStream::Unasked) => None,
            (LinkRole::Client, TrackedStream::Matrices) => Some(Stream::Matrices),
            (LinkRole::Client, TrackedStream::Quaternions) => Some(Stream::Quaternions),
        }
    }

    /// What comes of a message that arrived at `now` \[s since 1970\].
    pub fn receive(&mut self, received: Received, now: f64) -> Arrived {
        let mut arrived = Arrived::default();
        self.version = received.version.clamp(1, 2);
        let device = &received.device;
        let message = match received.message {
            Ok(Some(message)) => message,
            Ok(None) => {
                let note = format!("messages of type {} are not used", received.kind);
                self.complain(false, note, &mut arrived);
                return arrived;
            }
            Err(error) => {
                self.complain(true, error.to_string(), &mut arrived);
                return arrived;
            }
        };
        let stamp = received.time;
        match message {
            Message::Transform(matrix) => {
                if let Some(time) = self.time(stamp, now, &mut arrived) {
                    self.place(device, time, Place::from(&matrix), &mut arrived);
                }
            }
            Message::Position(position) => {
                if let Some(time) = self.time(stamp, now, &mut arrived) {
                    self.place(device, time, Place::from(&position), &mut arrived);
                }
            }
            Message::Matrices(tools) => {
                let tools = tools.iter().map(named).collect();
                if let Some(time) = self.time(stamp, now, &mut arrived) {
                    self.places(tools, time, &mut arrived);
                }
            }
            Message::Quaternions(tools) => {
                let tools = tools.iter().map(named).collect();
                if let Some(time) = self.time(stamp, now, &mut arrived) {
                    self.places(tools, time, &mut arrived);
                }
            }
            Message::Started(_, true) | Message::Stop(_) | Message::Capability(_) => {}
            Message::Started(..) => {
                let note = "the tracker refuses the stream that is asked for".to_owned();
                self.complain(true, note, &mut arrived);
            }
            Message::Start(stream, _) => {
                arrived.answer = self.bytes(&Message::Started(stream, false));
            }
            Message::Get(what) => arrived.answer = self.answer(&what),
            Message::Text(text) => {
                let text = String::from_utf8_lossy(&text.bytes).into_owned();
                arrived.notes.push((false, format!("{device}: {text:?}")));
            }
            Message::Status(status) if status.code != GOOD => {
                let Status {
                    code, name, text, ..
                } = status;
                let note = format!("{device}: status {code} {name:?}: {text:?}");
                self.complain(true, note, &mut arrived);
            }
            Message::Status(_) => {}
        }
        arrived
    }

    /// When a sample was measured \[s\]: by the sender's clock, or when it arrived where the sender states none. Where the sender's clock decides, from its first
    /// sample on; one without a time is none.
    fn time(&mut self, stamp: Timestamp, now: f64, arrived: &mut Arrived) -> Option<f64> {
        let seconds = |nanoseconds: u64| nanoseconds as f64 / 1e9;
        match (self.config.clock, stamp.nanoseconds()) {
            (LinkClock::Arrival, None) => Some(now),
            (LinkClock::Arrival, Some(nanoseconds)) => Some(seconds(nanoseconds)),
            (LinkClock::Device, Some(nanoseconds)) => {
                let start = *self.start.get_or_insert(nanoseconds);
                let since = nanoseconds.checked_sub(start);
                if since.is_none() {
                    let note = "a sample from before the first one is left out".to_owned();
                    self.complain(true, note, arrived);
                }
                since.map(seconds)
            }
            (LinkClock::Device, None) => {
                let note =
                    "samples without a time are left out, as `clock` is \"device\"".to_owned();
                self.complain(true, note, arrived);
                None
            }
        }
    }

    /// The samples of a connection that has ended: no tool of it is seen any more.
    pub fn lost(&mut self, now: f64) -> Vec<InputSample> {
        self.streamed.clear();
        let seen = std::mem::take(&mut self.seen).into_iter();
        seen.map(|device| InputSample::not_visible(&device, now))
            .collect()
    }

    /// All tools of a stream; those that it had and has no more are not seen.
    fn places(&mut self, tools: Vec<(String, Place)>, time: f64, arrived: &mut Arrived) {
        let mut missing = std::mem::take(&mut self.streamed);
        // Openings first: they are of the tools of the same message.
        let (openings, tools): (Vec<_>, Vec<_>) = tools
            .into_iter()
            .partition(|(name, _)| self.config.opening(name).is_some());
        for (name, place) in openings {
            self.place(&name, time, place, arrived);
        }
        for (name, place) in tools {
            let device = self.config.device(&name).to_owned();
            missing.remove(&device);
            self.streamed.insert(device);
            self.place(&name, time, place, arrived);
        }
        for device in &missing {
            arrived.samples.push(InputSample::not_visible(device, time));
        }
        self.streamed.append(&mut missing);
    }

    fn place(&mut self, name: &str, time: f64, place: Place, arrived: &mut Arrived) {
        if let Some((device, opening)) = self.config.opening(name) {
            match place.position {
                Ok(position) => {
                    let opening = opening.opening(position.x);
                    self.openings.insert(device.to_owned(), opening);
                }
                Err(error) => self.complain(true, format!("{name}: {error}"), arrived),
            }
            return;
        }
        let device = self.config.device(name).to_owned();
        // Of a marker the position counts, whatever its orientation is.
        let pose = match self.config.is_marker(&device) {
            true => place.position.map(|position| message::Pose {
                position: position.into(),
                ..message::Pose::default()
            }),
            false => place.pose.map(|pose| message::Pose {
                position: pose.position.into(),
                orientation: pose.orientation.coords.into(),
            }),
        };
        let sample = match pose {
            Ok(pose) => InputSample {
                device: device.clone(),
                device_time: time,
                visible: true,
                pose,
                opening: self.openings.get(&device).copied(),
            },
            Err(error) => {
                self.complain(true, format!("{name}: {error}"), arrived);
                InputSample::not_visible(&device, time)
            }
        };
        arrived.samples.push(sample);
        self.seen.insert(device);
    }

    fn answer(&self, what: &str) -> Option<Vec<u8>> {
        self.bytes(&match what {
            "CAPABIL" | "CAPABILITY" => Message::Capability(TYPES.map(str::to_owned).to_vec()),
            "STATUS" => Message::Status(Status {
                code: GOOD,
                subcode: 0,
                name: String::new(),
                text: String::new(),
            }),
            _ => return None,
        })
    }

    /// Nothing of what is sent is too long for its field.
    fn bytes(&self, message: &Message) -> Option<Vec<u8>> {
        encode(self.version, DEVICE, Timestamp::default(), message).ok()
    }

    /// The same once on a connection, and not without end.
    fn complain(&mut self, is_warning: bool, note: String, arrived: &mut Arrived) {
        const MOST: usize = 100;
        if self.complained.len() < MOST && self.complained.insert(note.clone()) {
            arrived.notes.push((is_warning, note));
        }
    }
}

/// A tool of a list with its place.
fn named<T>(tool: &Tracked<T>) -> (String, Place)
where
    for<'a> Place: From<&'a T>,
{
    (tool.name.clone(), Place::from(&tool.place))
}

#[cfg(test)]
mod tests;
