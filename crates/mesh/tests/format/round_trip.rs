//! What is written reads back to the same bits.

use crate::encode::{Layout, Order, Vtu, gmsh_2, gmsh_4, vtk_legacy};
use crate::samples::{assert_same, import, reference_tube, two_cells};
use crate::write::{
    write_gmsh_4, write_obj, write_stl_ascii, write_stl_binary, write_tetgen, write_vtk_legacy,
};
use microsim_mesh::format::{
    Field, FieldValues, MeshFormat, SurfaceFormat, VtuEncoding, read_surface, read_tet_mesh,
    write_gmsh_2, write_vtu,
};
use microsim_mesh::{TetMesh, TriangleSurface, signed_volume};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

fn vtu(mesh: &TetMesh, encoding: VtuEncoding) -> Vec<u8> {
    write_vtu(mesh, &mesh.positions, &[], &[], encoding)
}

/// `mesh` through every format that is written.
#[track_caller]
fn check(mesh: &TetMesh) {
    assert_same(&import(MeshFormat::Gmsh, &write_gmsh_2(mesh)).mesh, mesh);
    assert_same(&import(MeshFormat::Gmsh, &write_gmsh_4(mesh)).mesh, mesh);
    assert_same(
        &import(MeshFormat::VtkLegacy, &write_vtk_legacy(mesh)).mesh,
        mesh,
    );
    for encoding in [VtuEncoding::Ascii, VtuEncoding::AppendedRaw] {
        assert_same(&import(MeshFormat::Vtu, &vtu(mesh, encoding)).mesh, mesh);
    }
    let [node, ele] = write_tetgen(mesh);
    let import = read_tet_mesh(MeshFormat::TetGen, &[&node, &ele]).unwrap();
    assert_eq!(import.notes, Vec::<String>::new());
    assert_same(&import.mesh, mesh);
}

