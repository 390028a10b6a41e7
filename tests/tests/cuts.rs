//! Cuts right through a block leave two pieces, however the blade trembles, turns back or comes again: cases of trials in which they did not.

use microsim_tests::simulated::{probe, simulate};

#[track_caller]
fn parts_in_two(scene: &str) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/cuts/");
    let document = simulate(&format!("{path}{scene}.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    let pieces = probe(&document, "pieces");
    assert_eq!(pieces.last(), Some(&2.0), "{scene}: {pieces:?}");
}

#[test]
fn a_blade_that_trembles_parts_a_block() {
    parts_in_two("tremor");
}

#[test]
fn a_blade_that_goes_back_once_parts_a_block() {
    parts_in_two("one-reversal");
}

#[test]
fn cutting_again_along_a_cut_sheds_nothing() {
    parts_in_two("twice-along-one-plane");
    parts_in_two("two-blades-one-plane");
}
