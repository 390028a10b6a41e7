//! From what a file holds to a mesh: orientation, regions, notes.

use super::Import;
use super::error::{FormatError, Place};
use super::scalar::Numbers;
use crate::{FAMILIES, TetMesh, signed_volume};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Cell arrays that state which material a cell is made of, the first that is there counts: our own name, then those of
/// Gmsh (through meshio and VTK), SfePy, OpenGeoSys, Medit and TetGen.
const REGION_ARRAYS: [&str; 7] = [
    "region",
    "gmsh:physical",
    "CellEntityIds",
    "mat_id",
    "MaterialIDs",
    "medit:ref",
    "tetgen:ref",
];

/// Rank of a cell array as the one that holds the regions, smaller is better; nothing if it does not.
pub(super) fn region_rank(name: &str) -> Option<usize> {
    REGION_ARRAYS.iter().position(|known| *known == name)
}

/// Cell arrays that hold the fibre directions of a family, the first that is there counts: our own name, then those of others.
const DIRECTION_ARRAYS: [&[&str]; FAMILIES] = [
    &[
        "fibre_direction",
        "fiber_direction",
        "fibre",
        "fiber",
        "fibres",
        "fibers",
        "f0",
    ],
    &[
        "fibre_direction_2",
        "fiber_direction_2",
        "fibre_2",
        "fiber_2",
        "f1",
    ],
];

/// Our own names of the cell arrays of fibre directions, one for each family.
pub(super) const DIRECTIONS: [&str; FAMILIES] = [DIRECTION_ARRAYS[0][0], DIRECTION_ARRAYS[1][0]];

/// Our own name of the cell array of prestretches.
pub(super) const PRESTRETCH: &str = "prestretch";

/// Rank of a cell array of three components as the one that holds the fibre directions of a family, smaller is better; nothing if it
/// does not.
pub(super) fn direction_rank(name: &str, family: usize) -> Option<usize> {
    let mut known = DIRECTION_ARRAYS[family].iter();
    known.position(|known| *known == name)
}

/// The family of fibres whose directions a cell array of three components holds, and its rank; nothing if it holds none.
pub(super) fn family_and_rank(name: &str) -> Option<(usize, usize)> {
    let families = 0..FAMILIES;
    families
        .filter_map(|family| Some((family, direction_rank(name, family)?)))
        .next()
}

/// What cells carry, one value per cell of any type.
#[derive(Default)]
pub(super) struct CellData {
    pub(super) regions: Option<Vec<u32>>,
    /// Fibre directions of each family.
    pub(super) directions: [Option<Vec<Vector3<f64>>>; FAMILIES],
}

/// A mesh in the making.
#[derive(Default)]
pub(super) struct Parts {
    /// Nodes.
    pub(super) positions: Vec<Vector3<f64>>,
    /// Linear tetrahedra; every index is that of a node.
    pub(super) tets: Vec<[u32; 4]>,
    /// One region per tetrahedron.
    pub(super) regions: Vec<u32>,
    /// Fibre directions of any length, zero where there is none, of the first tetrahedra; the others have none.
    pub(super) directions: Vec<[Vector3<f64>; FAMILIES]>,
    /// Elements that are not linear tetrahedra, by name.
    pub(super) left_out: BTreeMap<String, usize>,
    /// What else is to be reported.
    pub(super) notes: Vec<String>,
}

impl Parts {
    /// Notes `count` elements called `name` that are not taken.
    pub(super) fn leave_out(&mut self, name: &str, count: usize) {
        if count > 0 {
            *self.left_out.entry(name.to_owned()).or_default() += count;
        }
    }

    /// Gives a tetrahedron the fibre direction of a family, of any length.
    pub(super) fn set_direction(&mut self, tet: usize, family: usize, direction: Vector3<f64>) {
        if self.directions.len() <= tet {
            self.directions.resize(tet + 1, Default::default());
        }
        self.directions[tet][family] = direction;
    }

