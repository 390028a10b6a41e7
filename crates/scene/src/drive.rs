//! What drives the bodies from step to step: moving clamps, grips that let go, loads that grow.

use crate::edits::{nodes_after_edit, nodes_after_edit_by, renumbering};
use crate::spec::{ClampSpec, LoadKind, LoadSpec, MotionSpec};
use microsim_mesh::{Surface, TetMesh, TopologyEdit};
use microsim_tissue::{Control, NodeTarget, Pressure};
use nalgebra::{Unit, UnitQuaternion, Vector3};
use std::sync::Arc;

/// The drive of one body.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drive {
    /// Clamps that stay closed.
    clamps: Vec<Clamp>,
    /// Number of the model's clamped nodes.
    clamped: usize,
    /// Grips: they let go at a time.
    grips: Vec<Grip>,
    loads: Vec<Load>,
}

/// A clamp that stays closed.
#[derive(Clone, Debug)]
struct Clamp {
    motion: Option<Motion>,
    nodes: Vec<ClampedNode>,
}

#[derive(Clone, Copy, Debug)]
struct ClampedNode {
    node: u32,
    /// Among the model's clamped nodes.
    place: usize,
    /// \[m\]
    rest: Vector3<f64>,
}

#[derive(Clone, Debug)]
struct Grip {
    motion: Option<Motion>,
    /// Nodes with their rest positions \[m\].
    nodes: Vec<(u32, Vector3<f64>)>,
    release: f64,
}

#[derive(Clone, Debug)]
struct Motion {
    pivot: Vector3<f64>,
    axis: Unit<Vector3<f64>>,
    keys: Vec<(f64, Vector3<f64>, f64)>,
}

#[derive(Clone, Debug)]
struct Load {
    triangles: Arc<[[u32; 3]]>,
    kind: LoadKind,
    /// Area at rest that belongs to each node \[m²\], for tractions.
    areas: Vec<(u32, f64)>,
    /// Its nodes, ascending.
    nodes: Vec<u32>,
    ramp: f64,
}

impl Drive {
    /// The drive of a body. `clamps` and `loads` come with the nodes or triangles that they mean; `clamped` are the model's
    /// clamped nodes, ascending.
    pub fn new(
        mesh: &TetMesh,
        origin: &Vector3<f64>,
        clamps: &[(&ClampSpec, Vec<u32>)],
        loads: &[(&LoadSpec, Vec<[u32; 3]>)],
        clamped: &[u32],
    ) -> Self {
        let mut drive = Self {
            clamped: clamped.len(),
            ..Self::default()
        };
        for (spec, nodes) in clamps {
            let motion = spec
                .motion
                .as_ref()
                .map(|motion| Motion::new(motion, origin));
            let at_rest = |node: u32| mesh.positions[node as usize];
            match spec.release {
                Some(release) => drive.grips.push(Grip {
                    motion,
                    nodes: nodes.iter().map(|&node| (node, at_rest(node))).collect(),
                    release,
                }),
                None => {
                    let nodes = nodes.iter().filter_map(|&node| {
                        let place = clamped.binary_search(&node).ok()?;
                        let rest = at_rest(node);
                        Some(ClampedNode { node, place, rest })
                    });
                    let nodes = nodes.collect();
                    drive.clamps.push(Clamp { motion, nodes });
                }
            }
        }
        for (spec, triangles) in loads {
            let surface = Surface::new(triangles.clone());
            drive.loads.push(Load {
                areas: areas(&surface, mesh),
                nodes: surface.nodes.clone(),
                triangles: triangles.as_slice().into(),
                kind: spec.kind,
                ramp: spec.ramp,
            });
        }
        drive
    }

    /// Updates the drive after an edit, whose result is `mesh`: what a clamp, grip or load has both nodes of that a new node comes from, it has too. `old` is
    /// the number of nodes before, `clamped` are the model's clamped nodes now.
    pub fn update_after_edit(
        &mut self,
        edit: &TopologyEdit,
        old: usize,
        mesh: &TetMesh,
        clamped: &[u32],
    ) {
        let now = renumbering(edit, old);
        let rest = |node: u32| mesh.positions[node as usize];
        for clamp in &mut self.clamps {
            // A node between two clamps goes with the first: the model holds every node that comes from two held ones.
            let held = clamp.nodes.iter().map(|held| held.node);
            let is_held =
                |node: u32| now(node).is_some_and(|now| clamped.binary_search(&now).is_ok());
            let nodes = nodes_after_edit_by(held, edit, old, |all, new, node| {
                all.contains(&node.between[0]) && is_held(new)
            });
            let nodes = nodes.into_iter().filter_map(|node| {
                let (place, rest) = (clamped.binary_search(&node).ok()?, rest(node));
                Some(ClampedNode { node, place, rest })
            });
            clamp.nodes = nodes.collect();
        }
        self.clamped = clamped.len();
        for grip in &mut self.grips {
            let nodes = nodes_after_edit(grip.nodes.iter().map(|(node, _)| *node), edit, old);
            grip.nodes = nodes.into_iter().map(|node| (node, rest(node))).collect();
        }
        for load in &mut self.loads {
            load.nodes = nodes_after_edit(load.nodes.iter().copied(), edit, old);
        }
    }

