//! The step of explicit methods that a body allows at work: at the largest stretch that is to be expected of it.
//!
//! What is here: how far a body is stretched where it lies and by what holds it, and the step for that. What is not: limits of a shape
//! that is given (crate `tissue`, module `stability`), and what looks after the step while a scene runs (`stretch_guard`).

use crate::body::limited_step;
use crate::stretch_guard::TOO_LONG;
use crate::view::BodyView;
use microsim_tissue::stability::{self, WORKING_STRETCH};

impl BodyView<'_> {
    /// How far it is stretched where it lies in the mesh, from its natural state: the mean over its volume of the stretch of lines along x,
    /// y or z, 1/|G⁻¹ e|, the largest of the three. 1 without prestretches.
    pub fn initial_stretch(&self) -> f64 {
        let mesh = self.mesh();
        if mesh.prestretches.is_empty() {
            return 1.0;
        }
        let volumes = mesh.volumes();
        let mut sums = [0.0; 3];
        for (prestretch, volume) in mesh.prestretches.iter().zip(&volumes) {
            // det G · G⁻¹ has the products of the columns of G as its rows.
            let [a, b, c] = [0, 1, 2].map(|k| prestretch.column(k).into_owned());
            let rows = [b.cross(&c), c.cross(&a), a.cross(&b)];
            for (k, sum) in sums.iter_mut().enumerate() {
                let square: f64 = rows.iter().map(|row| row[k] * row[k]).sum();
                *sum += volume * prestretch.determinant() / square.sqrt();
            }
        }
        let total: f64 = volumes.iter().sum();
        sums.into_iter().fold(0.0, f64::max) / total
    }

    /// The largest stretch that the scene prescribes, from the natural state: that of the prestretches times that between what holds the body,
    /// clamps and grips.
    pub fn prescribed_stretch(&self) -> f64 {
        let drawn = self.parts().drive.largest_stretch(self.mean_edge_length());
        self.initial_stretch() * drawn
    }

    /// The stretch at work, from the natural state: [`WORKING_STRETCH`], or what the scene prescribes where that is more.
    pub fn working_stretch(&self) -> f64 {
        self.prescribed_stretch().max(WORKING_STRETCH)
    }

    /// Longest step \[s\] that it would allow if it were [stretched](stability::stretched) by the factor `stretch` from its place in the
    /// mesh, along that axis along which it is the shortest; safety factor included, infinite for a method without a limit.
    pub fn stretched_step(&self, stretch: f64) -> f64 {
        if !self.scene.method.is_explicit() {
            return f64::INFINITY;
        }
        let steps = (0..3).map(|axis| {
            let shape = stability::stretched(self.model(), stretch, axis);
            limited_step(&self.scene.method, self.model(), &shape)
        });
        steps.fold(f64::INFINITY, f64::min)
    }

    /// Longest step \[s\] that it would allow at the [working stretch](Self::working_stretch), along any axis, safety factor included. A
    /// prestretched body is stretched by what it is not stretched already.
    pub fn working_step(&self) -> f64 {
        let further = self.working_stretch() / self.initial_stretch();
        self.stretched_step(further.max(1.0))
    }

    /// The step \[s\] to plan a run with: the [stable one](Self::stable_step) where the safety factor covers what the working stretch adds to
    /// the stiffness, else that at work, with which the run need not be shortened up to there.
    pub fn planned_step(&self) -> f64 {
        let (stable, working) = (self.stable_step(), self.working_step());
        match stable <= TOO_LONG * working {
            true => stable,
            false => working,
        }
    }
}
