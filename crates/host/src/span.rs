//! Spans of calls into plugins and of the stages of a tick: what `RUST_LOG` and `--trace` show.
//!
//! A plugin is a dynamic library with a subscriber registry of its own, so that spans inside of it do not arrive here: the host times
//! its calls from outside.

use crate::plan::PluginKind;
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

/// The span of a tick, which holds those of its stages.
pub(crate) fn of_tick(tick: u64) -> Span {
    debug_span!("tick", tick)
}
