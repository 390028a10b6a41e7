//! VTK legacy files (VTK user's guide, "Simple Legacy Formats"; version 5.1 as written by VTK 9).
//!
//! Binary data are big-endian by definition; the file cannot state otherwise, so a little-endian one is noticed by its
//! senseless counts.

use super::Import;
use super::assemble::{
    CellData, Parts, direction_values, family_and_rank, positions, region_rank, region_values,
};
use super::cells::Cells;
use super::error::{FormatError, Place};
use super::scalar::{Encoding, Endian, Numbers, Scalar};
use super::scanner::{Scanner, quoted};
use crate::FAMILIES;

/// The mesh in `file`.
pub(super) fn read(file: &[u8]) -> Result<Import, FormatError> {
    let mut scanner = Scanner::new(file);
    let first = scanner.line().unwrap_or_default();
    let version = first
        .strip_prefix(b"# vtk DataFile Version ")
        .and_then(|rest| std::str::from_utf8(rest).ok())
        .and_then(|rest| rest.trim().parse::<f64>().ok());
    let old_cells = match version {
        Some(version) if (1.0..5.0).contains(&version) => true,
        Some(version) if (5.0..6.0).contains(&version) => false,
        _ => {
            return Err(scanner.error(
                quoted(first),
                "\"# vtk DataFile Version \" and a version up to 5.1",
            ));
        }
    };
    scanner.line().ok_or_else(|| scanner.ended("a title"))?;
    let encoding = match scanner.required_word("ASCII or BINARY")? {
        word if word.eq_ignore_ascii_case(b"ASCII") => Encoding::Ascii,
        word if word.eq_ignore_ascii_case(b"BINARY") => Encoding::Binary(Endian::Big),
        word => return Err(scanner.error(quoted(word), "ASCII or BINARY")),
    };
    if encoding != Encoding::Ascii {
        scanner.places_are_bytes();
    }
    scanner.keyword("DATASET")?;
    scanner.keyword("UNSTRUCTURED_GRID")?;
    let mut reader = Reader {
        scanner,
        encoding,
        points: None,
        ends_and_connectivity: None,
        types: None,
        region: None,
        directions: Default::default(),
    };
    reader.sections(old_cells)?;
    reader.finish()
}

/// A file while it is read.
struct Reader<'a> {
    scanner: Scanner<'a>,
    encoding: Encoding,
    points: Option<Numbers>,
    ends_and_connectivity: Option<(Vec<i64>, Vec<i64>)>,
    types: Option<Vec<i64>>,
    /// The best region array so far: rank, name, values.
    region: Option<(usize, String, Numbers)>,
    /// The best array of fibre directions of each family so far.
    directions: [Option<(usize, String, Numbers)>; FAMILIES],
}

