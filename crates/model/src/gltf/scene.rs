//! The scene of a glTF file as nodes and parts.

use super::bytes::Buffers;
use super::document::{Document, Material, Node as Entry, Primitive};
use crate::affine::Affine;
use crate::error::{Flaw, ModelError, flawed};
use crate::mesh::{MAX_CORNERS, MAX_NODES, Mask, Model, Node, Part, unit};
use crate::numbers::{coordinate, point};

const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

/// A file without normals has flat faces (glTF 2.0, 3.7.2.1).
const FLAT: f64 = 1.0 - 1e-6;

pub(super) fn read(document: &Document, buffers: &Buffers<'_>) -> Result<Model, ModelError> {
    let mut model = Model::default();
    let mut seen = vec![false; document.nodes.len()];
    // Parents before their children, siblings in their order.
    let mut open: Vec<(usize, Option<usize>)> = document
        .shown()?
        .into_iter()
        .rev()
        .map(|node| (node, None))
        .collect();
    let mut corners = 0;
    while let Some((index, parent)) = open.pop() {
        let entry = document.node(index)?;
        if std::mem::replace(&mut seen[index], true) {
            return flawed(
                Flaw::Broken,
                format!("node {index}, which hangs on more than one, or on itself"),
            );
        }
        if model.nodes.len() == MAX_NODES {
            return flawed(Flaw::TooLarge, format!("more than {MAX_NODES} nodes"));
        }
        let node = model.nodes.len();
        model.nodes.push(Node {
            name: entry.name.clone(),
            parent,
            place: place(entry)?,
        });
        open.extend(
            entry
                .children
                .iter()
                .rev()
                .map(|child| (*child, Some(node))),
        );
        let Some(mesh) = entry.mesh else {
            continue;
        };
        if entry.skin.is_some() {
            return flawed(Flaw::NotRead, "a skin");
        }
        for primitive in &document.mesh(mesh)?.primitives {
            let part = part(node, primitive, document, buffers)?;
            corners += 3 * part.triangles.len();
            if corners > MAX_CORNERS {
                return flawed(
                    Flaw::TooLarge,
                    format!("more than {} triangles", MAX_CORNERS / 3),
                );
            }
            if !part.triangles.is_empty() {
                model.parts.push(part);
            }
        }
    }
    Ok(model)
}

fn part(
    node: usize,
    primitive: &Primitive,
    document: &Document,
    buffers: &Buffers<'_>,
) -> Result<Part, ModelError> {
    if !primitive.targets.is_empty() {
        return flawed(Flaw::NotRead, "a mesh that morphs");
    }
    let Some(position) = primitive.attributes.position else {
        return flawed(Flaw::Broken, "triangles without positions");
    };
    let mut part = Part {
        node,
        ..Part::default()
    };
    for values in buffers.vectors::<3>(document, position)? {
        part.positions.push(point(values)?);
    }
    if let Some(normal) = primitive.attributes.normal {
        for values in buffers.vectors::<3>(document, normal)? {
            let normal = unit(point(values)?.map(f64::from));
            part.normals.push(normal.map(|x| x as f32));
        }
    }
    if let Some(coordinates) = primitive.attributes.texcoord_0 {
        for [u, v] in buffers.vectors::<2>(document, coordinates)? {
            part.coordinates.push([coordinate(u)?, coordinate(v)?]);
        }
    }
    let count = part.positions.len();
    for (what, other) in [
        ("normals", part.normals.len()),
        ("texture coordinates", part.coordinates.len()),
    ] {
        if other != 0 && other != count {
            return flawed(Flaw::Broken, format!("{other} {what} for {count} vertices"));
        }
    }
    let indices = match primitive.indices {
        Some(indices) => buffers.indices(document, indices)?,
        None => (0..count as u32).collect(),
    };
    part.triangles = triangles(primitive.mode.unwrap_or(TRIANGLES), &indices)?;
    part.check()?;
    if let Some(material) = primitive.material {
        let material = document.material(material)?;
        let surface = &material.pbr_metallic_roughness;
        let colour = surface.base_color_factor.map(|[r, g, b, _]| [r, g, b]);
        let is_colour = |c: &f32| (0.0..=1.0).contains(c);
        if colour.is_some_and(|colour| !colour.iter().all(is_colour)) {
            return flawed(Flaw::NotANumber, "a base colour outside of 0 to 1");
        }
        part.colour = colour;
        if let Some(texture) = &surface.base_color_texture {
            document.texture(texture.index)?;
            if texture.tex_coord != 0 {
                return flawed(
                    Flaw::NotRead,
                    "a texture at other than the first texture coordinates",
                );
            }
            part.texture = Some(texture.index).filter(|_| !part.coordinates.is_empty());
        }
        let mask = mask(material)?;
        match (mask, part.texture) {
            // Of one opacity everywhere: all of it is there, or nothing.
            (Some(mask), None) if mask.factor < mask.cutoff => part.triangles.clear(),
            (_, None) => {}
            (mask, Some(_)) => part.mask = mask,
        }
    }
    if part.normals.is_empty() {
        part.set_normals(FLAT);
    }
    Ok(part)
}

