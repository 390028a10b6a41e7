//! The log, and the trace of where time goes.
//!
//! Both are made of the spans and events of `tracing`. The log goes to standard error; `RUST_LOG` chooses how much (warnings if
//! unset), and with `RUST_LOG=debug` every span prints how long it took. A trace goes to a file that Perfetto and `chrome://tracing` open.

use crate::output::Problem;
use microsim_settings::unwritable;
use std::fs::File;
use std::io::{BufWriter, IsTerminal};
use std::path::Path;
use tracing_chrome::{ChromeLayerBuilder, FlushGuard};
use tracing_subscriber::filter::{EnvFilter, LevelFilter, Targets};
use tracing_subscriber::fmt::format::FmtSpan;
use tracing_subscriber::layer::{Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

/// The crates whose spans are stages of a run or scene; those of libraries would only hide them.
const TRACED: [&str; 3] = ["microsim", "microsim_host", "microsim_scene"];

/// Starts the log, and the trace if a file is named. The trace is complete once the guard is dropped.
pub fn start(trace: Option<&Path>) -> Result<Option<FlushGuard>, Problem> {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn"));
    let log = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false)
        .without_time()
        // Where nobody reads standard error any more, that is no reason to end.
        .log_internal_errors(false)
        .with_span_events(FmtSpan::CLOSE)
        .with_filter(filter);
    let registry = tracing_subscriber::registry().with(log);
    let Some(path) = trace else {
        registry.init();
        return Ok(None);
    };
    let file = File::create_new(path).map_err(|e| format!("trace {}", unwritable(path, e)))?;
    let (layer, guard) = ChromeLayerBuilder::new()
        .writer(BufWriter::new(file))
        .include_args(true)
        .build();
    let traced = TRACED.map(|name| (name, LevelFilter::DEBUG));
    registry
        .with(layer.with_filter(traced.into_iter().collect::<Targets>()))
        .init();
    Ok(Some(guard))
}
