//! Static sag on the same mesh with the same material.

use crate::beam::{LAWS, beam, expected, mesh, static_sag};
use microsim_tissue::Discretisation;

/// Issue's tolerance 0.1 %; the reference is printed to six digits and both solutions are exact to more than that, so what
/// differs is only rounding of the meshes' coordinates to nine digits.
const TOLERANCE: f64 = 1e-3;

#[test]
fn the_static_sag_of_every_law_is_that_of_independent_codes() {
    for name in ["S", "M"] {
        let mesh = mesh(name);
        for (law, key) in LAWS {
            let model = beam(&mesh, law, 0.3, Discretisation::Tetrahedra);
            let found = static_sag(&model);
            let expected = expected(&format!("/static/linear_tetrahedra_{key}/{name}"));
            let error = found / expected - 1.0;
            println!("{name} {key}: {found:.7} m, {:+.4} %", error * 100.0);
            assert!(
                error.abs() < TOLERANCE,
                "{name} {key}: {found} instead of {expected}"
            );
        }
    }
}