impl Reader<'_> {
    fn sections(&mut self, old_cells: bool) -> Result<(), FormatError> {
        // What the attributes that are being read belong to: cells or not, and how many.
        let mut on_cells = false;
        let mut tuples = 0;
        while let Some(word) = self.scanner.word() {
            match word.to_ascii_uppercase().as_slice() {
                b"POINTS" => {
                    let count = self.count("points")?;
                    let scalar = self.scalar()?;
                    self.points = Some(self.data(scalar, count, 3, "coordinates")?);
                }
                b"CELLS" => self.ends_and_connectivity = Some(self.cells(old_cells)?),
                b"CELL_TYPES" => {
                    let count = self.count("cell types")?;
                    self.types = Some(self.wholes(Scalar::I32, count, "cell types")?);
                }
                b"POINT_DATA" => (on_cells, tuples) = (false, self.count("points")?),
                b"CELL_DATA" => (on_cells, tuples) = (true, self.count("cells")?),
                b"METADATA" => self.skip_metadata(),
                b"FIELD" => self.field(on_cells)?,
                keyword => {
                    let (name, components, values) = self.attribute(keyword, tuples)?;
                    if on_cells && keyword != b"LOOKUP_TABLE" {
                        self.offer(&name, components, values);
                    }
                }
            }
        }
        Ok(())
    }

    /// One attribute: its name, how many values each tuple has, and its values.
    fn attribute(
        &mut self,
        keyword: &[u8],
        tuples: usize,
    ) -> Result<(String, usize, Numbers), FormatError> {
        let known: &[&[u8]] = &[
            b"SCALARS",
            b"COLOR_SCALARS",
            b"LOOKUP_TABLE",
            b"VECTORS",
            b"NORMALS",
            b"TENSORS",
            b"TENSORS6",
            b"TEXTURE_COORDINATES",
            b"GLOBAL_IDS",
            b"PEDIGREE_IDS",
            b"EDGE_FLAGS",
        ];
        if !known.contains(&keyword) {
            return Err(self.scanner.error(
                quoted(keyword),
                "POINTS, CELLS, CELL_TYPES, POINT_DATA, CELL_DATA or an attribute of them",
            ));
        }
        let name = decoded_name(self.scanner.required_word("the name of an attribute")?);
        // Colours are floating-point in text and bytes in binary.
        let colour = match self.encoding {
            Encoding::Ascii => Scalar::F32,
            Encoding::Binary(_) => Scalar::U8,
        };
        let (scalar, tuples, components) = match keyword {
            b"SCALARS" => {
                let scalar = self.scalar()?;
                let components = match self.scanner.peek() {
                    Some(word) if word[0].is_ascii_digit() => self.count("components")?,
                    _ => 1,
                };
                self.scanner.keyword("LOOKUP_TABLE")?;
                self.scanner.required_word("the name of a lookup table")?;
                (scalar, tuples, components)
            }
            b"COLOR_SCALARS" => (colour, tuples, self.count("components")?),
            b"LOOKUP_TABLE" => (colour, self.count("colours")?, 4),
            b"TEXTURE_COORDINATES" => {
                let components = self.count("components")?;
                (self.scalar()?, tuples, components)
            }
            b"VECTORS" | b"NORMALS" => (self.scalar()?, tuples, 3),
            b"TENSORS" => (self.scalar()?, tuples, 9),
            b"TENSORS6" => (self.scalar()?, tuples, 6),
            _ => (self.scalar()?, tuples, 1),
        };
        let values = self.data(scalar, tuples, components, "values of an attribute")?;
        Ok((name, components, values))
    }

    /// A FIELD: several arrays, each with its own size.
    fn field(&mut self, on_cells: bool) -> Result<(), FormatError> {
        self.scanner.required_word("the name of a field")?;
        let arrays = self.count("arrays")?;
        for _ in 0..arrays {
            let mut name = self.scanner.required_word("the name of an array")?;
            if name == b"METADATA" {
                self.skip_metadata();
                name = self.scanner.required_word("the name of an array")?;
            }
            let name = decoded_name(name);
            let components = self.count("components")?;
            let tuples = self.count("tuples")?;
            if self.scanner.peek() == Some(b"string") {
                self.skip_strings(components.saturating_mul(tuples))?;
                continue;
            }
            let scalar = self.scalar()?;
            let values = self.data(scalar, tuples, components, "values of a field")?;
            if on_cells {
                self.offer(&name, components, values);
            }
        }
        Ok(())
    }

    /// Takes an array of the cells, if it is the best one so far of what it holds.
    fn offer(&mut self, name: &str, components: usize, values: Numbers) {
        let found = match components {
            1 => region_rank(name).map(|rank| (rank, &mut self.region)),
            3 => family_and_rank(name).map(|(family, rank)| (rank, &mut self.directions[family])),
            _ => None,
        };
        if let Some((rank, best)) = found
            && best.as_ref().is_none_or(|known| rank < known.0)
        {
            *best = Some((rank, name.to_owned(), values));
        }
    }

    /// CELLS: before version 5 one list of point counts and points, from then on offsets and connectivity.
    fn cells(&mut self, old: bool) -> Result<(Vec<i64>, Vec<i64>), FormatError> {
        let first = self.count("cells")?;
        let second = self.count("points of cells")?;
        if !old {
            self.scanner.keyword("OFFSETS")?;
            let scalar = self.scalar()?;
            let mut offsets = self.wholes(scalar, first, "offsets")?;
            self.scanner.keyword("CONNECTIVITY")?;
            let scalar = self.scalar()?;
            let connectivity = self.wholes(scalar, second, "connectivity")?;
            // The first offset is 0, each further one the end of a cell.
            if !offsets.is_empty() && offsets.remove(0) != 0 {
                return Err(self.scanner.error("a first offset other than 0", "0"));
            }
            return Ok((offsets, connectivity));
        }
        let list = self.wholes(Scalar::I32, second, "cells")?;
        let mut ends = Vec::with_capacity(first);
        let mut connectivity = Vec::with_capacity(second.saturating_sub(first));
        let mut rest = list.as_slice();
        while let Some((&count, following)) = rest.split_first() {
            let cell = usize::try_from(count)
                .ok()
                .and_then(|count| following.split_at_checked(count));
            let Some((cell, following)) = cell else {
                return Err(FormatError::new(
                    Place::Array("cells".to_owned()),
                    format!(
                        "{count} points in cell {}, {} numbers follow",
                        ends.len(),
                        following.len()
                    ),
                    "as many points as the list holds (binary legacy files are big-endian)",
                ));
            };
            connectivity.extend_from_slice(cell);
            ends.push(connectivity.len() as i64);
            rest = following;
        }
        if ends.len() != first {
            return Err(FormatError::new(
                Place::Array("cells".to_owned()),
                format!("{} cells", ends.len()),
                format!("{first}, as CELLS says"),
            ));
        }
        Ok((ends, connectivity))
    }

    fn finish(self) -> Result<Import, FormatError> {
        let missing = |what: &str| FormatError::new(Place::File, format!("no {what}"), what);
        let place = Place::Array("points".to_owned());
        let mut parts = Parts {
            positions: positions(self.points.ok_or_else(|| missing("POINTS"))?, &place)?,
            ..Parts::default()
        };
        let (ends, connectivity) = self.ends_and_connectivity.ok_or_else(|| missing("CELLS"))?;
        let types = self.types.ok_or_else(|| missing("CELL_TYPES"))?;
        let mut data = CellData::default();
        if let Some((_, name, values)) = self.region {
            match region_values(&name, values, types.len()) {
                Ok(values) => data.regions = Some(values),
                Err(note) => parts.notes.push(note),
            }
        }
        for (found, directions) in self.directions.into_iter().zip(&mut data.directions) {
            let Some((_, name, values)) = found else {
                continue;
            };
            match direction_values(&name, values, types.len()) {
                Ok(values) => *directions = Some(values),
                Err(note) => parts.notes.push(note),
            }
        }
        let cells = Cells {
            ends,
            connectivity,
            types,
        };
        cells.add_to(&mut parts, 0, &data)?;
        parts.finish()
    }

    /// A count in decimals.
    fn count(&mut self, what: &str) -> Result<usize, FormatError> {
        let count = self.scanner.number(&format!("the number of {what}"))?;
        // Every item takes a byte at least.
        self.scanner.check_count(count, 1, what)
    }

    /// The name of a number type; in binary the data follow its line.
    fn scalar(&mut self) -> Result<Scalar, FormatError> {
        let word = self.scanner.required_word("a number type")?;
        match word.to_ascii_lowercase().as_slice() {
            b"char" | b"signed_char" => Ok(Scalar::I8),
            b"unsigned_char" => Ok(Scalar::U8),
            b"short" => Ok(Scalar::I16),
            b"unsigned_short" => Ok(Scalar::U16),
            b"int" | b"vtkidtype" => Ok(Scalar::I32),
            b"unsigned_int" => Ok(Scalar::U32),
            b"long" | b"vtktypeint64" => Ok(Scalar::I64),
            b"unsigned_long" | b"vtktypeuint64" => Ok(Scalar::U64),
            b"float" => Ok(Scalar::F32),
            b"double" => Ok(Scalar::F64),
            _ => Err(self
                .scanner
                .error(quoted(word), "a number type (float, double, int, …)")),
        }
    }

    /// `tuples` × `components` numbers; in binary they begin after the end of the line.
    fn data(
        &mut self,
        scalar: Scalar,
        tuples: usize,
        components: usize,
        what: &str,
    ) -> Result<Numbers, FormatError> {
        if self.encoding != Encoding::Ascii {
            self.scanner.line();
        }
        let count = tuples.saturating_mul(components);
        self.scanner.numbers(self.encoding, scalar, count, what)
    }

    fn wholes(
        &mut self,
        scalar: Scalar,
        count: usize,
        what: &str,
    ) -> Result<Vec<i64>, FormatError> {
        self.data(scalar, count, 1, what)?
            .into_wholes()
            .ok_or_else(|| {
                self.scanner
                    .error("fractions", format!("whole numbers: {what}"))
            })
    }

    /// METADATA ends with an empty line.
    fn skip_metadata(&mut self) {
        self.scanner.line();
        while self
            .scanner
            .line()
            .is_some_and(|line| !line.trim_ascii().is_empty())
        {}
    }

    /// Strings stand one per line in text; in binary their lengths have a coding of their own.
    fn skip_strings(&mut self, count: usize) -> Result<(), FormatError> {
        self.scanner.word();
        if self.encoding != Encoding::Ascii {
            return Err(self.scanner.error(
                "an array of strings in a binary file",
                "numbers: export without arrays of strings, or in ASCII",
            ));
        }
        self.scanner.line();
        for _ in 0..count {
            self.scanner
                .line()
                .ok_or_else(|| self.scanner.ended("a string"))?;
        }
        Ok(())
    }
}

/// A name as VTK writes it: bytes that would break a word stand as %XX.
fn decoded_name(word: &[u8]) -> String {
    let mut name = Vec::with_capacity(word.len());
    let mut rest = word;
    while let Some((&byte, following)) = rest.split_first() {
        let code = following
            .get(..2)
            .and_then(|digits| std::str::from_utf8(digits).ok())
            .and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match code {
            Some(code) if byte == b'%' => {
                name.push(code);
                rest = &following[2..];
            }
            _ => {
                name.push(byte);
                rest = following;
            }
        }
    }
    String::from_utf8_lossy(&name).into_owned()
}

#[cfg(test)]
mod tests {
    use super::decoded_name;

    #[test]
    fn names_are_percent_decoded() {
        assert_eq!(decoded_name(b"gmsh%3Aphysical"), "gmsh:physical");
        assert_eq!(decoded_name(b"100%"), "100%");
        assert_eq!(decoded_name(b"%zz%41"), "%zzA");
    }
}
