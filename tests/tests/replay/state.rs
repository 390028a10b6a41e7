//! The state hash sees every bit that a plugin saves: one changed bit in one plugin's state changes the digest of this
//! plugin, of no other, and the running hash.

use microsim_host::assemble::Input;
use microsim_host::engine::{Hash, StateDigest};
use microsim_host::plan::RunPlan;
use microsim_host::{Checkpoint, Engine};
use microsim_tests::in_process::{engine, plan, tick};
use microsim_tests::tree;

/// Bits tried per plugin; of a larger state, evenly spread ones.
const BITS: usize = 600;

/// What became of the flipped bits of one plugin.
#[derive(Debug, Default)]
struct Flips {
    /// The plugin refused the state, with a reason.
    refused: usize,
    /// It saves the flipped state again: the hash must see it.
    kept: usize,
    /// It saves the state as it was: the bit belonged to the notation (a name of a field that may be missing, for example).
    notation: usize,
}

/// All that is hashed: the digests, and the running hash with them.
type Hashed = (Vec<StateDigest>, Hash);

/// Puts a state into the engine; what that saves, and its hashes. `None`: refused.
fn taken_up(engine: &mut Engine, state: &Checkpoint) -> Option<(Checkpoint, Hashed)> {
    if let Err(failure) = engine.restore(state) {
        assert!(
            !failure.panicked,
            "a bad state is refused, not panicked at: {failure}"
        );
        return None;
    }
    let saved = engine.checkpoint().expect("a restored plugin saves");
    let digests = engine.state_digests(&[]).expect("a restored plugin saves");
    Some((saved, (digests, engine.chain())))
}

fn flip(plan: &RunPlan, original: &Checkpoint, index: usize) -> Flips {
    let mut run = engine(plan);
    let (saved, (digests, chain)) = taken_up(&mut run, original).expect("its own state");
    assert!(
        saved == *original,
        "restoring and saving gives the same bytes"
    );
    let bits = 8 * original.states[index].len();
    let mut flips = Flips::default();
    for n in 0..bits.min(BITS) {
        let bit = if bits <= BITS { n } else { n * bits / BITS };
        let mut altered = original.clone();
        altered.states[index][bit / 8] ^= 1 << (bit % 8);
        let Some((saved, (now, now_chain))) = taken_up(&mut run, &altered) else {
            flips.refused += 1;
            // A plugin that has failed is not called again.
            run = engine(plan);
            continue;
        };
        // A run goes on from it only if it is the state whose hash was recorded.
        let resumed = run.resume(&altered);
        assert_eq!(
            resumed.is_ok(),
            saved.states == original.states,
            "bit {bit}"
        );
        if saved.states == original.states {
            flips.notation += 1;
            assert_eq!((now, now_chain), (digests.clone(), chain));
            continue;
        }
        flips.kept += 1;
        let what = format!("bit {bit} of \"{}\"", digests[index].plugin);
        for (n, (now, then)) in now.iter().zip(&digests).enumerate() {
            assert_eq!(
                now != then,
                n == index,
                "{what}: digest of \"{}\"",
                now.plugin
            );
        }
        assert_ne!(now_chain, chain, "{what}: the running hash");
    }
    flips
}

fn every_plugin_counts(plan: &RunPlan, ticks: u64) {
    let mut run = engine(plan);
    for _ in 0..ticks {
        tick(&mut run);
    }
    let original = run.checkpoint().expect("plugins save");
    let digests = run.state_digests(&[]).expect("plugins save");
    for (index, digest) in digests.iter().enumerate() {
        let flips = flip(plan, &original, index);
        println!(
            "{}: {} bytes, {flips:?}",
            digest.plugin,
            original.states[index].len()
        );
        // A source saves little: a number and a flag, eight bits that can differ.
        assert!(
            flips.kept >= 8 && flips.kept > 4 * flips.notation,
            "{}: {flips:?}",
            digest.plugin
        );
    }
}

#[test]
fn one_changed_bit_of_any_plugin_changes_the_hash_with_physics() {
    let script = tree().join("modules/push-strip/scripts/level1-pass.toml");
    let plan = plan("push-strip", 1, Input::Script(script), "unused".into());
    assert_eq!(
        plan.plugins.len(),
        6,
        "source, translator, physics, module, objects; recorder"
    );
    every_plugin_counts(&plan, 150);
}

#[test]
fn one_changed_bit_of_any_plugin_changes_the_hash_without_physics() {
    let recording = tree().join("assets/recordings/cataract-stylus/stylus.csv");
    let plan = plan(
        "touch-spheres",
        1,
        Input::Recording(recording),
        "unused".into(),
    );
    assert_eq!(
        plan.plugins.len(),
        5,
        "source, translator, module, objects; recorder"
    );
    every_plugin_counts(&plan, 150);
}
