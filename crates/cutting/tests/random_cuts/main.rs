//! A seeded sample of random cuts.

mod bodies;
#[path = "../../src/testing.rs"]
mod random;
mod soak;

#[test]
fn three_hundred_strokes_leave_sound_meshes() {
    let summary = soak::run(300, 1, 5, |_| ()).unwrap_or_else(|e| panic!("{e}"));
    println!("{summary:?}");
}
