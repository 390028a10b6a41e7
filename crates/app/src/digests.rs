//! `microsim digests`: what `cargo xtask build` writes into an installation.

use crate::cli::{DigestsArgs, Place};
use crate::output::{Exit, Problem, print};
use microsim_host::loader::file_hash;

/// Prints the digests of files as `b3sum` does, which checks them with `--check`.
pub fn digests(place: &Place, args: &DigestsArgs) -> Result<Exit, Problem> {
    let root = place.root.clone().unwrap_or_default();
    for file in &args.files {
        let hash = file_hash(&root.join(file)).map_err(|e| format!("{}: {e}", file.display()))?;
        print(format!("{hash}  {}", file.display()))?;
    }
    Ok(Exit::Done)
}
