//! The second-order correction of an iteration (Chebyshev–Halley).

use super::equation::Problem;
use super::workspace::NewtonSolver;
use microsim_contact_solver::LinearSystem;
use nalgebra::Vector3;

impl NewtonSolver {
    /// Sets c such that the forces left on the path x + α d + α² c, beyond their linear decrease, are of third order in α:
    /// K c = ½ ∂²r/∂α² along d, from a difference; zero where it is not `wanted`. The residual at the start is retained.
    pub(super) fn set_second_order(&mut self, problem: &Problem<'_>, wanted: bool) {
        if !wanted {
            self.second_order.fill(Vector3::zeros());
            return;
        }
        let options = self.options.second_order;
        let probe = options.probe;
        self.stored.copy_from_slice(&self.residual);
        for (c, r) in self.second_order.iter_mut().zip(&self.residual) {
            *c = r * -2.0;
        }
        for step in [probe, -probe] {
            for ((x, from), d) in self
                .trial
                .positions
                .iter_mut()
                .zip(&self.from)
                .zip(&self.direction)
            {
                *x = from + d * step;
            }
            self.set_velocities(problem);
            self.evaluate(problem, 0.0);
            for (c, r) in self.second_order.iter_mut().zip(&self.residual) {
                *c += r;
            }
        }
        for c in &mut self.second_order {
            *c *= 0.5 / (probe * probe);
        }
        self.residual.copy_from_slice(&self.stored);
        let size = |forces: &[Vector3<f64>]| forces.iter().map(|f| f.norm_squared()).sum::<f64>();
        let curvature = size(&self.second_order);
        let least = options.least_curvature;
        let mut corrects =
            curvature > least * least * size(&self.residual) && curvature.is_finite();
        if corrects {
            let tolerance = options.linear_tolerance;
            let solved = self.system.solve(&mut self.second_order, tolerance).is_ok();
            corrects = solved && size(&self.second_order) < size(&self.direction);
        }
        if !corrects {
            self.second_order.fill(Vector3::zeros());
        }
        self.advance(problem, 0.0);
    }
}
