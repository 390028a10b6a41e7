//! A set of which a few boxes change keeps its tree, and finds what is there.

use super::*;
use microsim_random::SplitMix64;
use nalgebra::Vector3;

/// Places in a box of side 2, and sizes so that each box meets a few others of some hundred.
fn random_box(random: &mut SplitMix64) -> Aabb {
    let a = random.vector();
    Aabb::of(&[a, a + random.vector() * 0.4])
}

/// Takes out `gone` boxes, and puts `new` ones in anywhere; the others keep their order. Returns the number of each box after it.
fn change(random: &mut SplitMix64, boxes: &mut Vec<Aabb>, gone: usize, new: usize) -> Vec<u32> {
    let mut from: Vec<u32> = (0..boxes.len() as u32).collect();
    for _ in 0..gone {
        from.remove(random.below(from.len() as u64) as usize);
    }
    for _ in 0..new {
        from.insert(random.below(from.len() as u64 + 1) as usize, NONE);
    }
    let mut to = vec![NONE; boxes.len()];
    for (number, &old) in (0..).zip(&from) {
        if old != NONE {
            to[old as usize] = number;
        }
    }
    let after = from.iter().map(|&old| match boxes.get(old as usize) {
        Some(bounds) => Aabb::of(&[bounds.min, bounds.max + Vector3::repeat(1e-3)]),
        None => random_box(random),
    });
    *boxes = after.collect();
    to
}

#[test]
fn a_set_of_which_few_boxes_change_keeps_its_tree() {
    let mut random = SplitMix64(3);
    let (mut small_trees, mut gone_of_small, mut pairs, mut found) = (0, 0, Vec::new(), 0);
    for round in 0..40 {
        let count = 200 + random.below(300) as usize;
        let mut boxes: Vec<Aabb> = (0..count).map(|_| random_box(&mut random)).collect();
        let mut bvh = Bvh::new();
        bvh.rebuild(&boxes);
        let mut added = 0;
        for step in 0..4 {
            // In three steps at most 12 % go and 9 % come: less than a third is loose, though what came and went counts twice. Then nearly half goes.
            let retained = step < 3;
            let fraction = |random: &mut SplitMix64, percent: u64| {
                random.below(count as u64 * percent / 100 + 1) as usize
            };
            let (gone, new) = match retained {
                true => (fraction(&mut random, 4), fraction(&mut random, 3)),
                false => (count * 2 / 5, 3),
            };
            let to = change(&mut random, &mut boxes, gone, new);
            bvh.renumber(&to);
            bvh.refit(&boxes);
            added += new;
            if retained {
                assert_eq!((bvh.first_tree, bvh.leaves.len()), (count, count + added));
                small_trees += usize::from(added > 0);
                let behind = bvh.leaves[count..].iter();
                gone_of_small += behind.filter(|leaf| leaf.index == NONE).count();
            } else {
                assert_eq!(
                    (bvh.first_tree, bvh.leaves.len()),
                    (boxes.len(), boxes.len())
                );
            }
            assert_eq!(bvh.len(), boxes.len());
            let queries: Vec<Aabb> = (0..20).map(|_| random_box(&mut random)).collect();
            let mut expected = Vec::new();
            for (i, query) in (0..).zip(&queries) {
                let met = (0..).zip(&boxes).filter(|(_, b)| query.overlaps(b));
                expected.extend(met.map(|(j, _)| [i, j]));
            }
            bvh.pairs(&queries, &mut pairs);
            assert_eq!(pairs, expected, "round {round}, step {step}");
            found += expected.len();
            for (index, bounds) in (0..).zip(&boxes) {
                assert_eq!(bvh.bounds(index), bounds);
            }
        }
    }
    assert!(
        small_trees > 100 && gone_of_small > 10 && found > 1000,
        "{small_trees} {gone_of_small} {found}"
    );
}
