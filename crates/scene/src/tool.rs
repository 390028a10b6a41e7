//! Tools: capsules posed by a pose and an opening.

use crate::error::SceneError;
use crate::jet::Jet;
use crate::spec::{CapsuleSpec, IrrigationSpec, Jaw, ToolKeySpec, ToolSpec};
use microsim_contact::CapsuleMotion;
use microsim_geometry::{Aabb, Capsule, Joint, Pose};
use nalgebra::{Unit, Vector3};

/// The motion of one tool during a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolMotion {
    /// Index of the tool in the scene.
    pub tool: usize,
    /// `world_from_tool` at the start of the tick.
    pub from: Pose,
    /// `world_from_tool` at the end of the tick.
    pub to: Pose,
    /// Opening at the start, in units of the tool's joints (0 is closed).
    pub opening_from: f64,
    /// Opening at the end.
    pub opening_to: f64,
    /// Whether the tool touches anything; one that is not seen does not.
    pub active: bool,
}

impl ToolMotion {
    /// Whether every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.from.is_finite()
            && self.to.is_finite()
            && self.opening_from.is_finite()
            && self.opening_to.is_finite()
    }

    /// Its first part, the fraction `reach` of it, 0..1; at 1 the same to the bit.
    pub(crate) fn first_part(&self, reach: f64) -> Self {
        if reach >= 1.0 {
            return *self;
        }
        let opened = self.opening_to - self.opening_from;
        Self {
            to: self.from.interpolate(&self.to, reach),
            opening_to: self.opening_from + opened * reach,
            ..*self
        }
    }
}

/// A checked tool.
#[derive(Clone, Debug)]
pub(crate) struct Tool {
    pub name: String,
    parts: Vec<Part>,
    /// Of both jaws against what opens or closes them, per unit of opening \[J\]; infinite where they are rigid.
    pub jaw_stiffness: f64,
    /// By what the tips come together per unit of opening \[m\]; 0 without jaws, and where they cut what they close on.
    path_of_closing: f64,
    /// Whether its lines of no return cut a body.
    pub cuts: bool,
    irrigation: Option<IrrigationSpec>,
    /// Its own motion; empty where it is moved from outside.
    pub motion: Vec<ToolKeySpec>,
}

#[derive(Clone, Debug)]
struct Part {
    name: String,
    capsule: Capsule,
    joint: Joint,
    jaw: Option<Jaw>,
    lonor: bool,
    edge: Option<Vector3<f64>>,
    lonor_offset: Option<Vector3<f64>>,
}

/// A line of no return in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lonor {
    /// The capsule whose axis it is.
    pub capsule: u32,
    pub a: Vector3<f64>,
    pub b: Vector3<f64>,
    /// Of the capsule \[m\].
    pub radius: f64,
    /// Where a single blade is sharp, of length 1.
    pub edge: Option<Vector3<f64>>,
    pub jaw: Option<Jaw>,
}

impl Tool {
    pub fn new(spec: &ToolSpec) -> Result<Self, SceneError> {
        let wrong = |part| SceneError::Tool {
            tool: spec.name.clone(),
            part,
        };
        let is_sharp = (0.0..=1.0).contains(&spec.sharpness);
        let is_stiff = spec.jaw_stiffness > 0.0;
        if spec.capsules.is_empty() || !is_sharp || !is_stiff {
            return Err(wrong(None));
        }
        let parts = spec.capsules.iter().enumerate().map(|(index, part)| {
            let capsule = Capsule {
                a: part.a.into(),
                b: part.b.into(),
                radius: part.radius,
            };
            let joint = part.joint;
            let ends_finite = capsule.a.iter().chain(&capsule.b).all(|c| c.is_finite());
            let no_line = part.lonor && capsule.a == capsule.b;
            let finite = ends_finite && capsule.radius.is_finite() && joint.is_finite();
            if !finite || capsule.radius <= 0.0 || no_line {
                return Err(wrong(Some(index)));
            }
            let offset = part.lonor_offset.map(Vector3::from);
            // Written so that what is not a number is refused.
            if offset
                .is_some_and(|offset| offset.norm() >= capsule.radius || !offset.norm().is_finite())
            {
                return Err(wrong(Some(index)));
            }
            let edge = match part.edge {
                None => None,
                Some(edge) => {
                    let edge = Unit::try_new(Vector3::from(edge), 0.0);
                    let edge = edge.filter(|edge| edge.iter().all(|c| c.is_finite()));
                    Some(edge.ok_or_else(|| wrong(Some(index)))?.into_inner())
                }
            };
            Ok(Part {
                name: part.name.clone(),
                capsule,
                joint,
                jaw: part.jaw,
                lonor: part.lonor,
                edge,
                lonor_offset: offset,
            })
        });
        let parts = parts.collect::<Result<Vec<_>, _>>()?;
        if spec.irrigation.is_some_and(|of| !is_valid(&of)) {
            return Err(SceneError::Irrigation {
                tool: spec.name.clone(),
            });
        }
        let mut latest = f64::NEG_INFINITY;
        for (index, key) in spec.motion.iter().enumerate() {
            let finite = key.time.is_finite() && key.pose.is_finite() && key.opening.is_finite();
            if !finite || key.time <= latest {
                return Err(SceneError::ToolMotion {
                    tool: spec.name.clone(),
                    key: index,
                });
            }
            latest = key.time;
        }
        let paths = paths_of_tips(&spec.capsules);
        Ok(Self {
            name: spec.name.clone(),
            parts,
            jaw_stiffness: spec.jaw_stiffness * squared_paths(paths),
            path_of_closing: match spec.sharpness > 0.0 {
                true => 0.0,
                false => paths.iter().sum(),
            },
            cuts: false,
            irrigation: spec.irrigation,
            motion: spec.motion.clone(),
        })
    }