/// Any finite coordinates, any nodes, any regions; elements turned positive, as every mesh is.
fn meshes() -> impl Strategy<Value = TetMesh> {
    let coordinate = prop_oneof![
        prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO,
        -1.0..1.0f64
    ];
    prop::collection::vec(prop::array::uniform3(coordinate), 4..20).prop_flat_map(|positions| {
        let positions: Vec<Vector3<f64>> = positions.into_iter().map(Vector3::from).collect();
        let node = 0..positions.len() as u32;
        let element = (
            prop::array::uniform4(node),
            prop_oneof![0..3u32, any::<u32>()],
        );
        prop::collection::vec(element, 1..20).prop_map(move |elements| {
            let (mut tets, regions): (Vec<[u32; 4]>, Vec<u32>) = elements.into_iter().unzip();
            for tet in &mut tets {
                let [a, b, c, d] = tet.map(|node| positions[node as usize]);
                if signed_volume(&a, &b, &c, &d) < 0.0 {
                    // Exact: the volume changes its sign and nothing else.
                    tet.swap(2, 3);
                }
            }
            TetMesh::new(positions.clone(), tets, regions)
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_meshes_keep_every_bit(mesh in meshes()) {
        check(&mesh);
    }

    #[test]
    fn random_surfaces_keep_every_bit(mesh in meshes()) {
        let surface = TriangleSurface {
            positions: mesh.positions,
            triangles: mesh.tets.iter().map(|&[a, b, c, _]| [a, b, c]).collect(),
        };
        let import = read_surface(SurfaceFormat::Obj, &write_obj(&surface)).unwrap();
        prop_assert_eq!(import.surface, surface);
    }
}

#[test]
fn the_samples_keep_every_bit() {
    check(&two_cells());
    let tube = reference_tube();
    // Counts as the reference says: 252 nodes, 702 tetrahedra.
    assert_eq!((tube.positions.len(), tube.tets.len()), (252, 702));
    check(&tube);
}

/// Fibre directions of length 1 keep their bits, of a mesh of which one element has none and one a single family; TetGen has no place for them.
#[test]
fn fibre_directions_keep_every_bit() {
    let mut mesh = two_cells();
    let families = |element: usize| {
        let (sine, cosine) = libm::sincos(0.3 * element as f64);
        let both = element != 5;
        let second = Vector3::new(0.0, cosine, sine) * f64::from(u8::from(both));
        [Vector3::new(cosine, sine, 0.0), second]
    };
    mesh.directions = (0..mesh.tets.len()).map(families).collect();
    mesh.directions[3] = Default::default();
    for (format, file) in [
        (MeshFormat::Gmsh, write_gmsh_2(&mesh)),
        (MeshFormat::Gmsh, write_gmsh_4(&mesh)),
        (MeshFormat::VtkLegacy, write_vtk_legacy(&mesh)),
        (MeshFormat::Vtu, vtu(&mesh, VtuEncoding::Ascii)),
        (MeshFormat::Vtu, vtu(&mesh, VtuEncoding::AppendedRaw)),
    ] {
        let read = import(format, &file);
        assert_same(&read.mesh, &mesh);
        assert_eq!(
            read.notes,
            ["1 of 12 tetrahedra have no fibre direction"],
            "{format:?}"
        );
    }
}

/// A prestretch stands row by row; as it leads to the rest positions it is not read back, and that is noted once.
#[test]
fn prestretches_are_written_and_their_loss_is_noted() {
    let mut mesh = two_cells();
    let prestretch = Matrix3::new(1.5, 0.25, 0.0, 0.125, 0.75, 0.0, 0.0, -0.5, 0.875);
    mesh.prestretches = vec![prestretch; mesh.tets.len()];
    let text = String::from_utf8(vtu(&mesh, VtuEncoding::Ascii)).unwrap();
    let head = "<DataArray type=\"Float64\" Name=\"prestretch\" NumberOfComponents=\"9\" format=\"ascii\">\n";
    let (_, values) = text.split_once(head).expect("the array");
    let rows = "1.5 0.25 0.0 0.125 0.75 0.0 0.0 -0.5 0.875\n".repeat(12);
    assert!(values.starts_with(&(rows + "</DataArray>")), "{values}");
    for encoding in [VtuEncoding::Ascii, VtuEncoding::AppendedRaw] {
        let read = import(MeshFormat::Vtu, &vtu(&mesh, encoding));
        assert_same(&read.mesh, &two_cells());
        let note =
            "prestretches are left out: the elements have no stress in the places of the file";
        assert_eq!(read.notes, [note]);
    }
}

/// Names of other programs, any length of the vectors, elements without one, views of other quantities.
#[test]
fn fibre_directions_of_others_become_unit_vectors() {
    let mesh = two_cells();
    let file = String::from_utf8(write_gmsh_2(&mesh)).unwrap();
    let view = |name: &str, components: usize, values: &str| {
        format!(
            "$ElementData\n1\n\"{name}\"\n1\n0.0\n3\n0\n{components}\n1\n{values}\n$EndElementData\n"
        )
    };
    let vectors = [view("temperature", 1, "2 37"), view("fiber", 3, "2 0 -3 4")];
    let read = import(
        MeshFormat::Gmsh,
        (file.clone() + &vectors.concat()).as_bytes(),
    );
    assert_eq!(read.mesh.fibres(1)[0], Vector3::new(0.0, -0.6, 0.8));
    assert_eq!(read.mesh.fibres(0)[0], Vector3::zeros());
    assert_eq!(read.notes, ["11 of 12 tetrahedra have no fibre direction"]);
    // Of several names the first of our list.
    let ours = view("fibre_direction", 3, "2 7 0 0");
    let read = import(
        MeshFormat::Gmsh,
        (file + &vectors.concat() + &ours).as_bytes(),
    );
    assert_eq!(read.mesh.fibres(1)[0], Vector3::x());

    let vtk = String::from_utf8(write_vtk_legacy(&mesh)).unwrap();
    let rows = "0 0 2\n".repeat(12);
    for array in [
        format!("VECTORS f0 float\n{rows}"),
        format!("FIELD FieldData 1\nf0 3 12 float\n{rows}"),
    ] {
        let read = import(MeshFormat::VtkLegacy, (vtk.clone() + &array).as_bytes());
        assert_eq!(read.mesh.directions, [[Vector3::z(), Vector3::zeros()]; 12]);
    }
    let short = "FIELD FieldData 1\nf0 3 1 float\n0 0 1\n";
    let read = import(MeshFormat::VtkLegacy, (vtk + short).as_bytes());
    assert!(read.mesh.directions.is_empty() && read.notes[0].contains("\"f0\" has 3 values"));
}

#[test]
fn binary_encodings_of_gmsh_and_vtk_are_read() {
    let mesh = two_cells();
    let left_out = |what| format!("left out, since only linear tetrahedra are taken: {what}");
    for order in [Order::Little, Order::Big] {
        let old = import(MeshFormat::Gmsh, &gmsh_2(&mesh, order));
        assert_same(&old.mesh, &mesh);
        assert_eq!(old.notes, [left_out("1 triangles")]);
        for wide in [false, true] {
            let new = import(MeshFormat::Gmsh, &gmsh_4(&mesh, order, wide));
            assert_same(&new.mesh, &mesh);
            assert_eq!(new.notes, [left_out("1 points")]);
        }
    }
    for new in [false, true] {
        // The file has the cell arrays "region" (always 9) and "gmsh:physical"; our own name comes first.
        let mut expected = mesh.clone();
        expected.regions.fill(9);
        assert_same(
            &import(MeshFormat::VtkLegacy, &vtk_legacy(&mesh, new)).mesh,
            &expected,
        );
        let file = vtk_legacy(&mesh, new);
        let at = file
            .windows(14)
            .position(|w| w == b"SCALARS region")
            .unwrap();
        let mut other_name = file.clone();
        other_name[at + 8..at + 14].copy_from_slice(b"strain");
        assert_same(&import(MeshFormat::VtkLegacy, &other_name).mesh, &mesh);
    }
}

#[test]
fn every_encoding_of_vtu_is_read() {
    let mesh = two_cells();
    // The file has the points twice, one copy per piece of six cells.
    let mut expected = mesh.clone();
    expected.positions.extend_from_slice(&mesh.positions);
    for tet in &mut expected.tets[6..] {
        *tet = tet.map(|node| node + mesh.positions.len() as u32);
    }
    let expected = TetMesh::new(expected.positions, expected.tets, expected.regions);
    for layout in [Layout::Inline, Layout::AppendedRaw, Layout::AppendedBase64] {
        for zlib in [false, true] {
            for wide_header in [false, true] {
                for order in [Order::Little, Order::Big] {
                    let variant = Vtu {
                        layout,
                        zlib,
                        wide_header,
                        order,
                    };
                    let file = variant.encode(&mesh);
                    let import = read_tet_mesh(MeshFormat::Vtu, &[&file])
                        .unwrap_or_else(|e| panic!("{variant:?}: {e}"));
                    assert_same(&import.mesh, &expected);
                }
            }
        }
    }
}

#[test]
fn fields_and_moved_positions_are_in_the_vtu_file() {
    let mesh = two_cells();
    let moved: Vec<_> = mesh.positions.iter().map(|p| p * 1.5).collect();
    let displacement: Vec<_> = mesh.positions.iter().map(|p| p * 0.5).collect();
    let stress: Vec<f64> = (0..mesh.tets.len())
        .map(|element| element as f64 + 0.5)
        .collect();
    let node_fields = [Field {
        name: "displacement <m>",
        values: FieldValues::Vectors(&displacement),
    }];
    let tensors = vec![Matrix3::new(1.0, 4.0, 6.0, 4.0, 2.0, 5.0, 6.0, 5.0, 3.0); mesh.tets.len()];
    let element_fields = [
        Field {
            name: "stress",
            values: FieldValues::Scalars(&stress),
        },
        Field {
            name: "tensor",
            values: FieldValues::SymmetricTensors(&tensors),
        },
    ];
    let file = write_vtu(
        &mesh,
        &moved,
        &node_fields,
        &element_fields,
        VtuEncoding::Ascii,
    );
    assert_eq!(import(MeshFormat::Vtu, &file).mesh.positions, moved);
    let text = String::from_utf8(file).unwrap();
    assert!(text.contains("Name=\"displacement &lt;m&gt;\" NumberOfComponents=\"3\""));
    assert!(text.contains("0.5\n1.5\n2.5\n"), "{text}");
    // The order of VTK: xx, yy, zz, xy, yz, xz.
    let tensor =
        "Name=\"tensor\" NumberOfComponents=\"6\" format=\"ascii\">\n1.0 2.0 3.0 4.0 5.0 6.0\n";
    assert!(text.contains(tensor), "{text}");
}

#[test]
fn negative_elements_are_turned_and_counted_flat_ones_stay() {
    let mut mesh = two_cells();
    for element in [0, 5, 7] {
        mesh.tets[element].swap(0, 1);
    }
    mesh.tets[3] = [0, 0, 1, 2];
    let import = import(MeshFormat::Gmsh, &write_gmsh_2(&mesh));
    assert_eq!(
        import.notes,
        ["3 of 12 tetrahedra were negative and had two nodes swapped"]
    );
    for (element, volume) in import.mesh.volumes().into_iter().enumerate() {
        assert!(if element == 3 {
            volume == 0.0
        } else {
            volume > 0.0
        });
    }
    assert_eq!(import.mesh.tets[3], [0, 0, 1, 2]);
}

/// The closed surface of a block, its vertices numbered as the triangles first use them, as STL must number them.
fn closed_surface(scale: f64) -> TriangleSurface {
    let mesh = two_cells();
    let mut surface = TriangleSurface::default();
    let mut index = vec![None; mesh.positions.len()];
    for triangle in mesh.surface().triangles {
        surface.triangles.push(triangle.map(|node| {
            let p = mesh.positions[node as usize];
            *index[node as usize].get_or_insert_with(|| {
                surface.positions.push(Vector3::new(p.x, p.y, p.z * scale));
                surface.positions.len() as u32 - 1
            })
        }));
    }
    surface
}

#[test]
fn stl_is_welded_again() {
    let surface = closed_surface(1e6);
    let text = read_surface(SurfaceFormat::Stl, &write_stl_ascii(&surface)).unwrap();
    assert_eq!(text.surface, surface);
    assert_eq!(text.notes, Vec::<String>::new());

    // Singles survive the binary form exactly.
    let single = TriangleSurface {
        positions: surface
            .positions
            .iter()
            .map(|p| p.map(|x| f64::from(x as f32)))
            .collect(),
        triangles: surface.triangles.clone(),
    };
    let binary = read_surface(SurfaceFormat::Stl, &write_stl_binary(&single)).unwrap();
    assert_eq!(binary.surface, single);
    // A binary file whose comment begins like a text file.
    let mut solid = write_stl_binary(&single);
    solid[..6].copy_from_slice(b"solid ");
    assert_eq!(
        read_surface(SurfaceFormat::Stl, &solid).unwrap().surface,
        single
    );
}

/// The block is 0.68 long; copies of its corners 1e-7 apart are 1.5e-7 of that, within the 1e-6 that are welded.
#[test]
fn stl_vertices_within_the_reach_are_joined() {
    let surface = closed_surface(1e6);
    let mut torn = TriangleSurface::default();
    for (number, triangle) in surface.triangles.iter().enumerate() {
        let shift = Vector3::repeat(1e-7 * (number % 2) as f64);
        torn.triangles
            .push([0, 1, 2].map(|corner| 3 * number as u32 + corner));
        torn.positions
            .extend(triangle.map(|vertex| surface.positions[vertex as usize] + shift));
    }
    let import = read_surface(SurfaceFormat::Stl, &write_stl_ascii(&torn)).unwrap();
    assert_eq!(import.surface.triangles, surface.triangles);
    assert_eq!(import.notes.len(), 1, "{:?}", import.notes);

    // The two faces 0.1e-6 apart of the flat block are one: its sides collapse and are left out.
    let flat = read_surface(SurfaceFormat::Stl, &write_stl_ascii(&closed_surface(1.0))).unwrap();
    assert_eq!(flat.surface.positions.len(), 6);
    assert!(
        flat.notes
            .iter()
            .any(|note| note.contains("12 triangles had two corners in one place")),
        "{:?}",
        flat.notes
    );
}

#[test]
fn obj_polygons_relative_indices_and_continued_lines() {
    let file = b"# a pyramid\nmtllib x.mtl\no p\nf 1/1/1 2//2 3/3 4\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 \\\n1\nvn 0 0 1\nf -5 -4 -1\r\n";
    let import = read_surface(SurfaceFormat::Obj, file).unwrap();
    assert_eq!(import.surface.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 4]]);
    assert_eq!(import.surface.positions[4], Vector3::new(0.5, 0.5, 1.0));
    assert_eq!(import.notes, ["1 polygons were cut into triangles as fans"]);
}
