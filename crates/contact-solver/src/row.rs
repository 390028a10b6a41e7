//! The augmented Lagrangian of one contact: force, energy and curvature when its sides have come closer.

use crate::contact::Contact;
use nalgebra::{Matrix3, Vector3};

/// A contact as an iteration sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// ρ \[N/m\]; 0 for a contact that can move nothing.
    pub penalty: f64,
    /// k \[N/m\].
    pub tangential_penalty: f64,
    /// λ \[N\].
    pub multiplier: f64,
    /// t \[N\].
    pub friction_multiplier: Vector3<f64>,
    /// μ λ \[N\].
    pub friction_bound: f64,
    /// Whether that stays.
    pub has_fixed_bound: bool,
    /// Whether both sides can move.
    pub is_between_bodies: bool,
    pub floor: f64,
    /// What is published of it.
    pub force: ContactForce,
    /// g₀ \[m\].
    pub gap: f64,
    /// u₀ \[m\].
    pub slip: Vector3<f64>,
    /// Displacement of each of its nodes per force, all others at rest \[m/N\], and of the gap with them.
    pub responses: [f64; 4],
    pub compliance: f64,
    /// What of its curvature is in the factored matrix.
    pub factored: Option<Matrix3<f64>>,
    /// Its curvature now.
    pub hessian: Matrix3<f64>,
}

/// Force of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContactForce {
    /// λ \[N\].
    pub normal: f64,
    /// t \[N\].
    pub friction: Vector3<f64>,
    /// Whether |t| is the friction bound.
    pub is_sliding: bool,
}

impl ContactForce {
    /// That of an open contact.
    pub const OPEN: Self = Self {
        normal: 0.0,
        friction: Vector3::new(0.0, 0.0, 0.0),
        is_sliding: true,
    };

    /// On the first side \[N\].
    #[inline]
    pub fn vector(&self, contact: &Contact) -> Vector3<f64> {
        contact.normal * self.normal + self.friction
    }
}

impl Row {
    /// What of its curvature is in the factored matrix, zero for none.
    #[inline]
    pub fn factored(&self) -> Matrix3<f64> {
        self.factored.unwrap_or_else(Matrix3::zeros)
    }

    /// Force and energy \[J\] after the sides have come closer by `y`.
    #[inline]
    pub fn law(&self, contact: &Contact, y: &Vector3<f64>) -> (ContactForce, f64) {
        let along = contact.normal.dot(y);
        let normal = (self.multiplier - self.penalty * (self.gap + along - self.floor)).max(0.0);
        let mut energy = normal * normal / (2.0 * self.penalty);
        let (mut friction, mut is_sliding) = (Vector3::zeros(), true);
        if self.friction_bound > 0.0 {
            let k = self.tangential_penalty;
            let trial = self.trial(contact, y, along);
            let size = trial.norm();
            is_sliding = size > self.friction_bound;
            if !is_sliding {
                friction = trial;
                energy += size * size / (2.0 * k);
            } else {
                friction = trial * (self.friction_bound / size);
                energy += self.friction_bound * (size - 0.5 * self.friction_bound) / k;
            }
        }
        let force = ContactForce {
            normal,
            friction,
            is_sliding,
        };
        (force, energy)
    }

    /// The force vector of [`law`](Self::law) \[N\].
    #[inline]
    pub fn force_at(&self, contact: &Contact, y: &Vector3<f64>) -> Vector3<f64> {
        self.law(contact, y).0.vector(contact)
    }

    /// t − k u.
    #[inline]
    fn trial(&self, contact: &Contact, y: &Vector3<f64>, along: f64) -> Vector3<f64> {
        let slip = self.slip + y - contact.normal * along;
        self.friction_multiplier - slip * self.tangential_penalty
    }

    /// The second derivative of the energy.
    #[inline]
    pub fn curvature(&self, contact: &Contact, y: &Vector3<f64>) -> Matrix3<f64> {
        let n = contact.normal;
        let along = n.dot(y);
        let normal = n * n.transpose();
        let mut curvature = Matrix3::zeros();
        if self.multiplier - self.penalty * (self.gap + along - self.floor) > 0.0 {
            curvature += normal * self.penalty;
        }
        if self.friction_bound > 0.0 {
            let k = self.tangential_penalty;
            let across = Matrix3::identity() - normal;
            let trial = self.trial(contact, y, along);
            let size = trial.norm();
            curvature += if size <= self.friction_bound {
                across * k
            } else {
                let unit = trial / size;
                (across - unit * unit.transpose()) * (k * self.friction_bound / size)
            };
        }
        curvature
    }

