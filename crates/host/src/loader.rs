//! Makes the object of a planned plugin, in this process or in one of its own, by its plan.

pub use crate::library::{LoadError, file_hash};

use crate::guest::Guest;
use crate::library;
use crate::plan::{Hosting, PlannedPlugin};
use microsim_abi::PluginBox;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The object of a plugin, wherever it runs.
pub struct Object {
    plugin: PluginBox,
    /// Set when the process of its own has ended; `None`: it is in this one.
    ended: Option<Arc<AtomicBool>>,
}

impl Object {
    /// Whether it had a process of its own, which has ended.
    pub fn has_ended(&self) -> bool {
        let ended = self.ended.as_ref();
        ended.is_some_and(|ended| ended.load(Ordering::Relaxed))
    }

    /// The plugin alone.
    pub fn into_plugin(self) -> PluginBox {
        self.plugin
    }
}

impl From<PluginBox> for Object {
    fn from(plugin: PluginBox) -> Self {
        Self {
            plugin,
            ended: None,
        }
    }
}

impl Deref for Object {
    type Target = PluginBox;

    fn deref(&self) -> &PluginBox {
        &self.plugin
    }
}

impl DerefMut for Object {
    fn deref_mut(&mut self) -> &mut PluginBox {
        &mut self.plugin
    }
}

/// Loads a plugin and makes its object.
pub fn load(plugin: &PlannedPlugin) -> Result<Object, LoadError> {
    let refuse = |reason: String| LoadError {
        plugin: plugin.name.clone(),
        path: plugin.library.clone(),
        reason,
    };
    let guest = |rules| Guest::start(&plugin.name, &plugin.library, &plugin.manifest, rules);
    match &plugin.hosting {
        Hosting::Guest(rules) => {
            let guest = guest(rules).map_err(refuse)?;
            let ended = Some(guest.ended());
            return Ok(Object {
                plugin: guest.into_plugin(),
                ended,
            });
        }
        // A file that is none of a library, or half of one, must not end this process.
        Hosting::TriedFirst(rules) => drop(guest(rules).map_err(refuse)?),
        Hosting::Inside => {}
    }
    let object = library::open(&plugin.library, &plugin.manifest).map_err(refuse)?;
    Ok(object.into())
}
