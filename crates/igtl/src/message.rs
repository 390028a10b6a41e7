//! Messages as data: lengths in millimetres as on the wire, poses by [`Matrix::pose`] and [`Position::pose`].

/// A rotation and a translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix {
    /// The columns of the rotation: where the axes of the device point.
    pub axes: [[f32; 3]; 3],
    /// \[mm\]
    pub translation: [f32; 3],
}

/// A place and a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// \[mm\]
    pub position: [f32; 3],
    /// x, y, z, w of a unit quaternion; `None` where the sender left it out.
    pub orientation: Option<[f32; 4]>,
}

/// Two kinds of streams of tracked tools.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stream {
    /// TDATA.
    Matrices,
    /// QTDATA.
    Quaternions,
}

/// A tool in TDATA or QTDATA. A tool that the tracker does not see is not in the list.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracked<Place> {
    /// Of at most 20 bytes.
    pub name: String,
    /// 1 tracker, 2 instrument with six degrees of freedom, 3 with three, 4 with five; others as they came.
    pub kind: u8,
    /// Where it is.
    pub place: Place,
}

/// A request for a stream of tracked tools.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Start {
    /// Least time between two messages \[ms\].
    pub interval: u32,
    /// Name of the coordinate system, of at most 32 bytes; empty for the sender's own.
    pub coordinates: String,
}

/// A text in its encoding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Text {
    /// MIBenum of the character set (IANA): 3 is US-ASCII, 106 is UTF-8.
    pub encoding: u16,
    /// The bytes, at most 65,535.
    pub bytes: Vec<u8>,
}

/// The state of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Status {
    /// 1 is good; 13 not ready, and others of the specification.
    pub code: u16,
    /// Of the device.
    pub subcode: i64,
    /// Name of the error, of at most 20 bytes.
    pub name: String,
    /// For people.
    pub text: String,
}

/// A message.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// TRANSFORM: where the device is.
    Transform(Matrix),
    /// POSITION: the same, shorter.
    Position(Position),
    /// TDATA.
    Matrices(Vec<Tracked<Matrix>>),
    /// QTDATA.
    Quaternions(Vec<Tracked<Position>>),
    /// STT_TDATA, STT_QTDATA.
    Start(Stream, Start),
    /// STP_TDATA, STP_QTDATA.
    Stop(Stream),
    /// RTS_TDATA, RTS_QTDATA: whether a stream begins.
    Started(Stream, bool),
    /// GET_ and what is asked for, of at most 8 bytes.
    Get(String),
    /// STRING.
    Text(Text),
    /// STATUS.
    Status(Status),
    /// CAPABILITY: the types that the sender knows, each of at most 12 bytes.
    Capability(Vec<String>),
}

/// The type of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// TRANSFORM.
    Transform,
    /// POSITION.
    Position,
    /// TDATA or QTDATA.
    Tracked(Stream),
    /// STT_.
    Start(Stream),
    /// STP_.
    Stop(Stream),
    /// RTS_.
    Started(Stream),
    /// GET_.
    Get(String),
    /// STRING.
    Text,
    /// STATUS.
    Status,
    /// CAPABILITY.
    Capability,
}

impl Kind {
    /// By the name in a header; `None` if this crate does not know it.
    pub fn of(name: &str) -> Option<Self> {
        Some(match name {
            "TRANSFORM" => Self::Transform,
            "POSITION" => Self::Position,
            "TDATA" => Self::Tracked(Stream::Matrices),
            "QTDATA" => Self::Tracked(Stream::Quaternions),
            "STRING" => Self::Text,
            "STATUS" => Self::Status,
            "CAPABILITY" => Self::Capability,
            _ => match (name.split_once('_')?, Stream::of(name)) {
                (("STT", _), Some(stream)) => Self::Start(stream),
                (("STP", _), Some(stream)) => Self::Stop(stream),
                (("RTS", _), Some(stream)) => Self::Started(stream),
                (("GET", what), _) => Self::Get(what.to_owned()),
                _ => return None,
            },
        })
    }
}

impl Stream {
    /// By the end of a type's name.
    fn of(name: &str) -> Option<Self> {
        match name.split_once('_')?.1 {
            "TDATA" => Some(Self::Matrices),
            "QTDATA" => Some(Self::Quaternions),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Matrices => "TDATA",
            Self::Quaternions => "QTDATA",
        }
    }
}

impl Message {
    /// The name of its type, as in a header.
    pub fn kind(&self) -> String {
        match self {
            Self::Transform(_) => "TRANSFORM".into(),
            Self::Position(_) => "POSITION".into(),
            Self::Matrices(_) => Stream::Matrices.name().into(),
            Self::Quaternions(_) => Stream::Quaternions.name().into(),
            Self::Start(stream, _) => format!("STT_{}", stream.name()),
            Self::Stop(stream) => format!("STP_{}", stream.name()),
            Self::Started(stream, _) => format!("RTS_{}", stream.name()),
            Self::Get(what) => format!("GET_{what}"),
            Self::Text(_) => "STRING".into(),
            Self::Status(_) => "STATUS".into(),
            Self::Capability(_) => "CAPABILITY".into(),
        }
    }
}

impl Text {
    /// In UTF-8.
    pub fn utf8(text: &str) -> Self {
        Self {
            encoding: 106,
            bytes: text.as_bytes().to_vec(),
        }
    }

    /// The text, if its encoding is US-ASCII or UTF-8 and its bytes are such.
    pub fn text(&self) -> Option<&str> {
        let text = std::str::from_utf8(&self.bytes).ok()?;
        match self.encoding {
            3 if text.is_ascii() => Some(text),
            106 => Some(text),
            _ => None,
        }
    }
}
