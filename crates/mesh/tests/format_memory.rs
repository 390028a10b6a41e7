//! Reading a damaged file takes no more memory than the file can fill.

#![allow(unsafe_code, reason = "an allocator that counts")]

use microsim_mesh::format::{MeshFormat, SurfaceFormat, read_surface, read_tet_mesh};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Notes the largest piece of memory that was asked for.
struct Watched;

static LARGEST: AtomicUsize = AtomicUsize::new(0);

// SAFETY: everything is handed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Watched {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LARGEST.fetch_max(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`, and `alloc` handed out the system's memory.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static WATCHED: Watched = Watched;

/// Headers that promise 4 billion items in files of less than 1 kB: nothing larger than 1 MB is asked for.
#[test]
fn promises_of_a_header_are_not_believed() {
    let head = "# vtk DataFile Version 4.2\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\n";
    let vtu = |length: &[u8], compressor: &str| {
        let mut file = format!(
            "<VTKFile type=\"UnstructuredGrid\" header_type=\"UInt32\"{compressor}><UnstructuredGrid>\
             <Piece NumberOfPoints=\"1400000000\" NumberOfCells=\"1\"><Points><DataArray type=\"UInt8\" format=\"appended\" \
             offset=\"0\"/></Points></Piece></UnstructuredGrid><AppendedData encoding=\"raw\">_"
        )
        .into_bytes();
        file.extend_from_slice(length);
        file.extend_from_slice(b"</AppendedData></VTKFile>");
        file
    };
    let zlib = " compressor=\"vtkZLibDataCompressor\"";
    let mut stl = vec![b' '; 84];
    stl[80..].fill(0xFF);
    let gmsh_4 = b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Nodes\n\xFF\xFF\xFF\xFF\0\0\0\0\xFF\xFF\xFF\xFF\0\0\0\0";
    let files: [(Option<MeshFormat>, Vec<u8>); 9] = [
        (
            Some(MeshFormat::Gmsh),
            b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4000000000\n1 0 0 0\n".to_vec(),
        ),
        (Some(MeshFormat::Gmsh), gmsh_4.to_vec()),
        (
            Some(MeshFormat::VtkLegacy),
            format!("{head}POINTS 4000000000 double\n").into_bytes(),
        ),
        (
            Some(MeshFormat::VtkLegacy),
            format!("{head}CELLS 4000000000 4000000000\n").into_bytes(),
        ),
        (
            Some(MeshFormat::VtkLegacy),
            format!("{head}FIELD f 1\na 4000000000 4000000000 double\n").into_bytes(),
        ),
        (Some(MeshFormat::Vtu), vtu(&[0xFF; 4], "")),
        (Some(MeshFormat::Vtu), vtu(&[0xFF; 40], zlib)),
        // One block of 4 GB from 8 bytes.
        (
            Some(MeshFormat::Vtu),
            vtu(
                &[
                    1, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0, 8, 0, 0, 0, 1, 2, 3, 4, 5, 6,
                    7, 8,
                ],
                zlib,
            ),
        ),
        (None, stl),
    ];
    for (format, file) in files {
        LARGEST.store(0, Ordering::Relaxed);
        let refused = match format {
            Some(format) => read_tet_mesh(format, &[&file]).is_err(),
            None => read_surface(SurfaceFormat::Stl, &file).is_err(),
        };
        let largest = LARGEST.load(Ordering::Relaxed);
        assert!(
            refused && largest < 1 << 20,
            "{format:?}: {largest} bytes for {:?}",
            file.escape_ascii().to_string()
        );
    }
}
