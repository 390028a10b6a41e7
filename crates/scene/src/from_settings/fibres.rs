//! Fibre directions of the elements of a body.

use super::error::FromSettingsError;
use super::error::missing;
use microsim_mesh::TetMesh;
use microsim_settings as settings;
use nalgebra::{Unit, Vector3};
use settings::KeyPath;

/// Gives the elements of `mesh` that are made of a material with fibres their directions; those of a mesh file stay where a material
/// states none. `is_of` returns whether an element of a region is made of a material.
pub(super) fn set_directions(
    mesh: &mut TetMesh,
    body: &settings::Body,
    key: &KeyPath,
    is_of: impl Fn(&settings::Material, u32) -> bool,
) -> Result<(), FromSettingsError> {
    for (index, material) in body.material.iter().enumerate() {
        let Some(fibres) = &material.fibres else {
            continue;
        };
        let key = key.key("material").at(index).key("fibres");
        let field = Field::new(fibres, body, &key)?;
        mesh.directions.resize(mesh.tets.len(), Vector3::zeros());
        for element in 0..mesh.tets.len() {
            if is_of(material, mesh.regions[element]) {
                let centre = mesh.corners(element).iter().sum::<Vector3<f64>>() / 4.0;
                mesh.directions[element] = field.at(&centre);
            }
        }
    }
    Ok(())
}

/// A direction for each point.
enum Field {
    Constant(Vector3<f64>),
    /// Around an axis through a point, in the frame of the scene.
    Helix {
        point: Vector3<f64>,
        axis: Vector3<f64>,
        cosine: f64,
        sine: f64,
    },
}

impl Field {
    fn new(
        fibres: &settings::Fibres,
        body: &settings::Body,
        key: &KeyPath,
    ) -> Result<Self, FromSettingsError> {
        let unit = |v: [f64; 3]| Unit::new_normalize(Vector3::from(v)).into_inner();
        if let Some(direction) = fibres.direction {
            return Ok(Self::Constant(unit(direction)));
        }
        let angle = fibres
            .angle
            .ok_or_else(|| missing(key.clone(), "`direction` or `angle`"))?;
        let (sine, cosine) = libm::sincos(angle);
        let of_tube = body.generator == settings::Generator::Tube;
        let axis = match fibres.axis {
            Some(axis) => axis,
            None if of_tube => body.axis.unwrap_or([1.0, 0.0, 0.0]),
            None => return Err(missing(key.key("axis"), "`axis`")),
        };
        let point = Vector3::from(fibres.point.unwrap_or([0.0; 3]));
        Ok(Self::Helix {
            point: point + Vector3::from(body.centre),
            axis: unit(axis),
            cosine,
            sine,
        })
    }

    /// On the axis itself, where nothing is around it, the direction of the axis.
    fn at(&self, place: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Constant(direction) => *direction,
            Self::Helix {
                point,
                axis,
                cosine,
                sine,
            } => match Unit::try_new(axis.cross(&(place - point)), 0.0) {
                Some(around) => around.into_inner() * *cosine + axis * *sine,
                None => *axis,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn helix(angle: f64) -> Field {
        let (sine, cosine) = libm::sincos(angle);
        Field::Helix {
            point: Vector3::new(0.0, 0.0, 1.0),
            axis: Vector3::x(),
            cosine,
            sine,
        }
    }

    #[test]
    fn fibres_are_around_an_axis_along_it_or_between() {
        let top = Vector3::new(0.3, 0.0, 3.0);
        let right = std::f64::consts::FRAC_PI_2;
        for (angle, expected) in [
            (0.0, Vector3::new(0.0, -1.0, 0.0)),
            (right, Vector3::x()),
            (
                0.5 * right,
                Vector3::new(0.5f64.sqrt(), -(0.5f64.sqrt()), 0.0),
            ),
        ] {
            let direction = helix(angle).at(&top);
            assert!((direction - expected).amax() < 1e-15, "{direction}");
        }
        let on_the_axis = helix(0.2).at(&Vector3::new(7.0, 0.0, 1.0));
        assert_eq!(on_the_axis, Vector3::x());
    }
}
