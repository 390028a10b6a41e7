//! Tetrahedral bodies as levels and scenes describe them: mesh, materials, clamps, couplings, loads, start.
//!
//! Frames: a block or tube is given in the frame of its level or scene, everything else of a body in the body's frame: origin
//! at `centre`, axes parallel. Everything is in SI.

use crate::colour::Colour;
use microsim_vocabulary::{CellSplit, Discretisation, Finish, LawName, terms};
use serde::{Deserialize, Serialize};

/// Most tetrahedra of a body: a few gigabytes.
pub const MAX_ELEMENTS: u64 = 5_000_000;

/// A tetrahedral body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Its name.
    pub name: String,
    /// What makes its mesh; the checks see to it that what each generator needs is there, and nothing else.
    pub generator: Generator,
    /// Sides of a block \[m\].
    pub size: Option<[f64; 3]>,
    /// Cells along each side of a block.
    pub cells: Option<[u32; 3]>,
    /// Radius of the lumen of a tube \[m\].
    pub inner_radius: Option<f64>,
    /// Layers of the wall of a tube, from the inside.
    pub layer: Vec<Layer>,
    /// Of a tube along its axis \[m\].
    pub length: Option<f64>,
    /// Cells around a tube.
    pub around: Option<u32>,
    /// Cells along a tube.
    pub along: Option<u32>,
    /// Direction of the axis of a tube; x if `None`.
    pub axis: Option<[f64; 3]>,
    /// Where the sector of a tube begins \[rad\].
    pub arc_start: Option<f64>,
    /// Angle of the sector of a tube \[rad\]; a full turn if `None`.
    pub arc: Option<f64>,
    /// How the cells of a block or tube are cut; `kuhn` if `None`.
    pub split: Option<CellSplit>,
    /// Path of a mesh from the file's own folder.
    pub file: Option<String>,
    /// Length of one unit of the mesh file \[m\]; 1 m if `None`.
    pub scale: Option<f64>,
    /// Size of the cells that fill a closed surface \[m\].
    pub fill: Option<f64>,
    /// Middle of a block or tube, place of the origin of a mesh file \[m\].
    pub centre: [f64; 3],
    /// Drag per mass \[1/s\].
    pub drag: f64,
    /// Colour.
    pub colour: Colour,
    /// How its surface answers light.
    pub finish: Finish,
    /// Force per length of a perfectly sharp edge that cuts it, that is work per area \[N/m\]; `None` for tissue that no single edge cuts.
    pub toughness: Option<f64>,
    /// From 0, like rubber, to 1: how early jaws pinch it off.
    pub brittleness: f64,
    /// What its regions are made of.
    pub material: Vec<Material>,
    /// What holds it.
    pub clamp: Vec<Clamp>,
    /// What joins its regions, where they share no nodes.
    pub coupling: Vec<Coupling>,
    /// What acts on its surface.
    pub load: Vec<Load>,
    /// How it lies and moves at the start, other than at rest.
    pub start: Vec<Start>,
}

impl Body {
    /// The files that its mesh is made of, from the folder of this one: two for TetGen, whose nodes have a file of their own.
    pub fn files(&self) -> Vec<String> {
        let Some(file) = &self.file else {
            return Vec::new();
        };
        match file.rsplit_once('.') {
            Some((stem, ending)) if ["node", "ele"].contains(&ending.to_lowercase().as_str()) => {
                vec![format!("{stem}.node"), format!("{stem}.ele")]
            }
            _ => vec![file.clone()],
        }
    }

    /// Number of tetrahedra, if that stands in the settings: six per cell.
    pub fn elements(&self) -> Option<u64> {
        let cells: u64 = match self.generator {
            Generator::Block => self.cells?.into_iter().map(u64::from).product(),
            Generator::Tube => {
                let through: u64 = self.layer.iter().map(|l| u64::from(l.cells)).sum();
                through * u64::from(self.around?) * u64::from(self.along?)
            }
            Generator::File => return None,
        };
        Some(6 * cells)
    }
}

terms! {
    /// What makes a mesh.
    pub enum Generator {
        /// A regular box of tetrahedra.
        Block = "block",
        /// A tube of one or several layers.
        Tube = "tube",
        /// A file: tetrahedra, or a closed surface that is filled.
        File = "file",
    }
}

/// A layer of the wall of a tube.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layer {
    /// \[m\]
    pub thickness: f64,
    /// Cells through the layer.
    pub cells: u32,
    /// Region of its elements.
    pub region: u32,
}

/// Nodes of a body, in its frame and at rest: all, or those that fulfil everything that is said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Nodes {
    /// Corner with the smallest coordinates of a box \[m\].
    pub min: Option<[f64; 3]>,
    /// Corner with the largest coordinates \[m\].
    pub max: Option<[f64; 3]>,
    /// Distances from an axis.
    pub shell: Option<Shell>,
    /// The one node nearest to this point \[m\].
    pub nearest: Option<[f64; 3]>,
}

/// A range of distances from an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shell {
    /// A point of the axis \[m\].
    pub point: [f64; 3],
    /// Direction of the axis, of length 1.
    pub axis: [f64; 3],
    /// Smallest and largest distance \[m\].
    pub radius: [f64; 2],
}

/// Nodes that are held, and how what holds them moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clamp {
    /// Which.
    pub nodes: Nodes,
    /// A point of the axis of rotation \[m\].
    pub pivot: [f64; 3],
    /// Axis of rotation, of length 1.
    pub axis: [f64; 3],
    /// How they are moved, by ascending time; empty for a clamp that stands.
    pub motion: Vec<MotionKey>,
    /// When it lets go \[s\]; `None` for never.
    pub release: Option<f64>,
}

