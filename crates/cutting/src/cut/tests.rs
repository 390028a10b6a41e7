use super::*;
use crate::testing::Random;
use crate::{Flaw, Measures, check};
use microsim_mesh::{Block, CellSplit};

type V3 = Vector3<f64>;

fn block(cells: [usize; 3]) -> TetMesh {
    let block = Block {
        center: [0.0; 3],
        size: cells.map(|n| n as f64),
        cells,
        split: CellSplit::Kuhn,
    };
    block.mesh().unwrap()
}

/// A square around `center` with this normal, far over the body.
fn plane(center: V3, normal: V3) -> Sheet {
    let normal = normal.normalize();
    let side = normal
        .cross(&if normal.x.abs() < 0.7 {
            V3::x()
        } else {
            V3::y()
        })
        .normalize();
    let up = normal.cross(&side);
    let at = |a: f64, b: f64| center + (side * a + up * b) * 40.0;
    Sheet::quad(
        [at(-1.0, -1.0), at(1.0, -1.0)],
        [at(-1.0, 1.0), at(1.0, 1.0)],
    )
}

struct Body {
    mesh: TetMesh,
    topology: Topology,
}

impl Body {
    fn new(mesh: TetMesh) -> Self {
        let topology = Topology::new(&mesh);
        Self { mesh, topology }
    }

    fn cut(&mut self, stroke: &mut Stroke, sheet: &Sheet) -> Option<Cut> {
        let positions = self.mesh.positions.clone();
        let blade = Blade::Sheet {
            sheet,
            positions: &positions,
        };
        let cut = self
            .topology
            .cut(&self.mesh, stroke, &blade, &Settings::default())
            .unwrap();
        if let Some(cut) = &cut {
            self.mesh.apply(&cut.edit).unwrap();
        }
        cut
    }

    fn check(&self) -> Result<Measures, Flaw> {
        check(&self.mesh, &self.topology)
    }
}

#[test]
fn planes_separate_a_block_into_two() {
    let mut random = Random(3);
    for n in 0..200 {
        let mut mesh = block([3, 3, 3]);
        for p in &mut mesh.positions {
            *p += random.vector() * 0.12;
        }
        let mut body = Body::new(mesh);
        let before = body.check().unwrap();
        let sheet = plane(random.vector() * 0.5, random.vector());
        let cut = body.cut(&mut Stroke::new(), &sheet).unwrap();
        let after = body.check().unwrap();
        assert_eq!((after.parts, cut.pieces.len()), (2, 1), "{n} {cut:?}");
        assert!((after.volume / before.volume - 1.0).abs() < 1e-12);
        assert!((after.outer_area / before.outer_area - 1.0).abs() < 1e-12);
        assert!(after.sheets[0].1 < 1e-12);
        assert!((after.sheets[0].0 - 2.0 * cut.opened[0].area).abs() < 1e-12);
        assert_eq!((cut.dropped, cut.snapped, cut.joined), (0, 0, 0));
    }
}
