//! The strip of a level on another mesh, stretched as its clamps do.

use crate::blade::{self, Plane};
use microsim_host::assemble::known_metrics;
use microsim_mesh::TetMesh;
use microsim_scene::{LevelParts, Pose, Scene, SceneSpec, Serial, ToolMotion, level_spec};
use microsim_settings::{self as settings, Loaded};
use microsim_tests::measured::thread_time;
use microsim_tests::repository;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Ticks in which the tissue comes to rest, and that are timed then.
const REST: usize = 100;
const TIMED: usize = 25;

/// How a strip is meshed.
#[derive(Clone, Copy, Debug)]
pub enum Mesh {
    /// Cells along its sides.
    Cells([u32; 3]),
    /// As shipped, but near marks with edges of at most this part of the longest, within a distance \[m\].
    Graded(f64, f64),
}

/// A level that cuts a strip.
pub struct Strip {
    level: Loaded<settings::Level>,
    models: BTreeMap<String, settings::Tool>,
    /// The middles of its marks \[m\].
    pub marks: Vec<Vector3<f64>>,
}

/// Keys of a body that refine it along the marks, of edges of at most `part` of the longest.
pub fn refined(marks: &[Vector3<f64>], part: f64, radius: f64) -> Vec<settings::Refine> {
    // The diagonal of a cell of 0.5 × 1 × 0.6 mm.
    let longest = Vector3::new(0.5e-3, 1e-3, 0.6e-3).norm();
    let of_mark = |mark: &Vector3<f64>| settings::Refine {
        point: Some([mark.x, -1e-3, 0.0]),
        to: Some([mark.x, 1e-3, 0.0]),
        normal: None,
        radius: Some(radius),
        region: None,
        // A hair more, so that rounding does not decide.
        size: 1.001 * longest * part,
    };
    marks.iter().map(of_mark).collect()
}

impl Strip {
    pub fn open(number: u32) -> Result<Self, String> {
        let root = repository();
        let module = root.join("modules/coordination");
        let manifest = settings::load_manifest(&module.join("module.toml"));
        let manifest = manifest.map_err(|e| e.to_string())?.settings;
        let path = module.join(format!("levels/level{number}.toml"));
        let level = settings::load_level(&path, &manifest, &known_metrics());
        let level = level.map_err(|e| e.to_string())?;
        let mut models = BTreeMap::new();
        for slot in &level.settings.tool {
            let path = root.join(format!("config/tools/{}.toml", slot.model));
            let tool = settings::load_tool(&path).map_err(|e| e.to_string())?;
            models.insert(slot.model.clone(), tool.settings);
        }
        let objects = level.settings.object.iter();
        let marks = objects.filter(|object| object.name.starts_with("mark-"));
        let marks = marks.map(|mark| Vector3::new(mark.position[0], mark.position[1], 0.0));
        Ok(Self {
            marks: marks.collect(),
            level,
            models,
        })
    }

    /// The mark of each plane: they take turns.
    pub fn cut_marks(&self, planes: &[Plane]) -> Vec<Vector3<f64>> {
        let marks = self.marks.iter().cycle().take(planes.len());
        marks.copied().collect()
    }

    /// The level on another mesh.
    pub fn with(&self, mesh: Mesh) -> Result<OnMesh<'_>, String> {
        let of = &self.level.settings;
        let mut bodies = of.body.clone();
        let body = bodies.first_mut().ok_or("a level without a body")?;
        match mesh {
            Mesh::Cells(cells) => body.cells = Some(cells),
            Mesh::Graded(part, radius) => body.refine = refined(&self.marks, part, radius),
        }
        let (Some(physics), Some(method)) = (&of.physics, &of.method) else {
            return Err("a level without physics".into());
        };
        let parts = LevelParts {
            physics,
            method,
            bodies: &bodies,
            rigid: &of.rigid,
            contacts: &of.contact,
            cuts: &of.cut,
            tools: &of.tool,
            models: &self.models,
        };
        let load = &mut |_: &std::path::Path| Err(std::io::ErrorKind::NotFound.into());
        let spec = level_spec(&parts, load).map_err(|e| e.to_string())?.spec;
        Ok(OnMesh { strip: self, spec })
    }
}

/// A level on a mesh.
pub struct OnMesh<'a> {
    strip: &'a Strip,
    spec: SceneSpec,
}

/// Tissue that its clamps have stretched.
pub struct Stretched {
    mesh: TetMesh,
    positions: Vec<Vector3<f64>>,
}

impl OnMesh<'_> {
    /// Its mesh at rest.
    pub fn mesh(&self) -> &TetMesh {
        &self.spec.bodies[0].mesh
    }

    fn ticks(
        &self,
        count: usize,
        motion: impl Fn(usize) -> Vec<ToolMotion>,
    ) -> Result<(Scene, Vec<f64>), String> {
        let mut scene = Scene::new(&self.spec).map_err(|e| e.to_string())?;
        let clock = &self.strip.level.settings.clock;
        let mut times = Vec::new();
        for tick in 0..count {
            let begin = now();
            let ticked = scene.tick(&motion(tick), clock.tick, clock.steps, &Serial);
            ticked.map_err(|e| e.to_string())?;
            times.push(now() - begin);
        }
        Ok((scene, times))
    }

    /// When its clamps have moved and it rests, without tools.
    pub fn stretched(&self) -> Result<Stretched, String> {
        let (scene, _) = self.ticks(REST, |_| Vec::new())?;
        Ok(Stretched {
            mesh: self.mesh().clone(),
            positions: scene.body(0).positions().to_vec(),
        })
    }

    /// The middle CPU time of a tick at rest while closed forceps stand on the tissue, 0.1 mm deep and 1 mm beside the first mark \[ms\].
    pub fn tick_under_forceps(&self) -> Result<f64, String> {
        let tools = self.strip.level.settings.tool.iter();
        let forceps = tools.enumerate().find(|(_, slot)| slot.model == "forceps");
        let (tool, _) = forceps.ok_or("a level without forceps")?;
        let mark = self.strip.marks.first().ok_or("a level without marks")?;
        let at = |tick: usize| {
            // 2 mm above the tissue, down in 40 ticks, to 0.1 mm below its upper side at 0.3 mm.
            let height = 2.2e-3 - 2e-3 * (tick.min(40) as f64 / 40.0);
            Pose {
                position: Vector3::new(mark.x + 1e-3, 0.0, height),
                ..Pose::identity()
            }
        };
        let motion = |tick: usize| {
            vec![ToolMotion {
                tool,
                from: at(tick),
                to: at(tick + 1),
                opening_from: 0.0,
                opening_to: 0.0,
                active: true,
            }]
        };
        let (scene, times) = self.ticks(REST + TIMED, motion)?;
        let sunk = scene
            .body(0)
            .positions()
            .iter()
            .map(|p| p.z)
            .fold(0.0, f64::min);
        if sunk > -0.35e-3 {
            return Err(format!(
                "the forceps do not press on the tissue, which is at {sunk} m"
            ));
        }
        Ok(microsim_tests::statistics::percentile(&times[REST..], 0.5))
    }
}

impl Stretched {
    /// The plane that metrics give the cut of a blade, at rest.
    pub fn path(&self, plane: &Plane) -> Result<Plane, String> {
        blade::path(&self.mesh, &self.positions, plane)
    }
}

/// CPU time of this thread \[ms\].
fn now() -> f64 {
    1e3 * thread_time()
}
