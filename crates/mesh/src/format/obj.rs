//! Wavefront `.obj`: vertices and faces. Textures, normals, groups and materials are passed over.

use super::SurfaceImport;
use super::error::{FormatError, Place};
use super::scanner::quoted;
use crate::TriangleSurface;
use nalgebra::Vector3;

/// Statements that do not concern the shape of the surface.
const PASSED_OVER: [&[u8]; 10] = [
    b"vt", b"vn", b"vp", b"g", b"o", b"s", b"usemtl", b"mtllib", b"l", b"p",
];

/// The surface in `file`.
pub(super) fn read(file: &[u8]) -> Result<SurfaceImport, FormatError> {
    let mut surface = TriangleSurface::default();
    let mut notes = Vec::new();
    // Faces may come before their vertices: which corner is the largest, on which line, is checked at the end.
    let mut largest: Option<(i64, usize)> = None;
    let mut polygons = 0;
    let mut lines = file.split(|&b| b == b'\n').zip(1..);
    while let Some((line, number)) = lines.next() {
        let error =
            |found: String, expected: &str| FormatError::new(Place::Line(number), found, expected);
        // A backslash at the end continues the line.
        let mut text = line.trim_ascii_end().to_vec();
        while text.last() == Some(&b'\\') {
            text.pop();
            text.extend_from_slice(
                lines
                    .next()
                    .map_or(&b""[..], |(next, _)| next.trim_ascii_end()),
            );
        }
        let comment = text.iter().position(|&b| b == b'#').unwrap_or(text.len());
        let mut words = text[..comment]
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty());
        match words.next() {
            None => {}
            Some(b"v") => {
                let mut position = Vector3::zeros();
                for axis in 0..3 {
                    let word = words.next().ok_or_else(|| {
                        error("the end of the line".to_owned(), "three coordinates")
                    })?;
                    let value = number_in::<f64>(word).filter(|value| value.is_finite());
                    position[axis] =
                        value.ok_or_else(|| error(quoted(word), "a finite coordinate"))?;
                }
                surface.positions.push(position);
            }
            Some(b"f") => {
                let mut corners = Vec::new();
                for word in words {
                    let vertex = word.split(|&b| b == b'/').next().and_then(number_in::<i64>);
                    // Positive numbers count from 1, negative ones back from the last vertex so far.
                    let index = match vertex {
                        Some(vertex) if vertex > 0 => vertex - 1,
                        Some(vertex) if vertex < 0 => {
                            vertex.saturating_add(surface.positions.len() as i64)
                        }
                        _ => {
                            return Err(error(
                                quoted(word),
                                "the number of a vertex, from 1 or from -1",
                            ));
                        }
                    };
                    if !(0..i64::from(u32::MAX)).contains(&index) {
                        return Err(error(quoted(word), "the number of a vertex of this file"));
                    }
                    if largest.is_none_or(|(most, _)| index > most) {
                        largest = Some((index, number));
                    }
                    corners.push(index as u32);
                }
                if corners.len() < 3 {
                    return Err(error(
                        format!("a face of {} vertices", corners.len()),
                        "3 or more",
                    ));
                }
                polygons += usize::from(corners.len() > 3);
                for pair in corners[1..].windows(2) {
                    surface.triangles.push([corners[0], pair[0], pair[1]]);
                }
            }
            Some(word) if PASSED_OVER.contains(&word) => {}
            Some(word) => {
                return Err(error(
                    quoted(word),
                    "v, f or another statement of a polygonal .obj file",
                ));
            }
        }
    }
    let vertices = surface.positions.len();
    if let Some((index, line)) = largest
        && index >= vertices as i64
    {
        return Err(FormatError::new(
            Place::Line(line),
            format!("vertex {}", index + 1),
            format!("vertices from 1 to {vertices}"),
        ));
    }
    if surface.triangles.is_empty() {
        return Err(FormatError::new(
            Place::File,
            "no face",
            "a surface of triangles or polygons",
        ));
    }
    if polygons > 0 {
        notes.push(format!(
            "{polygons} polygons were cut into triangles as fans"
        ));
    }
    Ok(SurfaceImport { surface, notes })
}

fn number_in<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}
