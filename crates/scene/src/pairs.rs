//! What touches what: rigid things and pairs, from their description.

use crate::error::SceneError;
use crate::spec::{PartnerSpec, RigidSpec, SceneSpec};
use microsim_contact::{Rigid, RigidShape};
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
}

/// What a body touches, by indices.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PairPartner {
    Tool(usize),
    Rigid {
        thing: usize,
        /// Its parts among those of all things.
        parts: Range<usize>,
    },
    Body(usize),
    Itself,
}

/// A rigid thing.
#[derive(Clone, Debug)]
pub(crate) struct Thing {
    pub name: String,
    /// Its parts among those of all things.
    pub parts: Range<usize>,
}

/// The rigid things, and the parts of all of them.
pub(crate) fn rigid(specs: &[RigidSpec]) -> Result<(Vec<Thing>, Vec<Rigid>), SceneError> {
    let (mut things, mut all) = (Vec::new(), Vec::new());
    for spec in specs {
        let sized = |part: &Rigid| match part.shape {
            RigidShape::HalfSpace => true,
            RigidShape::Cuboid {
                half_size,
                rounding,
            } => {
                let least = half_size.into_iter().fold(f64::INFINITY, f64::min);
                half_size.iter().all(|s| s.is_finite() && *s > 0.0)
                    && (0.0..=least).contains(&rounding)
            }
            RigidShape::Cylinder {
                radius,
                half_length,
            } => [radius, half_length]
                .iter()
                .all(|s| s.is_finite() && *s > 0.0),
        };
        let right = |part: &Rigid| part.pose.is_finite() && sized(part);
        if spec.parts.is_empty() || !spec.parts.iter().all(right) {
            return Err(SceneError::Rigid {
                name: spec.name.clone(),
            });
        }
        let first = all.len();
        all.extend_from_slice(&spec.parts);
        things.push(Thing {
            name: spec.name.clone(),
            parts: first..all.len(),
        });
    }
    Ok((things, all))
}

/// The pairs of a description.
pub(crate) fn find_pairs(spec: &SceneSpec, things: &[Thing]) -> Result<Vec<Pair>, SceneError> {
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
            PartnerSpec::Rigid(name) => {
                let thing = things.iter().position(|t| t.name == *name);
                let thing = thing.ok_or_else(|| wrong("no such rigid thing"))?;
                PairPartner::Rigid {
                    thing,
                    parts: things[thing].parts.clone(),
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
            return Err(wrong("stands twice"));
        }
        if !contact.friction.is_finite() || contact.friction < 0.0 {
            return Err(wrong("friction is a number of at least 0"));
        }
        if contact.force_limit.is_nan() || contact.force_limit < 0.0 {
            return Err(wrong("the limit of the force is at least 0 N"));
        }
        pairs.push(Pair {
            body,
            with,
            friction: contact.friction,
            force_limit: contact.force_limit,
            end_planes,
        });
    }
    Ok(pairs)
}
