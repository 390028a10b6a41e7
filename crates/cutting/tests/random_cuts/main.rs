//! A seeded sample of random cuts.

mod bodies;
mod soak;

use microsim_cutting::TopologyChange;

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

/// A mesh is valid and conforming after every step with each change of topology, whatever has been lost is what is missing, and nothing hangs together
/// across a blade that has passed right through.
#[test]
fn each_change_of_topology_leaves_sound_meshes() {
    for (change, divides) in [
        (TopologyChange::Remove, false),
        (TopologyChange::SplitAtFaces, false),
        (TopologyChange::SemiProgressive, true),
    ] {
        let run = soak::run_with(change, 100, 2, 3, &mut (), |_| ());
        let summary = run.unwrap_or_else(|e| panic!("{change:?}: {e}"));
        assert!(
            summary.complete > 15 && summary.pieces > 15,
            "{change:?} {summary:?}"
        );
        assert_eq!(summary.divided > 0, divides, "{change:?}");
        let takes = change == TopologyChange::Remove;
        assert_eq!(
            summary.lost > 1.0,
            takes,
            "{change:?}: lost {}",
            summary.lost
        );
    }
}
