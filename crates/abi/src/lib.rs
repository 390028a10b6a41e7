//! The plugin contract: what crosses between the host and a dynamic library, and nothing else.
//!
//! Here: the root module that every library exports, the object behind it, the plain data of a call, the version.
//! Not here: logic, typed messages (crate `message`), catching of panics and the safe traits (crate `sdk`), loading
//! (crate `host`).
//!
//! Life cycle, and which thread calls what. One plugin is called by one thread at a time, never re-entrantly.
//!
//! | call | state before | thread | may allocate |
//! |---|---|---|---|
//! | `manifest` | library loaded | host's main thread | no |
//! | `create` | manifest checked | host's main thread | cheaply |
//! | `initialise` | created | tick thread; for observers (renderer) the picture thread | yes |
//! | `reset` | initialised | same as `initialise` | yes |
//! | `process` | initialised | same as `initialise`, once per tick (observers: once per picture) | as little as it can |
//! | `save`, `restore` | initialised | same, between two ticks | yes |
//! | `extension` | initialised | same, between two ticks | yes |
//! | `stop` | initialised | same, once, last | yes |
//!
//! **Rationale.** Everything that a plugin receives or publishes is bytes, so that a plugin can be recorded, replayed and moved
//! into a process of its own. The trait below never grows: a plugin built against an older, smaller trait would be
//! refused by a newer host. Abilities that come later are asked for by name through `extension`.

#![allow(
    unsafe_code,
    reason = "pointers of the parallel loop cross the boundary; the derive macros of abi_stable"
)]
#![allow(
    non_local_definitions,
    non_camel_case_types,
    unused_braces,
    reason = "written by the derive macros of abi_stable 0.11"
)]

use abi_stable::{
    StableAbi, declare_root_module_statics,
    library::RootModule,
    package_version_strings, sabi_trait,
    sabi_types::VersionStrings,
    std_types::{RBox, ROption, RResult, RSlice, RStr, RString, RVec},
};
use std::ffi::c_void;

/// The version of this contract. A library built for another one is refused before its layout is looked at and before any
/// of its code runs.
pub const ABI_VERSION: u32 = 2;

/// Name of the plain word (`u32`) that a library exports and that holds the [`ABI_VERSION`] it was built for. The host reads it first.
pub const VERSION_SYMBOL: &str = "MICROSIM_ABI_VERSION";

/// Name of the symbol that a library exports, as the loader of abi_stable looks for it. The macro
/// `export_plugin!` of the SDK has to repeat it, because an attribute takes no constant.
pub const ROOT_SYMBOL: &str = "_1as_0lib_1header_0root_bmodule_bloader";

/// Why a call failed.
#[repr(u8)]
#[derive(StableAbi, Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// The plugin cannot go on.
    Error,
    /// Something that the plugin needs is not on this machine (a graphics driver, for example); the text names it.
    Unavailable,
    /// The plugin panicked; the SDK caught it at the boundary.
    Panic,
}

/// A failed call: the kind and one sentence for a person.
#[repr(C)]
#[derive(StableAbi, Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// What kind of failure it was.
    pub kind: FaultKind,
    /// One sentence for a person.
    pub text: RString,
}

/// A large state as one relocatable block of 64-bit words, shared read-only; valid until the call returns. The layout
/// inside is that of `microsim_bus::block`.
#[repr(C)]
#[derive(StableAbi, Clone, Copy)]
pub struct Block<'a> {
    /// Message kind, as in a frame header.
    pub kind: u64,
    /// The block: header, offsets, arrays.
    pub words: RSlice<'a, u64>,
}

/// A block that a plugin publishes; it replaces the one of the same kind and name.
#[repr(C)]
#[derive(StableAbi, Clone)]
pub struct BlockOut {
    /// Message kind, as in a frame header.
    pub kind: u64,
    /// The block: header, offsets, arrays.
    pub words: RVec<u64>,
}

/// What `process` is given. All times are simulated.
#[repr(C)]
#[derive(StableAbi, Clone, Copy)]
pub struct Call<'a> {
    /// Index of the tick, from 0.
    pub tick: u64,
    /// Time at the end of this tick \[ns\].
    pub time_ns: u64,
    /// Length of the tick \[ns\].
    pub tick_ns: u64,
    /// Solver steps in the tick.
    pub steps: u32,
    /// Messages for this plugin, framed as in `microsim_bus::frame`, in the order of their publication.
    pub messages: RSlice<'a, u8>,
    /// The latest block of each kind and name that this plugin subscribes to.
    pub blocks: RSlice<'a, Block<'a>>,
}

