//! The tube generator: walls of vessels (dissertation 4.1, NUMERICS 5).
//!
//! The section is a polygon whose corners lie on the exact radii; its area is less than the ring's by the factor
//! sin(2π/n)/(2π/n). Six tetrahedra per cell, or five; a ring of an odd number of cells closes only with six that are all alike.

use crate::cell_split::{cell_tets, is_mirrored};
use crate::{CellSplit, Surface, TetMesh};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Largest number of cells: their nodes and elements are then countable in 32 bits.
const MAX_CELLS: usize = 1 << 26;

/// A layer of the wall of a tube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Thickness \[m\], > 0.
    pub thickness: f64,
    /// Number of cells through the layer, ≥ 1.
    pub cells: usize,
    /// Region of its elements.
    pub region: u32,
}

/// What part of the full turn a tube covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arc {
    /// All of it: the tube is closed around.
    Full,
    /// A sector: the tube is open along its length.
    Sector {
        /// Where it begins \[rad\], from the first direction of [`Tube::frame`].
        start: f64,
        /// How far it goes \[rad\], above 0 and below 2π.
        angle: f64,
    },
}

/// A straight tube of one or several layers.
///
/// ```
/// use microsim_mesh::{Arc, CellSplit, Layer, Tube, TubeSide};
///
/// // A vessel of 1 mm with media (region 0) and adventitia (region 1).
/// let layer = |thickness, region| Layer { thickness, cells: 1, region };
/// let tube = Tube {
///     center: [0.0; 3],
///     axis: [0.0, 0.0, 1.0],
///     inner_radius: 0.38e-3,
///     layers: vec![layer(80e-6, 0), layer(40e-6, 1)],
///     length: 5e-3,
///     around: 12,
///     along: 20,
///     arc: Arc::Full,
///     split: CellSplit::Kuhn,
/// };
/// let mesh = tube.mesh()?;
/// assert_eq!(mesh.tets.len(), 12 * 20 * 2 * 6);
/// // The wall of the lumen: two triangles per cell.
/// assert_eq!(tube.side(&mesh, TubeSide::Inner).triangles.len(), 12 * 20 * 2);
/// # Ok::<(), microsim_mesh::TubeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Tube {
    /// Middle of the axis \[m\].
    pub center: [f64; 3],
    /// Direction of the axis; its length does not matter.
    pub axis: [f64; 3],
    /// Radius of the inner wall \[m\], > 0.
    pub inner_radius: f64,
    /// The layers from the inside to the outside, at least one.
    pub layers: Vec<Layer>,
    /// Length along the axis \[m\], > 0.
    pub length: f64,
    /// Number of cells around: at least 3 in a full turn, and less than half a turn each in a sector.
    pub around: usize,
    /// Number of cells along the axis, ≥ 1.
    pub along: usize,
    /// Closed around or open.
    pub arc: Arc,
    /// How the cells are cut.
    pub split: CellSplit,
}

/// A part of the boundary of a tube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TubeSide {
    /// The wall of the lumen.
    Inner,
    /// The outside of the last layer.
    Outer,
    /// The end against the direction of the axis.
    Start,
    /// The end in the direction of the axis.
    End,
}

/// Why a tube cannot be built.
#[derive(Clone, Debug, PartialEq)]
pub enum TubeError {
    /// A centre that is not finite, or an axis without direction.
    Place {
        /// The centre that was asked for \[m\].
        center: [f64; 3],
        /// The axis that was asked for.
        axis: [f64; 3],
    },
    /// A length or radius that is not finite and positive.
    Size {
        /// Which one: `inner_radius` or `length`.
        field: &'static str,
        /// Its value \[m\].
        value: f64,
    },
    /// No layer, or one without thickness or cells.
    Layer {
        /// Its index; 0 when there is none.
        layer: usize,
    },
    /// A sector that is not above 0 and below a full turn.
    Sector {
        /// The angle that was asked for \[rad\].
        angle: f64,
    },
    /// Too few cells around or along, or more than can be numbered.
    Cells {
        /// Cells around.
        around: usize,
        /// Cells along.
        along: usize,
    },
    /// Cells that are mirrored in a ring of an odd number.
    OddRing {
        /// Cells around.
        around: usize,
    },
}

