//! The stability atlas: how large a step may be, measured against predicted; what methods without a limit do to a motion; the
//! remedies for bad elements; and how a beam recovers from shapes that no load makes.
//!
//! What is here: the measurements, their tables as CSV and Markdown, heat maps as SVG, one page as HTML. What is not: files, and
//! clocks (a function that the caller brings gives CPU time). Everything but CPU times has the same bits on every machine.

mod figures;
mod heat_map;
mod large_steps;
mod limits;
mod page;
mod recovery;
mod recovery_figures;
mod remedies;
mod schemes;
mod subject;
mod tables;

pub use heat_map::{Field, HeatMap};
pub use large_steps::{LargeStep, Start};
pub use limits::{Limit, Measured, predicted};
pub use recovery::{Damage, Outcome, Recovery, Scheme, StepLength, recover};
pub use remedies::{Remedied, Remedy};
pub use subject::{Constants, Subject, Substance, Variation};

use microsim_tissue::Method;

/// Measured and exactly predicted limits may differ by this relative amount.
pub const TOLERANCE: f64 = 0.03;

/// All that was measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Atlas {
    /// Largest stable steps.
    pub limits: Vec<Limit>,
    /// Methods without a limit, far beyond that of the others.
    pub large_steps: Vec<LargeStep>,
    /// Remedies for bad elements.
    pub remedies: Vec<Remedied>,
    /// Recovery of the beam.
    pub recoveries: Vec<Recovery>,
}

/// How much of the atlas is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Everything: some minutes.
    Full,
    /// One or two of each kind: less than a minute.
    Short,
}

impl Atlas {
    /// Measures everything. `clock` gives CPU time \[s\]; `progress` is called with the part that is over, by number of parts, and with what is
    /// being done.
    pub fn make(
        extent: Extent,
        clock: &dyn Fn() -> f64,
        progress: &mut dyn FnMut(f64, &str),
    ) -> Self {
        let mut atlas = Self::default();
        let (substances, variations) = match extent {
            Extent::Full => (Substance::all(), &Variation::ALL[..]),
            Extent::Short => (Substance::few(), &Variation::FEW[..]),
        };
        let stepped = match extent {
            Extent::Full => large_steps::substances(),
            Extent::Short => vec![Substance::SpringsVolumes],
        };
        let remedied = Substance::few();
        let schemes = match extent {
            Extent::Full => schemes::all(),
            Extent::Short => schemes::few(),
        };
        let all = substances.len() + stepped.len() + remedied.len() + schemes.len();
        let mut begun = 0;
        let mut begins = |what: &str| {
            progress(f64::from(begun) / all as f64, what);
            begun += 1;
        };
        for substance in substances {
            begins(&format!("limits of {}", substance.name()));
            atlas.limits.extend(limits(substance, variations));
        }
        for substance in stepped {
            begins(&format!("large steps of {}", substance.name()));
            if let Ok(subject) = Subject::new(substance, Variation::Plain) {
                let runs = large_steps::large_steps(substance, &subject, &Start::ALL);
                atlas.large_steps.extend(runs);
            }
        }
        for substance in remedied {
            begins(&format!("remedies for {}", substance.name()));
            for variation in [Variation::Layer(0.03), Variation::Node(0.03)] {
                atlas
                    .remedies
                    .extend(remedies::remedies(substance, variation));
            }
        }
        for (index, scheme) in schemes.iter().enumerate() {
            begins(&format!(
                "recovery {} of {}: {}",
                index + 1,
                schemes.len(),
                scheme.name()
            ));
            atlas
                .recoveries
                .extend(recover(scheme, &Damage::ALL, clock));
        }
        atlas
    }

    /// Number of limits with an exact prediction, number of those that agree with it, and the largest relative difference.
    pub fn agreement(&self) -> (usize, usize, f64) {
        let compared = || {
            self.limits
                .iter()
                .filter_map(|limit| limit.agrees(TOLERANCE).map(|agrees| (limit, agrees)))
        };
        let agreeing = compared().filter(|(_, agrees)| *agrees).count();
        let differences = compared()
            .filter_map(|(limit, _)| limit.ratio())
            .map(|ratio| (ratio - 1.0).abs());
        (
            compared().count(),
            agreeing,
            differences.fold(0.0, f64::max),
        )
    }
}

/// The limits of all methods on the blocks of one substance.
pub fn limits(substance: Substance, variations: &[Variation]) -> Vec<Limit> {
    let mut found = Vec::new();
    for &variation in variations
        .iter()
        .filter(|variation| variation.concerns(substance))
    {
        if let Ok(subject) = Subject::new(substance, variation) {
            found.extend(
                limits::methods()
                    .filter_map(|method| Limit::find(method, substance, variation, &subject)),
            );
        }
    }
    found
}

/// A method with what distinguishes it from others of its name.
pub fn method_name(method: &Method) -> String {
    let plural = |n: u32, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    match method {
        Method::ImplicitEuler(newton)
        | Method::ImplicitMidpoint(newton)
        | Method::GuardedMidpoint(newton)
        | Method::Sdirk2(newton)
        | Method::QuasiStatic(newton) => match newton.iterations {
            1 => format!("{}, 1 iteration", method.name()),
            _ => method.name().into(),
        },
        Method::Xpbd {
            substeps,
            iterations,
        } => format!(
            "xpbd, {}, {}",
            plural(*substeps, "sub-step"),
            plural(*iterations, "iteration")
        ),
        _ => method.name().into(),
    }
}

#[cfg(test)]
mod tests;
