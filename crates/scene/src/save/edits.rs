//! Exact bytes of edits of meshes, of strokes and of the marks of cut surfaces.

use super::{Reader, RestoreError, put_f64, put_u32, put_vector};
use crate::body::{Body, CutTally};
use crate::edits::Edit;
use crate::lonor::BladeState;
use crate::pieces::Pieces;
use microsim_cutting::{
    Crossing, PassedNode, PathPoints, Stroke, Swept, Topology, TopologyChange, TopologyState,
    Waiting, check,
};
use microsim_mesh::{CutFace, NewNode, Replacement, Side, TopologyEdit};
use std::collections::BTreeMap;

/// An edit: body u32, nodes before it u32, generation u64; then lists, each behind its length u32: places of elements that slid (f64), new nodes
/// (2 × u32, f64), replaced elements (u32, list of 4 × u32), removed elements and nodes (u32), renumbered elements (5 × u32), cut faces (5 × u32, side
/// u32).
pub(super) fn put_edit(bytes: &mut Vec<u8>, edit: &Edit) {
    let TopologyEdit {
        generation,
        nodes,
        elements,
        removed,
        removed_nodes,
        renumbered,
        cut_faces,
    } = &edit.edit;
    put_u32(bytes, edit.body as u32);
    put_u32(bytes, edit.nodes as u32);
    bytes.extend_from_slice(&generation.to_le_bytes());
    put_list(bytes, &edit.places, |bytes, place| put_f64(bytes, *place));
    put_list(bytes, nodes, |bytes, node| {
        put_numbers(bytes, &node.between);
        put_f64(bytes, node.fraction);
    });
    put_list(bytes, elements, |bytes, replacement| {
        put_u32(bytes, replacement.element);
        put_list(bytes, &replacement.children, |bytes, child| {
            put_numbers(bytes, child)
        });
    });
    put_list(bytes, removed, |bytes, element| put_u32(bytes, *element));
    put_list(bytes, removed_nodes, |bytes, node| put_u32(bytes, *node));
    put_list(bytes, renumbered, |bytes, (element, corners)| {
        put_u32(bytes, *element);
        put_numbers(bytes, corners);
    });
    put_list(bytes, cut_faces, |bytes, face| {
        put_numbers(bytes, &face.nodes);
        let side = u32::from(face.side == Side::Positive);
        put_numbers(bytes, &[face.element, face.sheet, side]);
    });
}

pub(super) fn edit(reader: &mut Reader<'_>) -> Result<Edit, RestoreError> {
    let [body, nodes] = [reader.u32()? as usize, reader.u32()? as usize];
    let generation = u64::from_le_bytes(reader.array()?);
    let places = reader.list(Reader::f64)?;
    let edit = TopologyEdit {
        generation,
        nodes: reader.list(|r| {
            Ok(NewNode {
                between: r.numbers()?,
                fraction: r.f64()?,
            })
        })?,
        elements: reader.list(|r| {
            Ok(Replacement {
                element: r.u32()?,
                children: r.list(Reader::numbers)?,
            })
        })?,
        removed: reader.list(Reader::u32)?,
        removed_nodes: reader.list(Reader::u32)?,
        renumbered: reader.list(|r| Ok((r.u32()?, r.numbers()?)))?,
        cut_faces: reader.list(|r| {
            let nodes = r.numbers()?;
            let [element, sheet, side] = r.numbers()?;
            Ok(CutFace {
                nodes,
                element,
                sheet,
                side: match side {
                    0 => Side::Negative,
                    _ => Side::Positive,
                },
            })
        })?,
    };
    Ok(Edit {
        body,
        nodes,
        places,
        edit,
    })
}

