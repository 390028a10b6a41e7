//! The series of deformed meshes for ParaView: a `.vtu` per body and frame, a `.pvd` that lists all.

use crate::scene_file::SceneFile;
use microsim_mesh::format::{Field, FieldValues, PvdEntry, VtuEncoding, write_pvd, write_vtu};
use microsim_mesh::signed_volume;
use microsim_scene::{BodySpec, Runner, cauchy_stresses, green_strains, von_mises};
use microsim_settings::unwritable;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};

/// A folder into which a run is written.
pub struct Frames {
    folder: PathBuf,
    scene: String,
    bodies: Vec<BodySpec>,
    /// Time between two frames \[s\], and the time of the next one.
    interval: f64,
    next: f64,
    written: Vec<(f64, u32, String)>,
    count: u32,
}

impl Frames {
    /// Begins a series in `folder`, which is made, with the start of the scene.
    pub fn new(folder: &Path, scene: &SceneFile) -> Result<Self, String> {
        std::fs::create_dir_all(folder).map_err(|e| unwritable(folder, e))?;
        let name = scene.loaded.document.path();
        let mut frames = Self {
            folder: folder.to_path_buf(),
            scene: name
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            bodies: scene.spec.bodies.clone(),
            interval: scene.loaded.settings.run.frame,
            next: 0.0,
            written: Vec::new(),
            count: 0,
        };
        frames.after_sample(&scene.runner)?;
        Ok(frames)
    }

    /// Writes a frame if it is time for one; the last state always is one.
    pub fn after_sample(&mut self, runner: &Runner) -> Result<(), String> {
        let time = runner.scene().time();
        let last = self.written.last().map(|(time, ..)| *time);
        let due = time >= self.next - 0.5 * runner.sample() || runner.end().is_some();
        if !due || last == Some(time) {
            return Ok(());
        }
        self.next = time + self.interval;
        for (index, body) in self.bodies.iter().enumerate() {
            let file = format!("{}-{}-{:05}.vtu", self.scene, body.name, self.count);
            let path = self.folder.join(&file);
            std::fs::write(&path, frame(runner, index, body)).map_err(|e| unwritable(&path, e))?;
            self.written.push((time, index as u32, file));
        }
        self.count += 1;
        Ok(())
    }

    /// Writes the list; gives the folder and the number of meshes.
    pub fn finish(self) -> Result<(PathBuf, usize), String> {
        let entries: Vec<PvdEntry<'_>> = self
            .written
            .iter()
            .map(|(time, part, file)| PvdEntry {
                time: *time,
                part: *part,
                file,
            })
            .collect();
        let path = self.folder.join(format!("{}.pvd", self.scene));
        std::fs::write(&path, write_pvd(&entries)).map_err(|e| unwritable(&path, e))?;
        Ok((self.folder, self.written.len()))
    }
}

/// A body as it is now.
fn frame(runner: &Runner, index: usize, body: &BodySpec) -> Vec<u8> {
    let scene = runner.scene();
    let (now, rest) = (
        scene.body(index).positions(),
        scene.body(index).rest_positions(),
    );
    let displacement: Vec<Vector3<f64>> = now.iter().zip(rest).map(|(a, b)| a - b).collect();
    let rest_volumes = scene.body(index).model().rest_volumes();
    let ratio: Vec<f64> = scene
        .body(index)
        .tets()
        .iter()
        .zip(rest_volumes)
        .map(|(tet, rest)| {
            let [a, b, c, d] = tet.map(|node| &now[node as usize]);
            signed_volume(a, b, c, d) / rest
        })
        .collect();
    let mesh = scene.body(index).mesh();
    let strains = green_strains(mesh, now);
    let mut of_elements = vec![
        Field {
            name: "volume ratio",
            values: FieldValues::Scalars(&ratio),
        },
        Field {
            name: "Green strain",
            values: FieldValues::SymmetricTensors(&strains),
        },
    ];
    let body_now = scene.body(index);
    let flowed = body_now.model().plastic_states(mesh, body_now.state());
    let flowed = flowed.unwrap_or_default();
    let plastic_strains: Vec<f64> = flowed.iter().map(|one| one.strain).collect();
    if !flowed.is_empty() {
        of_elements.push(Field {
            name: "plastic strain",
            values: FieldValues::Scalars(&plastic_strains),
        });
    }
    let stresses = cauchy_stresses(body, mesh, now, &flowed).unwrap_or_default();
    let equivalent: Vec<f64> = stresses.iter().map(von_mises).collect();
    if !stresses.is_empty() {
        of_elements.push(Field {
            name: "Cauchy stress [Pa]",
            values: FieldValues::SymmetricTensors(&stresses),
        });
        of_elements.push(Field {
            name: "von Mises stress [Pa]",
            values: FieldValues::Scalars(&equivalent),
        });
    }
    let of_nodes = [
        Field {
            name: "displacement [m]",
            values: FieldValues::Vectors(&displacement),
        },
        Field {
            name: "velocity [m/s]",
            values: FieldValues::Vectors(scene.body(index).velocities()),
        },
    ];
    write_vtu(mesh, now, &of_nodes, &of_elements, VtuEncoding::AppendedRaw)
}