/// What `process` answers.
#[repr(C)]
#[derive(StableAbi, Clone)]
pub struct Output {
    /// Messages that this plugin publishes, framed as `microsim_bus::frame` describes, in the order of their publication.
    pub messages: RVec<u8>,
    /// Blocks that this plugin publishes.
    pub blocks: RVec<BlockOut>,
}

/// The body of a parallel loop (a type of its own because the layout check does not look into functions that take
/// functions).
#[repr(transparent)]
#[derive(StableAbi, Clone, Copy)]
pub struct ParallelBody {
    /// Computes one part; `data` is the pointer that came with the body. Does not unwind.
    pub call: unsafe extern "C" fn(data: *const c_void, part: u32),
}

/// The host's parallel loop over a fixed number of parts. Given to plugins that run in the host's process (physics),
/// never to a training module: no callback crosses to one.
#[repr(C)]
#[derive(StableAbi, Clone, Copy)]
pub struct ParallelFor {
    /// First argument of `run`: the host's, opaque to a plugin.
    pub context: *const c_void,
    /// Calls `body(data, part)` for every `part` in `0..parts`, on any threads, and returns when all are done. `body`
    /// must not unwind.
    pub run: unsafe extern "C" fn(
        context: *const c_void,
        parts: u32,
        body: ParallelBody,
        data: *const c_void,
    ),
}

// SAFETY: the host guarantees that `run` may be called from any thread while the plugin lives.
unsafe impl Send for ParallelFor {}
// SAFETY: the same.
unsafe impl Sync for ParallelFor {}

/// The ability to give, in place of what is saved, bytes for the state hash whose length does not grow with the run.
pub const STATE_HASHED: &str = "state.hashed";

/// A plugin, seen from the host. See the table above for threads and states.
#[sabi_trait]
pub trait PluginObject: Send {
    /// `setup`: the MessagePack of `microsim_message::Setup`.
    fn initialise(
        &mut self,
        setup: RSlice<'_, u8>,
        parallel: ROption<ParallelFor>,
    ) -> RResult<(), Fault>;
    /// Back to the state right after `initialise`.
    fn reset(&mut self) -> RResult<(), Fault>;
    /// One tick.
    fn process(&mut self, call: Call<'_>) -> RResult<Output, Fault>;
    /// All that evolves, as bytes; equal states give equal bytes.
    fn save(&mut self) -> RResult<RVec<u8>, Fault>;
    /// The opposite of `save`, in this or another process.
    fn restore(&mut self, state: RSlice<'_, u8>) -> RResult<(), Fault>;
    /// An ability by name; `RNone`: this plugin does not have it.
    fn extension(
        &mut self,
        name: RStr<'_>,
        request: RSlice<'_, u8>,
    ) -> RResult<ROption<RVec<u8>>, Fault>;
    /// The last call.
    #[sabi(last_prefix_field)]
    fn stop(&mut self) -> RResult<(), Fault>;
}

/// The object behind the boundary.
pub type PluginBox = PluginObject_TO<'static, RBox<()>>;

/// What every plugin library exports.
#[repr(C)]
#[derive(StableAbi)]
#[sabi(kind(Prefix(prefix_ref = PluginModule_Ref)))]
#[sabi(missing_field(panic))]
pub struct PluginModule {
    /// The manifest's text, as embedded at the time of the build.
    pub manifest: extern "C" fn() -> RStr<'static>,
    /// Makes the plugin's object; called once, after the manifest has been checked.
    #[sabi(last_prefix_field)]
    pub create: extern "C" fn() -> RResult<PluginBox, Fault>,
}

impl RootModule for PluginModule_Ref {
    declare_root_module_statics! {PluginModule_Ref}
    const BASE_NAME: &'static str = "microsim_plugin";
    const NAME: &'static str = "microsim plugin";
    const VERSION_STRINGS: VersionStrings = package_version_strings!();
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_root_symbol_is_that_of_abi_stable() {
        assert_eq!(
            abi_stable::library::ROOT_MODULE_LOADER_NAME,
            super::ROOT_SYMBOL
        );
    }
}
