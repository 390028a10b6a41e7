//! Signatures of a session by the station that recorded it: Ed25519 over a running digest of all records.

use ed25519_dalek::{Signature, Signer, SigningKey, VerifyingKey};
use std::fmt;

/// Bytes of a [`Seal`]: the public key of the station, and its signature.
pub const SEAL_LENGTH: usize = 96;

/// Public key and signature, as they stand in a file.
pub type Seal = [u8; SEAL_LENGTH];

/// What a signature is over begins with this line, so that it can be taken for nothing else.
const CONTEXT: &[u8] = b"MicroSim session, signed by its station\n";

/// Running digest of the records of a session: kind, tick, length and bytes of each, in the order of the file.
#[derive(Clone, Debug, Default)]
pub struct History(blake3::Hasher);

impl History {
    /// Of no record.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one record.
    pub fn add(&mut self, kind: u8, tick: u64, payload: &[u8]) {
        self.0.update(&[kind]);
        self.0.update(&tick.to_le_bytes());
        self.0.update(&(payload.len() as u64).to_le_bytes());
        self.0.update(payload);
    }

    /// What is signed behind these records: in a record of this kind at this tick, so that a signature of an unfinished session never
    /// closes one.
    fn message(&self, kind: u8, tick: u64) -> Vec<u8> {
        let digest = self.0.finalize();
        [CONTEXT, &[kind], &tick.to_le_bytes(), digest.as_bytes()].concat()
    }

    /// The station whose signature of these records `seal` is; `None` if it is that of none.
    pub fn signed_by(&self, kind: u8, tick: u64, seal: &[u8]) -> Option<Station> {
        let (public, signature) = seal.split_first_chunk::<32>()?;
        let key = VerifyingKey::from_bytes(public).ok()?;
        let signature = Signature::from_bytes(signature.try_into().ok()?);
        let message = self.message(kind, tick);
        key.verify_strict(&message, &signature).ok()?;
        Some(Station(*public))
    }
}

/// The secret key of a station. Whoever has it can sign whatever he likes.
#[derive(Clone)]
pub struct StationKey(SigningKey);

impl StationKey {
    /// The key that grows from 32 secret, random bytes.
    pub fn from_seed(seed: &[u8; 32]) -> Self {
        Self(SigningKey::from_bytes(seed))
    }

    /// The station.
    pub fn station(&self) -> Station {
        Station(self.0.verifying_key().to_bytes())
    }

    /// Signs all records so far, in a record of this kind at this tick.
    pub fn sign(&self, history: &History, kind: u8, tick: u64) -> Seal {
        let mut seal = [0; SEAL_LENGTH];
        seal[..32].copy_from_slice(&self.station().0);
        let signature = self.0.sign(&history.message(kind, tick));
        seal[32..].copy_from_slice(&signature.to_bytes());
        seal
    }
}

impl fmt::Debug for StationKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "StationKey of {}", self.station())
    }
}

/// A station, by its public key. Displayed as its fingerprint: the first 128 bits of the key's BLAKE3 digest, in groups of four digits.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Station([u8; 32]);

impl Station {
    /// Whether this is its fingerprint, with or without hyphens.
    pub fn has_fingerprint(&self, text: &str) -> bool {
        let bare = |text: &str| text.replace('-', "").to_ascii_lowercase();
        bare(text) == bare(&self.to_string())
    }
}

impl fmt::Display for Station {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digest = blake3::hash(&self.0);
        for (index, pair) in digest.as_bytes()[..16].chunks(2).enumerate() {
            let hyphen = if index == 0 { "" } else { "-" };
            write!(f, "{hyphen}{:02x}{:02x}", pair[0], pair[1])?;
        }
        Ok(())
    }
}

impl fmt::Debug for Station {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history(records: &[(u8, u64, &[u8])]) -> History {
        let mut history = History::new();
        for (kind, tick, payload) in records {
            history.add(*kind, *tick, payload);
        }
        history
    }

    /// RFC 8032, section 7.1, test 1: the public key of a secret one.
    #[test]
    fn keys_are_those_of_the_standard() {
        let bytes = |text: &str| -> [u8; 32] {
            std::array::from_fn(|n| u8::from_str_radix(&text[2 * n..2 * n + 2], 16).unwrap())
        };
        let secret = bytes("9d61b19deffd5a60ba844af492ec2cc44449c5697b326919703bac031cae7f60");
        let public = bytes("d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a");
        assert_eq!(StationKey::from_seed(&secret).station(), Station(public));
    }

    /// Any change of a record, of the order, of the place or of the seal itself.
    #[test]
    fn only_what_was_signed_fits() {
        let key = StationKey::from_seed(&[7; 32]);
        let signed = history(&[(1, 0, b"header"), (2, 1, b"tick"), (2, 2, b"")]);
        let seal = key.sign(&signed, 5, 2);
        assert_eq!(signed.signed_by(5, 2, &seal), Some(key.station()));
        for (kind, tick) in [(0, 2), (5, 3)] {
            assert_eq!(signed.signed_by(kind, tick, &seal), None);
        }
        let others = [
            history(&[(1, 0, b"headex"), (2, 1, b"tick"), (2, 2, b"")]),
            history(&[(2, 1, b"tick"), (1, 0, b"header"), (2, 2, b"")]),
            history(&[(1, 0, b"header"), (2, 1, b"tick")]),
            history(&[(1, 0, b"header"), (2, 1, b"tick"), (2, 3, b"")]),
            history(&[(1, 0, b"headert"), (2, 1, b"ick"), (2, 2, b"")]),
        ];
        for other in others {
            assert_eq!(other.signed_by(5, 2, &seal), None);
        }
        for bit in 0..8 * SEAL_LENGTH {
            let mut flipped = seal;
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(signed.signed_by(5, 2, &flipped), None, "bit {bit}");
        }
        assert_eq!(signed.signed_by(5, 2, &seal[1..]), None);
        assert_eq!(signed.signed_by(5, 2, &[]), None);
    }

    #[test]
    fn a_fingerprint_names_one_station() {
        let [one, other] = [[1; 32], [2; 32]].map(|seed| StationKey::from_seed(&seed).station());
        let text = one.to_string();
        assert_eq!((text.len(), text.split('-').count()), (39, 8));
        assert!(
            one.has_fingerprint(&text)
                && one.has_fingerprint(&text.replace('-', "").to_uppercase())
        );
        assert!(!other.has_fingerprint(&text) && !one.has_fingerprint(&text[..38]));
        let key = StationKey::from_seed(&[1; 32]);
        assert_eq!(format!("{key:?}"), format!("StationKey of {text}"));
    }
}
