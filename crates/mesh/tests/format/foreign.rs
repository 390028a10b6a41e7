//! Files that other programs wrote: the third-party meshes that the project ships, and the same small mesh as Gmsh, VTK and
//! meshio write it.

use crate::samples::{assert_same, import, two_cells};
use microsim_mesh::format::{Import, MeshFormat, SurfaceFormat, read_surface, read_tet_mesh};
use microsim_mesh::{TetMesh, defects};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

fn read(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../assets/meshes")
        .join(name)
}

fn shipped_mesh(name: &str) -> Import {
    let path = shipped(name);
    let path = path.to_str().unwrap();
    let format = MeshFormat::from_path(path).unwrap();
    let files: Vec<Vec<u8>> = format
        .files(path)
        .iter()
        .map(|file| read(Path::new(file)))
        .collect();
    let files: Vec<&[u8]> = files.iter().map(Vec::as_slice).collect();
    read_tet_mesh(format, &files).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Numbers of nodes and elements, which the file or its makers state; all elements positive.
#[track_caller]
fn counts(mesh: &TetMesh) -> (usize, usize) {
    assert!(mesh.volumes().iter().all(|&volume| volume > 0.0));
    (mesh.positions.len(), mesh.tets.len())
}

fn volume(mesh: &TetMesh, region: u32) -> f64 {
    mesh.volumes()
        .iter()
        .zip(&mesh.regions)
        .filter(|(_, of)| **of == region)
        .map(|(volume, _)| volume)
        .sum()
}

/// Counts of the file's header: POINTS 354, CELLS 1348, all of material 6. The cylinder is 0.1 long with radius 0.02 and its
/// mesh inscribed: a prism of 12 or more sides has more than 12 sin(π/6)/(2π) = 95 % of the volume.
#[test]
fn sfepy_cylinder_vtk_legacy() {
    let Import { mesh, .. } = shipped_mesh("sfepy/cylinder.vtk");
    assert_eq!(counts(&mesh), (354, 1348));
    let share = volume(&mesh, 6) / (PI * 0.02 * 0.02 * 0.1);
    assert!((0.95..1.0).contains(&share), "{share}");
}

/// Counts of the file's headers: 854 nodes; volume 444 ("cylinder", group 1) has 920 tetrahedra, volume 555 ("fill", group 2)
/// 2516. Together they fill a box of 5 × 5 × 1.
#[test]
fn sfepy_cylinder_in_box_gmsh_4() {
    let Import { mesh, notes } = shipped_mesh("sfepy/cylinder_in_box.msh");
    assert_eq!(counts(&mesh), (854, 920 + 2516));
    assert_eq!(
        mesh.regions.iter().filter(|&&region| region == 1).count(),
        920
    );
    assert!((volume(&mesh, 1) + volume(&mesh, 2) - 25.0).abs() < 25.0 * 1e-13);
    for name in ["region 1 \"cylinder\"", "region 2 \"fill\""] {
        assert!(notes.iter().any(|note| note.contains(name)), "{notes:?}");
    }
}

/// Counts of the file's header: 66 nodes, 127 elements, all of them tetrahedra of group 2.
#[test]
fn sfepy_tetrahedra_gmsh_2() {
    let Import { mesh, .. } = shipped_mesh("sfepy/msh_tetra.msh");
    assert_eq!(counts(&mesh), (66, 127));
    assert!(mesh.regions.iter().all(|&region| region == 2));
}

/// Counts of the files' headers; the sum of the region numbers is in meshio's own test of the file; it is the unit cube.
#[test]
fn meshio_tetgen_pair() {
    let Import { mesh, notes } = shipped_mesh("meshio/mesh.ele");
    assert_eq!(counts(&mesh), (89, 304));
    assert_eq!(mesh.regions.iter().sum::<u32>(), 373);
    assert!((volume(&mesh, 1) + volume(&mesh, 2) - 1.0).abs() < 1e-13);
    assert_eq!(notes[0], "left out: 1 attributes of each point");
}

/// Counts of the file's header and of meshio's own test of it: the unit cube in 27 cells of six.
#[test]
fn meshio_vtu_compressed() {
    let Import { mesh, .. } = shipped_mesh("meshio/02_raw_compressed.vtu");
    assert_eq!(counts(&mesh), (64, 162));
    assert!((volume(&mesh, 0) - 1.0).abs() < 1e-13);
}

/// 996 triangles by meshio's own test of the original. Closed, so V − E + F = V − F/2 = 2 for a sphere; volume by numpy from
/// the same coordinates. A red blood cell has about 90 µm³.
#[test]
fn meshio_red_blood_cell_stl() {
    let import = read_surface(
        SurfaceFormat::Stl,
        &read(&shipped("meshio/red-blood-cell.stl")),
    )
    .unwrap();
    let surface = import.surface;
    assert_eq!(import.notes, Vec::<String>::new());
    assert_eq!(
        (surface.positions.len(), surface.triangles.len()),
        (500, 996)
    );
    let volume: f64 = surface
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| surface.positions[vertex as usize]);
            a.dot(&b.cross(&c)) / 6.0
        })
        .sum();
    assert!((volume / 92.5815441070276 - 1.0).abs() < 1e-12, "{volume}");
}

