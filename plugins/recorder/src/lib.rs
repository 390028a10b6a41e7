//! The recorder: writes what the host hands it into a session file, record by record. The file format is the crate
//! `session`'s; what stands in a record is the host's.
//!
//! Each record reaches the operating system before the call returns, so a killed process loses at most the record that
//! was being written. The file must not exist before: nothing is ever overwritten.

#![forbid(unsafe_code)]

use microsim_sdk::message::SessionRecord;
use microsim_sdk::{Fault, Plugin, Services, Setup, Tick, export_plugin};
use microsim_session::Writer;
use microsim_settings::{RecorderConfig, unwritable};
use std::fs::File;
use std::path::PathBuf;

/// The recorder.
#[derive(Debug, Default)]
pub struct Recorder {
    path: PathBuf,
    writer: Option<Writer<File>>,
}

impl Recorder {
    fn fault(&self, error: std::io::Error) -> Fault {
        let path = self.path.display();
        Fault::new(format!(
            "cannot write {path}: {error}; what was written before is safe"
        ))
    }
}

impl Plugin for Recorder {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        let config: RecorderConfig = setup.configuration()?;
        self.path = config.path;
        let file = File::create_new(&self.path).and_then(Writer::create);
        self.writer =
            Some(file.map_err(|error| {
                Fault::new(format!("session {}", unwritable(&self.path, error)))
            })?);
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        for record in tick.messages::<SessionRecord>()? {
            let writer = self
                .writer
                .as_mut()
                .ok_or_else(|| Fault::new("not initialised"))?;
            let written = writer.append(record.kind, record.tick, &record.bytes);
            written.map_err(|error| self.fault(error))?;
        }
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        Vec::new()
    }

    fn restore(&mut self, _: &[u8]) -> Result<(), Fault> {
        Ok(())
    }

    fn stop(&mut self) -> Result<(), Fault> {
        let Some(writer) = self.writer.take() else {
            return Ok(());
        };
        let synced = writer.into_inner().sync_data();
        synced.map_err(|error| self.fault(error))
    }
}

export_plugin!(Recorder, "../plugin.toml");
