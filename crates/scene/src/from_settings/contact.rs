//! Tools, obstacles, and what touches what.

use super::Load;
use super::error::{FromSettingsCause, FromSettingsError, missing};
use crate::spec::{
    CapsuleSpec, ContactResponse, ContactSpec, CutSpec, CutTrigger, Grip, IrrigationSpec, Jaw,
    ObstacleSpec, PartnerSpec, ToolKeySpec, ToolSpec,
};
use microsim_contact::{BroadPhaseMethod, Depth, ObstaclePart, ObstacleShape};
use microsim_cutting::TopologyChange;
use microsim_geometry::Pose;
use microsim_settings as settings;
use nalgebra::Vector3;
use settings::KeyPath;
use std::path::Path;

/// How what may touch is found.
pub(super) fn broad_phase(name: settings::BroadPhase, cell_size: Option<f64>) -> BroadPhaseMethod {
    match name {
        settings::BroadPhase::Bvh => BroadPhaseMethod::Hierarchy,
        settings::BroadPhase::SpatialHash => BroadPhaseMethod::SpatialHash { cell_size },
        settings::BroadPhase::AllPairs => BroadPhaseMethod::AllPairs,
    }
}

/// Capsules as files have them, to those of a tool.
pub(super) fn capsules(
    parts: &[settings::ToolCapsule],
    hinge: Option<[f64; 3]>,
    opening_angle: Option<f64>,
) -> Vec<CapsuleSpec> {
    let touching = parts.iter().filter(|part| part.touches);
    let capsules = touching.map(|part| {
        let jaw = match part.jaw {
            settings::Jaw::Fixed => None,
            settings::Jaw::Left => Some(Jaw::Left),
            settings::Jaw::Right => Some(Jaw::Right),
        };
        CapsuleSpec {
            name: part.name.clone(),
            a: part.a,
            b: part.b,
            radius: part.radius,
            joint: part.joint(hinge, opening_angle),
            jaw,
            lonor: part.lonor,
            edge: part.edge,
            lonor_offset: part.lonor_offset,
        }
    });
    capsules.collect()
}

/// Fluid as files have it, to that of a tool.
pub(super) fn irrigation(of: &settings::Irrigation) -> IrrigationSpec {
    IrrigationSpec {
        position: of.position,
        direction: of.direction,
        pressure: of.pressure,
        radius: of.radius,
        reach: of.reach,
    }
}

/// The tools of a scene. A model is a file of the folder `tools` beside that of the scene.
pub(super) fn tools(
    tools: &[settings::SceneTool],
    load: &mut Load<'_>,
) -> Result<Vec<ToolSpec>, FromSettingsError> {
    let specs = tools.iter().enumerate().map(|(index, tool)| {
        let key = KeyPath::root().key("tool").at(index).key("model");
        let (parts, sharpness, jaw_stiffness, jet) = match &tool.model {
            Some(name) => {
                let model = model(name, &key, load)?;
                let parts = capsules(&model.capsule, model.hinge, model.opening_angle);
                (
                    parts,
                    model.sharpness,
                    model.jaw_stiffness,
                    model.irrigation,
                )
            }
            None => {
                let parts = capsules(&tool.capsule, tool.hinge, tool.opening_angle);
                (parts, tool.sharpness, None, tool.irrigation)
            }
        };
        let keys = tool.motion.iter().map(|key| ToolKeySpec {
            time: key.time,
            pose: Pose::from_arrays(key.position, key.orientation),
            opening: key.opening,
        });
        Ok(ToolSpec {
            name: tool.name.clone(),
            capsules: parts,
            sharpness,
            jaw_stiffness: jaw_stiffness.unwrap_or(f64::INFINITY),
            irrigation: jet.as_ref().map(irrigation),
            motion: keys.collect(),
        })
    });
    specs.collect()
}

fn model(
    name: &str,
    key: &KeyPath,
    load: &mut Load<'_>,
) -> Result<settings::Tool, FromSettingsError> {
    let file = format!("../tools/{name}.toml");
    let wrong = |reason: String| {
        let cause = FromSettingsCause::Tool {
            file: file.clone(),
            reason,
        };
        FromSettingsError::new(key.clone(), cause)
    };
    let bytes = load(Path::new(&file)).map_err(|error| wrong(error.to_string()))?;
    let text = String::from_utf8(bytes).map_err(|error| wrong(error.to_string()))?;
    let loaded = settings::read_tool(&text, &file).map_err(|error| wrong(error.to_string()))?;
    Ok(loaded.settings)
}

