//! Cuts right through a block leave the pieces that they should, however the blade trembles, turns back or comes again: cases of trials in which they did not.

use microsim_tests::simulated::{probe, simulate};

#[track_caller]
fn parts_in(scene: &str, count: f64) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/cuts/");
    let document = simulate(&format!("{path}{scene}.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    let pieces = probe(&document, "pieces");
    assert_eq!(pieces.last(), Some(&count), "{scene}: {pieces:?}");
}

#[track_caller]
fn parts_in_two(scene: &str) {
    parts_in(scene, 2.0);
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
fn a_blade_that_crosses_its_own_path_parts_what_it_has_gone_around() {
    parts_in("self-crossing", 3.0);
}

#[test]
fn cutting_again_along_a_cut_sheds_nothing() {
    parts_in_two("twice-along-one-plane");
    parts_in_two("two-blades-one-plane");
}
