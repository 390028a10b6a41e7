//! Surfaces in the colours of what is computed: stress, the quality of elements, what had to be done about them.

use microsim_bus::BlockView;
use microsim_vocabulary::{DebugView, Finish, Remedy};

use crate::legend::{Legend, NO_REMEDY, of_remedy};
use crate::picture::Item;
use crate::shape::Shape;
use crate::tissue::Tissue;

/// Values above the scale are those of this part of the nodes: single nodes at the edge of a contact do not leave the rest of one colour.
const ABOVE: f64 = 0.02;
/// What has no values.
const NO_VALUE: [f32; 3] = [0.62, 0.62, 0.62];

/// What is known of the nodes of a body, in the order of its tissue.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields {
    /// Von Mises stress \[Pa\]; empty where there is none.
    pub von_mises: Vec<f64>,
    /// Radius ratio of the worst element, below 0 inside out.
    pub quality: Vec<f64>,
    /// Bits of [`Remedy`].
    pub remedies: Vec<u32>,
}

impl Fields {
    /// Those of a block of kind [`TISSUE_FIELDS`](microsim_message::TISSUE_FIELDS).
    pub fn of_block(block: &BlockView<'_>) -> Self {
        Self {
            von_mises: block.f64s("von_mises").unwrap_or_default().to_vec(),
            quality: block.f64s("quality").unwrap_or_default().to_vec(),
            remedies: block.u32s("remedy").unwrap_or_default().to_vec(),
        }
    }

    fn values(&self, view: DebugView) -> &[f64] {
        match view {
            DebugView::Stress => &self.von_mises,
            DebugView::Quality => &self.quality,
            _ => &[],
        }
    }
}

/// Bodies in the colours of a view that colours surfaces, and what the colours mean. What has no values, or values of other nodes, is grey.
pub fn surfaces(view: DebugView, bodies: &[(Tissue, Fields)]) -> (Vec<Item>, Legend) {
    if view == DebugView::Remedies {
        let items = bodies.iter().flat_map(|(tissue, of)| {
            match of.remedies.len() == tissue.positions.len() {
                true => remedied(tissue, &of.remedies),
                false => {
                    let all = tissue.triangles.iter();
                    vec![part(tissue, all.copied().collect(), NO_VALUE)]
                }
            }
        });
        return (items.collect(), Legend::Remedies);
    }
    let seen = bodies.iter().flat_map(|(tissue, of)| {
        let values = of.values(view);
        let nodes = tissue.triangles.iter().flatten();
        nodes.filter_map(|node| values.get(*node as usize).copied())
    });
    let legend = match view {
        DebugView::Stress => Legend::of_stress(seen.collect(), ABOVE),
        _ => Legend::Quality,
    };
    let items = bodies.iter().map(|(tissue, of)| {
        let values = of.values(view);
        match values.len() == tissue.positions.len() {
            true => {
                let shape = Shape::Field {
                    positions: tissue.positions.clone(),
                    triangles: tissue.triangles.clone(),
                    values: values
                        .iter()
                        .map(|value| legend.part(*value) as f32)
                        .collect(),
                };
                Item::new(shape, [0.0; 3], [1.0; 3], Finish::Matte)
            }
            false => {
                let all = tissue.triangles.iter();
                part(tissue, all.copied().collect(), NO_VALUE)
            }
        }
    });
    (items.collect(), legend)
}

/// A body in one part for each remedy that there is: that of the worst of its corners for each triangle.
fn remedied(tissue: &Tissue, remedies: &[u32]) -> Vec<Item> {
    let of_triangle = |triangle: &[u32; 3]| {
        let bits = triangle.map(|node| remedies.get(node as usize).copied().unwrap_or_default());
        Legend::worst(bits[0] | bits[1] | bits[2])
    };
    let classes = Remedy::ALL.map(Some).into_iter().chain([None]);
    let parts = classes.map(|class| {
        let triangles = tissue.triangles.iter().copied();
        let of_class: Vec<_> = triangles.filter(|t| of_triangle(t) == class).collect();
        (of_class, class.map_or(NO_REMEDY, of_remedy))
    });
    let parts = parts.filter(|(triangles, _)| !triangles.is_empty());
    parts
        .map(|(triangles, colour)| part(tissue, triangles, colour))
        .collect()
}

/// Triangles of a body in one colour, with the nodes that they have.
fn part(tissue: &Tissue, mut triangles: Vec<[u32; 3]>, colour: [f32; 3]) -> Item {
    let mut nodes: Vec<u32> = triangles.as_flattened().to_vec();
    nodes.sort_unstable();
    nodes.dedup();
    for node in triangles.as_flattened_mut() {
        *node = nodes.partition_point(|of| of < node) as u32;
    }
    let positions = nodes.iter().map(|node| tissue.positions[*node as usize]);
    let shape = Shape::Mesh {
        positions: positions.collect(),
        triangles,
    };
    Item::new(shape, [0.0; 3], colour, Finish::Matte)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles with a common side.
    fn tissue() -> Tissue {
        Tissue {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [1, 3, 2]],
            ..Tissue::default()
        }
    }

    /// The scale of stresses up to 1.9 kPa ends at 2 kPa: 500 Pa are a quarter of it, 1 kPa a half. Quality is as it is, what is inside out as what is flat.
    #[test]
    fn values_lie_on_the_scale() {
        let fields = || Fields {
            von_mises: vec![0.0, 500.0, 1000.0, 1900.0],
            quality: vec![1.0, 0.25, 0.0, -0.5],
            remedies: Vec::new(),
        };
        for (view, expected) in [
            (DebugView::Stress, [0.0, 0.25, 0.5, 0.95]),
            (DebugView::Quality, [1.0, 0.25, 0.0, 0.0]),
        ] {
            let (items, _) = surfaces(view, &[(tissue(), fields())]);
            match &items[0].shape {
                Shape::Field { values, .. } => assert_eq!(*values, expected, "{view:?}"),
                other => panic!("{other:?}"),
            }
        }
    }

    /// What has no values of its nodes is there all the same, and looks like none of the values.
    #[test]
    fn what_has_no_values_is_grey() {
        let (items, _) = surfaces(DebugView::Stress, &[(tissue(), Fields::default())]);
        assert_eq!(items[0].colour, NO_VALUE);
        assert!(matches!(&items[0].shape, Shape::Mesh { triangles, .. } if triangles.len() == 2));
    }

    /// Node 3 is of the second triangle alone: that has its colour, with three nodes of its own.
    #[test]
    fn a_triangle_has_the_colour_of_its_worst_corner() {
        let fields = Fields {
            remedies: vec![0, 0, 0, Remedy::Inertia.bit() | Remedy::Inverted.bit()],
            ..Fields::default()
        };
        let (items, _) = surfaces(DebugView::Remedies, &[(tissue(), fields)]);
        let colours: Vec<[f32; 3]> = items.iter().map(|item| item.colour).collect();
        assert_eq!(colours, [of_remedy(Remedy::Inverted), NO_REMEDY]);
        for item in &items {
            match &item.shape {
                Shape::Mesh {
                    positions,
                    triangles,
                } => {
                    assert_eq!((positions.len(), triangles.len()), (3, 1));
                }
                other => panic!("{other:?}"),
            }
        }
    }
}