/// Obstacles; those that are hollow have several parts.
pub(super) fn obstacles(obstacles: &[settings::Rigid]) -> Vec<ObstacleSpec> {
    let specs = obstacles.iter().map(|obstacle| {
        let pose = Pose::from_arrays(obstacle.position, obstacle.orientation);
        let parts = obstacle.shape.parts().into_iter().map(|part| ObstaclePart {
            shape: match part.solid {
                settings::Solid::HalfSpace => ObstacleShape::HalfSpace,
                settings::Solid::Cuboid {
                    half_size,
                    rounding,
                } => ObstacleShape::Cuboid {
                    half_size,
                    rounding,
                },
                settings::Solid::Cylinder { radius, length } => ObstacleShape::Cylinder {
                    radius,
                    half_length: 0.5 * length,
                },
            },
            pose: Pose {
                position: pose.apply(&Vector3::from(part.centre)),
                ..pose
            },
        });
        ObstacleSpec {
            name: obstacle.name.clone(),
            parts: parts.collect(),
        }
    });
    specs.collect()
}

/// Pairs.
pub(super) fn contacts(
    pairs: &[settings::ContactPair],
) -> Result<Vec<ContactSpec>, FromSettingsError> {
    let specs = pairs.iter().enumerate().map(|(index, pair)| {
        let with = match (&pair.tool, &pair.rigid, &pair.with, pair.itself) {
            (Some(tool), None, None, false) => PartnerSpec::Tool(tool.clone()),
            (None, Some(obstacle), None, false) => PartnerSpec::Obstacle(obstacle.clone()),
            (None, None, Some(body), false) => PartnerSpec::Body {
                name: body.clone(),
                end_planes: pair.end_planes,
            },
            (None, None, None, true) => PartnerSpec::Itself,
            _ => {
                return Err(missing(
                    KeyPath::root().key("contact").at(index),
                    "one of `tool`, `rigid`, `with` and `self`",
                ));
            }
        };
        Ok(ContactSpec {
            body: pair.body.clone(),
            with,
            friction: pair.friction,
            force_limit: pair.force_limit.unwrap_or(f64::INFINITY),
            response: response(pair, index)?,
            grip: match pair.grip {
                settings::Grip::Friction => Grip::Friction,
                settings::Grip::Box => Grip::Box,
            },
        })
    });
    specs.collect()
}

fn response(
    pair: &settings::ContactPair,
    index: usize,
) -> Result<ContactResponse, FromSettingsError> {
    let depth = match pair.depth {
        Some(settings::PenetrationDepth::Nearest) => Depth::Nearest,
        Some(settings::PenetrationDepth::Consistent) | None => Depth::Consistent,
    };
    Ok(match pair.response {
        settings::ContactResponse::Constraint => ContactResponse::Constraint,
        settings::ContactResponse::TargetForce => ContactResponse::TargetForce { depth },
        settings::ContactResponse::Penalty => {
            let key = KeyPath::root().key("contact").at(index).key("stiffness");
            let stiffness = pair.stiffness.ok_or_else(|| missing(key, "`stiffness`"))?;
            ContactResponse::Penalty { stiffness, depth }
        }
    })
}

/// What cuts what.
pub(super) fn cuts(pairs: &[settings::CutPair]) -> Vec<CutSpec> {
    let specs = pairs.iter().map(|pair| CutSpec {
        topology: match pair.topology {
            settings::CutTopology::Remove => TopologyChange::Remove,
            settings::CutTopology::SplitAtFaces => TopologyChange::SplitAtFaces,
            settings::CutTopology::SemiProgressive => TopologyChange::SemiProgressive,
            settings::CutTopology::Progressive => TopologyChange::Progressive,
        },
        trigger: match pair.trigger {
            settings::CutTrigger::Force => CutTrigger::Force,
            settings::CutTrigger::Penetration => CutTrigger::Penetration,
        },
        ..CutSpec::new(&pair.body, &pair.tool)
    });
    specs.collect()
}
