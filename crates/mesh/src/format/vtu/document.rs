//! The XML around the arrays.

use crate::format::error::{FormatError, Place};
use crate::format::scalar::{Endian, Scalar};
use crate::format::scanner::quoted;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

/// What a file declares about its arrays.
pub(super) struct Document<'a> {
    /// Byte order of binary data.
    pub(super) endian: Endian,
    /// Type of the lengths before binary data.
    pub(super) header: Scalar,
    /// Whether binary data are compressed with zlib.
    pub(super) compressed: bool,
    /// The parts of the grid.
    pub(super) pieces: Vec<Piece<'a>>,
    /// The data after the underscore, to which offsets refer.
    pub(super) appended: Option<Appended<'a>>,
}

/// Data at the end of the file.
pub(super) struct Appended<'a> {
    /// From the first byte after the underscore to the end of the file.
    pub(super) bytes: &'a [u8],
    /// Whether they are base64, else raw.
    pub(super) base64: bool,
}

/// A part of the grid.
#[derive(Default)]
pub(super) struct Piece<'a> {
    /// NumberOfPoints.
    pub(super) point_count: usize,
    /// NumberOfCells.
    pub(super) cell_count: usize,
    pub(super) points: Option<Array<'a>>,
    pub(super) connectivity: Option<Array<'a>>,
    pub(super) offsets: Option<Array<'a>>,
    pub(super) types: Option<Array<'a>>,
    /// All of them.
    pub(super) cell_data: Vec<Array<'a>>,
}

/// A DataArray.
pub(super) struct Array<'a> {
    pub(super) name: String,
    pub(super) scalar: Scalar,
    pub(super) components: usize,
    pub(super) source: Source<'a>,
}

/// Where the numbers of an array stand.
#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    /// In the element, in decimals.
    Ascii(&'a [u8]),
    /// In the element, in base64.
    Base64(&'a [u8]),
    /// That many bytes into the appended data.
    Appended(usize),
}

/// The group of arrays that is being read.
#[derive(Clone, Copy, PartialEq)]
enum Group {
    Points,
    Cells,
    CellData,
    Other,
}

impl<'a> Document<'a> {
    pub(super) fn parse(file: &'a [u8]) -> Result<Self, FormatError> {
        let mut xml = Xml {
            file,
            reader: Reader::from_reader(file),
        };
        let root = loop {
            match xml.event()? {
                Event::Start(root) => break root,
                Event::Eof => return Err(xml.error("no XML element", "<VTKFile>")),
                _ => {}
            }
        };
        let mut document = xml.root(&root)?;
        // Raw data are not XML, so the end is looked for where it stands.
        if !file.trim_ascii_end().ends_with(b"</VTKFile>") {
            let found = "a file that ends before </VTKFile>";
            return Err(FormatError::new(
                Place::Byte(file.len()),
                found,
                "the whole file",
            ));
        }

        let mut group = Group::Other;
        loop {
            let event = xml.event()?;
            match &event {
                Event::Start(element) | Event::Empty(element) => match element.name().as_ref() {
                    "Piece" => document.pieces.push(Piece {
                        point_count: xml.count(element, "NumberOfPoints")?,
                        cell_count: xml.count(element, "NumberOfCells")?,
                        ..Piece::default()
                    }),
                    "Points" => group = Group::Points,
                    "Cells" => group = Group::Cells,
                    "CellData" => group = Group::CellData,
                    "PointData" | "FieldData" => group = Group::Other,
                    "DataArray" if group != Group::Other => {
                        let empty = matches!(event, Event::Empty(_));
                        let array = xml.array(element, empty)?;
                        let piece = document.pieces.last_mut();
                        let piece = piece.ok_or_else(|| {
                            xml.error("an array outside a piece", "<Piece> around it")
                        })?;
                        piece.take(group, array);
                    }
                    "AppendedData" => {
                        document.appended = Some(xml.appended(element)?);
                        break;
                    }
                    _ => {}
                },
                Event::Eof => break,
                _ => {}
            }
        }
        if document.pieces.is_empty() {
            return Err(FormatError::new(
                Place::File,
                "no piece",
                "<UnstructuredGrid> with a <Piece>",
            ));
        }
        Ok(document)
    }
}

impl<'a> Piece<'a> {
    fn take(&mut self, group: Group, array: Array<'a>) {
        let slot = match (group, array.name.as_str()) {
            (Group::Points, _) => &mut self.points,
            (Group::Cells, "connectivity") => &mut self.connectivity,
            (Group::Cells, "offsets") => &mut self.offsets,
            (Group::Cells, "types") => &mut self.types,
            (Group::CellData, _) => return self.cell_data.push(array),
            // Faces of polyhedra, which are left out as cells.
            _ => return,
        };
        *slot = Some(array);
    }
}

/// The reader, with errors that name the place.
struct Xml<'a> {
    file: &'a [u8],
    reader: Reader<&'a [u8]>,
}

impl<'a> Xml<'a> {
    fn position(&self) -> usize {
        (self.reader.buffer_position() as usize).min(self.file.len())
    }

    fn error(&self, found: impl Into<String>, expected: impl Into<String>) -> FormatError {
        let before = &self.file[..self.position()];
        let line = 1 + before.iter().filter(|&&b| b == b'\n').count();
        FormatError::new(Place::Line(line), found, expected)
    }

