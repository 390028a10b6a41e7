//! Mesh files by themselves: reading one and saying what is wrong with it.

use crate::scene_file::{mesh_defects, shortened};
use microsim_mesh::Severity;
use microsim_mesh::format::{Import, MeshFormat, SurfaceFormat, read_surface, read_tet_mesh};
use microsim_settings::read_regular;
use std::path::Path;

/// Whether the name of a file is that of a mesh.
pub fn is_mesh(path: &Path) -> bool {
    let name = path.to_string_lossy();
    MeshFormat::from_path(&name).is_some() || SurfaceFormat::from_path(&name).is_some()
}

/// The tetrahedra of a mesh file.
pub fn read(path: &Path) -> Result<Import, String> {
    let name = path.to_string_lossy();
    let format = MeshFormat::from_path(&name);
    let format = format.ok_or_else(|| {
        format!("{name}: no file of tetrahedra; expected a name that ends in .msh, .vtk, .vtu, .node or .ele")
    })?;
    let mut files = Vec::new();
    for file in format.files(&name) {
        files.push(read_regular(Path::new(&file)).map_err(|e| format!("{file}: {e}"))?);
    }
    let files: Vec<&[u8]> = files.iter().map(Vec::as_slice).collect();
    read_tet_mesh(format, &files).map_err(|e| format!("{name}: {e}"))
}

/// What should be known of a mesh; the error is a sentence per line.
pub fn check(path: &Path) -> Result<Vec<String>, String> {
    let name = path.to_string_lossy().into_owned();
    let (errors, mut warnings, notes) = if MeshFormat::from_path(&name).is_some() {
        let import = read(path)?;
        let (errors, warnings) = mesh_defects(&import.mesh, &[]);
        (errors, warnings, import.notes)
    } else if let Some(format) = SurfaceFormat::from_path(&name) {
        let bytes = read_regular(path).map_err(|e| format!("{name}: {e}"))?;
        let import = read_surface(format, &bytes).map_err(|e| format!("{name}: {e}"))?;
        let found = import.surface.defects();
        let list = |severity| {
            let of = found.iter().filter(|defect| defect.severity() == severity);
            shortened(of.map(ToString::to_string).collect())
        };
        let (errors, warnings) = (list(Severity::Error), list(Severity::Warning));
        (errors, warnings, import.notes)
    } else {
        return Err(format!("{name}: no mesh file"));
    };
    warnings.extend(notes);
    let named = |sentences: Vec<String>| -> Vec<String> {
        sentences.iter().map(|s| format!("{name}: {s}")).collect()
    };
    match errors.is_empty() {
        true => Ok(named(warnings)),
        false => Err(named(errors).join("\n")),
    }
}
