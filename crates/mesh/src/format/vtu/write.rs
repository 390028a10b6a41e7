//! `.vtu` files from a mesh and its fields.

use crate::TetMesh;
use crate::format::assemble::{DIRECTIONS, PRESTRETCH};
use nalgebra::{Matrix3, Vector3};
use std::fmt::Write;

/// How the arrays are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VtuEncoding {
    /// In decimals that read back to the same bits. VTK reads no NaN from text: a state that may hold one goes raw.
    Ascii,
    /// As raw little-endian bytes at the end of the file: small and fast.
    AppendedRaw,
}

/// A named quantity on the nodes or on the elements.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    /// Name that ParaView shows, with the unit: "displacement \[m\]".
    pub name: &'a str,
    /// One value per node or per element.
    pub values: FieldValues<'a>,
}

/// The values of a field.
#[derive(Clone, Copy, Debug)]
pub enum FieldValues<'a> {
    /// Numbers.
    Scalars(&'a [f64]),
    /// Vectors.
    Vectors(&'a [Vector3<f64>]),
    /// Symmetric tensors, of which xx, yy, zz, xy, yz and xz are written, as VTK orders them.
    SymmetricTensors(&'a [Matrix3<f64>]),
    /// Tensors, row by row.
    Tensors(&'a [Matrix3<f64>]),
    /// Counts, ids.
    Wholes(&'a [u32]),
}

impl FieldValues<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Scalars(values) => values.len(),
            Self::Vectors(values) => values.len(),
            Self::SymmetricTensors(values) | Self::Tensors(values) => values.len(),
            Self::Wholes(values) => values.len(),
        }
    }
}

/// `mesh` with its nodes at `positions` \[m\] (the rest positions, or where they are now) and the given fields. Regions and
/// ids are always written, as the cell arrays "region" and "element_id" and the point array "node_id"; fibre directions and prestretches where the
/// mesh has them. A prestretch leads to the rest position, also where others are written; it is not read back.
///
/// ```
/// use microsim_mesh::TetMesh;
/// use microsim_mesh::format::{
///     Field, FieldValues, MeshFormat, VtuEncoding, read_tet_mesh, write_vtu,
/// };
/// use nalgebra::Vector3;
///
/// let corners = vec![Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
/// let mesh = TetMesh::new(corners, vec![[0, 1, 2, 3]], vec![0]);
/// let mass = Field { name: "mass [kg]", values: FieldValues::Scalars(&[0.1; 4]) };
/// let file = write_vtu(&mesh, &mesh.positions, &[mass], &[], VtuEncoding::AppendedRaw);
/// // It reads back to the same bits.
/// let import = read_tet_mesh(MeshFormat::Vtu, &[&file])?;
/// assert_eq!(import.mesh, mesh);
/// # Ok::<(), microsim_mesh::format::FormatError>(())
/// ```
///
/// # Panics
/// If a field or `positions` has not one value per node or element.
pub fn write_vtu(
    mesh: &TetMesh,
    positions: &[Vector3<f64>],
    node_fields: &[Field<'_>],
    element_fields: &[Field<'_>],
    encoding: VtuEncoding,
) -> Vec<u8> {
    let nodes = mesh.positions.len();
    let elements = mesh.tets.len();
    assert_eq!(positions.len(), nodes, "one position per node");
    let mut file = File {
        encoding,
        text: String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n",
        ),
        appended: Vec::new(),
    };
    let _ = writeln!(
        file.text,
        "<Piece NumberOfPoints=\"{nodes}\" NumberOfCells=\"{elements}\">"
    );

    file.text.push_str("<Points>\n");
    file.field("Points", FieldValues::Vectors(positions), nodes);
    file.text.push_str("</Points>\n<Cells>\n");
    let connectivity: Vec<i64> = mesh
        .tets
        .iter()
        .flatten()
        .map(|&node| i64::from(node))
        .collect();
    let offsets: Vec<i64> = (1..=elements as i64).map(|element| 4 * element).collect();
    file.array("connectivity", "Int64", 1, &connectivity, |value| {
        value.to_le_bytes()
    });
    file.array("offsets", "Int64", 1, &offsets, |value| value.to_le_bytes());
    // VTK's number of the linear tetrahedron.
    file.array("types", "UInt8", 1, &vec![10u8; elements], |value| [*value]);

    file.text.push_str("</Cells>\n<PointData>\n");
    file.field("node_id", FieldValues::Wholes(&mesh.node_ids), nodes);
    for field in node_fields {
        file.field(field.name, field.values, nodes);
    }
    file.text.push_str("</PointData>\n<CellData>\n");
    file.field("region", FieldValues::Wholes(&mesh.regions), elements);
    file.field(
        "element_id",
        FieldValues::Wholes(&mesh.element_ids),
        elements,
    );
    for (family, name) in DIRECTIONS.into_iter().enumerate() {
        let directions: Vec<_> = mesh.directions.iter().map(|of| of[family]).collect();
        if directions.iter().any(|of| *of != Vector3::zeros()) {
            file.field(name, FieldValues::Vectors(&directions), elements);
        }
    }
    if !mesh.prestretches.is_empty() {
        let prestretches = FieldValues::Tensors(&mesh.prestretches);
        file.field(PRESTRETCH, prestretches, elements);
    }
    for field in element_fields {
        file.field(field.name, field.values, elements);
    }
    file.text
        .push_str("</CellData>\n</Piece>\n</UnstructuredGrid>\n");
    file.finish()
}

/// A file while it is written.
struct File {
    encoding: VtuEncoding,
    text: String,
    appended: Vec<u8>,
}

impl File {
    fn field(&mut self, name: &str, values: FieldValues<'_>, count: usize) {
        assert_eq!(
            values.len(),
            count,
            "one value of \"{name}\" per node or element"
        );
        match values {
            FieldValues::Scalars(values) => {
                self.array(name, "Float64", 1, values, |value| value.to_le_bytes())
            }
            FieldValues::Wholes(values) => {
                self.array(name, "UInt32", 1, values, |value| value.to_le_bytes())
            }
            FieldValues::Vectors(values) => {
                let flat: Vec<f64> = values
                    .iter()
                    .flat_map(|vector| [vector.x, vector.y, vector.z])
                    .collect();
                self.array(name, "Float64", 3, &flat, |value| value.to_le_bytes());
            }
            FieldValues::SymmetricTensors(values) => {
                const ORDER: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];
                let parts = values.iter().flat_map(|tensor| ORDER.map(|at| tensor[at]));
                let flat: Vec<f64> = parts.collect();
                self.array(name, "Float64", 6, &flat, |value| value.to_le_bytes());
            }
            FieldValues::Tensors(values) => {
                let rows = values.iter().flat_map(|tensor| tensor.row_iter());
                let flat: Vec<f64> = rows.flat_map(|row| [row[0], row[1], row[2]]).collect();
                self.array(name, "Float64", 9, &flat, |value| value.to_le_bytes());
            }
        }
    }

    fn array<T: std::fmt::Debug, const N: usize>(
        &mut self,
        name: &str,
        kind: &str,
        components: usize,
        values: &[T],
        bytes: impl Fn(&T) -> [u8; N],
    ) {
        let name = quick_xml::escape::escape(name);
        let _ = write!(self.text, "<DataArray type=\"{kind}\" Name=\"{name}\"");
        if components > 1 {
            let _ = write!(self.text, " NumberOfComponents=\"{components}\"");
        }
        match self.encoding {
            VtuEncoding::Ascii => {
                self.text.push_str(" format=\"ascii\">\n");
                for tuple in values.chunks(components) {
                    for (component, value) in tuple.iter().enumerate() {
                        let space = if component == 0 { "" } else { " " };
                        let _ = write!(self.text, "{space}{value:?}");
                    }
                    self.text.push('\n');
                }
                self.text.push_str("</DataArray>\n");
            }
            VtuEncoding::AppendedRaw => {
                let _ = writeln!(
                    self.text,
                    " format=\"appended\" offset=\"{}\"/>",
                    self.appended.len()
                );
                self.appended
                    .extend_from_slice(&((N * values.len()) as u64).to_le_bytes());
                for value in values {
                    self.appended.extend_from_slice(&bytes(value));
                }
            }
        }
    }

    fn finish(self) -> Vec<u8> {
        let mut out = self.text.into_bytes();
        if self.encoding == VtuEncoding::AppendedRaw {
            out.extend_from_slice(b"<AppendedData encoding=\"raw\">\n_");
            out.extend_from_slice(&self.appended);
            out.extend_from_slice(b"\n</AppendedData>\n");
        }
        out.extend_from_slice(b"</VTKFile>\n");
        out
    }
}
