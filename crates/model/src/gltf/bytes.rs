//! The bytes of a glTF file: its container, its buffers, and numbers in them.

use super::Files;
use super::document::{Accessor, Document, View};
use crate::error::{Flaw, ModelError, flawed};
use crate::mesh::{MAX_BYTES, MAX_CORNERS};
use crate::numbers::four;
use std::borrow::Cow;

const MAGIC: &[u8] = b"glTF";
const HEADER: usize = 12;

/// The JSON of a file, and the bytes behind it in a binary one.
pub(super) fn container(bytes: &[u8]) -> Result<(Document, Option<&[u8]>), ModelError> {
    if !bytes.starts_with(MAGIC) {
        return Ok((parsed(bytes)?, None));
    }
    let word = |at| four(bytes, at).map(u32::from_le_bytes);
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return flawed(Flaw::Truncated, "a header that ends too early");
    };
    if version != 2 {
        return flawed(
            Flaw::NotRead,
            format!("version {version} of the container; 2 is read"),
        );
    }
    let (length, found) = (length as usize, bytes.len());
    if found != length {
        let flaw = if found < length {
            Flaw::Truncated
        } else {
            Flaw::Broken
        };
        return flawed(flaw, format!("{found} bytes; its header states {length}"));
    }
    let (mut document, mut binary) = (None, None);
    let mut at = HEADER;
    while at < length {
        let (Some(size), Some(kind)) = (word(at), four(bytes, at + 4)) else {
            return flawed(Flaw::Truncated, "a chunk that ends too early");
        };
        let Some(chunk) = bytes[at + 8..].get(..size as usize) else {
            return flawed(
                Flaw::Truncated,
                format!("a chunk of {size} bytes that ends too early"),
            );
        };
        match &kind {
            b"JSON" if document.is_none() => document = Some(parsed(chunk)?),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            // Others may follow, and are left out.
            _ => {}
        }
        at += 8 + size as usize;
    }
    match document {
        Some(document) => Ok((document, binary)),
        None => flawed(Flaw::Broken, "a container without JSON"),
    }
}

fn parsed(bytes: &[u8]) -> Result<Document, ModelError> {
    let document: Document = serde_json::from_slice(bytes).map_err(|error| {
        let flaw = match error.classify() {
            serde_json::error::Category::Eof => Flaw::Truncated,
            _ => Flaw::Broken,
        };
        ModelError::new(flaw, format!("JSON that is no glTF: {error}"))
    })?;
    let is_2 = |version: &str| version == "2" || version.starts_with("2.");
    let version = &document.asset.version;
    let least = document.asset.min_version.as_deref().unwrap_or("2.0");
    match is_2(version) && least == "2.0" {
        true => Ok(document),
        false => flawed(
            Flaw::NotRead,
            format!("version {version} of glTF, readable from {least} on; 2.0 is read"),
        ),
    }
}

/// Where bytes that a URI names are.
pub(super) enum Source {
    /// In the URI.
    Within(Vec<u8>),
    /// In a file of this name in the same folder.
    File(String),
}

pub(super) fn source(uri: &str) -> Result<Source, ModelError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, digits)) = data.split_once(";base64,") else {
            return flawed(Flaw::NotRead, "embedded data that are not in base64");
        };
        return Ok(Source::Within(base64(digits)?));
    }
    let plain = |c: char| c.is_ascii_alphanumeric() || "._- ".contains(c);
    match uri.chars().all(plain) && !uri.starts_with('.') && !uri.is_empty() {
        true => Ok(Source::File(uri.to_owned())),
        false => {
            let uri: String = uri.chars().take(80).collect();
            flawed(
                Flaw::OutsideFolder,
                format!(
                    "the file `{uri}`; a model names files of its own folder, by letters, digits, dots, dashes and blanks"
                ),
            )
        }
    }
}

fn base64(digits: &str) -> Result<Vec<u8>, ModelError> {
    let mut bytes = Vec::with_capacity(digits.len() / 4 * 3);
    let (mut bits, mut held) = (0_u32, 0);
    for digit in digits.trim_end_matches('=').bytes() {
        let value = match digit {
            b'A'..=b'Z' => digit - b'A',
            b'a'..=b'z' => digit - b'a' + 26,
            b'0'..=b'9' => digit - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => {
                return flawed(
                    Flaw::Broken,
                    "embedded data with what is no digit of base64",
                );
            }
        };
        bits = bits << 6 | u32::from(value);
        held += 6;
        if held >= 8 {
            held -= 8;
            bytes.push((bits >> held) as u8);
        }
    }
    Ok(bytes)
}

/// The buffers of a file.
pub(super) struct Buffers<'a>(Vec<Cow<'a, [u8]>>);

