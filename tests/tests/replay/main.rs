//! A session proves itself: one history in every process, and any change of it is found and named.
//!
//! Expected values are the program's own first answer (a second process must give the same bits) or follow from what
//! the test itself has changed.

mod altered;
mod bits;
mod checkpoint;
mod forged;
mod live;
mod playback;
mod signed;
mod state;
#[path = "../plugins/tree.rs"]
mod tree;
mod without;

use microsim_tests::{run, scratch};
use std::fs;
use std::sync::OnceLock;

/// A level with physics and a script that passes it.
const PUSH_STRIP: [&str; 2] = ["--input", "script:level1-pass.toml"];
/// A level without physics and the motion of a real hand.
const TOUCH_SPHERES: [&str; 2] = ["--input", microsim_tests::RECORDING];

fn session(module: &str, args: &[&str]) -> Vec<u8> {
    let folder = scratch();
    let path = folder.path().join("a.session");
    run(module, &path, args);
    fs::read(path).expect("a session")
}

/// A session of the recorded hand on touch-spheres.
fn recorded_hand() -> &'static [u8] {
    static SESSION: OnceLock<Vec<u8>> = OnceLock::new();
    SESSION.get_or_init(|| session("touch-spheres", &TOUCH_SPHERES))
}

/// A session of the passing script on push-strip.
fn pushed_strip() -> &'static [u8] {
    static SESSION: OnceLock<Vec<u8>> = OnceLock::new();
    SESSION.get_or_init(|| session("push-strip", &PUSH_STRIP))
}
