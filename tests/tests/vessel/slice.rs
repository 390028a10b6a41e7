//! A slice of a long tube in elements: a ring, a quarter of it, or a half that is slit. It stands for all of the tube, as its flat sides slide on planes.

use crate::law::{directions, law_of};
use crate::slides::{Slide, Slides};
use microsim_mesh::{Arc, CellSplit, TetMesh, Tube, TubeSide};
use microsim_tests::vessel::layers::Layer;
use microsim_tests::vessel::radial::Profile;
use microsim_tissue::elements::{Configuration, NodeWindow};
use microsim_tissue::law::LawName;
use microsim_tissue::{
    Behaviour, ContinuumConstants, Control, Discretisation, Elements, Material, Method, Newton,
    Pressure, Serial, Solver, State, TissueModel, build_model,
};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Over the stiffness of the inner matrix times the length of the slice: under the stresses here, some hundred times that stiffness, nodes are
/// off their planes by 1e-4 of the length at most.
const PLANE_STIFFNESS: f64 = 1e5;

/// How a slice is divided.
#[derive(Clone, Copy, Debug)]
pub struct Cells {
    /// Through media and adventitia.
    pub through: [usize; 2],
    /// Around the whole ring.
    pub around: usize,
    /// Along the axis.
    pub along: usize,
    /// Length of each along the axis, over the mean of those through the wall.
    pub slender: f64,
    /// How they are cut into elements.
    pub split: CellSplit,
}

impl Cells {
    /// So many through each layer and twenty times as many around, as long as they are thick.
    pub fn equal(through: usize, split: CellSplit) -> Self {
        Self {
            through: [through; 2],
            around: 20 * through,
            along: 2,
            slender: 1.0,
            split,
        }
    }
}

/// The mesh of a level, of linear elements that can be cut: 3,000 for a vessel of 10 mm without load, two cells through the media, where stretches
/// differ most, and long ones along the axis.
pub const LEVEL: Cells = Cells {
    through: [2, 1],
    around: 20,
    along: 10,
    // 1 mm over a third of the wall of 0.39 mm.
    slender: 1.0 / (0.39 / 3.0),
    split: CellSplit::Five,
};

/// Which part of the ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// All of it.
    Ring,
    /// A quarter, on planes at both of its sides.
    Quarter,
    /// A half, on a plane at one side, free at the other.
    Slit,
}

/// A slice in its present state.
pub struct Slice {
    model: TissueModel,
    state: State,
    control: Control,
    solver: Box<dyn Solver>,
    planes: std::sync::Arc<Slides>,
    inner: Vec<u32>,
    outer: Vec<u32>,
    part: Part,
    length: f64,
}

/// Nodes of the frame that planes go through, behind those of the wall: in the plane of the start, of the end, in both planes along the axis, and
/// beside it at the inner radius.
const FRAME: u32 = 4;

impl Slice {
    /// Of layers in the place where the profile of a tube has them: it is in equilibrium there as that tube is.
    ///
    /// # Panics
    /// If there are none.
    pub fn new(
        layers: &[Layer],
        place: &Profile,
        part: Part,
        cells: Cells,
        discretisation: Discretisation,
    ) -> Self {
        let (inner_radius, outer_radius) = (place.inside.radius, place.outer_radius());
        let through: usize = cells.through.iter().sum();
        let length =
            cells.slender * (outer_radius - inner_radius) * cells.along as f64 / through as f64;
        let regions = 0..layers.len();
        let tube = Tube {
            center: [0.0; 3],
            axis: [1.0, 0.0, 0.0],
            inner_radius,
            layers: regions
                .map(|layer| {
                    let [inner, outer] = place.radii(layer);
                    microsim_mesh::Layer {
                        thickness: outer - inner,
                        cells: cells.through[layer],
                        region: layer as u32,
                    }
                })
                .collect(),
            length,
            around: match part {
                Part::Ring => cells.around,
                Part::Quarter => cells.around / 4,
                Part::Slit => cells.around / 2,
            },
            along: cells.along,
            arc: match part {
                Part::Ring => Arc::Full,
                Part::Quarter => sector(FRAC_PI_2),
                Part::Slit => sector(PI),
            },
            split: cells.split,
        };
        let mut mesh = tube.mesh().expect("a tube");
        let mut lumen = tube.side(&mesh, TubeSide::Inner).triangles;
        if discretisation.is_quadratic() {
            let mut refined = mesh.refined();
            refined.place_middles(|a, b| tube.between(a, b));
            lumen = refined.faces(&lumen);
            mesh = refined.mesh;
        }
        set_fibres_and_prestretches(&mut mesh, layers, place);

        let at = |wanted: f64| -> Vec<u32> {
            let nodes = (0..).zip(&mesh.positions);
            let near = nodes.filter(|(_, p)| (p.yz().norm() / wanted - 1.0).abs() < 1e-9);
            near.map(|(node, _)| node).collect()
        };
        let (inner, outer) = (at(inner_radius), at(outer_radius));
        let stiffness = PLANE_STIFFNESS * layers[0].wall.mu * length;
        let planes = std::sync::Arc::new(slides(&mesh, part, length, stiffness));

        let first = mesh.positions.len() as u32;
        let frame = frame(length, inner_radius);
        mesh.append(&frame, layers.len() as u32);
        let clamped: Vec<bool> = (0..mesh.positions.len() as u32)
            .map(|n| n >= first)
            .collect();
        let model = build_model(
            &mesh,
            &materials(layers, discretisation),
            &clamped,
            0.0,
            vec![planes.clone()],
        )
        .expect("a model");
        let method = Method::QuasiStatic(Newton {
            iterations: 60,
            tolerance: 1e-9,
            must_converge: true,
        });
        let pressure = Pressure {
            triangles: lumen.into(),
            pressure: 0.0,
        };
        Self {
            state: State::at_rest(&model),
            control: Control {
                gravity: Vector3::zeros(),
                clamped_positions: frame.positions,
                pressures: vec![pressure],
                ..Control::default()
            },
            solver: method.solver(&model).expect("a solver"),
            model,
            planes,
            inner,
            outer,
            part,
            length,
        }
    }

