//! Pictures of a scene as the microscope would show it: a PNG per frame.

use crate::scene_file::SceneFile;
use microsim_gpu::Gpu;
use microsim_render::{Finish, Item, Picture, Renderer, Shape, View};
use microsim_scene::{ObstacleSpec, Runner, Scene};
use microsim_settings as settings;
use std::path::{Path, PathBuf};

/// Width and height \[pixels\].
const SIZE: u32 = 960;
/// From the main lens to the focus \[m\]: a usual focal length of surgical microscopes.
const WORKING_DISTANCE: f64 = 0.25;
/// The field and the tilt \[rad\] of a scene that does not say them: the field is so many times as wide as its bodies are long.
const FIELD: f64 = 1.3;
const TILT: f64 = 0.9;
/// What shows where nothing lies.
const BACKGROUND: [f32; 3] = [0.07, 0.16, 0.17];
/// Tools, as the shipped ones are.
const METAL: [f32; 3] = [0.83, 0.85, 0.86];
/// Half the width of what stands for a plane, in fields.
const PLANE: f64 = 2.0;

/// A folder into which a run is drawn.
pub struct Pictures {
    folder: PathBuf,
    renderer: Renderer,
    view: View,
    bodies: Vec<([f32; 3], Finish)>,
    rigid: Vec<Item>,
    /// Time between two pictures \[s\], and the time of the next one.
    interval: f64,
    next: f64,
    count: usize,
}

impl Pictures {
    /// Begins in `folder`, which is made, with the start of the scene.
    pub fn new(folder: &Path, scene: &SceneFile) -> Result<Self, String> {
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let gpu = Gpu::off_screen().map_err(|e| e.to_string())?;
        let renderer = Renderer::new(&gpu).map_err(|e| e.to_string())?;
        let settings = &scene.loaded.settings;
        let view = view(settings.view, scene.runner.scene());
        let things = settings.rigid.iter().zip(&scene.spec.obstacles);
        let mut pictures = Self {
            folder: folder.to_path_buf(),
            renderer,
            rigid: things
                .flat_map(|(told, thing)| rigid(told, thing, view.field_diameter))
                .collect(),
            view,
            bodies: settings
                .body
                .iter()
                .map(|body| (colour(body.colour), finish(body.finish)))
                .collect(),
            interval: settings.run.frame,
            next: 0.0,
            count: 0,
        };
        pictures.after_sample(&scene.runner)?;
        Ok(pictures)
    }

    /// Draws if it is time for a picture; the last state always has one.
    pub fn after_sample(&mut self, runner: &Runner) -> Result<(), String> {
        let scene = runner.scene();
        let time = scene.time();
        if time < self.next - 0.5 * runner.sample() && runner.end().is_none() {
            return Ok(());
        }
        self.next = time + self.interval;
        let bodies = self.bodies.iter().enumerate().flat_map(|(body, look)| {
            let positions = scene.positions(body).iter();
            let positions = positions.map(|p| p.map(|c| c as f32).into()).collect();
            let triangles = &scene.surface(body).triangles;
            Item::tissue(positions, triangles, scene.inner(body), look.0, look.1)
        });
        let capsules = (0..scene.tool_count()).flat_map(|tool| scene.own_capsules(tool));
        let tools = capsules.map(|capsule| {
            let shape = Shape::Capsule {
                a: capsule.a.into(),
                b: capsule.b.into(),
                radius: capsule.radius,
            };
            Item::new(shape, [0.0; 3], METAL, Finish::Metal)
        });
        let picture = Picture {
            width: SIZE,
            height: SIZE,
            view: self.view,
            background: BACKGROUND,
            items: self
                .rigid
                .iter()
                .cloned()
                .chain(bodies)
                .chain(tools)
                .collect(),
        };
        let image = self.renderer.draw(&picture).map_err(|e| e.to_string())?;
        let path = self.folder.join(format!("frame-{:06}.png", self.count));
        image
            .write_png(&path)
            .map_err(|e| format!("{}: {e}", path.display()))?;
        self.count += 1;
        Ok(())
    }

    /// The folder and the number of pictures.
    pub fn finish(self) -> (PathBuf, usize) {
        (self.folder, self.count)
    }
}

/// What the scene says, or all bodies as they lie at the start.
fn view(said: Option<settings::View>, scene: &Scene) -> View {
    let said = said.unwrap_or_else(|| {
        let bodies = 0..scene.body_count();
        let all = || bodies.clone().flat_map(|body| scene.positions(body));
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for p in all() {
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        let sides = [0, 1, 2].map(|k| high[k] - low[k]);
        settings::View {
            field: FIELD * sides.iter().map(|s| s * s).sum::<f64>().sqrt(),
            centre: [0, 1, 2].map(|k| 0.5 * (low[k] + high[k])),
            tilt: TILT,
        }
    });
    View {
        centre: said.centre,
        field_diameter: said.field,
        working_distance: WORKING_DISTANCE.max(said.field),
        tilt: said.tilt,
    }
}

/// The parts of an obstacle.
fn rigid(told: &settings::Rigid, thing: &ObstacleSpec, field: f64) -> Vec<Item> {
    let item = |part: &microsim_scene::ObstaclePart| {
        let (shape, sunk) = match part.shape {
            microsim_scene::ObstacleShape::HalfSpace => {
                let half = PLANE * field;
                (
                    Shape::Box {
                        half: [half, half, 0.01 * half],
                    },
                    0.01 * half,
                )
            }
            microsim_scene::ObstacleShape::Cuboid { half_size, .. } => {
                (Shape::Box { half: half_size }, 0.0)
            }
            microsim_scene::ObstacleShape::Cylinder {
                radius,
                half_length,
            } => (
                Shape::Cylinder {
                    radius,
                    height: 2.0 * half_length,
                },
                half_length,
            ),
        };
        let down = part.pose.orientation * nalgebra::Vector3::z() * sunk;
        let turn = part.pose.orientation.coords;
        let position = part.pose.position - down;
        Item {
            orientation: [turn.x, turn.y, turn.z, turn.w],
            ..Item::new(
                shape,
                position.into(),
                colour(told.colour),
                finish(told.finish),
            )
        }
    };
    thing.parts.iter().map(item).collect()
}

fn colour(colour: settings::Colour) -> [f32; 3] {
    [colour.red, colour.green, colour.blue].map(|c| f32::from(c) / 255.0)
}

fn finish(finish: settings::Finish) -> Finish {
    match finish {
        settings::Finish::Matte => Finish::Matte,
        settings::Finish::Moist => Finish::Moist,
        settings::Finish::Metal => Finish::Metal,
    }
}
