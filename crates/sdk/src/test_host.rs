//! Runs one plugin in-process, without any file, through the same boundary as a loaded library. Every crossing goes
//! through a copy of the bytes, so that a plugin which holds a pointer, or knows the tick by anything but its
//! messages, is found out here.

use crate::boundary;
use crate::fault::Fault;
use crate::plugin::Plugin;
use abi_stable::std_types::{ROption, RResult, RSlice};
use microsim_abi::{Block as AbiBlock, Call, Fault as AbiFault, FaultKind, PluginBox};
use microsim_bus::{EndpointId, Frames, KindInfo, Limits, Router};
use microsim_message::{
    LevelControl, Message, Pose, Setup, ToolState, ToolStates, ToolStatus, TrainingResult,
    config_value, core_kinds, decode, encode, push,
};
use microsim_settings::{KnownMetric, Manifest, ModuleConfig, ToolModels, Unit};
use microsim_training::MOTION_METRICS;
use std::path::Path;

/// The test's own place on the bus.
const TESTER: &str = "tester";

/// What a plugin published in one tick.
#[derive(Clone, Debug, Default)]
pub struct Published {
    messages: Vec<u8>,
    blocks: Vec<Vec<u64>>,
}

impl Published {
    /// The messages of one kind, oldest first.
    pub fn all<M: Message>(&self) -> Vec<M> {
        Frames::new(&self.messages)
            .filter_map(Result::ok)
            .filter_map(|f| decode(&f))
            .map(|m| m.expect("the plugin's own message"))
            .collect()
    }

    /// The newest message of one kind.
    pub fn last<M: Message>(&self) -> Option<M> {
        self.all().pop()
    }

    /// The blocks as words.
    pub fn blocks(&self) -> &[Vec<u64>] {
        &self.blocks
    }
}

/// An in-process host for one plugin, for tests: examples at [`Plugin`] and, for a module, in `examples/module.rs`.
pub struct TestHost<P: Plugin> {
    object: PluginBox,
    router: Router,
    plugin: EndpointId,
    tester: EndpointId,
    setup: Setup,
    tick: u64,
    moving: bool,
    plugin_type: std::marker::PhantomData<P>,
}

fn open<T>(result: RResult<T, AbiFault>) -> Result<T, Fault> {
    result.into_result().map_err(|fault| Fault {
        text: fault.text.into_string(),
        unavailable: fault.kind == FaultKind::Unavailable,
    })
}

/// Adds the reasons and metrics of the manifest that the configuration leaves out, as the host does.
fn declare(manifest: &Manifest, config: &mut serde_json::Value) {
    let declared = [
        ("reasons", serde_json::json!(manifest.reason)),
        ("own_metrics", serde_json::json!(manifest.metric)),
    ];
    for (key, declared) in declared {
        let (Some(own), serde_json::Value::Array(declared)) =
            (config[key].as_array_mut(), declared)
        else {
            continue;
        };
        for item in declared {
            if !own.iter().any(|other| other["id"] == item["id"]) {
                own.push(item);
            }
        }
    }
}

impl<P: Plugin> TestHost<P> {
    /// Creates and initialises a module by its manifest (the text of `module.toml`), at a level with this configuration, in ticks
    /// of 8 ms. Reasons and metrics that the configuration leaves out are those of the manifest.
    pub fn of_module(
        manifest: &str,
        seed: u64,
        level: u32,
        mut config: serde_json::Value,
    ) -> Result<Self, Fault> {
        let manifest = microsim_settings::read_manifest(manifest, "module.toml")
            .map_err(|e| Fault::new(e.to_string()))?
            .settings;
        declare(&manifest, &mut config);
        let setup = Setup {
            name: manifest.name.clone(),
            seed,
            tick_ns: 8_000_000,
            steps: 1,
            level,
            config,
            files: Vec::new(),
        };
        Self::of_manifest(&manifest, setup)
    }

