//! STL: triangles without connectivity, in text or in single precision. Vertices are welded: first those with the same
//! bits, then those closer than [`WELD`] times the diagonal of the box around all. Normals are passed over: the order of
//! the corners gives them.

use super::SurfaceImport;
use super::error::{FormatError, Place};
use super::scalar::{Encoding, Endian, Scalar};
use super::scanner::{Scanner, quoted};
use crate::TriangleSurface;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Bytes before the triangles of a binary file: a comment of 80 and their number.
const HEAD: usize = 84;

/// Bytes of a triangle in a binary file: normal, corners, two bytes of attributes.
const TRIANGLE: usize = 50;

/// Largest distance of two copies of one vertex, by the diagonal of the bounding box: copies that were rounded to single
/// precision apart differ by a few units of 2⁻²³ ≈ 1.2e-7 of a coordinate.
const WELD: f64 = 1e-6;

/// The surface in `file`.
pub(super) fn read(file: &[u8]) -> Result<SurfaceImport, FormatError> {
    // Some binary files begin with "solid" as well, so the size decides.
    let size = file.get(80..HEAD).map(|count| {
        HEAD as u64 + TRIANGLE as u64 * Scalar::U32.whole(count, Endian::Little) as u64
    });
    let corners = if size == Some(file.len() as u64) {
        binary(file)?
    } else if file.trim_ascii_start().starts_with(b"solid") {
        text(file)?
    } else {
        let expected = match size {
            Some(size) => format!(
                "\"solid\", or {size} bytes as the number of triangles of a binary file asks for"
            ),
            None => "\"solid\", or a binary file of at least 84 bytes".to_owned(),
        };
        let found = format!(
            "{} in a file of {} bytes",
            quoted(&file[..file.len().min(8)]),
            file.len()
        );
        return Err(FormatError::new(Place::Byte(0), found, expected));
    };
    if corners.is_empty() {
        return Err(FormatError::new(
            Place::File,
            "no triangle",
            "a surface of triangles",
        ));
    }
    let import = weld(&corners);
    if import.surface.triangles.is_empty() {
        let found = format!(
            "{} triangles, all of them with two corners in one place",
            corners.len()
        );
        return Err(FormatError::new(
            Place::File,
            found,
            "a surface of triangles",
        ));
    }
    Ok(import)
}

type Corners = [Vector3<f64>; 3];

fn binary(file: &[u8]) -> Result<Vec<Corners>, FormatError> {
    let mut scanner = Scanner::new(file);
    scanner.places_are_bytes();
    let single = (Encoding::Binary(Endian::Little), Scalar::F32);
    scanner.take(HEAD, "the head of a binary file")?;
    let mut triangles = Vec::with_capacity(scanner.remaining() / TRIANGLE);
    while scanner.remaining() > 0 {
        scanner.take(12, "a normal")?;
        triangles.push(corners(&mut scanner, |scanner| {
            scanner.coordinate(single.0, single.1)
        })?);
        scanner.take(2, "attributes")?;
    }
    Ok(triangles)
}

fn text(file: &[u8]) -> Result<Vec<Corners>, FormatError> {
    let mut scanner = Scanner::new(file);
    let mut triangles = Vec::new();
    // A file may hold several solids; what follows the word on its line is a name.
    while scanner.peek().is_some() {
        scanner.keyword("solid")?;
        scanner.line();
        loop {
            let word = scanner.required_word("facet or endsolid")?;
            if word.eq_ignore_ascii_case(b"endsolid") {
                scanner.line();
                break;
            }
            if !word.eq_ignore_ascii_case(b"facet") {
                return Err(scanner.error(quoted(word), "facet or endsolid"));
            }
            scanner.keyword("normal")?;
            for _ in 0..3 {
                scanner.required_word("a normal")?;
            }
            scanner.keyword("outer")?;
            scanner.keyword("loop")?;
            let mut at_vertex = 0;
            triangles.push(corners(&mut scanner, |scanner| {
                if at_vertex % 3 == 0 {
                    scanner.keyword("vertex")?;
                }
                at_vertex += 1;
                scanner.coordinate(Encoding::Ascii, Scalar::F64)
            })?);
            scanner.keyword("endloop")?;
            scanner.keyword("endfacet")?;
        }
    }
    Ok(triangles)
}

/// Three corners of three coordinates each, read by `next`.
fn corners<'a>(
    scanner: &mut Scanner<'a>,
    mut next: impl FnMut(&mut Scanner<'a>) -> Result<f64, FormatError>,
) -> Result<Corners, FormatError> {
    let mut corners = [Vector3::zeros(); 3];
    for corner in &mut corners {
        for axis in 0..3 {
            corner[axis] = next(scanner)?;
        }
    }
    Ok(corners)
}

/// The surface of `triangles` with each vertex once, in the order in which they first appear.
fn weld(triangles: &[Corners]) -> SurfaceImport {
    let mut low = triangles[0][0];
    let mut high = low;
    for corner in triangles.iter().flatten() {
        low = low.inf(corner);
        high = high.sup(corner);
    }
    let reach = WELD * (high - low).norm();

    let mut surface = TriangleSurface::default();
    let mut notes = Vec::new();
    let mut exact: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    let mut cells: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
    let mut welded = 0;
    let mut collapsed = 0;
    for corners in triangles {
        let triangle = corners.map(|corner| {
            // Adding zero makes one of the two zeros.
            let bits = [corner.x, corner.y, corner.z].map(|value| (value + 0.0).to_bits());
            *exact.entry(bits).or_insert_with(|| {
                // Cells as wide as the reach: a neighbour lies in this one or in one of the 26 around it.
                let cell = [0, 1, 2].map(|axis| ((corner[axis] - low[axis]) / reach) as i64);
                if let Some(vertex) = neighbour(&cells, &surface.positions, cell, &corner, reach) {
                    welded += 1;
                    return vertex;
                }
                let vertex = surface.positions.len() as u32;
                surface.positions.push(corner);
                cells.entry(cell).or_default().push(vertex);
                vertex
            })
        });
        let [a, b, c] = triangle;
        if a == b || b == c || c == a {
            collapsed += 1;
        } else {
            surface.triangles.push(triangle);
        }
    }
    if welded > 0 {
        notes.push(format!(
            "{welded} vertices lay within {WELD:e} of the size from another and were joined with it"
        ));
    }
    if collapsed > 0 {
        notes.push(format!(
            "{collapsed} triangles had two corners in one place and are left out"
        ));
    }
    SurfaceImport { surface, notes }
}

/// The first vertex within `reach` of `corner`, whose cell is `cell`.
fn neighbour(
    cells: &BTreeMap<[i64; 3], Vec<u32>>,
    positions: &[Vector3<f64>],
    cell: [i64; 3],
    corner: &Vector3<f64>,
    reach: f64,
) -> Option<u32> {
    let around = |i: i64| i - 1..=i + 1;
    around(cell[0])
        .flat_map(|x| around(cell[1]).map(move |y| (x, y)))
        .flat_map(|(x, y)| around(cell[2]).map(move |z| [x, y, z]))
        .filter_map(|cell| cells.get(&cell))
        .flatten()
        .copied()
        .filter(|&vertex| (positions[vertex as usize] - corner).norm() <= reach)
        .min()
}
