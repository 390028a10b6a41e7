//! What each change of topology does to a mesh whose cut can be reckoned by hand.

use microsim_cutting::{Blade, Cut, Settings, Stroke, Sweep, Topology, TopologyChange, check};
use microsim_mesh::{Block, CellSplit, TetMesh};
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// A block of 4 × 4 × 2 in cells of 1, about the origin.
fn block() -> TetMesh {
    let block = Block {
        center: [0.0; 3],
        size: [4.0, 4.0, 2.0],
        cells: [4, 4, 2],
        split: CellSplit::Kuhn,
    };
    block.mesh().expect("a block")
}

struct Body {
    mesh: TetMesh,
    topology: Topology,
    stroke: Stroke,
    settings: Settings,
    /// Divided elements, lost volume, opened area and moment of its x, pieces.
    sum: (usize, f64, f64, f64, usize),
}

impl Body {
    fn new(change: TopologyChange) -> Self {
        let mesh = block();
        Self {
            topology: Topology::new(&mesh),
            mesh,
            stroke: Stroke::new(),
            settings: Settings {
                change,
                ..Settings::default()
            },
            sum: (0, 0.0, 0.0, 0.0, 0),
        }
    }

    fn made(&mut self, cut: Option<Cut>) {
        let Some(cut) = cut else { return };
        self.mesh.apply(&cut.edit).expect("an edit of this mesh");
        check(&self.mesh, &self.topology).expect("a valid mesh");
        let [opened, _] = cut.opened;
        self.sum.0 += cut.divided;
        self.sum.1 += cut.lost_volume;
        self.sum.2 += opened.area;
        self.sum.3 += opened.area * opened.centroid.x;
        self.sum.4 += cut.pieces.len();
    }

    /// Moves a blade at x = 0.3 that reaches from y = −3 to `end` from one height to another.
    fn blade(&mut self, end: f64, [from, to]: [f64; 2]) {
        let line = |z: f64| [V3::new(0.3, -3.0, z), V3::new(0.3, end, z)];
        let sweep = Sweep {
            before: line(from),
            now: line(to),
        };
        let places = self.mesh.positions.clone();
        let blade = Blade::Sweep {
            sweeps: &[sweep],
            before: &places,
            now: &places,
        };
        let Self {
            mesh,
            topology,
            stroke,
            settings,
            ..
        } = self;
        let cut = topology
            .cut(mesh, stroke, &blade, settings)
            .expect("a blade");
        self.made(cut);
    }

    /// The same in steps of at most 0.13, which meet no node.
    fn goes(&mut self, end: f64, from: f64, to: f64) {
        self.goes_by(0.13, end, from, to);
    }

    /// The same in steps of at most so much.
    fn goes_by(&mut self, step: f64, end: f64, from: f64, to: f64) {
        let count = ((to - from).abs() / step).ceil();
        let at = |k: f64| from + (to - from) * k / count;
        for k in 0..count as u32 {
            self.blade(end, [at(f64::from(k)), at(f64::from(k + 1))]);
        }
    }

    /// The blade is taken away.
    fn ends(&mut self) {
        let places = self.mesh.positions.clone();
        let Self {
            mesh,
            topology,
            stroke,
            settings,
            ..
        } = self;
        let cut = topology.conclude_stroke(mesh, stroke, &places, settings);
        self.made(cut);
    }
}

/// The plane x = 0.3 goes through the layer of cells between x = 0 and 1, and through each of their tetrahedra, which reach from one side of a cell to the other.
/// Each edge across is met at 0.3 of its length.
#[test]
fn a_plane_through_a_layer_of_cells() {
    let through = |change| {
        let mut body = Body::new(change);
        body.goes(3.0, 1.6, -1.6);
        body.ends();
        body.sum
    };
    // All 6 · 8 tetrahedra of the layer, of 1 · 4 · 2, are lost: each has a sixth of a cell and is as long as it.
    let (divided, lost, area, moment, pieces) = through(TopologyChange::Remove);
    assert_eq!((divided, pieces), (0, 1));
    assert!((lost - 8.0).abs() < 1e-12, "lost {lost}");
    assert!(
        (area - 8.0).abs() < 1e-12 && (moment / area - 0.5).abs() < 1e-12,
        "{area} {moment}"
    );
    // The nearest faces lie at x = 0.
    let (divided, lost, area, moment, pieces) = through(TopologyChange::SplitAtFaces);
    assert_eq!((divided, lost, pieces), (0, 0.0, 1));
    assert!(
        (area - 8.0).abs() < 1e-12 && moment.abs() < 1e-12,
        "{area} {moment}"
    );
    for change in [TopologyChange::SemiProgressive, TopologyChange::Progressive] {
        let (divided, lost, area, moment, pieces) = through(change);
        assert!(
            divided >= 48 && lost == 0.0 && pieces == 1,
            "{change:?} {divided}"
        );
        assert!((area - 8.0).abs() < 1e-12, "{change:?} {area}");
        // Blades are displaced by 1e-9 of an edge.
        assert!((moment / area - 0.3).abs() < 1e-8, "{change:?} {moment}");
    }
}

/// A blade that rests at the height of nodes, between two steps, has not left the elements there: nothing comes off but the one piece.
#[test]
fn a_blade_that_rests_at_nodes_leaves_one_piece() {
    for change in [TopologyChange::SemiProgressive, TopologyChange::Progressive] {
        for step in [0.25, 0.5, 1.0] {
            let mut body = Body::new(change);
            body.goes_by(step, 3.0, 2.0, -2.0);
            body.ends();
            assert_eq!(body.sum.4, 1, "{change:?} in steps of {step}");
            assert!(
                (body.sum.2 - 8.0).abs() < 1e-12,
                "{change:?} {}",
                body.sum.2
            );
        }
    }
}

/// A blade that comes in to less than a cell and is drawn back has left no element behind: with the dissertation's rule nothing has been divided, while a
/// progressive cut is there as far as edges were crossed.
#[test]
fn a_blade_that_is_drawn_back_at_once_has_divided_nothing() {
    let in_and_out = |change| {
        let mut body = Body::new(change);
        body.goes(3.0, 1.6, 0.9);
        body.goes(3.0, 0.9, 1.6);
        body.ends();
        body.sum.0
    };
    assert_eq!(in_and_out(TopologyChange::SemiProgressive), 0);
    assert!(in_and_out(TopologyChange::Progressive) > 0);
}

/// A blade whose end goes down at y = 0.4 cuts, beside it, tetrahedra in part. With the dissertation's rule these open to the edge opposite, beyond the blade: more
/// than what it has swept, 2 · 2.4, and no more than to the next row of nodes, 2 · 3, along faces that are up to
/// half as long again. A progressive cut opens what was passed whole, at least up to y = 0.
#[test]
fn elements_cut_in_part_open_beyond_the_blade_or_not_up_to_it() {
    let beside = |change| {
        let mut body = Body::new(change);
        body.goes(0.4, 1.6, -1.6);
        body.ends();
        assert_eq!(
            (body.sum.1, body.sum.4),
            (0.0, 0),
            "{change:?}: it hangs together"
        );
        body.sum.2
    };
    let swept = 2.0 * 2.4;
    let semi = beside(TopologyChange::SemiProgressive);
    assert!(semi > swept && semi < 6.0 * 1.5, "{semi}");
    let progressive = beside(TopologyChange::Progressive);
    assert!(
        progressive < swept && progressive > 4.0 * 0.99,
        "{progressive}"
    );
}
