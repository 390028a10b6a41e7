//! Parts of tools that are exempt from contact, as what they cut lies around them.

use microsim_contact::{CapsuleMotion, Partner, Point};

/// Part of a capsule that touches nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Exemption {
    /// The body, by its place in its group.
    pub body: u32,
    pub tool: u32,
    pub capsule: u32,
    /// Range along the axis, from 0 to 1; all of it if it goes beyond.
    pub range: [f64; 2],
}

impl Exemption {
    /// Whether a point of contact at the step fraction `fraction` of the tools' motion is of this part.
    pub fn covers(
        &self,
        point: &Point,
        tools: &[Option<Vec<CapsuleMotion>>],
        fraction: f64,
    ) -> bool {
        let partner = Partner::Tool {
            tool: self.tool,
            capsule: self.capsule,
        };
        if point.key.body != self.body || point.key.partner != partner {
            return false;
        }
        let capsules = tools.get(self.tool as usize).and_then(Option::as_ref);
        let Some(motion) = capsules.and_then(|all| all.get(self.capsule as usize)) else {
            return false;
        };
        let [a, b] = [
            motion.start.a.lerp(&motion.end.a, fraction),
            motion.start.b.lerp(&motion.end.b, fraction),
        ];
        let along = (point.place - a).dot(&(b - a)) / (b - a).norm_squared();
        self.range[0] <= along && along <= self.range[1]
    }
}
