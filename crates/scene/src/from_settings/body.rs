//! Bodies: meshes, materials, and what is attached to them.

use super::error::{FromSettingsCause, FromSettingsError, missing};
use super::fibres::set_directions;
use super::residual::set_prestretches;
use super::{Load, selections};
use crate::spec::{
    BodySpec, ClampSpec, CouplingKind, CouplingSpec, LoadKind, LoadSpec, LumenSpec, MotionKey,
    MotionSpec, Selection, StartSpec,
};
use microsim_mesh::format::{MeshFormat, SurfaceFormat, read_surface, read_tet_mesh};
use microsim_mesh::{
    Arc, Block, GradeError, Grading, Layer, PARTS, TetMesh, Tube, TubeSide, Zone, fill, fit_lattice,
};
use microsim_settings as settings;
use microsim_tissue::elements::{Bond, Cohesion, CouplingConstants, SlidingConstants};
use microsim_tissue::{Discretisation, Material};
use nalgebra::Vector3;
use settings::KeyPath;
use std::path::Path;

/// A body; `key` is its own.
pub(super) fn body(
    body: &settings::Body,
    key: &KeyPath,
    load: &mut Load<'_>,
    notes: &mut Vec<String>,
) -> Result<BodySpec, FromSettingsError> {
    let mut made = mesh(body, key, load, notes)?;
    if !body.refine.is_empty() {
        made = made.graded(body, key)?;
    }
    if !body.detached.is_empty() {
        made = made.detached(&body.detached, key)?;
    }
    if body.material.iter().any(is_quadratic) {
        let tets = PARTS * made.mesh.tets.len();
        allowed(tets as f64)
            .map_err(|cause| FromSettingsError::new(key.key("generator"), cause))?;
        made = made.refined();
    }
    let Made {
        mut mesh,
        ends,
        tube,
        lumen,
    } = made;
    set_directions(&mut mesh, body, key, |material, region| {
        let named = |m: &settings::Material| m.region == Some(region);
        named(material) || material.region.is_none() && !body.material.iter().any(named)
    })?;
    let (materials, tear_strains) = materials(body, key, &mesh)?;
    set_prestretches(&mut mesh, body, tube.as_ref(), &materials, key)?;
    let mut loads = Vec::new();
    for (index, load) in body.load.iter().enumerate() {
        let kind = match (load.pressure, load.traction) {
            (Some(pressure), _) => LoadKind::Pressure(pressure),
            (None, Some(traction)) => LoadKind::Traction(traction),
            (None, None) => {
                return Err(missing(
                    key.key("load").at(index),
                    "`pressure` or `traction`",
                ));
            }
        };
        loads.push(LoadSpec {
            surface: selection(&load.surface),
            kind,
            ramp: load.ramp,
        });
    }
    let couplings = body.coupling.iter().map(|coupling| CouplingSpec {
        from: coupling.from,
        to: coupling.to,
        kind: kind(coupling),
    });
    let starts = body.start.iter().map(|start| StartSpec {
        nodes: selection(&start.nodes),
        matrix: start.matrix,
        pivot: start.pivot,
        shift: start.shift,
        velocity: start.velocity,
    });
    Ok(BodySpec {
        name: body.name.clone(),
        mesh,
        origin: body.centre,
        materials,
        drag: body.drag,
        toughness: body.toughness.unwrap_or(f64::INFINITY),
        brittleness: body.brittleness,
        tear_strains,
        clamps: body.clamp.iter().map(clamp).collect(),
        couplings: couplings.collect(),
        loads,
        start: starts.collect(),
        ends,
        lumen,
    })
}

/// What a coupling does: the settings allow one kind.
fn kind(coupling: &settings::Coupling) -> CouplingKind {
    let stiffness_per_area = coupling.stiffness;
    if let Some(friction) = coupling.friction {
        return CouplingKind::Sliding(SlidingConstants {
            stiffness_per_area,
            friction,
            shear_strength: coupling.shear_strength,
        });
    }
    let bond = match (coupling.strength, coupling.energy) {
        (Some(strength), Some(energy)) => {
            Bond::Cohesive(Cohesion::new(stiffness_per_area, strength, energy))
        }
        _ => Bond::Elastic {
            break_distance: coupling.break_distance.unwrap_or(f64::INFINITY),
        },
    };
    CouplingKind::Bonded(CouplingConstants {
        stiffness_per_area,
        bond,
    })
}

