//! `microsim mesh`: meshes from mesh files.

use crate::cli::{MeshCommand, MeshRefineArgs};
use crate::mesh_file;
use crate::output::{Exit, Problem, print, print_json};
use crate::replace_file::write_new;
use microsim_mesh::format::{MeshFormat, VtuEncoding, write_gmsh_2, write_vtu};
use microsim_mesh::{Grading, Severity, TetMesh, Zone, defects};
use microsim_settings::MAX_ELEMENTS;
use serde_json::json;

/// Does what is asked for with a mesh file.
pub fn mesh(command: &MeshCommand) -> Result<Exit, Problem> {
    match command {
        MeshCommand::Refine(args) => refine(args),
    }
}

/// Each zone with its size: one for all, or one for each.
fn gradings(zones: &[Zone], sizes: &[f64]) -> Result<Vec<Grading>, String> {
    let size = |index: usize| match sizes {
        [size] => Ok(*size),
        sizes if sizes.len() == zones.len() => Ok(sizes[index]),
        sizes => Err(format!(
            "{} --size for {} --near; expected one for all or one for each, in their order",
            sizes.len(),
            zones.len()
        )),
    };
    let zones = zones.iter().enumerate();
    zones
        .map(|(index, zone)| {
            let size = size(index)?;
            Ok(Grading { zone: *zone, size })
        })
        .collect()
}

fn refine(args: &MeshRefineArgs) -> Result<Exit, Problem> {
    let gradings = gradings(&args.near, &args.size)?;
    let out = args.output.to_string_lossy();
    let write: fn(&TetMesh) -> Vec<u8> = match MeshFormat::from_path(&out) {
        Some(MeshFormat::Gmsh) => write_gmsh_2,
        Some(MeshFormat::Vtu) => {
            |mesh| write_vtu(mesh, &mesh.positions, &[], &[], VtuEncoding::AppendedRaw)
        }
        _ => return Err(format!("{out}: expected a name that ends in .msh or .vtu").into()),
    };
    let name = args.input.display();
    let import = mesh_file::read(&args.input)?;
    for note in import.notes.iter().filter(|_| !args.json) {
        print(format!("note: {name}: {note}"))?;
    }
    let mesh = &import.mesh;
    // A mesh that is wrong already would be refined into one that is wrong everywhere.
    let wrong = defects(mesh)
        .into_iter()
        .find(|d| d.severity() == Severity::Error);
    if let Some(defect) = wrong {
        return Err(format!("{name}: {defect}").into());
    }
    let limit = args.limit.unwrap_or(MAX_ELEMENTS) as usize;
    let graded = mesh.graded(&gradings, limit).map_err(|error| {
        let zone = match &error {
            microsim_mesh::GradeError::Zone { index, .. } => format!("--near {}: ", index + 1),
            microsim_mesh::GradeError::Size { index, .. } if args.size.len() > 1 => {
                format!("--size {}: ", index + 1)
            }
            _ => String::new(),
        };
        format!("{name}: {zone}{error}")
    })?;
    write_new(&args.output, &write(&graded.mesh))?;
    let (before, after) = (mesh.shortest_height(), graded.mesh.shortest_height());
    if args.json {
        let counts = |mesh: &TetMesh, height: f64| {
            json!({
                "nodes": mesh.positions.len(), "tetrahedra": mesh.tets.len(), "shortest_height": height,
            })
        };
        print_json(&json!({
            "input": args.input, "output": args.output, "notes": import.notes,
            "before": counts(mesh, before), "after": counts(&graded.mesh, after),
        }))?;
        return Ok(Exit::Done);
    }
    print(format!(
        "{out}: {} nodes and {} tetrahedra instead of {} and {}; the shortest height of one is {after:.3e} instead of {before:.3e} (in units of the file), so that explicit methods need steps of about {:.0} % of what they were",
        graded.mesh.positions.len(),
        graded.mesh.tets.len(),
        mesh.positions.len(),
        mesh.tets.len(),
        100.0 * after / before
    ))?;
    Ok(Exit::Done)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_one_for_all_or_one_for_each() {
        let zones = [Zone::Region(1), Zone::Region(2)];
        let sizes = |sizes: &[f64]| -> Result<Vec<f64>, String> {
            let gradings = gradings(&zones, sizes)?;
            Ok(gradings.iter().map(|grading| grading.size).collect())
        };
        assert_eq!(sizes(&[0.1]), Ok(vec![0.1, 0.1]));
        assert_eq!(sizes(&[0.1, 0.2]), Ok(vec![0.1, 0.2]));
        assert!(
            sizes(&[0.1, 0.2, 0.3])
                .unwrap_err()
                .contains("3 --size for 2 --near")
        );
    }
}
