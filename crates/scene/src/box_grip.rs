//! Gripping by the box between the jaws' lines of no return (dissertation 4.4.2), beside Coulomb's friction.
//!
//! While both jaws touch a body, its nodes in the box between their lines are brought along with the jaws by forces, as in the dissertation relative to
//! the motion of the instrument; contact may still move them out of the jaws. Nothing is stored: a node moves by what the box moves, from where it is.
//!
//! Limitations: the force has no bound, so nothing slips that is held, however hard it is pulled; it is in no report, as it is none of contact. Nodes alone
//! are held: elements larger than the box slip through it.

use crate::spec::{CapsuleSpec, Jaw};
use microsim_contact::{CapsuleMotion, Partner, Sides};
use microsim_geometry::Capsule;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// Lines of both jaws, one beside the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Couple {
    /// Capsules of the left and of the right one.
    capsules: [u32; 2],
    /// How far each line lies from its axis towards the other jaw \[m\].
    inward: [f64; 2],
}

/// The couples of a tool's lines, from the tips to the hinge.
pub(crate) fn couples(capsules: &[CapsuleSpec]) -> Vec<Couple> {
    let of = |jaw: Jaw| -> Vec<(u32, f64)> {
        let lines = (0..).zip(capsules);
        let lines = lines.filter(|(_, part)| part.lonor && part.jaw == Some(jaw));
        // The left jaw lies at +x.
        let sign = if jaw == Jaw::Left { -1.0 } else { 1.0 };
        let inward = |part: &CapsuleSpec| sign * part.lonor_offset.map_or(0.0, |offset| offset[0]);
        lines.map(|(index, part)| (index, inward(part))).collect()
    };
    let both = of(Jaw::Left).into_iter().zip(of(Jaw::Right));
    both.map(|(left, right)| Couple {
        capsules: [left.0, right.0],
        inward: [left.1, right.1],
    })
    .collect()
}

/// A box that holds nodes of a body.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BoxGrip {
    /// The body, by its place in its group.
    pub body: u32,
    pub tool: u32,
    pub couples: Vec<Couple>,
}

impl BoxGrip {
    /// Whether both jaws touch the body, whose nodes are `nodes`: by what the last step found within reach of them. By forces alone a grip would let go whenever a jaw
    /// bounces for a step.
    fn is_closed(&self, sides: &Sides, nodes: &Range<usize>) -> bool {
        [0, 1].into_iter().all(|jaw| {
            sides.entries().iter().any(|(partner, node, _)| {
                let Partner::Tool { tool, capsule } = *partner else {
                    return false;
                };
                let of_jaw = |couple: &Couple| couple.capsules[jaw] == capsule;
                tool == self.tool
                    && nodes.contains(&(*node as usize))
                    && self.couples.iter().any(of_jaw)
            })
        })
    }

    /// Adds the nodes that are held in a step, and where they are brought by its end \[m\]: of the body's nodes, which begin with `first`, at `positions`.
    pub fn add(
        &self,
        sides: &Sides,
        motion: &[CapsuleMotion],
        first: usize,
        positions: &[Vector3<f64>],
        carried: &mut Vec<(u32, Vector3<f64>)>,
    ) {
        if !self.is_closed(sides, &(first..first + positions.len())) {
            return;
        }
        let boxes = self.couples.iter().filter_map(|couple| {
            let [left, right] = couple.capsules.map(|capsule| &motion[capsule as usize]);
            let start = Frame::between([&left.start, &right.start])?;
            let end = Frame::between([&left.end, &right.end])?;
            let half = start.half_size(couple, [&left.start, &right.start]);
            Some((start, end, half))
        });
        let boxes: Vec<_> = boxes.collect();
        for (node, place) in positions.iter().enumerate() {
            let held = boxes.iter().find_map(|(start, end, half)| {
                let within = start.axes.tr_mul(&(place - start.origin));
                let is_in = (0..3).all(|k| within[k].abs() <= half[k]);
                is_in.then(|| end.origin + end.axes * within)
            });
            carried.extend(held.map(|target| ((first + node) as u32, target)));
        }
    }
}

/// An end of a line, and how far the line lies towards the other jaw \[m\].
type End = (Vector3<f64>, f64);

