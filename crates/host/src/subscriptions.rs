//! The messages that are addressed to the host itself.

use crate::engine::{Engine, HostState, TickOutput};
use crate::fault::Failure;
use microsim_bus::{Frames, kind_id};
use microsim_message::{InputEnd, Log, LogLevel, Message, Progress, TrainingResult, decode};

/// What the host receives of a tick's messages.
#[derive(Default)]
pub(crate) struct HostSubscriptions {
    /// The result, once the module has published it.
    pub result: Option<TrainingResult>,
}

impl HostSubscriptions {
    /// Handles the messages of a tick: ends of sources, the result, log and progress.
    pub fn handle(
        &mut self,
        engine: &Engine,
        output: &TickOutput,
        host: &mut HostState,
        progress: &mut dyn FnMut(&Progress),
    ) -> Result<(), Failure> {
        for frame in Frames::new(&output.log).filter_map(Result::ok) {
            let from = || engine.sender_name(frame.header.sender).to_owned();
            if frame.header.kind == kind_id(InputEnd::KIND) {
                if engine.is_source(frame.header.sender) {
                    host.ended_sources.insert(frame.header.sender);
                }
            } else if let Some(result) = decode::<TrainingResult>(&frame) {
                let tick = engine.tick_index() - 1;
                let result =
                    result.map_err(|e| Failure::found(&from(), "process", tick, e.to_string()))?;
                self.result = Some(result);
            } else if let Some(Ok(log)) = decode::<Log>(&frame) {
                print(&from(), &log);
            } else if let Some(Ok(reported)) = decode::<Progress>(&frame) {
                progress(&reported);
            }
        }
        for (subscriber, kind, n) in &output.dropped {
            tracing::warn!(
                "the queue of \"{subscriber}\" was full: {n} older \"{kind}\" were dropped"
            );
        }
        Ok(())
    }
}

/// Prints the log of a tick that ended in a failure.
pub(crate) fn print_log(engine: &Engine, log: &[u8]) {
    for frame in Frames::new(log).filter_map(Result::ok) {
        if let Some(Ok(log)) = decode::<Log>(&frame) {
            print(engine.sender_name(frame.header.sender), &log);
        }
    }
}

fn print(plugin: &str, log: &Log) {
    let text = &log.text;
    match log.level {
        LogLevel::Error => tracing::error!("{plugin}: {text}"),
        LogLevel::Warn => tracing::warn!("{plugin}: {text}"),
        LogLevel::Info => tracing::info!("{plugin}: {text}"),
        LogLevel::Debug => tracing::debug!("{plugin}: {text}"),
    }
}
