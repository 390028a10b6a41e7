//! A tube of two layers with nodes of their own, as blocks: what tests of vessels measure.

use super::VesselAxis;
use microsim_bus::{Block, BlockBuilder};
use microsim_message::{TISSUE_ELEMENTS, TISSUE_SNAPSHOT};
use std::f64::consts::PI;

/// A vessel along x from 0 to its length. Its sections are polygons with a corner on the z axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct TestTube {
    /// Inside of the media (region 0), between the layers, outside of the adventitia (region 1) \[m\].
    pub radii: [f64; 3],
    /// \[m\]
    pub length: f64,
    /// How far from the end of the media the adventitia ends \[m\].
    pub bare: f64,
    /// Corners of a section, and rings of strips between sections.
    pub around: usize,
    pub along: usize,
    /// Which strips of the media, around and along, have been opened on both sides: from the first to the one behind the last.
    pub opened: [[usize; 2]; 2],
    pub tick: u64,
}

impl Default for TestTube {
    fn default() -> Self {
        Self {
            radii: [0.5e-3, 0.6e-3, 0.65e-3],
            length: 4e-3,
            bare: 0.0,
            around: 24,
            along: 8,
            opened: [[0; 2]; 2],
            tick: 0,
        }
    }
}

impl TestTube {
    pub fn axis() -> VesselAxis {
        VesselAxis::new([0.0; 3], [1.0, 0.0, 0.0]).expect("a direction")
    }

    /// The snapshot and the elements of a tube whose nodes lie where `now` places them.
    pub fn blocks(&self, now: impl Fn([f64; 3]) -> [f64; 3]) -> (Block, Block) {
        let (mut rest, mut triangles) = (Vec::new(), Vec::new());
        let (mut regions, mut opened) = (Vec::new(), Vec::new());
        let (around, along) = (self.around, self.along);
        for layer in 0..2 {
            let first = rest.len();
            let length = self.length - if layer == 1 { self.bare } else { 0.0 };
            for section in 0..=along {
                for radius in &self.radii[layer..layer + 2] {
                    for k in 0..around {
                        let angle = 2.0 * PI * k as f64 / around as f64;
                        let x = length * section as f64 / along as f64;
                        rest.push([x, -radius * libm::sin(angle), radius * libm::cos(angle)]);
                    }
                }
            }
            let row = |section: usize, ring: usize, k: usize| {
                (first + (2 * section + ring) * around + k % around) as u32
            };
            let mut quad = |[a, b, c, d]: [u32; 4], is_opened: bool| {
                triangles.extend([a, c, b, a, d, c]);
                regions.extend([layer as u32; 2]);
                opened.extend([u32::from(is_opened); 2]);
            };
            for k in 0..around {
                for s in 0..along {
                    let [of_k, of_s] = self.opened.map(|[from, to]| from..to);
                    let is_opened = layer == 0 && of_k.contains(&k) && of_s.contains(&s);
                    let strip = |ring| [row(s, ring, k), row(s, ring, k + 1)];
                    let next = |ring| [row(s + 1, ring, k), row(s + 1, ring, k + 1)];
                    let ([a, b], [d, c]) = (strip(0), next(0));
                    quad([a, b, c, d], is_opened);
                    let ([a, b], [d, c]) = (strip(1), next(1));
                    quad([b, a, d, c], is_opened);
                }
                quad(
                    [
                        row(0, 0, k + 1),
                        row(0, 0, k),
                        row(0, 1, k),
                        row(0, 1, k + 1),
                    ],
                    false,
                );
                let s = along;
                quad(
                    [
                        row(s, 0, k),
                        row(s, 0, k + 1),
                        row(s, 1, k + 1),
                        row(s, 1, k),
                    ],
                    false,
                );
            }
        }
        let rows = rest.len() as u32;
        let snapshot = BlockBuilder::new(TISSUE_SNAPSHOT, "tube", 1, 0)
            .u32s("node_id", (0..rows).map(|row| row + 100))
            .f64s("position", rest.iter().flat_map(|place| now(*place)))
            .u32s("piece", (0..rows).map(|_| 0))
            .u32s("triangle", triangles)
            .u32s("inner", opened);
        let elements = BlockBuilder::new(TISSUE_ELEMENTS, "tube", 1, self.tick)
            .f64s("rest", rest.into_iter().flatten())
            .u32s("triangle_region", regions);
        let block = |builder: BlockBuilder| Block::new(&builder.finish()).expect("a good block");
        (block(snapshot), block(elements))
    }
}