/// One selection: the settings allow no more here.
fn selection(nodes: &settings::Nodes) -> Selection {
    selections(nodes)
        .into_iter()
        .next()
        .unwrap_or(Selection::All)
}

fn clamp(clamp: &settings::Clamp) -> ClampSpec {
    let keys: Vec<MotionKey> = clamp
        .motion
        .iter()
        .map(|key| MotionKey {
            time: key.time,
            shift: key.shift,
            angle: key.angle,
        })
        .collect();
    ClampSpec {
        nodes: selection(&clamp.nodes),
        motion: (!keys.is_empty()).then_some(MotionSpec {
            pivot: clamp.pivot,
            axis: clamp.axis,
            keys,
        }),
        release: clamp.release,
    }
}

/// Outward triangles.
type Face = Vec<[u32; 3]>;

/// The mesh of a body.
struct Made {
    mesh: TetMesh,
    /// The tube that it is.
    tube: Option<Tube>,
    /// The faces at the open ends of a tube.
    ends: Vec<Face>,
    /// The lumen of a tube that is closed around.
    lumen: Option<LumenSpec>,
}

impl Made {
    fn new(mesh: TetMesh) -> Self {
        Self {
            mesh,
            tube: None,
            ends: Vec::new(),
            lumen: None,
        }
    }

    /// Refined where the body asks for it; a tube of quadratic tetrahedra, which are curved, stays round.
    fn graded(self, body: &settings::Body, key: &KeyPath) -> Result<Self, FromSettingsError> {
        let key = key.key("refine");
        let gradings = body.refine.iter().enumerate().map(|(index, refine)| {
            let zone = zone(refine, &Vector3::from(body.centre));
            let zone =
                zone.ok_or_else(|| missing(key.at(index), "`point` with `radius`, or `region`,"))?;
            let size = refine.size;
            Ok(Grading { zone, size })
        });
        let gradings: Vec<Grading> = gradings.collect::<Result<_, _>>()?;
        let limit = settings::MAX_ELEMENTS as usize;
        let graded = self.mesh.graded(&gradings, limit);
        let graded = match &self.tube {
            Some(tube) if body.material.iter().any(is_quadratic) => {
                graded.and_then(|graded| graded.place_middles(|a, b| tube.between(a, b)))
            }
            _ => graded,
        };
        let graded = graded.map_err(|error| {
            let key = match error {
                GradeError::Zone { index, .. } | GradeError::Size { index, .. } => key.at(index),
                GradeError::Inverted { .. } | GradeError::Elements { .. } => key.at(0),
            };
            FromSettingsError::new(key, FromSettingsCause::Refine(error))
        })?;
        Ok(Self {
            ends: self.ends.iter().map(|face| graded.faces(face)).collect(),
            lumen: self.lumen.map(|of| LumenSpec {
                triangles: graded.faces(&of.triangles),
                ..of
            }),
            mesh: graded.mesh,
            tube: self.tube,
        })
    }

    /// With regions that have nodes of their own.
    fn detached(self, regions: &[u32], key: &KeyPath) -> Result<Self, FromSettingsError> {
        for (index, region) in regions.iter().enumerate() {
            if !self.mesh.regions.contains(region) {
                let mut regions = self.mesh.regions;
                regions.sort_unstable();
                regions.dedup();
                let region = *region;
                let cause = FromSettingsCause::Region { region, regions };
                return Err(FromSettingsError::new(key.key("detached").at(index), cause));
            }
        }
        let detached = self.mesh.detached(regions);
        Ok(Self {
            ends: self.ends.iter().map(|face| detached.faces(face)).collect(),
            lumen: self.lumen.map(|of| LumenSpec {
                triangles: detached.faces(&of.triangles),
                ..of
            }),
            mesh: detached.mesh,
            tube: self.tube,
        })
    }

    /// Refined once, for quadratic tetrahedra; those of a tube are curved.
    fn refined(self) -> Self {
        let mut refined = self.mesh.refined();
        if let Some(tube) = &self.tube {
            refined.place_middles(|a, b| tube.between(a, b));
        }
        Self {
            ends: self.ends.iter().map(|face| refined.faces(face)).collect(),
            lumen: self.lumen.map(|of| LumenSpec {
                triangles: refined.faces(&of.triangles),
                ..of
            }),
            mesh: refined.mesh,
            tube: self.tube,
        }
    }
}

