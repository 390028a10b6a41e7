//! Truncated and damaged files are errors, never panics.

use crate::encode::{Layout, Order, Vtu, gmsh_2, gmsh_4, vtk_legacy};
use crate::samples::two_cells;
use crate::write::{
    write_gmsh_4, write_obj, write_stl_ascii, write_stl_binary, write_tetgen, write_vtk_legacy,
};
use microsim_mesh::TriangleSurface;
use microsim_mesh::format::{
    FormatError, MeshFormat, SurfaceFormat, VtuEncoding, read_surface, read_tet_mesh, write_gmsh_2,
    write_vtu,
};
use microsim_random::SplitMix64;

pub type Read = fn(&[u8]) -> Result<(), FormatError>;

pub fn gmsh(file: &[u8]) -> Result<(), FormatError> {
    read_tet_mesh(MeshFormat::Gmsh, &[file]).map(drop)
}

pub fn vtk(file: &[u8]) -> Result<(), FormatError> {
    read_tet_mesh(MeshFormat::VtkLegacy, &[file]).map(drop)
}

pub fn vtu(file: &[u8]) -> Result<(), FormatError> {
    read_tet_mesh(MeshFormat::Vtu, &[file]).map(drop)
}

pub fn node(file: &[u8]) -> Result<(), FormatError> {
    read_tet_mesh(MeshFormat::TetGen, &[file, &write_tetgen(&two_cells())[1]]).map(drop)
}

pub fn ele(file: &[u8]) -> Result<(), FormatError> {
    read_tet_mesh(MeshFormat::TetGen, &[&write_tetgen(&two_cells())[0], file]).map(drop)
}

pub fn obj(file: &[u8]) -> Result<(), FormatError> {
    read_surface(SurfaceFormat::Obj, file).map(drop)
}

pub fn stl(file: &[u8]) -> Result<(), FormatError> {
    read_surface(SurfaceFormat::Stl, file).map(drop)
}

/// A readable file, how it is read, and what it must end with, if it must.
struct Sample {
    name: String,
    file: Vec<u8>,
    read: Read,
    end: &'static [u8],
}

fn samples() -> Vec<Sample> {
    let mesh = two_cells();
    let surface = TriangleSurface {
        positions: mesh
            .positions
            .iter()
            .map(|p| p.map(|x| f64::from(x as f32)))
            .collect(),
        triangles: mesh.surface().triangles,
    };
    let [node_file, ele_file] = write_tetgen(&mesh);
    let mut samples = Vec::new();
    let mut add = |name: &str, read: Read, end: &'static [u8], file: Vec<u8>| {
        samples.push(Sample {
            name: name.to_owned(),
            file,
            read,
            end,
        });
    };
    let elements = b"$EndElements";
    add("gmsh 2", gmsh, elements, write_gmsh_2(&mesh));
    add("gmsh 4", gmsh, elements, write_gmsh_4(&mesh));
    for order in [Order::Little, Order::Big] {
        add("gmsh 2 binary", gmsh, elements, gmsh_2(&mesh, order));
        add(
            "gmsh 4 binary, 4",
            gmsh,
            elements,
            gmsh_4(&mesh, order, false),
        );
        add(
            "gmsh 4 binary, 8",
            gmsh,
            elements,
            gmsh_4(&mesh, order, true),
        );
    }
    add("vtk", vtk, b"", write_vtk_legacy(&mesh));
    add("vtk binary", vtk, b"", vtk_legacy(&mesh, false));
    add("vtk 5 binary", vtk, b"", vtk_legacy(&mesh, true));
    let end = b"</VTKFile>";
    for encoding in [VtuEncoding::Ascii, VtuEncoding::AppendedRaw] {
        add(
            "vtu",
            vtu,
            end,
            write_vtu(&mesh, &mesh.positions, &[], &[], encoding),
        );
    }
    for layout in [Layout::Inline, Layout::AppendedRaw, Layout::AppendedBase64] {
        for zlib in [false, true] {
            let variant = Vtu {
                layout,
                zlib,
                wide_header: zlib,
                order: Order::Little,
            };
            add(&format!("{variant:?}"), vtu, end, variant.encode(&mesh));
        }
    }
    add("node", node, b"", node_file);
    add("ele", ele, b"", ele_file);
    add("obj", obj, b"", write_obj(&surface));
    add("stl", stl, b"endsolid", write_stl_ascii(&surface));
    add("stl binary", stl, b"", write_stl_binary(&surface));
    samples
}

/// Every prefix of every sample is read without a panic, and refused where the format marks its end.
#[test]
fn truncated_files_are_refused() {
    for Sample {
        name,
        file,
        read,
        end,
    } in samples()
    {
        read(&file).unwrap_or_else(|error| panic!("{name}: {error}"));
        let whole = file
            .windows(end.len().max(1))
            .rposition(|window| window == end);
        for length in 0..file.len() {
            let result = read(&file[..length]);
            if let (Some(whole), Ok(())) = (whole, result) {
                assert!(
                    length >= whole + end.len(),
                    "{name}: {length} of {} bytes read as whole",
                    file.len()
                );
            }
        }
    }
}

/// A thousand single-byte errors in each sample: read or refused, no panic.
#[test]
fn flipped_bytes_do_not_panic() {
    let mut random = SplitMix64(1);
    for Sample {
        name,
        mut file,
        read,
        ..
    } in samples()
    {
        let mut refused = 0;
        for _ in 0..1000 {
            let at = random.below(file.len() as u64) as usize;
            let good = file[at];
            file[at] ^= 1 << random.below(8);
            refused += usize::from(read(&file).is_err());
            file[at] = good;
        }
        assert!(refused > 0, "{name}: no damage was noticed");
    }
}
