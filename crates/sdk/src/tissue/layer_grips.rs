//! Which layers of a wall jaws grip, and how hard.

use super::contacts::valid_forces;
use crate::fault::Fault;
use crate::tick::Tick;
use microsim_message::{ContactForce, GRIP_MIN};
use serde::{Deserialize, Serialize};

/// What grips have done to one layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayerGrip {
    /// The region of its elements.
    pub region: u32,
    /// What acts on it now of the hardest grip \[N\].
    pub force: f64,
    /// Largest part of a sustained grip that acted on it \[N\]: see [`ContactForce::sustained_grip`].
    pub peak: f64,
    /// Time in which a grip acted on it with [`GRIP_MIN`] or more \[s\].
    pub time: f64,
}

/// The grips on the layers of a body, tick by tick. A grip acts on a layer by the part that it bears of the normal forces of the tool on the body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayerGrips {
    layers: Vec<LayerGrip>,
}

impl LayerGrips {
    /// Of the layers with these regions.
    pub fn of(regions: &[u32]) -> Self {
        let layer = |region: &u32| LayerGrip {
            region: *region,
            ..LayerGrip::default()
        };
        Self {
            layers: regions.iter().map(layer).collect(),
        }
    }

    /// Takes over the contacts of a tick, unless its forces mean nothing. `holders` are the tools that can grip.
    pub fn update(&mut self, tick: &Tick<'_>, body: &str, holders: &[String]) -> Result<(), Fault> {
        let Some(forces) = valid_forces(tick)? else {
            return Ok(());
        };
        let contacts = forces.iter().flat_map(|of| &of.contacts);
        let grips: Vec<&ContactForce> = contacts
            .filter(|of| of.body == body && holders.contains(&of.partner))
            .filter(|of| of.grip_force >= GRIP_MIN)
            .collect();
        for layer in &mut self.layers {
            let parts = grips.iter().map(|grip| (part_on(grip, layer.region), grip));
            let parts: Vec<_> = parts.collect();
            let largest = |of: &dyn Fn(&ContactForce) -> f64| {
                let forces = parts.iter().map(|(part, grip)| part * of(grip));
                forces.fold(0.0, f64::max)
            };
            layer.force = largest(&|grip| grip.grip_force);
            layer.peak = layer.peak.max(largest(&|grip| grip.sustained_grip));
            if layer.force >= GRIP_MIN {
                layer.time += tick.length();
            }
        }
        Ok(())
    }

    /// What grips have done to the layer of a region; `None` of one that is not watched.
    pub fn layer(&self, region: u32) -> Option<&LayerGrip> {
        self.layers.iter().find(|layer| layer.region == region)
    }
}

/// The part of a contact's normal forces that a region bears.
fn part_on(contact: &ContactForce, region: u32) -> f64 {
    let forces = contact.regions.iter();
    let all: f64 = forces.clone().map(|of| of.normal_force).sum();
    let on: f64 = forces
        .filter(|of| of.region == region)
        .map(|of| of.normal_force)
        .sum();
    if all > 0.0 { on / all } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_message::{ContactForces, RegionForce, SolverTick, push};

    fn grip(partner: &str, grip_force: f64, normal_forces: &[(u32, f64)]) -> ContactForce {
        let region = |&(region, normal_force): &(u32, f64)| RegionForce {
            region,
            normal_force,
            ..RegionForce::default()
        };
        ContactForce {
            partner: partner.into(),
            body: "vessel".into(),
            grip_force,
            sustained_grip: 0.5 * grip_force,
            regions: normal_forces.iter().map(region).collect(),
            ..ContactForce::default()
        }
    }

    fn update(grips: &mut LayerGrips, contacts: Vec<ContactForce>, valid: bool) {
        let mut messages = Vec::new();
        let solver = SolverTick {
            valid,
            ..SolverTick::default()
        };
        let forces = ContactForces {
            contacts,
            between: Vec::new(),
        };
        push(&mut messages, &solver);
        push(&mut messages, &forces);
        let tick = Tick {
            index: 0,
            time_ns: 0,
            tick_ns: 8_000_000,
            steps: 1,
            messages: &messages,
            blocks: Vec::new(),
            out: Vec::new(),
            out_blocks: Vec::new(),
        };
        let holders = ["left".to_owned(), "third".to_owned()];
        grips.update(&tick, "vessel", &holders).expect("messages");
    }

    /// By hand: of a grip of 20 mN three quarters act on the adventitia; the harder one of two counts; one too weak, of a tool that holds nothing or of a tick that means
    /// nothing does not.
    #[test]
    fn a_grip_acts_on_the_layers_that_bear_it() {
        let mut grips = LayerGrips::of(&[0, 1]);
        let on = |grips: &LayerGrips, region| *grips.layer(region).expect("it is watched");
        update(
            &mut grips,
            vec![grip("left", 0.02, &[(0, 0.01), (1, 0.03)])],
            true,
        );
        let (media, adventitia) = (on(&grips, 0), on(&grips, 1));
        assert_eq!(
            (media.force, media.peak, media.time),
            (0.005, 0.0025, 0.008)
        );
        assert_eq!((adventitia.force, adventitia.peak), (0.015, 0.0075));
        let both = vec![
            grip("left", 0.9e-3, &[(0, 1.0)]),
            grip("right", 1.0, &[(0, 1.0)]),
            grip("third", 0.012, &[(1, 0.05)]),
        ];
        update(&mut grips, both, true);
        let (media, adventitia) = (on(&grips, 0), on(&grips, 1));
        assert_eq!((media.force, media.peak, media.time), (0.0, 0.0025, 0.008));
        assert_eq!(
            (adventitia.force, adventitia.peak, adventitia.time),
            (0.012, 0.0075, 0.016)
        );
        update(&mut grips, vec![grip("left", 1.0, &[(0, 1.0)])], false);
        assert_eq!(on(&grips, 0), media);
        assert_eq!(grips.layer(2), None);
    }
}
