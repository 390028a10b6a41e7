//! Which program this is: version, commit of its sources, and version of the contract with plugins.

use std::sync::LazyLock;

/// The commit that the sources of this program are of, with `-dirty` where they are not as it has them; `unknown` where they were not built
/// in its repository. The build script states it.
pub const COMMIT: &str = env!("MICROSIM_COMMIT");

/// Version of the contract that libraries of plugins have to be built for.
pub const CONTRACT: u32 = microsim_abi::ABI_VERSION;

static TEXT: LazyLock<String> = LazyLock::new(|| {
    let version = env!("CARGO_PKG_VERSION");
    format!("{version} (commit {COMMIT}, plugin contract {CONTRACT})")
});

/// All three, as `--version` prints them.
pub fn text() -> &'static str {
    &TEXT
}
