//! Fibre directions of the elements of a body.

use super::error::FromSettingsError;
use super::error::missing;
use microsim_mesh::{FAMILIES, TetMesh};
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
        let families = match material.law {
            settings::Law::Springs => 0,
            settings::Law::Continuum(law) => law.families(),
        };
        let field = Field::new(fibres, families, body, &key)?;
        mesh.directions.resize(mesh.tets.len(), Default::default());
        for element in 0..mesh.tets.len() {
            if is_of(material, mesh.regions[element]) {
                let centre = mesh.corners(element).iter().sum::<Vector3<f64>>() / 4.0;
                mesh.directions[element] = field.at(&centre);
            }
        }
    }
    Ok(())
}

/// Directions for each point, of one or two families.
enum Field {
    Constant([Vector3<f64>; FAMILIES]),
    /// Around an axis through a point, in the frame of the scene.
    Helix {
        point: Vector3<f64>,
        axis: Vector3<f64>,
        cosine: f64,
        /// That of each family; of none if it is not there.
        sines: [Option<f64>; FAMILIES],
    },
}

impl Field {
    fn new(
        fibres: &settings::Fibres,
        families: usize,
        body: &settings::Body,
        key: &KeyPath,
    ) -> Result<Self, FromSettingsError> {
        let unit = |v: [f64; 3]| Unit::new_normalize(Vector3::from(v)).into_inner();
        if let Some(direction) = fibres.direction {
            let second = fibres.second_direction.map(unit);
            let second = second.unwrap_or_default();
            return Ok(Self::Constant([unit(direction), second]));
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
            sines: [Some(sine), (families == FAMILIES).then_some(-sine)],
        })
    }

    /// On the axis itself, where nothing is around it, the direction of the axis.
    fn at(&self, place: &Vector3<f64>) -> [Vector3<f64>; FAMILIES] {
        match self {
            Self::Constant(directions) => *directions,
            Self::Helix {
                point,
                axis,
                cosine,
                sines,
            } => {
                let around = Unit::try_new(axis.cross(&(place - point)), 0.0);
                sines.map(|sine| match (sine, &around) {
                    (None, _) => Vector3::zeros(),
                    (Some(sine), Some(around)) => around.into_inner() * *cosine + axis * sine,
                    (Some(_), None) => *axis,
                })
            }
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
            sines: [Some(sine), Some(-sine)],
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
            let [direction, second] = helix(angle).at(&top);
            assert!((direction - expected).amax() < 1e-15, "{direction}");
            // The other family mirrored: against the axis.
            assert!((second - direction - Vector3::x() * (second.x - direction.x)).amax() < 1e-15);
            assert_eq!(second.x, -direction.x);
        }
        let on_the_axis = helix(0.2).at(&Vector3::new(7.0, 0.0, 1.0));
        assert_eq!(on_the_axis, [Vector3::x(); FAMILIES]);
    }
}
