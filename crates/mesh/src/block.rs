//! The block generator: cells of six or five tetrahedra (NUMERICS 5).

use crate::cell_split::cell_tets;
use crate::{CellSplit, Layer, TetMesh};
use nalgebra::Vector3;

/// Largest number of cells: their nodes and elements are then countable in 32 bits.
const MAX_CELLS: usize = 1 << 26;

/// A block of equal cells, parallel to the axes.
///
/// ```
/// use microsim_mesh::{Block, CellSplit};
///
/// // A cube of 2 cm: eight cells of six tetrahedra each.
/// let block = Block {
///     center: [0.0; 3],
///     size: [0.02; 3],
///     cells: [2; 3],
///     split: CellSplit::Kuhn,
/// };
/// let mesh = block.mesh()?;
/// assert_eq!((mesh.positions.len(), mesh.tets.len()), (27, 48));
/// let volume: f64 = mesh.volumes().iter().sum();
/// assert!((volume - 8e-6).abs() < 1e-18);
/// # Ok::<(), microsim_mesh::BlockError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Centre of the block \[m\].
    pub center: [f64; 3],
    /// Edge lengths \[m\], each > 0.
    pub size: [f64; 3],
    /// Number of cells along each axis, each ≥ 1.
    pub cells: [usize; 3],
    /// How the cells are cut.
    pub split: CellSplit,
}

/// Why a block cannot be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BlockError {
    /// The centre is not finite, or a size is not finite and positive.
    Size {
        /// The size that was asked for \[m\].
        size: [f64; 3],
    },
    /// No cell along an axis, or more cells in all than can be numbered.
    Cells {
        /// The numbers that were asked for.
        cells: [usize; 3],
    },
    /// Layers that are not in sum as thick as the block, or have not in sum as many cells along z.
    Layers {
        /// Thickness of all layers \[m\].
        thickness: f64,
        /// Cells of all layers.
        cells: usize,
    },
}

/// The thickness of all layers is that of the block up to this fraction: what decimal numbers leave of a sum.
const THICKNESS: f64 = 1e-9;

impl std::fmt::Display for BlockError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Size { size } => {
                write!(
                    f,
                    "a block needs a finite centre and three sizes above 0 m, not {size:?} m"
                )
            }
            Self::Cells { cells } => {
                write!(
                    f,
                    "a block needs at least 1 cell along each axis and at most {MAX_CELLS} in all, not {cells:?}"
                )
            }
            Self::Layers { thickness, cells } => write!(
                f,
                "the layers of a block are as thick in sum as its size along z, and have as many cells, not {thickness:?} m and {cells}"
            ),
        }
    }
}

impl std::error::Error for BlockError {}

