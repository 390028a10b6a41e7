//! Wavefront OBJ: a text with positions, normals, texture coordinates and faces that name them.

use crate::affine::Affine;
use crate::error::{Flaw, ModelError, flawed};
use crate::mesh::{CREASE, MAX_CORNERS, MAX_NODES, Model, Node, Part, root, unit};
use crate::numbers::{coordinate, number, point};
use std::collections::BTreeMap;

/// Position, texture coordinates, normal of a corner, by their places in the lists.
type Corner = (usize, Option<usize>, Option<usize>);

#[derive(Default)]
struct Lists {
    positions: Vec<[f32; 3]>,
    coordinates: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
}

pub(crate) fn read(bytes: &[u8]) -> Result<Model, ModelError> {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return flawed(Flaw::Broken, "bytes that are no text in UTF-8");
    };
    let mut lists = Lists::default();
    let mut nodes: Vec<Node> = vec![root(String::new())];
    let mut objects: Vec<Vec<[Corner; 3]>> = vec![Vec::new()];
    let mut corners = 0;
    for (at, line) in text.lines().enumerate() {
        let at = at + 1;
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_ascii_whitespace();
        let Some(keyword) = words.next() else {
            continue;
        };
        let words: Vec<&str> = words.collect();
        match keyword {
            "v" => lists.positions.push(point(floats(&words, 3..=7, at)?)?),
            "vn" => {
                let n = point(floats(&words, 3..=3, at)?)?;
                lists.normals.push(unit(n.map(f64::from)).map(|x| x as f32));
            }
            "vt" => {
                let [u, v] = floats(&words, 2..=3, at)?;
                // From the lower left corner, as pictures of the form have it.
                lists
                    .coordinates
                    .push([coordinate(u)?, 1.0 - coordinate(v)?]);
            }
            "f" => {
                let face = words.iter().map(|word| corner(word, &lists, at));
                let face: Vec<Corner> = face.collect::<Result<_, _>>()?;
                if face.len() < 3 {
                    return flawed(
                        Flaw::Broken,
                        format!("line {at}: a face with {} corners", face.len()),
                    );
                }
                corners += 3 * (face.len() - 2);
                if corners > MAX_CORNERS {
                    return flawed(
                        Flaw::TooLarge,
                        format!("more than {} triangles", MAX_CORNERS / 3),
                    );
                }
                let fan = face[1..].windows(2).map(|pair| [face[0], pair[0], pair[1]]);
                objects
                    .last_mut()
                    .into_iter()
                    .for_each(|object| object.extend(fan.clone()));
            }
            "o" => {
                if nodes.len() == MAX_NODES {
                    return flawed(Flaw::TooLarge, format!("more than {MAX_NODES} objects"));
                }
                nodes.push(Node {
                    name: words.join(" "),
                    parent: Some(0),
                    place: Affine::IDENTITY,
                });
                objects.push(Vec::new());
            }
            // Lines and points have no surface; the rest is for colours, which a level gives.
            "g" | "s" | "l" | "p" | "mtllib" | "usemtl" => {}
            other => {
                let other: String = other.chars().take(20).collect();
                return flawed(
                    Flaw::Broken,
                    format!("line {at}: `{other}`, which is not read"),
                );
            }
        }
    }
    let mut parts = Vec::new();
    for (node, triangles) in objects.iter().enumerate().filter(|(_, t)| !t.is_empty()) {
        parts.push(part(node, triangles, &lists)?);
    }
    Ok(Model {
        nodes,
        parts,
        textures: Vec::new(),
    })
}

fn part(node: usize, triangles: &[[Corner; 3]], lists: &Lists) -> Result<Part, ModelError> {
    let mut part = Part {
        node,
        ..Part::default()
    };
    let corners = || triangles.iter().flatten();
    let has_normals = corners().all(|(_, _, normal)| normal.is_some());
    let has_coordinates = corners().all(|(_, coordinates, _)| coordinates.is_some());
    let mut known: BTreeMap<Corner, u32> = BTreeMap::new();
    for triangle in triangles {
        let vertices = triangle.map(|(position, coordinates, normal)| {
            let coordinates = coordinates.filter(|_| has_coordinates);
            let normal = normal.filter(|_| has_normals);
            *known
                .entry((position, coordinates, normal))
                .or_insert_with(|| {
                    part.positions.push(lists.positions[position]);
                    part.coordinates
                        .extend(coordinates.map(|at| lists.coordinates[at]));
                    part.normals.extend(normal.map(|at| lists.normals[at]));
                    part.positions.len() as u32 - 1
                })
        });
        part.triangles.push(vertices);
    }
    part.check()?;
    if !has_normals {
        part.set_normals(CREASE);
    }
    Ok(part)
}

/// The first N of the numbers of a line, which has as many as `count` allows.
fn floats<const N: usize>(
    words: &[&str],
    count: std::ops::RangeInclusive<usize>,
    at: usize,
) -> Result<[f32; N], ModelError> {
    if !count.contains(&words.len()) {
        return flawed(Flaw::Broken, format!("line {at}: {} numbers", words.len()));
    }
    let mut values = [0.0; N];
    for (value, word) in values.iter_mut().zip(words) {
        match number(word) {
            Some(number) => *value = number,
            None => {
                let word: String = word.chars().take(20).collect();
                return flawed(
                    Flaw::NotANumber,
                    format!("line {at}: `{word}`, which is no number"),
                );
            }
        }
    }
    Ok(values)
}

/// `position/coordinates/normal`, each from 1, or from the last one backwards.
fn corner(word: &str, lists: &Lists, at: usize) -> Result<Corner, ModelError> {
    let index = |text: Option<&str>, count: usize| -> Result<Option<usize>, ModelError> {
        let Some(text) = text.filter(|text| !text.is_empty()) else {
            return Ok(None);
        };
        let found = text.parse::<i64>().ok().and_then(|index| match index {
            1.. => usize::try_from(index - 1)
                .ok()
                .filter(|index| *index < count),
            0 => None,
            _ => count.checked_sub(usize::try_from(index.unsigned_abs()).ok()?),
        });
        match found {
            Some(index) => Ok(Some(index)),
            None => {
                let text: String = text.chars().take(20).collect();
                flawed(
                    Flaw::NoSuchIndex,
                    format!("line {at}: index {text} of {count}"),
                )
            }
        }
    };
    let mut parts = word.split('/');
    let position = index(parts.next(), lists.positions.len())?;
    let coordinates = index(parts.next(), lists.coordinates.len())?;
    let normal = index(parts.next(), lists.normals.len())?;
    match (position, parts.next()) {
        (Some(position), None) => Ok((position, coordinates, normal)),
        _ => flawed(
            Flaw::Broken,
            format!("line {at}: a corner that is not position/coordinates/normal"),
        ),
    }
}
