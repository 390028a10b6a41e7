//! What an error states: the place, what stands there, what should.

use crate::damage::{Read, ele, gmsh, node, obj, stl, vtk, vtu};
use crate::encode::{Layout, Order, Vtu, gmsh_2, gmsh_4, vtk_legacy};
use crate::samples::two_cells;
use crate::write::{write_stl_binary, write_tetgen};
use microsim_mesh::TriangleSurface;
use microsim_mesh::format::{Place, VtuEncoding, write_vtu};

const HEAD: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const NODES: &str = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n";
const VTK: &str = "# vtk DataFile Version 4.2\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\n";

/// `read` refuses `file` at `place`; the sentence has all of `words`.
#[track_caller]
fn refuse(read: Read, file: impl AsRef<[u8]>, place: Place, words: &[&str]) {
    let error = read(file.as_ref()).expect_err("damage was not noticed");
    assert_eq!(error.place, place, "{error}");
    let sentence = error.to_string();
    for word in words {
        assert!(sentence.contains(word), "\"{word}\" is not in: {sentence}");
    }
}

#[test]
fn damaged_gmsh_files_are_refused_with_place_and_reason() {
    let line = Place::Line;
    let nodes = |body: &str| format!("{HEAD}$Nodes\n{body}$EndNodes\n");
    let elements = |body: &str| format!("{HEAD}{NODES}$Elements\n{body}$EndElements\n");
    refuse(gmsh, "", line(1), &["the end of the file", "$MeshFormat"]);
    refuse(gmsh, "$NOD\n4\n", line(1), &["$NOD", "$MeshFormat"]);
    refuse(
        gmsh,
        "$MeshFormat\n4 0 8\n$EndMeshFormat\n",
        line(2),
        &["\"4\"", "2.2 or 4.1"],
    );
    refuse(gmsh, nodes("-1\n"), line(5), &["-1", "nodes"]);
    refuse(
        gmsh,
        nodes("4000000000\n1 0 0 0\n"),
        line(5),
        &["4000000000", "fits into the file"],
    );
    refuse(gmsh, nodes("1\n1 0 nan 0\n"), line(6), &["NaN", "finite"]);
    refuse(gmsh, nodes("1\n1 0 1e999 0\n"), line(6), &["inf", "finite"]);
    refuse(
        gmsh,
        nodes("2\n1 0 0 0\n1 0 0 1\n"),
        line(7),
        &["number 1 a second time"],
    );
    refuse(
        gmsh,
        nodes("2\n1 0 0 0\n"),
        line(7),
        &["$EndNodes", "fewer nodes"],
    );
    refuse(
        gmsh,
        nodes("1\n1 0 0 0\n2 0 0 0\n"),
        line(7),
        &["\"2\"", "$EndNodes"],
    );
    refuse(
        gmsh,
        format!("{HEAD}{NODES}"),
        line(11),
        &["the end of the file", "$Elements"],
    );
    refuse(
        gmsh,
        format!("{HEAD}$Elements\n"),
        line(4),
        &["without nodes"],
    );
    refuse(
        gmsh,
        elements("1\n1 4 2 1 1 1 2 3 5\n"),
        line(13),
        &["node number 5", "$Nodes"],
    );
    refuse(
        gmsh,
        elements("1\n1 11 2 1 1 1 2 3 4 1 2 3 4 1 2\n"),
        line(13),
        &["second or higher order", "order 1"],
    );
    refuse(
        gmsh,
        elements("1\n1 999 2 1 1 1 2 3 4\n"),
        line(13),
        &["type 999"],
    );
    refuse(
        gmsh,
        elements("1\n1 2 2 1 1 1 2 3\n"),
        Place::File,
        &["1 triangles", "linear tetrahedra"],
    );
    refuse(gmsh, elements("0\n"), Place::File, &["no element"]);
    refuse(
        gmsh,
        elements("1\n1 4 1 99999999999 1 2 3 4\n"),
        line(13),
        &["physical group 99999999999"],
    );
}

