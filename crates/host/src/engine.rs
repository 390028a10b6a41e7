//! The loop: per tick input → translator → physics (tools in sub-steps) → module → objects, over the bus, with a
//! running hash (Listing 5.1 of the dissertation).
//!
//! Here: order, life cycle, hash, saving. Not here: the wall clock, files, observers (module `run`), libraries
//! (module `loader`). Everything runs on the thread that calls [`Engine::tick`].

use crate::fault::Failure;
use crate::loader::Object;
use crate::parallel::Parallel;
use crate::plan::{PluginKind, RunPlan};
use crate::span;
use abi_stable::std_types::{ROption, RResult, RSlice};
use microsim_abi::{Block as AbiBlock, Call, Fault, Output, PluginBox, STATE_HASHED};
use microsim_bus::{Block, EndpointId, Frames, HOST, Limits, Router, kind_id};
use microsim_message::{
    DesktopInput, InputSample, LevelControl, Message, MicroscopeView, TISSUE_FIELDS, core_kinds,
    decode, decode_bytes, encode,
};
use microsim_session::{Chain, digest};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// A digest of 32 bytes.
pub type Hash = [u8; 32];

/// Kinds that every plugin may publish without declaring them.
const SERVICE_KINDS: [&str; 2] = ["host.log", "host.progress"];

/// What the host itself publishes: the operator's control of the level, and what is asked for in front of a window. Nothing that is computed.
const OF_HOST: [&str; 3] = [LevelControl::KIND, DesktopInput::KIND, MicroscopeView::KIND];

/// The ability to give a digest of a plugin's values.
const STATE_DIGEST: &str = "state.digest";

/// What comes from outside in one tick.
#[derive(Clone, Copy, Debug)]
pub enum Feed<'a> {
    /// Sources are asked; `control` are frames of the host itself.
    Live {
        /// Frames that the host publishes at the start of the tick.
        control: &'a [u8],
    },
    /// Sources are silent; the stamped frames of a recorded tick that came from outside are fed.
    Recorded {
        /// The log of the recorded tick.
        log: &'a [u8],
    },
}

/// What one tick gave.
#[derive(Clone, Debug)]
pub struct TickOutput {
    /// All messages, stamped, in the order of their publication.
    pub log: Vec<u8>,
    /// The running hash over all messages and blocks so far.
    pub chain: Hash,
    /// Messages that full queues lost: (subscriber, kind, number).
    pub dropped: Vec<(String, String, u64)>,
}

/// Digest of one plugin's saved state.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StateDigest {
    /// Name of the plugin.
    pub plugin: String,
    /// Digest of the bytes that it saved, or of those that it gives in their place for the hash.
    #[serde(with = "serde_bytes")]
    pub digest: Vec<u8>,
}

/// Everything that evolves in a run, between two ticks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Digest of the plan it belongs to.
    #[serde(with = "serde_bytes")]
    pub plan: Vec<u8>,
    /// Ticks done.
    pub tick: u64,
    /// The running hash.
    #[serde(with = "serde_bytes")]
    pub chain: Vec<u8>,
    /// Queues and blocks of the bus.
    #[serde(with = "serde_bytes")]
    pub bus: Vec<u8>,
    /// Saved states in the order of the plan.
    pub states: Vec<serde_bytes::ByteBuf>,
    /// Digests of the states, as they enter the state hash.
    pub digests: Vec<StateDigest>,
    /// The running hash behind these digests: the state hash with which the session that stopped here ended.
    #[serde(with = "serde_bytes")]
    pub state_hash: Vec<u8>,
    /// What the host itself remembers.
    pub host: HostState,
}

/// What the host itself remembers between two ticks.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HostState {
    /// Sources that have nothing more to give.
    pub ended_sources: BTreeSet<EndpointId>,
    /// Frames that the host publishes in the next tick.
    #[serde(with = "serde_bytes")]
    pub controls: Vec<u8>,
    /// Since when the module has to end \[ns\].
    pub ending_since: Option<u64>,
}

/// What of digests enters the running hash.
fn parts(digests: &[StateDigest]) -> impl Iterator<Item = &[u8]> {
    digests.iter().map(|d| d.digest.as_slice())
}

