//! Gmsh `.msh`, versions 2.x and 4.1 (Gmsh reference manual, "MSH file format" and "MSH file format version 2").

mod element_data;
mod elements;
mod version_2;
mod version_4;
mod write;

pub use write::write_gmsh_2;

use super::Import;
use super::assemble::Parts;
use super::error::FormatError;
use super::scalar::{Encoding, Endian, Scalar};
use super::scanner::{Scanner, quoted};
use crate::FAMILIES;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// A vector for each element, by its number in the file.
type Numbered = Vec<(i64, Vector3<f64>)>;

/// What both versions have in common while they are read.
struct Reader<'a> {
    scanner: Scanner<'a>,
    encoding: Encoding,
    /// Type of counts and numbers ("size_t") in version 4.1.
    size: Scalar,
    /// Index of each node by its number in the file.
    nodes: BTreeMap<i64, u32>,
    /// Number of each tetrahedron in the file.
    tet_numbers: Vec<i64>,
    /// Fibre directions of each family by the numbers of the elements, and the rank of their name.
    directions: [Option<(usize, Numbered)>; FAMILIES],
    parts: Parts,
}

/// The mesh in `file`.
pub(super) fn read(file: &[u8]) -> Result<Import, FormatError> {
    let mut scanner = Scanner::new(file);
    while scanner.peek() == Some(b"$Comments") {
        scanner.word();
        scanner.skip_past("$EndComments")?;
    }
    scanner.keyword("$MeshFormat")?;
    let version = scanner.required_word("the version of the format")?;
    let version_error = scanner.error(
        format!("version {}", quoted(version)),
        "version 2.2 or 4.1: write the mesh again with Gmsh in one of them",
    );
    let file_type: i64 = scanner.number("0 for ASCII or 1 for binary")?;
    if !(0..=1).contains(&file_type) {
        return Err(scanner.error(format!("{file_type}"), "0 for ASCII or 1 for binary"));
    }
    let size = match scanner.number("the size of numbers, 4 or 8")? {
        4 => Scalar::U32,
        8 => Scalar::U64,
        other => return Err(scanner.error(format!("{other}"), "the size of numbers, 4 or 8")),
    };
    let encoding = if file_type == 0 {
        Encoding::Ascii
    } else {
        Encoding::Binary(byte_order(&mut scanner)?)
    };
    scanner.keyword("$EndMeshFormat")?;

    let mut reader = Reader {
        scanner,
        encoding,
        size,
        nodes: BTreeMap::new(),
        tet_numbers: Vec::new(),
        directions: Default::default(),
        parts: Parts::default(),
    };
    match version {
        b"2" | b"2.0" | b"2.1" | b"2.2" => version_2::read(&mut reader)?,
        b"4.1" => version_4::read(&mut reader)?,
        _ => return Err(version_error),
    }
    reader.set_directions();
    reader.parts.finish()
}

/// The byte order of a binary file: it holds the number 1 in it.
fn byte_order(scanner: &mut Scanner<'_>) -> Result<Endian, FormatError> {
    scanner.line();
    scanner.places_are_bytes();
    let expected = "the number 1 in either byte order, which tells that of the file";
    match scanner.take(4, expected)? {
        [1, 0, 0, 0] => Ok(Endian::Little),
        [0, 0, 0, 1] => Ok(Endian::Big),
        other => Err(scanner.error(format!("the bytes {other:02X?}"), expected)),
    }
}

impl<'a> Reader<'a> {
    /// Reads section after section with `section`, which returns whether it knows the one it is given; others are skipped.
    fn sections(
        &mut self,
        mut section: impl FnMut(&mut Self, &str) -> Result<bool, FormatError>,
    ) -> Result<(), FormatError> {
        let mut elements = false;
        while let Some(word) = self.scanner.word() {
            let name = match word.strip_prefix(b"$").map(std::str::from_utf8) {
                Some(Ok(name)) if !name.is_empty() && !name.starts_with("End") => name,
                _ => {
                    return Err(self
                        .scanner
                        .error(quoted(word), "a section ($Nodes, $Elements, …)"));
                }
            };
            if self.encoding != Encoding::Ascii {
                // Binary data begin after the end of the line.
                self.scanner.line();
            }
            elements |= name == "Elements";
            if name == "Elements" && self.parts.positions.is_empty() {
                return Err(self
                    .scanner
                    .error("$Elements without nodes", "$Nodes before it"));
            }
            if name == "PhysicalNames" {
                self.physical_names()?;
            } else if name == "ElementData" {
                self.element_data()?;
            } else if section(self, name)? {
                self.scanner.keyword(&format!("$End{name}"))?;
            } else {
                self.scanner.skip_past(&format!("$End{name}"))?;
            }
        }
        if elements {
            Ok(())
        } else {
            Err(self.scanner.ended("$Elements"))
        }
    }

