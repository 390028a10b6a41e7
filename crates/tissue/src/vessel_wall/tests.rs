use super::*;
use crate::law::{HolzapfelParameters, LawName, MaterialLaw};
use microsim_vocabulary::Discretisation;

fn rubber(young: f64, poisson: f64) -> ContinuumConstants {
    ContinuumConstants {
        law: LawName::NeoHookean.into(),
        young,
        poisson,
        discretisation: Discretisation::Tetrahedra,
        plasticity: None,
    }
}

fn layer(radii: [f64; 2], constants: ContinuumConstants, opening_angle: f64) -> WallLayer {
    WallLayer {
        radii,
        constants,
        directions: Default::default(),
        opening_angle,
    }
}

/// Media and adventitia of the rabbit's carotid (Holzapfel, Gasser & Ogden 2000), in place of their own: fibres at ±29° and ±62°.
fn carotid(opening_angle: f64, pressure: f64) -> VesselWall {
    let of = |shear: f64, k1: f64, k2: f64, angle: f64, radii| {
        let law = MaterialLaw::HolzapfelGasserOgden(HolzapfelParameters {
            fibre_stiffness: k1,
            fibre_exponent: k2,
            fibre_dispersion: 0.0,
        });
        let (sine, cosine) = libm::sincos(angle.to_radians());
        WallLayer {
            directions: [sine, -sine].map(|sine| Vector3::new(0.0, cosine, sine)),
            ..layer(
                radii,
                ContinuumConstants {
                    law,
                    ..rubber(2.9 * shear, 0.45)
                },
                opening_angle,
            )
        }
    };
    VesselWall {
        layers: vec![
            of(3.0e3, 2.3632e3, 0.8393, 29.0, [0.7e-3, 0.9e-3]),
            of(0.3e3, 0.5620e3, 0.7112, 62.0, [0.9e-3, 1.0e-3]),
        ],
        axial_stretch: 1.5,
        pressure,
    }
}

/// Nothing stretches it: it is at rest where it lies.
#[test]
fn a_wall_without_load_is_at_rest() {
    let wall = VesselWall {
        layers: vec![layer([1e-3, 2e-3], rubber(1e5, 0.3), 0.0)],
        axial_stretch: 1.0,
        pressure: 0.0,
    };
    let stretches = wall.stretches().unwrap();
    for radius in [1e-3, 1.37e-3, 2e-3] {
        assert!((stretches.at(radius) - Vector3::repeat(1.0)).amax() < 1e-12);
    }
}

/// Lamé's tube in plane strain: λ_θ − 1 = u/r and λ_r − 1 = du/dr of u = (1 + ν)/E · a² p/(b² − a²) ((1 − 2ν) r + b²/r), to the square of the
/// strain.
#[test]
fn small_pressure_is_that_of_lame() {
    let (young, poisson, a, b, pressure) = (1e5, 0.3, 1e-3, 2e-3, 1.0);
    let wall = VesselWall {
        layers: vec![
            layer([a, 1.4e-3], rubber(young, poisson), 0.0),
            layer([1.4e-3, b], rubber(young, poisson), 0.0),
        ],
        axial_stretch: 1.0,
        pressure,
    };
    let stretches = wall.stretches().unwrap();
    let size = (1.0 + poisson) / young * a * a * pressure / (b * b - a * a);
    for r in [a, 1.2e-3, 1.4e-3, 1.7e-3, b] {
        let isotropic = size * (1.0 - 2.0 * poisson);
        let sheared = size * b * b / (r * r);
        let found = stretches.at(r);
        let strain = size * b * b / (a * a);
        assert!((found.x - 1.0 - isotropic + sheared).abs() < 10.0 * strain * strain);
        assert!((found.y - 1.0 - isotropic - sheared).abs() < 10.0 * strain * strain);
    }
}

/// With a pressure p the mean of σ_θθ over the wall is p r_i/(r_o − r_i), whatever the law and the natural state: the force on half a tube.
#[test]
fn hoop_stress_bears_the_pressure() {
    for (opening, pressure) in [(0.0, 0.0), (2.0, 0.0), (0.0, 5e3), (2.8, 13e3)] {
        let wall = carotid(opening, pressure);
        let stretches = wall.stretches().unwrap();
        let mut force = 0.0;
        let mut size = 0.0;
        for layer in &wall.layers {
            let [r0, r1] = layer.radii;
            // Simpson's rule.
            let parts = 2 * STEPS;
            let h = (r1 - r0) / parts as f64;
            for k in 0..=parts {
                let weight = match k {
                    0 => 1.0,
                    _ if k == parts => 1.0,
                    _ if k % 2 == 1 => 4.0,
                    _ => 2.0,
                };
                // The side of the layer at hand, where two meet.
                let r = (r0 + k as f64 * h).clamp(r0 * (1.0 + 1e-12), r1);
                let at = stretches.at(r);
                let hoop = wall.hoop_stress(layer, [at.x, at.y]);
                force += weight * h / 3.0 * hoop;
                size += weight * h / 3.0 * hoop.abs();
            }
        }
        let expected = pressure * wall.layers[0].radii[0];
        // Linear interpolation in the middle of steps: an eighth of the square of their number, times the curvature.
        assert!(
            (force - expected).abs() < 1e-4 * size.max(expected),
            "{force} {expected}"
        );
    }
}

/// A wall that is closed from a sector is compressed along the inside and pulled along the outside; layers meet with one λ_θ.
#[test]
fn closing_a_sector_bends_it() {
    let wall = carotid(2.8, 0.0);
    let stretches = wall.stretches().unwrap();
    let [inside, outside] = [0.7e-3, 1.0e-3].map(|r| stretches.at(r));
    assert!(inside.y < outside.y, "{inside} {outside}");
    let meet = [0.9e-3, 0.9e-3 * (1.0 + 1e-9)].map(|r| stretches.at(r));
    assert!((meet[0].y - meet[1].y).abs() < 1e-6);
}

#[test]
fn what_no_wall_bears_is_refused() {
    // From outside, so that the wall would be crushed.
    assert_eq!(
        carotid(0.0, -1e6).stretches(),
        Err(WallError::NoEquilibrium)
    );
}
