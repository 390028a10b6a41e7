//! Detection against closed forms, against brute force, and in the corners of the input.

mod body_contact;
mod brute;
mod depth;
mod obstacle_contact;
mod surface_update;
mod tool_contact;

use crate::{
    CapsuleMotion, ContactPair, ContactSurface, Detector, Frame, ObstaclePart, Point, Sides,
};
use microsim_geometry::Capsule;
use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_random::SplitMix64;
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// Cells of edge length 1 around `center`.
pub fn block(center: [f64; 3], cells: [usize; 3]) -> TetMesh {
    sized(center, cells.map(|n| n as f64), cells)
}

pub fn sized(center: [f64; 3], size: [f64; 3], cells: [usize; 3]) -> TetMesh {
    let split = CellSplit::Kuhn;
    let block = Block {
        center,
        size,
        cells,
        split,
    };
    block.mesh().expect("a block")
}

/// Bodies with their positions, and what they may touch.
#[derive(Clone)]
pub struct Group {
    pub detector: Detector,
    pub start: Vec<V3>,
    pub now: Vec<V3>,
    pub tools: Vec<Option<Vec<CapsuleMotion>>>,
    pub fraction: f64,
    pub reach: f64,
    pub sides: Sides,
}

impl Group {
    pub fn new(meshes: &[&TetMesh], obstacles: Vec<ObstaclePart>, pairs: Vec<ContactPair>) -> Self {
        let mut start = Vec::new();
        let mut surfaces = Vec::new();
        for mesh in meshes {
            surfaces.push(ContactSurface::new(mesh, start.len() as u32));
            start.extend(&mesh.positions);
        }
        Self {
            detector: Detector::new(surfaces, obstacles, pairs),
            now: start.clone(),
            start,
            tools: Vec::new(),
            fraction: 1.0,
            reach: 0.0,
            sides: Sides::new(),
        }
    }

    /// One body and one tool.
    pub fn with_tool(mesh: &TetMesh, capsules: Vec<CapsuleMotion>) -> Self {
        let mut group = Self::new(
            &[mesh],
            Vec::new(),
            vec![ContactPair::Tool { body: 0, tool: 0 }],
        );
        group.tools = vec![Some(capsules)];
        group
    }

    pub fn find(&mut self) -> Vec<Point> {
        let mut points = Vec::new();
        let frame = Frame {
            start: &self.start,
            now: &self.now,
            tools: &self.tools,
            fraction: self.fraction,
            reach: self.reach,
            sides: &self.sides,
        };
        self.detector.find(&frame, &mut points);
        check(&points);
        points
    }
}

/// What holds of all points.
pub fn check(points: &[Point]) {
    for point in points {
        let first = usize::from(point.first);
        let sum = |weights: &[f64]| weights.iter().sum::<f64>();
        assert!(
            (sum(&point.weights[..first]) - 1.0).abs() < 1e-15,
            "{point:?}"
        );
        let other = sum(&point.weights[first..]);
        assert!(other == 0.0 || (other + 1.0).abs() < 1e-15, "{point:?}");
        assert!((point.normal.norm() - 1.0).abs() < 1e-14, "{point:?}");
        let numbers = [point.gap, point.start_gap].into_iter();
        let numbers = numbers.chain(point.place.iter().copied());
        assert!(
            numbers
                .chain(point.drift.iter().copied())
                .all(f64::is_finite),
            "{point:?}"
        );
    }
    assert!(points.windows(2).all(|pair| pair[0].key < pair[1].key));
}

/// A capsule that moves without turning.
pub fn capsule(a: [f64; 3], b: [f64; 3], radius: f64, shift: [f64; 3]) -> CapsuleMotion {
    let (a, b, shift) = (V3::from(a), V3::from(b), V3::from(shift));
    let start = Capsule { a, b, radius };
    let end = Capsule {
        a: a + shift,
        b: b + shift,
        radius,
    };
    CapsuleMotion { start, end }
}
