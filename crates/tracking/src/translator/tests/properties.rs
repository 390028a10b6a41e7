//! What holds for any mapping.

use proptest::prelude::*;
use std::f64::consts::PI;

use super::*;

fn any_point() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-1.0_f64..1.0)
}

/// Any orientation, by axis angles, so that it is a unit quaternion without a division.
fn any_orientation() -> impl Strategy<Value = [f64; 4]> {
    prop::array::uniform3(-PI..PI).prop_map(|[a, b, c]| {
        let half = |angle: f64| (libm::sin(angle / 2.0), libm::cos(angle / 2.0));
        let ((sa, ca), (sb, cb), (sc, cc)) = (half(a), half(b), half(c));
        [
            sa * cb * cc + ca * sb * sc,
            ca * sb * cc - sa * cb * sc,
            ca * cb * sc + sa * sb * cc,
            ca * cb * cc - sa * sb * sc,
        ]
    })
}

fn any_mapping() -> impl Strategy<Value = Mapping> {
    (
        any_point(),
        any_point(),
        any_orientation(),
        any_orientation(),
        0.01_f64..10.0,
    )
        .prop_map(
            |(device_origin, field_offset, field_from_device, body_from_tool, scale)| Mapping {
                device_origin,
                field_offset,
                field_from_device,
                body_from_tool,
                scale,
                ..Mapping::identity("stylus", "forceps")
            },
        )
}

/// All lengths of the properties are below 4 m in the device, so below 4·scale + 2 m in the field; each result passes
/// fewer than 32 roundings of values of that size.
fn rounding(mapping: &Mapping) -> f64 {
    32.0 * f64::EPSILON * (4.0 * mapping.scale + 2.0)
}

proptest! {
    #[test]
    fn distances_scale_and_angles_stay(
        mapping in any_mapping(),
        points in prop::array::uniform3(any_point()),
    ) {
        let field = points.map(|point| pose_of(&mapping, &sample(0.0, point, IDENTITY)).position);
        let [a, b, c] = points;
        let [fa, fb, fc] = field;
        let tolerance = rounding(&mapping);
        prop_assert!((length(minus(fb, fa)) - mapping.scale * length(minus(b, a))).abs() <= tolerance);
        // The inner product of two edges holds their angle; an error of each edge enters times the other's length.
        let found = dot(minus(fb, fa), minus(fc, fa));
        let expected = mapping.scale * mapping.scale * dot(minus(b, a), minus(c, a));
        prop_assert!((found - expected).abs() <= 2.0 * tolerance * (4.0 * mapping.scale + 2.0));
    }

    /// In the mirror M = diag(−1, 1, 1) the tip is M p, and a direction v of the tool points where M R M v does.
    #[test]
    fn a_mirrored_pose_is_the_mirror_image(mapping in any_mapping(), point in any_point(), turn in any_orientation(), v in any_point()) {
        let mirror = |[x, y, z]: [f64; 3]| [-x, y, z];
        let sample = sample(0.0, point, turn);
        let pose = pose_of(&mapping, &sample);
        let seen = pose_of(&Mapping { mirrored: true, ..mapping }, &sample);
        prop_assert_eq!(seen.position, mirror(pose.position));
        let expected = mirror(turned(pose.orientation, mirror(v)));
        prop_assert!(close(turned(seen.orientation, v), expected, 64.0 * f64::EPSILON * (1.0 + length(v))));
    }

    #[test]
    fn origin_goes_to_the_offset(mapping in any_mapping()) {
        let pose = pose_of(&mapping, &sample(0.0, mapping.device_origin, IDENTITY));
        prop_assert_eq!(pose.position, mapping.field_offset);
    }

    /// Translating twice is translating once by the composed mapping.
    #[test]
    fn mappings_compose(first in any_mapping(), second in any_mapping(), point in any_point(), turn in any_orientation()) {
        let middle = pose_of(&first, &sample(0.0, point, turn));
        let twice = pose_of(&second, &sample(0.0, middle.position, middle.orientation));
        let composed = Mapping {
            field_offset: pose_of(&second, &sample(0.0, first.field_offset, IDENTITY)).position,
            field_from_device: product(second.field_from_device, first.field_from_device),
            scale: second.scale * first.scale,
            body_from_tool: product(first.body_from_tool, second.body_from_tool),
            ..first.clone()
        };
        let once = pose_of(&composed, &sample(0.0, point, turn));
        let tolerance = second.scale * rounding(&first) + rounding(&second) + rounding(&composed);
        prop_assert!(close(once.position, twice.position, tolerance), "{once:?} {twice:?}");
        prop_assert!(close(once.orientation, twice.orientation, 32.0 * f64::EPSILON));
    }

    /// A registered frame is one mapping before another.
    #[test]
    fn a_registration_comes_before_the_mapping(mapping in any_mapping(), frame in any_mapping(), point in any_point(), turn in any_orientation()) {
        let first = Mapping { device_origin: [0.0; 3], body_from_tool: IDENTITY, ..frame };
        let middle = pose_of(&first, &sample(0.0, point, turn));
        let twice = pose_of(&mapping, &sample(0.0, middle.position, middle.orientation));
        let registered = mapping.clone().registered(first.field_from_device, first.field_offset, first.scale);
        let once = pose_of(&registered, &sample(0.0, point, turn));
        // The origin is divided by the scale of the registration, so its rounding is that of lengths of 4 m / scale.
        let tolerance = mapping.scale * rounding(&first) * (1.0 + 1.0 / first.scale) * (1.0 + first.scale) + rounding(&mapping);
        prop_assert!(close(once.position, twice.position, tolerance), "{once:?} {twice:?}");
        prop_assert!(close(once.orientation, twice.orientation, 64.0 * f64::EPSILON));
    }

    /// The orientation is the three rotations one after the other, by their matrices.
    #[test]
    fn orientation_is_the_product_of_its_parts(mapping in any_mapping(), turn in any_orientation(), vector in any_point()) {
        let pose = pose_of(&mapping, &sample(0.0, [0.0; 3], turn));
        let expected = turned(mapping.field_from_device, turned(turn, turned(mapping.body_from_tool, vector)));
        prop_assert!(close(turned(pose.orientation, vector), expected, 64.0 * f64::EPSILON));
    }

    /// Whatever a sample holds: no panic, and no pose but a finite one with a unit orientation.
    #[test]
    fn no_sample_makes_a_broken_pose(
        position in prop::array::uniform3(prop::num::f64::ANY),
        orientation in prop_oneof![prop::array::uniform4(prop::num::f64::ANY), any_orientation()],
        time_s in prop::num::f64::ANY,
        opening in prop::option::of(prop::num::f64::ANY),
    ) {
        let mut translator = translator(Mapping { scale: 2.0, ..Mapping::identity("stylus", "forceps") });
        let sample = InputSample { opening, ..sample(time_s, position, orientation) };
        if let Ok(Some(tool)) = translator.feed(&sample, 0.0) {
            prop_assert!(tool.pose.position.iter().all(|component| component.is_finite()));
            let norm = tool.pose.orientation.iter().map(|component| component * component).sum::<f64>();
            prop_assert!((norm - 1.0).abs() <= 32.0 * f64::EPSILON);
            prop_assert!((0.0..=1.0).contains(&tool.opening) && tool.time.is_finite());
        } else {
            prop_assert_eq!(translator.tools()[0].refused(), 1);
        }
    }
}
