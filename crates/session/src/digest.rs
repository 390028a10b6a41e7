//! Digests (BLAKE3, 256 bit) of states and files, and the chain that binds them in their order.

/// The digest of a list of byte strings.
///
/// Each part enters behind its length (u64, little-endian), so that `["ab", "c"]` and `["a", "bc"]` differ.
pub fn digest<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    for part in parts {
        enter(&mut hasher, part);
    }
    hasher.finalize().into()
}

fn enter(hasher: &mut blake3::Hasher, part: &[u8]) {
    hasher.update(&(part.len() as u64).to_le_bytes());
    hasher.update(part);
}

/// A running digest: each link depends on all before it, so that equal values mean equal histories.
///
/// It starts from 32 zero bytes; a link is `digest([value so far, tick as u64 little-endian, parts …])`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Chain {
    value: [u8; 32],
}

impl Chain {
    /// The chain without a link.
    pub fn new() -> Self {
        Self::default()
    }

    /// The chain that has reached `value`, to continue a saved one.
    pub fn from_value(value: [u8; 32]) -> Self {
        Self { value }
    }

    /// Adds one link: the tick and what was there at it.
    pub fn add<'a>(&mut self, tick: u64, parts: impl IntoIterator<Item = &'a [u8]>) {
        let mut hasher = blake3::Hasher::new();
        enter(&mut hasher, &self.value);
        enter(&mut hasher, &tick.to_le_bytes());
        for part in parts {
            enter(&mut hasher, part);
        }
        self.value = hasher.finalize().into();
    }

    /// The value reached.
    pub fn value(&self) -> [u8; 32] {
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hex(bytes: [u8; 32]) -> String {
        bytes.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// Without parts it is plain BLAKE3 of nothing; the value stands in the official test vectors (input_len 0).
    #[test]
    fn of_nothing_is_the_official_vector() {
        assert_eq!(
            hex(digest([])),
            "af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262"
        );
    }

    #[test]
    fn parts_enter_behind_their_length() {
        let flat = b"\x02\0\0\0\0\0\0\0ab\x01\0\0\0\0\0\0\0c";
        assert_eq!(
            digest([b"ab".as_slice(), b"c"]),
            *blake3::hash(flat).as_bytes()
        );
    }

    #[test]
    fn concatenation_is_unambiguous() {
        let lists: [&[&[u8]]; 6] = [
            &[],
            &[b""],
            &[b"", b""],
            &[b"abc"],
            &[b"ab", b"c"],
            &[b"a", b"bc"],
        ];
        for (index, list) in lists.iter().enumerate() {
            for other in &lists[..index] {
                let digests = [*list, *other].map(|parts| digest(parts.iter().copied()));
                assert_ne!(digests[0], digests[1], "{list:?} and {other:?}");
            }
        }
    }

    #[test]
    fn chain_is_the_documented_recurrence() {
        let mut chain = Chain::new();
        chain.add(5, [b"state".as_slice()]);
        let first = digest([[0; 32].as_slice(), &5_u64.to_le_bytes(), b"state"]);
        assert_eq!(chain.value(), first);

        chain.add(6, [b"state".as_slice()]);
        let mut continued = Chain::from_value(first);
        continued.add(6, [b"state".as_slice()]);
        assert_eq!(chain, continued);
    }

    /// Any change of content, tick or order of earlier links shows in the last value.
    #[test]
    fn chain_depends_on_its_history() {
        let value = |links: &[(u64, &[u8])]| {
            let mut chain = Chain::new();
            for &(tick, part) in links {
                chain.add(tick, [part]);
            }
            chain.value()
        };
        let reference = value(&[(1, b"a"), (2, b"b"), (3, b"c")]);
        for changed in [
            value(&[(1, b"x"), (2, b"b"), (3, b"c")]),
            value(&[(0, b"a"), (2, b"b"), (3, b"c")]),
            value(&[(2, b"b"), (1, b"a"), (3, b"c")]),
            value(&[(1, b"a"), (2, b"b")]),
        ] {
            assert_ne!(changed, reference);
        }
    }
}