    /// With the multipliers and the bound updated after the sides have come closer by `y`; the multiplier residual \[m\], and the square of
    /// the change of the forces \[N²\].
    pub fn updated(&self, contact: &Contact, y: &Vector3<f64>) -> (Self, [f64; 2]) {
        let force = self.law(contact, y).0;
        let bound = match self.has_fixed_bound {
            true => self.friction_bound,
            false => contact.friction * force.normal,
        };
        let normal = force.normal - self.multiplier;
        // What sticks must not slide, and what slides must do so against the whole bound.
        let change = (force.friction - self.friction_multiplier).norm()
            + (bound - self.friction_bound).abs();
        let residual = (normal.abs() / self.penalty).max(change / self.tangential_penalty);
        let row = Self {
            multiplier: force.normal,
            friction_multiplier: force.friction,
            force,
            friction_bound: bound,
            ..*self
        };
        (row, [residual, normal * normal + change * change])
    }

    /// With the multipliers with which the force after the sides have come closer by `y` is this one: all forces stay in equilibrium.
    pub fn with_force(&self, contact: &Contact, y: &Vector3<f64>, force: ContactForce) -> Self {
        let along = contact.normal.dot(y);
        let slip = self.slip + y - contact.normal * along;
        let mut row = Self {
            multiplier: 0.0,
            force,
            ..*self
        };
        if force.normal > 0.0 {
            row.multiplier = force.normal + self.penalty * (self.gap + along - self.floor);
        }
        row.friction_multiplier = force.friction + slip * self.tangential_penalty;
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A contact along z, which has slid by 2 µm along x since the start of the step, and its row.
    fn slid(normal: f64, friction: f64) -> (Contact, Row) {
        let contact = Contact {
            friction: 0.5,
            normal_force: normal,
            friction_force: Vector3::x() * friction,
            ..Contact::of_node(0, Vector3::z(), 0.0)
        };
        let row = Row {
            penalty: 4e4,
            tangential_penalty: 4e3,
            multiplier: normal,
            friction_multiplier: contact.friction_force,
            friction_bound: contact.friction * normal,
            has_fixed_bound: false,
            force: ContactForce {
                normal,
                friction: contact.friction_force,
                is_sliding: false,
            },
            is_between_bodies: false,
            floor: 0.0,
            gap: 1e-7,
            slip: Vector3::x() * 2e-6,
            responses: [0.0; 4],
            compliance: 1.0,
            factored: None,
            hessian: Matrix3::zeros(),
        };
        (contact, row)
    }

    /// With the multipliers of `with_force` the law has this force at this place: the definition.
    #[test]
    fn a_contact_has_the_force_it_is_given() {
        // Closed and stuck, closed and sliding, open where it would stick: by how far it closes and slides in the iteration [m].
        let cases = [
            ([-2e-6, 0.0, -4e-7], 0.02, 1e-3, false),
            ([3e-6, 1e-6, -4e-7], 0.02, 1e-2, true),
            ([-2e-6, 0.0, 1e-3], 0.0, 1e-3, false),
        ];
        for (y, normal, friction, is_sliding) in cases {
            let y = Vector3::from(y);
            let (contact, row) = slid(0.02, 0.0);
            let force = ContactForce {
                normal,
                friction: Vector3::x() * friction,
                is_sliding,
            };
            let after = row.with_force(&contact, &y, force);
            let error = after.force_at(&contact, &y) - force.vector(&contact);
            assert!(error.norm() <= 1e-12 * row.friction_bound, "{error}");
            assert_eq!(after.force, force);
        }
    }

    /// Coulomb: what is published after an update is within the cone of the new normal force, and an open contact has no force.
    #[test]
    fn an_update_stays_within_the_cone() {
        let (contact, row) = slid(0.02, 1e-3);
        for y in [[3e-6, 1e-6, -4e-7], [0.0, 0.0, 1e-3]] {
            let y = Vector3::from(y);
            let (once, _) = row.updated(&contact, &y);
            let (twice, _) = once.updated(&contact, &y);
            let force = twice.force;
            assert!(force.friction.norm() <= contact.friction * once.multiplier * (1.0 + 1e-12));
            assert_eq!(twice.friction_bound, contact.friction * force.normal);
        }
    }
}
