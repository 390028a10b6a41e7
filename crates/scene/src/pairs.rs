//! What touches what: obstacles and pairs, from their description.

use crate::box_grip::{self, Couple};
use crate::error::SceneError;
use crate::spec::{ContactResponse, Grip, ObstacleSpec, PartnerSpec, SceneSpec};
use microsim_contact::{ObstaclePart, ObstacleShape};
use microsim_tissue::Method;
use std::ops::Range;

/// Two that touch.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pair {
    pub body: usize,
    pub with: PairPartner,
    /// μ.
    pub friction: f64,
    /// \[N\].
    pub force_limit: f64,
    pub end_planes: bool,
    pub response: ContactResponse,
    /// Lines of jaws between which the body is held; none where friction holds it.
    pub grip: Vec<Couple>,
}

/// What a body touches, by indices.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PairPartner {
    Tool(usize),
    Obstacle {
        obstacle: usize,
        /// Its parts among those of all obstacles.
        parts: Range<usize>,
    },
    Body(usize),
    Itself,
}

/// An obstacle.
#[derive(Clone, Debug)]
pub(crate) struct Obstacle {
    pub name: String,
    /// Its parts among those of all obstacles.
    pub parts: Range<usize>,
}

/// The obstacles, and the parts of all of them.
pub(crate) fn find_obstacles(
    specs: &[ObstacleSpec],
) -> Result<(Vec<Obstacle>, Vec<ObstaclePart>), SceneError> {
    let (mut obstacles, mut all) = (Vec::new(), Vec::new());
    for spec in specs {
        let sized = |part: &ObstaclePart| match part.shape {
            ObstacleShape::HalfSpace => true,
            ObstacleShape::Cuboid {
                half_size,
                rounding,
            } => {
                let least = half_size.into_iter().fold(f64::INFINITY, f64::min);
                half_size.iter().all(|s| s.is_finite() && *s > 0.0)
                    && (0.0..=least).contains(&rounding)
            }
            ObstacleShape::Cylinder {
                radius,
                half_length,
            } => [radius, half_length]
                .iter()
                .all(|s| s.is_finite() && *s > 0.0),
        };
        let right = |part: &ObstaclePart| part.pose.is_finite() && sized(part);
        if spec.parts.is_empty() || !spec.parts.iter().all(right) {
            return Err(SceneError::Obstacle {
                name: spec.name.clone(),
            });
        }
        let first = all.len();
        all.extend_from_slice(&spec.parts);
        obstacles.push(Obstacle {
            name: spec.name.clone(),
            parts: first..all.len(),
        });
    }
    Ok((obstacles, all))
}

/// The pairs of a description.
pub(crate) fn find_pairs(
    spec: &SceneSpec,
    obstacles: &[Obstacle],
) -> Result<Vec<Pair>, SceneError> {
    let mut pairs: Vec<Pair> = Vec::new();
    for (index, contact) in spec.contacts.iter().enumerate() {
        let wrong = |reason| SceneError::Contacts {
            index,
            body: contact.body.clone(),
            with: contact.with.name().to_owned(),
            reason,
        };
        let body_of = |name: &str| {
            let place = spec.bodies.iter().position(|b| b.name == name);
            place.ok_or_else(|| wrong("no such body"))
        };
        let body = body_of(&contact.body)?;
        let mut end_planes = false;
        let with = match &contact.with {
            PartnerSpec::Tool(name) => {
                let tool = spec.tools.iter().position(|t| t.name == *name);
                PairPartner::Tool(tool.ok_or_else(|| wrong("no such tool"))?)
            }
            PartnerSpec::Obstacle(name) => {
                let obstacle = obstacles.iter().position(|t| t.name == *name);
                let obstacle = obstacle.ok_or_else(|| wrong("no such obstacle"))?;
                PairPartner::Obstacle {
                    obstacle,
                    parts: obstacles[obstacle].parts.clone(),
                }
            }
            PartnerSpec::Body {
                name,
                end_planes: rule,
            } => {
                let other = body_of(name)?;
                if other == body {
                    return Err(wrong("a body and itself are no two bodies"));
                }
                let ends = [body, other].map(|b| spec.bodies[b].ends.is_empty());
                if *rule && ends.contains(&true) {
                    return Err(wrong(
                        "end planes are those of two bodies from the generator of tubes",
                    ));
                }
                end_planes = *rule;
                PairPartner::Body(other)
            }
            PartnerSpec::Itself => PairPartner::Itself,
        };
        let same = |pair: &Pair| {
            let turned =
                pair.with == PairPartner::Body(body) && with == PairPartner::Body(pair.body);
            (pair.body == body && pair.with == with) || turned
        };
        if pairs.iter().any(same) {
            return Err(wrong("occurs twice"));
        }
        if !contact.friction.is_finite() || contact.friction < 0.0 {
            return Err(wrong("friction is a number of at least 0"));
        }
        if contact.force_limit.is_nan() || contact.force_limit < 0.0 {
            return Err(wrong("the limit of the force is at least 0 N"));
        }
        if contact.response != ContactResponse::Constraint {
            if !spec.method.is_explicit() {
                return Err(wrong(
                    "a response other than `constraint` is for explicit methods: implicit and position-based ones have contact in their equations",
                ));
            }
            if contact.friction > 0.0 || end_planes {
                return Err(wrong(
                    "a response other than `constraint` knows neither friction nor end planes",
                ));
            }
        }
        let stiff = match contact.response {
            ContactResponse::Penalty { stiffness, .. } => stiffness.is_finite() && stiffness > 0.0,
            ContactResponse::Constraint | ContactResponse::TargetForce { .. } => true,
        };
        if !stiff {
            return Err(wrong("the stiffness of a penalty is above 0 N/m"));
        }
        let mut grip = Vec::new();
        if contact.grip == Grip::Box {
            let PairPartner::Tool(tool) = with else {
                return Err(wrong("a box grip is that of a tool with two jaws"));
            };
            grip = box_grip::couples(&spec.tools[tool].capsules);
            if grip.is_empty() {
                return Err(wrong(
                    "a box grip needs a line of no return in each of two jaws: there is no box between others",
                ));
            }
            if !spec.method.is_explicit() || spec.method == Method::ExplicitEuler {
                return Err(wrong(
                    "a box grip is a force that brings nodes to where the jaws are by the end of a step: for explicit methods but explicit-euler",
                ));
            }
        }
        pairs.push(Pair {
            body,
            with,
            friction: contact.friction,
            force_limit: contact.force_limit,
            end_planes,
            response: contact.response,
            grip,
        });
    }
    Ok(pairs)
}
