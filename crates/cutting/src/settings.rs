//! How a cut is made, and its limits.

use crate::change::TopologyChange;

/// How a cut is made, and its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How the mesh changes where the blade has gone.
    pub change: TopologyChange,
    /// Edges are divided no nearer to an end than this fraction (NUMERICS 3.5 a). The cut goes through a nearer end instead where that may be: it strays by as much as with a
    /// new node at this fraction, but without the slivers beside that.
    pub least_fraction: f64,
    /// An edge shorter than this fraction of the mean edge of the whole mesh is not divided: the cut goes through its nearer end, and so
    /// strays by half of it at most. With twice the least fraction that is no more than on a whole edge.
    pub least_edge: f64,
    /// No division leaves an element with less than this fraction of the mean volume of the whole mesh (NUMERICS 3.5 e).
    pub least_volume: f64,
    /// The teeth that nodes beside the path leave on the lips of a cut: what another cut would take off them with less than this fraction of the
    /// mean volume stays on.
    pub flake_volume: f64,
    /// So does what is thinner, on the mean, than this fraction of the mean edge: less than the least fraction, within which a cut strays.
    pub flake_thickness: f64,
    /// What comes off with less than this fraction of the mean volume is a crumb and is taken away.
    pub crumb_volume: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            change: TopologyChange::default(),
            least_fraction: 0.15,
            least_edge: 0.3,
            least_volume: 1e-3,
            flake_volume: 0.4,
            flake_thickness: 0.05,
            crumb_volume: 1e-3,
        }
    }
}
