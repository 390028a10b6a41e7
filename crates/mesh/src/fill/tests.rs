use super::*;
use crate::{ElementQuality, defects};
use std::f64::consts::PI;

/// Random sides and crossings at every point and edge of a lattice, far wilder than any surface.
fn random_stuffing(seed: u64, spread: u64) -> (Vec<Vector3<f64>>, Vec<[u32; 4]>) {
    let mut state = seed;
    // A linear congruential generator (Knuth's MMIX constants), its upper bits.
    let mut random = move || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 33) as f64 / (1u64 << 31) as f64
    };
    let lattice = Lattice {
        origin: Vector3::zeros(),
        cell: 1.0,
        cells: [12; 3],
    };
    let threshold = spread as f64 / 8.0;
    let inside: Vec<bool> = (0..lattice.len()).map(|_| random() < threshold).collect();
    const EXTREMES: [f64; 10] = [
        0.0, 0.2499, 0.25, 0.4118, 0.4119, 0.5881, 0.5882, 0.75, 0.7501, 1.0,
    ];
    stuffing::stuff(&lattice, &inside, |_, _| match seed % 3 {
        0 => random(),
        _ => EXTREMES[(random() * 10.0) as usize],
    })
}

#[test]
fn explore() {
    let mut min = PI;
    let mut max = 0.0f64;
    for seed in 0..400 {
        let (positions, tets) = random_stuffing(seed * 977 + 5, 1 + seed % 7);
        for tet in tets {
            let corners = tet.map(|n| positions[n as usize]);
            let q = ElementQuality::of(&corners);
            assert!(q.radius_ratio > 0.0, "{q:?}");
            min = min.min(q.dihedral_min);
            max = max.max(q.dihedral_max);
        }
    }
    println!("{} {}", min * 180.0 / PI, max * 180.0 / PI);
}
