//! Our methods. One more is one line in [`ENTRIES`].

use crate::beam::{Beam, FEW, MESHES, mesh};
use crate::exact;
use crate::measure::{first_peak, repeated, to_rest};
use crate::row::Row;
use microsim_tissue::law::LawName;
use microsim_tissue::{Discretisation, Method, Newton, stability};

/// Its name in the table.
pub const ENGINE: &str = "ours";

/// Steps of a method.
enum Steps {
    /// In milliseconds.
    Milliseconds(&'static [f64]),
    /// At a fraction of the stability limit of explicit methods.
    OfLimit(f64),
}

/// What is measured.
#[derive(Clone, Copy, PartialEq)]
enum What {
    Peak,
    Rest,
}

use Steps::{Milliseconds, OfLimit};
use What::{Peak, Rest};

/// A method with all that belongs to it: its name and settings in the table, what it is measured for, meshes, steps, law and
/// discretisation.
struct Entry {
    name: &'static str,
    settings: &'static str,
    method: Method,
    what: What,
    /// Meshes, by their first letters.
    meshes: &'static str,
    steps: Steps,
    law: LawName,
    discretisation: Discretisation,
}

impl Entry {
    /// Linear tetrahedra, stable neo-Hookean.
    const fn new(
        name: &'static str,
        settings: &'static str,
        method: Method,
        what: What,
        meshes: &'static str,
        steps: Steps,
    ) -> Self {
        Self {
            name,
            settings,
            method,
            what,
            meshes,
            steps,
            law: LawName::StableNeoHookean,
            discretisation: Discretisation::Tetrahedra,
        }
    }

    const fn law(mut self, law: LawName) -> Self {
        self.law = law;
        self
    }