struct Running {
    name: String,
    kind: PluginKind,
    endpoint: EndpointId,
    /// `None`: fed from a recording instead, or it has failed and is not called any more.
    object: Option<Object>,
}

/// One run.
pub struct Engine {
    plugins: Vec<Running>,
    router: Router,
    tick: u64,
    tick_ns: u64,
    steps: u32,
    chain: Chain,
    plan: Hash,
    parallel: Option<Parallel>,
    /// What failed between two ticks, where nobody could be informed of it.
    failure: Option<Failure>,
}

/// Digest of all in a plan that decides what is computed: not where libraries lie, nor how they were built, nor what
/// observers are given.
pub fn plan_digest(plan: &RunPlan) -> Hash {
    let mut parts = vec![
        plan.module.clone().into_bytes(),
        encode(&(
            plan.level,
            plan.seed,
            plan.tick_ns,
            plan.steps,
            plan.hash_every,
            &plan.without,
            &plan.input_digest,
            plan.queue_messages,
            plan.queue_bytes,
        )),
    ];
    for plugin in plan.plugins.iter().filter(|p| !p.kind.is_observer()) {
        parts.push(encode(&(
            &plugin.name,
            plugin.kind,
            &plugin.publishes,
            &plugin.subscribes,
        )));
        if plugin.kind != PluginKind::Source {
            parts.push(encode(&plugin.setup));
        }
    }
    digest(parts.iter().map(Vec::as_slice))
}

impl Engine {
    /// Registers the plugins of `plan` on a bus, in its order. `load` gives the object of each; for a replay it gives
    /// `None` for sources. Observers are not asked for.
    pub fn new<E: From<Failure>, O: Into<Object>>(
        plan: &RunPlan,
        limits: Limits,
        parallel: Option<Parallel>,
        mut load: impl FnMut(&crate::plan::PlannedPlugin) -> Result<Option<O>, E>,
    ) -> Result<Self, E> {
        let own = plan
            .plugins
            .iter()
            .flat_map(|p| p.own_kinds.iter().map(|k| k.info()));
        let kinds = core_kinds().into_iter().chain(own);
        let bus = |name: &str, e: microsim_bus::RouterError| {
            E::from(Failure::found(name, "register", 0, e.to_string()))
        };
        let mut router = Router::new(limits, kinds).map_err(|e| bus("host", e))?;
        let mut plugins = Vec::new();
        for planned in plan.plugins.iter().filter(|p| !p.kind.is_observer()) {
            let mut publishes = planned.publishes.clone();
            publishes.extend(SERVICE_KINDS.map(String::from));
            let endpoint = router
                .register(&planned.name, &publishes, &planned.subscribes)
                .map_err(|e| bus(&planned.name, e))?;
            plugins.push(Running {
                name: planned.name.clone(),
                kind: planned.kind,
                endpoint,
                object: load(planned)?.map(Into::into),
            });
        }
        let digest = plan_digest(plan);
        let mut engine = Self {
            plugins,
            router,
            tick: 0,
            tick_ns: plan.tick_ns,
            steps: plan.steps,
            chain: Chain::from_value(digest),
            plan: digest,
            parallel,
            failure: None,
        };
        engine.initialise(plan)?;
        Ok(engine)
    }

    fn initialise(&mut self, plan: &RunPlan) -> Result<(), Failure> {
        let planned = plan.plugins.iter().filter(|p| !p.kind.is_observer());
        for (plugin, planned) in self.plugins.iter_mut().zip(planned) {
            // No callback crosses to a training module: it may run in a process of its own.
            let parallel = match (&self.parallel, planned.kind) {
                (Some(parallel), PluginKind::Physics) => ROption::RSome(parallel.service()),
                _ => ROption::RNone,
            };
            let setup = encode(&planned.setup);
            plugin.call("initialise", 0, |p| {
                p.initialise(RSlice::from_slice(&setup), parallel)
            })?;
        }
        Ok(())
    }

    /// Ticks done.
    pub fn tick_index(&self) -> u64 {
        self.tick
    }

    /// Simulated time \[ns\].
    pub fn time_ns(&self) -> u64 {
        self.tick * self.tick_ns
    }

    /// Name of a message kind.
    pub fn kind_name(&self, id: u64) -> Option<&str> {
        self.router.kind_name(id)
    }

