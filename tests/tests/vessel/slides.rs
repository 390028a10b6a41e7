//! Planes on which nodes slide: where a part of a long tube is cut off by thought, the rest of it holds that part so.

use microsim_tissue::Elements;
use microsim_tissue::elements::splice::{make_room, splice};
use microsim_tissue::elements::{Configuration, ElementMatrix, EnergyKind, NodeWindow, Tangent};
use nalgebra::Vector3;
use std::any::Any;
use std::ops::Range;
use std::sync::Arc;

/// A node and the plane on which it slides, through another node, which the solver moves or holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slide {
    /// The node, and the one through which its plane goes.
    pub nodes: [u32; 2],
    /// Unit normal of the plane.
    pub normal: Vector3<f64>,
    /// k of the spring that holds the node on its plane \[N/m\].
    pub stiffness: f64,
}

impl Slide {
    /// How far the node is from its plane \[m\].
    fn excess(&self, positions: &[Vector3<f64>]) -> f64 {
        let [node, on_plane] = self.nodes.map(|node| positions[node as usize]);
        self.normal.dot(&(node - on_plane))
    }
}

/// Nodes that springs hold on planes, with the energy ½ k (n·(x − a))²: a penalty, so that the error is the force over k.
#[derive(Clone, Debug)]
pub struct Slides(Vec<Slide>);

impl Slides {
    /// These nodes on their planes.
    pub fn new(slides: Vec<Slide>) -> Self {
        Self(slides)
    }
}

impl Elements for Slides {
    fn kind(&self) -> EnergyKind {
        EnergyKind::Coupling
    }

    fn count(&self) -> usize {
        self.0.len()
    }

    fn nodes(&self, element: usize) -> &[u32] {
        &self.0[element].nodes
    }

    fn energy(&self, at: &Configuration<'_>) -> f64 {
        let squares = self.0.iter().map(|slide| {
            let excess = slide.excess(at.positions);
            0.5 * slide.stiffness * excess * excess
        });
        squares.sum()
    }

    fn add_forces(&self, range: Range<usize>, at: &Configuration<'_>, forces: &mut NodeWindow<'_>) {
        for slide in &self.0[range] {
            let push = slide.normal * (slide.stiffness * slide.excess(at.positions));
            forces.add(slide.nodes[0], -push);
            forces.add(slide.nodes[1], push);
        }
    }

    fn stiffness(
        &self,
        element: usize,
        _at: &Configuration<'_>,
        _tangent: Tangent,
        out: &mut ElementMatrix,
    ) {
        let slide = &self.0[element];
        out.reset(2);
        out.add_outer(&[slide.normal, -slide.normal], slide.stiffness);
    }

    fn is_viscous(&self) -> bool {
        false
    }

    fn damping(&self, _element: usize, _at: &Configuration<'_>, out: &mut ElementMatrix) {
        out.reset(2);
    }

    fn relaxation_time(&self, _element: usize) -> f64 {
        0.0
    }

    fn scale(&mut self, element: usize, factor: f64) {
        self.0[element].stiffness *= factor;
    }

    fn shifted(&self, nodes: u32) -> Arc<dyn Elements> {
        let moved = |slide: &Slide| Slide {
            nodes: slide.nodes.map(|node| node + nodes),
            ..*slide
        };
        Arc::new(Self(self.0.iter().map(moved).collect()))
    }

    fn splice(&mut self, removed: &[u32], added: &dyn Elements) -> bool {
        let Some(added) = (added as &dyn Any).downcast_ref::<Self>() else {
            return false;
        };
        splice(&mut self.0, removed, &added.0);
        true
    }

    fn make_room(&mut self) {
        make_room(&mut self.0);
    }
}
