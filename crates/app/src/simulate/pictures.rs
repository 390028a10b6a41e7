//! Pictures of a scene as the microscope would show it: a PNG per frame.

use crate::scene_file::SceneFile;
use microsim_gpu::Gpu;
use microsim_render::{
    Fields, Finish, Item, LegendWords, Picture, Quality, Renderer, Shape, Tissue, View, debug,
    snapshot,
};
use microsim_scene::{Material, ObstaclePart, ObstacleShape, ObstacleSpec, Runner, Scene};
use microsim_settings::{self as settings, DebugView, unwritable};
use std::path::{Path, PathBuf};

/// Width and height \[pixels\].
const SIZE: u32 = 960;
/// The field and the tilt \[rad\] of a scene that does not state them: the field is this many times as wide as its bodies are long.
const FIELD: f64 = 1.3;
const TILT: f64 = 0.9;
/// Tools with capsules of their own.
const METAL: [f32; 3] = [0.83, 0.85, 0.86];
/// Opacity of capsules that are laid over a tool.
const FAINT: f32 = 0.35;
/// A folder into which a run is drawn.
pub struct Pictures {
    folder: PathBuf,
    renderer: Renderer,
    view: View,
    /// Colour of each body, and whether it is a vein by its name.
    bodies: Vec<([f32; 3], bool)>,
    rigid: Vec<Item>,
    /// Of each tool its name in `config/tools` and its shape; those with capsules of their own have none.
    models: Vec<Option<(String, settings::Tool)>>,
    /// What is laid over them, and for that the materials of each body by the regions of its mesh.
    views: Vec<DebugView>,
    materials: Vec<Vec<(u32, Material)>>,
    /// Time between two pictures \[s\], and the time of the next one.
    interval: f64,
    next: f64,
    count: usize,
}

