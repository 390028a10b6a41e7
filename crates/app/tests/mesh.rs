//! `microsim mesh refine`, and what `check` and `simulate` output about scenes that refine their meshes.

use microsim_mesh::format::{MeshFormat, read_tet_mesh, write_gmsh_2};
use microsim_mesh::{Block, CellSplit, TetMesh};
use nalgebra::Vector3;
use std::path::Path;
use std::process::{Command, Output};

/// Runs the program in a folder.
fn microsim(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_microsim"));
    let command = command.current_dir(folder).args(words);
    command.output().expect("the program starts")
}

/// What was printed on both, and the exit status.
fn said(output: &Output) -> (String, Option<i32>) {
    let [out, err] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    (format!("{out}{err}"), output.status.code())
}

/// A block of two regions, in millimetres, with fibres along x.
fn block() -> TetMesh {
    let block = Block {
        center: [0.0; 3],
        size: [4.0, 2.0, 1.0],
        cells: [4, 2, 1],
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().expect("a block");
    for element in 0..mesh.tets.len() {
        let middle: Vector3<f64> = mesh.corners(element).iter().sum();
        mesh.regions[element] = u32::from(middle.x > 0.0);
    }
    mesh.directions = vec![[Vector3::x(), Vector3::z()]; mesh.tets.len()];
    mesh
}

/// Both formats hold the same mesh as the library makes, and the same command gives the same bytes.
#[test]
fn a_mesh_file_is_refined_in_zones_of_its_own_units() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("block.msh"), write_gmsh_2(&block())).expect("a file");
    let mut meshes = Vec::new();
    for name in ["fine.msh", "again.msh", "fine.vtu"] {
        let words = [
            "mesh",
            "refine",
            "block.msh",
            name,
            "--near",
            "-1.5,0,0,0.3",
            "--size",
            "0.4",
            "--near",
            "region:1",
            "--size",
            "1",
        ];
        let (text, status) = said(&microsim(folder.path(), &words));
        assert_eq!(status, Some(0), "{text}");
        assert!(text.contains("tetrahedra instead of 30 and 48"), "{text}");
        let bytes = std::fs::read(at(name)).expect("the file");
        let format = MeshFormat::from_path(name).expect("a format");
        let mesh = read_tet_mesh(format, &[&bytes]).expect("a mesh").mesh;
        let families = [Vector3::x(), Vector3::z()];
        assert_eq!(mesh.directions, vec![families; mesh.tets.len()]);
        let volume: f64 = mesh.volumes().iter().sum();
        assert!((volume - 8.0).abs() < 1e-12);
        let count = |region: u32| mesh.regions.iter().filter(|r| **r == region).count();
        assert!(count(0) > 48 && count(1) > 24, "{} {}", count(0), count(1));
        meshes.push(mesh);
    }
    assert_eq!(meshes[0], meshes[1]);
    assert_eq!(meshes[0], meshes[2]);
}

#[test]
fn what_cannot_be_refined_is_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("block.msh"), write_gmsh_2(&block())).expect("a file");
    std::fs::write(at("there.msh"), "").expect("a file");
    let bad = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\nmany\n";
    std::fs::write(at("bad.msh"), bad).expect("a file");
    let cases: [(&[&str], &str); 9] = [
        (
            &["block.msh", "out.msh", "--near", "0,0,0,0", "--size", "1"],
            "block.msh: --near 1: the zone to be refined has a radius of 0.0",
        ),
        (
            &["block.msh", "out.msh", "--near", "0,0,0,1", "--size", "nan"],
            "expected a finite one of at least",
        ),
        (
            &["block.msh", "out.msh", "--near", "0,0,0,1", "--size", "-1"],
            "expected a finite one of at least",
        ),
        (
            &["block.msh", "out.msh", "--near", "region:7", "--size", "1"],
            "region 7, which the mesh does not have; expected one of [0, 1]",
        ),
        (
            &[
                "block.msh",
                "out.msh",
                "--near",
                "region:1",
                "--size",
                "0.01",
                "--limit",
                "1000",
            ],
            "expected 1000 at most",
        ),
        (
            &["block.msh", "out.msh", "--near", "0,0,1", "--size", "1"],
            "expected X,Y,Z,R",
        ),
        (
            &["block.msh", "out.stl", "--near", "0,0,0,1", "--size", "1"],
            "expected a name that ends in .msh or .vtu",
        ),
        (
            &["block.msh", "there.msh", "--near", "0,0,0,1", "--size", "1"],
            "there.msh",
        ),
        (
            &["bad.msh", "out.msh", "--near", "0,0,0,1", "--size", "1"],
            "bad.msh: line 5",
        ),
    ];
    for (words, expected) in cases {
        let words: Vec<&str> = ["mesh", "refine"].iter().chain(words).copied().collect();
        let (text, status) = said(&microsim(folder.path(), &words));
        assert_eq!(status, Some(2), "{words:?}: {text}");
        assert!(text.contains(expected), "{words:?}: {text}");
    }
    assert!(!at("out.msh").exists());
}

/// A scene whose mesh is refined runs; one that cannot be is refused with file, line and column.
#[test]
fn scenes_refine_their_meshes_or_name_the_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = |name: &str, refine: &str| {
        let text = format!(
            "no_stated_error = 'a test'\ntitle = {{de='a', en='b'}}\nsummary = {{de='a', en='b'}}\nrun = {{duration='20 ms', step='10 ms'}}\nmethod = {{name='implicit-euler'}}\n\
             [[body]]\nname = 'b'\ngenerator = 'block'\nsize = ['4 mm', '2 mm', '1 mm']\ncells = [4, 2, 1]\n\
             material = [{{law='stable-neo-hookean', youngs_modulus='100 kPa', poisson_ratio=0.3, density=1000}}]\n\
             clamp = [{{nodes = {{min=['-2 mm', -1, -1], max=['-2 mm', 1, 1]}}}}]\n[[body.refine]]\n{refine}\n"
        );
        std::fs::write(folder.path().join(name), text).expect("a file");
    };
    scene(
        "fine.toml",
        "point = [0, 0, 0]\nradius = '0.1 mm'\nsize = '0.5 mm'",
    );
    let output = microsim(folder.path(), &["simulate", "fine.toml", "--json"]);
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a document");
    let text = document.to_string();
    assert!(output.status.success(), "{text}");
    scene("bad.toml", "region = 3\nsize = '0.5 mm'");
    let (text, status) = said(&microsim(folder.path(), &["check", "bad.toml"]));
    assert_eq!(status, Some(1), "{text}");
    assert!(
        text.contains("bad.toml:13:1: ") && text.contains("region 3"),
        "{text}"
    );
    scene("many.toml", "region = 0\nsize = '2 um'");
    let (text, status) = said(&microsim(folder.path(), &["check", "many.toml"]));
    assert_eq!(status, Some(1), "{text}");
    assert!(
        text.contains("many.toml:13:1: ") && text.contains("5000000 at most"),
        "{text}"
    );
}
