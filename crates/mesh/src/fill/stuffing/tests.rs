use super::*;
use crate::quality::ElementQuality;
use crate::{MAX_DIHEDRAL, MIN_DIHEDRAL, TetMesh};
use microsim_random::Congruential;

/// Smallest and largest dihedral angle \[rad\] over all pieces that one tetrahedron of the lattice can be cut into, with
/// these limits of warping: each of its points inside, outside or moved along any of its edges by 0, half or all of the
/// limit, and each crossing as near to either end as the limits leave it, or in the middle.
fn extreme_angles(tet: [u32; 4], long: f64, short: f64) -> (f64, f64) {
    let lattice = Lattice {
        origin: Vector3::zeros(),
        cell: 1.0,
        cells: [4; 3],
    };
    let limit = |i: u32, j: u32| if lattice.is_long(i, j) { long } else { short };
    let (mut min, mut max) = (f64::INFINITY, 0.0f64);
    for code in 0..81usize {
        let sides = [1, 3, 9, 27].map(|place| match code / place % 3 {
            0 => Side::Inside,
            1 => Side::Surface,
            _ => Side::Outside,
        });
        let mut inside = vec![false; lattice.len()];
        // What can be chosen, each with its places: a moved point's, or the shares of an edge.
        let mut moves: Vec<(u32, Vec<Vector3<f64>>)> = Vec::new();
        let mut cuts: Vec<((u32, u32), [f64; 3])> = Vec::new();
        for (k, side) in sides.into_iter().enumerate() {
            let at = lattice.position(tet[k]);
            match side {
                Side::Inside => inside[tet[k] as usize] = true,
                Side::Outside => {}
                Side::Surface => {
                    let ends = lattice.neighbours(tet[k]).flat_map(|n| {
                        let whole = (lattice.position(n) - at) * limit(tet[k], n);
                        [at + whole * 0.5, at + whole]
                    });
                    moves.push((tet[k], std::iter::once(at).chain(ends).collect()));
                }
            }
            for l in 0..k {
                if side.min(sides[l]) == Side::Inside && side.max(sides[l]) == Side::Outside {
                    let key = (tet[k].min(tet[l]), tet[k].max(tet[l]));
                    let limit = limit(tet[k], tet[l]);
                    cuts.push((key, [limit, 0.5, 1.0 - limit]));
                }
            }
        }
        let mut choice = vec![0usize; moves.len() + cuts.len()];
        loop {
            let mut pieces = Pieces {
                lattice: &lattice,
                inside: &inside,
                warped: moves
                    .iter()
                    .zip(&choice)
                    .map(|((point, places), &c)| (*point, places[c]))
                    .collect(),
                crossings: cuts
                    .iter()
                    .zip(&choice[moves.len()..])
                    .map(|((key, shares), &c)| (*key, shares[c]))
                    .collect(),
                nodes: BTreeMap::new(),
                positions: Vec::new(),
                tets: Vec::new(),
            };
            pieces.cut(tet);
            for piece in &pieces.tets {
                let quality = ElementQuality::of(&piece.map(|n| pieces.positions[n as usize]));
                assert!(
                    quality.radius_ratio > 0.0,
                    "{sides:?} {choice:?} {quality:?}"
                );
                min = min.min(quality.dihedral_min);
                max = max.max(quality.dihedral_max);
            }
            // The next choice, as a number with digits of different bases.
            let bases = moves
                .iter()
                .map(|m| m.1.len())
                .chain(cuts.iter().map(|_| 3));
            let advanced = choice.iter_mut().zip(bases).any(|(digit, base)| {
                *digit = (*digit + 1) % base;
                *digit != 0
            });
            if !advanced {
                break;
            }
        }
    }
    (min, max)
}

/// The bounds of the angles, for every kind of position of a tetrahedron in the lattice: of either parity.
#[test]
fn no_piece_is_worse_than_the_stated_bounds() {
    let lattice = Lattice {
        origin: Vector3::zeros(),
        cell: 1.0,
        cells: [4; 3],
    };
    let mut tets = Vec::new();
    lattice.visit_tets(|tet| {
        if tet.iter().all(|&p| lattice.neighbours(p).count() == 14) {
            tets.push(tet);
        }
    });
    for tet in [tets[0], tets[21]] {
        let (min, max) = extreme_angles(tet, WARP_LONG, WARP_SHORT);
        assert!((MIN_DIHEDRAL..MIN_DIHEDRAL + 0.001).contains(&min), "{min}");
        assert!(max <= MAX_DIHEDRAL && max > MAX_DIHEDRAL - 0.001, "{max}");
    }
}

/// Random sides and crossings at every point and edge, far wilder than any surface: the pieces fit together (each face
/// has one or two owners, the boundary is closed), and sum to what the boundary encloses.
#[test]
fn pieces_of_any_sides_and_crossings_fit_together() {
    let mut total = 0;
    for seed in 4..10u64 {
        let mut numbers = Congruential(seed);
        // Uniform in 0..1.
        let mut random = move || 0.5 * (numbers.number() + 1.0);
        let lattice = Lattice {
            origin: Vector3::zeros(),
            cell: 1.0,
            cells: [10; 3],
        };
        let inside: Vec<bool> = (0..lattice.len() as u32)
            .map(|point| lattice.neighbours(point).count() == 14 && random() * 10.0 < seed as f64)
            .collect();
        let (positions, tets) = stuff(&lattice, &inside, |_, _| random());
        let mesh = TetMesh::new(positions, tets, Vec::new());
        total += mesh.tets.len();
        let [ratio, min, max] = crate::quality::extremes(&mesh);
        assert!(ratio > 0.0 && min >= MIN_DIHEDRAL && max <= MAX_DIHEDRAL);
        // Pieces may touch in edges and nodes here; anything else is wrong.
        for defect in crate::defects(&mesh) {
            assert!(defect.severity() == crate::Severity::Warning, "{defect}");
        }
        let boundary = mesh.surface();
        for shared in crate::topology::edge_uses(&boundary.triangles) {
            let forward = shared.triangles.iter().filter(|(_, f)| *f).count();
            assert_eq!(2 * forward, shared.triangles.len());
        }
        let enclosed: f64 = boundary
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|n| mesh.positions[n as usize]);
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum();
        let volume: f64 = mesh.volumes().iter().sum();
        assert!((enclosed / volume - 1.0).abs() < 1e-12);
    }
    assert!(total > 1000, "{total}");
}