impl<'a> Buffers<'a> {
    pub fn new(
        document: &Document,
        binary: Option<&'a [u8]>,
        file: Files<'_, 'a>,
    ) -> Result<Self, ModelError> {
        let mut buffers = Vec::new();
        for (index, buffer) in document.buffers.iter().enumerate() {
            let bytes: Cow<'a, [u8]> = match &buffer.uri {
                Some(uri) => match source(uri)? {
                    Source::Within(bytes) => bytes.into(),
                    Source::File(name) => match file(&name) {
                        Some(bytes) if bytes.len() > MAX_BYTES => {
                            return flawed(
                                Flaw::TooLarge,
                                format!(
                                    "`{name}` has {} bytes; at most {MAX_BYTES} are read",
                                    bytes.len()
                                ),
                            );
                        }
                        Some(bytes) => bytes.into(),
                        None => {
                            return flawed(
                                Flaw::Missing,
                                format!("the file `{name}`, which is not there"),
                            );
                        }
                    },
                },
                None => match binary.filter(|_| index == 0) {
                    Some(bytes) => bytes.into(),
                    None => return flawed(Flaw::Missing, format!("buffer {index} without bytes")),
                },
            };
            if bytes.len() < buffer.byte_length {
                return flawed(
                    Flaw::Truncated,
                    format!(
                        "buffer {index} of {} bytes, of which {} are there",
                        buffer.byte_length,
                        bytes.len()
                    ),
                );
            }
            buffers.push(bytes);
        }
        Ok(Self(buffers))
    }

    /// The bytes of a view.
    pub fn view(&self, view: &View) -> Result<&[u8], ModelError> {
        let Some(buffer) = self.0.get(view.buffer) else {
            return flawed(
                Flaw::NoSuchIndex,
                format!("buffer {} of {}", view.buffer, self.0.len()),
            );
        };
        let end = view.byte_offset.checked_add(view.byte_length);
        match end.and_then(|end| buffer.get(view.byte_offset..end)) {
            Some(bytes) => Ok(bytes),
            None => flawed(
                Flaw::NoSuchIndex,
                format!(
                    "bytes {} and {} on of a buffer of {}",
                    view.byte_offset,
                    view.byte_length,
                    buffer.len()
                ),
            ),
        }
    }

    /// The elements of an accessor, each of `width` components, as `component` reads them.
    fn elements<T>(
        &self,
        document: &Document,
        accessor: &Accessor,
        width: usize,
        mut each: impl FnMut(Component, &[u8]) -> T,
    ) -> Result<Vec<T>, ModelError> {
        let kind = match width {
            1 => "SCALAR",
            2 => "VEC2",
            _ => "VEC3",
        };
        if accessor.kind != kind {
            return flawed(Flaw::Broken, format!("an accessor that is no {kind}"));
        }
        let Some(component) = Component::of(accessor) else {
            return flawed(
                Flaw::Broken,
                format!("an accessor of component type {}", accessor.component_type),
            );
        };
        if accessor.sparse.is_some() {
            return flawed(Flaw::NotRead, "sparse data");
        }
        if accessor.count > MAX_CORNERS {
            return flawed(
                Flaw::TooLarge,
                format!(
                    "{} elements; at most {MAX_CORNERS} are read",
                    accessor.count
                ),
            );
        }
        let Some(view) = accessor.buffer_view else {
            return flawed(Flaw::NotRead, "an accessor without data");
        };
        let view = document.view(view)?;
        let bytes = self.view(view)?;
        let size = width * component.size();
        let stride = view.byte_stride.unwrap_or(size).max(size);
        let element = |index: usize| {
            let at = stride
                .checked_mul(index)?
                .checked_add(accessor.byte_offset)?;
            bytes.get(at..at.checked_add(size)?)
        };
        let mut found = Vec::with_capacity(accessor.count.min(bytes.len()));
        for index in 0..accessor.count {
            match element(index) {
                Some(bytes) => found.push(each(component, bytes)),
                None => {
                    return flawed(
                        Flaw::NoSuchIndex,
                        format!(
                            "element {index} of {}, behind the {} bytes of its view",
                            accessor.count,
                            bytes.len()
                        ),
                    );
                }
            }
        }
        Ok(found)
    }

    /// Vectors of N numbers.
    pub fn vectors<const N: usize>(
        &self,
        document: &Document,
        accessor: usize,
    ) -> Result<Vec<[f32; N]>, ModelError> {
        let accessor = document.accessor(accessor)?;
        if accessor.component_type != FLOAT && !accessor.normalized {
            return flawed(Flaw::Broken, "vectors of whole numbers");
        }
        self.elements(document, accessor, N, |component, bytes| {
            let mut vector = [0.0; N];
            for (value, bytes) in vector.iter_mut().zip(bytes.chunks_exact(component.size())) {
                *value = component.float(bytes);
            }
            vector
        })
    }

    /// Indices of vertices.
    pub fn indices(&self, document: &Document, accessor: usize) -> Result<Vec<u32>, ModelError> {
        let accessor = document.accessor(accessor)?;
        if accessor.component_type == FLOAT {
            return flawed(Flaw::Broken, "indices that are no whole numbers");
        }
        self.elements(document, accessor, 1, Component::whole)
    }
}

const FLOAT: u32 = 5126;

/// Kinds of numbers.
#[derive(Clone, Copy)]
enum Component {
    Byte,
    Short,
    Int,
    Float,
}

impl Component {
    fn of(accessor: &Accessor) -> Option<Self> {
        match accessor.component_type {
            5121 => Some(Self::Byte),
            5123 => Some(Self::Short),
            5125 => Some(Self::Int),
            FLOAT => Some(Self::Float),
            _ => None,
        }
    }

    fn size(self) -> usize {
        match self {
            Self::Byte => 1,
            Self::Short => 2,
            Self::Int | Self::Float => 4,
        }
    }

    fn whole(self, bytes: &[u8]) -> u32 {
        let mut wide = [0; 4];
        wide[..bytes.len()].copy_from_slice(bytes);
        u32::from_le_bytes(wide)
    }

    /// Of whole numbers the part of the largest one.
    fn float(self, bytes: &[u8]) -> f32 {
        match self {
            Self::Float => f32::from_bits(self.whole(bytes)),
            Self::Byte => self.whole(bytes) as f32 / 255.0,
            Self::Short => self.whole(bytes) as f32 / 65_535.0,
            Self::Int => (f64::from(self.whole(bytes)) / f64::from(u32::MAX)) as f32,
        }
    }
}
