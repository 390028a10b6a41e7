//! One `process` call, typed.

use crate::fault::Fault;
use microsim_bus::{BlockView, Frame, Frames, kind_id};
use microsim_message::{Log, LogLevel, Message, decode, push};

/// What a plugin receives and publishes in one tick.
#[derive(Debug)]
pub struct Tick<'a> {
    pub(crate) index: u64,
    pub(crate) time_ns: u64,
    pub(crate) tick_ns: u64,
    pub(crate) steps: u32,
    pub(crate) messages: &'a [u8],
    pub(crate) blocks: Vec<BlockView<'a>>,
    pub(crate) out: Vec<u8>,
    pub(crate) out_blocks: Vec<(u64, Vec<u64>)>,
}

impl<'a> Tick<'a> {
    /// Index of the tick, from 0.
    pub fn index(&self) -> u64 {
        self.index
    }

    /// Simulated time at the end of the tick \[s\].
    pub fn time(&self) -> f64 {
        self.time_ns as f64 * 1e-9
    }

    /// Simulated time at the end of the tick \[ns\].
    pub fn time_ns(&self) -> u64 {
        self.time_ns
    }

    /// Length of the tick \[s\].
    pub fn length(&self) -> f64 {
        self.tick_ns as f64 * 1e-9
    }

    /// Solver steps in the tick.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// All messages for this plugin, of any kind, oldest first.
    pub fn frames(&self) -> impl Iterator<Item = Result<Frame<'a>, Fault>> + use<'a> {
        Frames::new(self.messages).map(|frame| frame.map_err(|e| Fault::new(e.to_string())))
    }

    /// The messages of one kind, oldest first.
    pub fn messages<M: Message>(&self) -> Result<Vec<M>, Fault> {
        let mut messages = Vec::new();
        for frame in self.frames() {
            if let Some(message) = decode(&frame?) {
                messages.push(message?);
            }
        }
        Ok(messages)
    }

    /// The newest message of one kind.
    pub fn latest<M: Message>(&self) -> Result<Option<M>, Fault> {
        let kind = kind_id(M::KIND);
        let mut latest = None;
        for frame in self.frames() {
            let frame = frame?;
            if frame.header.kind == kind {
                latest = Some(frame);
            }
        }
        let message = latest.and_then(|f| decode(&f)).transpose();
        message.map_err(Fault::from)
    }

    /// Publishes a message; subscribers that come later in the tick receive it in this tick, the others in the next.
    pub fn publish<M: Message>(&mut self, message: &M) {
        push(&mut self.out, message);
    }

    /// A line for the host's log.
    pub fn log(&mut self, level: LogLevel, text: impl Into<String>) {
        let text = text.into();
        self.publish(&Log { level, text });
    }

    /// The latest blocks of one kind, ordered by the id of their name.
    pub fn blocks(&self, kind: &str) -> impl Iterator<Item = BlockView<'a>> {
        let kind = kind_id(kind);
        self.blocks
            .iter()
            .copied()
            .filter(move |b| b.kind() == kind)
    }

    /// The latest block of one kind and name.
    pub fn block(&self, kind: &str, name: &str) -> Option<BlockView<'a>> {
        let name = kind_id(name);
        self.blocks(kind).find(|b| b.name() == name)
    }

    /// Publishes a block ([`microsim_bus::BlockBuilder::finish`]).
    pub fn publish_block(&mut self, words: Vec<u64>) {
        let kind = words.get(1).copied().unwrap_or_default();
        self.out_blocks.push((kind, words));
    }
}
