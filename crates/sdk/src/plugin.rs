//! The safe face of the plugin contract.

use crate::fault::Fault;
use crate::parallel::Parallel;
use crate::tick::Tick;
use microsim_message::Setup;

/// What the host offers beyond messages.
///
/// Log and progress are messages ([`Tick::log`]); files of the plugin's own and the seed are in its [`Setup`].
#[derive(Debug)]
pub struct Services {
    /// Parallel loop; serial where the host gives none (training modules, observers, tests).
    pub parallel: Parallel,
}

/// A plugin of any kind.
///
/// What it does is decided by the messages that it receives and publishes; its manifest declares them. The host calls it from one thread
/// at a time, never re-entrantly (details: crate `abi`). A training module implements [`Exercise`](crate::Exercise) instead.
///
/// ```
/// use microsim_sdk::message::{LevelControl, Message, decode_bytes, encode};
/// use microsim_sdk::{Fault, Plugin, Services, Setup, TestHost, Tick};
/// use serde::{Deserialize, Serialize};
///
/// /// A message of the plugin's own; the manifest declares its kind.
/// #[derive(Debug, PartialEq, Serialize, Deserialize)]
/// struct Pauses {
///     number: u32,
/// }
///
/// impl Message for Pauses {
///     const KIND: &'static str = "counter.pauses";
/// }
///
/// /// Counts how often the operator pauses.
/// struct Counter(u32);
///
/// impl Plugin for Counter {
///     fn new() -> Self {
///         Self(0)
///     }
///
///     fn initialise(&mut self, _: &Setup, _: Services) -> Result<(), Fault> {
///         Ok(())
///     }
///
///     fn reset(&mut self) -> Result<(), Fault> {
///         self.0 = 0;
///         Ok(())
///     }
///
///     fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
///         for control in tick.messages::<LevelControl>()? {
///             if control == LevelControl::Pause {
///                 self.0 += 1;
///                 tick.publish(&Pauses { number: self.0 });
///             }
///         }
///         Ok(())
///     }
///
///     fn save(&self) -> Vec<u8> {
///         encode(&self.0)
///     }
///
///     fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
///         self.0 = decode_bytes(state)?;
///         Ok(())
///     }
/// }
///
/// let setup = Setup {
///     name: "counter".into(),
///     seed: 1,
///     tick_ns: 8_000_000,
///     steps: 1,
///     level: 1,
///     config: serde_json::Value::Null,
///     files: Vec::new(),
/// };
/// let own = microsim_sdk::KindInfo {
///     name: Pauses::KIND.into(),
///     version: Pauses::VERSION,
///     overflow: Pauses::OVERFLOW,
/// };
/// let host = TestHost::<Counter>::new(&[Pauses::KIND], &["level.control"], &[own], setup)?;
/// // A fresh instance in every tick: what `save` leaves out would be lost.
/// let mut host = host.moving();
/// for number in 1..=2 {
///     host.send(&LevelControl::Pause);
///     assert_eq!(host.tick()?.last(), Some(Pauses { number }));
/// }
/// # Ok::<(), Fault>(())
/// ```
///
/// A plugin reads no clock and no random source but a [`crate::RandomStream`]: the same messages in give the same
/// messages out, to the bit. Input sources are the exception: what they publish is recorded.
pub trait Plugin: Send + Sized + 'static {
    /// Constructs cheaply: no files, no threads, no large memory.
    fn new() -> Self;

    /// Reads its set-up and allocates.
    fn initialise(&mut self, setup: &Setup, services: Services) -> Result<(), Fault>;

    /// Goes back to the state right after `initialise`.
    fn reset(&mut self) -> Result<(), Fault>;

    /// One tick: receives, computes, publishes.
    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault>;

    /// All that evolves, as bytes; equal states give equal bytes. The state hash, replay and restoring rest on it.
    /// Observers (renderer, recorder) have no state that a run may depend on and return none.
    fn save(&self) -> Vec<u8>;

    /// What stands for all that evolves in the state hash, for a state that grows without end: bytes whose length does not, which differ
    /// whenever those of [`Plugin::save`] do. `None`: what is saved is hashed.
    fn hashed(&self) -> Option<Vec<u8>> {
        None
    }

    /// The opposite of [`Plugin::save`], in this or another process, after `initialise` with an equal set-up.
    fn restore(&mut self, state: &[u8]) -> Result<(), Fault>;

    /// The last call: closes files, ends threads.
    fn stop(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    /// An ability that came after this trait was fixed, by name. `None`: not here.
    fn extension(&mut self, _name: &str, _request: &[u8]) -> Result<Option<Vec<u8>>, Fault> {
        Ok(None)
    }
}
