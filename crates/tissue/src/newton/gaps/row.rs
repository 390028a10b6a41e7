//! The law of one contact: what it does when its sides have come closer.

use crate::contact::Contact;
use nalgebra::{Matrix3, Vector3};

/// k over ρ.
const TANGENTIAL: f64 = 0.1;

/// A contact as an iteration sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// ρ \[N/m\]; 0 for a contact that can move nothing.
    pub stiffness: f64,
    /// λ \[N\].
    pub multiplier: f64,
    /// t \[N\].
    pub friction_force: Vector3<f64>,
    /// μ λ \[N\].
    pub bound: f64,
    /// Whether that stays.
    pub keeps_bound: bool,
    /// Whether both sides can move.
    pub joint: bool,
    pub floor: f64,
    /// What contacts are told.
    pub told: Told,
    /// g₀ \[m\].
    pub gap: f64,
    /// u₀ \[m\].
    pub slide: Vector3<f64>,
    /// How far each of its nodes goes for a force, all others at rest \[m/N\], and the gap with them.
    pub responses: [f64; 4],
    pub compliance: f64,
    /// What of its second derivative is in the factored matrix.
    pub factored: Option<Matrix3<f64>>,
    /// The second derivative now.
    pub hessian: Matrix3<f64>,
}

/// Force of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Told {
    /// λ \[N\].
    pub normal_force: f64,
    /// t \[N\].
    pub friction_force: Vector3<f64>,
    /// Whether t is all that the bound allows.
    pub is_sliding: bool,
}

impl Told {
    /// That of an open contact.
    pub const NONE: Self = Self {
        normal_force: 0.0,
        friction_force: Vector3::new(0.0, 0.0, 0.0),
        is_sliding: true,
    };
}

/// Force and energy of a contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law {
    pub told: Told,
    pub energy: f64,
}

impl Row {
    /// The state after the sides have come closer by `y`.
    pub fn law(&self, contact: &Contact, y: &Vector3<f64>) -> Law {
        let along = contact.normal.dot(y);
        let normal_force =
            (self.multiplier - self.stiffness * (self.gap + along - self.floor)).max(0.0);
        let mut energy = normal_force * normal_force / (2.0 * self.stiffness);
        let (mut friction_force, mut is_sliding) = (Vector3::zeros(), true);
        if self.bound > 0.0 {
            let k = TANGENTIAL * self.stiffness;
            let trial = self.trial(contact, y, along);
            let size = trial.norm();
            is_sliding = size > self.bound;
            if !is_sliding {
                friction_force = trial;
                energy += size * size / (2.0 * k);
            } else {
                friction_force = trial * (self.bound / size);
                energy += self.bound * (size - 0.5 * self.bound) / k;
            }
        }
        let told = Told {
            normal_force,
            friction_force,
            is_sliding,
        };
        Law { told, energy }
    }

    /// t − k u.
    fn trial(&self, contact: &Contact, y: &Vector3<f64>, along: f64) -> Vector3<f64> {
        let slide = self.slide + y - contact.normal * along;
        self.friction_force - slide * (TANGENTIAL * self.stiffness)
    }

    /// The second derivative of ψ.
    pub fn curvature(&self, contact: &Contact, y: &Vector3<f64>) -> Matrix3<f64> {
        let n = contact.normal;
        let along = n.dot(y);
        let normal = n * n.transpose();
        let mut curvature = Matrix3::zeros();
        if self.multiplier - self.stiffness * (self.gap + along - self.floor) > 0.0 {
            curvature += normal * self.stiffness;
        }
        if self.bound > 0.0 {
            let k = TANGENTIAL * self.stiffness;
            let across = Matrix3::identity() - normal;
            let trial = self.trial(contact, y, along);
            let size = trial.norm();
            curvature += if size <= self.bound {
                across * k
            } else {
                let unit = trial / size;
                (across - unit * unit.transpose()) * (k * self.bound / size)
            };
        }
        curvature
    }

