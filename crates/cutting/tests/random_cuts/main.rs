//! A seeded sample of random cuts.

mod bodies;
mod soak;

#[test]
fn three_hundred_strokes_leave_sound_meshes() {
    let summary = soak::run(300, 1, 3, &mut (), |_| ()).unwrap_or_else(|e| panic!("{e}"));
    // The sample holds what is to be tested.
    let found = [
        summary.complete,
        summary.pieces,
        summary.clamped,
        summary.joined,
        summary.snapped,
    ];
    assert!(found.iter().all(|&n| n > 50), "{summary:?}");
}
