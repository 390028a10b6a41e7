//! Tetrahedral meshes: connectivity, generators, surface, volumes.
//!
//! What is here: the mesh with stable ids, the block generator, everything that follows from connectivity. What is not:
//! physics, files, topology edits (they come with cutting; ids and the generation are here for them). Pure: same input,
//! same bits. Tetrahedra are positive: `signed_volume` > 0 for their node order.

mod block;
mod box_grid;
mod cell_split;
mod defects;
mod fill;
pub mod format;
mod quality;
mod surface;
mod surface_defect;
mod tet_mesh;
mod topology;
mod triangle_surface;
mod tube;

pub use block::{Block, BlockError};
pub use cell_split::CellSplit;
pub use defects::{COINCIDING, Defect, FLAT, Named, Severity, defects};
pub use fill::{FillError, MAX_DIHEDRAL, MIN_DIHEDRAL, fill};
pub use microsim_geometry::signed_volume;
pub use quality::{
    Distribution, ElementQuality, HISTOGRAM_BINS, Histogram, QualityReport, RankedElement,
};
pub use surface::Surface;
pub use surface_defect::SurfaceDefect;
pub use tet_mesh::TetMesh;
pub use triangle_surface::TriangleSurface;
pub use tube::{Arc, Layer, Tube, TubeError, TubeSide};
