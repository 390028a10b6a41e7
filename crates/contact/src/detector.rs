//! Finding points of contact.

use crate::body::{Body, Scratch};
use crate::capsule_motion::CapsuleMotion;
use crate::meshes::{Direction, Meeting};
use crate::point::Point;
use crate::rigid::Rigid;
use crate::sides::Sides;
use crate::skin::Skin;
use crate::skin_change::SkinChange;
use crate::{meshes, near, standing, tool};
use nalgebra::Vector3;

/// What may touch what. Bodies and rigid things are named by their places in the lists given to [`Detector::new`], tools by
/// theirs in [`Frame::tools`].
#[derive(Clone, Debug, PartialEq)]
pub enum Touch {
    /// A tool and a body.
    Tool {
        /// The body.
        body: u32,
        /// The tool.
        tool: u32,
    },
    /// A rigid thing and a body.
    Rigid {
        /// The body.
        body: u32,
        /// The thing.
        thing: u32,
    },
    /// Two bodies.
    Bodies {
        /// One body.
        body: u32,
        /// The other.
        with: u32,
        /// The ends of two vessels that lie opposite to one another, of `body` and of `with`: there nodes are brought before the
        /// other end's plane (dissertation 4.3).
        ends: Option<[VesselEnd; 2]>,
    },
    /// A body and itself.
    Itself {
        /// The body.
        body: u32,
    },
}

/// The end of a vessel.
#[derive(Clone, Debug, PartialEq)]
pub struct VesselEnd {
    /// The triangles of its face, outward, in the group's numbering of nodes.
    pub triangles: Vec<[u32; 3]>,
}

/// Where everything is.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// Positions of the group's nodes before the step \[m\].
    pub start: &'a [Vector3<f64>],
    /// Positions at which points are wanted \[m\].
    pub now: &'a [Vector3<f64>],
    /// The capsules of each tool over the step; `None` of a tool that is away.
    pub tools: &'a [Option<Vec<CapsuleMotion>>],
    /// How much of the tools' motion belongs to `now`, 0..1.
    pub way: f64,
    /// Points with a gap below this are found \[m\], ≥ 0.
    pub reach: f64,
    /// The normals that the step before ended with.
    pub sides: &'a Sides,
}

/// Finds the points of contact of a group of bodies. What it keeps from call to call is working memory: a result depends on the
/// arguments only.
#[derive(Clone, Debug)]
pub struct Detector {
    pub(crate) bodies: Vec<Body>,
    rigid: Vec<Rigid>,
    pairs: Vec<Pair>,
    scratch: Scratch,
}

/// A pair, with what is kept of it where bodies touch one another.
#[derive(Clone, Debug)]
struct Pair {
    touch: Touch,
    directions: [Direction; 2],
}

impl Detector {
    /// For these bodies, whose nodes are numbered body after body, rigid things and pairs. A pair that names a body or thing that is not there
    /// is left out.
    pub fn new(bodies: Vec<Skin>, rigid: Vec<Rigid>, mut pairs: Vec<Touch>) -> Self {
        let there = |body: &u32| (*body as usize) < bodies.len();
        pairs.retain(|pair| match pair {
            Touch::Tool { body, .. } | Touch::Itself { body } => there(body),
            Touch::Rigid { body, thing } => there(body) && (*thing as usize) < rigid.len(),
            Touch::Bodies { body, with, .. } => there(body) && there(with) && body != with,
        });
        let bodies = bodies.into_iter().enumerate();
        let mut bodies: Vec<Body> = bodies
            .map(|(index, skin)| Body::new(index as u32, skin))
            .collect();
        for pair in &pairs {
            match *pair {
                Touch::Bodies { body, with, .. } => {
                    bodies[body as usize].tree.want_tets();
                    bodies[with as usize].tree.want_tets();
                }
                Touch::Itself { body } => bodies[body as usize].tree.want_tets(),
                Touch::Tool { .. } | Touch::Rigid { .. } => {}
            }
        }
        let pairs = pairs.into_iter().map(|touch| Pair {
            touch,
            directions: Default::default(),
        });
        Self {
            bodies,
            rigid,
            pairs: pairs.collect(),
            scratch: Scratch::default(),
        }
    }

