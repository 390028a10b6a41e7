//! What is tried: meshes with more or fewer cells, discretisations of continua, methods with their steps.

use crate::execute::exact_way;
use crate::plan::PlannedStep;
use microsim_settings::{
    self as settings, Chart, ChartMethod, ChartScene, Discretisation, ExactKind, Generator, Law,
};

/// A mesh: overrides of the numbers of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// For people.
    pub title: String,
    /// Overrides.
    pub set: Vec<String>,
}

/// Discretisations of all continua of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Elements {
    /// For people.
    pub title: String,
    /// Overrides.
    pub set: Vec<String>,
}

/// Everything that is tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidates {
    /// From coarse to fine.
    pub meshes: Vec<Mesh>,
    /// Discretisations.
    pub elements: Vec<Elements>,
    /// What is the measure where nothing is known from outside.
    pub reference: (Mesh, Elements),
    /// The mesh that shows how far that measure may be off: two thirds of its cells along each edge.
    pub second: Mesh,
    /// Linear tetrahedra, which lock; `None` if there is no continuum.
    pub plain: Option<Elements>,
    /// Methods with their steps and iterations.
    pub methods: Vec<ChartMethod>,
    /// Overrides and step of exact solutions.
    pub exact: (Vec<String>, Option<PlannedStep>),
    /// Whether tools touch bodies.
    pub contact: bool,
    /// Why a method must compute motion, and not only where it ends; `None` if that is enough.
    pub motion: Option<&'static str>,
}

/// What a level demands beyond its scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AsLevel {
    /// A step is a whole part of it \[s\].
    pub tick: f64,
    /// Whether tools touch its bodies.
    pub contact: bool,
    /// Whether its bodies are cut or tear.
    pub cuts: bool,
}

/// One of each.
#[derive(Clone, Copy, Debug)]
pub struct Choices<'a> {
    /// Mesh.
    pub mesh: &'a Mesh,
    /// Elements.
    pub elements: &'a Elements,
    /// Method.
    pub method: &'a ChartMethod,
    /// Step.
    pub step: PlannedStep,
    /// Iterations.
    pub iterations: Option<u32>,
}

impl Candidates {
    /// Leaves mesh and elements as the file has them; the reference stays the fine mesh with its elements.
    pub fn keep_mesh(&mut self) {
        self.meshes = vec![Mesh {
            title: "its mesh".into(),
            set: Vec::new(),
        }];
        self.elements = vec![Elements {
            title: "its elements".into(),
            set: Vec::new(),
        }];
    }
}

impl Choices<'_> {
    /// All overrides but that of the step.
    pub fn overrides(&self) -> Vec<String> {
        let mut set = self.mesh.set.clone();
        set.extend_from_slice(&self.elements.set);
        set.extend_from_slice(&self.method.set);
        set.extend(self.iterations.map(|i| format!("method.iterations={i}")));
        set
    }
}

/// What the plan lets `tune` try on a scene. `kind`: what its exact solution is, unless it is `of_plan`; `level`: which limits it must meet
/// besides if it stands for a level.
pub fn candidates(
    chart: &Chart,
    scene: &settings::Scene,
    kind: ExactKind,
    of_plan: Option<&ChartScene>,
    level: Option<AsLevel>,
) -> Candidates {
    let tune = &chart.tune;
    let kind = of_plan.map_or(kind, |scene| scene.exact);
    let (set, step) = exact_way(chart, kind, of_plan);
    let contact = level.is_some_and(|level| level.contact);
    let planned = |name: &String| chart.method.iter().find(|m| m.name == *name);
    let (scales, reference, methods) = match level {
        None => {
            let scales = tune.scales.iter().map(|scale| [*scale; 3]).collect();
            let methods = tune.methods.iter().filter_map(planned).cloned().collect();
            (scales, tune.reference_scale, methods)
        }
        Some(level) => {
            let mut methods: Vec<ChartMethod> = chart.level_method.clone();
            for method in &mut methods {
                whole_parts(&mut method.steps, level.tick);
            }
            (
                tune.level_scales.clone(),
                tune.level_reference_scale,
                methods,
            )
        }
    };
    let mut meshes: Vec<Mesh> = Vec::new();
    for scale in scales {
        let mesh = scaled(scene, scale);
        if !meshes.iter().any(|other| other.set == mesh.set) {
            meshes.push(mesh);
        }
    }
    let elements = elements(scene, &tune.discretisations);
    Candidates {
        meshes,
        reference: (scaled(scene, [reference; 3]), elements[0].clone()),
        second: scaled(scene, [reference * 2.0 / 3.0; 3]),
        plain: discretised(scene, Discretisation::Tetrahedra),
        elements,
        methods,
        exact: (set.to_vec(), step),
        contact,
        motion: level.and_then(|level| motion(scene, level.cuts)),
    }
}

