//! Materials.

use super::error::{FromSettingsError, missing};
use microsim_settings as settings;
use microsim_tissue::law::LawName;
use microsim_tissue::{Behaviour, ContinuumConstants, Discretisation, Material, SpringConstants};
use settings::KeyPath;

/// A material; `key` is its own.
pub(super) fn material(
    material: &settings::Material,
    key: &KeyPath,
) -> Result<Material, FromSettingsError> {
    let (behaviour, modulus) = behaviour(material, key)?;
    let relaxation_time = match (material.relaxation_time, material.viscosity, modulus) {
        (Some(time), _, _) => time,
        (None, None, _) => 0.0,
        (None, Some(viscosity), Some(modulus)) => viscosity / modulus,
        (None, Some(_), None) => {
            return Err(missing(key.key("viscosity"), "a modulus for the viscosity"));
        }
    };
    Ok(Material {
        density: material.density,
        relaxation_time,
        behaviour,
    })
}

/// How it resists deformation, and its stiffness in uniaxial stretch [Pa], where that is known.
fn behaviour(
    material: &settings::Material,
    key: &KeyPath,
) -> Result<(Behaviour, Option<f64>), FromSettingsError> {
    let value =
        |name: &'static str, value: Option<f64>| value.ok_or_else(|| missing(key.key(name), name));
    let law = match material.law {
        settings::Law::Springs => {
            let stretch_modulus = value("stretch_modulus", material.stretch_modulus)?;
            let constants = SpringConstants {
                stretch_modulus,
                volume_modulus: material.volume_modulus.unwrap_or(0.0),
            };
            return Ok((Behaviour::Springs(constants), Some(stretch_modulus)));
        }
        settings::Law::Corotational => LawName::Corotational,
        settings::Law::StableNeoHookean => LawName::StableNeoHookean,
        settings::Law::NeoHookean => LawName::NeoHookean,
        settings::Law::NeoHookeanPolynomial => LawName::NeoHookeanPolynomial,
        settings::Law::StVenantKirchhoff => LawName::StVenantKirchhoff,
    };
    let young = value("youngs_modulus", material.youngs_modulus)?;
    let constants = ContinuumConstants {
        law,
        young,
        poisson: value("poisson_ratio", material.poisson_ratio)?,
        discretisation: match material.discretisation {
            None | Some(settings::Discretisation::Tetrahedra) => Discretisation::Tetrahedra,
            Some(settings::Discretisation::EdgeSmoothed) => Discretisation::EdgeSmoothed,
            Some(settings::Discretisation::NodeSmoothed) => Discretisation::NodeSmoothed,
            Some(settings::Discretisation::Selective) => Discretisation::Selective,
            Some(settings::Discretisation::NodalPressure) => Discretisation::NodalPressure,
        },
    };
    Ok((Behaviour::Continuum(constants), Some(young)))
}
