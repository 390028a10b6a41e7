//! The recorder of a run: a plugin that observes, called with one record at a time.

use crate::error::RunError;
use crate::fault::Failure;
use crate::loader::{Object, load};
use crate::plan::{PlannedPlugin, PluginKind};
use crate::span;
use abi_stable::std_types::{ROption, RResult, RSlice};
use microsim_abi::{Call, Fault, PluginBox};
use microsim_message::{SessionRecord, encode, push};
use microsim_session::{History, KIND_END, StationKey};

/// The recorder, called once per tick.
pub(crate) struct Recorder {
    name: String,
    object: Object,
    tick_ns: u64,
    /// All that has been written.
    history: History,
    /// What it is signed with.
    key: Option<StationKey>,
}

impl Recorder {
    /// Loads and initialises it: the session file is there from then on.
    pub fn start(planned: &PlannedPlugin, key: Option<StationKey>) -> Result<Self, RunError> {
        let mut recorder = Self {
            name: planned.name.clone(),
            object: load(planned)?,
            tick_ns: planned.setup.tick_ns,
            history: History::new(),
            key,
        };
        let setup = encode(&planned.setup);
        recorder.call("initialise", 0, |object| {
            object.initialise(RSlice::from_slice(&setup), ROption::RNone)
        })?;
        Ok(recorder)
    }

    /// Name of the plugin.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Appends a record to the session.
    pub fn write(&mut self, record: &SessionRecord) -> Result<(), Failure> {
        let mut messages = Vec::with_capacity(record.bytes.len() + 64);
        push(&mut messages, record);
        let call = Call {
            tick: record.tick,
            time_ns: (record.tick + 1) * self.tick_ns,
            tick_ns: self.tick_ns,
            steps: 0,
            messages: RSlice::from_slice(&messages),
            blocks: RSlice::from_slice(&[]),
        };
        self.call("process", record.tick, |object| object.process(call))?;
        self.history.add(record.kind, record.tick, &record.bytes);
        Ok(())
    }

    /// Signs all that has been written, in a record of this kind: one that closes the file is written without a key as well, and is empty
    /// then.
    pub fn sign(&mut self, kind: u8, tick: u64) -> Result<(), Failure> {
        let _span = tracing::debug_span!("sign").entered();
        let seal = self
            .key
            .as_ref()
            .map(|key| key.sign(&self.history, kind, tick));
        if seal.is_none() && kind != KIND_END {
            return Ok(());
        }
        let bytes = seal.map(Vec::from).unwrap_or_default();
        self.write(&SessionRecord { kind, tick, bytes })
    }

    /// Closes the session.
    pub fn stop(&mut self, tick: u64) -> Result<(), Failure> {
        self.call("stop", tick, |object| object.stop())
    }

    fn call<T>(
        &mut self,
        name: &str,
        tick: u64,
        call: impl FnOnce(&mut PluginBox) -> RResult<T, Fault>,
    ) -> Result<T, Failure> {
        let _span = span::of_call(name, PluginKind::Recorder, &self.name).entered();
        let result = call(&mut self.object).into_result();
        result.map_err(|fault| Failure::from_abi(&self.name, name, tick, fault))
    }
}
