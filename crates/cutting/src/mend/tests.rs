use super::*;
use crate::check;
use microsim_mesh::{Block, CellSplit};

type V3 = Vector3<f64>;

/// A block of 3 × 2 × 6 cells of size 1 around the origin.
fn block() -> TetMesh {
    let block = Block {
        center: [0.0; 3],
        size: [3.0, 2.0, 6.0],
        cells: [3, 2, 6],
        split: CellSplit::Kuhn,
    };
    block.mesh().unwrap()
}

fn height(mesh: &TetMesh, element: u32) -> f64 {
    mesh.corners(element as usize)
        .iter()
        .map(|p| p.z)
        .sum::<f64>()
        / 4.0
}

/// All faces in the plane z = 0 but one are torn, and the elements beside the plane remembered as swept or not.
fn joined_by_one_face(is_swept: bool) -> (TetMesh, Topology) {
    let mut mesh = block();
    let mut topology = Topology::new(&mesh);
    let mut faces = Vec::new();
    for element in 0..mesh.tets.len() as u32 {
        for (corner, other) in topology.closed(element) {
            if height(&mesh, element) < 0.0 && height(&mesh, other) > 0.0 {
                faces.push((element, corner as u8));
            }
        }
    }
    faces.remove(faces.len() / 2);
    let positions = mesh.positions.clone();
    let torn = topology.tear(
        &mesh,
        &faces,
        &BTreeMap::new(),
        &positions,
        &Settings::default(),
    );
    let torn = torn.unwrap().expect("faces come apart");
    assert_eq!(torn.pieces.len(), 0, "one face holds");
    mesh.apply(&torn.edit).unwrap();
    if is_swept {
        for element in 0..mesh.tets.len() as u32 {
            if height(&mesh, element).abs() < REACH * topology.mean_edge {
                let side = Vector3::z() * height(&mesh, element).signum();
                topology.swept.entry(element).or_default().pass(side);
            }
        }
    }
    (mesh, topology)
}

#[test]
fn a_bridge_of_one_face_is_opened_where_the_blade_has_passed() {
    let (mut mesh, mut topology) = joined_by_one_face(true);
    let mut stroke = Stroke::new();
    stroke.sheet = 1;
    let positions = mesh.positions.clone();
    let all = BTreeSet::new();
    let cut = topology.mend(&mesh, &mut stroke, &positions, &all, &Settings::default());
    let cut = cut.expect("a bridge");
    mesh.apply(&cut.edit).unwrap();
    // Half of a cell's square of 1.
    assert_eq!((cut.mended, cut.opened[0].area), (1, 0.5));
    // Above and below lie 3 × 2 × 3 cells of 6 elements.
    assert_eq!(cut.pieces.iter().map(Vec::len).collect::<Vec<_>>(), [108]);
    assert_eq!(check(&mesh, &topology).map(|m| m.parts), Ok(2));
}

#[test]
fn no_face_is_opened_where_no_blade_has_passed() {
    let (mesh, mut topology) = joined_by_one_face(false);
    let mut stroke = Stroke::new();
    stroke.sheet = 1;
    let positions = mesh.positions.clone();
    let all = BTreeSet::new();
    let cut = topology.mend(&mesh, &mut stroke, &positions, &all, &Settings::default());
    assert_eq!(cut, None);
    // Nor where it has not yet come beyond what is near to it.
    let (mesh, mut topology) = joined_by_one_face(true);
    let near = (0..mesh.positions.len() as u32).collect();
    let cut = topology.mend(&mesh, &mut stroke, &positions, &near, &Settings::default());
    assert_eq!(cut, None);
}

/// A blade as wide as the block goes in from above to `depth`, and out again, or on along the surface: the two sides hang together beyond its edge, whatever
/// it has swept.
#[test]
fn a_blade_that_ends_inside_opens_nothing_beyond() {
    for (depth, least) in [(2.2, 0.5), (4.3, 3.0), (-0.3, 0.0)] {
        let mut mesh = block();
        let mut topology = Topology::new(&mesh);
        let mut stroke = Stroke::new();
        let at = |x: f64, z: f64| [V3::new(x, -2.0, z), V3::new(x, 2.0, z)];
        let low: f64 = 3.0 - depth;
        let path = [
            (0.3, 9.0),
            (0.3, low),
            (0.32, low),
            (0.32, 9.0),
            (1.4, low.max(3.3)),
            (-1.4, low.max(3.3)),
            (0.0, 9.0),
        ];
        let mut area = 0.0;
        for pair in path.windows(2) {
            for step in 0..40 {
                let part = |k: usize| k as f64 / 40.0;
                let place = |k: usize| {
                    let lerp = |a: f64, b: f64| a + (b - a) * part(k);
                    at(lerp(pair[0].0, pair[1].0), lerp(pair[0].1, pair[1].1))
                };
                let positions = mesh.positions.clone();
                let blade = Blade::Sweep {
                    sweeps: &[Sweep {
                        before: place(step),
                        now: place(step + 1),
                    }],
                    before: &positions,
                    now: &positions,
                };
                let cut = topology.cut(&mesh, &mut stroke, &blade, &Settings::default());
                if let Some(cut) = cut.unwrap() {
                    mesh.apply(&cut.edit).unwrap();
                    assert_eq!(cut.mended, 0, "depth {depth}");
                    area += cut.opened[0].area;
                }
            }
        }
        // Of width 2, as deep as whole elements reach.
        assert!(
            (2.0 * least..=2.0 * depth.max(0.0)).contains(&area),
            "depth {depth}: {area}"
        );
        assert_eq!(
            check(&mesh, &topology).map(|m| m.parts),
            Ok(1),
            "depth {depth}"
        );
    }
}
