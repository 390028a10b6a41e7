//! Who may publish, who receives what, in which order, and what happens when a queue is full.
//!
//! Every publication is checked against the sender's declared topics, stamped with time and sender, appended to the
//! log of the tick and to the queue of every subscriber but the sender. Queues are bounded ([`Limits`]); the rule for
//! a full one belongs to the message kind ([`Overflow`]). Blocks are not queued: the latest of each kind and name is
//! what a reader gets.

use crate::block::{Block, BlockError};
use crate::frame::{FrameError, Frames, HEADER_SIZE, Header, push_stamped};
use crate::kind::{KindInfo, kind_id};
use microsim_vocabulary::Overflow;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;

/// An endpoint of the bus: the index that its registration returned.
pub type EndpointId = u16;
/// The host itself as a sender; it may publish every registered kind and has no queue.
pub const HOST: EndpointId = u16::MAX;

/// Bounds of one subscriber's queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Messages in a queue.
    pub messages: usize,
    /// Bytes in a queue, headers included.
    pub bytes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            messages: 4096,
            bytes: 4 << 20,
        }
    }
}

/// A set-up that cannot work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RouterError {
    /// Two kinds of one name (or, once in 10¹⁹, of one id).
    DuplicateKind(String, String),
    /// An endpoint names a kind that nobody registered.
    UnknownKind {
        /// Who names it.
        endpoint: String,
        /// What it names.
        kind: String,
    },
    /// Two endpoints of one name, or more than the bus can number.
    DuplicateEndpoint(String),
    /// Saved bytes that do not fit this router.
    BadState(String),
}

impl fmt::Display for RouterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DuplicateKind(a, b) => {
                write!(f, "message kinds \"{a}\" and \"{b}\" have the same id")
            }
            Self::UnknownKind { endpoint, kind } => {
                write!(
                    f,
                    "\"{endpoint}\" names the message kind \"{kind}\", which no loaded plugin brings"
                )
            }
            Self::DuplicateEndpoint(name) => write!(f, "two endpoints are called \"{name}\""),
            Self::BadState(what) => write!(f, "saved bus state does not fit: {what}"),
        }
    }
}

impl std::error::Error for RouterError {}

/// A publication that was refused; the sender is at fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Violation {
    /// Bytes that are no frames.
    Frame(FrameError),
    /// A block that is none.
    Block(BlockError),
    /// A kind that this run does not know.
    UnknownKind(u64),
    /// A kind that the sender's manifest does not list under `publishes`.
    NotDeclared(String),
    /// Another version of the kind than the registered one.
    Version {
        /// Name of the kind.
        kind: String,
        /// Version in the header.
        found: u16,
        /// Version registered.
        expected: u16,
    },
    /// More in one publication than a queue could ever hold.
    TooMuch {
        /// Bytes published.
        bytes: usize,
        /// Bytes allowed.
        limit: usize,
    },
    /// A queue is full of messages that must not be lost.
    Overflow {
        /// Name of the kind.
        kind: String,
        /// Whose queue is full.
        subscriber: String,
    },
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frame(e) => e.fmt(f),
            Self::Block(e) => e.fmt(f),
            Self::UnknownKind(id) => write!(f, "published a message of unknown kind {id:#018x}"),
            Self::NotDeclared(kind) => {
                write!(
                    f,
                    "published \"{kind}\", which its manifest does not list under `publishes`"
                )
            }
            Self::Version {
                kind,
                found,
                expected,
            } => {
                write!(
                    f,
                    "published \"{kind}\" in version {found}, this run knows version {expected}"
                )
            }
            Self::TooMuch { bytes, limit } => {
                write!(
                    f,
                    "published {bytes} bytes of messages at once, at most {limit} are allowed"
                )
            }
            Self::Overflow { kind, subscriber } => {
                write!(
                    f,
                    "published more \"{kind}\" than the queue of \"{subscriber}\" holds"
                )
            }
        }
    }
}

impl std::error::Error for Violation {}

#[derive(Clone, Debug)]
struct Endpoint {
    name: String,
    publishes: BTreeSet<u64>,
    subscribes: BTreeSet<u64>,
    queue: VecDeque<Vec<u8>>,
    queue_bytes: usize,
}

/// The bus of one run.
#[derive(Clone, Debug)]
pub struct Router {
    limits: Limits,
    kinds: BTreeMap<u64, KindInfo>,
    endpoints: Vec<Endpoint>,
    blocks: BTreeMap<(u64, u64), Block>,
    log: Vec<u8>,
    new_blocks: Vec<(u64, u64)>,
    dropped: BTreeMap<(EndpointId, u64), u64>,
}

impl Router {
    /// A bus that knows `kinds`.
    pub fn new(
        limits: Limits,
        kinds: impl IntoIterator<Item = KindInfo>,
    ) -> Result<Self, RouterError> {
        let mut known = BTreeMap::new();
        for kind in kinds {
            let name = kind.name.clone();
            if let Some(other) = known.insert(kind.id(), kind) {
                return Err(RouterError::DuplicateKind(other.name, name));
            }
        }
        Ok(Self {
            limits,
            kinds: known,
            endpoints: Vec::new(),
            blocks: BTreeMap::new(),
            log: Vec::new(),
            new_blocks: Vec::new(),
            dropped: BTreeMap::new(),
        })
    }

