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
    /// Methods with their steps and iterations.
    pub methods: Vec<ChartMethod>,
    /// Overrides and step of exact solutions.
    pub exact: (Vec<String>, Option<PlannedStep>),
    /// Whether tools touch bodies.
    pub contact: bool,
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
    /// Leaves mesh and elements as the file has them; the measure of things stays the fine mesh with its elements.
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

/// What the plan lets `tune` try on a scene. `kind`: what its exact solution is, unless it is `of_plan`; `contact`: whether tools
/// touch its bodies.
pub fn candidates(
    chart: &Chart,
    scene: &settings::Scene,
    kind: ExactKind,
    of_plan: Option<&ChartScene>,
    contact: bool,
) -> Candidates {
    let tune = &chart.tune;
    let kind = of_plan.map_or(kind, |scene| scene.exact);
    let (set, step) = exact_way(chart, kind, of_plan);
    let names = if contact {
        &tune.contact_methods
    } else {
        &tune.methods
    };
    let methods = names
        .iter()
        .filter_map(|name| chart.method.iter().find(|m| m.name == *name));
    let mut meshes: Vec<Mesh> = Vec::new();
    for scale in &tune.scales {
        let mesh = scaled(scene, *scale);
        if !meshes.iter().any(|other| other.set == mesh.set) {
            meshes.push(mesh);
        }
    }
    let elements = elements(scene, &tune.discretisations);
    Candidates {
        meshes,
        reference: (scaled(scene, tune.reference_scale), elements[0].clone()),
        elements,
        methods: methods.cloned().collect(),
        exact: (set.to_vec(), step),
        contact,
    }
}

/// The scene with about `scale` times as many cells along each edge.
fn scaled(scene: &settings::Scene, scale: f64) -> Mesh {
    let times = |cells: u32, least: u32| ((f64::from(cells) * scale).round() as u32).max(least);
    let (mut set, mut words) = (Vec::new(), Vec::new());
    for (index, body) in scene.body.iter().enumerate() {
        match body.generator {
            Generator::Block => {
                let Some(cells) = body.cells else { continue };
                let [x, y, z] = cells.map(|c| times(c, 1));
                set.push(format!("body.{index}.cells=[{x},{y},{z}]"));
                words.push(format!("{x} × {y} × {z} cells"));
            }
            Generator::Tube => {
                let (Some(around), Some(along)) = (body.around, body.along) else {
                    continue;
                };
                let (around, along) = (times(around, 3), times(along, 1));
                set.push(format!("body.{index}.around={around}"));
                set.push(format!("body.{index}.along={along}"));
                let mut through = 0;
                for (k, layer) in body.layer.iter().enumerate() {
                    let cells = times(layer.cells, 1);
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
    let mut continua = Vec::new();
    for (b, body) in scene.body.iter().enumerate() {
        for (m, material) in body.material.iter().enumerate() {
            if material.law != Law::Springs {
                continua.push((b, m));
            }
        }
    }
    if continua.is_empty() {
        return vec![Elements {
            title: "springs as they are".into(),
            set: Vec::new(),
        }];
    }
    let one = |discretisation: &Discretisation| {
        let name = Discretisation::NAMES[*discretisation as usize];
        let set = |(b, m): &(usize, usize)| format!("body.{b}.material.{m}.discretisation={name}");
        Elements {
            title: format!("{name} elements"),
            set: continua.iter().map(set).collect(),
        }
    };
    discretisations.iter().map(one).collect()
}
