//! The bodies of the atlas: a small block of each material, changed in one respect at a time.

use crate::eigen::eigenvalues;
use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_random::Congruential;
use microsim_tissue::law::LawName;
use microsim_tissue::stability::WORKING_STRETCH;
use microsim_tissue::{
    Behaviour, BuildError, ContinuumConstants, Discretisation, Material, SpringConstants, State,
    TissueModel, build_model,
};
use nalgebra::{Matrix3, Vector3};

/// Edge of a cell of the block \[m\].
pub(super) const CELL: f64 = 0.01;
/// Cells of the block.
const CELLS: [usize; 3] = [4, 2, 2];
/// The node in the middle of the block; it is inside.
const MIDDLE: [usize; 3] = [2, 1, 1];
/// Young's modulus \[Pa\], Poisson's ratio, density \[kg/m³\] of all bodies, unless stated otherwise.
const YOUNG: f64 = 1e5;
const POISSON: f64 = 0.3;
const DENSITY: f64 = 1000.0;

/// What a body is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Substance {
    /// Springs alone.
    Springs,
    /// Springs and volumes, fitted to Young's modulus and Poisson's ratio.
    SpringsVolumes,
    /// A continuum.
    Continuum(LawName, Discretisation),
}

impl Substance {
    /// Springs, springs with volumes, every law on tetrahedra, every discretisation with the stable neo-Hookean law.
    pub fn all() -> Vec<Self> {
        let laws = LawName::ALL.map(|law| Self::Continuum(law, Discretisation::Tetrahedra));
        let others = Discretisation::ALL
            .into_iter()
            .filter(|one| *one != Discretisation::Tetrahedra)
            .map(|one| Self::Continuum(LawName::StableNeoHookean, one));
        [Self::Springs, Self::SpringsVolumes]
            .into_iter()
            .chain(laws)
            .chain(others)
            .collect()
    }

    /// One of each kind.
    pub fn few() -> Vec<Self> {
        vec![
            Self::SpringsVolumes,
            Self::Continuum(LawName::StableNeoHookean, Discretisation::Tetrahedra),
            Self::Continuum(LawName::StableNeoHookean, Discretisation::Selective),
        ]
    }

    /// Its name in tables.
    pub fn name(&self) -> String {
        match self {
            Self::Springs => "springs".into(),
            Self::SpringsVolumes => "springs + volumes".into(),
            Self::Continuum(law, Discretisation::Tetrahedra) => law.name().into(),
            Self::Continuum(law, discretisation) => {
                format!("{}, {}", law.name(), discretisation.name())
            }
        }
    }

    /// The material with these constants.
    pub fn material(&self, constants: &Constants) -> Material {
        let Constants {
            young,
            poisson,
            density,
            relaxation_time,
        } = *constants;
        let behaviour = match self {
            Self::Springs => Behaviour::Springs(SpringConstants::scaled(young, 0.0)),
            Self::SpringsVolumes => Behaviour::Springs(SpringConstants::fitted(young, poisson)),
            Self::Continuum(law, discretisation) => Behaviour::Continuum(ContinuumConstants {
                law: (*law).into(),
                young,
                poisson,
                discretisation: *discretisation,
                plasticity: None,
            }),
        };
        Material {
            density,
            relaxation_time,
            behaviour,
        }
    }
}

/// Constants of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants {
    /// Young's modulus \[Pa\]; of springs their modulus.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Density \[kg/m³\].
    pub density: f64,
    /// Time of Kelvin–Voigt damping \[s\].
    pub relaxation_time: f64,
}

impl Default for Constants {
    fn default() -> Self {
        Self {
            young: YOUNG,
            poisson: POISSON,
            density: DENSITY,
            relaxation_time: 0.0,
        }
    }
}

