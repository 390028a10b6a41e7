use super::*;
use crate::ElementQuality;

/// Smallest and largest dihedral angle [rad] over all pieces that one tetrahedron of the lattice can be cut into, with
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

#[test]
fn explore_limits() {
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
    println!("{} tets", tets.len());
    let d = 180.0 / std::f64::consts::PI;
    for k in 0..4 {
        let (min, max) = extreme_angles(tets[k * 7], 0.24999, 0.41189);
        println!("{:?} {} {}", tets[k * 7], min * d, max * d);
    }
    for long in [0.22, 0.24, 0.25, 0.26] {
        for short in [0.41189, 0.42, 0.43, 0.44, 0.46, 0.49] {
            let (min, max) = extreme_angles(tets[0], long, short);
            println!("{long} {short}: {:.4} {:.4}", min * d, max * d);
        }
    }
}
