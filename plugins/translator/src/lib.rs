//! The translator (dissertation, 5.2.1): device samples in, tools in the field out. Thin over `tracking::Translator`.
//!
//! The instrument and the tool know nothing of each other: which device drives which tool slot stands in
//! `config/translator.toml`, which model a slot has in the level.

#![forbid(unsafe_code)]

use microsim_sdk::message::{
    ImplausibleSample, InputSample, Pose, ToolState, ToolStates, ToolStatus, decode_bytes, encode,
};
use microsim_sdk::{Fault, LogLevel, Plugin, Services, Setup, Tick, export_plugin};
use microsim_settings::{DeviceMap, ToolSlot, TranslatorConfig};
use microsim_tracking::{
    Clutch, Excess, Mapping, MarkedInstrument, MotionState, Opening, Refusal, SampleFault,
    TrackedTool, Translator, TranslatorState,
};
use std::collections::BTreeSet;

/// The translator of a run.
#[derive(Debug, Default)]
pub struct TranslatorPlugin {
    tools: Vec<ToolSlot>,
    translator: Option<Translator>,
    /// Devices that drive no tool and were complained about.
    idle_devices: BTreeSet<String>,
    devices: BTreeSet<String>,
    instruments: Vec<MarkedInstrument>,
}

fn mapping(config: &TranslatorConfig, device: &DeviceMap) -> Mapping {
    let mapping = Mapping {
        tool: device.tool.clone(),
        device: device.name.clone(),
        device_origin: device.origin,
        field_offset: device.field_offset,
        field_from_device: device.rotation,
        scale: device.scale,
        body_from_tool: device.tool_rotation,
        tip: config.tip(&device.name).map_or([0.0; 3], |tip| tip.tip),
        opening: device
            .opening
            .fixed()
            .map_or(Opening::DEVICE, Opening::Constant),
        mirrored: config.mirrored,
    };
    match config.workspace(&device.name) {
        None => mapping,
        Some(space) => mapping.registered(space.rotation, space.translation, space.scale),
    }
}

fn implausible(refusal: &Refusal, excess: Excess) -> ImplausibleSample {
    ImplausibleSample {
        tool: refusal.tool.clone(),
        device: refusal.device.clone(),
        device_time: refusal.time_s,
        limit: excess.limit,
        value: excess.value,
        bound: excess.bound,
    }
}

impl TranslatorPlugin {
    fn translator(&mut self) -> Result<&mut Translator, Fault> {
        self.translator
            .as_mut()
            .ok_or_else(|| Fault::new("not initialised"))
    }

    fn handle(&mut self, message: InputSample, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let now = tick.time();
        let is_clutch = |translator: &Translator| translator.is_clutch(&message.device);
        let is_clutch = self.translator.as_ref().is_some_and(is_clutch);
        if !is_clutch && !self.devices.contains(&message.device) {
            if self.idle_devices.insert(message.device.clone()) {
                let device = &message.device;
                tick.log(LogLevel::Warn, format!(
                    "device \"{device}\" drives no tool of this level; name one in config/translator.toml"
                ));
            }
            return Ok(());
        }
        let translator = self.translator()?;
        let translated = match translator.feed(&message, now) {
            Ok(translated) => translated,
            Err(refusal) => {
                // A flood of bad samples must not become a flood of log lines: the first of each tool, then every
                // thousandth.
                if refusal.count % 1000 == 1 {
                    let text = format!("{refusal} (refused so far: {})", refusal.count);
                    tick.log(LogLevel::Warn, text);
                }
                if let SampleFault::Implausible(excess) = refusal.fault {
                    tick.publish(&implausible(&refusal, excess));
                }
                translator.lost(&message)
            }
        };
        if let Some(sample) = translated {
            tick.publish(&sample);
        }
        Ok(())
    }

