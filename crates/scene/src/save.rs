//! Exact bytes of all that evolves.
//!
//! Little-endian, in this order: magic, version u32, time f64, whether the last tick was not valid u32, number of contact pairs u32, per pair the number of ticks in its window u32 and these (length, force, grip), the fraction of their motion that tools make in a tick f64, number of tools u32, per tool whether it is there u32 and if so its position 3 × f64, orientation x, y, z, w 4 × f64, target, opening, moment, stiffness and the opening at which it grasped f64 each, the force on it 3 × f64, the stiffness of what it pushes against f64 and whether it is where the hand holds it u32, number of edits u32 and these (`edits`), what decides of each cut; number of bodies u32; per body what cuts have made of it (tally, pieces, topology) if it can be cut, the number of nodes u32, the last
//! step f64, longest stable step f64, positions and velocities (3 × f64 per node), numbers of accelerations and of internal variables u32, these (3 ×
//! f64 and f64 each); number of groups of bodies that touch one another u32; per group the number of last normals u32 and per
//! normal partner, node u32, 3 × f64; the number of contact forces u32 and per force body u32, partner, five nodes u32, force along
//! the normal f64 and across it 3 × f64. A partner is three u32: kind (0 tool, 1 rigid, 2 body), index, capsule (0 but for a tool). What does not evolve is not saved: bytes are restored into a scene built from
//! the same description.

mod edits;

use crate::body::Body;
use crate::edits::Edit;
use crate::force_window::{ForceWindow, WindowTick};
use crate::group::Group;
use crate::group_contact::{ContactForce, ContactState};
use crate::member::Member;
use crate::placement::{Placement, Placements};
use crate::scene::Scene;
use crate::state::SceneState;
use microsim_contact::{Key, Partner, Sides};
use microsim_geometry::Pose;
use microsim_tissue::State;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

const MAGIC: &[u8; 4] = b"MSSC";
const VERSION: u32 = 15;

/// Why bytes cannot be restored. The scene is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RestoreError {
    /// They are not a saved scene.
    NotAScene,
    /// They were saved by another version of the format.
    Version {
        /// That version.
        found: u32,
    },
    /// They belong to another scene: numbers of bodies, nodes, groups or cuts differ, or edits or places on layers do not fit its meshes.
    OtherScene,
    /// They end too early or go on too long.
    Length,
    /// They hold a number that is not finite.
    NotFinite,
}

impl std::fmt::Display for RestoreError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotAScene => write!(f, "the bytes are not a saved scene"),
            Self::Version { found } => {
                write!(
                    f,
                    "the scene was saved in format {found}, this program reads format {VERSION}"
                )
            }
            Self::OtherScene => write!(
                f,
                "the saved scene has other bodies, meshes, contact pairs or cuts"
            ),
            Self::Length => write!(f, "the saved scene is cut short or has bytes too many"),
            Self::NotFinite => write!(f, "the saved scene holds numbers that are not finite"),
        }
    }
}

impl std::error::Error for RestoreError {}

