//! The header of a message, and fixed-length names in it.

use crc::{CRC_64_ECMA_182, Crc, Table};

/// Length of the header.
pub(crate) const HEADER: usize = 58;
/// Length of a type's name.
pub(crate) const KIND: usize = 12;
/// Length of the name of a device or tool.
pub(crate) const NAME: usize = 20;
/// Versions whose layout is known.
pub(crate) const VERSIONS: std::ops::RangeInclusive<u16> = 1..=3;

/// Polynomial 0x42F0E1EBA9EA3693, from 0, not reflected, nothing added at the end.
pub(crate) static CHECKSUM: Crc<u64, Table<16>> = Crc::<u64, Table<16>>::new(&CRC_64_ECMA_182);

/// A time in units of 2⁻³² s since 1970 UTC; zero is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Timestamp(pub u64);

impl Timestamp {
    /// In nanoseconds since 1970 UTC, to the nearest; `None` if the sender set none.
    pub fn nanoseconds(self) -> Option<u64> {
        let (seconds, fraction) = (self.0 >> 32, self.0 & 0xFFFF_FFFF);
        let nanoseconds = (fraction * 1_000_000_000 + (1 << 31)) >> 32;
        (self.0 != 0).then_some(seconds * 1_000_000_000 + nanoseconds)
    }

    /// Of nanoseconds since 1970 UTC, to the nearest unit. Times from 2106 on, which the format has not, are its last one.
    pub fn from_nanoseconds(nanoseconds: u64) -> Self {
        let (seconds, rest) = (nanoseconds / 1_000_000_000, nanoseconds % 1_000_000_000);
        let fraction = ((rest << 32) + 500_000_000) / 1_000_000_000;
        match seconds {
            0..=0xFFFF_FFFF => Self((seconds << 32) + fraction),
            _ => Self(u64::MAX),
        }
    }
}

/// The fields of a header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    pub version: u16,
    pub kind: String,
    pub device: String,
    pub time: Timestamp,
    pub length: u64,
    pub checksum: u64,
}

impl Header {
    pub fn read(bytes: &[u8; HEADER]) -> Self {
        let number = |at: usize| {
            let mut field = [0; 8];
            field.copy_from_slice(&bytes[at..at + 8]);
            u64::from_be_bytes(field)
        };
        Self {
            version: u16::from_be_bytes([bytes[0], bytes[1]]),
            kind: read_name(&bytes[2..14]),
            device: read_name(&bytes[14..34]),
            time: Timestamp(number(34)),
            length: number(42),
            checksum: number(50),
        }
    }

    /// The bytes; names must not be longer than their fields.
    pub fn write(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(HEADER);
        bytes.extend(self.version.to_be_bytes());
        write_name::<KIND>(&self.kind, &mut bytes);
        write_name::<NAME>(&self.device, &mut bytes);
        for number in [self.time.0, self.length, self.checksum] {
            bytes.extend(number.to_be_bytes());
        }
        bytes
    }
}

/// A text in a field: up to the first NUL, without blanks at its end. What is not UTF-8 is replaced.
pub(crate) fn read_name(field: &[u8]) -> String {
    let end = field.iter().position(|byte| *byte == 0);
    let text = String::from_utf8_lossy(&field[..end.unwrap_or(field.len())]);
    text.trim_end().to_owned()
}

/// A text in a field of `N` bytes, filled with NUL; it must not be longer.
pub(crate) fn write_name<const N: usize>(name: &str, bytes: &mut Vec<u8>) {
    let mut field = [0; N];
    field[..name.len()].copy_from_slice(name.as_bytes());
    bytes.extend(field);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The check value of CRC-64/ECMA-182 in the catalogue of parametrised CRC algorithms (Cook).
    #[test]
    fn the_checksum_is_that_of_the_catalogue() {
        assert_eq!(CHECKSUM.checksum(b"123456789"), 0x6C40_DF5F_0B49_7347);
        assert_eq!(CHECKSUM.checksum(b""), 0);
    }

    /// By hand: three quarters of a second are 0xC000_0000 units; a unit is 0.23 ns, so that nanoseconds come back.
    #[test]
    fn times_are_nanoseconds_and_back() {
        let time = Timestamp(5 << 32 | 0xC000_0000);
        assert_eq!(time.nanoseconds(), Some(5_750_000_000));
        assert_eq!(Timestamp::from_nanoseconds(5_750_000_000), time);
        assert_eq!(Timestamp::default().nanoseconds(), None);
        for nanoseconds in [1, 999_999_999, 1_767_323_045_123_456_789] {
            let back = Timestamp::from_nanoseconds(nanoseconds).nanoseconds();
            assert_eq!(back, Some(nanoseconds));
        }
        // The C++ library rounds down: a quarter of a unit is lost, no nanosecond.
        assert_eq!(
            Timestamp(5 << 32 | 0xBFFF_FFFF).nanoseconds(),
            time.nanoseconds()
        );
        assert_eq!(Timestamp::from_nanoseconds(u64::MAX), Timestamp(u64::MAX));
    }

    #[test]
    fn names_may_fill_their_field_or_end_in_blanks() {
        assert_eq!(read_name(b"ABCDEFGHIJKLMNOPQRST"), "ABCDEFGHIJKLMNOPQRST");
        assert_eq!(read_name(b"left  \0rest of memory"), "left");
        assert_eq!(read_name(&[0xFF; 2]), "\u{FFFD}\u{FFFD}");
    }
}
