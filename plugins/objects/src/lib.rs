//! Virtual objects (dissertation, 5.2.1): unique names, places in a scene graph, properties for drawing; a module
//! activates, moves and colours them by name. The rigid obstacles of the level are shown as well: they stand, and a module
//! may colour them.
//!
//! Tetrahedral bodies are the physics plugin's. Files of models and textures are known by their names here; whoever draws has their content.

#![forbid(unsafe_code)]

use microsim_geometry::Pose as Place;
use microsim_sdk::message::{
    Colour, Finish, ObjectScene, ObjectSet, ObjectState, Pose, Shape, decode_bytes, encode,
};
use microsim_sdk::{Fault, Plugin, Services, Setup, Tick, export_plugin};
use microsim_settings::{ObjectsConfig, Rigid, Shape as LevelShape, Solid};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What does not change.
#[derive(Debug)]
struct Model {
    name: String,
    parent: Option<usize>,
    shape: Shape,
    finish: Finish,
    /// Whether it is a part of a rigid obstacle.
    stands: bool,
}

/// What a module may change.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    active: bool,
    pose: Pose,
    colour: Colour,
}

/// The virtual objects of a level.
#[derive(Debug, Default)]
pub struct Objects {
    models: Vec<Model>,
    start: Vec<State>,
    states: Vec<State>,
    changed: bool,
}

impl Objects {
    /// Pose in the field: the chain of parents, whose activity does not matter.
    fn world(&self, index: usize) -> Pose {
        let mut at = Place::from_arrays(
            self.states[index].pose.position,
            self.states[index].pose.orientation,
        );
        let mut parent = self.models[index].parent;
        while let Some(above) = parent {
            let frame = Place::from_arrays(
                self.states[above].pose.position,
                self.states[above].pose.orientation,
            );
            at = Place {
                position: frame.apply(&at.position),
                orientation: frame.orientation * at.orientation,
            };
            parent = self.models[above].parent;
        }
        Pose {
            position: at.position.into(),
            orientation: at.orientation.coords.into(),
        }
    }

    fn scene(&self) -> ObjectScene {
        let active = (0..self.models.len()).filter(|i| self.states[*i].active);
        let objects = active.map(|i| ObjectState {
            name: self.models[i].name.clone(),
            shape: self.models[i].shape.clone(),
            pose: self.world(i),
            colour: self.states[i].colour,
            finish: self.models[i].finish,
        });
        ObjectScene {
            objects: objects.collect(),
        }
    }

    fn set(&mut self, change: &ObjectSet) -> Result<(), Fault> {
        let mut known = false;
        for (model, state) in self.models.iter().zip(&mut self.states) {
            if model.name != change.name {
                continue;
            }
            if model.stands && (change.active.is_some() || change.pose.is_some()) {
                return Err(Fault::new(format!(
                    "a module moves or hides the rigid obstacle \"{}\": it stands, its colour alone may change",
                    change.name
                )));
            }
            known = true;
            let before = state.clone();
            state.active = change.active.unwrap_or(state.active);
            state.pose = change.pose.unwrap_or(state.pose);
            state.colour = change.colour.unwrap_or(state.colour);
            self.changed |= *state != before;
        }
        if known {
            return Ok(());
        }
        let mut names: Vec<&str> = self.models.iter().map(|m| m.name.as_str()).collect();
        names.dedup();
        Err(Fault::new(format!(
            "a module names the object \"{}\"; this level has: {}",
            change.name,
            names.join(", ")
        )))
    }

    /// The solid parts of a rigid obstacle.
    fn add_rigid(&mut self, thing: &Rigid) {
        let place = Place::from_arrays(thing.position, thing.orientation);
        for part in thing.shape.parts() {
            self.models.push(Model {
                name: thing.name.clone(),
                parent: None,
                shape: match part.solid {
                    Solid::HalfSpace => Shape::HalfSpace,
                    Solid::Cuboid { half_size, .. } => Shape::Box { half_size },
                    Solid::Cylinder { radius, length } => Shape::Cylinder { radius, length },
                },
                finish: thing.finish,
                stands: true,
            });
            self.start.push(State {
                active: true,
                pose: Pose {
                    position: place.apply(&part.centre.into()).into(),
                    orientation: thing.orientation,
                },
                colour: thing.colour.srgb(),
            });
        }
    }
}

