//! STL: a list of triangles, as text or binary.

use crate::error::{Flaw, ModelError, flawed};
use crate::mesh::{CREASE, MAX_CORNERS, Model, Welded, root};
use crate::numbers::{four, number, point};

/// Bytes before the triangles: a comment of 80, their number.
const HEADER: usize = 84;

/// Bytes of a triangle: normal, three corners, two bytes of attributes.
const TRIANGLE: usize = 50;

pub(crate) fn read(bytes: &[u8]) -> Result<Model, ModelError> {
    let mut mesh = Welded::default();
    // A binary file may begin with `solid` too; then its length is that of its number of triangles.
    let is_text =
        bytes.trim_ascii_start().starts_with(b"solid") && length(bytes) != Some(bytes.len());
    match is_text {
        true => text(bytes, &mut mesh)?,
        false => binary(bytes, &mut mesh)?,
    }
    let mut part = mesh.part;
    part.check()?;
    part.set_normals(CREASE);
    let parts = if part.triangles.is_empty() {
        Vec::new()
    } else {
        vec![part]
    };
    Ok(Model {
        nodes: vec![root(String::new())],
        parts,
        textures: Vec::new(),
    })
}

fn count(bytes: &[u8]) -> Option<usize> {
    Some(u32::from_le_bytes(four(bytes, HEADER - 4)?) as usize)
}

/// Length of a binary file by its number of triangles.
fn length(bytes: &[u8]) -> Option<usize> {
    count(bytes)?.checked_mul(TRIANGLE)?.checked_add(HEADER)
}

fn binary(bytes: &[u8], mesh: &mut Welded) -> Result<(), ModelError> {
    let (Some(count), Some(length)) = (count(bytes), length(bytes)) else {
        return flawed(
            Flaw::Truncated,
            format!(
                "{} bytes; a binary STL has a header of {HEADER}",
                bytes.len()
            ),
        );
    };
    if count > MAX_CORNERS / 3 {
        return flawed(
            Flaw::TooLarge,
            format!("{count} triangles; at most {} are read", MAX_CORNERS / 3),
        );
    }
    let found = bytes.len();
    if found != length {
        let flaw = if found < length {
            Flaw::Truncated
        } else {
            Flaw::Broken
        };
        return flawed(
            flaw,
            format!("{found} bytes; {count} triangles take {length}"),
        );
    }
    for triangle in bytes[HEADER..].chunks_exact(TRIANGLE) {
        let float = |k: usize| four(triangle, 12 + 4 * k).map_or(f32::NAN, f32::from_le_bytes);
        let corner = |k: usize| point([float(3 * k), float(3 * k + 1), float(3 * k + 2)]);
        mesh.triangle([corner(0)?, corner(1)?, corner(2)?]);
    }
    Ok(())
}

fn text(bytes: &[u8], mesh: &mut Welded) -> Result<(), ModelError> {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return flawed(
            Flaw::Broken,
            "bytes that are neither a text nor a whole binary STL",
        );
    };
    let mut corners: Vec<[f32; 3]> = Vec::new();
    let mut is_open = false;
    for (at, line) in text.lines().enumerate() {
        let at = at + 1;
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words.first().copied() {
            None | Some("outer" | "endloop") => {}
            Some("solid") => is_open = true,
            Some("endsolid") => is_open = false,
            Some("facet") => corners.clear(),
            Some("vertex") => {
                let values: Option<Vec<f32>> = words[1..].iter().map(|word| number(word)).collect();
                match values.as_deref() {
                    Some([x, y, z]) => corners.push(point([*x, *y, *z])?),
                    Some(_) => {
                        return flawed(
                            Flaw::Broken,
                            format!("line {at}: a vertex without three numbers"),
                        );
                    }
                    None => {
                        return flawed(
                            Flaw::NotANumber,
                            format!("line {at}: a vertex with what is no number"),
                        );
                    }
                }
            }
            Some("endfacet") => match corners[..] {
                [a, b, c] => {
                    mesh.triangle([a, b, c]);
                    corners.clear();
                }
                _ => {
                    return flawed(
                        Flaw::Broken,
                        format!("line {at}: a facet with {} corners", corners.len()),
                    );
                }
            },
            Some(word) => {
                let word: String = word.chars().take(20).collect();
                return flawed(
                    Flaw::Broken,
                    format!("line {at}: `{word}`, which is no word of STL"),
                );
            }
        }
        if 3 * mesh.part.triangles.len() > MAX_CORNERS {
            return flawed(
                Flaw::TooLarge,
                format!("more than {} triangles", MAX_CORNERS / 3),
            );
        }
    }
    match is_open || !corners.is_empty() {
        true => flawed(Flaw::Truncated, "no `endsolid` at its end"),
        false => Ok(()),
    }
}
