//! Objects whose shape is a model from a file: read once, then drawn wherever a level and its module have them.

use crate::picture::Item;
use crate::shape::Shape;
use microsim_message::{ObjectScene, ObjectState, Shape as ObjectShape};
use microsim_model::{Part, read};
use std::collections::BTreeMap;

/// Models by the names of their files.
#[derive(Debug, Default)]
pub struct Models(BTreeMap<String, Vec<Part>>);

impl Models {
    /// Of files by their names; one that a model names is `MODEL/NAME`. Textures are left out: the renderer draws none yet.
    ///
    /// # Errors
    /// The name of a file that is refused, and why.
    pub fn new(files: &[(&str, &[u8])]) -> Result<Self, String> {
        let is_model = |name: &str| !name.contains('/') && !name.ends_with(".png");
        let mut found = BTreeMap::new();
        for (name, bytes) in files.iter().filter(|(name, _)| is_model(name)) {
            let beside = |reference: &str| {
                let whole = format!("{name}/{reference}");
                let file = files.iter().find(|(other, _)| *other == whole);
                file.map(|(_, bytes)| *bytes)
            };
            let model = read(name, bytes, &beside).map_err(|error| format!("{name}: {error}"))?;
            found.insert((*name).to_owned(), model.placed());
        }
        Ok(Self(found))
    }

    /// What is to be drawn of the objects that are models, each part where the object is. A part's own colour is multiplied by the object's.
    pub fn items(&self, scene: &ObjectScene) -> Vec<Item> {
        let items = scene.objects.iter().flat_map(|object| self.object(object));
        items.collect()
    }

    fn object(&self, object: &ObjectState) -> Vec<Item> {
        let ObjectShape::Model { model, scale, .. } = &object.shape else {
            return Vec::new();
        };
        let scale = *scale as f32;
        let parts = self.0.get(model).into_iter().flatten();
        let items = parts.map(|part| {
            let positions = part.positions.iter();
            let shape = Shape::Mesh {
                positions: positions.map(|p| p.map(|x| scale * x)).collect(),
                triangles: part.triangles.clone(),
            };
            let tint = part.colour.map_or([1.0; 3], |colour| colour.map(srgb));
            let colour = std::array::from_fn(|k| object.colour[k] as f32 * tint[k]);
            let item = Item::new(shape, [0.0; 3], colour, object.finish);
            item.at(object.pose.position, object.pose.orientation)
        });
        items.collect()
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
        let models = Models::new(&[("a.obj", TRIANGLE)]).expect("a model");
        let scene = ObjectScene {
            objects: vec![state("one", "a.obj", 0.01), state("two", "a.obj", 0.02)],
        };
        let items = models.items(&scene);
        let places: Vec<[f64; 3]> = items.iter().map(|item| item.position).collect();
        assert_eq!(places, [[0.01, 0.0, 0.0], [0.02, 0.0, 0.0]]);
        for item in &items {
            assert_eq!(item.orientation, scene.objects[0].pose.orientation);
            assert_eq!((item.colour, item.finish), ([1.0, 0.5, 0.0], Finish::Moist));
            let Shape::Mesh { positions, .. } = &item.shape else {
                panic!("{item:?}");
            };
            assert_eq!(positions[1], [1e-3, 0.0, 0.0]);
        }
        assert_eq!(models.items(&ObjectScene::default()), []);
    }

    #[test]
    fn a_broken_file_is_named() {
        let error = Models::new(&[("a.obj", b"v 0 0")]).expect_err("two numbers");
        assert!(error.starts_with("a.obj: line 1"), "{error}");
    }
}
