//! The shape of a tool of the level as it is held: what of it lies where, for modules without tissue.

use crate::fault::Fault;
use microsim_geometry::{self as geometry, SegmentPoint};
use microsim_message::Pose;
use microsim_settings::{Jaw, ModuleConfig, Tool};
use nalgebra::Vector3;

/// The shape of a tool of a level.
#[derive(Clone, Debug)]
pub struct ToolShape {
    model: Tool,
    mouth: [usize; 2],
}

/// What lies between the jaws: the tips of the left and of the right one, each from its free end towards the hinge \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mouth {
    /// The left tip.
    pub left: geometry::Capsule,
    /// The right tip.
    pub right: geometry::Capsule,
}

/// Where something passes between jaws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// Its place on the segment that passes: 0 at the first end, 1 at the second.
    pub t: f64,
    /// Distance from the middle between the jaws there \[m\].
    pub off_centre: f64,
    /// Free width between the jaws there, from surface to surface \[m\].
    pub gap: f64,
    /// Angle between the segment and the normal of the surface between the jaws, from 0 to π/2 \[rad\].
    pub angle: f64,
}

impl ToolShape {
    /// Of the tool in a slot of the level; its jaws are the parts of each side that lie nearest to the tip. A fault where the level has no
    /// such slot, or the model no jaws.
    pub fn with_jaws(config: &ModuleConfig, slot: &str) -> Result<Self, Fault> {
        let found = config.tools.iter().find(|tool| tool.name == slot);
        let model = found.and_then(|tool| config.models.get(&tool.model));
        let model = model.ok_or_else(|| Fault::new(format!("no tool \"{slot}\" with a shape")))?;
        let tip = |jaw: Jaw| {
            let parts = model.capsule.iter().enumerate();
            let of_jaw = parts.filter(|(_, part)| part.jaw == jaw);
            let height = |part: &microsim_settings::ToolCapsule| part.a[2].min(part.b[2]);
            let nearest = of_jaw.min_by(|(_, p), (_, q)| height(p).total_cmp(&height(q)));
            nearest.map(|(index, _)| index)
        };
        let (Some(left), Some(right)) = (tip(Jaw::Left), tip(Jaw::Right)) else {
            return Err(Fault::new(format!("tool \"{slot}\" needs two jaws")));
        };
        Ok(Self {
            model: model.clone(),
            mouth: [left, right],
        })
    }

    /// Its parts that can touch, in the field, at an opening from 0, closed, to 1.
    pub fn parts(&self, pose: Pose, opening: f64) -> impl Iterator<Item = geometry::Capsule> {
        let pose = geometry::Pose::from_arrays(pose.position, pose.orientation);
        let parts = self.model.capsules_at(opening).zip(&self.model.capsule);
        parts
            .filter(|(_, part)| part.touches)
            .map(move |(capsule, _)| capsule.posed(&pose))
    }

    /// What lies between its jaws, in the field.
    pub fn mouth(&self, pose: Pose, opening: f64) -> Mouth {
        let pose = geometry::Pose::from_arrays(pose.position, pose.orientation);
        let [left, right] = self.mouth.map(|index| {
            let part = &self.model.capsule[index];
            let joint = part.joint(self.model.hinge, self.model.opening_angle);
            let mut tip = joint.capsule_at(&part.closed(), opening);
            if part.b[2] < part.a[2] {
                std::mem::swap(&mut tip.a, &mut tip.b);
            }
            tip.posed(&pose)
        });
        Mouth { left, right }
    }
}

impl Mouth {
    /// Where the segment from `a` to `b` \[m\] goes through the surface between the tips of the jaws; `None` where it does not.
    pub fn passage(&self, a: &Vector3<f64>, b: &Vector3<f64>) -> Option<Passage> {
        let Self { left, right } = self;
        let halves = [[left.a, left.b, right.b], [left.a, right.b, right.a]];
        let (half, crossing) = halves
            .iter()
            .find_map(|half| Some((half, geometry::edge_through_triangle(a, b, half)?)))?;
        let SegmentPoint { point: place, t } = crossing.points.on_segment;
        let [l, r] = [left, right].map(|jaw| jaw.axis_point(&place).point);
        let across = r - l;
        let width = across.norm();
        let along = if width > 0.0 {
            (place - 0.5 * (l + r)).dot(&across) / width
        } else {
            0.0
        };
        // What goes through a surface has a length, and the surface an area.
        let normal = (half[1] - half[0]).cross(&(half[2] - half[0]));
        let along_normal = normal.dot(&(b - a)).abs();
        Some(Passage {
            t,
            angle: libm::atan2(normal.cross(&(b - a)).norm(), along_normal),
            off_centre: along.abs(),
            gap: (width - left.radius - right.radius).max(0.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn forceps() -> ToolShape {
        let text = include_str!("../../../config/tools/forceps.toml");
        let model = microsim_settings::read_tool(text, "forceps.toml")
            .expect("the shipped tool")
            .settings;
        ToolShape {
            model,
            mouth: [0, 2],
        }
    }

    /// The hinge lies 18 mm above the tip and each jaw opens by 6°: the axis of a tip, 0.125 mm beside the middle and 0.125 mm above the
    /// tip, is then 0.125 cos 6° + 17.875 sin 6° mm beside it.
    #[test]
    fn what_passes_in_the_middle_of_open_jaws_has_the_gap_of_the_hinge() {
        let mouth = forceps().mouth(Pose::default(), 1.0);
        let beside =
            0.125e-3 * libm::cos(6_f64.to_radians()) + 17.875e-3 * libm::sin(6_f64.to_radians());
        assert!((mouth.left.a.x - beside).abs() < 1e-15, "{mouth:?}");
        let [z, y] = [mouth.left.a.z, 1e-3];
        let at = |x: f64| mouth.passage(&Vector3::new(x, -y, z), &Vector3::new(x, 3.0 * y, z));
        let middle = at(0.0).expect("between the jaws");
        // Open jaws lean inwards by 6° less what they taper, atan(0.125/4.875): seen from the middle the nearest points lie a little higher.
        let lean = 6_f64.to_radians() - libm::atan(0.125 / 4.875);
        let width = 2.0 * beside * libm::cos(lean) * libm::cos(lean);
        assert!((middle.gap - (width - 0.25e-3)).abs() < 1e-15, "{middle:?}");
        assert!(
            (middle.t - 0.25).abs() < 1e-12 && middle.off_centre < 1e-15,
            "{middle:?}"
        );
        assert_eq!(at(1.01 * beside), None, "outside of the jaws");
        let off = at(0.3e-3).expect("between the jaws");
        assert!((off.off_centre - 0.3e-3).abs() < 0.01e-3, "{off:?}");
    }

    #[test]
    fn only_jaws_have_a_mouth_and_handles_do_not_touch() {
        let shape = forceps();
        assert_eq!(shape.parts(Pose::default(), 0.5).count(), 5);
        let closed = shape.mouth(Pose::default(), 0.0);
        let passage = closed.passage(
            &Vector3::new(0.0, -1e-3, 1e-3),
            &Vector3::new(0.0, 1e-3, 1e-3),
        );
        // Closed tips lie on each other but for their taper of 0.125 mm in 5 mm: 1 mm up, 2 · 0.125 · (1 − 0.125)/4.875 mm are free.
        let free = 0.25e-3 * 0.875 / 4.875;
        assert!(
            (passage.expect("between").gap - free).abs() < 1e-6,
            "{passage:?}"
        );
    }
}