impl Scene {
    /// All that evolves, exactly.
    ///
    /// ```
    /// # use microsim_mesh::{Block, CellSplit};
    /// # use microsim_scene::{Behaviour, BodySpec, Material, Method, Scene, SceneSpec, Serial};
    /// # use microsim_tissue::SpringConstants;
    /// # let block = Block { center: [0.0; 3], size: [2e-3; 3], cells: [2; 3], split: CellSplit::Kuhn };
    /// # let behaviour = Behaviour::Springs(SpringConstants::scaled(25e3, 5e4));
    /// # let material = Material { density: 1060.0, relaxation_time: 0.0, behaviour };
    /// # let cube = BodySpec::new("cube", block.mesh()?, material);
    /// let spec = SceneSpec::new(vec![cube], Method::StoermerVerlet);
    /// let mut scene = Scene::new(&spec)?;
    /// let steps = scene.required_steps(1e-3);
    /// scene.tick(&[], 1e-3, steps, &Serial)?;
    /// let saved = scene.save();
    ///
    /// // Another scene of the same description goes on from there, bit for bit.
    /// let mut other = Scene::new(&spec)?;
    /// other.restore(&saved)?;
    /// scene.tick(&[], 1e-3, steps, &Serial)?;
    /// other.tick(&[], 1e-3, steps, &Serial)?;
    /// assert_eq!(scene.digest(), other.digest());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn save(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        bytes.extend_from_slice(MAGIC);
        put_u32(&mut bytes, VERSION);
        put_f64(&mut bytes, self.state.time);
        put_u32(&mut bytes, u32::from(self.state.doubtful));
        put_f64(&mut bytes, self.state.overspent);
        put_u32(&mut bytes, self.state.windows.len() as u32);
        for window in &self.state.windows {
            put_u32(&mut bytes, window.ticks.len() as u32);
            for tick in &window.ticks {
                put_f64(&mut bytes, tick.length);
                put_vector(&mut bytes, &tick.force);
                put_f64(&mut bytes, tick.grip);
            }
        }
        put_f64(&mut bytes, self.state.placements.pace);
        put_u32(&mut bytes, self.state.placements.tools.len() as u32);
        for placement in &self.state.placements.tools {
            put_u32(&mut bytes, u32::from(placement.is_some()));
            if let Some(placement) = placement {
                put_placement(&mut bytes, placement);
            }
        }
        put_u32(&mut bytes, self.edits.len() as u32);
        self.edits
            .iter()
            .for_each(|edit| edits::put_edit(&mut bytes, edit));
        put_u32(&mut bytes, self.state.blades.len() as u32);
        for (blade, cut) in self.state.blades.iter().zip(&self.cuts) {
            edits::put_blade(&mut bytes, blade, cut.topology);
        }
        put_u32(&mut bytes, self.state.bodies.len() as u32);
        let bodies = self.state.bodies.iter().zip(&self.state.stable_steps);
        for ((body, stable_step), of) in bodies.zip(&self.bodies) {
            edits::put_cut(&mut bytes, of);
            put_u32(&mut bytes, body.positions.len() as u32);
            put_f64(&mut bytes, body.step);
            put_f64(&mut bytes, *stable_step);
            body.positions
                .iter()
                .chain(&body.velocities)
                .for_each(|v| put_vector(&mut bytes, v));
            put_u32(&mut bytes, body.accelerations.len() as u32);
            put_u32(&mut bytes, body.internal.len() as u32);
            body.accelerations
                .iter()
                .for_each(|a| put_vector(&mut bytes, a));
            body.internal.iter().for_each(|&i| put_f64(&mut bytes, i));
        }
        put_u32(&mut bytes, self.state.contacts.len() as u32);
        for contact in &self.state.contacts {
            let entries = contact.sides.entries();
            put_u32(&mut bytes, entries.len() as u32);
            for (partner, node, normal) in entries {
                put_partner(&mut bytes, partner);
                put_u32(&mut bytes, *node);
                put_vector(&mut bytes, normal);
            }
            put_u32(&mut bytes, contact.forces.len() as u32);
            for force in &contact.forces {
                put_u32(&mut bytes, force.key.body);
                put_partner(&mut bytes, &force.key.partner);
                let nodes = force.key.first.iter().chain(&force.key.second);
                nodes.for_each(|&node| put_u32(&mut bytes, node));
                put_f64(&mut bytes, force.normal_force);
                put_vector(&mut bytes, &force.friction_force);
            }
        }
        bytes
    }

    /// Takes over what [`save`](Self::save) gave, in a scene built from the same description. On an error nothing changes.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut reader = Reader { bytes };
        if reader.take(4).ok() != Some(MAGIC) {
            return Err(RestoreError::NotAScene);
        }
        let found = reader.u32()?;
        if found != VERSION {
            return Err(RestoreError::Version { found });
        }
        let time = reader.f64()?;
        let doubtful = reader.bool()?;
        let overspent = reader.f64()?;
        reader.expect(self.pairs.len())?;
        let windows = self.pairs.iter().map(|_| reader.window());
        let windows = windows.collect::<Result<_, _>>()?;
        let pace = reader.f64()?;
        if !(pace > 0.0 && pace <= 1.0) {
            return Err(RestoreError::OtherScene);
        }
        reader.expect(self.tools.len())?;
        let tools = self.tools.iter().map(|_| reader.placement());
        let placements = Placements {
            tools: tools.collect::<Result<_, _>>()?,
            pace,
        };
        let edits = reader.list(edits::edit)?;
        let mut cut = self.cut_by(&edits)?;
        reader.expect(self.cuts.len())?;
        let cuts = self.cuts.iter();
        let blades = cuts.map(|cut| edits::blade(&mut reader, cut.topology));
        let blades = blades.collect::<Result<_, _>>()?;
        reader.expect(self.bodies.len())?;
        let mut bodies = Vec::with_capacity(self.bodies.len());
        let mut stable_steps = Vec::with_capacity(self.bodies.len());
        for body in &mut cut {
            edits::cut(&mut reader, body)?;
            let nodes = body.model.node_count();
            reader.expect(nodes)?;
            let step = reader.f64()?;
            stable_steps.push(reader.longest_step()?);
            let positions = (0..nodes)
                .map(|_| reader.vector())
                .collect::<Result<_, _>>()?;
            let velocities = (0..nodes)
                .map(|_| reader.vector())
                .collect::<Result<_, _>>()?;
            // Accelerations are there after the first step of a method that carries them.
            let accelerations = reader.u32()? as usize;
            if accelerations != 0 && accelerations != nodes {
                return Err(RestoreError::OtherScene);
            }
            reader.expect(body.start.internal.len())?;
            let accelerations = (0..accelerations)
                .map(|_| reader.vector())
                .collect::<Result<_, _>>()?;
            let internal = (0..body.start.internal.len())
                .map(|_| reader.f64())
                .collect::<Result<Vec<f64>, _>>()?;
            if !body.model.admits(&internal) {
                return Err(RestoreError::OtherScene);
            }
            bodies.push(State {
                positions,
                velocities,
                step,
                accelerations,
                internal,
            });
        }
        // Bodies that are advanced together have come to them together.
        let carried = |member: &Member| bodies[member.body].accelerations.is_empty();
        let same = |group: &Group| {
            let mut members = group.members.windows(2);
            members.all(|two| carried(&two[0]) == carried(&two[1]))
        };
        if !self.groups.iter().all(same) {
            return Err(RestoreError::OtherScene);
        }
        reader.expect(self.groups.len())?;
        let mut contacts = Vec::with_capacity(self.groups.len());
        for _ in &self.groups {
            let mut entries = Vec::new();
            for _ in 0..reader.u32()? {
                entries.push((reader.partner()?, reader.u32()?, reader.vector()?));
            }
            let mut forces = Vec::new();
            for _ in 0..reader.u32()? {
                forces.push(reader.force()?);
            }
            if !forces.is_sorted_by(|a: &ContactForce, b| a.key < b.key) {
                return Err(RestoreError::OtherScene);
            }
            contacts.push(ContactState {
                sides: Sides::from_entries(entries),
                forces,
            });
        }
        if !reader.bytes.is_empty() {
            return Err(RestoreError::Length);
        }
        if edits != self.edits {
            self.bodies = cut;
            self.edits = edits;
            for group in &mut self.groups {
                group.rebuild(
                    &self.bodies,
                    &self.pairs,
                    &self.obstacle_parts,
                    &self.method,
                );
            }
        } else {
            self.bodies = cut;
        }
        self.bodies.iter_mut().for_each(Body::prepare_edits);
        self.state = SceneState {
            bodies,
            contacts,
            stable_steps,
            blades,
            windows,
            placements,
            doubtful,
            overspent,
            time,
        };
        self.relocate();
        Ok(())
    }
}