    /// Adds an endpoint with the topics of its manifest. Endpoints are numbered in the order of their registration.
    pub fn register(
        &mut self,
        name: &str,
        publishes: &[String],
        subscribes: &[String],
    ) -> Result<EndpointId, RouterError> {
        if self.endpoints.iter().any(|e| e.name == name) || self.endpoints.len() >= HOST as usize {
            return Err(RouterError::DuplicateEndpoint(name.into()));
        }
        let ids = |names: &[String]| {
            names
                .iter()
                .map(|kind| {
                    let id = kind_id(kind);
                    self.kinds.contains_key(&id).then_some(id).ok_or_else(|| {
                        RouterError::UnknownKind {
                            endpoint: name.into(),
                            kind: kind.clone(),
                        }
                    })
                })
                .collect::<Result<BTreeSet<_>, _>>()
        };
        let endpoint = Endpoint {
            name: name.into(),
            publishes: ids(publishes)?,
            subscribes: ids(subscribes)?,
            queue: VecDeque::new(),
            queue_bytes: 0,
        };
        self.endpoints.push(endpoint);
        Ok((self.endpoints.len() - 1) as EndpointId)
    }

    /// Name of a kind, for people.
    pub fn kind_name(&self, id: u64) -> Option<&str> {
        self.kinds.get(&id).map(|k| k.name.as_str())
    }

    /// Name of an endpoint, for people.
    pub fn endpoint_name(&self, id: EndpointId) -> &str {
        match self.endpoints.get(id as usize) {
            Some(endpoint) => &endpoint.name,
            None => "host",
        }
    }

    /// Publishes all frames of `bytes` in their order. The first bad one ends it; those before it are delivered.
    pub fn publish(
        &mut self,
        sender: EndpointId,
        time_ns: u64,
        bytes: &[u8],
    ) -> Result<(), Violation> {
        // The host's own messages come from outside of the run and are few.
        if bytes.len() > self.limits.bytes && sender != HOST {
            return Err(Violation::TooMuch {
                bytes: bytes.len(),
                limit: self.limits.bytes,
            });
        }
        for frame in Frames::new(bytes) {
            let frame = frame.map_err(Violation::Frame)?;
            let kind = self.check(sender, frame.header.kind)?;
            if kind.version != frame.header.version {
                return Err(Violation::Version {
                    kind: kind.name.clone(),
                    found: frame.header.version,
                    expected: kind.version,
                });
            }
            let (name, overflow) = (kind.name.clone(), kind.overflow);
            let header = Header {
                time_ns,
                sender,
                ..frame.header
            };
            let mut stamped = Vec::with_capacity(HEADER_SIZE + frame.payload.len());
            push_stamped(&mut stamped, &header, frame.payload);
            for subscriber in 0..self.endpoints.len() {
                let wants = self.endpoints[subscriber].subscribes.contains(&header.kind);
                if wants && subscriber != sender as usize {
                    self.enqueue(subscriber, &name, overflow, &header, &stamped)?;
                }
            }
            self.log.extend_from_slice(&stamped);
        }
        Ok(())
    }

    /// Publishes a block; it replaces the latest of its kind and name.
    pub fn publish_block(
        &mut self,
        sender: EndpointId,
        kind: u64,
        words: &[u64],
    ) -> Result<(), Violation> {
        self.check(sender, kind)?;
        let block = Block::new(words).map_err(Violation::Block)?;
        if block.view().kind() != kind {
            return Err(Violation::UnknownKind(block.view().kind()));
        }
        let key = (kind, block.view().name());
        self.blocks.insert(key, block);
        self.new_blocks.push(key);
        Ok(())
    }

    fn check(&self, sender: EndpointId, kind: u64) -> Result<&KindInfo, Violation> {
        let info = self.kinds.get(&kind).ok_or(Violation::UnknownKind(kind))?;
        match self.endpoints.get(sender as usize) {
            Some(endpoint) if !endpoint.publishes.contains(&kind) => {
                Err(Violation::NotDeclared(info.name.clone()))
            }
            _ => Ok(info),
        }
    }

    fn enqueue(
        &mut self,
        subscriber: usize,
        name: &str,
        overflow: Overflow,
        header: &Header,
        stamped: &[u8],
    ) -> Result<(), Violation> {
        let limits = self.limits;
        let endpoint = &mut self.endpoints[subscriber];
        while endpoint.queue.len() >= limits.messages
            || endpoint.queue_bytes + stamped.len() > limits.bytes
        {
            let kind = header.kind.to_le_bytes();
            let oldest = endpoint.queue.iter().position(|m| m[..8] == kind);
            match oldest.filter(|_| overflow == Overflow::DropOldest) {
                Some(oldest) => {
                    let lost = endpoint.queue.remove(oldest).unwrap_or_default();
                    endpoint.queue_bytes -= lost.len();
                    *self
                        .dropped
                        .entry((subscriber as EndpointId, header.kind))
                        .or_default() += 1;
                }
                None => {
                    return Err(Violation::Overflow {
                        kind: name.into(),
                        subscriber: endpoint.name.clone(),
                    });
                }
            }
        }
        endpoint.queue.push_back(stamped.to_vec());
        endpoint.queue_bytes += stamped.len();
        Ok(())
    }

