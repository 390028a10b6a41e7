//! Mesh files: bytes in, mesh out; mesh in, bytes out.
//!
//! | format | read | written |
//! |---|---|---|
//! | Gmsh `.msh` | 2.x and 4.1, ASCII and binary, both byte orders | 2.2 ASCII |
//! | VTK legacy `.vtk` | unstructured grids up to 5.1, ASCII and binary | – |
//! | VTK XML `.vtu` | ASCII, base64, appended, zlib, both byte orders | ASCII, appended raw; `.pvd` for time series |
//! | TetGen `.node` + `.ele` | counted from 0 or from 1 | – |
//! | Wavefront `.obj` | polygons, relative indices | – |
//! | STL `.stl` | ASCII and binary, vertices welded | – |
//!
//! Lengths are taken as they stand: the caller knows the unit of its file. Physical groups, material numbers and
//! attributes of elements become regions; a cell array of three components named `fibre_direction` (or `fiber`, `f0`, …; in Gmsh a view
//! in `$ElementData`) becomes the fibre directions, one named `fibre_direction_2` those of a second family, as unit vectors. Prestretches are written
//! to `.vtu` alone, as the cell array `prestretch` of nine components, row by row, and never read: a mesh from a file has no residual state. Every tetrahedron is turned positive; nothing else is repaired or judged here:
//! flat, duplicated or unconnected elements and unused nodes are the validity report's to find. What a file holds beyond
//! that (triangles, hexahedra, point data) is left out, which the notes state; curved tetrahedra are refused. A damaged
//! file is an error with its place, never a panic, and nothing is allocated beyond what the file can fill.
//!
//! What is not here: files and paths (the caller reads and writes), meshing, units. Numbers are written in the shortest
//! form that reads back to the same bits.

mod assemble;
mod cells;
mod error;
mod gmsh;
mod obj;
mod pvd;
mod scalar;
mod scanner;
mod stl;
mod tetgen;
mod vtk_legacy;
mod vtu;

pub use error::{FormatError, Place};
pub use gmsh::write_gmsh_2;
pub use pvd::{PvdEntry, write_pvd};
pub use vtu::{Field, FieldValues, VtuEncoding, write_vtu};

use crate::{TetMesh, TriangleSurface};

/// A format that holds tetrahedra.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Gmsh `.msh`; version and encoding stand in the file.
    Gmsh,
    /// VTK legacy `.vtk`.
    VtkLegacy,
    /// VTK XML `.vtu`.
    Vtu,
    /// TetGen: `.node` and `.ele`.
    TetGen,
}

impl MeshFormat {
    /// The format that the ending of `path` names, if it is one of ours.
    pub fn from_path(path: &str) -> Option<Self> {
        Some(match ending(path)?.as_str() {
            "msh" => Self::Gmsh,
            "vtk" => Self::VtkLegacy,
            "vtu" => Self::Vtu,
            "node" | "ele" => Self::TetGen,
            _ => return None,
        })
    }

    /// The files that make up the mesh at `path`, in the order in which [`read_tet_mesh`] takes them: `path` itself, or for
    /// TetGen the `.node` and the `.ele` file with its stem.
    pub fn files(self, path: &str) -> Vec<String> {
        match self {
            Self::Gmsh | Self::VtkLegacy | Self::Vtu => vec![path.to_owned()],
            Self::TetGen => {
                let stem = match ending(path).as_deref() {
                    Some("node" | "ele") => path.rsplit_once('.').map_or(path, |(stem, _)| stem),
                    _ => path,
                };
                vec![format!("{stem}.node"), format!("{stem}.ele")]
            }
        }
    }
}

/// A format that holds triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceFormat {
    /// Wavefront `.obj`.
    Obj,
    /// Stereolithography `.stl`, ASCII or binary.
    Stl,
}

impl SurfaceFormat {
    /// The format that the ending of `path` names, if it is one of ours.
    pub fn from_path(path: &str) -> Option<Self> {
        match ending(path)?.as_str() {
            "obj" => Some(Self::Obj),
            "stl" => Some(Self::Stl),
            _ => None,
        }
    }
}

