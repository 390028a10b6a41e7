//! A seeded sample of random cuts with all that follows a mesh.

#[path = "../../../cutting/tests/random_cuts/bodies.rs"]
mod bodies;
mod followers;
#[path = "../../../cutting/tests/random_cuts/soak.rs"]
mod soak;

#[test]
fn what_follows_a_hundred_strokes_is_what_is_made_anew() {
    let mut followers = followers::Followers::new(11);
    let summary = soak::run(100, 11, 3, &mut followers, |_| ()).unwrap_or_else(|e| panic!("{e}"));
    // The sample holds what is to be tested.
    let tally = followers.tally;
    assert!(
        summary.edits > 200 && tally.crumbs > 0,
        "{summary:?} {tally:?}"
    );
    assert!(
        tally.materials.iter().all(|&bodies| bodies > 0),
        "{tally:?}"
    );
    assert!(tally.points > 1000 && tally.floored > 1000, "{tally:?}");
}
