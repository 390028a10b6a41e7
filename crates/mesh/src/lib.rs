//! Tetrahedral meshes: generators, files, connectivity, edits of the topology, validity.
//!
//! What is here: the mesh with stable ids and regions; blocks, tubes of layers, closed surfaces filled with tetrahedra; uniform and local refinement;
//! the boundary and parts of it; reports on what is wrong with a mesh or surface, with place and
//! remedy. What is not: physics, reading and writing of disks (formats turn bytes into meshes
//! and back), deciding what is cut (edits of the topology are carried out here, made elsewhere). Pure: same input, same
//! bits. Tetrahedra are positive: `signed_volume` > 0 for their node order.

#![forbid(unsafe_code)]

mod block;
mod box_grid;
mod cell_split;
mod defects;
mod detach;
mod edit;
mod fill;
pub mod format;
mod grade;
mod quality;
mod refine;
mod surface;
mod surface_defect;
mod tet_mesh;
mod topology;
mod triangle_surface;
mod tube;

pub use block::{Block, BlockError};
pub use defects::{COINCIDING, Defect, FLAT, Named, Severity, defects, defects_but_detached};
pub use detach::Detached;
pub use edit::{Applied, CutFace, EditError, NewNode, Replaced, Replacement, Side, TopologyEdit};
pub use fill::{FillError, Fitted, LEAST_HEIGHT, MAX_DIHEDRAL, MIN_DIHEDRAL, fill, fit_lattice};
pub use grade::{GradeError, Graded, Grading, Zone};
pub use microsim_geometry::signed_volume;
pub use microsim_vocabulary::CellSplit;
pub use quality::ElementQuality;
pub use refine::{PARTS, Refined};
pub use surface::Surface;
pub use surface_defect::SurfaceDefect;
pub use tet_mesh::{FAMILIES, TetMesh};
pub use triangle_surface::TriangleSurface;
pub use tube::{Arc, Layer, Tube, TubeError, TubeSide};
