//! Saving in the middle of a cut.

use super::*;
use microsim_tissue::law::LawName;

/// The bar with a helix of fibres around its axis.
fn fibrous_bar() -> BodySpec {
    let mut body = bar(Discretisation::Selective, 0.0);
    if let Behaviour::Continuum(constants) = &mut body.materials[0].1.behaviour {
        constants.law = LawName::HolzapfelGasserOgden.into();
    }
    let mesh = &mut body.mesh;
    let centre = |element| mesh.corners(element).iter().sum::<Vector3<f64>>() / 4.0;
    let around = |place: Vector3<f64>| {
        (Vector3::x().cross(&place) + place.norm() * Vector3::x()).normalize()
    };
    mesh.directions = (0..mesh.tets.len())
        .map(|element| [around(centre(element)), Vector3::z()])
        .collect();
    body
}

/// Saved at each tick of a cut and restored, into the same scene and into a new one, it goes on with the same bits, with fibres and
/// without; reset, it begins again.
#[test]
fn a_cut_that_is_under_way_is_saved() {
    for (body, method) in [
        (
            bar(Discretisation::EdgeSmoothed, 0.0),
            Method::StoermerVerlet,
        ),
        (
            bar(Discretisation::EdgeSmoothed, 0.0),
            Method::ImplicitEuler(NEWTON),
        ),
        (fibrous_bar(), Method::StoermerVerlet),
        (fibrous_bar(), Method::ImplicitEuler(NEWTON)),
    ] {
        let of = spec(
            body,
            tool("blade", 0.0, vec![line(5e-5, None)]),
            false,
            method,
        );
        let fresh = || Scene::new(&of).unwrap();
        let mut scene = fresh();
        let start = scene.save();
        let steps = scene.required_steps(1e-3);
        let height = |k: usize| 1e-3 - 1e-4 * k as f64;
        let motion = |k| [down(0.37e-3, [height(k), height(k + 1)], [0.0; 2])];
        let mut saved = Vec::new();
        for k in 0..20 {
            saved.push(scene.save());
            scene.tick(&motion(k), 1e-3, steps, &Serial).unwrap();
        }
        let (end, digest) = (scene.save(), scene.digest());
        assert!(scene.body(0).piece_count() == 2 && end.len() > start.len());
        for from in [3, 7, 12] {
            let mut again = fresh();
            again.restore(&saved[from]).unwrap();
            assert_eq!(again.save(), saved[from], "tick {from}");
            for k in from..20 {
                again.tick(&motion(k), 1e-3, steps, &Serial).unwrap();
            }
            assert_eq!(again.save(), end, "from tick {from}");
            assert_eq!(again.digest(), digest, "from tick {from}");
        }
        scene.restore(&saved[12]).unwrap();
        assert_eq!(scene.save(), saved[12]);
        for damaged in [&end[..end.len() - 1], &end[..40]] {
            assert!(scene.restore(damaged).is_err());
            assert_eq!(scene.save(), saved[12]);
        }
        scene.reset();
        assert_eq!(scene.save(), start);
    }
}
