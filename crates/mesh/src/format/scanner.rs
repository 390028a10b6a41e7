//! A place in the bytes of a file: words, lines and binary numbers from there on.

use super::error::{FormatError, Place};
use super::scalar::{Encoding, Numbers, Scalar};
use std::str::FromStr;

/// Longest piece of a file that an error quotes \[characters\].
const QUOTED: usize = 40;

/// Reads a file from front to back.
#[derive(Clone)]
pub(super) struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Where the last item read begins: the place of an error.
    last: usize,
    /// Whether places are bytes, not lines.
    binary: bool,
}

impl<'a> Scanner<'a> {
    /// At the start of `bytes`.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            last: 0,
            binary: false,
        }
    }

    /// From here on places are bytes, since lines mean nothing in this file.
    pub(super) fn places_are_bytes(&mut self) {
        self.binary = true;
    }

    /// Number of bytes that follow.
    pub(super) fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// An error where the last item read begins.
    pub(super) fn error(
        &self,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> FormatError {
        let place = if self.binary {
            Place::Byte(self.last)
        } else {
            Place::Line(
                1 + self.bytes[..self.last]
                    .iter()
                    .filter(|&&b| b == b'\n')
                    .count(),
            )
        };
        FormatError::new(place, found, expected)
    }

    /// The next line without its end, or nothing at the end of the file.
    pub(super) fn line(&mut self) -> Option<&'a [u8]> {
        self.last = self.at;
        if self.remaining() == 0 {
            return None;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| b == b'\n');
        self.at += length.map_or(rest.len(), |length| length + 1);
        let line = &rest[..length.unwrap_or(rest.len())];
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    /// The next word, or nothing if only white space follows.
    pub(super) fn word(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace());
        self.last = self.at + start.unwrap_or(rest.len());
        let word = &rest[start?..];
        let length = word.iter().position(u8::is_ascii_whitespace);
        let word = &word[..length.unwrap_or(word.len())];
        self.at = self.last + word.len();
        Some(word)
    }

    /// The next word without moving past it.
    pub(super) fn peek(&self) -> Option<&'a [u8]> {
        self.clone().word()
    }

    /// The next word, which must be there.
    pub(super) fn required_word(&mut self, expected: &str) -> Result<&'a [u8], FormatError> {
        self.word().ok_or_else(|| self.ended(expected))
    }

    /// The next word, which must be `word`.
    pub(super) fn keyword(&mut self, word: &str) -> Result<(), FormatError> {
        let found = self.required_word(word)?;
        if found.eq_ignore_ascii_case(word.as_bytes()) {
            Ok(())
        } else {
            Err(self.error(quoted(found), word))
        }
    }

    /// The next word as a number.
    pub(super) fn number<T: FromStr>(&mut self, expected: &str) -> Result<T, FormatError> {
        let word = self.required_word(expected)?;
        std::str::from_utf8(word)
            .ok()
            .and_then(|text| text.parse().ok())
            .ok_or_else(|| self.error(quoted(word), expected))
    }

    /// The next `length` bytes.
    pub(super) fn take(&mut self, length: usize, expected: &str) -> Result<&'a [u8], FormatError> {
        self.last = self.at;
        if length > self.remaining() {
            let found = format!("only {} bytes more", self.remaining());
            return Err(self.error(found, format!("{length} bytes: {expected}")));
        }
        self.at += length;
        Ok(&self.bytes[self.last..self.at])
    }

    /// A whole number stored as `scalar`.
    pub(super) fn whole(
        &mut self,
        encoding: Encoding,
        scalar: Scalar,
        expected: &str,
    ) -> Result<i64, FormatError> {
        match encoding {
            Encoding::Ascii => self.number(expected),
            Encoding::Binary(endian) => {
                Ok(scalar.whole(self.take(scalar.size(), expected)?, endian))
            }
        }
    }

    /// A finite number stored as `scalar`.
    pub(super) fn coordinate(
        &mut self,
        encoding: Encoding,
        scalar: Scalar,
    ) -> Result<f64, FormatError> {
        let value: f64 = match encoding {
            Encoding::Ascii => self.number("a coordinate")?,
            Encoding::Binary(endian) => {
                scalar.real(self.take(scalar.size(), "a coordinate")?, endian)
            }
        };
        if value.is_finite() {
            Ok(value)
        } else {
            Err(self.error(format!("{value}"), "a finite coordinate"))
        }
    }

    /// `count` numbers stored as `scalar`.
    pub(super) fn numbers(
        &mut self,
        encoding: Encoding,
        scalar: Scalar,
        count: usize,
        expected: &str,
    ) -> Result<Numbers, FormatError> {
        match encoding {
            Encoding::Ascii => {
                self.check_count(count as i64, 1, expected)?;
                if scalar.is_real() {
                    let values: Result<_, _> = (0..count).map(|_| self.number(expected)).collect();
                    values.map(Numbers::Real)
                } else {
                    let values: Result<_, _> = (0..count).map(|_| self.number(expected)).collect();
                    values.map(Numbers::Whole)
                }
            }
            Encoding::Binary(endian) => {
                let length = count.saturating_mul(scalar.size());
                Ok(scalar.decode(self.take(length, expected)?, endian))
            }
        }
    }

    /// A count just read, if that many items of at least `bytes_each` bytes can follow: what is allocated for them is then
    /// bounded by the file.
    pub(super) fn check_count(
        &self,
        count: i64,
        bytes_each: usize,
        what: &str,
    ) -> Result<usize, FormatError> {
        let most = self.remaining() / bytes_each;
        match usize::try_from(count) {
            Ok(count) if count <= most && count <= u32::MAX as usize => Ok(count),
            _ => Err(self.error(
                format!(
                    "the number {count}, with {} bytes to follow",
                    self.remaining()
                ),
                format!("a number of {what} that fits into the file"),
            )),
        }
    }

    /// Moves past the line `end`, wherever it is.
    pub(super) fn skip_past(&mut self, end: &str) -> Result<(), FormatError> {
        let found = self.bytes[self.at..]
            .windows(end.len())
            .position(|window| window == end.as_bytes());
        match found {
            Some(offset) => {
                self.at += offset + end.len();
                Ok(())
            }
            None => Err(self.error("no end of this section", end)),
        }
    }

    /// An error at the end of the file.
    pub(super) fn ended(&self, expected: &str) -> FormatError {
        self.error("the end of the file", expected)
    }
}

