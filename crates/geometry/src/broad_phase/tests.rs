use super::*;
use crate::all_pairs::AllPairs;
use crate::bvh::Bvh;
use crate::spatial_hash::SpatialHash;
use crate::testing::Points;
use microsim_random::SplitMix64;
use nalgebra::Vector3;

fn brute_force(queries: &[Aabb], boxes: &[Aabb]) -> Vec<[u32; 2]> {
    let mut pairs = Vec::new();
    for (i, query) in queries.iter().enumerate() {
        for (j, bounds) in boxes.iter().enumerate() {
            if query.overlaps(bounds) {
                pairs.push([i as u32, j as u32]);
            }
        }
    }
    pairs
}

/// A box of any kind that a scene may hold, in a scene of size 1 around `offset`.
fn random_box(random: &mut SplitMix64, offset: &Vector3<f64>, extent: f64) -> Aabb {
    let a = random.vector();
    let b = a + random.vector() * extent;
    let bounds = match random.below(12) {
        // A point; a box on the lattice, which touches cells and other boxes exactly; a box through the whole scene.
        0 => Aabb::of(&[a]),
        1 | 2 => Aabb::of(&[random.lattice(), random.lattice()]),
        3 => Aabb::of(&[a, -a]),
        4 => Aabb::empty(),
        5 => Aabb {
            min: Vector3::new(f64::NAN, 0.0, 0.0),
            max: b,
        },
        6 => Aabb {
            min: Vector3::repeat(f64::NEG_INFINITY),
            max: b,
        },
        _ => Aabb::of(&[a, b]),
    };
    Aabb {
        min: bounds.min + offset,
        max: bounds.max + offset,
    }
}

/// 10,000 random sets of boxes, from nothing to crowds, in cells from much too small to much too large, at the origin and far
/// from it: all broad phases, updated from set to set, find what the comparison of every box with every other finds.
#[test]
fn broad_phases_equal_brute_force() {
    let mut random = SplitMix64(1);
    let (mut hash, mut bvh, mut list) = (SpatialHash::new(), Bvh::new(), AllPairs::new());
    let (mut pairs, mut found) = (Vec::new(), Vec::new());
    let mut overlaps = 0;
    for _ in 0..10_000 {
        let offset = Vector3::repeat([0.0, 1.0, -1e6, 1e12][random.below(4) as usize]);
        let extent = [0.05, 0.5][random.below(2) as usize];
        let mut boxes = |count| -> Vec<Aabb> {
            (0..random.below(count))
                .map(|_| random_box(&mut random, &offset, extent))
                .collect()
        };
        let (queries, boxes) = (boxes(20), boxes(30));
        let cell = [1e-3, 0.05, 0.2, 0.5, 3.0, 0.0, f64::NAN][random.below(7) as usize];
        let expected = brute_force(&queries, &boxes);
        overlaps += expected.len();

        hash.rebuild(cell, &boxes);
        hash.pairs(&queries, &mut pairs);
        assert_eq!(pairs, expected, "hash, cell {cell}, offset {offset}");
        // Refitted from the set before, as often as built.
        bvh.refit(&boxes);
        bvh.pairs(&queries, &mut pairs);
        assert_eq!(pairs, expected, "bvh");

        list.rebuild(&boxes);
        list.pairs(&queries, &mut pairs);
        assert_eq!(pairs, expected, "all pairs");

        let own: Vec<[u32; 2]> = brute_force(&boxes, &boxes)
            .into_iter()
            .filter(|[i, j]| i < j)
            .collect();
        hash.self_pairs(&mut pairs);
        assert_eq!(pairs, own);
        bvh.self_pairs(&mut pairs);
        assert_eq!(pairs, own);
        if let Some(query) = queries.first() {
            let first: Vec<u32> = expected
                .iter()
                .filter(|pair| pair[0] == 0)
                .map(|pair| pair[1])
                .collect();
            hash.query(query, &mut found);
            assert_eq!(found, first);
        }
    }
    // Enough was there to be found: 100 comparisons per set, one in ten of which overlaps at least.
    assert!(overlaps > 100_000, "{overlaps}");
}

#[test]
fn an_empty_set_answers_nothing() {
    let all = Aabb {
        min: Vector3::repeat(f64::NEG_INFINITY),
        max: Vector3::repeat(f64::INFINITY),
    };
    let mut found = vec![1];
    let mut hash = SpatialHash::new();
    hash.query(&all, &mut found);
    assert!(found.is_empty() && hash.is_empty());
    hash.rebuild(1.0, &[]);
    hash.query(&Aabb::of(&[Vector3::zeros()]), &mut found);
    assert!(found.is_empty());
    let mut bvh = Bvh::new();
    bvh.rebuild(&[]);
    bvh.query(&all, &mut found);
    assert!(found.is_empty() && bvh.is_empty());
}
