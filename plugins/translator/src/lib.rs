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
    Excess, Mapping, Opening, Refusal, SampleFault, TrackedTool, Translator, TranslatorState,
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
}

fn mapping(device: &DeviceMap) -> Mapping {
    Mapping {
        tool: device.tool.clone(),
        device: device.name.clone(),
        device_origin: device.origin,
        field_offset: device.field_offset,
        field_from_device: device.rotation,
        scale: device.scale,
        body_from_tool: device.tool_rotation,
        opening: device
            .opening
            .fixed()
            .map_or(Opening::DEVICE, Opening::Constant),
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
        if !self.devices.contains(&message.device) {
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
        let mappings = config.devices.iter().map(mapping).collect();
        let translator = Translator::new(mappings, config.stale_after, config.hand.limits());
        self.translator = Some(translator.map_err(|error| Fault::new(error.to_string()))?);
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
        for message in tick.messages::<InputSample>()? {
            self.handle(message, tick)?;
        }
        let states = self.states(tick.time())?;
        tick.publish(&states);
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        encode(&(
            self.translator.as_ref().map(Translator::state),
            &self.idle_devices,
        ))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        let (state, idle) = decode_bytes::<(Option<TranslatorState>, _)>(state)?;
        self.idle_devices = idle;
        if let Some(state) = state {
            let restored = self.translator()?.restore(state);
            restored.map_err(|error| Fault::new(error.to_string()))?;
        }
        Ok(())
    }
}

export_plugin!(TranslatorPlugin, "../plugin.toml");