/// `bytes` as an error shows them.
pub(super) fn quoted(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(4 * QUOTED)]);
    let short: String = text
        .chars()
        .take(QUOTED)
        .flat_map(char::escape_debug)
        .collect();
    format!("\"{short}\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_lines_and_places() {
        let mut scanner = Scanner::new(b"a  b\r\n\n c\nrest");
        assert_eq!(scanner.word(), Some(&b"a"[..]));
        assert_eq!(scanner.peek(), Some(&b"b"[..]));
        assert_eq!(scanner.line(), Some(&b"  b"[..]));
        assert_eq!(scanner.word(), Some(&b"c"[..]));
        assert_eq!(scanner.error("", "").place, Place::Line(3));
        assert_eq!(scanner.line(), Some(&b""[..]));
        assert_eq!(scanner.line(), Some(&b"rest"[..]));
        assert_eq!(scanner.line(), None);
        assert_eq!(scanner.word(), None);
        assert_eq!(scanner.error("", "").place, Place::Line(4));
    }

    #[test]
    fn counts_are_bounded_by_the_bytes_that_follow() {
        let scanner = Scanner::new(b"12345678");
        assert_eq!(scanner.check_count(2, 4, "things"), Ok(2));
        for count in [3, -1, i64::MAX] {
            assert!(scanner.check_count(count, 4, "things").is_err());
        }
    }

    #[test]
    fn quotations_are_short_and_printable() {
        assert_eq!(quoted(b"a\x00\xFF"), "\"a\\0\u{FFFD}\"");
        assert_eq!(quoted(&[b'x'; 1000]).len(), QUOTED + 2);
    }
}
