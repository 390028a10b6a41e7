//! The residual state of a tube: prestretches of its elements from axial stretch, transmural pressure and opening angles.

use super::error::{FromSettingsCause, FromSettingsError};
use microsim_mesh::{FAMILIES, TetMesh, Tube};
use microsim_settings as settings;
use microsim_tissue::vessel_wall::{VesselWall, WallLayer};
use microsim_tissue::{Behaviour, ContinuumConstants, Material};
use nalgebra::{Matrix3, Unit, Vector3};
use settings::KeyPath;

/// Gives the elements of `mesh`, those of `tube`, their prestretches, if the body states any.
pub(super) fn set_prestretches(
    mesh: &mut TetMesh,
    body: &settings::Body,
    tube: Option<&Tube>,
    materials: &[(u32, Material)],
    key: &KeyPath,
) -> Result<(), FromSettingsError> {
    let opens = body.layer.iter().any(|layer| layer.opening_angle != 0.0);
    let (Some(tube), true) = (
        tube,
        opens || body.axial_stretch != 1.0 || body.transmural_pressure != 0.0,
    ) else {
        return Ok(());
    };
    let frame = Frame {
        center: Vector3::from(tube.center),
        axis: Unit::new_normalize(Vector3::from(tube.axis)).into_inner(),
    };
    let radii: Vec<f64> = (0..mesh.tets.len())
        .map(|element| frame.mean_radius(mesh, element))
        .collect();
    let mut layers = Vec::new();
    let mut inner = tube.inner_radius;
    for (index, layer) in body.layer.iter().enumerate() {
        let key = key.key("layer").at(index);
        let outer = inner + layer.thickness;
        let constants = continuum(layer.region, materials)
            .ok_or_else(|| FromSettingsError::new(key.clone(), FromSettingsCause::Springs))?;
        layers.push(WallLayer {
            radii: [inner, outer],
            constants,
            directions: frame
                .directions(mesh, &radii, [inner, outer])
                .ok_or_else(|| FromSettingsError::new(key, FromSettingsCause::Asymmetric))?,
            opening_angle: layer.opening_angle,
        });
        inner = outer;
    }
    let wall = VesselWall {
        layers,
        axial_stretch: body.axial_stretch,
        pressure: body.transmural_pressure,
    };
    let stretches = wall
        .stretches()
        .map_err(|source| FromSettingsError::new(key.key("layer"), source.into()))?;
    let prestretch = |element: usize| {
        let axes = frame.at(&centre(mesh, element));
        axes * Matrix3::from_diagonal(&stretches.at(radii[element])) * axes.transpose()
    };
    mesh.prestretches = (0..mesh.tets.len()).map(prestretch).collect();
    Ok(())
}

/// The constants of a region, if it is a continuum.
fn continuum(region: u32, materials: &[(u32, Material)]) -> Option<ContinuumConstants> {
    let (_, material) = materials.iter().find(|(of, _)| *of == region)?;
    match material.behaviour {
        Behaviour::Continuum(constants) => Some(constants),
        Behaviour::Springs(_) => None,
    }
}

fn centre(mesh: &TetMesh, element: usize) -> Vector3<f64> {
    mesh.corners(element).iter().sum::<Vector3<f64>>() / 4.0
}

/// The cylindrical frame of a tube.
struct Frame {
    center: Vector3<f64>,
    axis: Vector3<f64>,
}

impl Frame {
    /// From the axis to a place \[m\].
    fn out(&self, place: &Vector3<f64>) -> Vector3<f64> {
        let from_axis = place - self.center;
        from_axis - self.axis * from_axis.dot(&self.axis)
    }

    /// Unit vectors r, θ, z at a place as columns. No element lies on the axis: the lumen is there.
    fn at(&self, place: &Vector3<f64>) -> Matrix3<f64> {
        let radial = self.out(place).normalize();
        let around = self.axis.cross(&radial);
        Matrix3::from_columns(&[radial, around, self.axis])
    }

    /// The mean of the radii of an element's corners \[m\]: these lie on the circles of the wall, while its centre lies inside the polygon.
    fn mean_radius(&self, mesh: &TetMesh, element: usize) -> f64 {
        let corners = mesh.corners(element);
        corners.iter().map(|p| self.out(p).norm()).sum::<f64>() / 4.0
    }

    /// The fibre directions of the elements between two radii by r, θ, z; `None` if they differ.
    fn directions(
        &self,
        mesh: &TetMesh,
        mean_radii: &[f64],
        [inner, outer]: [f64; 2],
    ) -> Option<[Vector3<f64>; FAMILIES]> {
        // Directions follow from angles by a few operations on numbers of order one.
        const ROUNDING: f64 = 1e-9;
        let mut common = None;
        for (element, radius) in mean_radii.iter().enumerate() {
            if *radius < inner || *radius > outer {
                continue;
            }
            let axes = self.at(&centre(mesh, element));
            let own = mesh.fibres(element).map(|a| axes.tr_mul(&a));
            let common = common.get_or_insert(own);
            let differs = |(a, b): (&Vector3<f64>, &Vector3<f64>)| (a - b).amax() > ROUNDING;
            if own.iter().zip(&*common).any(differs) {
                return None;
            }
        }
        Some(common.unwrap_or_default())
    }
}
