//! The bytes between the host and a guest: one request, one reply, each with its length before it. The plugin contract's own data, and
//! nothing else.

use abi_stable::std_types::{ROption, RSlice, RVec};
use microsim_abi::{Block, BlockOut, Call, Fault, FaultKind, Output};
use std::path::Path;

/// Longest message that is accepted \[B\]: more than any tick needs, less than harms the receiver.
pub const LONGEST: u64 = 1 << 29;

/// In the place of a memory limit: there is none.
pub const NO_LIMIT: u64 = 0;

/// What the host asks for: the calls of the contract, and the loading before them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Ask {
    Load,
    Initialise,
    Reset,
    Process,
    Save,
    Restore,
    Extension,
    Stop,
}

impl Ask {
    const ALL: [Self; 8] = [
        Self::Load,
        Self::Initialise,
        Self::Reset,
        Self::Process,
        Self::Save,
        Self::Restore,
        Self::Extension,
        Self::Stop,
    ];

    /// By its number.
    pub fn of(number: u64) -> Option<Self> {
        Self::ALL.into_iter().find(|ask| *ask as u64 == number)
    }
}

/// Bytes in the making: numbers of eight bytes, and texts with their length.
#[derive(Default)]
pub struct Message(pub Vec<u8>);

impl Message {
    /// Of a request.
    pub fn ask(ask: Ask) -> Self {
        let mut message = Self::default();
        message.number(ask as u64);
        message
    }

    pub fn number(&mut self, number: u64) {
        self.0.extend_from_slice(&number.to_le_bytes());
    }

    pub fn bytes(&mut self, bytes: &[u8]) {
        self.number(bytes.len() as u64);
        self.0.extend_from_slice(bytes);
    }

    pub fn path(&mut self, path: &Path) {
        self.bytes(path.as_os_str().as_encoded_bytes());
    }

    fn words(&mut self, words: &[u64]) {
        self.bytes(bytemuck::cast_slice(words));
    }

    /// What `process` is given.
    pub fn call(&mut self, call: &Call<'_>) {
        self.number(call.tick);
        self.number(call.time_ns);
        self.number(call.tick_ns);
        self.number(call.steps.into());
        self.bytes(&call.messages);
        self.number(call.blocks.len() as u64);
        for block in call.blocks {
            self.number(block.kind);
            self.words(&block.words);
        }
    }

    /// What `process` answers.
    pub fn output(&mut self, output: &Output) {
        self.bytes(&output.messages);
        self.number(output.blocks.len() as u64);
        for block in &output.blocks {
            self.number(block.kind);
            self.words(&block.words);
        }
    }

    /// A reply: what was asked for, or a fault.
    pub fn reply<T>(result: Result<T, Fault>, write: impl FnOnce(&mut Self, T)) -> Self {
        let mut message = Self::default();
        match result {
            Ok(value) => {
                message.number(0);
                write(&mut message, value);
            }
            Err(fault) => {
                message.number(match fault.kind {
                    FaultKind::Error => 1,
                    FaultKind::Unavailable => 2,
                    FaultKind::Panic => 3,
                });
                message.bytes(fault.text.as_bytes());
            }
        }
        message
    }
}

/// Bytes that are read; `None`: they are not what was agreed.
pub struct Reading<'a>(pub &'a [u8]);

impl<'a> Reading<'a> {
    pub fn number(&mut self) -> Option<u64> {
        let (number, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u64::from_le_bytes(*number))
    }

    pub fn bytes(&mut self) -> Option<&'a [u8]> {
        let length = usize::try_from(self.number()?).ok()?;
        let (bytes, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(bytes)
    }

