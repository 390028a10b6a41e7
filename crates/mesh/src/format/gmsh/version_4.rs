//! Version 4.1: elements lie in blocks of one geometric entity, which carries the physical groups.

use super::Reader;
use super::elements::TETRAHEDRON;
use crate::format::error::FormatError;
use crate::format::scalar::Scalar;
use std::collections::BTreeMap;

/// Reads all sections.
pub(super) fn read(reader: &mut Reader<'_>) -> Result<(), FormatError> {
    let mut regions = BTreeMap::new();
    reader.sections(|reader, name| {
        match name {
            "Entities" => entities(reader, &mut regions)?,
            "Nodes" => nodes(reader)?,
            "Elements" => elements(reader, &regions)?,
            _ => return Ok(false),
        }
        Ok(true)
    })
}

/// The regions of the volumes: the first physical group of each.
fn entities(reader: &mut Reader<'_>, regions: &mut BTreeMap<i64, u32>) -> Result<(), FormatError> {
    let mut counts = [0; 4];
    for count in &mut counts {
        let number = reader.size("a number of points, curves, surfaces or volumes")?;
        *count = reader
            .scanner
            .check_count(number, reader.least_bytes(5, 32), "entities")?;
    }
    let mut several = 0;
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let tag = reader.int("the number of an entity")?;
            // A point has a place, the others a bounding box.
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                reader.scanner.coordinate(reader.encoding, Scalar::F64)?;
            }
            let groups = int_list(reader, "physical groups")?;
            if dimension > 0 {
                int_list(reader, "bounding entities")?;
            }
            if let (3, Some(&group)) = (dimension, groups.first()) {
                let region = reader.region(group)?;
                regions.insert(tag, region);
                several += usize::from(groups.len() > 1);
            }
        }
    }
    if several > 0 {
        reader.parts.notes.push(format!(
            "{several} volumes belong to several physical groups; the first is their region"
        ));
    }
    Ok(())
}

fn int_list(reader: &mut Reader<'_>, what: &str) -> Result<Vec<i64>, FormatError> {
    let count = reader.size(&format!("a number of {what}"))?;
    let count = reader
        .scanner
        .check_count(count, reader.least_bytes(1, 4), what)?;
    (0..count).map(|_| reader.int(what)).collect()
}

fn nodes(reader: &mut Reader<'_>) -> Result<(), FormatError> {
    let (blocks, count) = section_head(reader, "nodes")?;
    for _ in 0..blocks {
        let dimension = reader.int("the dimension of an entity")?;
        reader.int("the number of an entity")?;
        let parametric = reader.int("0 or 1 for parametric coordinates")?;
        let parameters = match (parametric, dimension) {
            (0, 0..=3) => 0,
            (1, 0..=3) => dimension as usize,
            _ => {
                return Err(reader.scanner.error(
                    format!("{parametric} for an entity of dimension {dimension}"),
                    "0 or 1 for parametric coordinates of an entity of dimension 0 to 3",
                ));
            }
        };
        let in_block = reader.size("a number of nodes")?;
        let least = reader.least_bytes(4, 24 + reader.size.size());
        let in_block = reader.scanner.check_count(in_block, least, "nodes")?;
        for _ in 0..in_block {
            let tag = reader.size("a node number")?;
            reader.number_node(tag)?;
        }
        for _ in 0..in_block {
            let position = reader.position()?;
            reader.parts.positions.push(position);
            let skipped = "parametric coordinates";
            reader
                .scanner
                .numbers(reader.encoding, Scalar::F64, parameters, skipped)?;
        }
    }
    check_total(reader, reader.parts.positions.len(), count, "nodes")
}

fn elements(reader: &mut Reader<'_>, regions: &BTreeMap<i64, u32>) -> Result<(), FormatError> {
    let (blocks, count) = section_head(reader, "elements")?;
    let mut read = 0;
    let mut ungrouped = 0;
    for _ in 0..blocks {
        reader.int("the dimension of an entity")?;
        let entity = reader.int("the number of an entity")?;
        let element_type = reader.int("an element type")?;
        let (nodes, name) = reader.known_type(element_type)?;
        let in_block = reader.size("a number of elements")?;
        let least = reader.least_bytes(1 + nodes, (1 + nodes) * reader.size.size());
        let in_block = reader.scanner.check_count(in_block, least, "elements")?;
        for _ in 0..in_block {
            let number = reader.size("an element number")?;
            if element_type == TETRAHEDRON {
                let mut tet = [0; 4];
                for slot in &mut tet {
                    *slot = reader.node(|reader| reader.size("a node number"))?;
                }
                reader.parts.tets.push(tet);
                reader
                    .parts
                    .regions
                    .push(regions.get(&entity).copied().unwrap_or(0));
                reader.tet_numbers.push(number);
            } else {
                reader
                    .scanner
                    .numbers(reader.encoding, reader.size, nodes, "node numbers")?;
            }
        }
        if element_type != TETRAHEDRON {
            reader.parts.leave_out(name, in_block);
        } else if !regions.contains_key(&entity) {
            ungrouped += in_block;
        }
        read += in_block;
    }
    if ungrouped > 0 && !regions.is_empty() {
        reader.parts.notes.push(format!(
            "{ungrouped} tetrahedra lie in volumes without a physical group: region 0"
        ));
    }
    check_total(reader, read, count, "elements")
}

/// Numbers of blocks and of entities, with which $Nodes and $Elements begin.
fn section_head(reader: &mut Reader<'_>, what: &str) -> Result<(usize, i64), FormatError> {
    let blocks = reader.size("a number of blocks")?;
    let blocks = reader
        .scanner
        .check_count(blocks, reader.least_bytes(4, 16), "blocks")?;
    let count = reader.size(&format!("the number of {what}"))?;
    reader.scanner.check_count(count, 2, what)?;
    reader.size("the smallest number in use")?;
    reader.size("the largest number in use")?;
    Ok((blocks, count))
}

fn check_total(
    reader: &Reader<'_>,
    found: usize,
    stated: i64,
    what: &str,
) -> Result<(), FormatError> {
    if found as i64 == stated {
        Ok(())
    } else {
        Err(reader.scanner.error(
            format!("{found} {what} in the blocks"),
            format!("{stated}, as the section says"),
        ))
    }
}
