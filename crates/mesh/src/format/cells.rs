//! VTK cells: which are tetrahedra.

use super::assemble::{CellData, Parts};
use super::error::{FormatError, Place};

/// Cells as three arrays: where each one's points end in `connectivity`, and its type.
pub(super) struct Cells {
    /// One past the last point of each cell in `connectivity`, ascending.
    pub(super) ends: Vec<i64>,
    /// Points of all cells.
    pub(super) connectivity: Vec<i64>,
    /// VTK's number of each cell's type.
    pub(super) types: Vec<i64>,
}

/// What a cell type is to us.
enum Kind {
    Tetrahedron,
    CurvedTetrahedron,
    Other(&'static str),
}

/// VTK's cell types (vtkCellType.h).
fn kind(cell_type: i64) -> Kind {
    match cell_type {
        10 => Kind::Tetrahedron,
        24 | 64 | 71 | 78 => Kind::CurvedTetrahedron,
        0..=2 => Kind::Other("points"),
        3 | 4 | 21 => Kind::Other("lines"),
        5 | 6 | 22 => Kind::Other("triangles"),
        7 => Kind::Other("polygons"),
        8 | 9 | 23 => Kind::Other("quadrilaterals"),
        11 | 12 | 25 => Kind::Other("hexahedra"),
        13 | 26 => Kind::Other("prisms"),
        14 | 27 => Kind::Other("pyramids"),
        _ => Kind::Other("cells of other types"),
    }
}

impl Cells {
    /// Adds the tetrahedra to `parts`, whose last positions from `first` on are the points.
    pub(super) fn add_to(
        &self,
        parts: &mut Parts,
        first: usize,
        data: &CellData,
    ) -> Result<(), FormatError> {
        let error = |found: String, expected: &str| {
            Err(FormatError::new(
                Place::Array("cells".to_owned()),
                found,
                expected,
            ))
        };
        if self.ends.len() != self.types.len() {
            return error(
                format!("{} cells and {} types", self.ends.len(), self.types.len()),
                "one type per cell",
            );
        }
        let points = parts.positions.len() - first;
        let mut start = 0;
        for (cell, (&end, &cell_type)) in self.ends.iter().zip(&self.types).enumerate() {
            let nodes = usize::try_from(end)
                .ok()
                .and_then(|end| self.connectivity.get(start..end));
            let Some(nodes) = nodes else {
                return error(
                    format!("offset {end} of cell {cell} after offset {start}"),
                    "ascending offsets within the connectivity",
                );
            };
            start += nodes.len();
            match kind(cell_type) {
                Kind::Other(name) => parts.leave_out(name, 1),
                Kind::CurvedTetrahedron => {
                    return error(
                        format!(
                            "a tetrahedron of second or higher order (cell {cell}, type {cell_type})"
                        ),
                        "linear tetrahedra: export the mesh with elements of first order",
                    );
                }
                Kind::Tetrahedron => {
                    let &[a, b, c, d] = nodes else {
                        return error(
                            format!("{} points in tetrahedron {cell}", nodes.len()),
                            "4 points",
                        );
                    };
                    let mut tet = [0; 4];
                    for (slot, point) in tet.iter_mut().zip([a, b, c, d]) {
                        match usize::try_from(point) {
                            Ok(index) if index < points => *slot = (first + index) as u32,
                            _ => {
                                return error(
                                    format!("point {point} in cell {cell}"),
                                    &format!("points from 0 to {}", points.saturating_sub(1)),
                                );
                            }
                        }
                    }
                    parts.tets.push(tet);
                    let region = data.regions.as_ref().map_or(0, |regions| regions[cell]);
                    parts.regions.push(region);
                    for (family, directions) in data.directions.iter().enumerate() {
                        if let Some(directions) = directions {
                            parts.set_direction(parts.tets.len() - 1, family, directions[cell]);
                        }
                    }
                }
            }
        }
        Ok(())
    }
}