/// The part of a body that is to be refined, in the world; `origin` is that of the body's frame \[m\]. `None` if its keys name none.
fn zone(refine: &settings::Refine, origin: &Vector3<f64>) -> Option<Zone> {
    let place = |point: [f64; 3]| (origin + Vector3::from(point)).into();
    if let Some(region) = refine.region {
        return Some(Zone::Region(region));
    }
    let (point, radius) = (place(refine.point?), refine.radius?);
    Some(match (refine.to, refine.normal) {
        (Some(to), _) => Zone::Capsule {
            ends: [point, place(to)],
            radius,
        },
        (None, Some(normal)) => Zone::Slab {
            point,
            normal,
            distance: radius,
        },
        (None, None) => Zone::Ball {
            center: point,
            radius,
        },
    })
}

/// Whether a material asks for quadratic tetrahedra.
fn is_quadratic(material: &settings::Material) -> bool {
    let discretisation = material.discretisation;
    discretisation.is_some_and(Discretisation::is_quadratic)
}

/// Makes the mesh of a body.
fn mesh(
    body: &settings::Body,
    key: &KeyPath,
    load: &mut Load<'_>,
    notes: &mut Vec<String>,
) -> Result<Made, FromSettingsError> {
    let wrong = |cause| FromSettingsError::new(key.key("generator"), cause);
    let split = body.split.unwrap_or_default();
    match body.generator {
        settings::Generator::Block => {
            let size = body
                .size
                .ok_or_else(|| missing(key.key("size"), "`size`"))?;
            let cells = body
                .cells
                .ok_or_else(|| missing(key.key("cells"), "`cells`"))?;
            let block = Block {
                center: body.centre,
                size,
                cells: cells.map(|n| n as usize),
                split,
            };
            let mesh = match layers(body)[..] {
                [] => block.mesh(),
                ref layers => block.layered(layers),
            };
            let mesh = mesh.map_err(|e| wrong(FromSettingsCause::Block(e)))?;
            Ok(Made::new(mesh))
        }
        settings::Generator::Tube => {
            let size = |name: &'static str, value: Option<f64>| {
                value.ok_or_else(|| missing(key.key(name), name))
            };
            let cells = |name: &'static str, value: Option<u32>| {
                value.ok_or_else(|| missing(key.key(name), name))
            };
            let tube = Tube {
                center: body.centre,
                axis: body.axis.unwrap_or([1.0, 0.0, 0.0]),
                inner_radius: size("inner_radius", body.inner_radius)?,
                layers: layers(body),
                length: size("length", body.length)?,
                around: cells("around", body.around)? as usize,
                along: cells("along", body.along)? as usize,
                arc: match body.arc {
                    None => Arc::Full,
                    Some(angle) => Arc::Sector {
                        start: body.arc_start.unwrap_or(0.0),
                        angle,
                    },
                },
                split,
            };
            let mesh = tube.mesh().map_err(|e| wrong(FromSettingsCause::Tube(e)))?;
            let ends =
                [TubeSide::Start, TubeSide::End].map(|side| tube.side(&mesh, side).triangles);
            let lumen = (tube.arc == Arc::Full).then(|| LumenSpec {
                triangles: tube.side(&mesh, TubeSide::Inner).triangles,
                axis: tube.axis,
                sections: tube.along as u32,
            });
            Ok(Made {
                mesh,
                ends: ends.into(),
                lumen,
                tube: Some(tube),
            })
        }
        settings::Generator::File => Ok(Made::new(from_file(body, key, load, notes)?)),
    }
}

/// The layers of a tube or block.
fn layers(body: &settings::Body) -> Vec<Layer> {
    let layers = body.layer.iter().map(|layer| Layer {
        thickness: layer.thickness,
        cells: layer.cells as usize,
        region: layer.region,
    });
    layers.collect()
}

