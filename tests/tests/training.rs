//! A sample of `cargo xtask soak training`: a minute of scripted training of random modules in this process.

use microsim_tests::training::{Order, Played, Training};

/// Simulated \[s\].
const SECONDS: f64 = 60.0;
/// The first ten runs with it have every module, none of the levels that cost several times real time, and a vessel as the tenth, which is replayed.
const SEED: u64 = 230;

/// Every run ends as its script is named, no force is infinite, what is replayed is the same to the bit, memory is flat.
#[test]
fn a_minute_of_training_leaves_nothing_behind() {
    let mut training = Training::new().expect("the built tree");
    let mut order = Order::new(SEED);
    let is_replayed = |played: &Played| played.replayed && played.tissue > 0;
    while training.simulated() < SECONDS || !training.played.iter().any(is_replayed) {
        let exercise = order.next().expect("there is always another one");
        let played = training.play(exercise).expect("it begins");
        println!("{played:?}");
    }
    assert_eq!(training.faults(), [""; 0]);
    let memory = training.memory();
    assert!(memory.is_flat(), "{memory:?}");
}
