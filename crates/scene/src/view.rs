//! What can be read of one body of a scene.

use crate::body::{Body, CutTally};
use crate::initial_equilibrium::InitialEquilibrium;
use crate::scene::Scene;
use crate::select;
use crate::spec::Selection;
use microsim_geometry::signed_volume;
use microsim_mesh::{Surface, TetMesh};
use microsim_tissue::{Energies, Forces, Serial, State, TissueModel};
use nalgebra::Vector3;

/// Read access to one body of a scene.
///
/// Indices of nodes, elements and triangles hold until the next tick that cuts it; the ids of nodes and elements are stable.
#[derive(Clone, Copy, Debug)]
pub struct BodyView<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) index: usize,
}

impl Scene {
    /// The body with an index below [`body_count`](Self::body_count).
    ///
    /// ```
    /// # use microsim_mesh::{Block, CellSplit};
    /// # use microsim_scene::{Behaviour, BodySpec, Material, Method, Scene, SceneSpec, Serial};
    /// # use microsim_tissue::SpringConstants;
    /// # let block = Block { center: [0.0; 3], size: [2e-3; 3], cells: [2; 3], split: CellSplit::Kuhn };
    /// # let behaviour = Behaviour::Springs(SpringConstants::scaled(25e3, 5e4));
    /// # let material = Material { density: 1060.0, relaxation_time: 0.0, behaviour };
    /// # let cube = BodySpec::new("cube", block.mesh()?, material);
    /// let scene = Scene::new(&SceneSpec::new(vec![cube], Method::StoermerVerlet))?;
    /// let body = scene.body(0);
    /// assert_eq!((body.positions().len(), body.element_count()), (27, 48));
    /// assert!((body.volume() - 8e-9).abs() < 1e-18);
    /// assert_eq!(body.piece_count(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// When there is no such body.
    pub fn body(&self, index: usize) -> BodyView<'_> {
        assert!(index < self.bodies.len(), "no body {index}");
        BodyView { scene: self, index }
    }

    /// All bodies, in the order of the description.
    pub fn bodies(&self) -> impl ExactSizeIterator<Item = BodyView<'_>> {
        (0..self.bodies.len()).map(|index| BodyView { scene: self, index })
    }
}

