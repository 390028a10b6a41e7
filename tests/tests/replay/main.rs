//! A session proves itself: one history in every process, and any change of it is found and named.
//!
//! Expected values are the program's own first answer (a second process must give the same bits) or follow from what
//! the test itself has changed.

mod altered;
mod checkpoint;
mod live;
mod same_bits;
mod state;
mod without;

use std::path::PathBuf;

/// A level with physics and a script that passes it.
const PUSH_STRIP: [&str; 2] = ["--input", "script:level1-pass.toml"];
/// A level without physics and the motion of a real hand.
const TOUCH_SPHERES: [&str; 2] = ["--input", microsim_tests::RECORDING];

/// A session of the recorded hand on touch-spheres in `folder`.
fn recorded_hand(folder: &tempfile::TempDir) -> PathBuf {
    let session = folder.path().join("hand.session");
    microsim_tests::run("touch-spheres", &session, &TOUCH_SPHERES);
    session
}

/// A session of the passing script on push-strip in `folder`.
fn pushed_strip(folder: &tempfile::TempDir) -> PathBuf {
    let session = folder.path().join("strip.session");
    microsim_tests::run("push-strip", &session, &PUSH_STRIP);
    session
}