impl Scene {
    /// The bodies as these edits make them of those that were there before any.
    fn cut_by(&self, edits: &[Edit]) -> Result<Vec<Body>, RestoreError> {
        if edits == self.edits {
            return Ok(self.bodies.clone());
        }
        let (bodies, _) = self.uncut.as_deref().ok_or(RestoreError::OtherScene)?;
        let mut bodies = bodies.clone();
        for edit in edits {
            let body = bodies.get_mut(edit.body);
            let body = body.filter(|body| body.topology.is_some());
            let body = body.ok_or(RestoreError::OtherScene)?;
            if !body.model.relocate_to(&edit.places) {
                return Err(RestoreError::OtherScene);
            }
            body.update_after_edit(&edit.edit, &self.method)
                .map_err(|_| RestoreError::OtherScene)?;
        }
        Ok(bodies)
    }
}

fn put_u32(bytes: &mut Vec<u8>, value: u32) {
    bytes.extend_from_slice(&value.to_le_bytes());
}

fn put_f64(bytes: &mut Vec<u8>, value: f64) {
    bytes.extend_from_slice(&value.to_le_bytes());
}

fn put_vector(bytes: &mut Vec<u8>, vector: &Vector3<f64>) {
    vector.iter().for_each(|&c| put_f64(bytes, c));
}