/// The same mesh as each program writes it, in its encodings. Binary files keep every bit; Gmsh writes 16 digits as text,
/// VTK's legacy writer 11.
#[test]
fn other_programs_write_the_mesh_as_we_read_it() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/format/data");
    let mut names: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    names.retain(|path| {
        path.file_name()
            .unwrap()
            .to_string_lossy()
            .starts_with("two-cells.")
    });
    names.sort();
    assert_eq!(names.len(), 18, "{names:?}");
    let expected = two_cells();
    for path in names {
        let name = path.file_name().unwrap().to_str().unwrap();
        let mut mesh = import(MeshFormat::from_path(name).unwrap(), &read(&path)).mesh;
        let digits = match name {
            "two-cells.gmsh-2-ascii.msh" | "two-cells.gmsh-4-ascii.msh" => Some(16),
            "two-cells.vtk-42-ascii.vtk" | "two-cells.vtk-51-ascii.vtk" => Some(11),
            _ => None,
        };
        if let Some(digits) = digits {
            // Half a unit of the last digit, which is at most 5 of a number that begins with a 1.
            for (found, exact) in mesh.positions.iter_mut().zip(&expected.positions) {
                for axis in 0..3 {
                    let error = (found[axis] / exact[axis] - 1.0).abs();
                    assert!(
                        error <= 5.0 * 0.1f64.powi(digits) + f64::EPSILON,
                        "{name}: {error}"
                    );
                }
                *found = *exact;
            }
        }
        assert_same(&mesh, &expected);
    }
}

/// Version 2 writes an element of two physical groups twice, under a number each; version 4.1 writes it once. Both give the same mesh.
#[test]
fn overlapping_physical_groups_of_version_2_are_no_doubled_elements() {
    let file = |second: &str| {
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n\
             $Elements\n3\n1 4 2 7 1 1 2 3 4\n{second}\n3 4 2 7 1 2 3 4 5\n$EndElements\n"
        )
    };
    let import =
        |text: String| read_tet_mesh(MeshFormat::Gmsh, &[text.as_bytes()]).expect("a mesh");
    let twice = import(file("2 4 2 8 1 1 2 3 4"));
    assert_eq!(twice.mesh.tets.len(), 2);
    assert_eq!(twice.mesh.regions, [7, 7]);
    assert_eq!(defects(&twice.mesh), []);
    let note = "1 tetrahedra stand once more in another physical group; the first is their region";
    assert!(
        twice.notes.iter().any(|said| said == note),
        "{:?}",
        twice.notes
    );
    // Twice in one group is a defect, which is not hidden.
    let doubled = import(file("2 4 2 7 1 1 2 3 4"));
    assert!(!defects(&doubled.mesh).is_empty());
}