    const fn discretisation(mut self, discretisation: Discretisation) -> Self {
        self.discretisation = discretisation;
        self
    }
}

const ONE: &str = "one Newton iteration per step, conjugate gradients after an f32 factor or on two levels, by size";
const DIRECT: &str =
    "Newton's method, conjugate gradients after an f32 factor or on two levels, by size";
const POLYNOMIAL: &str = "law neo-hookean-polynomial, of which its constraints are made";

const SHORT: Steps = Milliseconds(&[5.0]);
const LONG: Steps = Milliseconds(&[10.0, 15.0, 20.0, 22.0]);
const REST: Steps = Milliseconds(&[100.0, 200.0, 500.0, 1000.0]);

#[rustfmt::skip]
const ENTRIES: &[Entry] = &[
    Entry::new("stoermer-verlet", "0.9 of the stability limit", Method::StoermerVerlet, Peak, "SML", OfLimit(0.9)),
    Entry::new("implicit-midpoint", ONE, Method::ImplicitMidpoint(newton(1)), Peak, "SM", SHORT),
    Entry::new("implicit-midpoint", ONE, Method::ImplicitMidpoint(newton(1)), Peak, "SML", LONG),
    Entry::new("guarded-midpoint", ONE, Method::GuardedMidpoint(newton(1)), Peak, "SML", LONG),
    Entry::new("implicit-midpoint (St Venant–Kirchhoff)", ONE, Method::ImplicitMidpoint(newton(1)), Peak, "SML", LONG)
        .law(LawName::StVenantKirchhoff),
    Entry::new("sdirk2", ONE, Method::Sdirk2(newton(1)), Peak, "SM", LONG),
    Entry::new("implicit-euler", ONE, Method::ImplicitEuler(newton(1)), Peak, "SML", LONG),
    Entry::new("implicit-euler", ONE, Method::ImplicitEuler(newton(1)), Rest, "SML", REST),
    Entry::new("quasi-static, 2 iterations", DIRECT, Method::QuasiStatic(newton(2)), Rest, "SML", Milliseconds(&[100.0])),
    Entry::new("quasi-static, 3 iterations", DIRECT, Method::QuasiStatic(newton(3)), Rest, "SML", Milliseconds(&[100.0])),
    Entry::new("xpbd, 1 iteration", POLYNOMIAL, xpbd(1), Peak, "SM", Milliseconds(&[0.1, 0.2, 0.4])).law(LawName::NeoHookeanPolynomial),
    Entry::new("xpbd, 1 iteration", POLYNOMIAL, xpbd(1), Peak, "L", Milliseconds(&[0.1, 0.2])).law(LawName::NeoHookeanPolynomial),
    Entry::new("xpbd, 10 iterations", POLYNOMIAL, xpbd(10), Peak, "SM", Milliseconds(&[1.0])).law(LawName::NeoHookeanPolynomial),
    Entry::new("implicit-midpoint, edge-smoothed", ONE, Method::ImplicitMidpoint(newton(1)), Peak, "SM", Milliseconds(&[10.0]))
        .discretisation(Discretisation::EdgeSmoothed),
    Entry::new("implicit-midpoint, quadratic-pressure", ONE, Method::ImplicitMidpoint(newton(1)), Peak, "3456", Milliseconds(&[10.0, 20.0]))
        .law(LawName::StVenantKirchhoff).discretisation(Discretisation::QuadraticPressure),
    Entry::new("implicit-midpoint, quadratic-pressure", ONE, Method::ImplicitMidpoint(newton(1)), Peak, "8", Milliseconds(&[5.0, 10.0]))
        .law(LawName::StVenantKirchhoff).discretisation(Discretisation::QuadraticPressure),
    Entry::new("quasi-static, quadratic-pressure", DIRECT, Method::QuasiStatic(newton(3)), Rest, "568", Milliseconds(&[100.0]))
        .law(LawName::StVenantKirchhoff).discretisation(Discretisation::QuadraticPressure),
];

/// Newton's method of a number of iterations, converged or not.
const fn newton(iterations: u32) -> Newton {
    Newton {
        iterations,
        tolerance: 1e-6,
        must_converge: false,
    }
}

/// XPBD of a number of iterations per step.
const fn xpbd(iterations: u32) -> Method {
    Method::Xpbd {
        substeps: 1,
        iterations,
    }
}

/// CPU time \[s\] after which a run that does not come to rest is given up, by default and if everything is asked for.
const CAPS: [f64; 2] = [60.0, 600.0];

/// Measures all methods.
pub fn measure(all: bool) -> Vec<Row> {
    let mut rows = Vec::new();
    for name in MESHES.into_iter().chain(FEW) {
        let mesh = mesh(name);
        for entry in ENTRIES.iter().filter(|entry| entry.meshes.contains(name)) {
            let beam = Beam::new(&mesh, entry.law, entry.discretisation);
            let steps = match entry.steps {
                Milliseconds(steps) => steps.iter().map(|step| step * 1e-3).collect(),
                OfLimit(share) => vec![stability::stable_step(&beam.model, share)],
            };
            for step in steps {
                for row in run(entry, name, &beam, step, CAPS[usize::from(all)]) {
                    crate::say(&row);
                    rows.push(row);
                }
            }
        }
    }
    rows
}

/// The row of a run; of a quasi-static one also the row in which the analysis of the mesh counts, which is made once.
fn run(entry: &Entry, mesh: &str, beam: &Beam, step: f64, cap: f64) -> Vec<Row> {
    let own = entry.discretisation != Discretisation::Tetrahedra;
    let mut row = Row {
        engine: ENGINE.into(),
        version: env!("CARGO_PKG_VERSION").into(),
        method: entry.name.into(),
        mesh: mesh.into(),
        step,
        asks: [entry.what == Peak, entry.what == Rest],
        settings: format!("{}; {}", entry.law.name(), entry.settings),
        ..Row::default()
    };
    let exact = if own {
        // Another discretisation has other exact solutions; what it adds and what it removes is told together.
        row.method = match FEW.contains(&mesh) {
            true => format!("{}, {mesh} × 1 × 1 cells", entry.name),
            false => format!("{}, mesh {mesh}", entry.name),
        };
        row.mesh = exact::BEAM.1.into();
        row.settings += "; errors are against the exact beam";
        exact::read(exact::BEAM.0, exact::BEAM.1)
    } else {
        exact::read(entry.law.name(), mesh)
    };
    let mut with_analysis = None;
    let measured = match entry.what {
        Peak => repeated(
            || first_peak(beam, &entry.method, step),
            |peak| peak.cpu_s_per_s,
        )
        .map(|peak| {
            row.cpu_s_per_s = Some(peak.cpu_s_per_s);
            row.peak_error = Some(peak.height / exact.peak - 1.0);
            row.peak_time_error = Some(peak.time / exact.time - 1.0);
        }),
        Rest => {
            let run = || to_rest(beam, &entry.method, step, &exact, cap);
            repeated(run, |rest| rest.cpu_s.unwrap_or(f64::INFINITY)).map(|rest| {
                row.cpu_s_to_rest = rest.cpu_s;
                row.rest_error = Some(rest.error);
                if rest.cpu_s.is_none() {
                    row.note = "not at rest in the time given".into();
                }
                with_analysis = rest.cpu_s.map(|cpu_s| cpu_s + rest.analysis_s);
            })
        }
    };
    if let Err(why) = measured {
        row.note = why;
    }
    let mut rows = vec![row];
    if let (Method::QuasiStatic(_), Some(cpu_s)) = (entry.method, with_analysis) {
        rows.push(Row {
            method: format!("{} and the analysis of the mesh", entry.name),
            cpu_s_to_rest: Some(cpu_s),
            ..rows[0].clone()
        });
    }
    rows
}
