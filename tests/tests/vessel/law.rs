//! The laws of walls against closed forms along r, θ, z, and against differences of their energy at any deformation.

use microsim_tests::vessel::carotid;
use microsim_tests::vessel::wall::{Invariants, Wall};
use microsim_tissue::law::{HolzapfelParameters, Lame, LawName, MaterialLaw};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// What elements are given for a wall.
pub fn law_of(wall: &Wall) -> MaterialLaw {
    let parameters = HolzapfelParameters {
        fibre_stiffness: wall.fibre_stiffness,
        fibre_exponent: wall.fibre_exponent,
        fibre_dispersion: wall.fibre_dispersion,
    };
    match wall.invariants {
        Invariants::Full => MaterialLaw::HolzapfelGasserOgden(parameters),
        Invariants::Isochoric => MaterialLaw::HolzapfelGasserOgdenIsochoric(parameters),
    }
}

/// The two fibre directions by r, θ, z.
pub fn directions(wall: &Wall) -> [Vector3<f64>; 2] {
    let (sine, cosine) = libm::sincos(wall.fibre_angle);
    [
        Vector3::new(0.0, cosine, sine),
        Vector3::new(0.0, cosine, -sine),
    ]
}

fn walls() -> Vec<Wall> {
    let mut walls = Vec::new();
    for wall in [carotid::media(0.49), carotid::adventitia(0.45)] {
        for invariants in [Invariants::Full, Invariants::Isochoric] {
            for fibre_dispersion in [0.0, 0.1, 0.226, 1.0 / 3.0] {
                walls.push(Wall {
                    fibre_dispersion,
                    invariants,
                    ..wall
                });
            }
        }
    }
    walls
}

fn lame(wall: &Wall) -> Lame {
    Lame {
        mu: wall.mu,
        lambda: wall.lambda,
    }
}

/// Rotations before and after the stretches.
fn frames() -> [[Matrix3<f64>; 2]; 2] {
    let turned = |x: f64, y: f64, z: f64| *Rotation3::from_euler_angles(x, y, z).matrix();
    [
        [Matrix3::identity(); 2],
        [turned(0.3, -1.1, 2.0), turned(-0.8, 0.4, 0.9)],
    ]
}

/// Stress at stretches along r, θ, z, with the material turned by one rotation and the result by another.
fn nominal(wall: &Wall, stretches: [f64; 3], [before, after]: &[Matrix3<f64>; 2]) -> Matrix3<f64> {
    let f = after * Matrix3::from_diagonal(&stretches.into()) * before.transpose();
    let fibres = directions(wall).map(|a| before * a);
    let stress = law_of(wall).stress(&f, &lame(wall), fibres);
    after.transpose() * stress * before
}

/// Along the axes of stretch, slack and taut, to 1e-8 of the largest stress: the difference is rounding.
fn assert_nominal(wall: &Wall, stretches: [f64; 3]) {
    let expected = Matrix3::from_diagonal(&wall.nominal(stretches).into());
    for frame in frames() {
        let found = nominal(wall, stretches, &frame);
        let error = (found - expected).amax();
        // Of a stress that is zero by equilibrium the stiffness is the scale.
        let scale = expected.amax().max(wall.mu + wall.lambda);
        assert!(
            error < 1e-8 * scale,
            "{wall:?} {stretches:?}: {found} {expected}"
        );
    }
}

#[test]
fn stresses_are_those_of_the_closed_forms() {
    for wall in walls() {
        for radial in [0.4, 0.8, 1.1] {
            for around in [0.7, 1.0, 1.3, 1.6] {
                for along in [0.8, 1.2, 1.7] {
                    assert_nominal(&wall, [radial, around, along]);
                }
            }
        }
    }
}

/// Pulled around or along alone, the sides free: the stretches of the sides are solved from the closed forms, and the law leaves no stress there.
#[test]
fn uniaxial_and_biaxial_tension_are_the_closed_forms() {
    for wall in walls() {
        for stretch in [0.8, 0.95, 1.05, 1.2, 1.4, 1.6] {
            assert_nominal(&wall, wall.uniaxial(1, stretch));
            assert_nominal(&wall, wall.uniaxial(2, stretch));
            for along in [0.9, 1.2, 1.5] {
                assert_nominal(&wall, wall.biaxial(stretch, along));
            }
        }
    }
}

/// Ψ at any F, by its definition.
fn energy(wall: &Wall, f: &Matrix3<f64>) -> f64 {
    let c = f.tr_mul(f);
    let (volume, kappa) = (f.determinant(), wall.fibre_dispersion);
    let log = libm::log(volume);
    let scale = match wall.invariants {
        Invariants::Full => 1.0,
        Invariants::Isochoric => libm::pow(volume, -2.0 / 3.0),
    };
    let families = directions(wall).map(|a| {
        let square = scale * a.dot(&(c * a));
        let strain = kappa * (scale * c.trace() - 3.0) + (1.0 - 3.0 * kappa) * (square - 1.0);
        // Differences across the place where fibres become taut are no derivatives.
        assert!(strain.abs() > 0.03, "{wall:?} {f}");
        let taut = strain.max(0.0);
        let (k1, k2) = (wall.fibre_stiffness, wall.fibre_exponent);
        k1 / (2.0 * k2) * libm::expm1(k2 * taut * taut)
    });
    0.5 * wall.mu * (c.trace() - 3.0) - wall.mu * log
        + 0.5 * wall.lambda * log * log
        + families[0]
        + families[1]
}

/// With shear, where each family has a strain of its own: central differences of sixth order. Their error is h⁶/140 of the seventh derivative,
/// which the exponential makes some 1e5 times the stress, and rounding, 1e-16 of the energy over h.
#[test]
fn stresses_are_derivatives_of_the_energy_at_any_deformation() {
    let h = 2e-3;
    let deformations = [
        Matrix3::new(0.8, 0.2, -0.1, 0.1, 1.2, 0.5, 0.0, -0.2, 1.3),
        Matrix3::new(1.6, 0.0, 0.1, -0.1, 0.6, -0.1, 0.1, 0.05, 0.65),
    ];
    for wall in walls() {
        for f in deformations {
            let stress = law_of(&wall).stress(&f, &lame(&wall), directions(&wall));
            for place in 0..9 {
                let odd = |steps: f64| {
                    let at = |steps: f64| {
                        let mut moved = f;
                        moved[place] += steps * h;
                        energy(&wall, &moved)
                    };
                    at(steps) - at(-steps)
                };
                let difference = (45.0 * odd(1.0) - 9.0 * odd(2.0) + odd(3.0)) / (60.0 * h);
                let error = (difference - stress[place]).abs();
                assert!(
                    error < 1e-8 * stress.amax(),
                    "{wall:?} {place}: {error} {stress}"
                );
            }
        }
    }
}

/// Both are laws that a file can name.
#[test]
fn the_laws_have_their_names() {
    for (invariants, name) in [
        (Invariants::Full, LawName::HolzapfelGasserOgden),
        (
            Invariants::Isochoric,
            LawName::HolzapfelGasserOgdenIsochoric,
        ),
    ] {
        let wall = Wall {
            invariants,
            ..carotid::media(0.49)
        };
        assert_eq!(law_of(&wall).name(), name);
    }
}
