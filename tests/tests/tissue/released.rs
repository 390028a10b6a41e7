//! First peak after release, undamped, by an explicit method at a small step.

use crate::beam::{GRAVITY, LAWS, beam, expected, mesh, sag};
use microsim_tissue::{Control, Discretisation, Method, Serial, State, TissueModel, stability};

/// Fraction of the stability limit: the error of the step is then some (hω)²/24 of the slow modes that make the peak, 1e-5.
const SHARE: f64 = 0.3;

/// First peak of the sag \[m\] and its time \[s\]: the largest value before the curve has fallen for 50 ms.
fn first_peak(model: &TissueModel) -> (f64, f64) {
    let mut state = State::at_rest(model);
    let control = Control {
        gravity: GRAVITY,
        ..Control::default()
    };
    let mut solver = Method::StoermerVerlet.solver(model).expect("a solver");
    let h = stability::stable_step(model, SHARE);
    let (mut peak, mut at, mut time) = (0.0, 0.0, 0.0);
    while time < at + 0.05 {
        solver
            .step(model, &mut state, &control, &[], h, &Serial)
            .expect("a step");
        time += h;
        let sag = sag(model, &state);
        if sag > peak {
            (peak, at) = (sag, time);
        }
        assert!(time < 0.5, "a peak comes within half a second");
    }
    (peak, at)
}

#[test]
fn the_first_peak_on_s_is_that_of_independent_codes() {
    let mesh = mesh("S");
    for (law, key) in LAWS {
        let model = beam(&mesh, law, 0.3, Discretisation::Tetrahedra);
        compare("S", key, first_peak(&model));
    }
}

#[test]
fn the_first_peak_on_m_is_that_of_independent_codes() {
    let mesh = mesh("M");
    for (law, key) in &LAWS[..2] {
        let model = beam(&mesh, *law, 0.3, Discretisation::Tetrahedra);
        compare("M", key, first_peak(&model));
    }
}

/// Height and time within 0.5 %, as the issue asks.
fn compare(mesh: &str, key: &str, (peak, time): (f64, f64)) {
    let path = format!("/dynamic_first_peak/linear_tetrahedra_{key}/{mesh}");
    for (what, found) in [("sag_m", peak), ("time_s", time)] {
        let expected = expected(&format!("{path}/{what}"));
        let error = found / expected - 1.0;
        println!("{mesh} {key} {what}: {found:.6}, {:+.3} %", error * 100.0);
        assert!(
            error.abs() < 5e-3,
            "{mesh} {key} {what}: {found} instead of {expected}"
        );
    }
}
