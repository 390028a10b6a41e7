//! VTK XML unstructured grids, `.vtu` (VTK file formats, "XML File Formats").

mod array;
mod document;
mod write;

pub use write::{Field, FieldValues, VtuEncoding, write_vtu};

use super::Import;
use super::assemble::{
    CellData, PRESTRETCH, Parts, direction_rank, direction_values, positions, region_rank,
    region_values,
};
use super::cells::Cells;
use super::error::{FormatError, Place};
use array::Decoder;
use document::{Array, Document};

/// The mesh in `file`; several pieces follow one another.
pub(super) fn read(file: &[u8]) -> Result<Import, FormatError> {
    let document = Document::parse(file)?;
    let mut decoder = Decoder::new(&document, file.len());
    let mut parts = Parts::default();
    for piece in &document.pieces {
        let first = parts.positions.len();
        let numbers = decoder.numbers(required(&piece.points, "Points")?)?;
        let place = Place::Array("Points".to_owned());
        if Some(numbers.len()) != piece.point_count.checked_mul(3) {
            return Err(FormatError::new(
                place,
                format!("{} numbers for {} points", numbers.len(), piece.point_count),
                "three per point",
            ));
        }
        parts.positions.extend(positions(numbers, &place)?);
        if parts.positions.len() > u32::MAX as usize {
            return Err(FormatError::new(place, "more than 2³² points", "fewer"));
        }

        let mut wholes = |array: &Option<Array<'_>>, name: &str| {
            decoder
                .numbers(required(array, name)?)?
                .into_wholes()
                .ok_or_else(|| {
                    FormatError::new(Place::Array(name.to_owned()), "fractions", "whole numbers")
                })
        };
        let cells = Cells {
            connectivity: wholes(&piece.connectivity, "connectivity")?,
            ends: wholes(&piece.offsets, "offsets")?,
            types: wholes(&piece.types, "types")?,
        };
        if cells.types.len() != piece.cell_count {
            return Err(FormatError::new(
                Place::Array("types".to_owned()),
                format!("{} types for {} cells", cells.types.len(), piece.cell_count),
                "one per cell",
            ));
        }

        let best = |components: usize, rank: &dyn Fn(&str) -> Option<usize>| {
            let arrays = piece.cell_data.iter();
            arrays
                .filter(|array| array.components == components)
                .filter_map(|array| Some((rank(&array.name)?, array)))
                .min_by_key(|(rank, _)| *rank)
                .map(|(_, array)| array)
        };
        let mut data = CellData::default();
        if let Some(array) = best(1, &region_rank) {
            match region_values(&array.name, decoder.numbers(array)?, cells.types.len()) {
                Ok(values) => data.regions = Some(values),
                Err(note) => parts.notes.push(note),
            }
        }
        for (family, directions) in data.directions.iter_mut().enumerate() {
            let Some(array) = best(3, &|name| direction_rank(name, family)) else {
                continue;
            };
            match direction_values(&array.name, decoder.numbers(array)?, cells.types.len()) {
                Ok(values) => *directions = Some(values),
                Err(note) => parts.notes.push(note),
            }
        }
        cells.add_to(&mut parts, first, &data)?;
    }
    // They lead to the rest positions, which a file of a deformed mesh does not have.
    let mut arrays = document.pieces.iter().flat_map(|piece| &piece.cell_data);
    if arrays.any(|array| array.name == PRESTRETCH) {
        parts.notes.push(
            "prestretches are left out: the elements have no stress in the places of the file"
                .to_owned(),
        );
    }
    parts.finish()
}

fn required<'a, 'b>(
    array: &'a Option<Array<'b>>,
    name: &str,
) -> Result<&'a Array<'b>, FormatError> {
    array.as_ref().ok_or_else(|| {
        FormatError::new(
            Place::File,
            format!("a piece without the array {name}"),
            name,
        )
    })
}