/// State and strokes of a cut: capsules in tissue (u32), closed parts (u32 whether there is one, 2 × f64), strokes; of a semi-progressive one with the edges that
/// wait (2 × u32, f64, three flags u32, 3 × f64).
pub(super) fn put_blade(bytes: &mut Vec<u8>, blade: &BladeState, topology: TopologyChange) {
    put_list(bytes, &blade.inside, |bytes, capsule| {
        put_u32(bytes, *capsule)
    });
    put_list(bytes, &blade.closed, |bytes, closed| {
        put_u32(bytes, u32::from(closed.is_some()));
        let part = closed.unwrap_or_default();
        part.into_iter().for_each(|end| put_f64(bytes, end));
    });
    put_list(bytes, &blade.strokes, |bytes, (line, stroke)| {
        put_u32(bytes, *line);
        put_u32(bytes, stroke.sheet);
        let nodes: Vec<_> = stroke.nodes.iter().collect();
        put_list(bytes, &nodes, |bytes, (node, passed)| {
            put_u32(bytes, **node);
            bytes.extend(passed.side.to_le_bytes());
            put_f64(bytes, passed.advance);
        });
        put_vector(bytes, &stroke.across);
        put_f64(bytes, stroke.advance);
        put_f64(bytes, stroke.unseen);
        put_u32(bytes, stroke.points.count);
        put_vector(bytes, &stroke.points.sum);
        let products = stroke.points.products.iter();
        products.for_each(|product| put_f64(bytes, *product));
        if topology == TopologyChange::SemiProgressive {
            let waiting: Vec<_> = stroke.waiting.iter().collect();
            put_list(bytes, &waiting, |bytes, (edge, of)| {
                put_numbers(bytes, *edge);
                put_f64(bytes, of.crossing.fraction);
                let flags = [of.crossing.positive, of.crossing.is_certain, of.forward];
                put_numbers(bytes, &flags.map(u32::from));
                put_vector(bytes, &of.crossing.normal);
            });
        }
    });
}

pub(super) fn blade(
    reader: &mut Reader<'_>,
    topology: TopologyChange,
) -> Result<BladeState, RestoreError> {
    Ok(BladeState {
        inside: reader.list(Reader::u32)?,
        closed: reader.list(|r| {
            let there = r.u32()? != 0;
            let part = [r.f64()?, r.f64()?];
            Ok(there.then_some(part))
        })?,
        strokes: reader.list(|r| {
            let line = r.u32()?;
            let stroke = Stroke {
                sheet: r.u32()?,
                nodes: r
                    .list(|r| {
                        let node = r.u32()?;
                        let side = i8::from_le_bytes(r.array()?);
                        let advance = r.f64()?;
                        Ok((node, PassedNode { side, advance }))
                    })?
                    .into_iter()
                    .collect::<BTreeMap<_, _>>(),
                across: r.vector()?,
                advance: r.f64()?,
                unseen: r.f64()?,
                points: PathPoints {
                    count: r.u32()?,
                    sum: r.vector()?,
                    products: {
                        let mut products = [0.0; 6];
                        for product in &mut products {
                            *product = r.f64()?;
                        }
                        products
                    },
                },
                waiting: match topology {
                    TopologyChange::SemiProgressive => {
                        r.list(waiting)?.into_iter().collect::<BTreeMap<_, _>>()
                    }
                    _ => BTreeMap::new(),
                },
            };
            Ok((line, stroke))
        })?,
        leaving: Vec::new(),
    })
}

/// An edge that waits.
fn waiting(reader: &mut Reader<'_>) -> Result<([u32; 2], Waiting), RestoreError> {
    let edge = reader.numbers()?;
    let fraction = reader.f64()?;
    let flags: [u32; 3] = reader.numbers()?;
    let [positive, is_certain, forward] = flags.map(|flag| flag != 0);
    let crossing = Crossing {
        fraction,
        positive,
        is_certain,
        normal: reader.vector()?,
    };
    Ok((edge, Waiting { crossing, forward }))
}

/// What cuts have made of a body, besides its edits: divided u64, rejected u64, lost volume f64, merged u64, number of pieces u32, the piece of each
/// node u32, and the state of its topology. Nothing of a body that cannot be cut.
pub(super) fn put_cut(bytes: &mut Vec<u8>, body: &Body) {
    let Some(topology) = &body.topology else {
        return;
    };
    let CutTally {
        divided,
        rejected,
        lost_volume,
        merged,
    } = body.tally;
    bytes.extend_from_slice(&divided.to_le_bytes());
    bytes.extend_from_slice(&rejected.to_le_bytes());
    put_f64(bytes, lost_volume);
    bytes.extend_from_slice(&merged.to_le_bytes());
    put_u32(bytes, body.pieces.count());
    put_numbers(bytes, &body.pieces.of_nodes);
    put_topology(bytes, &topology.state());
}