    /// Empties an endpoint's queue: its messages, oldest first.
    pub fn take_messages(&mut self, endpoint: EndpointId) -> Vec<u8> {
        let endpoint = &mut self.endpoints[endpoint as usize];
        let mut bytes = Vec::with_capacity(endpoint.queue_bytes);
        for message in endpoint.queue.drain(..) {
            bytes.extend_from_slice(&message);
        }
        endpoint.queue_bytes = 0;
        bytes
    }

    /// The latest blocks that an endpoint subscribes to, ordered by kind and name id.
    pub fn blocks_for(&self, endpoint: EndpointId) -> Vec<Block> {
        let subscribes = &self.endpoints[endpoint as usize].subscribes;
        self.blocks
            .iter()
            .filter(|((kind, _), _)| subscribes.contains(kind))
            .map(|(_, block)| block.clone())
            .collect()
    }

    /// The latest block of every kind and name, in the order of their ids: for observers.
    pub fn blocks(&self) -> Vec<Block> {
        self.blocks.values().cloned().collect()
    }

    /// All that was published since the last call, stamped: the log of the tick.
    pub fn take_log(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.log)
    }

    /// The blocks that were published since the last call, in that order.
    pub fn take_new_blocks(&mut self) -> Vec<Block> {
        let keys = std::mem::take(&mut self.new_blocks);
        keys.iter()
            .filter_map(|key| self.blocks.get(key).cloned())
            .collect()
    }

    /// Messages that full queues have lost since the last call: (subscriber, kind, number).
    pub fn take_dropped(&mut self) -> Vec<(String, String, u64)> {
        let dropped = std::mem::take(&mut self.dropped);
        dropped
            .into_iter()
            .map(|((endpoint, kind), n)| {
                let kind = self.kind_name(kind).unwrap_or("?").to_owned();
                (self.endpoint_name(endpoint).to_owned(), kind, n)
            })
            .collect()
    }

    /// Forgets all messages and blocks, as if new.
    pub fn clear(&mut self) {
        for endpoint in &mut self.endpoints {
            endpoint.queue.clear();
            endpoint.queue_bytes = 0;
        }
        self.blocks.clear();
        self.log.clear();
        self.new_blocks.clear();
        self.dropped.clear();
    }

    /// Queues and latest blocks as bytes, between two ticks.
    pub fn save(&self) -> Vec<u8> {
        let mut out = Vec::new();
        let mut put = |bytes: &[u8]| {
            out.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
            out.extend_from_slice(bytes);
        };
        for endpoint in &self.endpoints {
            put(&endpoint
                .queue
                .iter()
                .flatten()
                .copied()
                .collect::<Vec<u8>>());
        }
        for block in self.blocks.values() {
            let bytes: Vec<u8> = block.words().iter().flat_map(|w| w.to_le_bytes()).collect();
            put(&bytes);
        }
        out
    }

    /// The opposite of [`Router::save`], for a router with the same kinds and endpoints.
    pub fn restore(&mut self, state: &[u8]) -> Result<(), RouterError> {
        let bad = |what: &str| RouterError::BadState(what.into());
        let mut parts = Vec::new();
        let mut rest = state;
        while !rest.is_empty() {
            let (size, tail) = rest
                .split_first_chunk::<8>()
                .ok_or_else(|| bad("torn size"))?;
            let size = u64::from_le_bytes(*size) as usize;
            let part = tail.get(..size).ok_or_else(|| bad("torn part"))?;
            parts.push(part);
            rest = &tail[size..];
        }
        if parts.len() < self.endpoints.len() {
            return Err(bad("fewer queues than endpoints"));
        }
        let (queues, blocks) = parts.split_at(self.endpoints.len());
        let mut new_queues = Vec::new();
        for queue in queues {
            let mut messages = VecDeque::new();
            for frame in Frames::new(queue) {
                let frame = frame.map_err(|e| RouterError::BadState(e.to_string()))?;
                let mut stamped = Vec::new();
                push_stamped(&mut stamped, &frame.header, frame.payload);
                messages.push_back(stamped);
            }
            new_queues.push(messages);
        }
        let mut new_blocks = BTreeMap::new();
        for bytes in blocks {
            let words: Vec<u64> = bytes
                .chunks_exact(8)
                .map(|c| u64::from_le_bytes(c.try_into().expect("8 bytes")))
                .collect();
            let block = Block::new(&words).map_err(|e| RouterError::BadState(e.to_string()))?;
            new_blocks.insert((block.view().kind(), block.view().name()), block);
        }
        for (endpoint, queue) in self.endpoints.iter_mut().zip(new_queues) {
            endpoint.queue_bytes = queue.iter().map(Vec::len).sum();
            endpoint.queue = queue;
        }
        self.blocks = new_blocks;
        Ok(())
    }
}