fn from_file(
    body: &settings::Body,
    key: &KeyPath,
    load: &mut Load<'_>,
    notes: &mut Vec<String>,
) -> Result<TetMesh, FromSettingsError> {
    let at = key.key("file");
    let wrong = |cause| FromSettingsError::new(at.clone(), cause);
    let file = body
        .file
        .clone()
        .ok_or_else(|| missing(at.clone(), "`file`"))?;
    let mut bytes = Vec::new();
    for part in body.files() {
        bytes.push(load(Path::new(&part)).map_err(|error| {
            wrong(FromSettingsCause::File {
                file: part,
                reason: error.to_string(),
            })
        })?);
    }
    let unit = body.scale.unwrap_or(1.0);
    let place = |p: &Vector3<f64>| p * unit + Vector3::from(body.centre);
    let note = |text: &String| format!("{file}: {text}");
    let format = |source| FromSettingsCause::Format {
        file: file.clone(),
        source,
    };
    if let Some(kind) = MeshFormat::from_path(&file) {
        let parts: Vec<&[u8]> = bytes.iter().map(Vec::as_slice).collect();
        let mut import = read_tet_mesh(kind, &parts).map_err(|e| wrong(format(e)))?;
        notes.extend(import.notes.iter().map(note));
        allowed(import.mesh.tets.len() as f64).map_err(wrong)?;
        import.mesh.positions.iter_mut().for_each(|p| *p = place(p));
        return Ok(import.mesh);
    }
    let Some(kind) = SurfaceFormat::from_path(&file) else {
        return Err(wrong(FromSettingsCause::Ending { file: file.clone() }));
    };
    let mut import = read_surface(kind, &bytes[0]).map_err(|e| wrong(format(e)))?;
    notes.extend(import.notes.iter().map(note));
    import
        .surface
        .positions
        .iter_mut()
        .for_each(|p| *p = place(p));
    let cell = body
        .fill
        .ok_or_else(|| missing(key.key("fill"), "`fill`"))?;
    // Six in each cell of the box around it: what filling looks at, whatever it retains.
    let bounds = microsim_geometry::Aabb::of(&import.surface.positions);
    let cells = (bounds.max - bounds.min).map(|side| (side / cell).ceil().max(1.0));
    allowed(6.0 * cells.product())
        .map_err(|cause| FromSettingsError::new(key.key("fill"), cause))?;
    let filled = match body.filling.unwrap_or_default() {
        settings::Filling::Stuffing => fill(&import.surface, cell),
        settings::Filling::FittedLattice => {
            fit_lattice(&import.surface, cell).map(|fitted| fitted.mesh)
        }
    };
    filled.map_err(|e| wrong(FromSettingsCause::Fill(e)))
}

/// Whether a body may have so many tetrahedra.
fn allowed(count: f64) -> Result<(), FromSettingsCause> {
    match count <= settings::MAX_ELEMENTS as f64 {
        true => Ok(()),
        false => Err(FromSettingsCause::Elements {
            count: count as u64,
        }),
    }
}

/// Regions with something each.
type OfRegions<T> = Vec<(u32, T)>;

/// The material of each region of the mesh, and the strain at which those tear that do; one without a region is for all that no other names.
fn materials(
    body: &settings::Body,
    key: &KeyPath,
    mesh: &TetMesh,
) -> Result<(OfRegions<Material>, OfRegions<f64>), FromSettingsError> {
    let mut regions = mesh.regions.clone();
    regions.sort_unstable();
    regions.dedup();
    let named: Vec<u32> = body.material.iter().filter_map(|m| m.region).collect();
    let (mut materials, mut tears) = (Vec::new(), Vec::new());
    for (index, of) in body.material.iter().enumerate() {
        let key = key.key("material").at(index);
        let material = super::material::material(of, &key)?;
        let before = materials.len();
        match of.region {
            Some(region) if !regions.contains(&region) => {
                let cause = FromSettingsCause::Region { region, regions };
                return Err(FromSettingsError::new(key.key("region"), cause));
            }
            Some(region) => materials.push((region, material)),
            None => {
                let rest = regions.iter().filter(|region| !named.contains(region));
                materials.extend(rest.map(|&region| (region, material)));
            }
        }
        if let Some(strain) = of.tear_strain {
            let new = materials[before..].iter();
            tears.extend(new.map(|(region, _)| (*region, strain)));
        }
    }
    Ok((materials, tears))
}
