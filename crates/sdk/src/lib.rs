//! All that the author of a plugin or training module uses.
//!
//! # Where to begin
//! A training module implements [`Exercise`]: which targets a level has, and when each is reached. [`Training`] makes a [`Plugin`] of it
//! (start, pause, limits, metrics, verdict, save and restore), [`export_plugin!`] a dynamic library that the host loads.
//!
//! 1. `cargo run --example module -p microsim-sdk` runs a whole module of one file in-process, with manifest and level as text.
//! 2. `cargo xtask new module NAME` makes the folder of a module that builds, runs, and passes and fails by script: `module.toml` (the
//!    manifest), `levels/`, `scripts/`, `src/lib.rs`.
//! 3. `crates/sdk/README.md` explains step by step what to put into it; `microsim schema manifest --markdown` and `microsim schema level
//!    --markdown` list all keys of its files, `microsim bus` all messages.
//! 4. [`TestHost`] runs it in tests, `microsim check modules/NAME` checks its files, `microsim run NAME --level 1 --input
//!    script:level1-pass.toml` runs it.
//!
//! A plugin that is no training module (an input source, an observer) implements [`Plugin`] itself.
//!
//! | what for | see |
//! |---|---|
//! | tasks of a level, called in every tick | [`Exercise`], [`Training`] |
//! | targets, metrics, reasons to fail, lines of the report | [`LevelRun`] |
//! | what a level's file gives | [`ModuleConfig`] (tools, objects, limits, the module's own keys), [`Setup`] (seed, tick, files) |
//! | messages in and out of a tick | [`Tick`] |
//! | the platform's messages, and kinds of one's own | module [`message`], [`message::Message`] |
//! | tissue: marks that move with it, grips, cuts, pieces, rings, sections, normals | module [`tissue`] |
//! | trays, directions, paths | [`Tray`], [`axis`], [`turned_to`], [`shortest_path`] |
//! | where the parts of a tool are, and what passes between its jaws | [`ToolShape`], [`Mouth`], module [`geometry`] |
//! | what the trainee sees | [`Microscope`] |
//! | random numbers that can be saved | [`RandomStream`] |
//! | an error, as one sentence for a person | [`Fault`] |
//! | samples of a file as an input source | [`Playback`] |
//! | parallel loops (physics only) | [`Parallel`] |
//! | arrays of numbers: meshes, pictures | [`BlockBuilder`], [`BlockView`] |
//! | a plugin in a test | [`TestHost`] |
//!
//! Staying at a place for a time, and other parts of scores, are in the crate `training` (`Dwell`). Quantities are in SI units, positions in
//! the frame of the microscope's field: origin at its centre, z towards the viewer.
//!
//! The raw boundary (crate `abi`) is not visible from here; every panic is caught before it reaches it.

#![allow(
    unsafe_code,
    reason = "the boundary to the host: a C function, an exported symbol, an object that is dropped behind a guard"
)]

mod boundary;
mod direction;
mod exercise;
mod fault;
mod level_rules;
mod level_run;
mod microscope;
mod panic;
mod parallel;
mod playback;
mod plugin;
mod random;
mod shortest_path;
mod test_host;
mod tick;
pub mod tissue;
mod tool_shape;
mod tray;

pub use direction::{axis, turned_to};
pub use exercise::{Exercise, Training};
pub use fault::Fault;
pub use level_run::LevelRun;
pub use microscope::Microscope;
pub use microsim_bus::{BlockBuilder, BlockView, KindInfo, Overflow, kind_id as name_id};
#[doc(inline)]
pub use microsim_geometry as geometry;
#[doc(inline)]
pub use microsim_message as message;
pub use microsim_message::{LogLevel, Setup};
pub use microsim_settings::{ModuleConfig, Object, Shape, View};
pub use parallel::Parallel;
pub use playback::Playback;
pub use plugin::{Plugin, Services};
pub use random::RandomStream;
pub use shortest_path::shortest_path;
pub use test_host::{Published, TestHost};
pub use tick::Tick;
pub use tool_shape::{Mouth, Passage, ToolShape};
pub use tray::Tray;

