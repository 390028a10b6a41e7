//! Where a blade went through a mesh.

use nalgebra::Vector3;

/// The points at which blades crossed edges of the mesh, at rest, as sums over them: enough for the plane nearest to all (least squares). Unlike the
/// faces that a cut opens they do not depend on where edges may be divided ([`Settings::least_fraction`](crate::Settings)).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathPoints {
    /// Their number.
    pub count: u32,
    /// Their sum \[m\].
    pub sum: Vector3<f64>,
    /// Sums of products of their coordinates: xx, yy, zz, xy, xz, yz \[m²\].
    pub products: [f64; 6],
}

impl PathPoints {
    /// Adds a point \[m\].
    pub(crate) fn add(&mut self, p: &Vector3<f64>) {
        self.merge(&Self {
            count: 1,
            sum: *p,
            products: [
                p.x * p.x,
                p.y * p.y,
                p.z * p.z,
                p.x * p.y,
                p.x * p.z,
                p.y * p.z,
            ],
        });
    }

    /// Adds all points of `other`.
    pub fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.sum += other.sum;
        for (sum, product) in self.products.iter_mut().zip(other.products) {
            *sum += product;
        }
    }
}
