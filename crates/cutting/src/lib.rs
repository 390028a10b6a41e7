//! Cutting and tearing: from the path of a blade to the edit of a mesh.
mod check;
mod clusters;
mod cut;
mod decide;
mod editor;
mod material_point;
mod pattern;
mod pieces;
mod report;
mod sheet;
mod stroke;
mod sweep;
mod tear;
#[cfg(test)]
mod testing;
mod topology;

pub use check::{Flaw, Measures, check};
pub use cut::{Blade, Settings};
pub use material_point::MaterialPoint;
pub use pattern::{
    EDGES, EdgeSet, PATTERNS, Pattern, PatternNode, Row, divide, is_divisible, pattern_of,
};
pub use report::{Cut, Opened, Rejected, SurfaceChange};
pub use sheet::Sheet;
pub use stroke::Stroke;
pub use sweep::Sweep;
pub use topology::{SurfaceTriangle, Topology, TopologyState};