/// Why a level asks for motion.
fn motion(scene: &settings::Scene, cuts: bool) -> Option<&'static str> {
    let viscous = |material: &settings::Material| {
        material.relaxation_time.unwrap_or(0.0) > 0.0 || material.viscosity.unwrap_or(0.0) > 0.0
    };
    if cuts {
        Some("it has no inertia: a piece that comes off could not fall")
    } else if scene.body.iter().any(|b| b.material.iter().any(viscous)) {
        Some("it leaves out the viscosity that the level states")
    } else {
        None
    }
}

/// Shortens steps to whole parts of a tick.
fn whole_parts(steps: &mut Vec<f64>, tick: f64) {
    for step in steps.iter_mut() {
        *step = tick / (tick / *step * (1.0 - 1e-9)).ceil().max(1.0);
    }
    steps.dedup();
}

/// The scene with about so many times as many cells: along x, y and z of blocks; along, around and through tubes.
fn scaled(scene: &settings::Scene, scale: [f64; 3]) -> Mesh {
    let times = |cells: u32, axis: usize, least: u32| {
        ((f64::from(cells) * scale[axis]).round() as u32).max(least)
    };
    let (mut set, mut words) = (Vec::new(), Vec::new());
    for (index, body) in scene.body.iter().enumerate() {
        match body.generator {
            Generator::Block => {
                let Some(cells) = body.cells else { continue };
                let [x, y, z] = [0, 1, 2].map(|axis| times(cells[axis], axis, 1));
                set.push(format!("body.{index}.cells=[{x},{y},{z}]"));
                words.push(format!("{x} × {y} × {z} cells"));
            }
            Generator::Tube => {
                let (Some(around), Some(along)) = (body.around, body.along) else {
                    continue;
                };
                let (around, along) = (times(around, 1, 3), times(along, 0, 1));
                set.push(format!("body.{index}.around={around}"));
                set.push(format!("body.{index}.along={along}"));
                let mut through = 0;
                for (k, layer) in body.layer.iter().enumerate() {
                    let cells = times(layer.cells, 2, 1);
                    through += cells;
                    set.push(format!("body.{index}.layer.{k}.cells={cells}"));
                }
                words.push(format!("{around} × {along} × {through} cells"));
            }
            Generator::File => words.push("its mesh file".into()),
        }
    }
    Mesh {
        title: words.join(" and "),
        set,
    }
}

/// The discretisations of a scene's continua; as they are if it has none.
fn elements(scene: &settings::Scene, discretisations: &[Discretisation]) -> Vec<Elements> {
    let all = discretisations.iter();
    let found: Vec<Elements> = all.filter_map(|d| discretised(scene, *d)).collect();
    if found.is_empty() {
        return vec![Elements {
            title: "springs as they are".into(),
            set: Vec::new(),
        }];
    }
    found
}

/// A scene's continua in a discretisation; `None` if it has none.
fn discretised(scene: &settings::Scene, discretisation: Discretisation) -> Option<Elements> {
    let mut continua = Vec::new();
    for (b, body) in scene.body.iter().enumerate() {
        for (m, material) in body.material.iter().enumerate() {
            if material.law != Law::Springs {
                continua.push((b, m));
            }
        }
    }
    let name = discretisation.name();
    let set = |(b, m): &(usize, usize)| format!("body.{b}.material.{m}.discretisation={name}");
    (!continua.is_empty()).then(|| Elements {
        title: format!("{name} elements"),
        set: continua.iter().map(set).collect(),
    })
}
