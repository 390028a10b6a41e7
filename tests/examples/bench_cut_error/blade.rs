//! Exact straight blades at random places around marks, and the cuts that they leave in a mesh.

use microsim_cutting::{Blade, Cut, Settings, Sheet, Stroke, Topology};
use microsim_mesh::TetMesh;
use microsim_random::SplitMix64;
use nalgebra::{Matrix3, Vector3};

/// How far from its mark a blade may pass \[m\], and how far askew to it \[rad\]: as hands cut that nearly do as they should.
const BESIDE: f64 = 0.2e-3;
const ASKEW: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// Half of the side of a blade's sheet \[m\]: beyond the strip on all sides.
const REACH: f64 = 3e-3;

/// A plane.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// A point of it \[m\].
    pub point: Vector3<f64>,
    /// Of length 1.
    pub normal: Vector3<f64>,
}

impl Plane {
    /// The angle between two planes \[rad\], and how much farther one passes a mark than the other \[m\].
    pub fn differs(&self, other: &Self, mark: &Vector3<f64>) -> (f64, f64) {
        let normal = match self.normal.dot(&other.normal) < 0.0 {
            true => -self.normal,
            false => self.normal,
        };
        let away = |point: &Vector3<f64>, normal: &Vector3<f64>| (point - mark).dot(normal);
        let beside = away(&self.point, &normal) - away(&other.point, &other.normal);
        let sine = normal.cross(&other.normal).norm();
        (libm::atan2(sine, normal.dot(&other.normal)), beside.abs())
    }

    /// Its part that reaches through a strip, as a sheet.
    fn sheet(&self) -> Sheet {
        let along = Vector3::y();
        let along = (along - self.normal * self.normal.dot(&along)).normalize() * REACH;
        let down = self.normal.cross(&along);
        let corner = |a: f64, b: f64| self.point + along * a + down * b;
        Sheet::quad(
            [corner(-1.0, -1.0), corner(1.0, -1.0)],
            [corner(-1.0, 1.0), corner(1.0, 1.0)],
        )
    }
}

/// Planes of blades, one mark after the other; a mark lies along y.
pub fn planes(marks: &[Vector3<f64>], count: usize, seed: u64) -> Vec<Plane> {
    let mut random = SplitMix64(seed);
    let planes = marks.iter().cycle().take(count).map(|mark| {
        let (beside, turned, bevel) = (random.number(), random.number(), random.number());
        let (turned, bevel) = (turned * ASKEW, bevel * ASKEW);
        let normal = Vector3::new(1.0, libm::tan(turned), libm::tan(bevel));
        Plane {
            point: mark + Vector3::x() * (beside * BESIDE),
            normal: normal.normalize(),
        }
    });
    planes.collect()
}

/// A cut through nodes that stand at `positions`, with the mesh that it leaves.
pub fn cut(
    mesh: &TetMesh,
    positions: &[Vector3<f64>],
    plane: &Plane,
) -> Result<(Cut, TetMesh), String> {
    let sheet = plane.sheet();
    let blade = Blade::Sheet {
        sheet: &sheet,
        positions,
    };
    let mut topology = Topology::new(mesh);
    let made = topology.cut(mesh, &mut Stroke::new(), &blade, &Settings::default());
    let made = made.map_err(|why| why.to_string())?;
    let made = made.ok_or("a blade that cuts nothing")?;
    let mut mesh = mesh.clone();
    mesh.apply(&made.edit).map_err(|why| why.to_string())?;
    Ok((made, mesh))
}

/// The lips of a cut against the plane of its blade.
#[derive(Clone, Copy, Debug)]
pub struct Lips {
    /// Between the mean normal of the lips and the blade \[rad\].
    pub angle: f64,
    /// Distance of their centroid from the plane \[m\].
    pub place: f64,
    /// Root mean square distance of their points from the plane \[m\].
    pub scatter: f64,
    /// Whether the mesh is in two.
    pub parted: bool,
}

/// What an exact blade leaves in a mesh at rest.
pub fn lips(mesh: &TetMesh, plane: &Plane) -> Result<Lips, String> {
    let (made, cut) = cut(mesh, &mesh.positions, plane)?;
    let [opened, _] = made.opened;
    let own = Plane {
        point: opened.centroid,
        normal: opened.normal.normalize(),
    };
    let (angle, _) = own.differs(plane, &plane.point);
    let (mut square, mut area) = (0.0, 0.0);
    for face in &made.edit.cut_faces {
        let corners = face.nodes.map(|node| cut.positions[node as usize]);
        let [a, b, c] = corners;
        let size = 0.5 * (b - a).cross(&(c - a)).norm();
        let [x, y, z] = corners.map(|p| (p - plane.point).dot(&plane.normal));
        // The mean square of a linear function over a triangle, by its values at the corners.
        let mean = (x * x + y * y + z * z + (x + y + z).powi(2)) / 12.0;
        square += size * mean;
        area += size;
    }
    Ok(Lips {
        angle,
        place: (opened.centroid - plane.point).dot(&plane.normal).abs(),
        scatter: (square / area).sqrt(),
        parted: made.pieces.len() == 1,
    })
}

/// The plane nearest to where a blade crossed the edges of a mesh at rest, as the metrics take it: least squares.
pub fn path(mesh: &TetMesh, positions: &[Vector3<f64>], plane: &Plane) -> Result<Plane, String> {
    let (made, _) = cut(mesh, positions, plane)?;
    let points = made.points;
    let count = f64::from(points.count);
    let mean = points.sum / count;
    let [xx, yy, zz, xy, xz, yz] = points.products;
    let products = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let covariance = products / count - mean * mean.transpose();
    let eigen = covariance.symmetric_eigen();
    let normal = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    Ok(Plane {
        point: mean,
        normal: normal.into(),
    })
}
