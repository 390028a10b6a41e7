//! Cutting and tearing: from the path of a blade, or from faces that fail, to one atomic edit of a tetrahedral mesh.
//!
//! What is here: [`Topology`], the connectivity of a body updated edit by edit; [`Blade`]s that stand still or move through
//! tissue that moves; the six patterns by which elements are divided ([`divide`]); what opens, comes off and is laid open ([`Cut`]);
//! tears; the coarsening of what cuts have left behind ([`Topology::coarsen`]); and the check of all that ([`check`]). What is not: forces, tools, when to cut, files,
//! clocks, threads. Pure: the same input gives the same bits.
//!
//! A step goes so. Every edge that the blade has crossed gets a node on the path ([`Sweep`], [`Sheet`]), a new one or one of its ends where that is near, and all elements at it are divided
//! at once, each by the pattern for its crossed edges (dissertation, appendix B; NUMERICS 4): neighbours fit as every decision is that
//! of an edge or a face alone. Then faces with all three nodes on the path and elements on both sides of it come apart: nodes are
//! doubled once per group of elements that hang together by faces around them (NUMERICS 4.9). So the mesh is conforming and its surface
//! closed after every step, with the blade inside too, and no face opens that the blade has not passed.
//!
//! This differs from the dissertation (4.2.1) in one point. There an element is divided when the blade has left it, and a partial pattern opens to the
//! edge opposite: a crack that the blade did not make, and beside which it goes on. Here a [`Stroke`] remembers the nodes on the path, and
//! what is cut in part is divided and holds together until the blade has passed it. The dissertation's method and two older ones are there beside it
//! ([`TopologyChange`]).
//!
//! A stroke that ends inside tissue leaves the edge of its cut in the topology, and the next goes on from there: a blade may be drawn back
//! and set in again, in any number of strokes, without a bridge between them.
//!
//! A hand trembles and turns back. Which nodes lie on which side of a stroke's path is found at the edges that it crosses, and remembered around the
//! blade; where the path comes around a node that it had passed, that node is on the path; elements that come to lie in the cut itself are given to one
//! side. So a stroke separates what it has swept between, and does not shed what lies in the cut.
//!
//! Limitations: a blade that meets no edge, as it is narrower than an element, cuts nothing. The cut goes through nodes that the blade passes nearby, and where elements have become too small to be divided
//! ([`Settings`]). A cut that comes within an element of the edge of an older one goes through its nodes. What another
//! cut would take off the lips of an older one in less than 0.4 of an element or thinner than 0.05 of an edge stays on. What a stroke
//! leaves joined that crosses its own path is parted when the blade has gone on by more than an edge or has left the tissue. A loop that is only two or three edges across may then fall into several
//! parts, along faces that no blade has passed.

#![forbid(unsafe_code)]

mod blade;
mod change;
mod check;
mod clusters;
mod coarsen;
mod crossing;
mod cut;
mod decide;
mod editor;
mod fibre;
mod flow;
mod mend;
mod moves;
mod opening;
mod path;
mod pattern;
mod pieces;
mod remove;
mod report;
mod settings;
mod sheet;
mod stroke;
mod sweep;
mod swept;
mod tear;
mod topology;
mod waiting;

pub use blade::Blade;
pub use change::TopologyChange;
pub use check::{Flaw, Measures, check};
pub use crossing::Crossing;
pub use fibre::Fibre;
pub use path::PathPoints;
pub use pattern::{EDGES, EdgeSet, PATTERNS, Pattern, PatternNode, Row, divide};
pub use report::{Cut, Opened, Rejected, SurfaceChange};
pub use settings::Settings;
pub use sheet::Sheet;
pub use stroke::{PassedNode, Stroke, Waiting};
pub use sweep::Sweep;
pub use swept::Swept;
pub use topology::{SurfaceTriangle, Topology, TopologyState};
