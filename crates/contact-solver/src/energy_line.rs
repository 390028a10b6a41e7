//! The energy of a linearised step, ½ dᵀ K d − r·d + Σ ψ(Σ w d), along a line of displacements: that of all contacts, closed or open.

use crate::contact::Contact;
use crate::row::Row;
use crate::vectors::{convex_search, dot};
use nalgebra::Vector3;

/// The displacements `from` + length · `step`, for lengths from 0 to 1.
pub(crate) struct EnergyLine<'a> {
    contacts: &'a [Contact],
    rows: &'a [Row],
    from: &'a [Vector3<f64>],
    step: &'a [Vector3<f64>],
    /// Work of the forces r − K d at the start, without contacts, along the step \[J\].
    work: f64,
    /// Work of K step along the step \[J\].
    stiffness: f64,
}

impl<'a> EnergyLine<'a> {
    /// `left` is r − K d at the start, `product` K step; both without contacts \[N\].
    pub fn new(
        (contacts, rows): (&'a [Contact], &'a [Row]),
        [from, step]: [&'a [Vector3<f64>]; 2],
        [left, product]: [&[Vector3<f64>]; 2],
    ) -> Self {
        Self {
            contacts,
            rows,
            from,
            step,
            work: dot(left, step),
            stiffness: dot(step, product),
        }
    }

    /// The contacts that can move something, with the motions of their sides to the start of the line and along it.
    fn acting(&self) -> impl Iterator<Item = (&Contact, &Row, [Vector3<f64>; 2])> {
        let all = self.contacts.iter().zip(self.rows);
        all.filter(|(_, row)| row.penalty > 0.0)
            .map(|(contact, row)| {
                let motions = [self.from, self.step].map(|of| contact.interpolate(of));
                (contact, row, motions)
            })
    }

    /// Derivative of the energy by the length \[J\].
    pub fn slope_at(&self, length: f64) -> f64 {
        let mut slope = length * self.stiffness - self.work;
        for (contact, row, [from, motion]) in self.acting() {
            let y = from + motion * length;
            slope -= row.force_at(contact, &y).dot(&motion);
        }
        slope
    }

    /// Whether the energy is higher at the end than at the start, by more than `rounding` of its terms, or is not finite there.
    pub fn rises(&self, rounding: f64) -> bool {
        let mut change = 0.5 * self.stiffness - self.work;
        let mut terms = 0.5 * self.stiffness + self.work.abs();
        for (contact, row, [from, motion]) in self.acting() {
            let [before, after] = [from, from + motion].map(|y| row.law(contact, &y).1);
            change += after - before;
            terms += after + before;
        }
        let is_no_rise = change <= rounding * terms && terms.is_finite();
        !is_no_rise
    }

    /// The length at which the energy is lowest: 1, but where contacts that the step closes or opens matter. `start` is the slope at length 0 \[J\];
    /// 1 is taken where the slope there is at most `flat` of it.
    pub fn lowest(&self, start: f64, flat: f64, bisections: u32) -> f64 {
        convex_search(start, flat, bisections, |length| self.slope_at(length))
    }
}
