//! Tetrahedral meshes: connectivity, generators, surface, volumes.
//!
//! What is here: the mesh with stable ids, the block generator, everything that follows from connectivity. What is not:
//! physics, files, topology edits (they come with cutting; ids and the generation are here for them). Pure: same input,
//! same bits. Tetrahedra are positive: `signed_volume` > 0 for their node order.

mod block;
pub mod format;
mod surface;
mod tet_mesh;
mod triangle_surface;

pub use block::{Block, BlockError};
pub use microsim_geometry::signed_volume;
pub use surface::Surface;
pub use tet_mesh::TetMesh;
pub use triangle_surface::TriangleSurface;