fn shape(shape: &LevelShape) -> Shape {
    match shape.clone() {
        LevelShape::Sphere { radius } => Shape::Sphere { radius },
        LevelShape::Capsule { radius, length } => Shape::Capsule { radius, length },
        LevelShape::Box { half_size } => Shape::Box { half_size },
        LevelShape::Ring { radius, tube } => Shape::Ring { radius, tube },
        LevelShape::Model {
            model,
            scale,
            texture,
        } => Shape::Model {
            model,
            scale,
            texture,
        },
    }
}

impl Plugin for Objects {
    fn new() -> Self {
        Self::default()
    }

    fn initialise(&mut self, setup: &Setup, _: Services) -> Result<(), Fault> {
        let config: ObjectsConfig = setup.configuration()?;
        for thing in &config.rigid {
            self.add_rigid(thing);
        }
        let mut index = BTreeMap::new();
        for object in &config.objects {
            for name in object.names() {
                index.insert(name, self.models.len() + index.len());
            }
        }
        for object in &config.objects {
            let parent = object.parent.as_ref().and_then(|p| index.get(p).copied());
            for name in object.names() {
                self.models.push(Model {
                    name,
                    parent,
                    shape: shape(&object.shape),
                    finish: object.finish,
                    stands: false,
                });
                self.start.push(State {
                    active: object.active,
                    pose: Pose {
                        position: object.position,
                        orientation: object.orientation,
                    },
                    colour: object.colour.srgb(),
                });
            }
        }
        self.reset()
    }

    fn reset(&mut self) -> Result<(), Fault> {
        self.states = self.start.clone();
        self.changed = true;
        Ok(())
    }

    fn process(&mut self, tick: &mut Tick<'_>) -> Result<(), Fault> {
        for change in tick.messages::<ObjectSet>()? {
            self.set(&change)?;
        }
        if self.changed {
            tick.publish(&self.scene());
            self.changed = false;
        }
        Ok(())
    }

    fn save(&self) -> Vec<u8> {
        encode(&(&self.states, self.changed))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), Fault> {
        let (states, changed): (Vec<State>, bool) = decode_bytes(state)?;
        if states.len() != self.models.len() {
            return Err(Fault::new("the saved state belongs to another level"));
        }
        (self.states, self.changed) = (states, changed);
        Ok(())
    }
}