    /// Equilibrium at a pressure \[Pa\] and an axial stretch from the place at the start.
    ///
    /// # Panics
    /// If there is none near.
    pub fn load(&mut self, pressure: f64, along: f64) {
        for (place, sign) in [(0, -0.5), (1, 0.5)] {
            self.control.clamped_positions[place].x = sign * along * self.length;
        }
        self.control.pressures[0].pressure = pressure;
        self.solver
            .step(
                &self.model,
                &mut self.state,
                &self.control,
                &[],
                1.0,
                &Serial,
            )
            .unwrap_or_else(|error| panic!("{pressure} Pa, {along}: {error}"));
    }

    /// Mean distance of the inner and of the outer nodes from the axis \[m\].
    pub fn radii(&self) -> [f64; 2] {
        [&self.inner, &self.outer].map(|nodes| {
            let radii = nodes
                .iter()
                .map(|n| self.state.positions[*n as usize].yz().norm());
            radii.sum::<f64>() / nodes.len() as f64
        })
    }

    /// Largest distance of the inner nodes from the axis less the smallest one, over their mean.
    pub fn spread(&self) -> f64 {
        let places = self.inner.iter().map(|n| self.state.positions[*n as usize]);
        let radii = places.map(|place| place.yz().norm());
        let largest = radii.clone().fold(0.0, f64::max);
        (largest - radii.fold(f64::INFINITY, f64::min)) / self.radii()[0]
    }

    /// Axial force in the wall of the whole ring \[N\].
    pub fn force(&self) -> f64 {
        let mut forces = vec![Vector3::zeros(); self.model.node_count()];
        let at = Configuration {
            positions: &self.state.positions,
            velocities: &self.state.velocities,
            internal: &[],
        };
        let mut window = NodeWindow {
            first: 0,
            values: &mut forces,
        };
        self.planes
            .add_forces(0..self.planes.count(), &at, &mut window);
        let end = self.model.node_count() - FRAME as usize + 1;
        let parts = match self.part {
            Part::Ring => 1.0,
            Part::Quarter => 4.0,
            Part::Slit => 2.0,
        };
        -parts * forces[end].x
    }

    /// Angle that a slit ring covers \[rad\], by the directions of the wall at its ends.
    pub fn angle(&self) -> f64 {
        let rest = self.model.rest_positions();
        let cut = |node: &&u32| {
            let p = &rest[**node as usize];
            p.z.abs() < 1e-9 * self.length && p.y < 0.0
        };
        let mean = |nodes: &[u32]| {
            let of = nodes
                .iter()
                .filter(cut)
                .map(|n| self.state.positions[*n as usize]);
            of.clone().sum::<Vector3<f64>>() / of.count() as f64
        };
        let outward = mean(&self.outer) - mean(&self.inner);
        let angle = libm::atan2(outward.z, outward.y);
        2.0 * if angle < 0.0 { angle + 2.0 * PI } else { angle }
    }
}