    /// The same tool; `cuts` is whether its lines of no return cut a body.
    pub fn cutting(self, cuts: bool) -> Self {
        Self { cuts, ..self }
    }

    /// The jet of its fluid at a pose and an opening; `None` where nothing flows.
    pub fn jet(&self, world_from_tool: &Pose, opening: f64) -> Option<Jet> {
        let of = self.irrigation.filter(|_| opening > 0.0)?;
        let direction = world_from_tool.orientation * Vector3::from(of.direction);
        Some(Jet {
            tip: world_from_tool.apply(&of.position.into()),
            direction: direction.normalize(),
            pressure: of.pressure * opening.min(1.0),
            radius: of.radius,
            reach: of.reach,
        })
    }

    /// Whether its fluid flows at any time of a motion.
    pub fn irrigates(&self, motion: &ToolMotion) -> bool {
        self.irrigation.is_some() && motion.opening_from.max(motion.opening_to) > 0.0
    }

    /// By what its tips come together in a motion \[m\]; 0 where they open.
    pub fn closing(&self, motion: &ToolMotion) -> f64 {
        (motion.opening_from - motion.opening_to).max(0.0) * self.path_of_closing
    }

    /// The name of a capsule.
    pub fn part_name(&self, capsule: u32) -> &str {
        let part = self.parts.get(capsule as usize);
        part.map_or("", |part| &part.name)
    }

    /// The jaw that a capsule belongs to.
    pub fn jaw(&self, capsule: u32) -> Option<Jaw> {
        self.parts.get(capsule as usize).and_then(|part| part.jaw)
    }

    /// The jaws that its capsules belong to.
    pub fn jaws(&self) -> Vec<Option<Jaw>> {
        self.parts.iter().map(|part| part.jaw).collect()
    }

    /// Its own pose and opening at `time` \[s\].
    pub fn own_place(&self, time: f64) -> Option<(Pose, f64)> {
        let next = self.motion.partition_point(|key| key.time <= time);
        let before = next.checked_sub(1).map(|index| &self.motion[index]);
        match (before, self.motion.get(next)) {
            (Some(one), Some(two)) => {
                let fraction = (time - one.time) / (two.time - one.time);
                let opening = one.opening + (two.opening - one.opening) * fraction;
                Some((one.pose.interpolate(&two.pose, fraction), opening))
            }
            (Some(key), None) | (None, Some(key)) => Some((key.pose, key.opening)),
            (None, None) => None,
        }
    }

