//! Lumens of tubes whose areas are known: at rest, drawn in, closed, opened by a cut.

use super::*;
use microsim_mesh::{Arc, CellSplit, Layer, Tube, TubeSide};

const RADIUS: f64 = 1e-3;
const LENGTH: f64 = 10e-3;
const AROUND: usize = 24;
const ALONG: usize = 10;

/// A vessel along y around the origin, and its lumen.
fn vessel() -> (TetMesh, Lumen) {
    let tube = Tube {
        center: [0.0; 3],
        axis: [0.0, 1.0, 0.0],
        inner_radius: RADIUS,
        layers: vec![Layer {
            thickness: 0.1e-3,
            cells: 1,
            region: 0,
        }],
        length: LENGTH,
        around: AROUND,
        along: ALONG,
        arc: Arc::Full,
        split: CellSplit::Kuhn,
    };
    let mesh = tube.mesh().unwrap();
    let spec = LumenSpec {
        triangles: tube.side(&mesh, TubeSide::Inner).triangles,
        axis: tube.axis,
        sections: ALONG as u32,
    };
    let lumen = Lumen::new(&spec, &mesh).unwrap();
    (mesh, lumen)
}

fn pressures(lumen: &Lumen, y: f64, positions: &[Vector3<f64>]) -> Vec<f64> {
    let mut sections = Vec::new();
    let point = Vector3::new(0.0, y, 0.0);
    lumen.pressures(&point, 1.0, positions, &mut sections);
    sections.iter().map(|section| section.pressure).collect()
}

/// The area of a regular polygon of n corners on a circle is n r²/2 sin(2π/n); turned and bent as a whole, it stays.
#[test]
fn areas_are_those_of_the_polygon() {
    let (mesh, lumen) = vessel();
    let n = AROUND as f64;
    let polygon = 0.5 * n * RADIUS * RADIUS * libm::sin(2.0 * PI / n);
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    let turned: Vec<Vector3<f64>> = mesh.positions.iter().map(|p| turn * p).collect();
    for positions in [&mesh.positions, &turned] {
        let mut sections = Vec::new();
        lumen.measure(positions, &mut sections);
        for section in &sections {
            assert!((section.area / polygon - 1.0).abs() < 1e-12, "{section:?}");
            let length = LENGTH / ALONG as f64;
            assert!((section.length / length - 1.0).abs() < 1e-12);
        }
    }
}

/// On the axis the two open ends of a tube take away 1 − cos of what half a cone sees, (1 − d/√(d² + R²))/2 of all directions
/// each, at the distances d: beyond the mouth more than half.
#[test]
fn a_lumen_holds_what_its_wall_surrounds() {
    let (mesh, lumen) = vessel();
    let holds = |x: f64, y: f64| lumen.holds(&Vector3::new(x, y, 0.0), &mesh.positions);
    let end = 0.5 * LENGTH;
    for (x, y, expected) in [
        (0.0, 0.0, true),
        (0.9 * RADIUS, 0.0, true),
        (0.0, end - 0.1 * RADIUS, true),
        (0.0, end + 0.1 * RADIUS, false),
        (0.0, -end - 0.1 * RADIUS, false),
        (1.2 * RADIUS, 0.0, false),
    ] {
        assert_eq!(holds(x, y), expected, "{x} {y}");
    }
}

/// Hagen and Poiseuille in a tube of one area: the pressure falls evenly to both open ends. From the middle of section 2 there are 2.5
/// sections to one end, 7.5 to the other.
#[test]
fn pressure_falls_evenly_to_open_ends() {
    let (mesh, lumen) = vessel();
    let middle = -0.5 * LENGTH + 2.5e-3;
    let found = pressures(&lumen, middle, &mesh.positions);
    for (k, found) in found.iter().enumerate() {
        let expected = match k {
            0..=2 => (k as f64 + 0.5) / 2.5,
            _ => (9.5 - k as f64) / 7.5,
        };
        assert!((found - expected).abs() < 1e-12, "{k}: {found} {expected}");
    }
}

