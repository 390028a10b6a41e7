//! Blades: a sheet at rest, or a segment in motion.

use crate::report::Rejected;
use crate::sheet::Sheet;
use crate::sweep::Sweep;
use nalgebra::Vector3;

/// A blade and the nodes around it.
#[derive(Clone, Copy, Debug)]
pub enum Blade<'a> {
    /// A sheet through nodes that stand still.
    Sheet {
        /// The sheet.
        sheet: &'a Sheet,
        /// Where the nodes are \[m\].
        positions: &'a [Vector3<f64>],
    },
    /// A blade that moves, through nodes that move.
    Sweep {
        /// Its parts: of one instrument, on one sheet.
        sweeps: &'a [Sweep],
        /// Where the nodes were before the step \[m\].
        before: &'a [Vector3<f64>],
        /// Where they are after it \[m\].
        now: &'a [Vector3<f64>],
    },
}

impl Blade<'_> {
    pub(crate) fn now(&self) -> &[Vector3<f64>] {
        match self {
            Self::Sheet { positions, .. } => positions,
            Self::Sweep { now, .. } => now,
        }
    }

    pub(crate) fn check(&self, nodes: usize) -> Result<(), Rejected> {
        let all = |points: &[Vector3<f64>]| points.iter().all(|p| p.iter().all(|x| x.is_finite()));
        let count = |positions: &[Vector3<f64>]| {
            let count = positions.len();
            if count == nodes {
                Ok(())
            } else {
                Err(Rejected::Positions {
                    nodes,
                    positions: count,
                })
            }
        };
        match self {
            Self::Sheet { sheet, positions } => {
                count(positions)?;
                if !all(&sheet.points) {
                    return Err(Rejected::NotFinite);
                }
                let has_area = |t: usize| {
                    let [a, b, c] = sheet.corners(t);
                    (b - a).cross(&(c - a)) != Vector3::zeros()
                };
                if !(0..sheet.triangles.len()).any(has_area) {
                    return Err(Rejected::NoBlade);
                }
            }
            Self::Sweep {
                sweeps,
                before,
                now,
            } => {
                count(before)?;
                count(now)?;
                let finite = |s: &Sweep| all(&s.before) && all(&s.now);
                if !sweeps.iter().all(finite) {
                    return Err(Rejected::NotFinite);
                }
                let has_length = |[a, b]: &[Vector3<f64>; 2]| a != b;
                let is_blade = |s: &Sweep| has_length(&s.before) || has_length(&s.now);
                if !sweeps.iter().any(is_blade) {
                    return Err(Rejected::NoBlade);
                }
            }
        }
        Ok(())
    }
}