#[test]
fn wrong_byte_orders_are_noticed() {
    let mesh = two_cells();
    let mut file = gmsh_2(&mesh, Order::Little);
    file[20..24].copy_from_slice(&[0, 1, 0, 0]);
    refuse(
        gmsh,
        &file,
        Place::Byte(20),
        &["00, 01, 00, 00", "byte order"],
    );
    // The marker says big-endian, the numbers are little-endian: the first coordinates make no sense, or no node is found.
    let mut file = gmsh_4(&mesh, Order::Little, true);
    file[20..24].copy_from_slice(&[0, 0, 0, 1]);
    assert!(gmsh(&file).is_err());
    // VTK legacy is big-endian by definition. Cells follow the points; their counts are senseless when swapped.
    let mut file = vtk_legacy(&mesh, false);
    let cells = file.windows(6).position(|w| w == b"CELLS ").unwrap();
    let start = cells + file[cells..].iter().position(|&b| b == b'\n').unwrap() + 1;
    for k in 0..5 * mesh.tets.len() {
        file[start + 4 * k..start + 4 * k + 4].reverse();
    }
    refuse(
        vtk,
        &file,
        Place::Array("cells".to_owned()),
        &["points in cell 0"],
    );
    let little = Vtu {
        layout: Layout::AppendedRaw,
        zlib: false,
        wide_header: false,
        order: Order::Little,
    };
    let text = b"LittleEndian";
    let mut file = little.encode(&mesh);
    let at = file.windows(text.len()).position(|w| w == text).unwrap();
    file.splice(at..at + text.len(), *b"BigEndian");
    refuse(
        vtu,
        &file,
        Place::Array("any name".to_owned()),
        &["byte_order"],
    );
}

#[test]
fn damaged_vtk_files_are_refused_with_place_and_reason() {
    let cells = Place::Array("cells".to_owned());
    let with = |rest: &str| format!("{VTK}{rest}");
    refuse(vtk, "<VTKFile>", Place::Line(1), &["DataFile Version"]);
    refuse(
        vtk,
        VTK.replace("4.2", "6.0"),
        Place::Line(1),
        &["up to 5.1"],
    );
    refuse(
        vtk,
        VTK.replace("UNSTRUCTURED_GRID", "POLYDATA"),
        Place::Line(4),
        &["POLYDATA", "UNSTRUCTURED_GRID"],
    );
    refuse(
        vtk,
        VTK.replace("POINTS 4", "POINTS -4"),
        Place::Line(5),
        &["-4"],
    );
    refuse(
        vtk,
        VTK.replace("POINTS 4", "POINTS 4000000000"),
        Place::Line(5),
        &["fits into the file"],
    );
    refuse(
        vtk,
        VTK.replace("0 0 0 1 0 0", "0 0 0 nan 0 0"),
        Place::Array("points".to_owned()),
        &["NaN", "point 1"],
    );
    refuse(vtk, VTK, Place::File, &["no CELLS"]);
    refuse(
        vtk,
        with("CELLS 1 5\n4 0 1 2 3\n"),
        Place::File,
        &["no CELL_TYPES"],
    );
    refuse(
        vtk,
        with("CELLS 1 5\n4 0 1 2 4\nCELL_TYPES 1\n10\n"),
        cells.clone(),
        &["point 4", "0 to 3"],
    );
    refuse(
        vtk,
        with("CELLS 1 5\n4 0 1 2 -1\nCELL_TYPES 1\n10\n"),
        cells.clone(),
        &["point -1"],
    );
    refuse(
        vtk,
        with("CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n10\n"),
        cells.clone(),
        &["3 points in tetrahedron 0"],
    );
    refuse(
        vtk,
        with("CELLS 1 5\n5 0 1 2 3\nCELL_TYPES 1\n10\n"),
        cells.clone(),
        &["5 points in cell 0"],
    );
    refuse(
        vtk,
        with("CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 2\n10 10\n"),
        cells.clone(),
        &["1 cells and 2 types"],
    );
    refuse(
        vtk,
        with("CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n24\n"),
        cells,
        &["second or higher order"],
    );
    refuse(
        vtk,
        with("CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n"),
        Place::File,
        &["1 triangles"],
    );
    refuse(vtk, with("NONSENSE 1\n"), Place::Line(7), &["NONSENSE"]);
}

