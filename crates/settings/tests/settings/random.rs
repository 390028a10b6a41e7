//! No text whatever makes the reader panic.

use crate::{EXAMPLES, read};
use proptest::prelude::*;

/// Pieces that files are made of, right and wrong.
fn piece() -> impl Strategy<Value = String> {
    let words = [
        "name",
        "key",
        "[[tool]]",
        "[[tool.key]]",
        "[[object]]",
        "[[body.clamp]]",
        "[[body.material]]",
        "[[probe]]",
        "[[expect]]",
        "[run]",
        "[method]",
        "nodes",
        "law = \"springs\"",
        "form = \"plain\"",
        "[[limit]]",
        "[module]",
        "[clock]",
        "metric",
        "min",
        "max",
        "type",
        "unit",
        "=",
        " ",
        "\n",
        ".",
        "[",
        "]",
        "{",
        "}",
        ",",
        "\"",
        "'",
        "nan",
        "-inf",
        "1e999",
        "9223372036854775808",
        "-0.0",
        "true",
        "\"8 ms\"",
        "\"1e9999999999999 mm\"",
        "1979-05-27",
        "µ",
        "#",
        "\"\"\"",
        "\"°\"",
        "0x",
        "\r\n",
        "\0",
        "count = 256",
    ];
    prop_oneof![
        8 => proptest::sample::select(words.to_vec()).prop_map(str::to_owned),
        1 => any::<String>(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn pieces_never_panic(pieces in proptest::collection::vec(piece(), 0..40)) {
        for (kind, _) in EXAMPLES {
            let _ = read(kind, &pieces.concat());
        }
    }

    /// An example with a part replaced gets past the syntax more often than a random text.
    #[test]
    fn damaged_examples_never_panic(kind in 0..EXAMPLES.len(), from in 0.0..1.0_f64, len in 0..30_usize, new in piece()) {
        let (kind, text) = EXAMPLES[kind];
        let characters: Vec<char> = text.chars().collect();
        let from = (from * characters.len() as f64) as usize;
        let to = (from + len).min(characters.len());
        let damaged: String = characters[..from].iter().copied().chain(new.chars()).chain(characters[to..].iter().copied()).collect();
        if let Err(errors) = read(kind, &damaged) {
            prop_assert!(!errors.0.is_empty());
        }
    }
}

/// Brackets nested deeper than any parser likes.
#[test]
fn deep_nesting_is_an_error() {
    for (open, close) in [("[", "]"), ("{a=", "}")] {
        let text = format!("a = {}1{}", open.repeat(20_000), close.repeat(20_000));
        assert!(read("host", &text).is_err());
    }
}