    /// Name of a sender.
    pub fn sender_name(&self, id: EndpointId) -> &str {
        self.router.endpoint_name(id)
    }

    /// Whether this sender is a source.
    pub fn is_source(&self, sender: EndpointId) -> bool {
        let mut sources = self.plugins.iter().filter(|p| p.kind == PluginKind::Source);
        sources.any(|p| p.endpoint == sender)
    }

    /// All messages of a tick that ended in a failure, up to it.
    pub fn take_log(&mut self) -> Vec<u8> {
        self.router.take_log()
    }

    /// Whether messages of this sender come from outside: sources and the host itself.
    pub fn is_external(&self, sender: EndpointId) -> bool {
        sender == HOST || self.is_source(sender)
    }

    /// The latest blocks, for observers.
    pub fn blocks(&self) -> Vec<Block> {
        self.router.blocks()
    }

    /// What pictures of the computation show of bodies as they are now, by the ability `tissue.fields` of the physics. Nothing of it is published or recorded. A plugin that
    /// fails in it makes the next tick fail.
    pub fn fields(&mut self) -> Vec<Block> {
        let physics = self
            .plugins
            .iter()
            .filter(|p| p.kind == PluginKind::Physics);
        let names: Vec<String> = physics.map(|p| p.name.clone()).collect();
        let mut blocks = Vec::new();
        for name in names {
            let answer = self
                .extension(&name, TISSUE_FIELDS, &[])
                .and_then(|answer| {
                    let words: Vec<Vec<u64>> = match answer {
                        Some(answer) => decode_bytes(&answer).map_err(|e| e.to_string()),
                        None => Ok(Vec::new()),
                    }
                    .map_err(|why| Failure::found(&name, "extension", self.tick, why))?;
                    let found: Result<Vec<Block>, _> =
                        words.iter().map(|of| Block::new(of)).collect();
                    found.map_err(|e| Failure::found(&name, "extension", self.tick, e.to_string()))
                });
            match answer {
                Ok(found) => blocks.extend(found),
                Err(failure) => self.failure = Some(failure),
            }
        }
        blocks
    }

    /// One tick. After a failure the engine must not be ticked again.
    pub fn tick(&mut self, feed: Feed<'_>) -> Result<TickOutput, Failure> {
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        let tick = self.tick;
        let time_ns = (tick + 1) * self.tick_ns;
        match feed {
            Feed::Live { control } => {
                let sent = self.router.publish(HOST, time_ns, control);
                sent.map_err(|v| Failure::found("host", "publish", tick, v.to_string()))?;
            }
            Feed::Recorded { log } => self.feed(tick, log)?,
        }
        for index in 0..self.plugins.len() {
            let plugin = &mut self.plugins[index];
            let messages = self.router.take_messages(plugin.endpoint);
            let blocks = self.router.blocks_for(plugin.endpoint);
            let blocks: Vec<_> = blocks
                .iter()
                .map(|b| AbiBlock {
                    kind: b.view().kind(),
                    words: RSlice::from_slice(b.words()),
                })
                .collect();
            let call = Call {
                tick,
                time_ns,
                tick_ns: self.tick_ns,
                steps: self.steps,
                messages: RSlice::from_slice(&messages),
                blocks: RSlice::from_slice(&blocks),
            };
            let output = plugin.call("process", tick, |p| p.process(call))?;
            if let Some(output) = output {
                self.publish(index, tick, time_ns, &output)?;
            }
        }
        self.tick += 1;
        let log = self.router.take_log();
        let blocks = self.router.take_new_blocks();
        let words = blocks.iter().map(|b| bytemuck::cast_slice(b.words()));
        self.chain
            .add(tick, std::iter::once(log.as_slice()).chain(words));
        Ok(TickOutput {
            log,
            chain: self.chain.value(),
            dropped: self.router.take_dropped(),
        })
    }