/// What follows the last dot of the file name, in lower case.
fn ending(path: &str) -> Option<String> {
    let name = path.rsplit(['/', '\\']).next()?;
    Some(name.rsplit_once('.')?.1.to_ascii_lowercase())
}

/// A mesh from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    /// The mesh, every element of it positive or flat; ids are the indices, nodes and elements in the order of the file.
    pub mesh: TetMesh,
    /// What was left out, turned round or assumed: one sentence each.
    pub notes: Vec<String>,
}

/// A surface from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceImport {
    /// The surface; vertices and triangles in the order of the file.
    pub surface: TriangleSurface,
    /// What was left out, welded or assumed: one sentence each.
    pub notes: Vec<String>,
}

/// The tetrahedral mesh in `files`: one file, or two for TetGen (see [`MeshFormat::files`]).
///
/// ```
/// use microsim_mesh::format::{MeshFormat, read_tet_mesh};
///
/// let node = b"4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n";
/// let ele = b"1 4 1\n0 0 1 2 3 7\n";
/// let import = read_tet_mesh(MeshFormat::TetGen, &[node, ele])?;
/// assert_eq!((import.mesh.tets.len(), import.mesh.regions[0]), (1, 7));
/// // A damaged file is an error with its place.
/// let error = read_tet_mesh(MeshFormat::TetGen, &[&node[..20], ele]).unwrap_err();
/// assert!(!error.to_string().is_empty());
/// # Ok::<(), microsim_mesh::format::FormatError>(())
/// ```
///
/// # Panics
/// If the number of files is not the format's.
pub fn read_tet_mesh(format: MeshFormat, files: &[&[u8]]) -> Result<Import, FormatError> {
    match (format, files) {
        (MeshFormat::Gmsh, [file]) => gmsh::read(file),
        (MeshFormat::VtkLegacy, [file]) => vtk_legacy::read(file),
        (MeshFormat::Vtu, [file]) => vtu::read(file),
        (MeshFormat::TetGen, [node, ele]) => tetgen::read(node, ele),
        _ => panic!("{format:?} is not made of {} files", files.len()),
    }
}

/// The surface in `file`.
///
/// ```
/// use microsim_mesh::format::{SurfaceFormat, read_surface};
///
/// let file = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
/// let import = read_surface(SurfaceFormat::Obj, file)?;
/// assert_eq!(import.surface.triangles.len(), 2);
/// assert_eq!(import.notes, ["1 polygons were cut into triangles as fans"]);
/// # Ok::<(), microsim_mesh::format::FormatError>(())
/// ```
pub fn read_surface(format: SurfaceFormat, file: &[u8]) -> Result<SurfaceImport, FormatError> {
    match format {
        SurfaceFormat::Obj => obj::read(file),
        SurfaceFormat::Stl => stl::read(file),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_name_formats() {
        for (path, format) in [
            ("tube.msh", Some(MeshFormat::Gmsh)),
            ("a.b/tube.VTK", Some(MeshFormat::VtkLegacy)),
            ("tube.vtu", Some(MeshFormat::Vtu)),
            ("tube.node", Some(MeshFormat::TetGen)),
            ("tube.1.ele", Some(MeshFormat::TetGen)),
            ("tube.msh/readme", None),
            ("tube.stl", None),
        ] {
            assert_eq!(MeshFormat::from_path(path), format, "{path}");
        }
        assert_eq!(SurfaceFormat::from_path("x.OBJ"), Some(SurfaceFormat::Obj));
        assert_eq!(SurfaceFormat::from_path("x.stl"), Some(SurfaceFormat::Stl));
        assert_eq!(SurfaceFormat::from_path("stl"), None);
        for path in ["d.1/t.node", "d.1/t.ele", "d.1/t"] {
            assert_eq!(
                MeshFormat::TetGen.files(path),
                ["d.1/t.node", "d.1/t.ele"],
                "{path}"
            );
        }
    }
}