/// In which respect a body differs from the plain block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Variation {
    /// In none.
    Plain,
    /// Young's modulus times this.
    Stiffness(f64),
    /// Density times this.
    Density(f64),
    /// This Poisson's ratio.
    Poisson(f64),
    /// Drag with this damping ratio ζ = c/(2ω_max) of the fastest mode.
    Drag(f64),
    /// Kelvin–Voigt viscosity with this damping ratio ζ = τ ω_max/2 of the fastest mode.
    Viscosity(f64),
    /// One layer of cells squeezed to this fraction of its thickness.
    Layer(f64),
    /// One node moved towards the opposite face of an element, until this fraction of the height is left.
    Node(f64),
    /// All of its surface held, drawn out by this factor along x and so much thinner that its volume is that at rest: with the stress and
    /// the stiffness that it then has.
    Stretch(f64),
    /// Started from random offsets of all free nodes, each component up to this fraction of a cell.
    Amplitude(f64),
}

impl Variation {
    /// All that the atlas goes through.
    pub const ALL: [Self; 24] = [
        Self::Plain,
        Self::Stiffness(0.01),
        Self::Stiffness(100.0),
        Self::Density(0.1),
        Self::Density(10.0),
        Self::Poisson(0.45),
        Self::Poisson(0.49),
        Self::Drag(0.1),
        Self::Drag(0.5),
        Self::Drag(2.0),
        Self::Viscosity(0.1),
        Self::Viscosity(0.5),
        Self::Viscosity(2.0),
        Self::Layer(0.3),
        Self::Layer(0.1),
        Self::Layer(0.03),
        Self::Node(0.3),
        Self::Node(0.1),
        Self::Node(0.03),
        Self::Stretch(1.0),
        Self::Stretch(WORKING_STRETCH),
        Self::Amplitude(0.05),
        Self::Amplitude(0.1),
        Self::Amplitude(0.2),
    ];

    /// One or two of each kind.
    pub const FEW: [Self; 12] = [
        Self::Plain,
        Self::Stiffness(100.0),
        Self::Density(0.1),
        Self::Poisson(0.49),
        Self::Drag(0.5),
        Self::Viscosity(0.5),
        Self::Layer(0.1),
        Self::Node(0.1),
        Self::Stretch(1.0),
        Self::Stretch(WORKING_STRETCH),
        Self::Amplitude(0.1),
        Self::Amplitude(0.2),
    ];

    /// What is varied, and its value.
    pub fn names(&self) -> (&'static str, String) {
        let percent = |fraction: &f64| format!("{} %", (100.0 * fraction).round());
        match self {
            Self::Plain => ("plain", "–".into()),
            Self::Stiffness(factor) => ("stiffness", format!("×{factor}")),
            Self::Density(factor) => ("density", format!("×{factor}")),
            Self::Poisson(ratio) => ("Poisson’s ratio", ratio.to_string()),
            Self::Drag(ratio) => ("drag ζ", ratio.to_string()),
            Self::Viscosity(ratio) => ("viscous ζ", ratio.to_string()),
            Self::Layer(fraction) => ("thin layer", percent(fraction)),
            Self::Node(fraction) => ("sliver", percent(fraction)),
            Self::Stretch(factor) => ("stretch", format!("×{factor}")),
            Self::Amplitude(fraction) => ("offsets", percent(fraction)),
        }
    }

    /// Whether it changes anything in a body of this substance.
    pub fn concerns(&self, substance: Substance) -> bool {
        // Springs have no prestretch.
        !matches!(
            (self, substance),
            (Self::Poisson(_), Substance::Springs)
                | (
                    Self::Stretch(_),
                    Substance::Springs | Substance::SpringsVolumes
                )
        )
    }

    /// The constants of the material without damping.
    fn constants(&self) -> Constants {
        let mut constants = Constants::default();
        match self {
            Self::Stiffness(factor) => constants.young *= factor,
            Self::Density(factor) => constants.density *= factor,
            Self::Poisson(ratio) => constants.poisson = *ratio,
            _ => {}
        }
        constants
    }
}

/// A body of the atlas.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The body.
    pub model: TissueModel,
    /// Eigenvalues of M⁻¹K at rest without damping \[1/s²\], ascending.
    pub eigenvalues: Vec<f64>,
    /// Drag per mass \[1/s\].
    pub drag: f64,
    /// Time of Kelvin–Voigt damping \[s\].
    pub relaxation_time: f64,
}