impl std::fmt::Display for TubeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Place { center, axis } => write!(
                f,
                "a tube needs a finite centre and an axis with a direction, not center {center:?} m and axis {axis:?}"
            ),
            Self::Size { field, value } => {
                write!(
                    f,
                    "a tube needs a finite {field} above 0 m, not {value:?} m"
                )
            }
            Self::Layer { layer } => write!(
                f,
                "layer {layer} of the tube is missing or empty: give each layer a finite thickness above 0 m and at least 1 cell"
            ),
            Self::Sector { angle } => write!(
                f,
                "the sector of an open tube needs a finite start and an angle above 0 and below 2π rad, not {angle:?} rad; use a full arc for a closed tube"
            ),
            Self::Cells { around, along } => write!(
                f,
                "a tube needs at least 3 cells in a full turn (each cell below half a turn), at least 1 along and at most {MAX_CELLS} in all, not {around} around and {along} along"
            ),
            Self::OddRing { around } => write!(
                f,
                "mirrored cells close around only in even numbers, not {around}: take one more or less, or Kuhn cells"
            ),
        }
    }
}

impl std::error::Error for TubeError {}

impl Tube {
    /// The mesh of the tube. Nodes run through the wall first, then along, then around; so do the cells, six or five
    /// elements each. Every layer has the region it names.
    pub fn mesh(&self) -> Result<TetMesh, TubeError> {
        self.check()?;
        let cells_through: usize = self.layers.iter().map(|layer| layer.cells).sum();
        let [first, second, axis] = self.frame();
        let center = Vector3::from(self.center);
        let radii = self.radii();
        let (start, angle) = match self.arc {
            Arc::Full => (0.0, 2.0 * PI),
            Arc::Sector { start, angle } => (start, angle),
        };

        let columns = self.columns();
        let mut positions = Vec::with_capacity(columns * (self.along + 1) * radii.len());
        for a in 0..columns {
            let phi = start + angle * (a as f64 / self.around as f64);
            let direction = first * libm::cos(phi) + second * libm::sin(phi);
            for l in 0..=self.along {
                let along = axis * (self.length * (l as f64 / self.along as f64 - 0.5));
                positions.extend(
                    radii
                        .iter()
                        .map(|&radius| center + along + direction * radius),
                );
            }
        }

        let node = |[a, l, r]: [usize; 3]| {
            (((a % columns) * (self.along + 1) + l) * radii.len() + r) as u32
        };
        let cell_regions: Vec<u32> = self
            .layers
            .iter()
            .flat_map(|layer| std::iter::repeat_n(layer.region, layer.cells))
            .collect();
        let elements = self.split.tetrahedra() * self.around * self.along * cells_through;
        let mut tets = Vec::with_capacity(elements);
        let mut regions = Vec::with_capacity(elements);
        for a in 0..self.around {
            for l in 0..self.along {
                for (r, &region) in cell_regions.iter().enumerate() {
                    // Around, along, outward: right-handed, like the frame.
                    for tet in cell_tets(self.split, [a, l, r]) {
                        tets.push(tet.map(node));
                        regions.push(region);
                    }
                }
            }
        }
        Ok(TetMesh::new(positions, tets, regions))
    }

    /// Right-handed unit vectors: the directions of the angles 0 and π/2, and the axis. An axis along x has y and z; the
    /// first direction is the coordinate axis after the one closest to the tube's axis, turned perpendicular to it.
    pub fn frame(&self) -> [Vector3<f64>; 3] {
        let axis = Vector3::from(self.axis);
        let axis = axis / axis.norm();
        let next = (axis.iamax() + 1) % 3;
        let mut first = Vector3::zeros();
        first[next] = 1.0;
        first -= axis * axis[next];
        first /= first.norm();
        [first, axis.cross(&first), axis]
    }