/// Gives a body that is updated after its edits the rest of what cuts have made of it.
pub(super) fn cut(reader: &mut Reader<'_>, body: &mut Body) -> Result<(), RestoreError> {
    if body.topology.is_none() {
        return Ok(());
    }
    body.tally = CutTally {
        divided: u64::from_le_bytes(reader.array()?),
        rejected: u64::from_le_bytes(reader.array()?),
        lost_volume: reader.f64()?,
        merged: u64::from_le_bytes(reader.array()?),
    };
    let count = reader.u32()?;
    let mut of_nodes = body.pieces.of_nodes.clone();
    for piece in &mut of_nodes {
        *piece = reader.u32()?;
    }
    let numbers = 1..=body.mesh.tets.len() as u32 + 1;
    let known = |piece: &u32| *piece < count;
    let pieces = numbers.contains(&count) && of_nodes.iter().all(known);
    let topology = Topology::restore(&body.mesh, &topology(reader)?);
    let sound = check(&body.mesh, &topology).is_ok() && body.model.tets() == body.mesh.tets;
    if !pieces || !sound {
        return Err(RestoreError::OtherScene);
    }
    body.topology = Some(topology);
    body.pieces = Pieces::new(of_nodes, count, &body.mesh.tets);
    body.rebuild_surface();
    Ok(())
}

/// The state of a body's topology beyond its mesh.
fn put_topology(bytes: &mut Vec<u8>, state: &TopologyState) {
    put_list(bytes, &state.marks, |bytes, (element, corner, sheet)| {
        put_numbers(bytes, &[*element, u32::from(*corner), *sheet]);
    });
    put_list(bytes, &state.front, |bytes, node| put_u32(bytes, *node));
    put_list(bytes, &state.parted, |bytes, node| put_u32(bytes, *node));
    put_list(bytes, &state.swept, |bytes, (element, swept)| {
        put_numbers(bytes, &[*element, u32::from(swept.passed)]);
        put_vector(bytes, &swept.side);
    });
    put_f64(bytes, state.mean_volume);
    put_f64(bytes, state.mean_edge);
    put_u32(bytes, state.sheets);
}

fn topology(reader: &mut Reader<'_>) -> Result<TopologyState, RestoreError> {
    Ok(TopologyState {
        marks: reader.list(|r| {
            let [element, corner, sheet] = r.numbers()?;
            let corner = u8::try_from(corner).map_err(|_| RestoreError::OtherScene)?;
            Ok((element, corner, sheet))
        })?,
        front: reader.list(Reader::u32)?,
        parted: reader.list(Reader::u32)?,
        swept: reader.list(|r| {
            let [element, passed] = r.numbers()?;
            let passed = passed != 0;
            let side = r.vector()?;
            Ok((element, Swept { passed, side }))
        })?,
        mean_volume: reader.f64()?,
        mean_edge: reader.f64()?,
        sheets: reader.u32()?,
    })
}

fn put_list<T>(bytes: &mut Vec<u8>, items: &[T], mut put: impl FnMut(&mut Vec<u8>, &T)) {
    put_u32(bytes, items.len() as u32);
    items.iter().for_each(|item| put(bytes, item));
}

fn put_numbers(bytes: &mut Vec<u8>, numbers: &[u32]) {
    numbers.iter().for_each(|number| put_u32(bytes, *number));
}

impl Reader<'_> {
    pub(super) fn list<T>(
        &mut self,
        mut item: impl FnMut(&mut Self) -> Result<T, RestoreError>,
    ) -> Result<Vec<T>, RestoreError> {
        let count = self.u32()?;
        (0..count).map(|_| item(self)).collect()
    }

    fn numbers<const N: usize>(&mut self) -> Result<[u32; N], RestoreError> {
        let mut numbers = [0; N];
        for number in &mut numbers {
            *number = self.u32()?;
        }
        Ok(numbers)
    }
}