fn put_placement(bytes: &mut Vec<u8>, placement: &Placement) {
    put_vector(bytes, &placement.pose.position);
    let orientation = placement.pose.orientation.coords;
    orientation.iter().for_each(|&c| put_f64(bytes, c));
    let numbers = [
        placement.target,
        placement.opening,
        placement.moment,
        placement.stiffness,
        placement.grasped,
    ];
    numbers.iter().for_each(|&number| put_f64(bytes, number));
    put_vector(bytes, &placement.push);
    put_f64(bytes, placement.resistance);
    put_u32(bytes, u32::from(placement.is_free));
}

fn put_partner(bytes: &mut Vec<u8>, partner: &Partner) {
    let numbers = match *partner {
        Partner::Tool { tool, capsule } => [0, tool, capsule],
        Partner::Obstacle { part } => [1, part, 0],
        Partner::Body { body } => [2, body, 0],
    };
    numbers.into_iter().for_each(|n| put_u32(bytes, n));
}

struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], RestoreError> {
        let (head, tail) = self
            .bytes
            .split_at_checked(count)
            .ok_or(RestoreError::Length)?;
        self.bytes = tail;
        Ok(head)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], RestoreError> {
        let (head, tail) = self.bytes.split_first_chunk().ok_or(RestoreError::Length)?;
        self.bytes = tail;
        Ok(*head)
    }

    fn u32(&mut self) -> Result<u32, RestoreError> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn f64(&mut self) -> Result<f64, RestoreError> {
        let value = f64::from_le_bytes(self.array()?);
        if value.is_finite() {
            Ok(value)
        } else {
            Err(RestoreError::NotFinite)
        }
    }

    /// A step, which is infinite for a method without a limit.
    fn longest_step(&mut self) -> Result<f64, RestoreError> {
        let value = f64::from_le_bytes(self.array()?);
        if value >= 0.0 {
            Ok(value)
        } else {
            Err(RestoreError::NotFinite)
        }
    }

    fn vector(&mut self) -> Result<Vector3<f64>, RestoreError> {
        Ok(Vector3::new(self.f64()?, self.f64()?, self.f64()?))
    }

    fn bool(&mut self) -> Result<bool, RestoreError> {
        match self.u32()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(RestoreError::OtherScene),
        }
    }

    fn placement(&mut self) -> Result<Option<Placement>, RestoreError> {
        if !self.bool()? {
            return Ok(None);
        }
        let position = self.vector()?;
        let [x, y, z, w] = [self.f64()?, self.f64()?, self.f64()?, self.f64()?];
        let orientation = Quaternion::new(w, x, y, z);
        if (orientation.norm() - 1.0).abs() > 1e-9 {
            return Err(RestoreError::OtherScene);
        }
        Ok(Some(Placement {
            pose: Pose {
                position,
                // As it was saved, to the bit.
                orientation: UnitQuaternion::new_unchecked(orientation),
            },
            target: self.f64()?,
            opening: self.f64()?,
            moment: self.f64()?,
            stiffness: self.f64()?,
            grasped: self.f64()?,
            push: self.vector()?,
            resistance: self.f64()?,
            is_free: self.bool()?,
        }))
    }

    fn partner(&mut self) -> Result<Partner, RestoreError> {
        let [kind, index, capsule] = [self.u32()?, self.u32()?, self.u32()?];
        Ok(match (kind, capsule) {
            (0, capsule) => Partner::Tool {
                tool: index,
                capsule,
            },
            (1, 0) => Partner::Obstacle { part: index },
            (2, 0) => Partner::Body { body: index },
            _ => return Err(RestoreError::OtherScene),
        })
    }

    fn window(&mut self) -> Result<ForceWindow, RestoreError> {
        let ticks = (0..self.u32()?).map(|_| {
            Ok(WindowTick {
                length: self.f64()?,
                force: self.vector()?,
                grip: self.f64()?,
            })
        });
        Ok(ForceWindow {
            ticks: ticks.collect::<Result<_, RestoreError>>()?,
        })
    }

    fn force(&mut self) -> Result<ContactForce, RestoreError> {
        let body = self.u32()?;
        let partner = self.partner()?;
        let first = [self.u32()?, self.u32()?, self.u32()?];
        let second = [self.u32()?, self.u32()?];
        Ok(ContactForce {
            key: Key {
                body,
                partner,
                first,
                second,
            },
            normal_force: self.f64()?,
            friction_force: self.vector()?,
        })
    }

    /// A number that has to be `count`.
    fn expect(&mut self, count: usize) -> Result<(), RestoreError> {
        if self.u32()? as usize == count {
            Ok(())
        } else {
            Err(RestoreError::OtherScene)
        }
    }
}