/// A frame between two lines: x from the right to the left one, z along both, from `a` to `b`.
#[derive(Clone, Copy, Debug)]
struct Frame {
    origin: Vector3<f64>,
    axes: Matrix3<f64>,
}

impl Frame {
    /// `None` where the lines lie in one another.
    fn between([left, right]: [&Capsule; 2]) -> Option<Self> {
        let middle = |of: &Capsule| (of.a + of.b) * 0.5;
        let z = ((left.b - left.a) + (right.b - right.a)).try_normalize(0.0)?;
        let across = middle(left) - middle(right);
        let x = (across - z * across.dot(&z)).try_normalize(0.0)?;
        Some(Self {
            origin: (middle(left) + middle(right)) * 0.5,
            axes: Matrix3::from_columns(&[x, z.cross(&x), z]),
        })
    }

    /// Half of the sides of the box between the lines: as wide as they are apart where that is most, as thick as the capsules, as long as the lines \[m\].
    fn half_size(&self, couple: &Couple, [left, right]: [&Capsule; 2]) -> Vector3<f64> {
        let ends = [
            (left.a, couple.inward[0]),
            (left.b, couple.inward[0]),
            (right.a, couple.inward[1]),
            (right.b, couple.inward[1]),
        ];
        let within = ends.map(|(end, inward)| (self.axes.tr_mul(&(end - self.origin)), inward));
        let most = |of: &dyn Fn(&End) -> f64| within.iter().map(of).fold(0.0, f64::max);
        Vector3::new(
            most(&|(end, inward)| end.x.abs() - inward),
            left.radius.max(right.radius),
            most(&|(end, _)| end.z.abs()),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn capsule(x: f64, shift: f64) -> Capsule {
        Capsule {
            a: Vector3::new(x + shift, 0.0, 0.0),
            b: Vector3::new(x + shift, 0.0, 4.0),
            radius: 0.5,
        }
    }

    /// A node of the body within reach of each of these.
    fn touched(capsules: &[u32]) -> Sides {
        let entry = |capsule: &u32| {
            let partner = Partner::Tool {
                tool: 0,
                capsule: *capsule,
            };
            (partner, 11, Vector3::x())
        };
        Sides::from_entries(capsules.iter().map(entry).collect())
    }

    /// Lines at x = ±1 that move by 0.25: what lies between them and within their thickness moves along, and only while both touch.
    #[test]
    fn nodes_in_the_box_move_with_it_while_both_jaws_touch() {
        let spec = |x: f64, jaw| CapsuleSpec {
            lonor: true,
            jaw: Some(jaw),
            ..CapsuleSpec::new([x, 0.0, 0.0], [x, 0.0, 4.0], 0.5)
        };
        let grip = |offset: Option<[f64; 3]>| BoxGrip {
            body: 0,
            tool: 0,
            couples: couples(&[
                CapsuleSpec {
                    lonor_offset: offset,
                    ..spec(1.0, Jaw::Left)
                },
                spec(-1.0, Jaw::Right),
            ]),
        };
        let motion = [1.0, -1.0].map(|x| CapsuleMotion {
            start: capsule(x, 0.0),
            end: capsule(x, 0.25),
        });
        let places = [
            Vector3::new(0.5, 0.25, 1.0),
            Vector3::new(0.0, 0.75, 1.0),
            Vector3::new(1.25, 0.0, 1.0),
            Vector3::new(0.0, 0.0, 4.5),
        ];
        let held = |grip: &BoxGrip, capsules: &[u32]| {
            let mut carried = Vec::new();
            grip.add(&touched(capsules), &motion, 10, &places, &mut carried);
            carried
        };
        let expected = [(10, Vector3::new(0.75, 0.25, 1.0))];
        assert_eq!(held(&grip(None), &[0, 1]), expected);
        assert!(
            held(&grip(None), &[0]).is_empty(),
            "one jaw alone holds nothing"
        );
        // With a line 0.25 outside of its axis the box reaches to x = 1.25.
        let wide = grip(Some([0.25, 0.0, 0.0]));
        assert_eq!(held(&wide, &[0, 1]).len(), 2);
    }
}
