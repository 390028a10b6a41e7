//! Parts of tools that are exempt from contact, as what they cut lies around them.

use microsim_contact::{CapsuleMotion, Partner, Point};
use nalgebra::Vector3;

/// Cosine of the angle around the direction to the other blade within which a normal presses towards it: 60°, as an edge is sharp within. A judgement.
const BETWEEN: f64 = 0.5;

/// Part of a capsule that touches nothing, or nothing that it would press towards another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Exemption {
    /// The body, by its place in its group.
    pub body: u32,
    pub tool: u32,
    pub capsule: u32,
    /// Range along the axis, from 0 to 1; all of it if it goes beyond.
    pub range: [f64; 2],
    /// The capsule of the other blade, where only what is between both is exempt.
    pub towards: Option<u32>,
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
        let Some([a, b]) = self.axis(self.capsule, tools, fraction) else {
            return false;
        };
        let along = along(&point.place, &a, &b);
        if !(self.range[0] <= along && along <= self.range[1]) {
            return false;
        }
        let Some(other) = self.towards else {
            return true;
        };
        let Some([c, d]) = self.axis(other, tools, fraction) else {
            return false;
        };
        let place = |a: &Vector3<f64>, b: &Vector3<f64>| {
            let along = self::along(&point.place, a, b);
            a.lerp(b, along.clamp(0.0, 1.0))
        };
        let across = place(&c, &d) - place(&a, &b);
        point.normal.dot(&across) > BETWEEN * across.norm()
    }

    /// The ends of a capsule's axis \[m\].
    fn axis(
        &self,
        capsule: u32,
        tools: &[Option<Vec<CapsuleMotion>>],
        fraction: f64,
    ) -> Option<[Vector3<f64>; 2]> {
        let capsules = tools.get(self.tool as usize)?.as_ref()?;
        let motion = capsules.get(capsule as usize)?;
        Some([
            motion.start.a.lerp(&motion.end.a, fraction),
            motion.start.b.lerp(&motion.end.b, fraction),
        ])
    }
}

/// Where the point of a line through `a` (0) and `b` (1) is that is next to a place.
fn along(place: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    let axis = b - a;
    (place - a).dot(&axis) / axis.norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;
    use microsim_contact::Key;
    use microsim_geometry::Capsule;

    /// Two blades along x, one above the other, and points on the lower one with normals around its axis: what it would press up, towards the other within 60°, is exempt, where the blade is
    /// closed; without another one all is.
    #[test]
    fn what_is_between_closed_blades_is_exempt() {
        let blade = |z: f64| {
            let axis = [Vector3::new(0.0, 0.0, z), Vector3::new(10.0, 0.0, z)];
            let at = Capsule {
                a: axis[0],
                b: axis[1],
                radius: 1.0,
            };
            CapsuleMotion { start: at, end: at }
        };
        let tools = [Some(vec![blade(0.0), blade(2.0)])];
        let point = |x: f64, angle: f64, capsule: u32| {
            let normal = Vector3::new(0.0, angle.sin(), angle.cos());
            Point {
                key: Key {
                    body: 0,
                    partner: Partner::Tool { tool: 0, capsule },
                    first: [0, u32::MAX, u32::MAX],
                    second: [u32::MAX; 2],
                },
                nodes: [0; 4],
                weights: [1.0, 0.0, 0.0, 0.0],
                first: 1,
                normal,
                gap: 0.0,
                start_gap: 0.0,
                drift: Vector3::zeros(),
                place: Vector3::new(x, 0.0, 0.0) + normal,
            }
        };
        let exempt = |towards: Option<u32>, point: &Point| {
            let part = Exemption {
                body: 0,
                tool: 0,
                capsule: 0,
                range: [0.0, 0.5],
                towards,
            };
            part.covers(point, &tools, 1.0)
        };
        for degrees in (0..360).step_by(10).filter(|degrees| degrees % 60 != 0) {
            let angle = f64::from(degrees).to_radians();
            let up = angle.cos() > 0.5;
            assert_eq!(exempt(Some(1), &point(4.0, angle, 0)), up, "{degrees}");
            assert!(exempt(None, &point(4.0, angle, 0)));
            assert!(!exempt(Some(1), &point(6.0, angle, 0)), "not closed there");
            assert!(!exempt(Some(1), &point(4.0, angle, 1)), "the other blade");
        }
    }
}
