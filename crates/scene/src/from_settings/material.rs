//! Materials.

use super::error::{FromSettingsError, missing};
use microsim_settings as settings;
use microsim_tissue::elements::{ContinuumPlasticity, Plasticity};
use microsim_tissue::law::MaterialLaw;
use microsim_tissue::{
    Behaviour, Coefficients, ContinuumConstants, Discretisation, KindConstants, Material,
    SpringConstants, SpringForm, SpringModuli,
};
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

/// How it resists deformation, and its stiffness in uniaxial stretch \[Pa\], where that is known.
fn behaviour(
    material: &settings::Material,
    key: &KeyPath,
) -> Result<(Behaviour, Option<f64>), FromSettingsError> {
    let value =
        |name: &'static str, value: Option<f64>| value.ok_or_else(|| missing(key.key(name), name));
    let law = match material.law {
        settings::Law::Springs => {
            let (form, modulus) = springs(material, &value)?;
            let plasticity = material.plasticity.map(|flow| {
                Ok(Plasticity {
                    yield_strain: flow.yield_strain,
                    creep_rate: flow.creep_rate.ok_or_else(|| {
                        missing(key.key("plasticity").key("creep_rate"), "creep_rate")
                    })?,
                    max_strain: flow.max_strain,
                    hardening: flow.hardening,
                    max_stiffening: flow.max_stiffening,
                })
            });
            let plasticity = plasticity.transpose()?;
            let constants = SpringConstants { form, plasticity };
            return Ok((Behaviour::Springs(constants), modulus));
        }
        settings::Law::Continuum(law) => {
            MaterialLaw::read(law, &|key| value(key, material.parameter(key)))?
        }
    };
    let young = value("youngs_modulus", material.youngs_modulus)?;
    let constants = ContinuumConstants {
        law,
        young,
        poisson: value("poisson_ratio", material.poisson_ratio)?,
        discretisation: material
            .discretisation
            .unwrap_or(Discretisation::Tetrahedra),
        plasticity: material.plasticity.map(|flow| ContinuumPlasticity {
            yield_strain: flow.yield_strain,
            yield_growth: flow.yield_growth.unwrap_or(0.0),
            creep_rate: flow.creep_rate,
            max_strain: flow.max_strain,
            hardening: flow.hardening,
            max_stiffening: flow.max_stiffening,
        }),
    };
    Ok((Behaviour::Continuum(constants), Some(young)))
}

/// The constants of springs, and their modulus \[Pa\], where they have one.
fn springs(
    material: &settings::Material,
    value: &dyn Fn(&'static str, Option<f64>) -> Result<f64, FromSettingsError>,
) -> Result<(SpringForm, Option<f64>), FromSettingsError> {
    let coefficients = |stiffness: Option<f64>, damping: Option<f64>| Coefficients {
        stiffness: stiffness.unwrap_or(0.0),
        damping: damping.unwrap_or(0.0),
    };
    let constants = KindConstants {
        length: coefficients(material.length_stiffness, material.length_damping),
        area: coefficients(material.area_stiffness, material.area_damping),
        volume: coefficients(material.volume_stiffness, material.volume_damping),
    };
    Ok(match material.form {
        None | Some(settings::SpringForm::Scaled) => {
            let stretch = value("stretch_modulus", material.stretch_modulus)?;
            let moduli = SpringModuli {
                stretch,
                area: material.area_modulus.unwrap_or(0.0),
                volume: material.volume_modulus.unwrap_or(0.0),
            };
            (
                SpringForm::Scaled(moduli),
                Some(stretch).filter(|s| *s > 0.0),
            )
        }
        Some(settings::SpringForm::Plain) => (SpringForm::Plain(constants), None),
        Some(settings::SpringForm::Normalised) => (SpringForm::Normalised(constants), None),
        Some(settings::SpringForm::Fitted) => {
            let young = value("youngs_modulus", material.youngs_modulus)?;
            let poisson = value("poisson_ratio", material.poisson_ratio)?;
            (SpringForm::Fitted { young, poisson }, Some(young))
        }
    })
}