    /// The same from files, as the host reads them: the manifest `module.toml` and `levels/level<N>.toml` below the folder of the module,
    /// the shapes of the tools that the level names below `tools` (`config/tools` of an installation), vessels in the folder `vessels` beside it.
    /// Ticks are those of the level.
    pub fn of_level(module: &Path, tools: &Path, seed: u64, level: u32) -> Result<Self, Fault> {
        let fault = |e: microsim_settings::ConfigErrors| Fault::new(e.to_string());
        let manifest = microsim_settings::load_manifest(&module.join("module.toml"));
        let manifest = manifest.map_err(fault)?.settings;
        let known: Vec<KnownMetric<'_>> = MOTION_METRICS
            .iter()
            .filter_map(|metric| {
                Some(KnownMetric {
                    id: metric.id.as_ref(),
                    unit: Unit::of_symbol(&metric.unit)?,
                    direction: metric.direction,
                })
            })
            .collect();
        let file = module.join("levels").join(format!("level{level}.toml"));
        let vessels = tools.with_file_name("vessels");
        let loaded = microsim_settings::load_level_with(&file, &manifest, &known, &vessels);
        let settings = loaded.map_err(fault)?.settings;
        let mut models = ToolModels::new();
        for slot in &settings.tool {
            let shape = microsim_settings::load_tool(&tools.join(format!("{}.toml", slot.model)));
            models.insert(slot.model.clone(), shape.map_err(fault)?.settings);
        }
        let setup = Setup {
            name: manifest.name.clone(),
            seed,
            tick_ns: settings.clock.tick_us() * 1000,
            steps: settings.clock.steps,
            level,
            config: config_value(&ModuleConfig::new(&settings, &manifest, &models)),
            files: Vec::new(),
        };
        Self::of_manifest(&manifest, setup)
    }

    fn of_manifest(manifest: &Manifest, setup: Setup) -> Result<Self, Fault> {
        let publishes: Vec<&str> = manifest.publishes.iter().map(String::as_str).collect();
        let subscribes: Vec<&str> = manifest.subscribes.iter().map(String::as_str).collect();
        Self::new(&publishes, &subscribes, &[], setup)
    }

    /// Creates and initialises the plugin. `publishes` and `subscribes` are those of its manifest, `own_kinds` the
    /// message kinds that it brings.
    pub fn new(
        publishes: &[&str],
        subscribes: &[&str],
        own_kinds: &[KindInfo],
        setup: Setup,
    ) -> Result<Self, Fault> {
        let kinds = core_kinds().into_iter().chain(own_kinds.iter().cloned());
        let all: Vec<String> = kinds.clone().map(|k| k.name).collect();
        let names = |list: &[&str]| list.iter().map(|s| s.to_string()).collect::<Vec<_>>();
        let fault = |e: microsim_bus::RouterError| Fault::new(e.to_string());
        let mut router = Router::new(Limits::default(), kinds).map_err(fault)?;
        let tester = router.register(TESTER, &all, &all).map_err(fault)?;
        let mut publishes = names(publishes);
        publishes.extend(["host.log".into(), "host.progress".into()]);
        let plugin = router
            .register(&setup.name, &publishes, &names(subscribes))
            .map_err(fault)?;
        let mut host = Self {
            object: open(boundary::create::<P>())?,
            router,
            plugin,
            tester,
            setup,
            tick: 0,
            moving: false,
            plugin_type: std::marker::PhantomData,
        };
        host.initialise()?;
        Ok(host)
    }

    fn initialise(&mut self) -> Result<(), Fault> {
        let setup = encode(&self.setup);
        open(
            self.object
                .initialise(RSlice::from_slice(&setup), ROption::RNone),
        )
    }

    /// From now on every tick moves the plugin to a fresh instance by `save` and `restore`: whatever it does not save
    /// is lost, as it would be after a crash.
    pub fn moving(mut self) -> Self {
        self.moving = true;
        self
    }

    /// Publishes a message that the plugin receives in the next tick (if it subscribes to its kind).
    pub fn send<M: Message>(&mut self, message: &M) {
        let mut bytes = Vec::new();
        push(&mut bytes, message);
        let time = self.tick * self.setup.tick_ns;
        self.router
            .publish(self.tester, time, &bytes)
            .expect("a known kind and room in the queue");
    }

