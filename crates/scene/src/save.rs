//! Exact bytes of all that evolves.
//!
//! Little-endian, in this order: magic, version u32, time f64, number of bodies u32; per body the number of nodes u32, the last
//! step f64, longest stable step f64, positions and velocities (3 × f64 per node), numbers of accelerations and of internal variables u32, these (3 ×
//! f64 and f64 each); number of pairs u32; per pair the number of remembered normals u32
//! and per normal capsule u32, node u32, 3 × f64. What does not evolve is not saved: bytes are restored into a scene built from
//! the same description.

use crate::scene::{Scene, SceneState};
use microsim_contact::ContactMemory;
use microsim_tissue::State;
use nalgebra::Vector3;

const MAGIC: &[u8; 4] = b"MSSC";
const VERSION: u32 = 3;

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
    /// They belong to another scene: numbers of bodies, nodes or pairs differ.
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
                "the saved scene has other bodies, meshes or contact pairs"
            ),
            Self::Length => write!(f, "the saved scene is cut short or has bytes too many"),
            Self::NotFinite => write!(f, "the saved scene holds numbers that are not finite"),
        }
    }
}

impl std::error::Error for RestoreError {}

impl Scene {
    /// All that evolves, exactly.
    pub fn save(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        bytes.extend_from_slice(MAGIC);
        put_u32(&mut bytes, VERSION);
        put_f64(&mut bytes, self.state.time);
        put_u32(&mut bytes, self.state.bodies.len() as u32);
        for (body, stable_step) in self.state.bodies.iter().zip(&self.state.stable_steps) {
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
        put_u32(&mut bytes, self.state.memories.len() as u32);
        for memory in &self.state.memories {
            let entries = memory.entries();
            put_u32(&mut bytes, entries.len() as u32);
            for (capsule, node, normal) in entries {
                put_u32(&mut bytes, capsule);
                put_u32(&mut bytes, node);
                put_vector(&mut bytes, normal);
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
        reader.expect(self.bodies.len())?;
        let mut bodies = Vec::with_capacity(self.bodies.len());
        let mut stable_steps = Vec::with_capacity(self.bodies.len());
        for body in &self.bodies {
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
                .collect::<Result<_, _>>()?;
            bodies.push(State {
                positions,
                velocities,
                step,
                accelerations,
                internal,
            });
        }
        reader.expect(self.pairs.len())?;
        let mut memories = Vec::with_capacity(self.pairs.len());
        for _ in &self.pairs {
            let mut memory = ContactMemory::new();
            for _ in 0..reader.u32()? {
                let (capsule, node) = (reader.u32()?, reader.u32()?);
                memory.remember(capsule, node, reader.vector()?);
            }
            memories.push(memory);
        }
        if !reader.bytes.is_empty() {
            return Err(RestoreError::Length);
        }
        self.state = SceneState {
            bodies,
            memories,
            stable_steps,
            time,
        };
        Ok(())
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

    /// A number that has to be `count`.
    fn expect(&mut self, count: usize) -> Result<(), RestoreError> {
        if self.u32()? as usize == count {
            Ok(())
        } else {
            Err(RestoreError::OtherScene)
        }
    }
}