    /// The nodes that grips and loads act on.
    pub fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        let gripped = self.grips.iter().flat_map(|grip| &grip.nodes);
        let gripped = gripped.map(|(node, _)| *node);
        let loaded = self.loads.iter().flat_map(|load| &load.nodes);
        gripped.chain(loaded.copied())
    }

    /// The triangles of loads once the surface has changed: those `outside` that no cut has opened, outward.
    pub fn update_loads(&mut self, mesh: &TetMesh, outside: &[[u32; 3]]) {
        for load in &mut self.loads {
            let of_load = outside.iter().copied();
            let of_load =
                of_load.filter(|t| t.iter().all(|node| load.nodes.binary_search(node).is_ok()));
            let surface = Surface::new(of_load.collect());
            load.areas = areas(&surface, mesh);
            load.triangles = surface.triangles.into();
        }
    }

    /// Whether anything loads the surface.
    pub fn has_loads(&self) -> bool {
        !self.loads.is_empty()
    }

    /// Whether any grip needs a method with prescribed nodes.
    pub fn has_grips(&self) -> bool {
        !self.grips.is_empty()
    }

    /// Whether a clamp that stays closed moves at any time.
    pub fn moves_clamps(&self) -> bool {
        self.clamps.iter().any(|clamp| clamp.motion.is_some())
    }

    /// Whether anything that holds the body moves, closes or is released between two times \[s\].
    pub fn moves(&self, from: f64, to: f64) -> bool {
        let still = |motion: &Option<Motion>| {
            let last = motion.as_ref().and_then(|motion| motion.keys.last());
            last.is_none_or(|(time, _, _)| *time <= from)
        };
        // A grip that closes on a body at time 0 may first have to bring it to where it is.
        let stays = |grip: &Grip| {
            (still(&grip.motion) && from > 0.0 && to < grip.release) || grip.release < from
        };
        !self.clamps.iter().all(|clamp| still(&clamp.motion)) || !self.grips.iter().all(stays)
    }

    /// The largest stretch between two that hold the body, centre to centre over that at rest, at the times of their keys; 1 where nothing
    /// is drawn out. Those nearer than `least` \[m\] are not looked at.
    pub fn largest_stretch(&self, least: f64) -> f64 {
        let clamps = self.clamps.iter().map(|clamp| {
            let places: Vec<Vector3<f64>> = clamp.nodes.iter().map(|held| held.rest).collect();
            (clamp.motion.as_ref(), places, f64::INFINITY)
        });
        let grips = self.grips.iter().map(|grip| {
            let places: Vec<Vector3<f64>> = grip.nodes.iter().map(|(_, rest)| *rest).collect();
            (grip.motion.as_ref(), places, grip.release)
        });
        let holders = clamps
            .chain(grips)
            .filter(|(_, places, _)| !places.is_empty());
        // Motions are rigid: the centre of what they hold goes with them.
        let holders: Vec<(Option<&Motion>, Vector3<f64>, f64)> = holders
            .map(|(motion, places, release)| {
                let centre = places.iter().sum::<Vector3<f64>>() / places.len() as f64;
                (motion, centre, release)
            })
            .collect();
        let mut largest: f64 = 1.0;
        for (index, (motion, centre, release)) in holders.iter().enumerate() {
            for (other, from, until) in &holders[..index] {
                let length = (centre - from).norm();
                if length < least {
                    continue;
                }
                let keys = [motion, other].into_iter().copied().flatten();
                let times = keys.flat_map(|motion| motion.keys.iter().map(|(time, _, _)| *time));
                let until = release.min(*until);
                let times = times.map(|time| time.min(until));
                let stretches = times.map(|time| {
                    (placed(*motion, centre, time) - placed(*other, from, time)).norm() / length
                });
                largest = stretches.fold(largest, f64::max);
            }
        }
        largest
    }

    /// What drives the body in the step that ends at `time` \[s\].
    pub fn control(&self, gravity: &Vector3<f64>, time: f64) -> Control {
        let mut control = Control {
            gravity: *gravity,
            ..Control::default()
        };
        if self.moves_clamps() {
            control.clamped_positions = vec![Vector3::zeros(); self.clamped];
            for clamp in &self.clamps {
                for ClampedNode { place, rest, .. } in &clamp.nodes {
                    control.clamped_positions[*place] = placed(clamp.motion.as_ref(), rest, time);
                }
            }
        }
        for load in &self.loads {
            let fraction = if time < load.ramp {
                time / load.ramp
            } else {
                1.0
            };
            match load.kind {
                LoadKind::Pressure(pressure) => control.pressures.push(Pressure {
                    triangles: load.triangles.clone(),
                    pressure: fraction * pressure,
                }),
                LoadKind::Traction(traction) => {
                    let traction = Vector3::from(traction) * fraction;
                    let forces = load
                        .areas
                        .iter()
                        .map(|(node, area)| (*node, traction * *area));
                    control.forces.extend(forces);
                }
            }
        }
        control
    }

    /// The targets of gripped nodes at the end of the step that ends at `time` \[s\]: of a node in two grips the first.
    pub fn targets(&self, time: f64) -> Vec<NodeTarget> {
        let mut targets: Vec<NodeTarget> = Vec::new();
        // A grip holds through the step in which it is released; a tolerance of rounding on times that are sums of steps.
        let closed = |grip: &&Grip| time <= grip.release * (1.0 + 1e-12);
        for grip in self.grips.iter().filter(closed) {
            targets.extend(grip.nodes.iter().map(|(node, rest)| NodeTarget {
                node: *node,
                target: placed(grip.motion.as_ref(), rest, time),
                overlap: Vector3::zeros(),
            }));
        }
        targets.sort_by_key(|target| target.node);
        targets.dedup_by_key(|target| target.node);
        targets
    }
}