    /// The capsules in the world at the fraction `t` (0..1) of a motion.
    pub fn capsules_at<'a>(
        &'a self,
        motion: &ToolMotion,
        t: f64,
    ) -> impl Iterator<Item = Capsule> + 'a {
        let world_from_tool = motion.from.interpolate(&motion.to, t);
        let opening = motion.opening_from + (motion.opening_to - motion.opening_from) * t;
        self.capsules_of(&world_from_tool, opening)
    }

    /// The capsules in the world at a pose and an opening.
    pub fn capsules_of<'a>(
        &'a self,
        world_from_tool: &Pose,
        opening: f64,
    ) -> impl Iterator<Item = Capsule> + use<'a> {
        let world_from_tool = *world_from_tool;
        self.parts
            .iter()
            .map(move |part| part.at(opening).posed(&world_from_tool))
    }

    /// How a place of a capsule in the world \[m\] moves as the tool opens, per unit of opening \[m\].
    pub fn path_of_opening(
        &self,
        capsule: u32,
        world_from_tool: &Pose,
        place: &Vector3<f64>,
    ) -> Vector3<f64> {
        match self.parts[capsule as usize].joint {
            Joint::Fixed => Vector3::zeros(),
            Joint::Hinge(hinge) => {
                let axis = world_from_tool.orientation * hinge.axis.into_inner();
                axis.cross(&(place - world_from_tool.apply(&hinge.pivot))) * hinge.angle
            }
        }
    }

    /// Its lines of no return in the world at the fraction `t` (0..1) of a motion.
    pub fn lines(&self, motion: &ToolMotion, t: f64) -> Vec<Lonor> {
        let world_from_tool = motion.from.interpolate(&motion.to, t);
        let opening = motion.opening_from + (motion.opening_to - motion.opening_from) * t;
        let cutting = self.parts.iter().enumerate().filter(|(_, part)| part.lonor);
        let lines = cutting.map(|(index, part)| {
            let Capsule { a, b, radius } = part.at(opening).posed(&world_from_tool);
            let turned = |direction: Vector3<f64>| {
                world_from_tool.orientation * part.joint.direction_at(direction, opening)
            };
            let edge = part.edge.map(turned);
            let beside = |end: Vector3<f64>| match part.lonor_offset {
                None => end,
                Some(offset) => end + turned(offset),
            };
            Lonor {
                capsule: index as u32,
                a: beside(a),
                b: beside(b),
                radius,
                edge,
                jaw: part.jaw,
            }
        });
        lines.collect()
    }

    /// The capsules over a step, from the fraction `t0` to `t1` of a motion.
    pub fn step(&self, motion: &ToolMotion, t0: f64, t1: f64) -> Vec<CapsuleMotion> {
        let ends = self.capsules_at(motion, t1);
        self.capsules_at(motion, t0)
            .zip(ends)
            .map(|(start, end)| CapsuleMotion { start, end })
            .collect()
    }

    /// How many steps a motion takes in which no part goes further than this fraction of its own radius or of `edge` \[m\], whichever is less, where it
    /// comes into a box; 0 where none does. A shaft that turns about its tip goes far where it touches nothing, and one about its own axis not at all.
    pub fn steps_within(
        &self,
        motion: &ToolMotion,
        bounds: &Aabb,
        edge: f64,
        fraction: f64,
    ) -> f64 {
        let translation = (motion.to.position - motion.from.position).norm();
        let angle = motion.from.angle_to(&motion.to);
        // In the frame of the tool, the turn that the motion ends with.
        let turn = motion.from.orientation.inverse() * motion.to.orientation;
        let axis = turn.imag().try_normalize(0.0);
        let openings = [motion.opening_from, motion.opening_to];
        let poses = [0.0, 1.0].map(|t| self.capsules_at(motion, t).collect::<Vec<_>>());
        let mut most = 0.0f64;
        for (index, part) in self.parts.iter().enumerate() {
            // A path at a constant distance from the axis, but for what a joint changes of it.
            let of_end = |end: Vector3<f64>| {
                let point = Capsule {
                    a: end,
                    b: end,
                    radius: part.capsule.radius,
                };
                let path = part.joint.bounds(&point, openings).path;
                let place = part.joint.capsule_at(&point, motion.opening_from).a;
                let arm = axis.map_or(0.0, |axis| axis.cross(&place).norm());
                translation + path + (arm + path) * angle
            };
            let ends = [part.capsule.a, part.capsule.b].map(of_end);
            let radius = part.capsule.radius;
            // No point is ever further from the nearer end of its path than half the path.
            let around = bounds.inflated(radius + 0.5 * ends[0].max(ends[1]));
            for capsules in &poses {
                let capsule = &capsules[index];
                if let Some(within) = around.clip(&capsule.a, &capsule.b) {
                    let travel = within.map(|t| ends[0] + (ends[1] - ends[0]) * t);
                    let travel = travel[0].max(travel[1]);
                    most = most.max(travel / (fraction * radius.min(edge)));
                }
            }
        }
        most
    }
}

