//! The solutions along the radius: exact where a closed form is known, converged, and the same by different means.

use microsim_tests::vessel::carotid::{
    INNER_RADIUS, OPENED_RADIUS, OPENING, PRESSURE, STRETCH, layers, media,
};
use microsim_tests::vessel::incompressible::pressure_and_force;
use microsim_tests::vessel::layers::Layer;
use microsim_tests::vessel::tube::Tube;
use microsim_tests::vessel::wall::{Invariants, Wall};
use std::f64::consts::{PI, TAU};

/// The matrix alone.
fn matrix(mu: f64, poisson: f64) -> Wall {
    Wall {
        mu,
        lambda: 0.0,
        fibre_stiffness: 0.0,
        fibre_exponent: 1.0,
        fibre_dispersion: 0.0,
        fibre_angle: 0.5,
        invariants: Invariants::Full,
    }
    .with_poisson(poisson)
}

/// Lamé's tube in plane strain, u(r) = p a²/(E (b² − a²)) (1 + ν) ((1 − 2ν) r + b²/r): at a pressure p the relative difference is of the order
/// of the strain, which is p times less than 1 / μ here.
#[test]
fn a_small_pressure_gives_lames_solution() {
    let (a, b, poisson) = (1e-3, 2e-3, 0.3);
    let wall = matrix(1e5, poisson);
    let tube = Tube::new(&[Layer::closed(wall, a, b - a)]);
    let error = |pressure: f64| {
        let found = tube.at_stretch(pressure, 1.0);
        let lame = |r: f64| {
            pressure * a * a / (wall.young() * (b * b - a * a))
                * (1.0 + poisson)
                * ((1.0 - 2.0 * poisson) * r + b * b / r)
        };
        let inner = (found.inside.radius - a) / lame(a) - 1.0;
        let outer = (found.outer_radius() - b) / lame(b) - 1.0;
        // Of both ends of a plane strain: ν (σ_r + σ_θ) = 2 ν p a²/(b² − a²) everywhere.
        let force = 2.0 * poisson * pressure * a * a * PI;
        [inner, outer, found.force / force - 1.0]
    };
    for (small, large) in error(1.0).into_iter().zip(error(1e3)) {
        assert!(small.abs() < 1e-4, "{small}");
        assert!(
            large.abs() < 1e-1 && large.abs() > 100.0 * small.abs(),
            "{large}"
        );
    }
}

/// Incompressible neo-Hookean tube in plane strain, by hand: with Δ = a'² − a² and λ_θ = r/R, p = μ ln((a' b)/(a b')) + μ/2 Δ (1/a'² − 1/b'²)
/// with the sign of the inflated one (Rivlin's tube; from ∫ μ (λ_θ² − 1/λ_θ²)/r dr).
#[test]
fn the_integrals_give_the_closed_form_of_a_neo_hookean_tube() {
    let (a, b, mu) = (1.0e-3, 1.6e-3, 4e3);
    let layer = Layer::closed(matrix(mu, 0.3), a, b - a);
    for inner in [1.05e-3, 1.4e-3, 2.0e-3] {
        let difference = inner * inner - a * a;
        let outer = (b * b + difference).sqrt();
        let closed = mu * libm::log(inner * b / (a * outer))
            + 0.5 * mu * difference * (1.0 / (inner * inner) - 1.0 / (outer * outer));
        let [pressure, _] = pressure_and_force(&[layer], inner, 1.0);
        assert!(
            (pressure / closed - 1.0).abs() < 1e-10,
            "{pressure} {closed}"
        );
    }
}

/// The error of the integrator falls with the fourth power of the step, and at the steps that are used it is below 1e-8 of the radius and of
/// the force.
#[test]
fn the_solution_is_converged() {
    for (poisson, opening, inner) in [(0.45, 0.0, INNER_RADIUS), (0.49, OPENING, OPENED_RADIUS)] {
        let found = |steps: usize| {
            let mut tube = Tube::new(&layers(poisson, inner, opening));
            let usual = tube.steps;
            tube.steps = if steps == 0 { usual } else { steps };
            let wall = tube.at_stretch(PRESSURE, STRETCH);
            [wall.inside.radius, wall.outer_radius(), wall.force]
        };
        let [exact, usual, coarse, fine] = [256, 0, 16, 32].map(found);
        let errors = |of: [f64; 3]| [0, 1, 2].map(|i| of[i] / exact[i] - 1.0);
        let [usual, coarse, fine] = [usual, coarse, fine].map(errors);
        for ((usual, coarse), fine) in usual.into_iter().zip(coarse).zip(fine) {
            let order = libm::log2((coarse / fine).abs());
            println!("{poisson}: {usual:.1e} order {order:.2}");
            assert!((3.5..4.8).contains(&order), "{order}");
            assert!(usual.abs() < 1e-8, "{usual}");
        }
    }
}

