//! What training modules measure of tissue: marks, grips, cuts, pieces, vessels, from messages about nodes, contact forces and cuts alone.

mod bites;
mod body_forces;
mod contacts;
mod cuts;
mod delivery;
mod free_length;
mod layer_grips;
mod mark_line;
mod marks;
mod opening;
mod patch;
mod patency;
mod path;
mod pieces;
mod rim;
mod ring;
mod shape;
#[cfg(test)]
mod test_tube;
mod vessel_axis;
mod vessel_wall;
mod wall_injury;

pub use bites::Bites;
pub use body_forces::BodyForces;
pub use contacts::{Contacts, Grasp, Grip, Releases};
pub use cuts::{Assignment, CutFindings, CutLog};
pub use delivery::{Delivered, Delivery};
pub use free_length::FreeLength;
pub use layer_grips::{LayerGrip, LayerGrips};
pub use mark_line::MarkLine;
pub use marks::{colour, mark_colour, mark_places, show_colour, show_mark};
pub use opening::Opening;
pub use patch::{Patch, PatchPlace};
pub use patency::Patency;
pub use pieces::{PieceView, Probes};
pub use rim::Rim;
pub use ring::Ring;
pub use shape::{BodyShape, Loop};
pub use vessel_axis::VesselAxis;
pub use vessel_wall::VesselWall;
pub use wall_injury::{LayerInjury, WallInjury};

use crate::fault::Fault;
use microsim_settings::ModuleConfig;
use nalgebra::Vector3;

/// The name of the tissue of a level: its first body. A fault where it has none.
pub fn tissue_of(config: &ModuleConfig) -> Result<String, Fault> {
    let body = config.bodies.first().cloned();
    body.ok_or_else(|| Fault::new("the level needs a [[body]]: the tissue"))
}

/// Distance of two points \[m\].
pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (Vector3::from(a) - Vector3::from(b)).norm()
}

/// Row of the node with an id in the arrays of a snapshot. Ids are stable, but not in order: a cut may move nodes to other rows.
pub(crate) fn row_of(ids: &[u32], id: u32) -> Option<usize> {
    ids.iter().position(|other| *other == id)
}

/// Place of a node of a snapshot \[m\].
pub(crate) fn place_of(positions: &[f64], row: usize) -> [f64; 3] {
    [0, 1, 2].map(|k| positions[3 * row + k])
}
