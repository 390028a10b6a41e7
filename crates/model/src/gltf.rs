//! glTF 2.0: a scene of nodes in JSON, numbers in buffers beside it or within.

mod bytes;
mod document;
mod scene;

use crate::error::{Flaw, ModelError, flawed};
use crate::mesh::Model;
use crate::texture::{Texture, Wrap, read_texture};
use bytes::{Source, container, source};
use document::{Document, MimeType};

/// Gives the bytes of a file in the folder of the model.
pub(crate) type Files<'f, 'a> = &'f dyn Fn(&str) -> Option<&'a [u8]>;

pub(crate) fn references(bytes: &[u8]) -> Result<Vec<String>, ModelError> {
    let (document, _) = container(bytes)?;
    let mut named = Vec::new();
    let buffers = document.buffers.iter().filter_map(|b| b.uri.as_deref());
    let images = document.images.iter().filter_map(|i| i.uri.as_deref());
    for uri in buffers.chain(images) {
        if let Source::File(name) = source(uri)?
            && !named.contains(&name)
        {
            named.push(name);
        }
    }
    Ok(named)
}

pub(crate) fn read<'a>(bytes: &'a [u8], file: Files<'_, 'a>) -> Result<Model, ModelError> {
    let (document, binary) = container(bytes)?;
    if let Some(extension) = document.extensions_required.first() {
        let extension: String = extension.chars().take(60).collect();
        return flawed(
            Flaw::NotRead,
            format!("the extension {extension}, which the file requires"),
        );
    }
    let buffers = bytes::Buffers::new(&document, binary, file)?;
    let mut model = scene::read(&document, &buffers)?;
    // Only those that parts show, each once.
    let mut shown: Vec<usize> = model.parts.iter().filter_map(|part| part.texture).collect();
    shown.sort_unstable();
    shown.dedup();
    for part in &mut model.parts {
        part.texture = part.texture.and_then(|t| shown.binary_search(&t).ok());
    }
    for image in shown {
        model
            .textures
            .push(texture(&document, image, &buffers, file)?);
    }
    Ok(model)
}

/// The picture of a texture.
fn texture<'a>(
    document: &Document,
    texture: usize,
    buffers: &bytes::Buffers<'a>,
    file: Files<'_, 'a>,
) -> Result<Texture, ModelError> {
    let texture = document.texture(texture)?;
    let Some(image) = texture.source else {
        return flawed(Flaw::NotRead, "a texture without a picture");
    };
    let image = document.image(image)?;
    if image.mime_type == Some(MimeType::Jpeg) {
        return flawed(Flaw::NotRead, "a texture in JPEG; textures are PNG");
    }
    let within = match (&image.uri, image.buffer_view) {
        (Some(uri), None) => match source(uri)? {
            Source::File(name) => match file(&name) {
                Some(bytes) => read_texture(bytes),
                None => flawed(Flaw::Missing, "a picture that is not there"),
            },
            Source::Within(bytes) => read_texture(&bytes),
        },
        (None, Some(view)) => read_texture(buffers.view(document.view(view)?)?),
        _ => {
            return flawed(
                Flaw::Broken,
                "a picture that is neither in a file nor in a buffer",
            );
        }
    };
    let read =
        within.map_err(|error| ModelError::new(error.flaw, format!("a texture: {error}")))?;
    let wrap = match texture.sampler {
        None => [Wrap::Repeat; 2],
        Some(sampler) => {
            let sampler = document.sampler(sampler)?;
            [wrap(sampler.wrap_s)?, wrap(sampler.wrap_t)?]
        }
    };
    Ok(Texture { wrap, ..read })
}

/// A wrap mode of a sampler (glTF 2.0, 5.26).
fn wrap(mode: Option<u32>) -> Result<Wrap, ModelError> {
    match mode {
        None | Some(10_497) => Ok(Wrap::Repeat),
        Some(33_648) => Ok(Wrap::Mirrored),
        Some(33_071) => Ok(Wrap::Clamp),
        Some(mode) => flawed(
            Flaw::Broken,
            format!(
                "a sampler of wrap mode {mode}; expected 10497 (repeat), 33648 (mirrored) or 33071 (clamp)"
            ),
        ),
    }
}
