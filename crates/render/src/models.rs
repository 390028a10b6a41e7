//! Objects whose shape is a model from a file: read once, then drawn wherever a level and its module have them.

use crate::mesh::{Detail, Mesh, Vertex};
use crate::picture::Item;
use crate::shape::{Model, Shape};
use crate::textures::Texture;
use microsim_message::{ObjectScene, ObjectState, Shape as ObjectShape};
use microsim_model::{Part, read, read_texture};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Sizes and textures of models that are remembered at most.
const MOST: usize = 256;

/// A model as a file has it.
#[derive(Debug)]
struct Read {
    parts: Vec<Part>,
    /// Textures that parts refer to.
    textures: Vec<Texture>,
}

/// What an object shows: the file of its model, the bits of its scale, the file of its texture.
type Key = (String, u64, Option<String>);

/// A part that is drawn, with its own colour, sRGB.
type Tinted = (Arc<Model>, [f32; 3]);

/// Models and textures by the names of their files.
#[derive(Debug, Default)]
pub struct Models {
    read: BTreeMap<String, Read>,
    textures: BTreeMap<String, Texture>,
    /// What was drawn so far.
    drawn: BTreeMap<Key, Vec<Tinted>>,
}

impl Models {
    /// Of files by their names; one that a model names is `MODEL/NAME`.
    ///
    /// # Errors
    /// The name of a file that is refused, and why.
    pub fn new(files: &[(&str, &[u8])]) -> Result<Self, String> {
        let mut models = Self::default();
        for (name, bytes) in files.iter().filter(|(name, _)| !name.contains('/')) {
            let named = |error| format!("{name}: {error}");
            if name.ends_with(".png") {
                let texture = read_texture(bytes).map_err(named)?;
                let texture = Texture::new(texture);
                models.textures.insert((*name).to_owned(), texture);
                continue;
            }
            let beside = |reference: &str| {
                let whole = format!("{name}/{reference}");
                let file = files.iter().find(|(other, _)| *other == whole);
                file.map(|(_, bytes)| *bytes)
            };
            let model = read(name, bytes, &beside).map_err(named)?;
            let read = Read {
                parts: model.placed(),
                textures: model.textures.into_iter().map(Texture::new).collect(),
            };
            models.read.insert((*name).to_owned(), read);
        }
        Ok(models)
    }

    /// What is to be drawn of the objects that are models, each part where the object is. Colour of the object, colour of the part and texture are multiplied;
    /// the texture of an object goes before that of a part, and all of the part is there then, as only a file states where it is cut out.
    pub fn items(&mut self, scene: &ObjectScene) -> Vec<Item> {
        let items = scene.objects.iter().flat_map(|object| self.object(object));
        items.collect()
    }

    fn object(&mut self, object: &ObjectState) -> Vec<Item> {
        let ObjectShape::Model {
            model,
            scale,
            texture,
        } = &object.shape
        else {
            return Vec::new();
        };
        let Some(read) = self.read.get(model) else {
            return Vec::new();
        };
        if self.drawn.len() >= MOST {
            self.drawn.clear();
        }
        let key = (model.clone(), scale.to_bits(), texture.clone());
        let textures = &self.textures;
        let parts = self.drawn.entry(key).or_insert_with(|| {
            let own = texture.as_ref().and_then(|name| textures.get(name));
            let parts = read.parts.iter();
            parts
                .map(|part| {
                    let of_part = part.texture.and_then(|place| read.textures.get(place));
                    let texture = own.or(of_part).filter(|_| !part.coordinates.is_empty());
                    let mask = part.mask.filter(|_| own.is_none());
                    let mesh = mesh(part, *scale as f32);
                    let model = Model::of_file(mesh, texture.cloned(), mask);
                    let tint = part.colour.map_or([1.0; 3], |colour| colour.map(srgb));
                    (Arc::new(model), tint)
                })
                .collect()
        });
        let items = parts.iter().map(|(model, tint)| {
            let colour = std::array::from_fn(|k| object.colour[k] as f32 * tint[k]);
            let shape = Shape::Model(Arc::clone(model));
            let item = Item::new(shape, [0.0; 3], colour, object.finish);
            item.at(object.pose.position, object.pose.orientation)
        });
        items.collect()
    }
}

/// Triangles of a part, so many times as large.
fn mesh(part: &Part, scale: f32) -> Mesh {
    let scaled = |position: &[f32; 3]| position.map(|x| scale * x);
    let vertices = part.positions.iter().zip(&part.normals);
    let coordinates = part.coordinates.iter().copied();
    let coordinates = coordinates.chain(std::iter::repeat([0.0; 2]));
    Mesh {
        vertices: vertices
            .map(|(position, normal)| Vertex {
                position: scaled(position),
                normal: *normal,
            })
            .collect(),
        details: part
            .positions
            .iter()
            .zip(coordinates)
            .map(|(position, coordinates)| Detail {
                rest: scaled(position).map(|x| 1e3 * x),
                layer: 0.0,
                coordinates,
            })
            .collect(),
        indices: part.triangles.as_flattened().to_vec(),
    }
}

/// A linear intensity as sRGB has it (IEC 61966-2-1).
fn srgb(linear: f32) -> f32 {
    match linear <= 0.003_130_8 {
        true => 12.92 * linear,
        false => 1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_message::Pose;
    use microsim_vocabulary::Finish;

    /// A triangle with one corner a unit along x, in a file of millimetres.
    const TRIANGLE: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    fn state(name: &str, model: &str, x: f64) -> ObjectState {
        ObjectState {
            name: name.into(),
            shape: ObjectShape::Model {
                model: model.into(),
                scale: 1e-3,
                texture: None,
            },
            pose: Pose {
                position: [x, 0.0, 0.0],
                orientation: [0.0, 0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()],
            },
            colour: [1.0, 0.5, 0.0],
            finish: Finish::Moist,
        }
    }

    /// What the scene has is drawn where it has it, as large as the scale makes it; what is not in the scene, as it is hidden, is not drawn.
    #[test]
    fn models_are_drawn_where_the_scene_has_them() {
        let mut models = Models::new(&[("a.obj", TRIANGLE)]).expect("a model");
        let scene = ObjectScene {
            objects: vec![state("one", "a.obj", 0.01), state("two", "a.obj", 0.02)],
        };
        let items = models.items(&scene);
        let places: Vec<[f64; 3]> = items.iter().map(|item| item.position).collect();
        assert_eq!(places, [[0.01, 0.0, 0.0], [0.02, 0.0, 0.0]]);
        for item in &items {
            assert_eq!(item.orientation, scene.objects[0].pose.orientation);
            assert_eq!((item.colour, item.finish), ([1.0, 0.5, 0.0], Finish::Moist));
            let Shape::Model(model) = &item.shape else {
                panic!("{item:?}");
            };
            assert_eq!(model.mesh().vertices[1].position, [1e-3, 0.0, 0.0]);
            assert!(model.texture().is_none() && !model.is_closed());
        }
        // One model on the device for both, and for all pictures.
        assert_eq!(items[0].shape, items[1].shape);
        assert_eq!(models.items(&scene), items);
        assert_eq!(models.items(&ObjectScene::default()), []);
    }

    #[test]
    fn a_broken_file_is_named() {
        let error = Models::new(&[("a.obj", b"v 0 0")]).expect_err("two numbers");
        assert!(error.starts_with("a.obj: line 1"), "{error}");
    }
}
