//! A seeded sample of strokes of a trembling hand.

mod hand;
mod regions;
mod soak;

use hand::Course;

#[test]
fn a_trembling_hand_separates_what_its_blade_has_swept_between() {
    let summary = soak::run(30, 7, Course::Straight, |_| ()).unwrap_or_else(|e| panic!("{e}"));
    assert!(summary.joined.is_empty(), "{summary:?}");
    // Few leave one (`cargo xtask soak tremor`, tests/results/cutting.md).
    assert!(summary.shards <= 2, "{summary:?}");
    assert_eq!(summary.regions, 2 * summary.strokes, "{summary:?}");
}

/// What a loop leaves between its two legs may hang together: a limitation of the crate. The mesh is valid all the same, and the loop is cut
/// where it does not come near itself.
#[test]
fn a_path_that_crosses_itself_leaves_a_valid_mesh() {
    let summary = soak::run(8, 3, Course::Looped, |_| ()).unwrap_or_else(|e| panic!("{e}"));
    assert!(summary.edits > 100 && summary.regions > 16, "{summary:?}");
}