    /// Publishes where all tools are: closed and tracked, each with its slot.
    pub fn send_tools(&mut self, tools: &[(&str, Pose)]) {
        let closed: Vec<_> = tools
            .iter()
            .map(|(tool, pose)| (*tool, *pose, 0.0))
            .collect();
        self.send_open_tools(&closed);
    }

    /// The same with how far each is open, from 0 (closed) to 1.
    pub fn send_open_tools(&mut self, tools: &[(&str, Pose, f64)]) {
        let state = |(tool, pose, opening): &(&str, Pose, f64)| ToolState {
            tool: (*tool).into(),
            model: "-".into(),
            status: ToolStatus::Tracked,
            pose: *pose,
            opening: *opening,
        };
        self.send(&ToolStates {
            tools: tools.iter().map(state).collect(),
        });
    }

    /// Publishes a block.
    pub fn send_block(&mut self, words: &[u64]) {
        self.router
            .publish_block(self.tester, words[1], words)
            .expect("a good block");
    }

    /// One tick: what the plugin published, or its fault. A publication that the manifest does not declare is a fault.
    pub fn tick(&mut self) -> Result<Published, Fault> {
        if self.moving {
            let state = self.save()?;
            self.object = open(boundary::create::<P>())?;
            self.initialise()?;
            self.restore(&state)?;
        }
        let messages = self.router.take_messages(self.plugin);
        let blocks = self.router.blocks_for(self.plugin);
        let blocks: Vec<_> = blocks
            .iter()
            .map(|b| (b.view().kind(), b.words().to_vec()))
            .collect();
        let blocks: Vec<_> = blocks
            .iter()
            .map(|(kind, words)| AbiBlock {
                kind: *kind,
                words: RSlice::from_slice(words),
            })
            .collect();
        let time_ns = (self.tick + 1) * self.setup.tick_ns;
        let output = open(self.object.process(Call {
            tick: self.tick,
            time_ns,
            tick_ns: self.setup.tick_ns,
            steps: self.setup.steps,
            messages: RSlice::from_slice(&messages),
            blocks: RSlice::from_slice(&blocks),
        }))?;
        self.tick += 1;
        let mut published = Published::default();
        let violation = |v: microsim_bus::Violation| Fault::new(v.to_string());
        self.router
            .publish(self.plugin, time_ns, &output.messages)
            .map_err(violation)?;
        for block in &output.blocks {
            self.router
                .publish_block(self.plugin, block.kind, &block.words)
                .map_err(violation)?;
            published.blocks.push(block.words.to_vec());
        }
        self.router.take_log();
        self.router.take_messages(self.tester);
        published.messages = output.messages.to_vec();
        Ok(published)
    }

    /// The input ends: the verdict of a training module.
    pub fn end(&mut self) -> TrainingResult {
        self.send(&LevelControl::InputEnded);
        let result = self.tick().expect("a good tick").last();
        result.expect("a verdict when the input has ended")
    }

    /// The plugin's state.
    pub fn save(&mut self) -> Result<Vec<u8>, Fault> {
        Ok(open(self.object.save())?.to_vec())
    }

    /// Puts the plugin into a saved state.
    pub fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        let copy = state.to_vec();
        open(self.object.restore(RSlice::from_slice(&copy)))
    }

    /// What it answers where it is asked for an ability by name; `None`: it does not have it.
    pub fn extension(&mut self, name: &str, request: &[u8]) -> Result<Option<Vec<u8>>, Fault> {
        let copy = request.to_vec();
        let answer = self
            .object
            .extension(name.into(), RSlice::from_slice(&copy));
        Ok(open(answer)?.into_option().map(|answer| answer.to_vec()))
    }

    /// Back to the state after `initialise`.
    pub fn reset(&mut self) -> Result<(), Fault> {
        self.tick = 0;
        open(self.object.reset())
    }

    /// The last call.
    pub fn stop(&mut self) -> Result<(), Fault> {
        open(self.object.stop())
    }
}