    pub fn text(&mut self) -> Option<&'a str> {
        std::str::from_utf8(self.bytes()?).ok()
    }

    fn blocks(&mut self) -> Option<Vec<(u64, Vec<u64>)>> {
        let count = self.number()?;
        let mut blocks = Vec::new();
        for _ in 0..count {
            let kind = self.number()?;
            let bytes = self.bytes()?;
            if !bytes.len().is_multiple_of(8) {
                return None;
            }
            let (words, _) = bytes.as_chunks();
            let words = words.iter().map(|word| u64::from_le_bytes(*word));
            blocks.push((kind, words.collect()));
        }
        Some(blocks)
    }

    /// What `process` is given, handed to `then`.
    pub fn call<T>(&mut self, then: impl FnOnce(Call<'_>) -> T) -> Option<T> {
        let [tick, time_ns, tick_ns] = [self.number()?, self.number()?, self.number()?];
        let steps = u32::try_from(self.number()?).ok()?;
        let messages = self.bytes()?;
        let blocks = self.blocks()?;
        let blocks: Vec<Block<'_>> = blocks
            .iter()
            .map(|(kind, words)| Block {
                kind: *kind,
                words: RSlice::from_slice(words),
            })
            .collect();
        Some(then(Call {
            tick,
            time_ns,
            tick_ns,
            steps,
            messages: RSlice::from_slice(messages),
            blocks: RSlice::from_slice(&blocks),
        }))
    }

    /// What `process` answers.
    pub fn output(&mut self) -> Option<Output> {
        let messages = self.bytes()?.to_vec().into();
        let blocks = self.blocks()?.into_iter();
        Some(Output {
            messages,
            blocks: blocks
                .map(|(kind, words)| BlockOut {
                    kind,
                    words: words.into(),
                })
                .collect(),
        })
    }

    /// A reply: what `read` makes of it, or a fault.
    pub fn reply<T>(
        mut self,
        read: impl FnOnce(&mut Self) -> Option<T>,
    ) -> Option<Result<T, Fault>> {
        let kind = match self.number()? {
            0 => return read(&mut self).map(Ok),
            1 => FaultKind::Error,
            2 => FaultKind::Unavailable,
            3 => FaultKind::Panic,
            _ => return None,
        };
        let text = self.text()?.into();
        Some(Err(Fault { kind, text }))
    }
}

/// An ability, or none.
pub fn optional(message: &mut Message, answer: ROption<RVec<u8>>) {
    match answer.into_option() {
        None => message.number(0),
        Some(bytes) => {
            message.number(1);
            message.bytes(&bytes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_call_arrives_as_it_was_sent() {
        let words = [3_u64, u64::MAX];
        let blocks = [Block {
            kind: 9,
            words: RSlice::from_slice(&words),
        }];
        let call = Call {
            tick: 5,
            time_ns: 6,
            tick_ns: 7,
            steps: 8,
            messages: RSlice::from_slice(b"frames"),
            blocks: RSlice::from_slice(&blocks),
        };
        let mut message = Message::default();
        message.call(&call);
        let read = Reading(&message.0).call(|c| {
            let block = &c.blocks[0];
            (
                [c.tick, c.time_ns, c.tick_ns, c.steps.into(), block.kind],
                c.messages.to_vec(),
                block.words.to_vec(),
            )
        });
        assert_eq!(
            read,
            Some(([5, 6, 7, 8, 9], b"frames".to_vec(), words.to_vec()))
        );
        // Cut anywhere, it is refused.
        for end in 0..message.0.len() {
            assert!(Reading(&message.0[..end]).call(|_| ()).is_none(), "{end}");
        }
    }

    #[test]
    fn a_reply_is_an_answer_or_a_fault() {
        let fault = Fault {
            kind: FaultKind::Panic,
            text: "why".into(),
        };
        let message = Message::reply(Err::<(), _>(fault.clone()), |_, ()| ());
        assert_eq!(Reading(&message.0).reply(|_| Some(())), Some(Err(fault)));
        let message = Message::reply(Ok(7), |message, n| message.number(n));
        assert_eq!(Reading(&message.0).reply(Reading::number), Some(Ok(7)));
        assert_eq!(Reading(b"\x09").reply(Reading::number), None);
    }
}