impl<'a> BodyView<'a> {
    pub(crate) fn parts(&self) -> &'a Body {
        &self.scene.bodies[self.index]
    }

    /// Its index in the scene.
    pub fn index(&self) -> usize {
        self.index
    }

    /// Its name.
    pub fn name(&self) -> &'a str {
        &self.parts().name
    }

    /// Origin of its frame in the world \[m\]; its axes are the world's.
    pub fn origin(&self) -> Vector3<f64> {
        self.parts().origin
    }

    /// Its mesh at rest.
    pub fn mesh(&self) -> &'a TetMesh {
        &self.parts().mesh
    }

    /// Topology generation of its mesh: the number of edits so far.
    pub fn generation(&self) -> u64 {
        self.mesh().generation
    }

    /// Stable ids of its nodes.
    pub fn node_ids(&self) -> &'a [u32] {
        &self.mesh().node_ids
    }

    /// Stable ids of its elements.
    pub fn element_ids(&self) -> &'a [u32] {
        &self.mesh().element_ids
    }

    /// Its elements as node indices.
    pub fn tets(&self) -> &'a [[u32; 4]] {
        &self.mesh().tets
    }

    /// Number of its elements.
    pub fn element_count(&self) -> usize {
        self.tets().len()
    }

    /// Its surface: outward triangles as node indices.
    pub fn surface(&self) -> &'a Surface {
        &self.parts().surface
    }

    /// Whether a cut has opened each triangle of its surface.
    pub fn opened(&self) -> &'a [bool] {
        &self.parts().opened
    }

    /// The region of the element behind each triangle of its surface.
    pub fn triangle_regions(&self) -> impl Iterator<Item = u32> + 'a {
        self.parts().triangle_regions()
    }

    /// The piece that each node is of: 0 of what was there before any came off, else the number under which it came off.
    pub fn pieces(&self) -> &'a [u32] {
        &self.parts().pieces.of_nodes
    }

    /// Number of pieces so far: 1 before any came off. One that is cut further counts for more.
    pub fn piece_count(&self) -> u32 {
        self.parts().pieces.count()
    }

    /// What cuts have done to it.
    pub fn cut_tally(&self) -> CutTally {
        self.parts().tally
    }

    /// Rest volume \[m³\] and mass \[kg\] before any cut.
    pub fn uncut(&self) -> (f64, f64) {
        let uncut = self.scene.uncut.as_deref();
        let uncut = uncut.map_or(self.parts(), |(bodies, _)| &bodies[self.index]);
        let model = &uncut.model;
        (
            model.rest_volumes().iter().sum(),
            model.masses().iter().sum(),
        )
    }

    /// Node positions at rest \[m\].
    pub fn rest_positions(&self) -> &'a [Vector3<f64>] {
        self.model().rest_positions()
    }

    /// Node positions at the start \[m\]; of a node that a cut has made those of where it would have been.
    pub fn start_positions(&self) -> &'a [Vector3<f64>] {
        &self.parts().start.positions
    }

    /// How a body with residual stress begins in equilibrium; `None` of one without.
    pub fn initial_equilibrium(&self) -> Option<InitialEquilibrium> {
        self.parts().initial_equilibrium
    }

    /// Node positions in the world \[m\].
    pub fn positions(&self) -> &'a [Vector3<f64>] {
        &self.state().positions
    }

    /// Node velocities \[m/s\]: at the end of the last step, with leapfrog in its middle.
    pub fn velocities(&self) -> &'a [Vector3<f64>] {
        &self.state().velocities
    }

    /// Node masses \[kg\].
    pub fn masses(&self) -> &'a [f64] {
        self.model().masses()
    }

    /// Whether each node is clamped for good.
    pub fn clamped(&self) -> Vec<bool> {
        let model = self.model();
        (0..model.node_count())
            .map(|node| model.is_clamped(node))
            .collect()
    }

    /// Whether each node is prescribed now: by a clamp, or by one that has not been released yet.
    pub fn held(&self) -> Vec<bool> {
        let mut held = self.clamped();
        for target in self.parts().drive.targets(self.scene.time()) {
            held[target.node as usize] = true;
        }
        held
    }

    /// The nodes in `selection`, ascending.
    pub fn select(&self, selection: &Selection) -> Vec<u32> {
        select::nodes(self.mesh(), &self.parts().origin, selection)
    }

    /// Its model.
    pub fn model(&self) -> &'a TissueModel {
        &self.parts().model
    }

    /// Its state.
    pub fn state(&self) -> &'a State {
        &self.scene.state.bodies[self.index]
    }

    /// Mean edge length at rest \[m\]: its characteristic length.
    pub fn mean_edge_length(&self) -> f64 {
        self.model().mean_edge_length()
    }

    /// Longest step \[s\] that it allows, safety factor included; infinite for a method without a limit.
    pub fn stable_step(&self) -> f64 {
        self.scene.state.stable_steps[self.index]
    }

    /// Volume \[m³\].
    pub fn volume(&self) -> f64 {
        let positions = self.positions();
        let volumes = self.tets().iter().map(|tet| {
            let [a, b, c, d] = tet.map(|node| &positions[node as usize]);
            signed_volume(a, b, c, d)
        });
        volumes.sum()
    }

    /// Momentum \[kg m/s\]; nodes that are clamped have none.
    pub fn momentum(&self) -> Vector3<f64> {
        let model = self.model();
        let nodes = self.velocities().iter().enumerate();
        nodes
            .filter(|(node, _)| !model.is_clamped(*node))
            .map(|(node, v)| v * model.inertia(node))
            .sum()
    }

    /// Energy by kind \[J\].
    pub fn energies(&self) -> Energies {
        self.state().energies(self.model())
    }

    /// Elastic and viscous force, weight and loads at each node \[N\]; at a clamped node it is what the clamp bears.
    pub fn forces(&self) -> Vec<Vector3<f64>> {
        let (model, scene) = (self.model(), self.scene);
        let control = self.parts().drive.control(&scene.gravity, scene.state.time);
        let mut forces = Forces::new(model);
        forces
            .compute(model, self.state(), &control, &Serial)
            .to_vec()
    }
}