    fn event(&mut self) -> Result<Event<'a>, FormatError> {
        self.reader.read_event().map_err(|error| {
            self.error(
                format!("XML that cannot be read ({error})"),
                "well-formed XML",
            )
        })
    }

    fn attribute(
        &self,
        element: &BytesStart<'_>,
        name: &str,
    ) -> Result<Option<String>, FormatError> {
        let unreadable =
            |error: String| self.error(format!("attributes that cannot be read ({error})"), name);
        match element.try_get_attribute(name) {
            Ok(None) => Ok(None),
            Ok(Some(attribute)) => match attribute.normalized_value(XmlVersion::Explicit1_0) {
                Ok(value) => Ok(Some(value.into_owned())),
                Err(error) => Err(unreadable(error.to_string())),
            },
            Err(error) => Err(unreadable(error.to_string())),
        }
    }

    /// The number in an attribute that must be there.
    fn count(&self, element: &BytesStart<'_>, name: &str) -> Result<usize, FormatError> {
        let value = self.attribute(element, name)?.unwrap_or_default();
        value
            .trim()
            .parse()
            .map_err(|_| self.error(quoted(value.as_bytes()), format!("a number as {name}")))
    }

    fn root(&self, root: &BytesStart<'_>) -> Result<Document<'a>, FormatError> {
        if root.name().as_ref() != "VTKFile" {
            return Err(self.error(quoted(root.name().as_ref().as_bytes()), "<VTKFile>"));
        }
        let attribute = |name| Ok(self.attribute(root, name)?.unwrap_or_default());
        let kind = attribute("type")?;
        if kind != "UnstructuredGrid" {
            return Err(self.error(
                format!("data of type {}", quoted(kind.as_bytes())),
                "UnstructuredGrid",
            ));
        }
        let endian = match attribute("byte_order")?.as_str() {
            "LittleEndian" | "" => Endian::Little,
            "BigEndian" => Endian::Big,
            other => return Err(self.error(quoted(other.as_bytes()), "LittleEndian or BigEndian")),
        };
        let header = match attribute("header_type")?.as_str() {
            "UInt32" | "" => Scalar::U32,
            "UInt64" => Scalar::U64,
            other => {
                return Err(self.error(quoted(other.as_bytes()), "header_type UInt32 or UInt64"));
            }
        };
        let compressed = match attribute("compressor")?.as_str() {
            "" => false,
            "vtkZLibDataCompressor" => true,
            other => {
                return Err(self.error(
                    format!("compressor {}", quoted(other.as_bytes())),
                    "vtkZLibDataCompressor or none: export again with zlib or uncompressed",
                ));
            }
        };
        Ok(Document {
            endian,
            header,
            compressed,
            pieces: Vec::new(),
            appended: None,
        })
    }

    /// A DataArray; `empty` elements have no content.
    fn array(&mut self, element: &BytesStart<'_>, empty: bool) -> Result<Array<'a>, FormatError> {
        let kind = self.attribute(element, "type")?.unwrap_or_default();
        let scalar = match kind.as_str() {
            "Int8" => Scalar::I8,
            "UInt8" => Scalar::U8,
            "Int16" => Scalar::I16,
            "UInt16" => Scalar::U16,
            "Int32" => Scalar::I32,
            "UInt32" => Scalar::U32,
            "Int64" => Scalar::I64,
            "UInt64" => Scalar::U64,
            "Float32" => Scalar::F32,
            "Float64" => Scalar::F64,
            other => {
                return Err(self.error(
                    quoted(other.as_bytes()),
                    "a number type (Float64, Int32, …)",
                ));
            }
        };
        let components = match self.attribute(element, "NumberOfComponents")?.as_deref() {
            None | Some("") => 1,
            Some(_) => self.count(element, "NumberOfComponents")?,
        };
        let name = self.attribute(element, "Name")?.unwrap_or_default();
        let format = self.attribute(element, "format")?.unwrap_or_default();
        let source = match format.as_str() {
            "appended" => Source::Appended(self.count(element, "offset")?),
            "ascii" | "" => Source::Ascii(self.content(empty)?),
            "binary" => Source::Base64(self.content(empty)?),
            other => {
                return Err(
                    self.error(quoted(other.as_bytes()), "format ascii, binary or appended")
                );
            }
        };
        Ok(Array {
            name,
            scalar,
            components,
            source,
        })
    }

    /// The text of the element that was just opened, up to the next mark-up.
    fn content(&mut self, empty: bool) -> Result<&'a [u8], FormatError> {
        if empty {
            return Ok(&[]);
        }
        let rest = &self.file[self.position()..];
        match rest.iter().position(|&b| b == b'<') {
            Some(length) => Ok(&rest[..length]),
            None => Err(self.error("the end of the file", "</DataArray>")),
        }
    }

    fn appended(&self, element: &BytesStart<'_>) -> Result<Appended<'a>, FormatError> {
        let base64 = match self.attribute(element, "encoding")?.as_deref() {
            Some("raw") => false,
            Some("base64") | None => true,
            Some(other) => {
                return Err(self.error(quoted(other.as_bytes()), "encoding raw or base64"));
            }
        };
        let rest = self.file[self.position()..].trim_ascii_start();
        match rest.strip_prefix(b"_") {
            Some(bytes) => Ok(Appended { bytes, base64 }),
            None => Err(self.error(
                quoted(&rest[..rest.len().min(8)]),
                "an underscore before the data",
            )),
        }
    }
}
