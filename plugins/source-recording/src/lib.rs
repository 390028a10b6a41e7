//! Recorded motion as an input source: a CSV file with its column map, or the samples of a recorded session. Thin over
//! `tracking::read_csv`.

#![forbid(unsafe_code)]

use microsim_sdk::message::decode_bytes;
use microsim_sdk::{Fault, Playback, Plugin, Services, Setup, Tick, export_plugin};
use microsim_settings::{RecordingConfig, RecordingMap, Unit};
use microsim_tracking::{Column, ColumnMap, DeviceColumns, OpeningColumn, read_csv};

/// Name of the file with the motion.
const FILE: &str = "recording";

/// Plays recorded motion.
#[derive(Debug, Default)]
pub struct RecordingSource {
    playback: Playback,
}

/// The column map as the reader wants it. Units were checked when the map was read.
fn column_map(map: &RecordingMap) -> Result<ColumnMap, Fault> {
    let factor = |unit: Unit, symbol: &str| {
        unit.to_si(1.0, symbol)
            .ok_or_else(|| Fault::new(format!("unknown unit \"{symbol}\"")))
    };
    let devices = map.device.iter().map(|device| {
        Ok(DeviceColumns {
            device: device.name.clone(),
            position: device.position.clone(),
            position_factor: factor(Unit::Length, &device.position_unit)?,
            orientation: device.quaternion.clone(),
            opening: device.opening.as_ref().map(|opening| OpeningColumn {
                name: opening.column.clone(),
                closed: opening.closed,
                open: opening.open,
            }),
            visible: device.visible.clone(),
        })
    });
    Ok(ColumnMap {
        delimiter: map.delimiter_byte(),
        time: Column {
            name: map.time.column.clone(),
            factor: factor(Unit::Time, &map.time.unit)?,
        },
        devices: devices.collect::<Result<_, Fault>>()?,
        gap_s: Some(map.gap),
    })
}

impl Plugin for RecordingSource {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        let config: RecordingConfig = setup.configuration()?;
        let file = setup.files.iter().find(|f| f.name == FILE);
        let bytes = &file
            .ok_or_else(|| Fault::new("no file \"recording\" in the set-up"))?
            .bytes;
        self.playback = match config {
            RecordingConfig::Csv { name, map } => {
                let recording = read_csv(bytes, &name, &column_map(&map)?);
                let recording = recording.map_err(|error| Fault::new(error.to_string()))?;
                Playback::by_device_time(&setup.name, recording.samples)
            }
            RecordingConfig::Samples => Playback::new(&setup.name, decode_bytes(bytes)?),
        };
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        self.playback.reset();
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        self.playback.play(tick);
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        self.playback.save()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        self.playback.restore(state)
    }
}

export_plugin!(RecordingSource, "../plugin.toml");
