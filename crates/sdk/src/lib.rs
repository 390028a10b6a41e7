//! All that the author of a plugin or training module uses.
//!
//! - [`Plugin`]: the safe trait; [`export_plugin!`] makes a dynamic library of it.
//! - [`Tick`]: typed messages in and out of one `process` call.
//! - [`message`]: the platform's message kinds; [`message::Message`] for kinds of your own.
//! - [`RandomStream`]: named, seeded random numbers that can be saved.
//! - [`Playback`]: samples of a file as an input source.
//! - [`Parallel`]: a parallel loop with a fixed partition (physics only).
//! - [`LevelRun`]: phases, targets, limits, metrics and the result of a training module.
//! - [`Tray`]: the inner space of a tray of the level.
//! - [`Exercise`]: what a training module asks for; [`Training`] is the frame around it.
//! - [`tissue`]: marks that follow tissue, grips, cuts assigned to marks, pieces, rings.
//! - [`TestHost`]: runs a plugin in-process without any file, every crossing through a byte copy.
//!
//! A whole module in one file: `cargo run --example module -p microsim-sdk`; a folder for a new one: `cargo xtask new-module`.
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
mod panic;
mod parallel;
mod playback;
mod plugin;
mod random;
mod shortest_path;
mod test_host;
mod tick;
pub mod tissue;
mod tray;

pub use direction::{axis, turned_to};
pub use exercise::{Exercise, Training};
pub use fault::Fault;
pub use level_run::LevelRun;
pub use microsim_bus::{BlockBuilder, BlockView, KindInfo, Overflow, kind_id as name_id};
pub use microsim_message as message;
pub use microsim_message::{LogLevel, Setup};
pub use microsim_settings::{ModuleConfig, Object, Shape};
pub use parallel::Parallel;
pub use playback::Playback;
pub use plugin::{Plugin, Services};
pub use random::RandomStream;
pub use shortest_path::shortest_path;
pub use test_host::{Published, TestHost};
pub use tick::Tick;
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
