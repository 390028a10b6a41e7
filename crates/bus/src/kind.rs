//! Message kinds: a name for people, an id for the wire.

use microsim_vocabulary::Overflow;

/// The id of a message kind: the 64-bit FNV-1a hash of its name (Fowler, Noll, Vo). Two kinds of one run with equal
/// ids are refused when they are registered.
pub const fn kind_id(name: &str) -> u64 {
    let bytes = name.as_bytes();
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(0x0000_0100_0000_01b3);
        i += 1;
    }
    hash
}

/// A message kind that a run knows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KindInfo {
    /// Full name, for example `tool.states`.
    pub name: String,
    /// Version of the payload; a receiver that knows another one refuses it.
    pub version: u16,
    /// Rule for a full queue.
    pub overflow: Overflow,
}

impl KindInfo {
    /// The kind's id on the wire.
    pub fn id(&self) -> u64 {
        kind_id(&self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_fnv1a() {
        // Published test vectors of FNV-1a, 64 bits: "" , "a", "foobar".
        assert_eq!(kind_id(""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(kind_id("a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(kind_id("foobar"), 0x8594_4171_f739_67e8);
    }
}
