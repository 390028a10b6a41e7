//! A source alone: its samples, without a module, a translator or a recording. For commands that calibrate, show devices or record input.

use crate::engine::{Engine, Feed, HostState};
use crate::error::RunError;
use crate::fault::Failure;
use crate::input::source_setup;
use crate::installation::Installation;
use crate::installed::{RunSetup, planned};
use crate::loader::load;
use crate::plan::{PluginKind, RunPlan};
use crate::request::{AssembleError, Input, Request};
use crate::subscriptions::HostSubscriptions;
use microsim_bus::Frames;
use microsim_message::{InputSample, InputTiming, LocalText, decode};
use std::path::PathBuf;

/// Time between two looks at the source \[ns\].
const TICK_NS: u64 = 4_000_000;
/// Messages and bytes that wait at most; nobody subscribes, so nothing does.
const QUEUE: u32 = 1024;

/// A source that is listened to.
pub struct Listener {
    engine: Engine,
    host: HostState,
    subscriptions: HostSubscriptions,
}

/// What came in a tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Heard {
    /// In the order of their arrival.
    pub samples: Vec<InputSample>,
    /// Samples that the source had to drop.
    pub dropped: u64,
    /// Whether nothing more will come.
    pub ended: bool,
}

impl Listener {
    /// Begins to listen to an input.
    ///
    /// # Errors
    /// If there is no such input, or its plugin does not start.
    pub fn open(installation: &Installation, input: &Input) -> Result<Self, AssembleError> {
        let request = Request {
            module: String::new(),
            level: 1,
            variant: None,
            input: input.clone(),
            hand: None,
            seed: 1,
            without: Vec::new(),
            pictures: false,
            session: PathBuf::new(),
        };
        let source = source_setup(installation, &request)?;
        let manifest = installation.plugin(&source.plugin)?;
        if manifest.settings.kind != PluginKind::Source {
            return Err(AssembleError(format!(
                "plugin \"{}\" is of kind `{}`, an input has to be a `source`",
                source.plugin,
                manifest.settings.kind.name()
            )));
        }
        let run = RunSetup {
            seed: 1,
            tick_ns: TICK_NS,
            steps: 1,
            level: 1,
        };
        let digest = source.digest();
        let why = source.why;
        let plugin = planned(
            installation,
            manifest,
            why,
            run,
            source.config,
            source.files,
        )?;
        let plan = RunPlan {
            module: String::new(),
            module_title: LocalText::new(String::new(), String::new()),
            level: 1,
            variant: None,
            level_title: LocalText::new(String::new(), String::new()),
            level_summary: LocalText::new(String::new(), String::new()),
            seed: 1,
            tick_ns: TICK_NS,
            steps: 1,
            hash_every: u64::MAX,
            input: input.to_string(),
            synthetic: None,
            input_digest: digest,
            queue_messages: QUEUE,
            queue_bytes: QUEUE << 10,
            model_error: None,
            changed_files: Vec::new(),
            without: Vec::new(),
            plugins: vec![plugin],
            parts: Vec::new(),
        };
        let made = Engine::new(&plan, plan.limits(), None, |p| {
            load(p).map(Some).map_err(RunError::from)
        });
        Ok(Self {
            engine: made.map_err(|error: RunError| AssembleError(error.to_string()))?,
            host: HostState::default(),
            subscriptions: HostSubscriptions::default(),
        })
    }

    /// Simulated time between two ticks \[s\]: that of the clock for a live source.
    pub fn tick_s(&self) -> f64 {
        TICK_NS as f64 * 1e-9
    }

    /// What has come since the last tick.
    ///
    /// # Errors
    /// If the source fails.
    pub fn tick(&mut self) -> Result<Heard, Failure> {
        let output = self.engine.tick(Feed::Live { control: &[] })?;
        self.subscriptions
            .handle(&self.engine, &output, &mut self.host, &mut |_| {})?;
        let mut heard = Heard {
            ended: !self.host.ended_sources.is_empty(),
            ..Heard::default()
        };
        for frame in Frames::new(&output.log).filter_map(Result::ok) {
            if let Some(Ok(sample)) = decode::<InputSample>(&frame) {
                heard.samples.push(sample);
            } else if let Some(Ok(timing)) = decode::<InputTiming>(&frame) {
                heard.dropped += timing.dropped;
            }
        }
        Ok(heard)
    }

    /// Ends the source.
    pub fn stop(mut self) -> Vec<Failure> {
        self.engine.stop()
    }
}