/// Whether the values of a fluid mean anything.
fn is_valid(of: &IrrigationSpec) -> bool {
    let mut numbers = of.position.iter().chain(&of.direction);
    let is_finite = numbers.all(|c| c.is_finite()) && of.pressure.is_finite();
    let is_positive = |value: f64| value.is_finite() && value > 0.0;
    let has_size = is_positive(of.radius) && is_positive(of.reach);
    // The squares of smaller and of larger ones have no sum.
    let length = Vector3::from(of.direction).norm();
    let has_direction = length > 1e-6 && length.is_finite();
    is_finite && has_size && of.pressure >= 0.0 && has_direction
}

/// l α of both jaws \[m\], with the distance l of the tip from the hinge and the turn α per unit of opening; 0 of one that does not turn.
fn paths_of_tips(capsules: &[CapsuleSpec]) -> [f64; 2] {
    [Jaw::Left, Jaw::Right].map(|jaw| {
        let parts = capsules.iter().filter(|part| part.jaw == Some(jaw));
        let paths = parts.filter_map(|part| match part.joint {
            Joint::Hinge(hinge) => {
                let reach = |end: [f64; 3]| (Vector3::from(end) - hinge.pivot).norm();
                Some(reach(part.a).max(reach(part.b)) * hinge.angle.abs())
            }
            Joint::Fixed => None,
        });
        paths.fold(0.0, f64::max)
    })
}

/// The sum of their squares \[m²\]: times the stiffness of a tip it is that of the opening. Infinite without jaws, which nothing opens.
fn squared_paths(paths: [f64; 2]) -> f64 {
    let sum: f64 = paths.iter().map(|path| path * path).sum();
    if sum > 0.0 { sum } else { f64::INFINITY }
}

/// How strongly two jaws press against each other through what lies between them: the smaller of their pushes in the direction in
/// which each closes. `axis` is the x axis of their tool. Jaws that push to the same side, as tissue lies on them, squeeze nothing.
pub(crate) fn squeeze([left, right]: [Vector3<f64>; 2], axis: Vector3<f64>) -> f64 {
    (-left.dot(&axis)).min(right.dot(&axis)).max(0.0)
}

impl Part {
    /// The part in the tool's frame at an opening.
    fn at(&self, opening: f64) -> Capsule {
        self.joint.capsule_at(&self.capsule, opening)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::CapsuleSpec;
    use microsim_geometry::Hinge;
    use nalgebra::UnitQuaternion;

    fn jaw() -> Tool {
        let joint = Joint::Hinge(Hinge {
            pivot: Vector3::new(0.0, 0.0, 0.01),
            axis: Vector3::y_axis(),
            angle: 0.2,
        });
        let capsule = CapsuleSpec {
            joint,
            ..CapsuleSpec::new([0.0; 3], [0.0, 0.0, 0.01], 1e-4)
        };
        Tool::new(&ToolSpec {
            name: "jaw".into(),
            capsules: vec![capsule],
            sharpness: 0.0,
            jaw_stiffness: f64::INFINITY,
            irrigation: None,
            motion: Vec::new(),
        })
        .unwrap()
    }

    fn motion(to: Pose, opening_to: f64) -> ToolMotion {
        ToolMotion {
            tool: 0,
            from: Pose::identity(),
            to,
            opening_from: 0.0,
            opening_to,
            active: true,
        }
    }

    #[test]
    fn a_part_turns_about_its_hinge_by_angle_times_opening() {
        let tool = jaw();
        let motion = motion(
            Pose {
                position: Vector3::x(),
                ..Pose::identity()
            },
            1.5,
        );
        let half = tool.capsules_at(&motion, 0.5).next().unwrap();
        // Right-handed about +y by 0.15 rad: the tip, 10 mm below the pivot, goes to −x.
        let expected = Vector3::new(0.5 - 0.01 * sine(0.15), 0.0, 0.01 - 0.01 * cosine(0.15));
        assert!((half.a - expected).norm() < 1e-15, "{}", half.a);
        assert!((half.b - Vector3::new(0.5, 0.0, 0.01)).norm() < 1e-15);
    }

    // Taylor series to the last digit: the expected values do not come from the function under test.
    fn sine(x: f64) -> f64 {
        x - x.powi(3) / 6.0 + x.powi(5) / 120.0 - x.powi(7) / 5040.0 + x.powi(9) / 362_880.0
    }

    fn cosine(x: f64) -> f64 {
        1.0 - x.powi(2) / 2.0 + x.powi(4) / 24.0 - x.powi(6) / 720.0 + x.powi(8) / 40_320.0
    }

    /// Against the paths of its ends in a thousand parts of the motion: no shorter than they are, and not four times as long.
    #[test]
    fn steps_hold_the_path_of_what_is_in_the_box() {
        let tool = jaw();
        let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 2.5);
        let to = Pose {
            position: Vector3::new(1e-3, 2e-3, 0.0),
            orientation: turn,
        };
        let motion = motion(to, 3.0);
        let mut path = [0.0; 2];
        let mut last = tool.capsules_at(&motion, 0.0).next().unwrap();
        for i in 1..=1000 {
            let now = tool
                .capsules_at(&motion, f64::from(i) / 1000.0)
                .next()
                .unwrap();
            path[0] += (now.a - last.a).norm();
            path[1] += (now.b - last.b).norm();
            last = now;
        }
        let everywhere = Aabb::of(&[Vector3::zeros()]).inflated(1.0);
        // Of the radius of 0.1 mm.
        let travel = 1e-4 * tool.steps_within(&motion, &everywhere, f64::INFINITY, 1.0);
        assert!(path.iter().all(|w| *w <= travel), "{path:?} {travel}");
        assert!(
            path.iter().any(|w| *w > 0.25 * travel),
            "the bound is not idle: {path:?} {travel}"
        );
    }

