//! Finding points of contact.

use crate::body::Body;
use crate::body_pair::{self, BodyPair};
use crate::broad_phase::BroadPhaseMethod;
use crate::capsule_motion::CapsuleMotion;
use crate::features::Features;
use crate::frame::Frame;
use crate::node_face::Pass;
use crate::obstacle::ObstaclePart;
use crate::pair::{ContactPair, Detection, VesselEnd};
use crate::point::Point;
use crate::surface::ContactSurface;
use crate::surface_update::SurfaceUpdate;
use crate::{near, obstacle_contact, tool_contact};

/// Finds the points of contact of a group of bodies. What it retains from call to call is working memory: a result depends on the
/// arguments only.
///
/// ```
/// use microsim_contact::{ContactPair, ContactSurface, Detector, Frame, ObstaclePart, ObstacleShape, Sides};
/// use microsim_geometry::Pose;
/// use microsim_mesh::{Block, CellSplit};
/// use nalgebra::Vector3;
///
/// // A cube on the plane z = 0, which sinks in by 0.1 during a step.
/// let block = Block { center: [0.0, 0.0, 0.5], size: [1.0; 3], cells: [1; 3], split: CellSplit::Kuhn };
/// let cube = block.mesh()?;
/// let plane = ObstaclePart { shape: ObstacleShape::HalfSpace, pose: Pose::identity() };
/// let pair = ContactPair::Obstacle { body: 0, part: 0 };
/// let mut detector = Detector::new(vec![ContactSurface::new(&cube, 0)], vec![plane], vec![pair]);
/// let now: Vec<_> = cube.positions.iter().map(|p| p - Vector3::z() * 0.1).collect();
/// let frame = Frame {
///     start: &cube.positions,
///     now: &now,
///     tools: &[],
///     fraction: 1.0,
///     reach: 0.01,
///     sides: &Sides::new(),
/// };
/// let mut points = Vec::new();
/// detector.find(&frame, &mut points);
/// assert_eq!(points.len(), 4, "the corners of the lower face");
/// assert!(points.iter().all(|point| (point.gap + 0.1).abs() < 1e-15 && point.normal == Vector3::z()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Detector {
    pub(crate) bodies: Vec<Body>,
    obstacles: Vec<ObstaclePart>,
    pairs: Vec<Pair>,
    /// Working memory.
    features: Features,
    pub(crate) tool_scratch: tool_contact::Scratch,
}

/// A pair, with both passes where bodies touch one another.
#[derive(Clone, Debug)]
struct Pair {
    touch: ContactPair,
    detection: Detection,
    passes: [Pass; 2],
}

impl Detector {
    /// For these bodies, whose nodes are numbered body after body, parts of obstacles and pairs. A pair that names one that is not there
    /// is left out.
    pub fn new(
        bodies: Vec<ContactSurface>,
        obstacles: Vec<ObstaclePart>,
        mut pairs: Vec<ContactPair>,
    ) -> Self {
        let there = |body: &u32| (*body as usize) < bodies.len();
        pairs.retain(|pair| match pair {
            ContactPair::Tool { body, .. } | ContactPair::Itself { body } => there(body),
            ContactPair::Obstacle { body, part } => {
                there(body) && (*part as usize) < obstacles.len()
            }
            ContactPair::Bodies { body, with, .. } => there(body) && there(with) && body != with,
        });
        let bodies = bodies.into_iter().enumerate();
        let mut bodies: Vec<Body> = bodies
            .map(|(index, surface)| Body::new(index as u32, surface))
            .collect();
        for pair in &pairs {
            match *pair {
                ContactPair::Bodies { body, with, .. } => {
                    bodies[body as usize].tree.want_tets();
                    bodies[with as usize].tree.want_tets();
                }
                ContactPair::Itself { body } => bodies[body as usize].tree.want_tets(),
                ContactPair::Tool { .. } | ContactPair::Obstacle { .. } => {}
            }
        }
        let pairs = pairs.into_iter().map(|touch| Pair {
            touch,
            detection: Detection::default(),
            passes: Default::default(),
        });
        Self {
            bodies,
            obstacles,
            pairs: pairs.collect(),
            features: Features::default(),
            tool_scratch: tool_contact::Scratch::default(),
        }
    }

    /// The same detector with another broad phase.
    #[must_use]
    pub fn with_broad_phase(mut self, broad_phase: BroadPhaseMethod) -> Self {
        for body in &mut self.bodies {
            body.tree.set_broad_phase(broad_phase, &body.surface);
        }
        self
    }

    /// Updates a body after an edit of its mesh; those behind it in the group are updated as well, as their nodes have other numbers.
    pub fn update_after_edit(&mut self, body: u32, change: &SurfaceUpdate<'_>) {
        self.bodies[body as usize].update_after_edit(change);
        for pair in &mut self.pairs {
            pair.passes = Default::default();
        }
    }