    /// With the multipliers and the bound updated after the sides have come closer by `y`; how far the sides are from where they
    /// should be \[m\], and the square of the change of the forces \[N²\].
    pub fn updated(&self, contact: &Contact, y: &Vector3<f64>) -> (Self, [f64; 2]) {
        let told = self.law(contact, y).told;
        let bound = match self.keeps_bound {
            true => self.bound,
            false => contact.friction * told.normal_force,
        };
        let normal_force = told.normal_force - self.multiplier;
        // What sticks must not slide, and what slides must do so against all that there is.
        let change =
            (told.friction_force - self.friction_force).norm() + (bound - self.bound).abs();
        let miss =
            (normal_force.abs() / self.stiffness).max(change / (TANGENTIAL * self.stiffness));
        let row = Self {
            multiplier: told.normal_force,
            friction_force: told.friction_force,
            told,
            bound,
            ..*self
        };
        (row, [miss, normal_force * normal_force + change * change])
    }

    /// With the multipliers with which the forces after the sides have come closer by `y` are these: all forces stay in balance.
    pub fn with_force(&self, contact: &Contact, y: &Vector3<f64>, told: Told) -> Self {
        let along = contact.normal.dot(y);
        let slide = self.slide + y - contact.normal * along;
        let mut row = Self {
            multiplier: 0.0,
            told,
            ..*self
        };
        if told.normal_force > 0.0 {
            row.multiplier = told.normal_force + self.stiffness * (self.gap + along - self.floor);
        }
        row.friction_force = told.friction_force + slide * (TANGENTIAL * self.stiffness);
        row
    }
}

impl Law {
    /// On the first side \[N\].
    pub fn force(&self, contact: &Contact) -> Vector3<f64> {
        contact.normal * self.told.normal_force + self.told.friction_force
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A contact along z, which has slid by 2 µm along x since the start of the step, and its row.
    fn slid(normal_force: f64, friction_force: f64) -> (Contact, Row) {
        let contact = Contact {
            friction: 0.5,
            normal_force,
            friction_force: Vector3::x() * friction_force,
            ..Contact::of_node(0, Vector3::z(), 0.0)
        };
        let row = Row {
            stiffness: 4e4,
            multiplier: normal_force,
            friction_force: contact.friction_force,
            bound: contact.friction * normal_force,
            keeps_bound: false,
            told: Told {
                normal_force,
                friction_force: contact.friction_force,
                is_sliding: false,
            },
            joint: false,
            floor: 0.0,
            gap: 1e-7,
            slide: Vector3::x() * 2e-6,
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
        for (y, normal_force, friction_force, is_sliding) in cases {
            let y = Vector3::from(y);
            let (contact, row) = slid(0.02, 0.0);
            let told = Told {
                normal_force,
                friction_force: Vector3::x() * friction_force,
                is_sliding,
            };
            let after = row.with_force(&contact, &y, told);
            let force = contact.normal * normal_force + told.friction_force;
            let error = after.law(&contact, &y).force(&contact) - force;
            assert!(error.norm() <= 1e-12 * row.bound, "{error}");
            assert_eq!(after.told, told);
        }
    }

    /// Coulomb: what is told after an update is within the cone of the new normal force, and nothing is told of an open contact.
    #[test]
    fn an_update_stays_within_the_cone() {
        let (contact, row) = slid(0.02, 1e-3);
        for y in [[3e-6, 1e-6, -4e-7], [0.0, 0.0, 1e-3]] {
            let y = Vector3::from(y);
            let (once, _) = row.updated(&contact, &y);
            let (twice, _) = once.updated(&contact, &y);
            let Told {
                normal_force,
                friction_force,
                ..
            } = twice.told;
            assert!(friction_force.norm() <= contact.friction * once.multiplier * (1.0 + 1e-12));
            assert_eq!(twice.bound, contact.friction * normal_force);
        }
    }
}