#[doc(hidden)]
pub mod export {
    //! What [`crate::export_plugin!`] expands to; not for direct use.
    pub use crate::boundary::create;
    pub use abi_stable::{
        library::{__call_root_module_loader, CheckTypeLayout, LibHeader, RootModuleResult},
        prefix_type::PrefixTypeTrait,
        std_types::{RResult, RStr},
    };
    pub use microsim_abi::{ABI_VERSION, Fault, PluginBox, PluginModule, PluginModule_Ref};
}

/// Makes a dynamic library of a [`Plugin`]: `export_plugin!(MyPlugin, "../module.toml");` with the path of the
/// manifest relative to the source file. Once per library.
///
/// ```
/// # use microsim_sdk::{Fault, Plugin, Services, Setup, Tick};
/// # struct Silent;
/// # impl Plugin for Silent {
/// #     fn new() -> Self { Self }
/// #     fn initialise(&mut self, _: &Setup, _: Services) -> Result<(), Fault> { Ok(()) }
/// #     fn reset(&mut self) -> Result<(), Fault> { Ok(()) }
/// #     fn process(&mut self, _: &mut Tick<'_>) -> Result<(), Fault> { Ok(()) }
/// #     fn save(&self) -> Vec<u8> { Vec::new() }
/// #     fn restore(&mut self, _: &[u8]) -> Result<(), Fault> { Ok(()) }
/// # }
/// // In a plugin: "../plugin.toml" or "../module.toml".
/// microsim_sdk::export_plugin!(Silent, "../Cargo.toml");
/// ```
///
/// Written out instead of `#[export_root_module]`, so that a plugin needs no dependency but this crate.
#[macro_export]
macro_rules! export_plugin {
    ($plugin:ty, $manifest:literal) => {
        const _: () = {
            extern "C" fn manifest() -> $crate::export::RStr<'static> {
                $crate::export::RStr::from_str(include_str!($manifest))
            }

            extern "C" fn create()
            -> $crate::export::RResult<$crate::export::PluginBox, $crate::export::Fault> {
                $crate::export::create::<$plugin>()
            }

            fn module() -> $crate::export::PluginModule_Ref {
                $crate::export::PrefixTypeTrait::leak_into_prefix($crate::export::PluginModule {
                    manifest,
                    create,
                })
            }

            extern "C" fn load() -> $crate::export::RootModuleResult {
                $crate::export::__call_root_module_loader(module)
            }

            // SAFETY: the name belongs to plugin libraries alone (`microsim_abi::VERSION_SYMBOL`).
            #[unsafe(export_name = "MICROSIM_ABI_VERSION")]
            static VERSION: u32 = $crate::export::ABI_VERSION;

            // SAFETY: the name belongs to plugin libraries alone (`microsim_abi::ROOT_SYMBOL`), and `load` returns the
            // module that the header is made for.
            #[unsafe(export_name = "_1as_0lib_1header_0root_bmodule_bloader")]
            static HEADER: $crate::export::LibHeader = unsafe {
                $crate::export::LibHeader::from_constructor::<$crate::export::PluginModule_Ref>(
                    load,
                    $crate::export::CheckTypeLayout::Yes,
                )
            };
        };
    };
}

#[cfg(test)]
mod tests {
    /// An attribute takes no constant, so that the macro repeats the names.
    #[test]
    fn the_export_macro_writes_the_symbols_of_the_contract() {
        let source = include_str!("lib.rs");
        for symbol in [microsim_abi::ROOT_SYMBOL, microsim_abi::VERSION_SYMBOL] {
            let export = format!("#[unsafe(export_name = \"{symbol}\")]");
            assert_eq!(source.matches(&export).count(), 1, "{symbol}");
        }
    }
}