/// What of a surface is there (glTF 2.0, 3.9.4); `None` if all of it is.
fn mask(material: &Material) -> Result<Option<Mask>, ModelError> {
    let factor = material.pbr_metallic_roughness.base_color_factor;
    match material.alpha_mode.as_deref() {
        None | Some("OPAQUE") => Ok(None),
        Some("MASK") => {
            let mask = Mask {
                cutoff: material.alpha_cutoff.unwrap_or(0.5),
                factor: factor.map_or(1.0, |[.., opacity]| opacity),
            };
            if !(mask.cutoff >= 0.0 && mask.cutoff.is_finite()) {
                return flawed(Flaw::NotANumber, "an alphaCutoff below 0");
            }
            match (0.0..=1.0).contains(&mask.factor) {
                true => Ok(Some(mask)),
                false => flawed(Flaw::NotANumber, "an opacity outside of 0 to 1"),
            }
        }
        Some("BLEND") => flawed(
            Flaw::NotRead,
            "a material of alphaMode BLEND; OPAQUE and MASK are drawn",
        ),
        Some(other) => {
            let other: String = other.chars().take(60).collect();
            flawed(
                Flaw::Broken,
                format!("a material of alphaMode {other}; expected OPAQUE, MASK or BLEND"),
            )
        }
    }
}

fn triangles(mode: u32, indices: &[u32]) -> Result<Vec<[u32; 3]>, ModelError> {
    let found = match mode {
        TRIANGLES if !indices.len().is_multiple_of(3) => {
            return flawed(
                Flaw::Broken,
                format!("triangles of {} corners", indices.len()),
            );
        }
        TRIANGLES => indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect(),
        STRIP => {
            let triangles = indices.windows(3).enumerate();
            // Every other one is the other side up.
            let turned = |(k, t): (usize, &[u32])| match k % 2 {
                0 => [t[0], t[1], t[2]],
                _ => [t[1], t[0], t[2]],
            };
            triangles.map(turned).collect()
        }
        FAN => match indices {
            [first, rest @ ..] => rest.windows(2).map(|t| [*first, t[0], t[1]]).collect(),
            [] => Vec::new(),
        },
        0..=3 => return flawed(Flaw::NotRead, "points or lines"),
        _ => return flawed(Flaw::Broken, format!("a primitive of mode {mode}")),
    };
    Ok(found)
}

/// Where a node lies in the frame of its parent.
fn place(entry: &Entry) -> Result<Affine, ModelError> {
    let parts = entry.translation.is_some() || entry.rotation.is_some() || entry.scale.is_some();
    let place = match entry.matrix {
        Some(_) if parts => return flawed(Flaw::Broken, "a node with a matrix and parts of one"),
        // By columns.
        Some(m) => {
            if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
                return flawed(Flaw::Broken, "a matrix that is not affine");
            }
            Affine {
                linear: [0, 1, 2].map(|i| [m[i], m[4 + i], m[8 + i]]),
                offset: [m[12], m[13], m[14]],
            }
        }
        None => {
            let [x, y, z, w] = entry.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
            let norm = x * x + y * y + z * z + w * w;
            // Single precision, written with few digits.
            if norm.is_nan() || (norm - 1.0).abs() >= 0.01 {
                return flawed(Flaw::NotANumber, "a rotation that is no unit quaternion");
            }
            let s = 2.0 / norm;
            let turned = [
                [
                    1.0 - s * (y * y + z * z),
                    s * (x * y - z * w),
                    s * (x * z + y * w),
                ],
                [
                    s * (x * y + z * w),
                    1.0 - s * (x * x + z * z),
                    s * (y * z - x * w),
                ],
                [
                    s * (x * z - y * w),
                    s * (y * z + x * w),
                    1.0 - s * (x * x + y * y),
                ],
            ];
            let scale = entry.scale.unwrap_or([1.0; 3]);
            Affine {
                linear: turned.map(|row| [0, 1, 2].map(|j| row[j] * scale[j])),
                offset: entry.translation.unwrap_or_default(),
            }
        }
    };
    match place.is_bounded() {
        true => Ok(place),
        false => flawed(Flaw::NotANumber, "a place that is not finite, or too far"),
    }
}