/// Where a motion is at a time; between two keys it is interpolated linearly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionKey {
    /// \[s\]
    pub time: f64,
    /// Translation \[m\].
    pub shift: [f64; 3],
    /// Right-handed angle about the axis \[rad\].
    pub angle: f64,
}

/// A soft, two-sided coupling of the nodes of one region to the surface of another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// Region whose nodes are coupled.
    pub from: u32,
    /// Region to whose surface they are coupled.
    pub to: u32,
    /// Per area \[N/m³\].
    pub stiffness: f64,
    /// Distance at which a node tears off \[m\]; `None` for never.
    pub break_distance: Option<f64>,
}

/// A load on part of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// The triangles all of whose nodes are among these.
    pub surface: Nodes,
    /// Against the outward normal of the deformed surface \[Pa\].
    pub pressure: Option<f64>,
    /// Force per area at rest that keeps its direction \[Pa\].
    pub traction: Option<[f64; 3]>,
    /// Time to the full value \[s\].
    pub ramp: f64,
}

/// Where nodes are at the start, p = pivot + matrix (p_rest − pivot) + shift, and how fast.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// Which; those that are clamped stay.
    pub nodes: Nodes,
    /// Rows of the matrix.
    pub matrix: [[f64; 3]; 3],
    /// Fixed point of the matrix \[m\].
    pub pivot: [f64; 3],
    /// \[m\]
    pub shift: [f64; 3],
    /// \[m/s\]
    pub velocity: [f64; 3],
}

/// What a region is made of; the checks see to it that what each law needs is there, and nothing else.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// The region; all that no other material names if `None`.
    pub region: Option<u32>,
    /// \[kg/m³\]
    pub density: f64,
    /// Its law.
    pub law: Law,
    /// Strain across a plane at which it tears by itself; `None` for never.
    pub tear_strain: Option<f64>,
    /// Time of Kelvin–Voigt damping \[s\].
    pub relaxation_time: Option<f64>,
    /// Viscosity of Kelvin–Voigt damping in uniaxial stretch \[Pa s\].
    pub viscosity: Option<f64>,
    /// Young's modulus \[Pa\].
    pub youngs_modulus: Option<f64>,
    /// Poisson's ratio.
    pub poisson_ratio: Option<f64>,
    /// Elements of a continuum.
    pub discretisation: Option<Discretisation>,
    /// What the constants of springs mean.
    pub form: Option<SpringForm>,
    /// Stiffness of springs against a change of length \[Pa\], form `scaled`.
    pub stretch_modulus: Option<f64>,
    /// Stiffness of triangles against a change of area \[Pa\], form `scaled`.
    pub area_modulus: Option<f64>,
    /// Stiffness of tetrahedra against a change of volume \[Pa\], form `scaled`.
    pub volume_modulus: Option<f64>,
    /// Constant of each edge, forms `plain` \[N/m\] and `normalised` \[J\].
    pub length_stiffness: Option<f64>,
    /// Constant of each triangle, forms `plain` \[N/m³\] and `normalised` \[J\].
    pub area_stiffness: Option<f64>,
    /// Constant of each tetrahedron, forms `plain` \[N/m⁵\] and `normalised` \[J\].
    pub volume_stiffness: Option<f64>,
    /// Damping of each edge, forms `plain` \[N s/m\] and `normalised` \[J s\].
    pub length_damping: Option<f64>,
    /// Damping of each triangle, forms `plain` \[N s/m³\] and `normalised` \[J s\].
    pub area_damping: Option<f64>,
    /// Damping of each tetrahedron, forms `plain` \[N s/m⁵\] and `normalised` \[J s\].
    pub volume_damping: Option<f64>,
    /// Plastic flow of springs.
    pub plasticity: Option<Plasticity>,
}

/// The law of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "&'static str")]
pub enum Law {
    /// Springs along the edges, and area and volume forces (4.1, 4.2).
    Springs,
    /// A continuum.
    Continuum(LawName),
}

impl Law {
    /// All, springs first.
    pub fn all() -> impl Iterator<Item = Self> {
        std::iter::once(Self::Springs).chain(LawName::ALL.map(Self::Continuum))
    }

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Springs => "springs",
            Self::Continuum(law) => law.name(),
        }
    }
}

impl TryFrom<String> for Law {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let mut all = Self::all();
        all.find(|law| law.name() == name)
            .ok_or_else(|| format!("`{name}` is no law"))
    }
}

impl From<Law> for &'static str {
    fn from(law: Law) -> Self {
        law.name()
    }
}

terms! {
    /// What the constants of springs mean.
    pub enum SpringForm {
        /// Moduli, scaled with the elements: the same body on any mesh.
        Scaled = "scaled",
        /// Constants of each element, equations 4.1 and 4.2.
        Plain = "plain",
        /// Constants of each element for relative changes, equations 3.5 to 3.8.
        Normalised = "normalised",
        /// Moduli fitted to Young's modulus and Poisson's ratio.
        Fitted = "fitted",
    }
}

/// Plastic flow (4.2, dilatation).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plasticity {
    /// Strain from which on the rest size flows.
    pub yield_strain: f64,
    /// Rate of the flow \[1/s\].
    pub creep_rate: f64,
    /// Largest plastic strain.
    pub max_strain: f64,
    /// Growth of the stiffness per plastic strain.
    pub hardening: f64,
    /// Largest factor of the stiffness.
    pub max_stiffening: f64,
}
