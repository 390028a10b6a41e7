//! The encodings that we read but do not write, written here straight from the formats' descriptions.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use microsim_mesh::TetMesh;
use std::io::Write;

/// Writes numbers in one byte order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    Little,
    Big,
}

impl Order {
    fn put<const N: usize>(self, out: &mut Vec<u8>, little: [u8; N]) {
        match self {
            Self::Little => out.extend_from_slice(&little),
            Self::Big => out.extend(little.iter().rev()),
        }
    }

    fn int(self, out: &mut Vec<u8>, value: u32) {
        self.put(out, value.to_le_bytes());
    }

    fn real(self, out: &mut Vec<u8>, value: f64) {
        self.put(out, value.to_le_bytes());
    }

    fn size(self, out: &mut Vec<u8>, wide: bool, value: usize) {
        if wide {
            self.put(out, (value as u64).to_le_bytes());
        } else {
            self.put(out, (value as u32).to_le_bytes());
        }
    }
}

/// Gmsh 2.2 binary: a triangle first, then all tetrahedra in one block.
pub fn gmsh_2(mesh: &TetMesh, order: Order) -> Vec<u8> {
    let mut out = b"$MeshFormat\n2.2 1 8\n".to_vec();
    order.int(&mut out, 1);
    out.extend_from_slice(
        format!("\n$EndMeshFormat\n$Nodes\n{}\n", mesh.positions.len()).as_bytes(),
    );
    for (index, p) in mesh.positions.iter().enumerate() {
        // Numbers that do not start at 1 and are not consecutive.
        order.int(&mut out, 10 + 3 * index as u32);
        p.iter().for_each(|&value| order.real(&mut out, value));
    }
    out.extend_from_slice(format!("\n$EndNodes\n$Elements\n{}\n", 1 + mesh.tets.len()).as_bytes());
    for value in [2, 1, 2, 1, 5, 5, 10, 13, 16] {
        order.int(&mut out, value);
    }
    for value in [4, mesh.tets.len() as u32, 2] {
        order.int(&mut out, value);
    }
    for (index, (tet, region)) in mesh.tets.iter().zip(&mesh.regions).enumerate() {
        for value in [2 + index as u32, *region, *region] {
            order.int(&mut out, value);
        }
        tet.iter()
            .for_each(|&node| order.int(&mut out, 10 + 3 * node));
    }
    out.extend_from_slice(b"\n$EndElements\n");
    out
}

/// Gmsh 4.1 binary with numbers of 8 (`wide`) or 4 bytes: a point, a parametric node block, one volume per run of a region.
pub fn gmsh_4(mesh: &TetMesh, order: Order, wide: bool) -> Vec<u8> {
    let mut out = format!("$MeshFormat\n4.1 1 {}\n", if wide { 8 } else { 4 }).into_bytes();
    order.int(&mut out, 1);
    let runs: Vec<&[u32]> = mesh.regions.chunk_by(|a, b| a == b).collect();
    out.extend_from_slice(b"\n$EndMeshFormat\n$Entities\n");
    for count in [1, 0, 0, runs.len()] {
        order.size(&mut out, wide, count);
    }
    order.int(&mut out, 7);
    [0.0; 3]
        .iter()
        .for_each(|&value| order.real(&mut out, value));
    order.size(&mut out, wide, 0);
    for (index, run) in runs.iter().enumerate() {
        order.int(&mut out, 100 + index as u32);
        [0.0; 6]
            .iter()
            .for_each(|&value| order.real(&mut out, value));
        order.size(&mut out, wide, 1);
        order.int(&mut out, run[0]);
        order.size(&mut out, wide, 1);
        order.int(&mut out, 3);
    }

    // The first node on a curve, with its parameter; the others in a volume.
    let nodes = mesh.positions.len();
    out.extend_from_slice(b"\n$EndEntities\n$Nodes\n");
    for value in [2, nodes, 1, nodes] {
        order.size(&mut out, wide, value);
    }
    for (block, dimension) in [(0..1, 1), (1..nodes, 3)] {
        for value in [dimension, 100, u32::from(dimension == 1)] {
            order.int(&mut out, value);
        }
        order.size(&mut out, wide, block.len());
        block
            .clone()
            .for_each(|node| order.size(&mut out, wide, node + 1));
        for node in block {
            mesh.positions[node]
                .iter()
                .for_each(|&value| order.real(&mut out, value));
            if dimension == 1 {
                order.real(&mut out, 0.5);
            }
        }
    }

    out.extend_from_slice(b"\n$EndNodes\n$Elements\n");
    for value in [1 + runs.len(), 1 + mesh.tets.len(), 1, 1 + mesh.tets.len()] {
        order.size(&mut out, wide, value);
    }
    for value in [0, 7, 15] {
        order.int(&mut out, value);
    }
    for value in [1, 1, 1] {
        order.size(&mut out, wide, value);
    }
    let mut element = 0;
    for (index, run) in runs.iter().enumerate() {
        for value in [3, 100 + index as u32, 4] {
            order.int(&mut out, value);
        }
        order.size(&mut out, wide, run.len());
        for tet in &mesh.tets[element..element + run.len()] {
            order.size(&mut out, wide, 2 + element);
            tet.iter()
                .for_each(|&node| order.size(&mut out, wide, node as usize + 1));
            element += 1;
        }
    }
    out.extend_from_slice(b"\n$EndElements\n");
    out
}