    /// The point between two others where the wall is round \[m\]: of the mean of their radii, in the middle around and along. Two that face each
    /// other across the axis have none around; theirs is on the line.
    pub fn between(&self, a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
        let [_, _, axis] = self.frame();
        let center = Vector3::from(self.center);
        let across = |p: &Vector3<f64>| {
            let from = p - center;
            from - axis * axis.dot(&from)
        };
        let middle = (a + b) * 0.5;
        let (radius, towards) = (0.5 * (across(a).norm() + across(b).norm()), across(&middle));
        match towards.norm() > 1e-9 * radius {
            true => middle - towards + towards * (radius / towards.norm()),
            false => middle,
        }
    }

    /// The triangles on `side` of the boundary of `mesh`, which this tube has made, outward.
    pub fn side(&self, mesh: &TetMesh, side: TubeSide) -> Surface {
        let through = 1 + self.layers.iter().map(|layer| layer.cells).sum::<usize>();
        mesh.surface().within(|node| {
            let (r, l) = (
                node as usize % through,
                node as usize / through % (self.along + 1),
            );
            match side {
                TubeSide::Inner => r == 0,
                TubeSide::Outer => r + 1 == through,
                TubeSide::Start => l == 0,
                TubeSide::End => l == self.along,
            }
        })
    }

    /// Number of node columns around.
    fn columns(&self) -> usize {
        match self.arc {
            Arc::Full => self.around,
            Arc::Sector { .. } => self.around + 1,
        }
    }

    /// Radii of the nodes through the wall \[m\].
    fn radii(&self) -> Vec<f64> {
        let mut inner = self.inner_radius;
        let mut radii = vec![inner];
        for layer in &self.layers {
            radii.extend(
                (1..=layer.cells)
                    .map(|i| inner + layer.thickness * (i as f64 / layer.cells as f64)),
            );
            inner += layer.thickness;
        }
        radii
    }

    fn check(&self) -> Result<(), TubeError> {
        let axis = Vector3::from(self.axis);
        let directed = axis.norm().is_finite() && axis.norm() > 0.0;
        if !directed || !self.center.iter().all(|c| c.is_finite()) {
            return Err(TubeError::Place {
                center: self.center,
                axis: self.axis,
            });
        }
        let positive = |value: f64| value.is_finite() && value > 0.0;
        for (field, value) in [("inner_radius", self.inner_radius), ("length", self.length)] {
            if !positive(value) {
                return Err(TubeError::Size { field, value });
            }
        }
        let empty = |layer: &Layer| !positive(layer.thickness) || layer.cells == 0;
        if self.layers.is_empty() || self.layers.iter().any(empty) {
            let layer = self.layers.iter().position(empty).unwrap_or(0);
            return Err(TubeError::Layer { layer });
        }
        let least_around = match self.arc {
            Arc::Full => 3,
            Arc::Sector { start, angle } => {
                if !(start.is_finite() && angle > 0.0 && angle < 2.0 * PI) {
                    return Err(TubeError::Sector { angle });
                }
                if angle < PI { 1 } else { 2 }
            }
        };
        let through = self
            .layers
            .iter()
            .try_fold(0usize, |sum, layer| sum.checked_add(layer.cells));
        let total = through
            .and_then(|n| n.checked_mul(self.around))
            .and_then(|n| n.checked_mul(self.along));
        if self.around < least_around || !total.is_some_and(|n| (1..=MAX_CELLS).contains(&n)) {
            return Err(TubeError::Cells {
                around: self.around,
                along: self.along,
            });
        }
        if is_mirrored(self.split) && self.arc == Arc::Full && self.around % 2 == 1 {
            return Err(TubeError::OddRing {
                around: self.around,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
