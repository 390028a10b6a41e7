//! Spans of calls into plugins and of the stages of a tick: what `RUST_LOG` and `--trace` show.
//!
//! A plugin is a dynamic library with a subscriber registry of its own, so that spans inside of it do not arrive here: the host times
//! its calls from outside.

use crate::plan::PluginKind;
use rustix::time::{ClockId, clock_gettime};
use tracing::field::Empty;
use tracing::span::EnteredSpan;
use tracing::{Span, debug_span};

/// The span of a call of the life cycle. That of `process` has the name of its stage in the tick.
pub(crate) fn of_call(call: &str, kind: PluginKind, plugin: &str) -> Span {
    match (call, kind) {
        ("process", PluginKind::Source) => debug_span!("input", plugin),
        ("process", PluginKind::Translator) => debug_span!("translate", plugin),
        ("process", PluginKind::Physics) => debug_span!("physics", plugin),
        ("process", PluginKind::Module) => debug_span!("module", plugin),
        ("process", PluginKind::Objects) => debug_span!("objects", plugin),
        ("process", PluginKind::Renderer) => debug_span!("draw", plugin),
        ("process", PluginKind::Recorder) => debug_span!("record", plugin),
        ("initialise", _) => debug_span!("initialise", plugin),
        ("reset", _) => debug_span!("reset", plugin),
        ("save", _) => debug_span!("save", plugin),
        ("restore", _) => debug_span!("restore", plugin),
        ("extension", _) => debug_span!("extension", plugin),
        _ => debug_span!("stop", plugin),
    }
}

/// The span of a tick, which holds those of its stages. When it ends it is given the CPU time of the thread that computed the tick:
/// where other programs take the processor, the time from begin to end is no measure of the tick.
pub(crate) struct TickSpan {
    span: EnteredSpan,
    begin: f64,
}

/// Begins the span of a tick.
pub(crate) fn of_tick(tick: u64) -> TickSpan {
    let span = debug_span!("tick", tick, cpu_us = Empty).entered();
    let begin = match span.is_disabled() {
        true => 0.0,
        false => cpu_time(),
    };
    TickSpan { span, begin }
}

impl Drop for TickSpan {
    fn drop(&mut self) {
        if !self.span.is_disabled() {
            self.span.record("cpu_us", cpu_time() - self.begin);
        }
    }
}

/// CPU time of this thread \[µs\].
fn cpu_time() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    1e6 * time.tv_sec as f64 + 1e-3 * time.tv_nsec as f64
}