impl Subject {
    /// The block of `substance` with `variation`; it is clamped at its first end.
    pub fn new(substance: Substance, variation: Variation) -> Result<Self, BuildError> {
        let mesh = block(variation);
        let mut constants = variation.constants();
        let plain = body(&mesh, &substance.material(&constants), 0.0)?;
        let eigenvalues = eigenvalues(&plain, &State::at_rest(&plain));
        let omega = eigenvalues.iter().copied().fold(0.0, f64::max).sqrt();
        let (mut drag, mut model) = (0.0, plain);
        match variation {
            Variation::Drag(ratio) => drag = 2.0 * ratio * omega,
            Variation::Viscosity(ratio) => constants.relaxation_time = 2.0 * ratio / omega,
            _ => {}
        }
        if drag > 0.0 || constants.relaxation_time > 0.0 {
            model = body(&mesh, &substance.material(&constants), drag)?;
        }
        Ok(Self {
            model,
            eigenvalues,
            drag,
            relaxation_time: constants.relaxation_time,
        })
    }

    /// The largest eigenvalue \[1/s²\].
    pub fn lambda(&self) -> f64 {
        self.eigenvalues.iter().copied().fold(0.0, f64::max)
    }
}

/// The block with the mesh of `variation`.
pub fn block(variation: Variation) -> TetMesh {
    let block = Block {
        center: CELLS.map(|n| 0.5 * CELL * n as f64),
        size: CELLS.map(|n| CELL * n as f64),
        cells: CELLS,
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().expect("a block of positive size");
    // For laws that have a direction: along the block, the stiffest modes are those of its length.
    mesh.directions = vec![[Vector3::x(), Vector3::y()]; mesh.tets.len()];
    match variation {
        Variation::Layer(fraction) => {
            // The plane behind the middle one comes nearer to it.
            let planes = MIDDLE[0] as f64 * CELL;
            for position in &mut mesh.positions {
                if (position.x - planes - CELL).abs() < 0.5 * CELL {
                    position.x = planes + fraction * CELL;
                }
            }
        }
        Variation::Node(fraction) => {
            let [i, j, k] = MIDDLE;
            let node = (k * (CELLS[1] + 1) + j) * (CELLS[0] + 1) + i;
            let tet = mesh.tets.iter().find(|tet| tet.contains(&(node as u32)));
            let others: Vec<Vector3<f64>> = tet
                .into_iter()
                .flatten()
                .filter(|&&other| other as usize != node)
                .map(|&other| mesh.positions[other as usize])
                .collect();
            let normal = (others[1] - others[0])
                .cross(&(others[2] - others[0]))
                .normalize();
            let height = normal.dot(&(mesh.positions[node] - others[0]));
            mesh.positions[node] -= normal * ((1.0 - fraction) * height);
        }
        Variation::Stretch(factor) => {
            let across = 1.0 / factor.sqrt();
            let stretch = Matrix3::from_diagonal(&Vector3::new(factor, across, across));
            mesh.positions.iter_mut().for_each(|p| *p = stretch * *p);
            mesh.prestretches = vec![stretch; mesh.tets.len()];
        }
        _ => {}
    }
    mesh
}

/// The body of a block mesh, refined for quadratic tetrahedra, clamped where x is 0, and a prestretched one on all of its surface: inside,
/// stress that is the same everywhere is in equilibrium.
pub fn body(mesh: &TetMesh, material: &Material, drag: f64) -> Result<TissueModel, BuildError> {
    let refined = material.is_quadratic().then(|| mesh.refined().mesh);
    let mesh = refined.as_ref().unwrap_or(mesh);
    let clamped: Vec<bool> = match mesh.prestretches.is_empty() {
        true => mesh.positions.iter().map(|p| p.x < 1e-3 * CELL).collect(),
        false => {
            let surface = mesh.surface().nodes;
            let nodes = 0..mesh.positions.len() as u32;
            nodes
                .map(|node| surface.binary_search(&node).is_ok())
                .collect()
        }
    };
    build_model(mesh, &[(0, *material)], &clamped, drag, Vec::new())
}

/// At rest but for random offsets of the free nodes, each component up to `size` \[m\].
pub fn disturbed(model: &TissueModel, size: f64) -> State {
    let mut state = State::at_rest(model);
    let mut random = Congruential(1);
    for (position, w) in state.positions.iter_mut().zip(model.inverse_masses()) {
        if *w > 0.0 {
            *position += random.vector() * size;
        }
    }
    state
}