impl Block {
    /// The mesh of the block: nodes in x-fastest order, six or five tetrahedra per cell.
    pub fn mesh(&self) -> Result<TetMesh, BlockError> {
        let sizes_valid = self.size.iter().all(|s| s.is_finite() && *s > 0.0);
        if !sizes_valid || !self.center.iter().all(|c| c.is_finite()) {
            return Err(BlockError::Size { size: self.size });
        }
        let total = self
            .cells
            .iter()
            .try_fold(1usize, |product, &n| product.checked_mul(n));
        if !total.is_some_and(|n| (1..=MAX_CELLS).contains(&n)) {
            return Err(BlockError::Cells { cells: self.cells });
        }

        let [nx, ny, nz] = self.cells;
        let coordinate = |axis: usize, i: usize| {
            self.center[axis] + self.size[axis] * (i as f64 / self.cells[axis] as f64 - 0.5)
        };
        let mut positions = Vec::with_capacity((nx + 1) * (ny + 1) * (nz + 1));
        for k in 0..=nz {
            for j in 0..=ny {
                for i in 0..=nx {
                    positions.push(Vector3::new(
                        coordinate(0, i),
                        coordinate(1, j),
                        coordinate(2, k),
                    ));
                }
            }
        }

        let node = |[i, j, k]: [usize; 3]| ((k * (ny + 1) + j) * (nx + 1) + i) as u32;
        let mut tets = Vec::with_capacity(self.split.tetrahedra() * nx * ny * nz);
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    for tet in cell_tets(self.split, [i, j, k]) {
                        tets.push(tet.map(node));
                    }
                }
            }
        }
        let regions = vec![0; tets.len()];
        Ok(TetMesh::new(positions, tets, regions))
    }

    /// The mesh of a block that consists of layers along z, from below: each has its thickness, cells and region.
    pub fn layered(&self, layers: &[Layer]) -> Result<TetMesh, BlockError> {
        let mut mesh = self.mesh()?;
        let thickness: f64 = layers.iter().map(|layer| layer.thickness).sum();
        let cells = layers.iter().map(|layer| layer.cells).sum();
        let positive = layers.iter().all(|layer| layer.thickness > 0.0);
        let fits = (thickness - self.size[2]).abs() <= THICKNESS * self.size[2];
        if !(positive && fits && cells == self.cells[2]) {
            return Err(BlockError::Layers { thickness, cells });
        }
        let below = self.center[2] - 0.5 * self.size[2];
        let (mut heights, mut regions) = (vec![below], Vec::with_capacity(cells));
        let mut bottom = 0.0;
        for layer in layers {
            heights.extend(
                (1..=layer.cells).map(|cell| {
                    below + bottom + layer.thickness * (cell as f64 / layer.cells as f64)
                }),
            );
            regions.extend(std::iter::repeat_n(layer.region, layer.cells));
            bottom += layer.thickness;
        }
        let [nx, ny, _] = self.cells;
        for (node, p) in mesh.positions.iter_mut().enumerate() {
            p.z = heights[node / ((nx + 1) * (ny + 1))];
        }
        for (element, region) in mesh.regions.iter_mut().enumerate() {
            *region = regions[element / (self.split.tetrahedra() * nx * ny)];
        }
        Ok(mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn blocks() -> Vec<Block> {
        let mut blocks = Vec::new();
        for cells in [[1, 1, 1], [2, 1, 1], [3, 2, 4], [20, 4, 2]] {
            for split in CellSplit::ALL {
                blocks.push(Block {
                    center: [0.003, -0.001, 0.0],
                    size: [0.02, 0.004, 0.001],
                    cells,
                    split,
                });
            }
        }
        blocks
    }

    #[test]
    fn layers_have_their_thickness_cells_and_regions() {
        for split in CellSplit::ALL {
            assert_layers(split);
        }
    }

    fn assert_layers(split: CellSplit) {
        let block = Block {
            center: [0.0, 0.0, 1.0],
            size: [2.0, 3.0, 0.5],
            cells: [2, 1, 3],
            split,
        };
        let layer = |thickness, cells, region| Layer {
            thickness,
            cells,
            region,
        };
        let layers = [layer(0.4, 1, 7), layer(0.1, 2, 3)];
        let mesh = block.layered(&layers).unwrap();
        let volume = |region: u32| -> f64 {
            let all = mesh.volumes().into_iter().zip(&mesh.regions);
            all.filter(|(_, r)| **r == region).map(|(v, _)| v).sum()
        };
        assert!((volume(7) - 2.4).abs() < 1e-14 && (volume(3) - 0.6).abs() < 1e-14);
        let count = |region| mesh.regions.iter().filter(|r| **r == region).count();
        let per_layer = 2 * split.tetrahedra();
        assert_eq!((count(7), count(3)), (per_layer, 2 * per_layer));
        let mut heights: Vec<f64> = mesh.positions.iter().map(|p| p.z).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup();
        for (found, expected) in heights.iter().zip([0.75, 1.15, 1.2, 1.25]) {
            assert!((found - expected).abs() < 1e-14);
        }
        for wrong in [
            &layers[..1],
            &[layer(0.4, 1, 7), layer(0.1, 1, 3)],
            &[layer(0.4, 1, 7), layer(0.2, 2, 3)],
            &[layer(0.6, 1, 7), layer(-0.1, 2, 3)],
        ] {
            assert!(matches!(
                block.layered(wrong),
                Err(BlockError::Layers { .. })
            ));
        }
    }

    #[test]
    fn every_element_is_positive_and_the_volumes_fill_the_block() {
        for block in blocks() {
            let mesh = block.mesh().unwrap();
            let cells: usize = block.cells.iter().product();
            let volume: f64 = block.size.iter().product();
            // Parts of the volume of a cell.
            let parts: &[f64] = match block.split {
                CellSplit::Kuhn | CellSplit::Mirrored => &[1.0 / 6.0; 6],
                CellSplit::Five => &[1.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0],
            };
            assert_eq!(mesh.tets.len(), parts.len() * cells);
            for (v, part) in mesh.volumes().iter().zip(parts.iter().cycle()) {
                // A few roundings of coordinates that are small against the cell's.
                let found = v * cells as f64 / volume;
                assert!((found / part - 1.0).abs() < 1e-12, "{v}");
            }
            let sum: f64 = mesh.volumes().iter().sum();
            assert!((sum / volume - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn mass_is_density_times_volume() {
        for block in blocks() {
            let mesh = block.mesh().unwrap();
            let densities = vec![1060.0; mesh.tets.len()];
            let mass: f64 = mesh.node_masses(&densities).iter().sum();
            let expected = 1060.0 * block.size.iter().product::<f64>();
            assert!((mass / expected - 1.0).abs() < 1e-13);
        }
    }

    /// A ball: Euler number of the solid V − E + F − T = 1, of its boundary V − E + F = 2; every directed boundary edge
    /// has its reverse; the boundary's enclosed volume (divergence theorem) is the block's, so it faces outward.
    #[test]
    fn the_surface_is_a_closed_outward_sphere() {
        for block in blocks() {
            let mesh = block.mesh().unwrap();
            let surface = mesh.surface();
            let [nx, ny, nz] = block.cells;
            assert_eq!(surface.triangles.len(), 4 * (nx * ny + ny * nz + nz * nx));

            let mut directed: BTreeMap<[u32; 2], i32> = BTreeMap::new();
            for t in &surface.triangles {
                for k in 0..3 {
                    let (i, j) = (t[k], t[(k + 1) % 3]);
                    *directed.entry([i.min(j), i.max(j)]).or_default() +=
                        if i < j { 1 } else { -1 };
                }
            }
            assert!(directed.values().all(|&sum| sum == 0));
            let boundary_euler =
                surface.nodes.len() as i64 - directed.len() as i64 + surface.triangles.len() as i64;
            assert_eq!(boundary_euler, 2);

            let faces = (4 * mesh.tets.len() + surface.triangles.len()) / 2;
            let euler = mesh.positions.len() as i64 - mesh.edges().len() as i64 + faces as i64
                - mesh.tets.len() as i64;
            assert_eq!(euler, 1);

            let enclosed: f64 = surface
                .triangles
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(|node| mesh.positions[node as usize]);
                    signed_volume_from_origin(a, b, c)
                })
                .sum();
            let volume: f64 = block.size.iter().product();
            assert!((enclosed / volume - 1.0).abs() < 1e-12);
        }
    }

    fn signed_volume_from_origin(a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>) -> f64 {
        a.dot(&b.cross(&c)) / 6.0
    }

    /// Block of nx·ny·nz cells: edges along the axes, one diagonal per face, and one per cell of six tetrahedra.
    #[test]
    fn unique_edges_are_counted_by_formula() {
        for block in blocks() {
            let mesh = block.mesh().unwrap();
            let [x, y, z] = block.cells;
            let axes = x * (y + 1) * (z + 1) + (x + 1) * y * (z + 1) + (x + 1) * (y + 1) * z;
            let diagonals = x * y * (z + 1) + x * (y + 1) * z + (x + 1) * y * z;
            let within = match block.split {
                CellSplit::Kuhn | CellSplit::Mirrored => x * y * z,
                CellSplit::Five => 0,
            };
            assert_eq!(mesh.edges().len(), axes + diagonals + within);
        }
        let cube = Block {
            center: [0.0; 3],
            size: [1.0; 3],
            cells: [1; 3],
            split: CellSplit::Kuhn,
        }
        .mesh()
        .unwrap();
        let expected = (12.0 + 6.0 * 2f64.sqrt() + 3f64.sqrt()) / 19.0;
        assert!((cube.mean_edge_length() - expected).abs() < 1e-15);
    }

    /// The diagonals of the cells: all along (1, 1, 1) in Kuhn cells, as many along each of the four space diagonals in
    /// mirrored ones, where the numbers of cells are even.
    #[test]
    fn mirrored_cells_prefer_no_diagonal() {
        for (split, expected) in [
            (CellSplit::Kuhn, [64, 0, 0, 0]),
            (CellSplit::Mirrored, [16; 4]),
        ] {
            let mesh = Block {
                center: [0.0; 3],
                size: [4.0; 3],
                cells: [4; 3],
                split,
            }
            .mesh()
            .unwrap();
            let mut counts = [0; 4];
            for [i, j] in mesh.edges() {
                let edge = mesh.positions[j as usize] - mesh.positions[i as usize];
                if (edge.norm_squared() - 3.0).abs() < 1e-9 {
                    let edge = edge * edge.z.signum();
                    counts[usize::from(edge.x < 0.0) + 2 * usize::from(edge.y < 0.0)] += 1;
                }
            }
            assert_eq!(counts, expected);
            assert_eq!(crate::defects(&mesh), []);
        }
    }

    #[test]
    fn ids_name_every_node_and_element_once() {
        let mesh = blocks()[2].mesh().unwrap();
        assert!(
            mesh.node_ids.windows(2).all(|pair| pair[0] < pair[1])
                && mesh.node_ids.len() == mesh.positions.len()
        );
        assert!(
            mesh.element_ids.windows(2).all(|pair| pair[0] < pair[1])
                && mesh.element_ids.len() == mesh.tets.len()
        );
        assert_eq!(mesh.generation, 0);
    }

    #[test]
    fn impossible_blocks_are_refused() {
        let good = Block {
            center: [0.0; 3],
            size: [1.0; 3],
            cells: [1; 3],
            split: CellSplit::Kuhn,
        };
        for size in [[0.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, f64::NAN]] {
            assert!(matches!(
                Block { size, ..good }.mesh(),
                Err(BlockError::Size { .. })
            ));
        }
        for cells in [[0, 1, 1], [usize::MAX, 2, 1], [1 << 9, 1 << 9, 1 << 9]] {
            assert!(matches!(
                Block { cells, ..good }.mesh(),
                Err(BlockError::Cells { .. })
            ));
        }
        assert!(
            Block {
                center: [f64::INFINITY, 0.0, 0.0],
                ..good
            }
            .mesh()
            .is_err()
        );
    }
}