/// As ν goes to 1/2 the difference from the incompressible tube goes to zero with the compressibility, (1 − 2ν)/ν · 1/(2μ): a tenth of it, a tenth of
/// the difference. This is the same boundary value problem by other means: shooting there, integrals here.
#[test]
fn nearly_incompressible_tubes_approach_the_incompressible_one() {
    for (opening, inner) in [(0.0, INNER_RADIUS), (OPENING, OPENED_RADIUS)] {
        for along in [1.5, 1.7, 1.9] {
            let differences = [0.4999, 0.49999, 0.499_999].map(|poisson| {
                let layers = layers(poisson, inner, opening);
                let wall = Tube::new(&layers).at_stretch(PRESSURE, along);
                let [pressure, force] = pressure_and_force(&layers, wall.inside.radius, along);
                [pressure / PRESSURE - 1.0, force / wall.force - 1.0]
            });
            for i in 0..2 {
                let of = differences.map(|both| both[i]);
                println!("{along} {of:?}");
                for pair in of.windows(2) {
                    assert!((pair[0] / pair[1] / 10.0 - 1.0).abs() < 0.1, "{of:?}");
                }
                assert!(of[2].abs() < 1e-4, "{of:?}");
            }
        }
    }
}

/// One layer whose ring comes from a sector opens to it without any stress, whatever its law; so does one with axial prestretch, which it loses.
#[test]
fn a_slit_ring_of_one_layer_is_its_natural_sector() {
    let layer = Layer {
        sector: TAU - OPENING,
        prestretch: 1.2,
        ..Layer::closed(media(0.45), 1.43e-3, 0.26e-3)
    };
    let open = Tube::new(&[layer]).slit();
    let near = |found: f64, expected: f64| {
        assert!((found / expected - 1.0).abs() < 1e-8, "{found} {expected}");
    };
    near(open.inside.angle, layer.sector);
    near(open.inside.radius, layer.inner_radius);
    near(open.inside.along, 1.0 / 1.2);
    for point in &open.points {
        assert!(
            point
                .stresses
                .iter()
                .all(|s| s.abs() < 1e-8 * layer.wall.mu)
        );
    }
    // Closed it has stress: pushed inside, pulled outside.
    let closed = Tube::new(&[layer]).at_force(0.0, 0.0);
    let around = [0, closed.points.len() - 1].map(|at| closed.points[at].stresses[1]);
    assert!(around[0] < -500.0 && around[1] > 500.0, "{around:?}");
    assert!(closed.outer_stress.abs() < 1e-6 && closed.force.abs() < 1e-12);
}

/// A thin bimetal: two layers of the same thickness h/2 each and the same modulus, of which one is by ε longer around than the other. Cut open, the strip
/// has the curvature of Timoshenko (1925), 3/2 ε/h more than its natural one; here layers of sectors of 1 and 1 + ε, of a radius 200 times the
/// thickness. The difference is of the order of ε and of h over the radius.
#[test]
fn layers_of_different_length_bend_as_timoshenkos_strip() {
    let (radius, thickness, excess) = (20e-3, 0.1e-3, 1e-3);
    let wall = matrix(1e5, 0.0);
    let half = 0.5 * thickness;
    let mut layers = [0.0, half].map(|from| Layer::closed(wall, radius + from, half));
    layers.iter_mut().for_each(|layer| layer.sector = 3.0);
    layers[0].sector *= 1.0 + excess;
    let open = Tube::new(&layers).slit();
    // The angle over the length of the middle is the curvature.
    let middle = 3.0 * (1.0 + 0.5 * excess) * (radius + half);
    let change = open.inside.angle / middle - 1.0 / (radius + half);
    // The inner layer is the longer one: the strip straightens.
    let expected = -1.5 * excess / thickness;
    println!("{change} {expected}");
    assert!(
        (change / expected - 1.0).abs() < 0.02,
        "{change} {expected}"
    );
}

/// What the paper of Holzapfel, Gasser & Ogden (2000) concludes of the residual stress: with the opening angle the stress around is far more uniform
/// through the media than without, at the mean pressure and an axial stretch of 1.7.
#[test]
fn residual_stress_makes_the_stress_around_more_uniform() {
    let ratio = |inner: f64, opening: f64| {
        let layers = layers(0.4999, inner, opening);
        let wall = Tube::new(&layers).at_stretch(PRESSURE, STRETCH);
        let media: Vec<f64> = wall
            .points
            .iter()
            .filter(|point| point.layer == 0)
            .map(|point| point.stresses[1])
            .collect();
        println!(
            "{opening:.3}: r_i {:.4} mm, r_o {:.4} mm, F {:.4} mN, σ_θ {:.1} to {:.1} kPa",
            wall.inside.radius * 1e3,
            wall.outer_radius() * 1e3,
            wall.force * 1e3,
            media[0] * 1e-3,
            media[media.len() - 1] * 1e-3
        );
        media[0] / media[media.len() - 1]
    };
    let (without, with) = (ratio(INNER_RADIUS, 0.0), ratio(OPENED_RADIUS, OPENING));
    assert!(without > 2.0, "{without}");
    assert!(
        (with - 1.0).abs() < 0.5 * (without - 1.0),
        "{with} {without}"
    );
}