/// VTK legacy binary (big-endian), in the layout of version 5.1 (`new`) or of those before; point data come first.
pub fn vtk_legacy(mesh: &TetMesh, new: bool) -> Vec<u8> {
    let order = Order::Big;
    let (nodes, cells) = (mesh.positions.len(), mesh.tets.len());
    let version = if new { "5.1" } else { "3.0" };
    let mut out =
        format!("# vtk DataFile Version {version}\ntitle\nBINARY\nDATASET UNSTRUCTURED_GRID\n")
            .into_bytes();
    let text = |out: &mut Vec<u8>, text: String| out.extend_from_slice(text.as_bytes());
    text(&mut out, "FIELD FieldData 1\nTIME 1 1 double\n".to_owned());
    order.real(&mut out, 0.25);
    text(&mut out, format!("\nPOINTS {nodes} double\n"));
    mesh.positions
        .iter()
        .flat_map(|p| p.iter())
        .for_each(|&value| order.real(&mut out, value));
    if new {
        text(
            &mut out,
            format!(
                "\nMETADATA\nINFORMATION 0\n\nCELLS {} {}\nOFFSETS vtktypeint64\n",
                cells + 1,
                4 * cells
            ),
        );
        (0..=cells).for_each(|cell| order.size(&mut out, true, 4 * cell));
        text(&mut out, "\nCONNECTIVITY vtktypeint64\n".to_owned());
        mesh.tets
            .iter()
            .flatten()
            .for_each(|&node| order.size(&mut out, true, node as usize));
    } else {
        text(&mut out, format!("\nCELLS {cells} {}\n", 5 * cells));
        for tet in &mesh.tets {
            order.int(&mut out, 4);
            tet.iter().for_each(|&node| order.int(&mut out, node));
        }
    }
    text(&mut out, format!("\nCELL_TYPES {cells}\n"));
    (0..cells).for_each(|_| order.int(&mut out, 10));
    text(
        &mut out,
        format!("\nPOINT_DATA {nodes}\nVECTORS velocity float\n"),
    );
    (0..3 * nodes).for_each(|_| order.int(&mut out, 0x0A0A_0A0A));
    text(
        &mut out,
        format!("\nCELL_DATA {cells}\nSCALARS region float 1\nLOOKUP_TABLE default\n"),
    );
    (0..cells).for_each(|_| order.int(&mut out, 9f32.to_bits()));
    text(
        &mut out,
        format!("\nFIELD FieldData 1\ngmsh%3Aphysical 1 {cells} long\n"),
    );
    mesh.regions
        .iter()
        .for_each(|&region| order.size(&mut out, true, region as usize));
    out.push(b'\n');
    out
}

/// Where a `.vtu` file keeps its arrays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Layout {
    Inline,
    AppendedRaw,
    AppendedBase64,
}

/// A `.vtu` file in one of its encodings.
#[derive(Clone, Copy, Debug)]
pub struct Vtu {
    pub layout: Layout,
    pub zlib: bool,
    pub wide_header: bool,
    pub order: Order,
}