    fn publish(
        &mut self,
        index: usize,
        tick: u64,
        time_ns: u64,
        output: &Output,
    ) -> Result<(), Failure> {
        let plugin = &self.plugins[index];
        let endpoint = plugin.endpoint;
        if plugin.kind == PluginKind::Source && !output.blocks.is_empty() {
            let text = "a source may publish messages only: a recording could not feed blocks";
            return Err(Failure::found(&plugin.name, "process", tick, text));
        }
        if plugin.kind == PluginKind::Source {
            // Whoever decodes them later is not to be blamed for what is no sample.
            let frames = Frames::new(&output.messages).filter_map(Result::ok);
            for sample in frames.filter_map(|frame| decode::<InputSample>(&frame)) {
                sample.map_err(|e| Failure::found(&plugin.name, "process", tick, e.to_string()))?;
            }
        }
        let mut result = self.router.publish(endpoint, time_ns, &output.messages);
        for block in &output.blocks {
            result = result.and_then(|()| {
                self.router
                    .publish_block(endpoint, block.kind, &block.words)
            });
        }
        result
            .map_err(|v| Failure::found(&self.plugins[index].name, "process", tick, v.to_string()))
    }

    fn feed(&mut self, tick: u64, log: &[u8]) -> Result<(), Failure> {
        let bad = |what: String| Failure::found("recording", "feed", tick, what);
        for frame in Frames::new(log) {
            let frame = frame.map_err(|e| bad(e.to_string()))?;
            if self.is_external(frame.header.sender) {
                let is_of_host = OF_HOST
                    .iter()
                    .any(|kind| kind_id(kind) == frame.header.kind);
                if frame.header.sender == HOST && !is_of_host {
                    return Err(bad(
                        "a message of the host that it never publishes".to_owned()
                    ));
                }
                let mut bytes = Vec::new();
                microsim_bus::frame::push_stamped(&mut bytes, &frame.header, frame.payload);
                self.router
                    .publish(frame.header.sender, frame.header.time_ns, &bytes)
                    .map_err(|v| bad(v.to_string()))?;
            }
        }
        Ok(())
    }

    /// Digests of all saved states. `recorded` stands in for sources that a replay does not run.
    pub fn state_digests(&mut self, recorded: &[StateDigest]) -> Result<Vec<StateDigest>, Failure> {
        let tick = self.tick;
        let digests = self.digests(recorded)?;
        self.chain.add(tick, parts(&digests));
        Ok(digests)
    }

    fn digests(&mut self, recorded: &[StateDigest]) -> Result<Vec<StateDigest>, Failure> {
        let tick = self.tick;
        let mut digests = Vec::new();
        for plugin in &mut self.plugins {
            let nothing = RSlice::from_slice(&[]);
            let hashed = plugin.call("extension", tick, |p| {
                p.extension(STATE_HASHED.into(), nothing)
            })?;
            let state = match hashed.and_then(|answer| answer.into_option()) {
                Some(hashed) => Some(hashed),
                None => plugin.call("save", tick, |p| p.save())?,
            };
            let digest = match state {
                Some(state) => digest([state.as_slice()]).to_vec(),
                None => recorded
                    .iter()
                    .find(|d| d.plugin == plugin.name)
                    .map(|d| d.digest.clone())
                    .unwrap_or_default(),
            };
            digests.push(StateDigest {
                plugin: plugin.name.clone(),
                digest,
            });
        }
        Ok(digests)
    }

    /// The running hash with these digests behind it.
    fn hash_with(&self, digests: &[StateDigest]) -> Hash {
        let mut chain = self.chain;
        chain.add(self.tick, parts(digests));
        chain.value()
    }

    /// Digests of the values of all plugins that have any: raw numbers in a fixed order, free of names and encodings, by the ability
    /// `state.digest`.
    pub fn value_digests(&mut self) -> Result<Vec<Vec<u8>>, Failure> {
        let tick = self.tick;
        let mut digests = Vec::new();
        for plugin in &mut self.plugins {
            let request = RSlice::from_slice(&[]);
            let answer = plugin.call("extension", tick, |p| {
                p.extension(STATE_DIGEST.into(), request)
            })?;
            digests.extend(answer.and_then(|a| a.into_option()).map(|a| a.to_vec()));
        }
        Ok(digests)
    }

    /// The running hash now.
    pub fn chain(&self) -> Hash {
        self.chain.value()
    }