/// A section pressed together has a million times the resistance: before it the whole pressure, behind it none. With half the radius a section has a
/// quarter of the area and 16 times the resistance: over one the pressure falls 16 times as far as over one that is wide.
#[test]
fn a_closed_section_bears_the_whole_pressure() {
    let (mesh, lumen) = vessel();
    let middle = -0.5 * LENGTH + 2.5e-3;
    // Section 7 is flat, from 2 to 3 mm.
    let squeezed: Vec<Vector3<f64>> = mesh
        .positions
        .iter()
        .map(|p| match (1.9e-3..3.1e-3).contains(&p.y) {
            true => Vector3::new(p.x, p.y, p.z * 1e-9),
            false => *p,
        })
        .collect();
    let found = pressures(&lumen, middle, &squeezed);
    for (k, found) in found.iter().enumerate().skip(2) {
        match k {
            2..=6 => assert!(*found > 0.999, "{k}: {found}"),
            7 => assert!((found - 0.5).abs() < 1e-3, "{found}"),
            _ => assert!(*found < 1e-3, "{k}: {found}"),
        }
    }
    // The left end is as before.
    assert!((found[0] - 0.2).abs() < 1e-12);
    let narrow: Vec<Vector3<f64>> = mesh
        .positions
        .iter()
        .map(|p| match p.y > 0.9e-3 {
            true => Vector3::new(0.5 * p.x, p.y, 0.5 * p.z),
            false => *p,
        })
        .collect();
    let found = pressures(&lumen, middle, &narrow);
    let drops = [found[2] - found[3], found[7] - found[8]];
    assert!((drops[1] / drops[0] - 16.0).abs() < 1e-9, "{drops:?}");
}

/// Where the wall is open the fluid leaves: from the middle of section 2 the pressure falls evenly to the beginning of the first open section,
/// however far apart what is behind it has drawn back, and behind it there is none.
#[test]
fn pressure_falls_evenly_to_where_a_cut_has_opened_the_wall() {
    let (mesh, mut lumen) = vessel();
    let source = -0.5 * LENGTH + 2.5e-3;
    let wall: Vec<[u32; 3]> = lumen.triangles().iter().map(|of| of.nodes).collect();
    let drawn_back: Vec<Vector3<f64>> = mesh
        .positions
        .iter()
        .map(|p| match p.y > 0.5e-3 {
            true => p + Vector3::y() * 4e-3,
            false => *p,
        })
        .collect();
    // The ring between sections 5 and 6, and the wall of section 6 as a whole, from 1 to 2 mm.
    let ring: Vec<u32> = (0..mesh.positions.len() as u32)
        .filter(|&node| (mesh.positions[node as usize].y - 1e-3).abs() < 1e-6)
        .collect();
    let middle = |of: &[u32; 3]| of.map(|n| mesh.positions[n as usize].y).iter().sum::<f64>() / 3.0;
    let mut left = wall.clone();
    left.retain(|of| !(1e-3..2e-3).contains(&middle(of)));
    for (wall, opened, first) in [(&wall, &ring[..], 5), (&left, &[][..], 6)] {
        lumen.update(&mesh, wall, opened);
        let positions = match first {
            5 => [&mesh.positions, &drawn_back],
            _ => [&mesh.positions, &mesh.positions],
        };
        for positions in positions {
            let found = pressures(&lumen, source, positions);
            for (k, found) in found.iter().enumerate() {
                let expected = match k {
                    0..=2 => (k as f64 + 0.5) / 2.5,
                    _ => ((f64::from(first) - k as f64 - 0.5) / (f64::from(first) - 2.5)).max(0.0),
                };
                assert!(
                    (found - expected).abs() < 1e-12,
                    "{first} {k}: {found} {expected}"
                );
            }
        }
    }
    // From behind the cut, where the world's origin is as near as can be to a section without a wall.
    lumen.update(&mesh, &left, &[]);
    let found = pressures(&lumen, 2.5e-3, &mesh.positions);
    assert!(
        found[..7].iter().all(|p| *p == 0.0) && found[7] > 0.8,
        "{found:?}"
    );
}
