//! What acts on a body in a tick, part by part and region by region.

use microsim_message::{ContactForce, ContactForces, PartForce, RegionForce};
use nalgebra::Vector3;

/// The forces of all tools on a body, of one message. They mean something where the solver's tick is
/// [valid](microsim_message::SolverTick::valid).
#[derive(Clone, Copy, Debug)]
pub struct BodyForces<'a> {
    contacts: &'a [ContactForce],
    body: &'a str,
}

impl<'a> BodyForces<'a> {
    /// Those on the body of this name.
    pub fn of(forces: &'a ContactForces, body: &'a str) -> Self {
        Self {
            contacts: &forces.contacts,
            body,
        }
    }

    fn contacts(&self) -> impl Iterator<Item = &'a ContactForce> {
        let body = self.body;
        self.contacts.iter().filter(move |c| c.body == body)
    }

    /// What a part of a tool does, such as one jaw; the part is named as the file of the tool does. `None` where it does not touch.
    pub fn part(&self, tool: &str, part: &str) -> Option<&'a PartForce> {
        let mut parts = self
            .contacts()
            .filter(|c| c.partner == tool)
            .flat_map(|c| &c.parts);
        parts.find(|force| force.part == part)
    }

    /// What acts on a region of the body, of all tools together. `None` where nothing touches it.
    pub fn region(&self, region: u32) -> Option<RegionForce> {
        let of_tools = self.contacts().flat_map(|c| &c.regions);
        let on_it: Vec<&RegionForce> = of_tools.filter(|force| force.region == region).collect();
        let first = on_it.first()?;
        let normal_force: f64 = on_it.iter().map(|force| force.normal_force).sum();
        let force: Vector3<f64> = on_it.iter().map(|of| Vector3::from(of.force)).sum();
        let weighted = on_it
            .iter()
            .map(|of| Vector3::from(of.point) * of.normal_force);
        let point = match normal_force > 0.0 {
            true => (weighted.sum::<Vector3<f64>>() / normal_force).into(),
            false => first.point,
        };
        Some(RegionForce {
            region,
            force: force.into(),
            normal_force,
            point,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_region(region: u32, force: [f64; 3], normal_force: f64, x: f64) -> RegionForce {
        RegionForce {
            region,
            force,
            normal_force,
            point: [x, 0.0, 0.0],
        }
    }

    /// By hand: two tools on region 2, from opposite sides, the second one three times as strongly; another body does not count.
    #[test]
    fn forces_of_tools_on_a_region_add_up_and_those_of_parts_do_not() {
        let contact = |tool: &str, body: &str, regions| ContactForce {
            partner: tool.into(),
            body: body.into(),
            regions,
            parts: vec![PartForce {
                part: "left-tip".into(),
                normal_force: 4.0,
                ..PartForce::default()
            }],
            ..ContactForce::default()
        };
        let left = vec![
            on_region(1, [9.0; 3], 9.0, 0.0),
            on_region(2, [1.0, 0.0, 2.0], 1.0, 4.0),
        ];
        let forces = ContactForces {
            contacts: vec![
                contact("left", "vessel", left),
                contact("left", "other", vec![on_region(2, [5.0; 3], 5.0, 9.0)]),
                contact(
                    "right",
                    "vessel",
                    vec![on_region(2, [-3.0, 0.0, 0.0], 3.0, 0.0)],
                ),
            ],
            between: Vec::new(),
        };
        let on = BodyForces::of(&forces, "vessel");
        let expected = on_region(2, [-2.0, 0.0, 2.0], 4.0, 1.0);
        assert_eq!(on.region(2), Some(expected));
        assert_eq!(on.region(3), None);
        assert_eq!(
            on.part("right", "left-tip").map(|p| p.normal_force),
            Some(4.0)
        );
        assert_eq!(on.part("right", "shaft"), None);
        assert_eq!(on.part("third", "left-tip"), None);
    }
}
