use super::*;
use crate::law::contract;

/// Moduli of order one, as the contract's.
const FIBRES: HolzapfelParameters = HolzapfelParameters {
    fibre_stiffness: 0.7,
    fibre_exponent: 0.05,
    fibre_dispersion: 0.12,
};

fn constants(lame: Lame, fibres: HolzapfelParameters, angle: f64) -> HolzapfelConstants {
    let (sine, cosine) = libm::sincos(angle);
    let directions = [cosine, -cosine].map(|cosine| Vector3::new(cosine, sine, 0.0));
    HolzapfelGasserOgden::constants(&lame, &fibres).along(directions)
}

#[test]
fn keeps_the_contract() {
    let limits = [0.0, 0.12, 1.0 / 3.0];
    for fibre_dispersion in limits {
        let fibres = HolzapfelParameters {
            fibre_dispersion,
            ..FIBRES
        };
        contract::check_with::<HolzapfelGasserOgden>(&fibres);
        contract::check_with::<HolzapfelGasserOgdenIsochoric>(&fibres);
    }
    // Without an exponent φ is ½ k₁ E².
    let quadratic = HolzapfelParameters {
        fibre_exponent: 0.0,
        ..FIBRES
    };
    contract::check_with::<HolzapfelGasserOgden>(&quadratic);
    contract::check_with::<HolzapfelGasserOgdenIsochoric>(&quadratic);
}

/// Stretches x, y, z along the axes, both families at ±β to x in the plane of x and y: with E = κ (x² + y² + z² − 3) + (1 − 3κ) (x² cos²β + y²
/// sin²β − 1) the fibres add 4 φ' x (κ + (1 − 3κ) cos²β) to P_x, 4 φ' y (κ + (1 − 3κ) sin²β) to P_y and 4 φ' z κ to P_z, φ' = k₁ E exp(k₂ E²);
/// the matrix has μ (s − 1/s) + λ ln J/s. With the isochoric C̄ all of E + 1 has the factor J^(−2/3), and s ∂/∂s of it is that of each
/// stretch less a third of their sum.
#[test]
fn stretches_along_the_axes_have_the_closed_form() {
    let lame = Lame {
        mu: 0.8,
        lambda: 2.5,
    };
    for dispersion in [0.0, 0.12, 1.0 / 3.0] {
        let fibres = HolzapfelParameters {
            fibre_dispersion: dispersion,
            ..FIBRES
        };
        let beta = 0.6;
        let c = constants(lame, fibres, beta);
        let cosine = libm::cos(beta) * libm::cos(beta);
        let aligned = 1.0 - 3.0 * dispersion;
        let weights = [cosine, 1.0 - cosine, 0.0].map(|part| dispersion + aligned * part);
        for stretches in [[1.4_f64, 0.9, 0.8], [1.1, 1.6, 0.7], [0.9, 0.8, 1.3]] {
            let f = Matrix3::from_diagonal(&Vector3::from(stretches));
            let j: f64 = stretches.iter().product();
            let parts: [f64; 3] = std::array::from_fn(|i| weights[i] * stretches[i] * stretches[i]);
            let sum: f64 = parts.iter().sum();
            let force = |e: f64| {
                let bears = f64::from(u8::from(e > 0.0));
                bears * fibres.fibre_stiffness * e * libm::exp(fibres.fibre_exponent * e * e)
            };
            let [full, isochoric] = [
                HolzapfelGasserOgden::stress(&f, &c),
                HolzapfelGasserOgdenIsochoric::stress(&f, &c),
            ];
            let power = libm::pow(j, -2.0 / 3.0);
            for (i, s) in stretches.into_iter().enumerate() {
                let matrix = lame.mu * (s - 1.0 / s) + lame.lambda * libm::log(j) / s;
                let expected = matrix + 4.0 * force(sum - 1.0) * parts[i] / s;
                assert!(
                    (full[(i, i)] - expected).abs() < 1e-14 * 10.0,
                    "{full} {expected}"
                );
                let of_power = power * (parts[i] - sum / 3.0) / s;
                let expected = matrix + 4.0 * force(power * sum - 1.0) * of_power;
                assert!((isochoric[(i, i)] - expected).abs() < 1e-14 * 10.0);
            }
        }
    }
}

