//! The message bus: bounded, ordered, recordable. It knows no plugin and no message type.
//!
//! - [`kind`]: names of message kinds and their ids.
//! - [`frame`]: how a message travels as bytes behind a header.
//! - [`block`]: how a large state travels as one relocatable block of plain data.
//! - [`router`]: who may publish and who receives what; the queues and their overflow rule; order.
//!
//! Not here: typed messages (crate `message`), threads, clocks. Order is that of publication; two runs with the same
//! publications give the same queues to the byte.

#![forbid(unsafe_code)]

pub mod block;
pub mod frame;
pub mod kind;
pub mod router;
#[cfg(test)]
mod router_tests;

pub use block::{Block, BlockBuilder, BlockError, BlockView};
pub use frame::{Frame, FrameError, Frames, Header, push_frame};
pub use kind::{KindInfo, kind_id};
pub use microsim_vocabulary::Overflow;
pub use router::{EndpointId, HOST, Limits, Router, RouterError, Violation};