export_plugin!(Objects, "../plugin.toml");

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_sdk::TestHost;
    use serde_json::json;

    fn host() -> TestHost<Objects> {
        let look = |mut thing: serde_json::Value| {
            for (key, value) in [("colour", json!("#ff0000")), ("finish", json!("matte"))] {
                thing[key] = value;
            }
            thing["orientation"] = json!([0.0, 0.0, 0.0, 1.0]);
            thing
        };
        let rigid = [
            look(json!({
                "name": "tray", "shape": "tray", "half_size": [0.004, 0.003, 0.001], "wall": 0.0005,
                "position": [0.01, 0.0, 0.0],
            })),
            look(json!({ "name": "ground", "shape": "plane", "position": [0.0, 0.0, -0.002] })),
        ];
        host_of(json!({ "objects": [], "rigid": rigid }))
    }

    fn host_of(config: serde_json::Value) -> TestHost<Objects> {
        let setup = Setup {
            name: "objects".into(),
            seed: 0,
            tick_ns: 1_000_000,
            steps: 1,
            level: 1,
            config,
            files: Vec::new(),
        };
        TestHost::new(&["object.scene"], &["object.set"], &[], setup).expect("a complete set-up")
    }

    fn set(name: &str) -> ObjectSet {
        ObjectSet {
            name: name.into(),
            ..ObjectSet::default()
        }
    }

    /// A tray is a floor and four walls, by its definition: its floor reaches a wall beyond the inner space and lies below it. A
    /// colour goes to all of its parts and to nothing else.
    #[test]
    fn rigid_things_are_shown_and_coloured_part_by_part() {
        let mut host = host();
        let scene: ObjectScene = host.tick().expect("a tick").last().expect("a scene");
        let tray: Vec<&ObjectState> = scene.objects.iter().filter(|o| o.name == "tray").collect();
        assert_eq!((tray.len(), scene.objects.len()), (5, 6));
        let floor = tray.iter().find(|part| part.pose.position[2] < -0.0011);
        let floor = floor.expect("a floor below the inner space");
        let Shape::Box { half_size } = floor.shape else {
            panic!("{:?}", floor.shape);
        };
        // Sums of a few decimals: rounding is below a nanometre by far.
        for (found, expected) in half_size.iter().zip([0.0045, 0.0035, 0.00025]) {
            assert!((found - expected).abs() < 1e-12, "{half_size:?}");
        }
        assert!((floor.pose.position[0] - 0.01).abs() < 1e-12);
        assert_eq!(scene.objects[5].shape, Shape::HalfSpace);

        host.send(&ObjectSet {
            colour: Some([0.0, 1.0, 0.0]),
            ..set("tray")
        });
        let scene: ObjectScene = host.tick().expect("a tick").last().expect("a change");
        for object in &scene.objects {
            let green = object.colour == [0.0, 1.0, 0.0];
            assert_eq!(green, object.name == "tray", "{}", object.name);
        }
    }

    /// A model hangs on a bar: a quarter turn of the bar about z takes its place (3, 0, 0) mm to (0, 3, 0) mm of the bar, which stands at x = 10 mm. What
    /// is hidden is not in the scene, whatever hangs on it.
    #[test]
    fn a_model_is_moved_with_its_parent_and_hidden_alone() {
        let object = |more: serde_json::Value| {
            let mut object = json!({
                "count": null, "radius": null, "length": null, "tube": null, "half_size": null, "position": [0.0, 0.0, 0.0],
                "orientation": [0.0, 0.0, 0.0, 1.0], "parent": null, "colour": "#ff0000", "finish": "matte", "active": true,
            });
            let more = more.as_object().expect("keys").clone();
            object.as_object_mut().expect("keys").extend(more);
            object
        };
        let objects = [
            object(
                json!({ "name": "bar", "shape": "sphere", "radius": 0.001, "position": [0.01, 0.0, 0.0] }),
            ),
            object(json!({
                "name": "clamp", "shape": "model", "model": "clamp.glb", "scale": 0.5, "texture": "steel.png",
                "parent": "bar", "position": [0.003, 0.0, 0.0],
            })),
        ];
        let mut host = host_of(json!({ "objects": objects, "rigid": [] }));
        let half = 0.5_f64.sqrt();
        host.send(&ObjectSet {
            pose: Some(Pose {
                position: [0.01, 0.0, 0.0],
                orientation: [0.0, 0.0, half, half],
            }),
            active: Some(false),
            ..set("bar")
        });
        let scene: ObjectScene = host.tick().expect("a tick").last().expect("a scene");
        let [clamp] = &scene.objects[..] else {
            panic!("{scene:?}");
        };
        let shape = Shape::Model {
            model: "clamp.glb".into(),
            scale: 0.5,
            texture: Some("steel.png".into()),
        };
        assert_eq!((&clamp.name[..], &clamp.shape), ("clamp", &shape));
        for (found, expected) in clamp.pose.position.iter().zip([0.01, 0.003, 0.0]) {
            assert!((found - expected).abs() < 1e-12, "{:?}", clamp.pose);
        }
        assert!((clamp.pose.orientation[2] - half).abs() < 1e-12);
        host.send(&ObjectSet {
            active: Some(false),
            ..set("clamp")
        });
        let scene: ObjectScene = host.tick().expect("a tick").last().expect("a change");
        assert_eq!(scene.objects, []);
    }

    #[test]
    fn a_rigid_thing_neither_moves_nor_hides() {
        for change in [
            ObjectSet {
                pose: Some(Pose::default()),
                ..set("tray")
            },
            ObjectSet {
                active: Some(false),
                ..set("tray")
            },
        ] {
            let mut host = host();
            host.send(&change);
            let fault = host.tick().expect_err("it stands");
            assert!(fault.to_string().contains("\"tray\""), "{fault}");
        }
    }
}