impl Vtu {
    /// The mesh in two pieces: its points twice, one half of the cells each.
    pub fn encode(self, mesh: &TetMesh) -> Vec<u8> {
        let mut appended = Vec::new();
        let mut out = format!(
            "<VTKFile type='UnstructuredGrid' version='1.0' byte_order='{:?}Endian' header_type='UInt{}'{}>\n<!-- two pieces --><UnstructuredGrid>\n<FieldData><DataArray type='String' Name='s' format='ascii'>1 2</DataArray></FieldData>",
            self.order,
            if self.wide_header { 64 } else { 32 },
            if self.zlib {
                " compressor='vtkZLibDataCompressor'"
            } else {
                ""
            },
        );
        let half = mesh.tets.len() / 2;
        for range in [0..half, half..mesh.tets.len()] {
            let (mut points, mut connectivity, mut offsets, mut regions) =
                (vec![], vec![], vec![], vec![]);
            mesh.positions
                .iter()
                .flat_map(|p| p.iter())
                .for_each(|&value| self.order.real(&mut points, value));
            for (cell, index) in range.clone().enumerate() {
                mesh.tets[index]
                    .iter()
                    .for_each(|&node| self.order.int(&mut connectivity, node));
                self.order.size(&mut offsets, true, 4 * (cell + 1));
                self.order.int(&mut regions, mesh.regions[index]);
            }
            out += &format!(
                "<Piece NumberOfPoints='{}' NumberOfCells='{}'>\n<PointData/><CellData>",
                mesh.positions.len(),
                range.len()
            );
            out += &self.array(&mut appended, "region", "UInt32", &regions);
            out += "</CellData><Points>";
            out += &self.array(
                &mut appended,
                "any name",
                "Float64' NumberOfComponents='3",
                &points,
            );
            out += "</Points><Cells>";
            out += &self.array(&mut appended, "connectivity", "Int32", &connectivity);
            out += &self.array(&mut appended, "offsets", "Int64", &offsets);
            out += &self.array(&mut appended, "types", "UInt8", &vec![10; range.len()]);
            out += "</Cells></Piece>\n";
        }
        out += "</UnstructuredGrid>\n";
        let mut out = out.into_bytes();
        if self.layout != Layout::Inline {
            let encoding = if self.layout == Layout::AppendedRaw {
                "raw"
            } else {
                "base64"
            };
            out.extend_from_slice(format!("<AppendedData encoding='{encoding}'>\n _").as_bytes());
            out.extend_from_slice(&appended);
            out.extend_from_slice(b"\n</AppendedData>");
        }
        out.extend_from_slice(b"</VTKFile>\n");
        out
    }

    fn array(self, appended: &mut Vec<u8>, name: &str, kind: &str, bytes: &[u8]) -> String {
        let (mut head, mut data) = (Vec::new(), Vec::new());
        if self.zlib {
            // Blocks of 100 bytes and a shorter last one.
            let blocks: Vec<&[u8]> = bytes.chunks(100).collect();
            for value in [blocks.len(), 100, bytes.len() % 100] {
                self.order.size(&mut head, self.wide_header, value);
            }
            for block in blocks {
                let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
                encoder.write_all(block).unwrap();
                let block = encoder.finish().unwrap();
                self.order.size(&mut head, self.wide_header, block.len());
                data.extend_from_slice(&block);
            }
        } else {
            self.order.size(&mut head, self.wide_header, bytes.len());
            data.extend_from_slice(bytes);
        }
        let mut encoded = Vec::new();
        match self.layout {
            Layout::AppendedRaw => {
                encoded.extend_from_slice(&head);
                encoded.extend_from_slice(&data);
            }
            // Lengths and data together, or apart as VTK does for compressed data.
            _ if self.zlib => encoded = (base64(&head) + &base64(&data)).into_bytes(),
            _ => encoded = base64(&[head, data].concat()).into_bytes(),
        }
        if self.layout == Layout::Inline {
            let text = String::from_utf8(encoded).unwrap();
            return format!(
                "<DataArray type='{kind}' Name='{name}' format='binary'>\n  {text}\n</DataArray>\n"
            );
        }
        let offset = appended.len();
        appended.extend_from_slice(&encoded);
        format!("<DataArray type='{kind}' Name='{name}' format='appended' offset='{offset}'/>\n")
    }
}

fn base64(bytes: &[u8]) -> String {
    let letters = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let mut bits = 0u32;
        for k in 0..3 {
            bits = bits << 8 | u32::from(group.get(k).copied().unwrap_or(0));
        }
        for k in 0..4 {
            let letter = letters[(bits >> (18 - 6 * k) & 63) as usize];
            text.push(if k <= group.len() {
                letter as char
            } else {
                '='
            });
        }
    }
    text
}
