//! Models and textures of virtual objects from files: bytes in, triangle lists with normals, texture coordinates and a hierarchy of nodes out.
//!
//! [`read`] takes glTF 2.0 (`.glb`, `.gltf`), Wavefront OBJ (`.obj`) and STL (`.stl`, text or binary), [`read_texture`] PNG. The form is that of the name's
//! ending. [`write_glb`] writes glTF. Not here: files (the caller gives bytes, also of files that a `.gltf` names, see [`references`]), drawing, units: lengths are as in the file.
//!
//! # What is read of each form
//! - **glTF**: scene, nodes with matrices or translation, rotation and scale, triangles as lists, strips and fans with positions, normals and the first
//!   texture coordinates, base colours and their textures with the wrap modes of their samplers (not the filters: textures are always smoothed), surfaces that
//!   are opaque or cut out (`alphaMode` `OPAQUE` and `MASK`). Embedded data, and files beside it by their plain names.
//! - **OBJ**: `v`, `vn`, `vt`, `f` with any number of corners; each `o` is a node. Groups, smoothing and materials (`mtllib`, `usemtl`) are left out: colour and
//!   texture of an object come from its level.
//! - **STL**: the triangles; its normals are left out, as many programs write wrong ones.
//!
//! Where a file has no normals, those of faces that meet at less than [`CREASE`] are averaged, by area; edges sharper than that stay edges.
//!
//! # What is refused
//! Everything that is not as its form demands, with the kind of flaw ([`Flaw`]) and a sentence: truncated files, numbers that are not finite, indices that lead
//! nowhere, more than [`MAX_BYTES`], [`MAX_CORNERS`], [`MAX_NODES`] or [`MAX_TEXTURE`], unknown forms, files outside of the folder, extensions that a file requires,
//! skins and morphs, translucent surfaces (`alphaMode` `BLEND`), sparse data, pictures in other forms than PNG. No bytes make it panic, or take more memory than a multiple of their length.
//!
//! # Rationale
//! The crates `gltf` 1.4, `tobj` and `stl_io` were weighed: they leave ranges, cycles and sizes to the caller, who has to look at all of it again, and each format
//! refuses in words of its own. What is needed of the forms is small.

#![forbid(unsafe_code)]

mod affine;
mod error;
mod gltf;
mod mesh;
mod numbers;
mod obj;
mod stl;
mod texture;
mod write;

pub use affine::Affine;
pub use error::{Flaw, ModelError};
pub use mesh::{CREASE, MAX_BYTES, MAX_CORNERS, MAX_NODES, Mask, Model, Node, Part};
pub use texture::{MAX_TEXTURE, Texture, Wrap, read_texture};
pub use write::{MaterialToWrite, NodeToWrite, Triangles, write_glb};

use error::flawed;

/// Names of files in the same folder that a model names: buffers and pictures of a `.gltf`.
///
/// # Errors
/// A file that is not read, or that leads outside of the folder.
pub fn references(name: &str, bytes: &[u8]) -> Result<Vec<String>, ModelError> {
    match form(name, bytes)? {
        Form::Glb | Form::Gltf => gltf::references(bytes),
        Form::Obj | Form::Stl => Ok(Vec::new()),
    }
}

/// Reads a model; `file` gives the bytes of one that [`references`] has named.
///
/// # Errors
/// What is refused, see above.
pub fn read<'a>(
    name: &str,
    bytes: &'a [u8],
    file: &dyn Fn(&str) -> Option<&'a [u8]>,
) -> Result<Model, ModelError> {
    let model = match form(name, bytes)? {
        Form::Glb | Form::Gltf => gltf::read(bytes, file)?,
        Form::Obj => obj::read(bytes)?,
        Form::Stl => stl::read(bytes)?,
    };
    model.check()?;
    match model.parts.is_empty() {
        true => flawed(Flaw::Broken, "no triangle"),
        false => Ok(model),
    }
}

#[derive(Clone, Copy)]
enum Form {
    Glb,
    Gltf,
    Obj,
    Stl,
}

fn form(name: &str, bytes: &[u8]) -> Result<Form, ModelError> {
    let form = match name.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "glb" => Form::Glb,
        "gltf" => Form::Gltf,
        "obj" => Form::Obj,
        "stl" => Form::Stl,
        _ => {
            return flawed(
                Flaw::UnknownForm,
                "a name that does not end in .glb, .gltf, .obj or .stl",
            );
        }
    };
    match bytes.len() {
        0 => flawed(Flaw::Truncated, "an empty file"),
        n if n > MAX_BYTES => flawed(
            Flaw::TooLarge,
            format!("{n} bytes; at most {MAX_BYTES} are read"),
        ),
        _ => Ok(form),
    }
}