impl Pictures {
    /// Begins in `folder`, which is made, with the start of the scene.
    pub fn new(folder: &Path, scene: &SceneFile, views: &[DebugView]) -> Result<Self, String> {
        std::fs::create_dir_all(folder).map_err(|e| unwritable(folder, e))?;
        let gpu = Gpu::off_screen().map_err(|e| e.to_string())?;
        let mut renderer = Renderer::new(&gpu).map_err(|e| e.to_string())?;
        // Whoever looks at a file has time, with a software driver too.
        renderer.set_quality(Quality::Medium);
        let settings = &scene.loaded.settings;
        let view = view(settings.view, scene.runner.scene());
        let obstacles = settings.rigid.iter().zip(&scene.spec.obstacles);
        let mut pictures = Self {
            folder: folder.to_path_buf(),
            renderer,
            rigid: obstacles
                .flat_map(|(given, obstacle)| rigid(given, obstacle, view.field_diameter))
                .collect(),
            view,
            models: models(scene)?,
            bodies: settings
                .body
                .iter()
                .map(|body| (colour(body.colour), body.name.contains("vein")))
                .collect(),
            views: views.to_vec(),
            materials: scene
                .spec
                .bodies
                .iter()
                .map(|b| b.materials.clone())
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
        let bodies = self.bodies.iter().enumerate().map(|(index, look)| {
            let body = scene.body(index);
            let points = |points: &[nalgebra::Vector3<f64>]| -> Vec<[f32; 3]> {
                points.iter().map(|p| p.map(|c| c as f32).into()).collect()
            };
            Tissue {
                body: index as u64,
                node_ids: body.node_ids().to_vec(),
                positions: points(body.positions()),
                rest: points(body.rest_positions()),
                triangles: body.surface().triangles.clone(),
                inner: body.opened().to_vec(),
                regions: body.triangle_regions().collect(),
                colour: look.0,
                vein: look.1,
                ..Tissue::default()
            }
        });
        let motions = scene.own_motions(time, time);
        let tools = motions
            .iter()
            .flat_map(|motion| match &self.models[motion.tool] {
                Some((name, model)) => {
                    let pose = microsim_message::Pose {
                        position: motion.to.position.into(),
                        orientation: motion.to.orientation.coords.into(),
                    };
                    snapshot::tool(name, model, pose, motion.opening_to, 1.0)
                }
                None => capsules(scene, motion.tool),
            });
        let mut items: Vec<Item> = self.rigid.iter().cloned().chain(tools).collect();
        if self.views.contains(&DebugView::Capsules) {
            let all = motions.iter();
            let all = all.flat_map(|motion| capsules(scene, motion.tool));
            items.extend(all.map(|item| Item {
                opacity: FAINT,
                ..item
            }));
        }
        let mut picture = Picture {
            tissues: bodies.collect(),
            ..Picture::new((SIZE, SIZE), self.view, items)
        };
        let legend = debug::bodies(&mut picture, &self.views, |tissue| {
            let body = tissue.body as usize;
            let fields = scene.body(body).node_fields(&self.materials[body]);
            Fields {
                von_mises: fields.von_mises.unwrap_or_default(),
                quality: fields.quality,
                remedies: fields.remedies,
            }
        });
        let mut image = self.renderer.draw(&picture).map_err(|e| e.to_string())?;
        if let Some(legend) = legend {
            image.write_legend(&legend, &LegendWords::ENGLISH);
        }
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

/// The capsules of a tool where it is now.
fn capsules(scene: &Scene, tool: usize) -> Vec<Item> {
    let capsules = scene.own_capsules(tool).into_iter();
    let items = capsules.map(|capsule| {
        let shape = Shape::Capsule {
            a: capsule.a.into(),
            b: capsule.b.into(),
            radius: capsule.radius,
        };
        Item::new(shape, [0.0; 3], METAL, Finish::Metal)
    });
    items.collect()
}

/// The shapes of tools that are some of `config/tools`.
fn models(scene: &SceneFile) -> Result<Vec<Option<(String, settings::Tool)>>, String> {
    let folder = scene.loaded.document.path();
    let folder = folder.parent().unwrap_or(Path::new("")).join("../tools");
    let model = |tool: &settings::SceneTool| {
        let Some(name) = &tool.model else {
            return Ok(None);
        };
        let loaded = settings::load_tool(&folder.join(name).with_extension("toml"));
        let loaded = loaded.map_err(|error| error.to_string())?;
        Ok(Some((name.clone(), loaded.settings)))
    };
    scene.loaded.settings.tool.iter().map(model).collect()
}

/// The view that the scene states, or all bodies as they lie at the start.
fn view(given: Option<settings::View>, scene: &Scene) -> View {
    let given = given.unwrap_or_else(|| {
        let bodies = 0..scene.body_count();
        let all = || bodies.clone().flat_map(|body| scene.body(body).positions());
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
    View::of_microscope(given.centre, given.field, given.tilt)
}

/// The parts of an obstacle.
fn rigid(given: &settings::Rigid, obstacle: &ObstacleSpec, field: f64) -> Vec<Item> {
    let (colour, finish) = (colour(given.colour), given.finish);
    let item = |part: &ObstaclePart| {
        let turn = part.pose.orientation.coords;
        let (position, orientation) = (part.pose.position.into(), turn.into());
        let item = |shape| Item::new(shape, position, colour, finish).at(position, orientation);
        match part.shape {
            ObstacleShape::HalfSpace => {
                Item::half_space(position, orientation, field, colour, finish)
            }
            ObstacleShape::Cuboid { half_size, .. } => item(Shape::Box { half: half_size }),
            ObstacleShape::Cylinder {
                radius,
                half_length,
            } => {
                let height = 2.0 * half_length;
                item(Shape::Cylinder { radius, height }).raised(-half_length)
            }
        }
    };
    obstacle.parts.iter().map(item).collect()
}

fn colour(colour: settings::Colour) -> [f32; 3] {
    colour.srgb().map(|c| c as f32)
}