    /// A number that is `int` in C.
    fn int(&mut self, expected: &str) -> Result<i64, FormatError> {
        self.scanner.whole(self.encoding, Scalar::I32, expected)
    }

    /// A number that is `size_t` in C.
    fn size(&mut self, expected: &str) -> Result<i64, FormatError> {
        self.scanner.whole(self.encoding, self.size, expected)
    }

    /// A count that stands in decimals in either encoding, as in version 2; in a binary file the data follow its line.
    fn decimal_count(&mut self, bytes_each: usize, what: &str) -> Result<usize, FormatError> {
        let count = self.scanner.number(&format!("the number of {what}"))?;
        let count = self.scanner.check_count(count, bytes_each, what)?;
        if self.encoding != Encoding::Ascii {
            self.scanner.line();
        }
        Ok(count)
    }

    /// The least number of bytes that `values` numbers take: a digit and a space each, or `binary` together.
    fn least_bytes(&self, values: usize, binary: usize) -> usize {
        match self.encoding {
            Encoding::Ascii => 2 * values,
            Encoding::Binary(_) => binary,
        }
    }

    /// Three coordinates.
    fn position(&mut self) -> Result<Vector3<f64>, FormatError> {
        let mut position = Vector3::zeros();
        for axis in 0..3 {
            position[axis] = self.scanner.coordinate(self.encoding, Scalar::F64)?;
        }
        Ok(position)
    }

    /// Gives node number `tag` the next index.
    fn number_node(&mut self, tag: i64) -> Result<(), FormatError> {
        let index = self.nodes.len() as u32;
        match self.nodes.insert(tag, index) {
            None => Ok(()),
            Some(_) => Err(self.scanner.error(
                format!("node number {tag} a second time"),
                "every node number once",
            )),
        }
    }

    /// The index of the node whose number comes next, read by `next`.
    fn node(
        &mut self,
        next: impl FnOnce(&mut Self) -> Result<i64, FormatError>,
    ) -> Result<u32, FormatError> {
        let tag = next(self)?;
        self.nodes.get(&tag).copied().ok_or_else(|| {
            self.scanner.error(
                format!("node number {tag}"),
                "the number of one of the nodes in $Nodes",
            )
        })
    }

    /// Number of nodes and name of `element_type`, which was just read, if it is one that can be passed over or taken.
    fn known_type(&self, element_type: i64) -> Result<(usize, &'static str), FormatError> {
        match elements::element_type(element_type) {
            Some((_, elements::CURVED)) => Err(self.scanner.error(
                format!("tetrahedra of second or higher order (type {element_type})"),
                "linear tetrahedra: mesh again with elements of order 1 (Gmsh: -order 1)",
            )),
            Some(known) => Ok(known),
            None => Err(self.scanner.error(
                format!("element type {element_type}"),
                "one of Gmsh's element types up to 31",
            )),
        }
    }

    /// The region of physical group `group`; a negative one is the same group on a reversed entity.
    fn region(&self, group: i64) -> Result<u32, FormatError> {
        u32::try_from(group.unsigned_abs()).map_err(|_| {
            self.scanner.error(
                format!("physical group {group}"),
                "a number of at most 32 bits",
            )
        })
    }

    /// Notes the names of the groups of volumes: they name the regions.
    fn physical_names(&mut self) -> Result<(), FormatError> {
        let count = self.scanner.number("the number of names")?;
        let count = self.scanner.check_count(count, 5, "names")?;
        for _ in 0..count {
            let dimension: i64 = self.scanner.number("the dimension of a group")?;
            let tag: i64 = self.scanner.number("the number of a group")?;
            let name = self.scanner.line().unwrap_or_default().trim_ascii();
            let name = name.strip_prefix(b"\"").unwrap_or(name);
            let name = name.strip_suffix(b"\"").unwrap_or(name);
            if dimension == 3 {
                self.parts
                    .notes
                    .push(format!("the file calls region {tag} {}", quoted(name)));
            }
        }
        self.scanner.keyword("$EndPhysicalNames")
    }
}