#[test]
fn damaged_vtu_files_are_refused_with_place_and_reason() {
    let mesh = two_cells();
    let good = String::from_utf8(write_vtu(
        &mesh,
        &mesh.positions,
        &[],
        &[],
        VtuEncoding::Ascii,
    ))
    .unwrap();
    let line = 1 + good.lines().position(|line| line == "</Piece>").unwrap();
    let array = |name: &str| Place::Array(name.to_owned());
    refuse(
        vtu,
        good.replace("\"UnstructuredGrid\"", "\"PolyData\""),
        Place::Line(2),
        &["PolyData"],
    );
    refuse(
        vtu,
        good.replace("Float64", "Float16"),
        Place::Line(6),
        &["Float16"],
    );
    refuse(
        vtu,
        good.replace("UInt64\">", "UInt64\" compressor=\"vtkLZ4DataCompressor\">"),
        Place::Line(2),
        &["LZ4", "zlib"],
    );
    refuse(
        vtu,
        good.replace("NumberOfPoints=\"12\"", "NumberOfPoints=\"13\""),
        array("Points"),
        &["36 numbers for 13 points"],
    );
    refuse(
        vtu,
        good.replace("NumberOfPoints=\"12\"", "NumberOfPoints=\"-12\""),
        Place::Line(4),
        &["-12"],
    );
    refuse(
        vtu,
        good.replace("NumberOfCells=\"12\"", "NumberOfCells=\"11\""),
        array("types"),
        &["12 types for 11 cells"],
    );
    refuse(vtu, good.replace("-0.25", "nan"), array("Points"), &["NaN"]);
    refuse(
        vtu,
        good.replace("\"offsets\"", "\"ends\""),
        Place::File,
        &["offsets"],
    );
    refuse(
        vtu,
        good.replace("</Piece>", "</Pieces>"),
        Place::Line(line),
        &["XML"],
    );
    refuse(
        vtu,
        good.replace("</VTKFile>\n", ""),
        Place::Byte(good.len() - 11),
        &["ends before"],
    );
    refuse(
        vtu,
        good.replacen("\n4\n8\n", "\n4\n3\n", 1),
        array("cells"),
        &["offset 3 of cell 1"],
    );
}

#[test]
fn damaged_tetgen_files_are_refused_with_place_and_reason() {
    let files = write_tetgen(&two_cells());
    let [nodes, elements] = files.map(|file| String::from_utf8(file).unwrap());
    refuse(
        node,
        nodes.replace("12 3 0 0", "12 2 0 0"),
        Place::Line(1),
        &[".node file, line 1", "dimension 2"],
    );
    refuse(
        node,
        nodes.replace("12 3 0 0", "-12 3 0 0"),
        Place::Line(1),
        &["-12"],
    );
    refuse(
        node,
        nodes.replace("12 3 0 0", "13 3 0 0"),
        Place::Line(13),
        &["point 13 of 13"],
    );
    refuse(
        node,
        nodes.replace("12 3 0 0", "11 3 0 0"),
        Place::Line(13),
        &["no more points"],
    );
    refuse(
        node,
        nodes.replace("\n1 ", "\n0 "),
        Place::Line(3),
        &["number 0 a second time"],
    );
    refuse(
        node,
        nodes.replacen("-0.25", "inf", 1),
        Place::Line(2),
        &["finite"],
    );
    refuse(
        ele,
        elements.replace("12 4 1", "12 10 1"),
        Place::Line(1),
        &[".ele file, line 1", "10 nodes", "-o2"],
    );
    refuse(
        ele,
        elements.replacen("\n0 0 ", "\n0 12 ", 1),
        Place::Line(2),
        &["point number 12", ".node"],
    );
    refuse(
        ele,
        elements.replace("12 4 1", "18446744073709551615 4 1"),
        Place::Line(13),
        &["tetrahedron 13"],
    );
}

#[test]
fn damaged_surfaces_are_refused_with_place_and_reason() {
    refuse(
        obj,
        "v 0 0 0\nf 1 1 2\n",
        Place::Line(2),
        &["vertex 2", "1 to 1"],
    );
    refuse(obj, "v 0 0 0\nf 1 1 0\n", Place::Line(2), &["\"0\""]);
    refuse(obj, "v 0 0 0\nf 1 1 -2\n", Place::Line(2), &["\"-2\""]);
    refuse(obj, "v 0 0 nan\n", Place::Line(1), &["nan", "finite"]);
    refuse(obj, "v 0 0\n", Place::Line(1), &["three coordinates"]);
    refuse(obj, "v 0 0 0\nf 1 1\n", Place::Line(2), &["2 vertices"]);
    refuse(obj, "v 0 0 0\n", Place::File, &["no face"]);
    refuse(obj, "%PDF-1.4\n", Place::Line(1), &["%PDF"]);
    refuse(stl, "solid\nendsolid\n", Place::File, &["no triangle"]);
    refuse(
        stl,
        "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n",
        Place::Line(4),
        &["\"x\""],
    );
    refuse(stl, b"binary or not", Place::Byte(0), &["13 bytes"]);
    let mut file = write_stl_binary(&TriangleSurface {
        positions: two_cells().positions,
        triangles: vec![[0, 1, 3]],
    });
    file[80] = 2;
    refuse(stl, &file, Place::Byte(0), &["184 bytes", "134 bytes"]);
    file[80] = 1;
    file[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    refuse(stl, &file, Place::Byte(96), &["finite"]);
}
