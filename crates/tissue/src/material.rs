//! The spring–volume material: moduli in, stiffness of each element out.
//!
//! Springs carry k = Σ_tets c·E·L0 with c = 2√2/25 (Lloyd, Székely, Harders 2007, for near-regular tetrahedra), volumes
//! E_V = ½ κ V0 (V/V0 − 1)², so k = κ/V0 (NUMERICS 1.1). Both scale with the elements, so that static shapes and λ_max·(edge
//! length)² depend on the moduli and not on the mesh.
//!
//! Limitations: E and κ are the constants of this discrete material, not Young's modulus and bulk modulus of a continuum;
//! a spring network has a Poisson's ratio of its own near ¼, and strong volume forces lock on linear tetrahedra
//! (NUMERICS 1.6).

/// c of k = Σ c·E·L0, 2√2/25.
const SPRING_SHARE: f64 = 0.08 * std::f64::consts::SQRT_2;

/// Values of a [`SpringVolume`] material, not yet checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringVolumeSpec {
    /// Modulus E of the springs [Pa], > 0.
    pub stretch_modulus: f64,
    /// Modulus κ of the volume forces [Pa], ≥ 0.
    pub volume_modulus: f64,
    /// Density [kg/m³], > 0.
    pub density: f64,
    /// Drag per mass c of dv/dt = −c v [1/s], ≥ 0.
    pub drag: f64,
}

/// Springs and volume forces with valid values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringVolume(SpringVolumeSpec);

/// A value outside its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialError {
    /// Which value.
    pub value_name: &'static str,
    /// What was given.
    pub value: f64,
    /// What is allowed, with the unit.
    pub allowed: &'static str,
}

impl std::fmt::Display for MaterialError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} is {}, allowed is {}",
            self.value_name, self.value, self.allowed
        )
    }
}

impl std::error::Error for MaterialError {}

impl SpringVolume {
    /// The material with the moduli of `spec`; refuses values that are not finite or out of range.
    pub fn from_moduli(spec: SpringVolumeSpec) -> Result<Self, MaterialError> {
        let positive = |value_name, value: f64, allowed| {
            let valid = value.is_finite() && value > 0.0;
            if valid {
                Ok(())
            } else {
                Err(MaterialError {
                    value_name,
                    value,
                    allowed,
                })
            }
        };
        let not_negative = |value_name, value: f64, allowed| {
            let valid = value.is_finite() && value >= 0.0;
            if valid {
                Ok(())
            } else {
                Err(MaterialError {
                    value_name,
                    value,
                    allowed,
                })
            }
        };
        positive("stretch_modulus", spec.stretch_modulus, "> 0 Pa")?;
        not_negative("volume_modulus", spec.volume_modulus, ">= 0 Pa")?;
        positive("density", spec.density, "> 0 kg/m³")?;
        not_negative("drag", spec.drag, ">= 0 1/s")?;
        Ok(Self(spec))
    }

    /// The values.
    pub fn spec(&self) -> &SpringVolumeSpec {
        &self.0
    }

    /// Share of one tetrahedron in the stiffness of an edge of length `rest_length` [m]; [N/m].
    pub fn spring_stiffness(&self, rest_length: f64) -> f64 {
        SPRING_SHARE * self.0.stretch_modulus * rest_length
    }

    /// Stiffness of the volume energy of a tetrahedron of `rest_volume` [m³]; [N/m⁵].
    pub fn volume_stiffness(&self, rest_volume: f64) -> f64 {
        self.0.volume_modulus / rest_volume
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_out_of_range_are_named() {
        let good = SpringVolumeSpec {
            stretch_modulus: 2e4,
            volume_modulus: 0.0,
            density: 1060.0,
            drag: 0.0,
        };
        assert!(SpringVolume::from_moduli(good).is_ok());
        for (bad, name) in [
            (
                SpringVolumeSpec {
                    stretch_modulus: 0.0,
                    ..good
                },
                "stretch_modulus",
            ),
            (
                SpringVolumeSpec {
                    volume_modulus: -1.0,
                    ..good
                },
                "volume_modulus",
            ),
            (
                SpringVolumeSpec {
                    density: f64::INFINITY,
                    ..good
                },
                "density",
            ),
            (
                SpringVolumeSpec {
                    drag: f64::NAN,
                    ..good
                },
                "drag",
            ),
        ] {
            assert_eq!(SpringVolume::from_moduli(bad).unwrap_err().value_name, name);
        }
    }

    #[test]
    fn stiffness_follows_numerics_1_1() {
        let spec = SpringVolumeSpec {
            stretch_modulus: 25e3,
            volume_modulus: 5e4,
            density: 1060.0,
            drag: 0.0,
        };
        let material = SpringVolume::from_moduli(spec).unwrap();
        // 2√2/25 · 25 kPa · 1 mm = 2.828… N/m; 50 kPa / 2e-10 m³ = 2.5e14 N/m⁵.
        assert!((material.spring_stiffness(1e-3) - 2.0 * 2f64.sqrt()).abs() < 1e-15 * 3.0);
        assert!((material.volume_stiffness(2e-10) / 2.5e14 - 1.0).abs() < 1e-15);
    }
}