/// So much of a ring, from the first direction \[rad\].
fn sector(angle: f64) -> Arc {
    Arc::Sector { start: 0.0, angle }
}

/// The two families of each element, and its prestretch, along r, θ, z at its middle.
fn set_fibres_and_prestretches(mesh: &mut TetMesh, layers: &[Layer], place: &Profile) {
    for element in 0..mesh.tets.len() {
        let corners = mesh.corners(element);
        let centre = corners.iter().sum::<Vector3<f64>>() / 4.0;
        let radial = Vector3::new(0.0, centre.y, centre.z).normalize();
        let axes = Matrix3::from_columns(&[radial, Vector3::x().cross(&radial), Vector3::x()]);
        let layer = mesh.regions[element] as usize;
        // Corners lie on the circles of the wall, their middle within the polygon.
        let radius = corners.iter().map(|p| p.yz().norm()).sum::<f64>() / 4.0;
        let stretches = place.stretches_at(layer, radius);
        mesh.directions
            .push(directions(&layers[layer].wall).map(|a| axes * a));
        let prestretch = axes * Matrix3::from_diagonal(&stretches.into()) * axes.transpose();
        mesh.prestretches.push(prestretch);
    }
}

/// The planes of start and end, and those along the axis.
fn slides(mesh: &TetMesh, part: Part, length: f64, stiffness: f64) -> Slides {
    // Three nodes inside at the start of a ring, that it neither turns nor drifts: as it is in equilibrium they bear nothing.
    let inside = mesh.positions[0].yz().norm();
    let holds = |p: &Vector3<f64>, (_, normal, _): &(f64, Vector3<f64>, u32)| {
        p.yz().norm() < (1.0 + 1e-9) * inside
            && (p.x + 0.5 * length).abs() < 1e-9 * length
            && (normal.z > 0.5 || p.z > 0.0)
    };
    let first = mesh.positions.len() as u32;
    let mut slides = Vec::new();
    for (node, p) in (0..).zip(&mesh.positions) {
        let planes = [
            (p.x + 0.5 * length, Vector3::x(), 0),
            (p.x - 0.5 * length, Vector3::x(), 1),
            (p.y, Vector3::y(), 2),
            (p.z, Vector3::z(), 2),
        ];
        let on = |plane: &&(f64, Vector3<f64>, u32)| match part {
            Part::Quarter => plane.0.abs() < 1e-9 * length,
            Part::Ring => plane.0.abs() < 1e-9 * length && (plane.2 < 2 || holds(p, plane)),
            // Neither across the axis at the top of the half, nor at its free end.
            Part::Slit => plane.0.abs() < 1e-9 * length && (plane.2 < 2 || p.y > 0.1 * length),
        };
        slides.extend(planes.iter().filter(on).map(|(_, normal, frame)| Slide {
            nodes: [node, first + frame],
            normal: *normal,
            stiffness,
        }));
    }
    if part == Part::Slit {
        // The first node lies inside at the plane; without it the half would slide along that.
        slides.push(Slide {
            nodes: [0, first + 3],
            normal: Vector3::y(),
            stiffness,
        });
    }
    Slides::new(slides)
}

/// One tetrahedron of what holds the planes.
fn frame(length: f64, inner_radius: f64) -> TetMesh {
    let size = 20.0 * inner_radius;
    let corners = vec![
        Vector3::new(-0.5 * length, size, size),
        Vector3::new(0.5 * length, size, 2.0 * size),
        Vector3::zeros(),
        Vector3::new(-size, inner_radius, 0.0),
    ];
    TetMesh::new(corners, vec![[0, 1, 3, 2]], vec![0])
}

/// Those of the layers, and of the frame behind them.
fn materials(layers: &[Layer], discretisation: Discretisation) -> Vec<(u32, Material)> {
    let material = |constants| Material {
        density: 1060.0,
        relaxation_time: 0.0,
        behaviour: Behaviour::Continuum(constants),
    };
    let walls = layers.iter().map(|layer| {
        material(ContinuumConstants {
            law: law_of(&layer.wall),
            young: layer.wall.young(),
            poisson: layer.wall.poisson(),
            discretisation,
            plasticity: None,
        })
    });
    let frame = material(ContinuumConstants {
        law: LawName::StVenantKirchhoff.into(),
        young: layers[0].wall.young(),
        poisson: 0.0,
        discretisation: Discretisation::Tetrahedra,
        plasticity: None,
    });
    (0..).zip(walls.chain([frame])).collect()
}
