//! The numbers of an array: base64, lengths, zlib.

use super::document::{Array, Document, Source};
use crate::format::error::{FormatError, Place};
use crate::format::scalar::{Encoding, Numbers};
use crate::format::scanner::Scanner;
use flate2::read::ZlibDecoder;
use std::io::Read;

/// Largest ratio of deflate: 258 bytes from 2 bits.
const INFLATION: usize = 1032;

/// Decodes arrays; what all of them hold together is bounded by what the file can hold.
pub(super) struct Decoder<'a> {
    document: &'a Document<'a>,
    /// Bytes that may still come out.
    budget: usize,
}

impl<'a> Decoder<'a> {
    /// For a file of `length` bytes.
    pub(super) fn new(document: &'a Document<'a>, length: usize) -> Self {
        let budget = length.saturating_mul(if document.compressed { INFLATION } else { 1 });
        Self { document, budget }
    }

    /// All numbers of `array`.
    pub(super) fn numbers(&mut self, array: &Array<'_>) -> Result<Numbers, FormatError> {
        self.decode(array).map_err(|(found, expected)| {
            let name = if array.name.is_empty() {
                "Points"
            } else {
                &array.name
            };
            FormatError::new(Place::Array(name.to_owned()), found, expected)
        })
    }

    fn decode(&mut self, array: &Array<'_>) -> Result<Numbers, Problem> {
        let (encoded, base64) = match array.source {
            Source::Ascii(text) => return ascii(text, array),
            Source::Base64(text) => (text, true),
            Source::Appended(offset) => {
                let appended = self.document.appended.as_ref();
                let appended = appended
                    .ok_or_else(|| problem("an offset without appended data", "<AppendedData>"))?;
                let bytes = appended.bytes.get(offset..).ok_or_else(|| {
                    let found = format!(
                        "offset {offset}, behind the {} bytes of data",
                        appended.bytes.len()
                    );
                    (found, "an offset into the appended data".to_owned())
                })?;
                (bytes, appended.base64)
            }
        };
        let mut stream = Stream {
            rest: encoded,
            base64,
            held: Vec::new(),
        };
        let bytes = if self.document.compressed {
            self.inflate(&mut stream)?
        } else {
            let length = self.length(&mut stream)?;
            self.spend(length)?;
            stream.take(length)?
        };
        if !bytes.len().is_multiple_of(array.scalar.size()) {
            return Err((
                format!("{} bytes", bytes.len()),
                format!("numbers of {} bytes each", array.scalar.size()),
            ));
        }
        Ok(array.scalar.decode(&bytes, self.document.endian))
    }

    /// Blocks of zlib after their number, the size of a whole one, that of the last (0 if whole), and the compressed sizes.
    fn inflate(&mut self, stream: &mut Stream<'_>) -> Result<Vec<u8>, Problem> {
        let [blocks, whole, last] = [
            self.length(stream)?,
            self.length(stream)?,
            self.length(stream)?,
        ];
        if blocks > stream.rest.len() {
            let found = format!("{blocks} blocks in {} bytes", stream.rest.len());
            return Err((found, "blocks that fit into the file".to_owned()));
        }
        let sizes: Vec<usize> = (0..blocks)
            .map(|_| self.length(stream))
            .collect::<Result<_, _>>()?;
        let mut out = Vec::new();
        for (block, size) in sizes.into_iter().enumerate() {
            let compressed = stream.take(size)?;
            let expected = if block + 1 == blocks && last != 0 {
                last
            } else {
                whole
            };
            self.spend(expected)?;
            let before = out.len();
            let inflated = ZlibDecoder::new(compressed.as_slice())
                .take(expected as u64 + 1)
                .read_to_end(&mut out);
            let length = out.len() - before;
            match inflated {
                Ok(_) if length == expected => {}
                Ok(_) => {
                    let found = format!("{length} or more bytes in block {block}");
                    return Err((found, format!("{expected} bytes, as its header says")));
                }
                Err(error) => {
                    let found = format!("damaged data in block {block} ({error})");
                    return Err((found, "a zlib stream".to_owned()));
                }
            }
        }
        Ok(out)
    }

    /// A length of the header type.
    fn length(&self, stream: &mut Stream<'_>) -> Result<usize, Problem> {
        let header = self.document.header;
        let bytes = stream.take(header.size())?;
        // Lengths are unsigned, so the number is never negative; one too large for memory fails where it is used.
        Ok(header.whole(&bytes, self.document.endian) as usize)
    }