/// Fibres that are shortened bear nothing: the stress is that of the matrix, to the bit.
#[test]
fn fibres_bear_no_compression() {
    let lame = Lame::from_young_poisson(1.0, 0.4);
    let fibres = HolzapfelParameters {
        fibre_dispersion: 0.0,
        ..FIBRES
    };
    let c = constants(lame, fibres, 0.0);
    let f = Matrix3::from_diagonal(&Vector3::new(0.9, 1.2, 1.05));
    assert_eq!(
        HolzapfelGasserOgden::stress(&f, &c),
        NeoHookean::stress(&f, &lame)
    );
    assert_eq!(
        HolzapfelGasserOgden::tangent(&f, &c),
        NeoHookean::tangent(&f, &lame)
    );
}

/// Without direction (κ = 1/3) the directions do not matter.
#[test]
fn full_dispersion_is_isotropic() {
    let fibres = HolzapfelParameters {
        fibre_dispersion: 1.0 / 3.0,
        ..FIBRES
    };
    let lame = Lame::from_young_poisson(1.0, 0.4);
    let f = Matrix3::new(1.2, 0.3, -0.1, 0.0, 1.1, 0.2, 0.4, -0.2, 0.9);
    let stresses =
        [0.1, 1.3].map(|angle| HolzapfelGasserOgden::stress(&f, &constants(lame, fibres, angle)));
    assert!((stresses[0] - stresses[1]).amax() < 1e-15 * 8.0);
}

/// A strip pulled to 1.4 along fibres with free sides, at ν = 0.45: with the isochoric C̄ it swells by a third or more, with the full
/// invariants it gains no more than the neo-Hookean matrix alone at this stretch (Nolan et al. 2014, section 4: an unphysical growth of the
/// volume). The sides' stretch q is the root of P_q = 0, found by bisection; with fibres along the pull P_q of the full invariants is that
/// of the matrix.
#[test]
fn fibres_of_the_isochoric_deformation_swell() {
    let lame = Lame::from_young_poisson(3e3 * 2.9, 0.45);
    let fibres = HolzapfelParameters {
        fibre_stiffness: 20e3,
        fibre_exponent: 1.0,
        fibre_dispersion: 0.0,
    };
    let c = constants(lame, fibres, 0.0);
    let volume = |stress: fn(&Matrix3<f64>, &HolzapfelConstants) -> Matrix3<f64>| {
        let (mut low, mut high) = (0.5, 2.0);
        for _ in 0..60 {
            let q = 0.5 * (low + high);
            let f = Matrix3::from_diagonal(&Vector3::new(1.4, q, q));
            match stress(&f, &c)[(1, 1)] > 0.0 {
                true => high = q,
                false => low = q,
            }
        }
        1.4 * low * low
    };
    let full = volume(HolzapfelGasserOgden::stress);
    let isochoric = volume(HolzapfelGasserOgdenIsochoric::stress);
    let matrix = volume(|f, c| NeoHookean::stress(f, &c.lame));
    assert_eq!(full, matrix);
    assert!(full < 1.05 && isochoric > 1.3, "{full} {isochoric}");
}

/// Beyond k₂ E² = 12 energy, stress and tangent go on continuously.
#[test]
fn the_exponential_goes_on_as_a_polynomial() {
    let fibres = HolzapfelParameters {
        fibre_exponent: 3.0,
        ..FIBRES
    };
    let c = constants(Lame::from_young_poisson(1.0, 0.4), fibres, 0.0);
    // E = 2: k₂ E² is 12 exactly.
    let [at, beyond] = [2.0, 2.0 + 1e-14].map(|e| c.exponential(e));
    for (k, (a, b)) in at.iter().zip(beyond).enumerate() {
        // 1e-14 times the next derivative, which is at most 4 k₂ E = 24 times this one and some, and rounding.
        assert!((a - b).abs() < 1e-12 * a, "{k}: {a} {b}");
    }
    assert!(c.exponential(1e6).iter().all(|value| value.is_finite()));
}

#[test]
fn parameters_out_of_range_are_named() {
    assert_eq!(HolzapfelParameters::default().check(0.45), Ok(()));
    let wrong = |fibres: HolzapfelParameters| fibres.check(0.45).unwrap_err().value_name;
    for fibre_stiffness in [-1.0, f64::NAN, f64::INFINITY] {
        let name = wrong(HolzapfelParameters {
            fibre_stiffness,
            ..FIBRES
        });
        assert_eq!(name, "fibre_stiffness");
    }
    for fibre_exponent in [-0.1, 1.1e4, f64::NAN] {
        let name = wrong(HolzapfelParameters {
            fibre_exponent,
            ..FIBRES
        });
        assert_eq!(name, "fibre_exponent");
    }
    for fibre_dispersion in [-0.01, 0.334, f64::NAN] {
        let name = wrong(HolzapfelParameters {
            fibre_dispersion,
            ..FIBRES
        });
        assert_eq!(name, "fibre_dispersion");
    }
}