    /// Gives the pair of two bodies, in this order, other ends.
    pub fn set_ends(&mut self, pair: [u32; 2], ends: [VesselEnd; 2]) {
        for Pair { touch, .. } in &mut self.pairs {
            match touch {
                ContactPair::Bodies {
                    body,
                    with,
                    ends: of_pair,
                } if [*body, *with] == pair => *of_pair = Some(ends.clone()),
                _ => {}
            }
        }
    }

    /// Gives the pair of two bodies, in this order, or of a body and itself, another detection.
    pub fn set_detection(&mut self, bodies: [u32; 2], of: Detection) {
        for Pair {
            touch, detection, ..
        } in &mut self.pairs
        {
            let touching = match *touch {
                ContactPair::Bodies { body, with, .. } => [body, with],
                ContactPair::Itself { body } => [body, body],
                ContactPair::Tool { .. } | ContactPair::Obstacle { .. } => continue,
            };
            if touching == bodies {
                *detection = of;
            }
        }
    }

    /// The bodies whose triangles a pair needs to look up, if it does.
    fn needs(&self, touch: &ContactPair, frame: &Frame<'_>) -> Option<[u32; 2]> {
        let (needs, bodies) = match *touch {
            ContactPair::Tool { body, tool } => {
                let capsules = frame.tools.get(tool as usize).and_then(Option::as_ref);
                let reached = |capsules: &Vec<CapsuleMotion>| {
                    let of = &self.bodies[body as usize];
                    capsules
                        .iter()
                        .any(|motion| tool_contact::reach(of, motion, frame).is_some())
                };
                (capsules.is_some_and(reached), [body; 2])
            }
            ContactPair::Obstacle { body, part } => {
                let obstacle = &self.obstacles[part as usize];
                let needs =
                    obstacle_contact::needs_triangles(&self.bodies[body as usize], obstacle, frame);
                (needs, [body; 2])
            }
            ContactPair::Itself { body } => (true, [body; 2]),
            ContactPair::Bodies { body, with, .. } => {
                let [first, second] = [body, with].map(|body| &self.bodies[body as usize]);
                let reach = body_pair::reach(first, frame).max(body_pair::reach(second, frame));
                (near::may_meet(first, second, reach), [body, with])
            }
        };
        needs.then_some(bodies)
    }

    /// Replaces `points` by all points with a gap below `frame.reach`, ascending by their keys.
    pub fn find(&mut self, frame: &Frame<'_>, points: &mut Vec<Point>) {
        points.clear();
        for body in &mut self.bodies {
            body.update(frame);
        }
        for index in 0..self.pairs.len() {
            let needed = self.needs(&self.pairs[index].touch, frame);
            for body in needed.into_iter().flatten() {
                let Body { tree, surface, .. } = &mut self.bodies[body as usize];
                tree.build(surface);
            }
        }
        for Pair {
            touch,
            detection,
            passes,
        } in &mut self.pairs
        {
            let (features, scratch) = (&mut self.features, &mut self.tool_scratch);
            match touch {
                &mut ContactPair::Tool { body, tool } => {
                    if let Some(Some(capsules)) = frame.tools.get(tool as usize) {
                        let body = &self.bodies[body as usize];
                        tool_contact::find(
                            body,
                            (tool, capsules),
                            frame,
                            features,
                            scratch,
                            points,
                        );
                    }
                }
                &mut ContactPair::Obstacle { body, part } => {
                    let obstacle = (part, &self.obstacles[part as usize]);
                    let body = &self.bodies[body as usize];
                    obstacle_contact::find(body, obstacle, frame, features, points);
                }
                ContactPair::Bodies { body, with, ends } => {
                    let [first, second] = [*body, *with].map(|body| &self.bodies[body as usize]);
                    let [own, other] = match ends {
                        Some([own, other]) => [Some(&*own), Some(&*other)],
                        None => [None; 2],
                    };
                    let there = BodyPair {
                        first,
                        second,
                        frame,
                    };
                    let back = BodyPair {
                        first: second,
                        second: first,
                        frame,
                    };
                    if let Detection::Discrete(depth) = *detection {
                        passes[0].find_inside(there, depth, points);
                        passes[1].find_inside(back, depth, points);
                        continue;
                    }
                    passes[0].find(there, other, points);
                    passes[1].find(back, own, points);
                    let [there_direction, back_direction] = passes;
                    there_direction.find_edges(Some(back_direction), there, points);
                }
                &mut ContactPair::Itself { body } => {
                    let body = &self.bodies[body as usize];
                    let itself = BodyPair {
                        first: body,
                        second: body,
                        frame,
                    };
                    if let Detection::Discrete(depth) = *detection {
                        passes[0].find_inside(itself, depth, points);
                        continue;
                    }
                    passes[0].find(itself, None, points);
                    passes[0].find_edges(None, itself, points);
                }
            }
        }
        points.retain(Point::is_finite);
        points.sort_unstable_by(|a, b| a.key.cmp(&b.key).then(a.gap.total_cmp(&b.gap)));
        points.dedup_by_key(|point| point.key);
    }
}