    /// Follows a cut of a body; those behind it in the group follow as well, as their nodes have other numbers.
    pub fn follow(&mut self, body: u32, change: &SkinChange<'_>) {
        self.bodies[body as usize].follow(change);
        for pair in &mut self.pairs {
            pair.directions = Default::default();
        }
    }

    /// Gives the pair of two bodies, in this order, other ends.
    pub fn set_ends(&mut self, pair: [u32; 2], ends: [VesselEnd; 2]) {
        for Pair { touch, .. } in &mut self.pairs {
            match touch {
                Touch::Bodies {
                    body,
                    with,
                    ends: of_pair,
                } if [*body, *with] == pair => *of_pair = Some(ends.clone()),
                _ => {}
            }
        }
    }

    /// Whether a pair asks where triangles are, and of which bodies.
    fn asks(&self, touch: &Touch, frame: &Frame<'_>) -> Option<[u32; 2]> {
        let (asks, bodies) = match *touch {
            Touch::Tool { body, tool } => {
                let capsules = frame.tools.get(tool as usize).and_then(Option::as_ref);
                let reached = |capsules: &Vec<CapsuleMotion>| {
                    let of = &self.bodies[body as usize];
                    capsules
                        .iter()
                        .any(|motion| tool::reach(of, motion, frame).is_some())
                };
                (capsules.is_some_and(reached), [body; 2])
            }
            Touch::Rigid { body, thing } => {
                let rigid = &self.rigid[thing as usize];
                let asks = standing::asks_for_triangles(&self.bodies[body as usize], rigid, frame);
                (asks, [body; 2])
            }
            Touch::Itself { body } => (true, [body; 2]),
            Touch::Bodies { body, with, .. } => {
                let [first, second] = [body, with].map(|body| &self.bodies[body as usize]);
                let reach = meshes::reach(first, frame).max(meshes::reach(second, frame));
                (near::may_meet(first, second, reach), [body, with])
            }
        };
        asks.then_some(bodies)
    }

    /// Replaces `points` by all points with a gap below `frame.reach`, ascending by their keys.
    pub fn find(&mut self, frame: &Frame<'_>, points: &mut Vec<Point>) {
        points.clear();
        for body in &mut self.bodies {
            body.update(frame);
        }
        for index in 0..self.pairs.len() {
            let asked = self.asks(&self.pairs[index].touch, frame);
            for body in asked.into_iter().flatten() {
                let Body { tree, skin, .. } = &mut self.bodies[body as usize];
                tree.build(skin);
            }
        }
        for Pair { touch, directions } in &mut self.pairs {
            let scratch = &mut self.scratch;
            match touch {
                &mut Touch::Tool { body, tool } => {
                    if let Some(Some(capsules)) = frame.tools.get(tool as usize) {
                        let body = &self.bodies[body as usize];
                        tool::find(body, (tool, capsules), frame, scratch, points);
                    }
                }
                &mut Touch::Rigid { body, thing } => {
                    let rigid = (thing, &self.rigid[thing as usize]);
                    let body = &self.bodies[body as usize];
                    standing::find(body, rigid, frame, scratch, points);
                }
                Touch::Bodies { body, with, ends } => {
                    let [first, second] = [*body, *with].map(|body| &self.bodies[body as usize]);
                    let [own, other] = match ends {
                        Some([own, other]) => [Some(&*own), Some(&*other)],
                        None => [None; 2],
                    };
                    let there = Meeting {
                        first,
                        second,
                        frame,
                    };
                    let back = Meeting {
                        first: second,
                        second: first,
                        frame,
                    };
                    directions[0].find(there, other, points);
                    directions[1].find(back, own, points);
                    let [there_direction, back_direction] = directions;
                    there_direction.find_edges(Some(back_direction), there, points);
                }
                &mut Touch::Itself { body } => {
                    let body = &self.bodies[body as usize];
                    let itself = Meeting {
                        first: body,
                        second: body,
                        frame,
                    };
                    directions[0].find(itself, None, points);
                    directions[0].find_edges(None, itself, points);
                }
            }
        }
        points.retain(Point::is_finite);
        points.sort_unstable_by(|a, b| a.key.cmp(&b.key).then(a.gap.total_cmp(&b.gap)));
        points.dedup_by_key(|point| point.key);
    }
}
