//! What has been done to the layers of a wall: stretched too far, cut, torn.

use super::VesselWall;
use microsim_bus::BlockView;
use microsim_message::TissueCut;
use serde::{Deserialize, Serialize};

/// The injury of one layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayerInjury {
    /// The region of its elements.
    pub region: u32,
    /// Stretch from the natural state beyond which it counts as injured.
    pub threshold: f64,
    /// Largest stretch so far: of the single element that was stretched farthest, which depends on the mesh.
    pub stretch: f64,
    /// Largest volume, at rest, that was beyond the threshold in one tick \[m³\].
    pub volume: f64,
    /// The same over the volume of the whole layer then.
    pub fraction: f64,
    /// Area that tools opened, at rest, of one side \[m²\].
    pub cut: f64,
    /// Area that tore by itself, at rest, of one side \[m²\].
    pub torn: f64,
    /// What was open in the last tick \[m²\].
    open: f64,
}

/// The injuries of the layers of a vessel, tick by tick.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WallInjury {
    layers: Vec<LayerInjury>,
}

impl WallInjury {
    /// Of layers by their regions, each with the stretch beyond which it counts as injured.
    pub fn of(layers: &[(u32, f64)]) -> Self {
        let layer = |(region, threshold): &(u32, f64)| LayerInjury {
            region: *region,
            threshold: *threshold,
            ..LayerInjury::default()
        };
        Self {
            layers: layers.iter().map(layer).collect(),
        }
    }

    /// Looks at a tick: [elements](microsim_message::TISSUE_ELEMENTS), the surface of the same tick, what was cut in it; `valid` is whether its forces
    /// mean anything. From a tick that is not valid nothing is taken. What a layer has open more than before was cut and torn as the areas of both in the
    /// whole body are. `None` if the block is of something else.
    pub fn update(
        &mut self,
        elements: &BlockView<'_>,
        wall: &VesselWall<'_>,
        cuts: &[TissueCut],
        valid: bool,
    ) -> Option<()> {
        let regions = elements.u32s("region")?;
        let volumes = elements.f64s("volume")?;
        let stretches = elements.f64s("stretch")?;
        let area = |torn: bool| {
            let of = cuts.iter().filter(|cut| cut.tool.is_empty() == torn);
            of.map(|cut| cut.area).sum::<f64>()
        };
        let (by_tools, by_itself) = (area(false), area(true));
        for layer in &mut self.layers {
            let open = wall.opened(layer.region);
            let more = open - std::mem::replace(&mut layer.open, open);
            if !valid {
                continue;
            }
            if more > 0.0 && by_tools + by_itself > 0.0 {
                layer.cut += more * by_tools / (by_tools + by_itself);
                layer.torn += more * by_itself / (by_tools + by_itself);
            }
            let (mut whole, mut beyond) = (0.0, 0.0);
            for ((region, volume), stretch) in regions.iter().zip(volumes).zip(stretches) {
                if *region != layer.region {
                    continue;
                }
                layer.stretch = layer.stretch.max(*stretch);
                whole += volume;
                if *stretch > layer.threshold {
                    beyond += volume;
                }
            }
            layer.volume = layer.volume.max(beyond);
            if whole > 0.0 {
                layer.fraction = layer.fraction.max(beyond / whole);
            }
        }
        Some(())
    }

    /// The injury of the layer of a region; `None` of one that is not watched.
    pub fn layer(&self, region: u32) -> Option<&LayerInjury> {
        self.layers.iter().find(|layer| layer.region == region)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tissue::test_tube::TestTube;
    use microsim_bus::{Block, BlockBuilder};
    use microsim_message::TISSUE_ELEMENTS;

    /// Elements of two layers: volumes 1 to 4, stretched by these.
    fn elements(stretches: [f64; 4]) -> Block {
        let builder = BlockBuilder::new(TISSUE_ELEMENTS, "tube", 1, 0)
            .u32s("region", [0, 0, 1, 1])
            .f64s("volume", [1.0, 2.0, 3.0, 4.0])
            .f64s("stretch", stretches);
        Block::new(&builder.finish()).expect("a good block")
    }

    /// By hand: of the media 2 of 3 are beyond 1.5 at most, then 1; of the adventitia nothing is beyond its threshold. A tick that means nothing counts nowhere, also not
    /// what came open in it. Of what is opened in a tick with 3 areas cut and 1 torn a quarter is torn.
    #[test]
    fn layers_are_injured_beyond_their_thresholds() {
        let mut injury = WallInjury::of(&[(0, 1.5), (1, 2.0)]);
        let tube = TestTube::default();
        let mut tick = |rows: usize, stretches, cuts: &[TissueCut], valid| {
            let opened = [[0, 1], [0, rows]];
            let (snapshot, of_tube) = TestTube { opened, ..tube }.blocks(|place| place);
            let (snapshot, of_tube) = (snapshot.view(), of_tube.view());
            let wall = VesselWall::of(&snapshot, &of_tube, TestTube::axis()).expect("a wall");
            let block = elements(stretches);
            let updated = injury.update(&block.view(), &wall, cuts, valid);
            assert_eq!(updated, Some(()));
            (
                *injury.layer(0).expect("it is watched"),
                *injury.layer(1).expect("so is it"),
                wall.opened(0),
            )
        };
        let cut = |tool: &str, area: f64| TissueCut {
            tool: tool.into(),
            area,
            ..TissueCut::default()
        };
        let (media, adventitia, _) = tick(0, [1.2, 1.6, 1.9, 1.0], &[], true);
        assert_eq!(
            (media.stretch, media.volume, media.fraction),
            (1.6, 2.0, 2.0 / 3.0)
        );
        assert_eq!((adventitia.stretch, adventitia.volume), (1.9, 0.0));
        tick(2, [9.0; 4], &[cut("right", 1.0)], false);
        let (media, adventitia, before) = tick(2, [1.7, 1.0, 1.0, 1.0], &[], true);
        assert_eq!((media.stretch, media.volume, media.cut), (1.7, 2.0, 0.0));
        assert_eq!(adventitia.fraction, 0.0);
        let cuts = [cut("right", 3.0), cut("", 1.0)];
        let (media, adventitia, after) = tick(4, [1.0; 4], &cuts, true);
        let opened = after - before;
        assert!(opened > 0.0 && (media.cut - 0.75 * opened).abs() < 1e-12 * opened);
        assert!((media.torn - 0.25 * opened).abs() < 1e-12 * opened);
        assert_eq!((adventitia.cut, adventitia.torn), (0.0, 0.0));
        assert_eq!(injury.layer(2), None);
    }
}
