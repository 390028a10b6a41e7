//! One connection: which samples come of a message, and what is answered. Knows no socket and no clock.

use microsim_igtl::{
    Message, NotRigid, Pose, Received, Start, Status, Stream, Timestamp, Tracked, encode,
};
use microsim_sdk::message::{self, InputSample};
use microsim_settings::{LinkRole, OpenIgtLink, TrackedStream};
use std::collections::BTreeSet;

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
}

impl Conversation {
    pub fn new(config: OpenIgtLink) -> Self {
        Self {
            config,
            seen: BTreeSet::new(),
            streamed: BTreeSet::new(),
            complained: BTreeSet::new(),
            version: 1,
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
        let time = received.time.nanoseconds();
        let time = time.map_or(now, |nanoseconds| nanoseconds as f64 / 1e9);
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
        match message {
            Message::Transform(matrix) => self.place(device, time, matrix.pose(), &mut arrived),
            Message::Position(place) => self.place(device, time, place.pose(), &mut arrived),
            Message::Matrices(tools) => {
                let tools = tools
                    .iter()
                    .map(|tool| (tool.name.clone(), tool.place.pose()));
                self.places(tools.collect(), time, &mut arrived);
            }
            Message::Quaternions(tools) => {
                let pose = |tool: &Tracked<microsim_igtl::Position>| {
                    (tool.name.clone(), tool.place.pose())
                };
                self.places(tools.iter().map(pose).collect(), time, &mut arrived);
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

    /// The samples of a connection that has ended: no tool of it is seen any more.
    pub fn lost(&mut self, now: f64) -> Vec<InputSample> {
        self.streamed.clear();
        let seen = std::mem::take(&mut self.seen).into_iter();
        seen.map(|device| InputSample::not_visible(&device, now))
            .collect()
    }

    /// All tools of a stream; those that it had and has no more are not seen.
    fn places(
        &mut self,
        tools: Vec<(String, Result<Pose, NotRigid>)>,
        time: f64,
        arrived: &mut Arrived,
    ) {
        let mut missing = std::mem::take(&mut self.streamed);
        for (name, pose) in tools {
            let device = self.config.device(&name).to_owned();
            missing.remove(&device);
            self.streamed.insert(device);
            self.place(&name, time, pose, arrived);
        }
        for device in &missing {
            arrived.samples.push(InputSample::not_visible(device, time));
        }
        self.streamed.append(&mut missing);
    }

    fn place(
        &mut self,
        name: &str,
        time: f64,
        pose: Result<Pose, NotRigid>,
        arrived: &mut Arrived,
    ) {
        let device = self.config.device(name).to_owned();
        let sample = match pose {
            Ok(pose) => InputSample {
                device: device.clone(),
                device_time: time,
                visible: true,
                pose: message::Pose {
                    position: pose.position.into(),
                    orientation: pose.orientation.coords.into(),
                },
                opening: None,
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

#[cfg(test)]
mod tests;