    /// Makes the fibre directions unit vectors, one for each tetrahedron, or none at all.
    fn finish_directions(&mut self) {
        if self.directions.is_empty() {
            return;
        }
        self.directions.resize(self.tets.len(), Default::default());
        for direction in self.directions.iter_mut().flatten() {
            // One of length 1 to rounding keeps its bits.
            if (direction.norm_squared() - 1.0).abs() > 4.0 * f64::EPSILON {
                // Scaled first: the square of the largest number there is has no value.
                *direction = match direction.amax() {
                    size if size > 0.0 && size.is_finite() => (*direction / size).normalize(),
                    _ => Vector3::zeros(),
                };
            }
        }
        // Where there is one family it is the first.
        for families in &mut self.directions {
            if families[0] == Vector3::zeros() {
                families.swap(0, 1);
            }
        }
        let all = self.tets.len();
        let families = self.directions.iter();
        let without = families.filter(|of| of[0] == Vector3::zeros()).count();
        self.notes.push(match without {
            0 => "every tetrahedron has a fibre direction".to_owned(),
            _ => format!("{without} of {all} tetrahedra have no fibre direction"),
        });
    }

    /// The mesh, its elements turned positive.
    pub(super) fn finish(mut self) -> Result<Import, FormatError> {
        let others: Vec<String> = self
            .left_out
            .iter()
            .map(|(name, count)| format!("{count} {name}"))
            .collect();
        if self.tets.is_empty() {
            let found = if others.is_empty() {
                "no element".to_owned()
            } else {
                format!("no tetrahedron, only {}", others.join(", "))
            };
            return Err(FormatError::new(Place::File, found, "linear tetrahedra"));
        }
        if !others.is_empty() {
            self.notes.push(format!(
                "left out, since only linear tetrahedra are taken: {}",
                others.join(", ")
            ));
        }

        self.finish_directions();
        let mut turned = 0;
        for tet in &mut self.tets {
            let [a, b, c, d] = tet.map(|node| self.positions[node as usize]);
            if signed_volume(&a, &b, &c, &d) < 0.0 {
                tet.swap(2, 3);
                turned += 1;
            }
        }
        if turned > 0 {
            self.notes.push(format!(
                "{turned} of {} tetrahedra were negative and had two nodes swapped",
                self.tets.len()
            ));
        }
        let mut mesh = TetMesh::new(self.positions, self.tets, self.regions);
        mesh.directions = self.directions;
        Ok(Import {
            mesh,
            notes: self.notes,
        })
    }
}

/// Coordinates in threes as positions; `place` is the array's.
pub(super) fn positions(numbers: Numbers, place: &Place) -> Result<Vec<Vector3<f64>>, FormatError> {
    let values = numbers.into_reals();
    if let Some(index) = values.iter().position(|value| !value.is_finite()) {
        return Err(FormatError::new(
            place.clone(),
            format!("{} as a coordinate of point {}", values[index], index / 3),
            "finite coordinates",
        ));
    }
    Ok(values
        .chunks_exact(3)
        .map(|p| Vector3::new(p[0], p[1], p[2]))
        .collect())
}

/// The values of a region array of `cells` cells, or a note why they cannot be regions.
pub(super) fn region_values(
    name: &str,
    numbers: Numbers,
    cells: usize,
) -> Result<Vec<u32>, String> {
    let count = numbers.len();
    if count != cells {
        return Err(format!(
            "cell array \"{name}\" has {count} values for {cells} cells and is not used: every region is 0"
        ));
    }
    numbers
        .into_wholes()
        .and_then(|values| values.into_iter().map(|value| u32::try_from(value).ok()).collect())
        .ok_or_else(|| {
            format!(
                "cell array \"{name}\" holds values other than 0, 1, 2, … and is not used: every region is 0"
            )
        })
}

/// The vectors of an array of fibre directions of `cells` cells, or a note why they cannot be directions.
pub(super) fn direction_values(
    name: &str,
    numbers: Numbers,
    cells: usize,
) -> Result<Vec<Vector3<f64>>, String> {
    let values = numbers.into_reals();
    if Some(values.len()) != cells.checked_mul(3) {
        let count = values.len();
        return Err(format!(
            "cell array \"{name}\" has {count} values for {cells} vectors and is not used: there are no fibre directions"
        ));
    }
    let vectors = values.chunks_exact(3);
    Ok(vectors.map(|v| Vector3::new(v[0], v[1], v[2])).collect())
}