    /// Everything that evolves, between two ticks.
    pub fn checkpoint(&mut self) -> Result<Checkpoint, Failure> {
        let tick = self.tick;
        let mut states = Vec::new();
        for plugin in &mut self.plugins {
            let state = plugin.call("save", tick, |p| p.save())?;
            states.push(state.map(|s| s.to_vec()).unwrap_or_default().into());
        }
        let digests = self.digests(&[])?;
        Ok(Checkpoint {
            plan: self.plan.to_vec(),
            tick,
            chain: self.chain.value().to_vec(),
            bus: self.router.save(),
            states,
            state_hash: self.hash_with(&digests).to_vec(),
            digests,
            host: HostState::default(),
        })
    }

    /// Goes on from a checkpoint as [`Engine::restore`] does, and refuses it unless the states that plugins have then are those whose hash
    /// was recorded. Of a source that a replay does not run, the digest in the checkpoint counts.
    pub fn resume(&mut self, checkpoint: &Checkpoint) -> Result<(), Failure> {
        self.restore(checkpoint)?;
        let digests = self.digests(&checkpoint.digests)?;
        if self.hash_with(&digests).as_slice() != checkpoint.state_hash {
            let text =
                "the restored state does not have the state hash that was recorded at this tick";
            return Err(Failure::found("host", "restore", checkpoint.tick, text));
        }
        Ok(())
    }

    /// Goes on from a checkpoint of the same plan, in this or another process.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), Failure> {
        let bad = |what: &str| Failure::found("host", "restore", checkpoint.tick, what);
        if checkpoint.plan != self.plan || checkpoint.states.len() != self.plugins.len() {
            return Err(bad(
                "the checkpoint belongs to another module, level, seed or set-up",
            ));
        }
        let chain: Hash = checkpoint
            .chain
            .as_slice()
            .try_into()
            .map_err(|_| bad("bad hash"))?;
        self.router
            .restore(&checkpoint.bus)
            .map_err(|e| bad(&e.to_string()))?;
        for (plugin, state) in self.plugins.iter_mut().zip(&checkpoint.states) {
            plugin.call("restore", checkpoint.tick, |p| {
                p.restore(RSlice::from_slice(state))
            })?;
        }
        self.tick = checkpoint.tick;
        self.chain = Chain::from_value(chain);
        Ok(())
    }

    /// Back to the start: every plugin as it was right after `initialise`, an empty bus, tick 0.
    pub fn reset(&mut self) -> Result<(), Failure> {
        let tick = self.tick;
        for plugin in &mut self.plugins {
            plugin.call("reset", tick, |p| p.reset())?;
        }
        self.router.clear();
        self.tick = 0;
        self.chain = Chain::from_value(self.plan);
        Ok(())
    }

    /// Asks a plugin for an ability by name, between two ticks. `None`: the plugin does not have it, or is not there.
    pub fn extension(
        &mut self,
        plugin: &str,
        name: &str,
        request: &[u8],
    ) -> Result<Option<Vec<u8>>, Failure> {
        let tick = self.tick;
        let Some(plugin) = self.plugins.iter_mut().find(|p| p.name == plugin) else {
            return Ok(None);
        };
        let request = RSlice::from_slice(request);
        let answer = plugin.call("extension", tick, |p| p.extension(name.into(), request))?;
        Ok(answer.and_then(|a| a.into_option()).map(|a| a.to_vec()))
    }

    /// Stops every plugin that has not failed, whatever the others answer; what fails now comes back.
    pub fn stop(&mut self) -> Vec<Failure> {
        let tick = self.tick;
        let stop = |p: &mut Running| p.call("stop", tick, |o| o.stop()).err();
        self.plugins.iter_mut().filter_map(stop).collect()
    }
}

impl Running {
    fn call<T>(
        &mut self,
        name: &str,
        tick: u64,
        call: impl FnOnce(&mut PluginBox) -> RResult<T, Fault>,
    ) -> Result<Option<T>, Failure> {
        let Some(object) = &mut self.object else {
            return Ok(None);
        };
        let _span = span::of_call(name, self.kind, &self.name).entered();
        call(object).into_result().map(Some).map_err(|fault| {
            let ended = self.object.take().is_some_and(|object| object.has_ended());
            Failure {
                ended,
                ..Failure::from_abi(&self.name, name, tick, fault)
            }
        })
    }
}