/// Area at rest of the triangles at each node \[m²\].
fn areas(surface: &Surface, mesh: &TetMesh) -> Vec<(u32, f64)> {
    let areas = surface.node_areas(&mesh.positions);
    surface.nodes.iter().copied().zip(areas).collect()
}

/// Where something at `rest` is at `time`.
fn placed(motion: Option<&Motion>, rest: &Vector3<f64>, time: f64) -> Vector3<f64> {
    motion.map_or(*rest, |motion| motion.place(rest, time))
}

impl Motion {
    fn new(spec: &MotionSpec, origin: &Vector3<f64>) -> Self {
        let keys = spec.keys.iter();
        Self {
            pivot: origin + Vector3::from(spec.pivot),
            axis: Unit::new_normalize(Vector3::from(spec.axis)),
            keys: keys
                .map(|key| (key.time, Vector3::from(key.shift), key.angle))
                .collect(),
        }
    }

    fn place(&self, rest: &Vector3<f64>, time: f64) -> Vector3<f64> {
        let (mut before, mut shift, mut angle) = (0.0, Vector3::zeros(), 0.0);
        for (at, next_shift, next_angle) in &self.keys {
            if time < *at {
                let fraction = (time - before) / (at - before);
                shift += (next_shift - shift) * fraction;
                angle += (next_angle - angle) * fraction;
                break;
            }
            (before, shift, angle) = (*at, *next_shift, *next_angle);
        }
        let turned = UnitQuaternion::from_axis_angle(&self.axis, angle) * (rest - self.pivot);
        self.pivot + turned + shift
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::MotionKey;

    #[test]
    fn a_motion_is_linear_between_its_keys_and_stands_after_the_last() {
        let key = |time, x, angle| MotionKey {
            time,
            shift: [x, 0.0, 0.0],
            angle,
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        let spec = MotionSpec {
            pivot: [0.0; 3],
            axis: [0.0, 0.0, 2.0],
            keys: vec![key(1.0, 2.0, 0.0), key(3.0, 2.0, quarter)],
        };
        let motion = Motion::new(&spec, &Vector3::new(1.0, 0.0, 0.0));
        let rest = Vector3::new(2.0, 0.0, 0.0);
        let root = std::f64::consts::FRAC_1_SQRT_2;
        for (time, x, y) in [
            (0.0, 2.0, 0.0),
            (0.5, 3.0, 0.0),
            (1.0, 4.0, 0.0),
            (2.0, 3.0 + root, root),
            (3.0, 3.0, 1.0),
            (9.0, 3.0, 1.0),
        ] {
            let place = motion.place(&rest, time);
            assert!(
                (place - Vector3::new(x, y, 0.0)).norm() < 1e-14,
                "{time}: {place}"
            );
        }
    }
}