    fn states(&self, now: f64) -> Result<ToolStates, Fault> {
        let translator = self.translator.as_ref();
        let translator = translator.ok_or_else(|| Fault::new("not initialised"))?;
        let state = |slot: &ToolSlot| {
            let tool = translator.tools().iter().find(|t| t.name() == slot.name);
            let last = tool.and_then(TrackedTool::pose);
            ToolState {
                tool: slot.name.clone(),
                model: slot.model.clone(),
                status: tool.map_or(ToolStatus::NeverSeen, |t| translator.status(t, now).0),
                pose: last.map_or_else(Pose::default, |last| last.pose),
                opening: last.map_or(1.0, |last| last.opening),
            }
        };
        let tools = self.tools.iter().map(state);
        Ok(ToolStates {
            tools: tools.collect(),
        })
    }
}

impl Plugin for TranslatorPlugin {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        let config: TranslatorConfig = setup.configuration()?;
        let mappings = config.devices.iter().map(|device| mapping(&config, device));
        let limits = config.hand.limits();
        let translator = Translator::new(mappings.collect(), config.stale_after, limits);
        let filters = config.filters.iter();
        let filters = filters.map(|f| (f.device.clone(), f.parameters.one_euro()));
        let clutches = config.clutches.iter().map(|clutch| Clutch {
            device: clutch.device.clone(),
            tools: clutch.tool.clone(),
        });
        // A tool without a device has no clutch.
        let driven = |tool: &String| config.devices.iter().any(|device| device.tool == *tool);
        let clutches = clutches.map(|clutch| Clutch {
            tools: clutch.tools.into_iter().filter(driven).collect(),
            ..clutch
        });
        let (filters, clutches) = (filters.collect(), clutches.collect());
        let translator = translator.and_then(|made| made.with_motion(filters, clutches));
        self.translator = Some(translator.map_err(|error| Fault::new(error.to_string()))?);
        let instruments = config.markers.iter().map(|tool| {
            let made = tool.instrument();
            made.map_err(|e| Fault::new(format!("markers of \"{}\": {e}", tool.device)))
        });
        self.instruments = instruments.collect::<Result<_, Fault>>()?;
        self.devices = config.devices.iter().map(|d| d.name.clone()).collect();
        self.tools = config.tools;
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        self.idle_devices.clear();
        self.translator()?.reset();
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        let mut complete = Vec::new();
        for message in tick.messages::<InputSample>()? {
            let mut instruments = self.instruments.iter_mut();
            if !instruments.any(|instrument| instrument.add(&message, &mut complete)) {
                self.handle(message, tick)?;
            }
        }
        let rest = self
            .instruments
            .iter_mut()
            .filter_map(MarkedInstrument::finish);
        complete.extend(rest);
        for (sample, tracking) in complete {
            tick.publish(&tracking);
            self.handle(sample, tick)?;
        }
        let states = self.states(tick.time())?;
        tick.publish(&states);
        Ok(())
    }

    /// Without filters and clutches the state is that of a translator that knows of none.
    fn save(&self) -> Vec<u8> {
        let translator = self.translator.as_ref();
        let state = translator.map(Translator::state);
        match translator.and_then(Translator::motion_state) {
            None => encode(&(state, &self.idle_devices)),
            Some(motion) => encode(&(state, &self.idle_devices, motion)),
        }
    }

    fn restore(&mut self, saved: &[u8]) -> Result<(), Fault> {
        let has_motion = self.translator()?.motion_state().is_some();
        let (state, idle, motion): (Option<TranslatorState>, _, Option<MotionState>) =
            match has_motion {
                false => {
                    let (state, idle) = decode_bytes(saved)?;
                    (state, idle, None)
                }
                true => {
                    let (state, idle, motion) = decode_bytes(saved)?;
                    (state, idle, Some(motion))
                }
            };
        self.idle_devices = idle;
        let translator = self.translator()?;
        if let Some(state) = state {
            let restored = translator.restore(state);
            restored.map_err(|error| Fault::new(error.to_string()))?;
        }
        if let Some(motion) = motion
            && !translator.restore_motion(motion)
        {
            return Err(Fault::new("the saved state has other filters or clutches"));
        }
        Ok(())
    }
}

export_plugin!(TranslatorPlugin, "../plugin.toml");