    /// A rod of 10 mm that turns by 0.1 about its tip: where the box ends 1 mm from the tip, it goes 0.1 mm, and in one about its own axis nothing.
    #[test]
    fn what_is_outside_of_the_box_counts_for_nothing() {
        let tool = jaw();
        let turned = |axis, angle| {
            let orientation = UnitQuaternion::from_axis_angle(&axis, angle);
            let position = Vector3::zeros();
            motion(
                Pose {
                    position,
                    orientation,
                },
                0.0,
            )
        };
        let tip = Aabb::of(&[Vector3::repeat(-1e-3), Vector3::repeat(1e-3)]);
        let steps = |motion: &ToolMotion, bounds: &Aabb| {
            tool.steps_within(motion, bounds, f64::INFINITY, 1.0)
        };
        let aside = turned(Vector3::x_axis(), 0.1);
        let everywhere = tip.inflated(1.0);
        // By the radius and half of its longest path the box is larger.
        let reach = 1e-3 + 1e-4 + 0.5e-3;
        assert!((steps(&aside, &everywhere) - 10.0).abs() < 1e-9);
        let found = steps(&aside, &tip);
        assert!((found - reach * 0.1 / 1e-4).abs() < 0.01, "{found}");
        assert!(steps(&turned(Vector3::z_axis(), 1.0), &tip) < 1e-9);
        let far = Aabb::of(&[Vector3::repeat(0.1)]);
        assert_eq!(steps(&aside, &far), 0.0);
    }

    /// Pushes in units of a tool whose x axis is −y of the world. By hand: the smaller push along the closing directions counts, what
    /// acts across them does not; tissue draped over closed jaws is pushed up and outwards, a dilator pushes outwards alone.
    #[test]
    fn only_what_jaws_press_against_each_other_is_a_squeeze() {
        let axis = -Vector3::y();
        let squeeze = |left: [f64; 3], right: [f64; 3]| {
            let world = |[x, y, z]: [f64; 3]| Vector3::new(y, -x, z);
            super::squeeze([world(left), world(right)], axis)
        };
        assert_eq!(squeeze([-2.0, 0.0, 0.0], [3.0, 0.0, 0.0]), 2.0);
        assert_eq!(squeeze([-2.0, 1.0, 5.0], [1.5, -4.0, 0.0]), 1.5);
        assert_eq!(squeeze([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]), 0.0);
        assert_eq!(squeeze([0.3, 0.0, 1.0], [-0.3, 0.0, 1.0]), 0.0);
        assert_eq!(squeeze([2.0, 0.0, 0.0], [-2.0, 0.0, 0.0]), 0.0);
        assert_eq!(
            squeeze([-2.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
            0.0,
            "one jaw alone"
        );
    }
}
