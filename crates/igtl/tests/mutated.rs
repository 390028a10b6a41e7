//! A sample of what `cargo xtask soak igtl` does for as long as one likes.

#[path = "fuzz/mutate.rs"]
mod mutate;

use mutate::{Numbers, check, corpus, stream};

/// 20,000 streams of mutated frames of real peers; a quarter of the messages of the corpus has to come through, or the mutations reach nothing.
#[test]
fn mutated_frames_are_errors_or_messages() {
    let corpus = corpus();
    let mut numbers = Numbers(20_261_125);
    let (mut messages, mut failed) = (0, 0);
    for _ in 0..20_000 {
        let bytes = stream(&corpus, &mut numbers);
        let (count, has_failed) = check(&bytes, &mut numbers);
        messages += count;
        failed += usize::from(has_failed);
    }
    assert!(messages > 10_000, "{messages} messages");
    assert!(failed > 2_000, "{failed} streams failed");
}

/// The corpus itself has a frame of every type, and all of them are messages.
#[test]
fn the_corpus_is_real() {
    let corpus = corpus();
    assert!(corpus.len() >= 20, "{}", corpus.len());
    let bytes = corpus.concat();
    let (count, failed) = check(&bytes, &mut Numbers(1));
    assert_eq!((count, failed), (corpus.len(), false));
}
