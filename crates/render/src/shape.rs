//! The forms of items.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::mesh::Mesh;
use crate::textures::Texture;
use microsim_model::Mask;

/// The form of an item, in the item's own frame. Both sides of every surface are drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Ball around the origin.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// Every point within `radius` of the segment from `a` to `b`.
    Capsule {
        /// One end of the segment \[m\].
        a: [f64; 3],
        /// The other end \[m\].
        b: [f64; 3],
        /// Radius \[m\].
        radius: f64,
    },
    /// Two balls and the tangent cone between them: a capsule whose radius changes evenly, such as the jaw of a forceps.
    Taper {
        /// Centre of the one ball \[m\].
        a: [f64; 3],
        /// Centre of the other ball \[m\].
        b: [f64; 3],
        /// Radius of the ball at `a` \[m\].
        radius_a: f64,
        /// Radius of the ball at `b` \[m\].
        radius_b: f64,
    },
    /// Cuboid around the origin, edges along the axes.
    Box {
        /// Half of each edge \[m\].
        half: [f64; 3],
    },
    /// Cuboid around the origin with round edges and corners.
    RoundedBox {
        /// Half of each edge \[m\].
        half: [f64; 3],
        /// Of edges and corners \[m\]; what is more than the smallest half counts as that.
        radius: f64,
    },
    /// Part of an instrument or of a model from a file, made once.
    Model(Arc<Model>),
    /// Closed cylinder, from the origin along +z.
    Cylinder {
        /// Radius \[m\].
        radius: f64,
        /// Length along z \[m\].
        height: f64,
    },
    /// Closed cone: base disc around the origin in the xy plane, apex on +z.
    Cone {
        /// Radius of the base \[m\].
        radius: f64,
        /// Height of the apex \[m\].
        height: f64,
    },
    /// Arrow from the origin along +z: a shaft, and over the last third a head three times as thick.
    Arrow {
        /// Radius of the shaft \[m\].
        radius: f64,
        /// Length including the head \[m\].
        length: f64,
    },
    /// Torus around z in the xy plane, or the first part of one: seen from +z it begins at +y and runs like the hand of a clock.
    Ring {
        /// From the axis to the middle of the tube \[m\].
        radius: f64,
        /// Radius of the tube \[m\].
        tube: f64,
        /// The part that is drawn, 0..1; 1 is the whole ring.
        fraction: f64,
    },
    /// Any triangulated surface, shaded smoothly over its edges.
    Mesh {
        /// Corners \[m\].
        positions: Vec<[f32; 3]>,
        /// Three indices into `positions` each.
        triangles: Vec<[u32; 3]>,
    },
    /// The same in the colours of values at its corners, which are multiplied by that of the item.
    Field {
        /// Corners \[m\].
        positions: Vec<[f32; 3]>,
        /// Three indices into `positions` each.
        triangles: Vec<[u32; 3]>,
        /// Of each corner, from 0 to 1, by [`colour_of`](crate::colour_of).
        values: Vec<f32>,
    },
}

/// Triangles that are made once and drawn often, such as a jaw of an instrument. Two are the same if they are copies of one.
#[derive(Clone)]
pub struct Model {
    id: u64,
    mesh: Mesh,
    /// Wound anticlockwise as seen from outside and without an edge.
    closed: bool,
    texture: Option<Texture>,
    mask: Option<Mask>,
}

impl Model {
    /// Takes closed triangles; each call makes another model.
    pub(crate) fn new(mesh: Mesh) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self {
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            mesh,
            closed: true,
            texture: None,
            mask: None,
        }
    }

    /// Takes triangles that may have edges, what is seen on them, and what of them is there by it.
    pub(crate) fn of_file(mesh: Mesh, texture: Option<Texture>, mask: Option<Mask>) -> Self {
        Self {
            closed: false,
            mask: mask.filter(|_| texture.is_some()),
            texture,
            ..Self::new(mesh)
        }
    }

    /// Whether no inner side is ever seen.
    pub(crate) fn is_closed(&self) -> bool {
        self.closed
    }

    /// What of the triangles is there by the opacity of the texture; `None` if all of them are.
    pub(crate) fn mask(&self) -> Option<Mask> {
        self.mask
    }

    pub(crate) fn texture(&self) -> Option<&Texture> {
        self.texture.as_ref()
    }

    /// What distinguishes it from others of the process.
    pub(crate) fn id(&self) -> u64 {
        self.id
    }

    pub(crate) fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.mesh.indices.len() / 3
    }
}

impl PartialEq for Model {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl fmt::Debug for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangles = self.triangle_count();
        write!(f, "Model({}, {triangles} triangles)", self.id)
    }
}

impl Shape {
    /// What makes the form undrawable, if anything.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        let lengths_good =
            |lengths: &[f64]| finite(lengths) && lengths.iter().all(|&length| length >= 0.0);
        let good = match self {
            Self::Sphere { radius } => lengths_good(&[*radius]),
            Self::Capsule { a, b, radius } => finite(a) && finite(b) && lengths_good(&[*radius]),
            Self::Taper {
                a,
                b,
                radius_a,
                radius_b,
            } => finite(a) && finite(b) && lengths_good(&[*radius_a, *radius_b]),
            Self::Box { half } => lengths_good(half),
            Self::RoundedBox { half, radius } => lengths_good(half) && lengths_good(&[*radius]),
            Self::Model(_) => true,
            Self::Cylinder { radius, height } | Self::Cone { radius, height } => {
                lengths_good(&[*radius, *height])
            }
            Self::Arrow { radius, length } => lengths_good(&[*radius, *length]),
            Self::Ring {
                radius,
                tube,
                fraction,
            } => lengths_good(&[*radius, *tube]) && (0.0..=1.0).contains(fraction),
            Self::Field {
                values, positions, ..
            } if values.len() != positions.len()
                || !values.iter().all(|value| (0.0..=1.0).contains(value)) =>
            {
                return Some("a value within 0..1 is needed for each corner");
            }
            Self::Mesh {
                positions,
                triangles,
            }
            | Self::Field {
                positions,
                triangles,
                ..
            } => {
                if !positions.iter().flatten().all(|part| part.is_finite()) {
                    return Some("mesh has a corner that is not finite");
                }
                if triangles
                    .iter()
                    .flatten()
                    .any(|&index| index as usize >= positions.len())
                {
                    return Some("mesh has a triangle with a corner that does not exist");
                }
                true
            }
        };
        if good {
            None
        } else {
            Some("lengths must be finite and not negative, a fraction within 0..1")
        }
    }
}

/// Whether all are numbers.
pub(crate) fn finite(parts: &[f64]) -> bool {
    parts.iter().all(|part| part.is_finite())
}
