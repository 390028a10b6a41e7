//! A sample of `cargo xtask soak training`: a minute of scripted training of random modules in this process.

use microsim_tests::training::{Order, REPLAYED, Training};

/// Simulated \[s\].
const SECONDS: f64 = 60.0;
const SEED: u64 = 1;

/// Every run ends as its script is named, no force is infinite, what is replayed is the same to the bit, memory is flat.
#[test]
fn a_minute_of_training_leaves_nothing_behind() {
    let mut training = Training::new().expect("the built tree");
    let mut order = Order::new(SEED);
    while training.simulated() < SECONDS || training.played.len() < REPLAYED {
        let exercise = order.next().expect("there is always another one");
        let played = training.play(exercise).expect("it begins");
        println!("{played:?}");
    }
    assert_eq!(training.faults(), [""; 0]);
    let replayed = training.played.iter().filter(|of| of.replayed).count();
    assert!(replayed > 0);
    let memory = training.memory();
    assert!(memory.is_flat(), "{memory:?}");
}