    fn spend(&mut self, bytes: usize) -> Result<(), Problem> {
        match self.budget.checked_sub(bytes) {
            Some(left) => {
                self.budget = left;
                Ok(())
            }
            None => Err((
                format!("a length of {bytes} bytes"),
                "arrays that fit into the file (is its byte order what byte_order says?)"
                    .to_owned(),
            )),
        }
    }
}

/// What was found and what was expected.
type Problem = (String, String);

fn problem(found: &str, expected: &str) -> Problem {
    (found.to_owned(), expected.to_owned())
}

fn ascii(text: &[u8], array: &Array<'_>) -> Result<Numbers, Problem> {
    let count = text
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
        .count();
    Scanner::new(text)
        .numbers(Encoding::Ascii, array.scalar, count, "numbers")
        .map_err(|error| {
            (
                error.found,
                format!("{} of type {:?}", error.expected, array.scalar),
            )
        })
}

/// Bytes as they stand or out of base64.
struct Stream<'a> {
    rest: &'a [u8],
    base64: bool,
    /// Decoded bytes of a group of four letters that were not asked for yet.
    held: Vec<u8>,
}

impl Stream<'_> {
    /// The next `length` bytes.
    fn take(&mut self, length: usize) -> Result<Vec<u8>, Problem> {
        let short = |found: usize| {
            (
                format!("the end of the data after {found} of {length} bytes"),
                "all of them (is the file whole, and its byte order what byte_order says?)"
                    .to_owned(),
            )
        };
        if !self.base64 {
            let Some((bytes, rest)) = self.rest.split_at_checked(length) else {
                return Err(short(self.rest.len()));
            };
            self.rest = rest;
            return Ok(bytes.to_vec());
        }
        let mut bytes = std::mem::take(&mut self.held);
        while bytes.len() < length {
            if !self.group(&mut bytes)? {
                return Err(short(bytes.len()));
            }
        }
        self.held = bytes.split_off(length);
        Ok(bytes)
    }

    /// Decodes four letters; false at the end. Padding ends a group, not the data: VTK encodes the lengths before compressed
    /// data apart from them, some writers always do.
    fn group(&mut self, bytes: &mut Vec<u8>) -> Result<bool, Problem> {
        let mut bits = 0u32;
        let mut letters = 0;
        let mut padding = 0;
        while letters + padding < 4 {
            let Some((&letter, rest)) = self.rest.split_first() else {
                return if letters + padding == 0 {
                    Ok(false)
                } else {
                    Err(problem(
                        "base64 that ends within a group",
                        "groups of four letters",
                    ))
                };
            };
            if letter == b'<' {
                self.rest = &[];
                continue;
            }
            self.rest = rest;
            let value = match letter {
                b'A'..=b'Z' => letter - b'A',
                b'a'..=b'z' => letter - b'a' + 26,
                b'0'..=b'9' => letter - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                b'=' if letters >= 2 => {
                    padding += 1;
                    continue;
                }
                _ if letter.is_ascii_whitespace() => continue,
                _ => return Err((format!("the byte {letter:02X}"), "base64".to_owned())),
            };
            if padding > 0 {
                return Err(problem("a letter after padding", "groups of four letters"));
            }
            bits = bits << 6 | u32::from(value);
            letters += 1;
        }
        bits <<= 6 * padding;
        let [_, a, b, c] = bits.to_be_bytes();
        bytes.extend_from_slice(&[a, b, c][..3 - padding]);
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stream(text: &[u8]) -> Stream<'_> {
        Stream {
            rest: text,
            base64: true,
            held: Vec::new(),
        }
    }

    /// The vectors of RFC 4648, section 10.
    #[test]
    fn base64_is_that_of_the_rfc() {
        let cases: [(&[u8], &[u8]); 6] = [
            (b"Zg==", b"f"),
            (b"Zm8=", b"fo"),
            (b"Zm9v", b"foo"),
            (b"Zm9vYg==", b"foob"),
            (b"Zm9vYmE=", b"fooba"),
            (b" Zm9v\nYmFy<", b"foobar"),
        ];
        for (text, bytes) in cases {
            assert_eq!(stream(text).take(bytes.len()).unwrap(), bytes);
            assert!(stream(text).take(bytes.len() + 1).is_err());
        }
        // "fo" and "bar" encoded apart, asked for in other portions.
        let mut apart = stream(b"Zm8=YmFy");
        assert_eq!(apart.take(1).unwrap(), b"f");
        assert_eq!(apart.take(3).unwrap(), b"oba");
        assert_eq!(apart.take(1).unwrap(), b"r");
        for damaged in [&b"Zm9"[..], b"Z=9v", b"Zm=v", b"Zm-v"] {
            assert!(stream(damaged).take(3).is_err());
        }
    }
}
