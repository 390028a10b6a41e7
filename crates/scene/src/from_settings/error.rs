//! Why settings do not describe a scene.

use crate::error::SceneError;
use microsim_mesh::format::FormatError;
use microsim_mesh::{BlockError, FillError, GradeError, TubeError};
use microsim_settings::KeyPath;
use microsim_tissue::elements::CoupleError;
use microsim_tissue::vessel_wall::WallError;

/// Why settings do not describe a scene, and which key is to blame.
#[derive(Clone, Debug, PartialEq)]
pub struct FromSettingsError {
    /// The key, from the top of the file.
    pub key: KeyPath,
    /// Why.
    pub cause: Box<FromSettingsCause>,
}

/// Why settings do not describe a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum FromSettingsCause {
    /// A mesh file cannot be read.
    File {
        /// The file.
        file: String,
        /// Message of the system.
        reason: String,
    },
    /// The shape of a tool cannot be read.
    Tool {
        /// The file.
        file: String,
        /// Why.
        reason: String,
    },
    /// The ending of a mesh file is none of ours.
    Ending {
        /// The file.
        file: String,
    },
    /// A mesh file is not what its extension states.
    Format {
        /// The file.
        file: String,
        /// Where and why.
        source: FormatError,
    },
    /// A block cannot be generated.
    Block(BlockError),
    /// A tube cannot be generated.
    Tube(TubeError),
    /// A surface cannot be filled.
    Fill(FillError),
    /// A mesh cannot be refined.
    Refine(GradeError),
    /// A material is for a region that the mesh does not have.
    Region {
        /// The region.
        region: u32,
        /// Those of the mesh.
        regions: Vec<u32>,
    },
    /// A mesh has more tetrahedra than a body may have.
    Elements {
        /// How many; of a surface to be filled about how many.
        count: u64,
    },
    /// The residual state of a wall cannot be found.
    Wall(WallError),
    /// A layer of springs has no residual state.
    Springs,
    /// Fibres of a layer are not alike all around.
    Asymmetric,
    /// Something is not there.
    Missing(&'static str),
}

impl std::fmt::Display for FromSettingsCause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File { file, reason } => {
                write!(f, "the mesh file `{file}` cannot be read: {reason}")
            }
            Self::Tool { file, reason } => {
                write!(f, "the tool's file `{file}` cannot be read: {reason}")
            }
            Self::Ending { file } => write!(
                f,
                "`{file}` is no mesh file: its name must end in .msh, .vtk, .vtu, .node, .ele (tetrahedra), .obj or .stl (a closed surface)"
            ),
            Self::Format { file, source } => write!(f, "`{file}`: {source}"),
            Self::Block(source) => write!(f, "{source}"),
            Self::Tube(source) => write!(f, "{source}"),
            Self::Fill(source) => write!(f, "{source}"),
            Self::Refine(source) => write!(f, "{source}"),
            Self::Region { region, regions } => write!(
                f,
                "the mesh has no region {region}, only {regions:?}: correct the region of the material or of the mesh"
            ),
            Self::Elements { count } => write!(
                f,
                "{count} tetrahedra are too many: {} at most, so use a coarser mesh or larger cells",
                microsim_settings::MAX_ELEMENTS
            ),
            Self::Wall(source) => write!(f, "{source}"),
            Self::Springs => write!(
                f,
                "a layer of springs has no residual state: expected is the law of a continuum, or no `axial_stretch`, `transmural_pressure` and \
                 `opening_angle`"
            ),
            Self::Asymmetric => write!(
                f,
                "fibres of the layer are not alike all around: a residual state needs them at an `angle`"
            ),
            Self::Missing(what) => write!(f, "{what} is missing"),
        }
    }
}

impl From<WallError> for FromSettingsCause {
    fn from(source: WallError) -> Self {
        Self::Wall(source)
    }
}

impl std::fmt::Display for FromSettingsError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "key `{}`: {}", self.key, self.cause)
    }
}

impl std::error::Error for FromSettingsError {}

impl SceneError {
    /// The regions `from` and `to` of a coupling that have no interface, if that is what is wrong.
    pub fn uncoupled(&self) -> Option<[u32; 2]> {
        match self {
            Self::Couple {
                source: CoupleError::NoInterface { from, to },
                ..
            } => Some([*from, *to]),
            _ => None,
        }
    }
}

impl FromSettingsError {
    pub(super) fn new(key: KeyPath, cause: FromSettingsCause) -> Self {
        let cause = Box::new(cause);
        Self { key, cause }
    }
}

pub(super) fn missing(key: KeyPath, what: &'static str) -> FromSettingsError {
    FromSettingsError::new(key, FromSettingsCause::Missing(what))
}
