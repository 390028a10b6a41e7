//! Version 2.x: every element carries its tags, the first of which is its physical group.

use super::Reader;
use super::elements::TETRAHEDRON;
use crate::format::error::FormatError;
use crate::format::scalar::{Encoding, Scalar};
use std::collections::BTreeMap;

/// Reads all sections.
pub(super) fn read(reader: &mut Reader<'_>) -> Result<(), FormatError> {
    reader.sections(|reader, name| {
        match name {
            "Nodes" => nodes(reader)?,
            "Elements" => elements(reader)?,
            _ => return Ok(false),
        }
        Ok(true)
    })
}

fn nodes(reader: &mut Reader<'_>) -> Result<(), FormatError> {
    let count = reader.decimal_count(reader.least_bytes(4, 28), "nodes")?;
    for _ in 0..count {
        let tag = reader.int("a node number (or fewer nodes in $Nodes)")?;
        reader.number_node(tag)?;
        let position = reader.position()?;
        reader.parts.positions.push(position);
    }
    Ok(())
}

/// Reads the elements. One that belongs to several physical groups is written once for each, under a number of its own: the first counts,
/// as in version 4.1.
fn elements(reader: &mut Reader<'_>) -> Result<(), FormatError> {
    let count = reader.decimal_count(reader.least_bytes(4, 8), "elements")?;
    let mut read = 0;
    // Nodes and geometric entity, with the first region.
    let mut seen: BTreeMap<([u32; 4], i64), u32> = BTreeMap::new();
    let mut again = 0;
    while read < count {
        // ASCII: number, type, number of tags per element. Binary: a header for several elements, then their numbers.
        let ascii = reader.encoding == Encoding::Ascii;
        let mut number = 0;
        if ascii {
            number = reader.int("an element number (or fewer elements in $Elements)")?;
        }
        let element_type = reader.int("an element type")?;
        let block = if ascii {
            1
        } else {
            let block = reader.int("a number of elements")?;
            reader.scanner.check_count(block, 4, "elements")?
        };
        if block == 0 || block > count - read {
            return Err(reader.scanner.error(
                format!("{block} elements after {read} of {count}"),
                "blocks that add up to the number of elements",
            ));
        }
        let tags = reader.int("a number of tags")?;
        let tags = reader.scanner.check_count(tags, 1, "tags")?;
        let (nodes, name) = reader.known_type(element_type)?;
        for _ in 0..block {
            if !ascii {
                number = reader.int("an element number")?;
            }
            let (mut physical, mut entity) = (0, None);
            for tag in 0..tags {
                let value = reader.int("a tag of an element")?;
                match tag {
                    0 => physical = value,
                    1 => entity = Some(value),
                    _ => {}
                }
            }
            if element_type == TETRAHEDRON {
                let region = reader.region(physical)?;
                let mut tet = [0; 4];
                for slot in &mut tet {
                    *slot = reader.node(|reader| reader.int("a node number"))?;
                }
                // Twice in one group, or in two entities, is a defect of the mesh, which shows later.
                if let Some(entity) = entity
                    && *seen.entry((tet, entity)).or_insert(region) != region
                {
                    again += 1;
                    continue;
                }
                reader.parts.tets.push(tet);
                reader.parts.regions.push(region);
                reader.tet_numbers.push(number);
            } else {
                reader
                    .scanner
                    .numbers(reader.encoding, Scalar::I32, nodes, "node numbers")?;
            }
        }
        if element_type != TETRAHEDRON {
            reader.parts.leave_out(name, block);
        }
        read += block;
    }
    if again > 0 {
        reader.parts.notes.push(format!(
            "{again} tetrahedra stand once more in another physical group; the first is their region"
        ));
    }
    Ok(())
}
