use super::*;
use microsim_geometry::signed_volume;
use microsim_random::SplitMix64;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Whether a set can be divided: it is not empty and holds no three edges of a face.
fn is_divisible(set: EdgeSet) -> bool {
    POSITIONS[set as usize].is_some()
}

/// Letter of the pattern of a set; `None` for one that no pattern is for.
fn pattern_of(set: EdgeSet) -> Option<char> {
    POSITIONS[set as usize].map(|position| PATTERNS[position.pattern].name)
}

type V3 = Vector3<f64>;

/// A positive tetrahedron, away from flat.
fn tetrahedron(random: &mut SplitMix64) -> [V3; 4] {
    loop {
        let mut corners = std::array::from_fn(|_| random.vector());
        let [a, b, c, d] = corners;
        let volume = signed_volume(&a, &b, &c, &d);
        if volume < 0.0 {
            corners.swap(0, 1);
        }
        if volume.abs() > 0.05 {
            return corners;
        }
    }
}

fn volume(corners: [V3; 4]) -> f64 {
    let [a, b, c, d] = corners;
    signed_volume(&a, &b, &c, &d)
}

/// Where a node lies, for one fraction on each edge.
fn place(node: PatternNode, corners: &[V3; 4], fractions: &[f64; 6]) -> V3 {
    let [i, j] = node.map(usize::from);
    if i == j {
        return corners[i];
    }
    let (low, high) = (i.min(j), i.max(j));
    corners[low] + (corners[high] - corners[low]) * fractions[edge_between(i, j)]
}

/// Outward faces of a positive tetrahedron.
const FACES: [[usize; 3]; 4] = [[1, 2, 3], [2, 0, 3], [0, 1, 3], [0, 2, 1]];

/// A triangle from its smallest node on, so that equal ones are equal.
fn turned(t: [PatternNode; 3]) -> [PatternNode; 3] {
    let first = (0..3).min_by_key(|&k| t[k]).unwrap();
    [t[first], t[(first + 1) % 3], t[(first + 2) % 3]]
}

/// The outward triangles of a set of tetrahedra that no other of them has from the other side. An inner one has two.
fn boundary(tets: &[[PatternNode; 4]]) -> Vec<[PatternNode; 3]> {
    let mut count: BTreeMap<[PatternNode; 3], i32> = BTreeMap::new();
    for tet in tets {
        for face in FACES {
            *count.entry(turned(face.map(|k| tet[k]))).or_default() += 1;
        }
    }
    assert!(count.values().all(|&n| n == 1), "a face twice");
    let open = |t: &[PatternNode; 3]| !count.contains_key(&turned([t[0], t[2], t[1]]));
    count.keys().copied().filter(open).collect()
}

/// The face rule (NUMERICS 4.0, 4.8) for the face of corners `f`, counter-clockwise.
fn face_rule(f: [u8; 3], set: EdgeSet, ids: [u32; 4]) -> Vec<[PatternNode; 3]> {
    let cut = |i: u8, j: u8| set & 1 << edge_between(i as usize, j as usize) != 0;
    let at = |i: u8| [i, i];
    let crossed = (0..3).filter(|&k| cut(f[k], f[(k + 1) % 3])).count();
    // Turned so that the crossed edge is u–v (one), or the common corner is w (two).
    let place = (0..3).find(|&k| {
        let [u, v, w] = [f[k], f[(k + 1) % 3], f[(k + 2) % 3]];
        match crossed {
            0 => true,
            1 => cut(u, v),
            _ => cut(w, u) && cut(w, v),
        }
    });
    let k = place.unwrap();
    let [u, v, w] = [f[k], f[(k + 1) % 3], f[(k + 2) % 3]];
    let triangles = match crossed {
        0 => vec![[at(u), at(v), at(w)]],
        1 => vec![[at(u), [u, v], at(w)], [[v, u], at(v), at(w)]],
        _ if ids[u as usize] < ids[v as usize] => {
            vec![
                [[w, u], [w, v], at(w)],
                [at(u), at(v), [v, w]],
                [at(u), [v, w], [u, w]],
            ]
        }
        _ => vec![
            [[w, u], [w, v], at(w)],
            [at(u), at(v), [u, w]],
            [at(v), [v, w], [u, w]],
        ],
    };
    triangles.into_iter().map(turned).collect()
}

/// The 41 sets without three edges of a face.
fn divisible() -> Vec<EdgeSet> {
    let holds_face = |set: u8| {
        FACES
            .iter()
            .any(|f| (0..3).all(|k| set & 1 << edge_between(f[k], f[(k + 1) % 3]) != 0))
    };
    (1..64).filter(|&set| !holds_face(set)).collect()
}

fn every_case() -> impl Iterator<Item = (EdgeSet, [u32; 4])> {
    divisible()
        .into_iter()
        .flat_map(|set| permutations().map(move |order| (set, order.map(|i| i as u32 + 5))))
}

/// NUMERICS 4.7: 41 sets with the empty one.
#[test]
fn the_patterns_cover_exactly_the_sets_without_a_whole_face() {
    let mut count: BTreeMap<char, usize> = BTreeMap::new();
    for set in 0..64 {
        assert_eq!(is_divisible(set), divisible().contains(&set), "{set:06b}");
        if let Some(name) = pattern_of(set) {
            *count.entry(name).or_default() += 1;
        }
    }
    let expected = [('A', 6), ('B', 12), ('C', 12), ('D', 4), ('E', 3), ('F', 3)];
    assert_eq!(count.into_iter().collect::<Vec<_>>(), expected);
}

/// Every set with every order of ids (so every combination of diagonals): children are positive and fill the parent, whatever the
/// fractions; their boundary is the face rule's triangles and the two sides of the crack, and the crack closes.
#[test]
fn children_fill_their_parent_and_their_faces_keep_the_rule() {
    let mut random = SplitMix64(1);
    for (set, ids) in every_case() {
        let tets = divide(set, ids);
        for _ in 0..4 {
            let corners = tetrahedron(&mut random);
            let fractions = std::array::from_fn(|_| 0.5 + 0.45 * random.number());
            let volumes = tets
                .iter()
                .map(|tet| volume(tet.map(|node| place(node, &corners, &fractions))));
            let volumes: Vec<f64> = volumes.collect();
            let name = pattern_of(set).unwrap();
            assert!(
                volumes.iter().all(|&v| v > 0.0),
                "{name} {set:06b} {ids:?} {volumes:?}"
            );
            let sum: f64 = volumes.iter().sum();
            assert!(
                (sum - volume(corners)).abs() < 1e-14,
                "{name} {set:06b} {ids:?}"
            );
        }
        let mut open = boundary(&tets);
        for face in FACES {
            let face = face.map(|k| k as u8);
            for triangle in face_rule(face, set, ids) {
                let at = open.iter().position(|t| *t == triangle);
                open.remove(at.unwrap_or_else(|| panic!("{set:06b} {ids:?}: {triangle:?}")));
            }
        }
        // The two sides of the crack are the same triangles, reversed, with both copies of each node at one.
        let joined = |t: &[PatternNode; 3]| turned(t.map(|[i, j]| [i.min(j), i.max(j)]));
        let mut sides: Vec<_> = open.iter().map(joined).collect();
        sides.sort_unstable();
        for t in &sides {
            assert!(sides.binary_search(&turned([t[0], t[2], t[1]])).is_ok());
        }
        assert!(sides.windows(2).all(|pair| pair[0] != pair[1]));
    }
}

/// Edges of the children that touch a new node, as appendix B numbers them: A 6, B 11, C 18 and the missing one (NUMERICS 4.3), D 15, E 22. F: four
/// half edges, each of four copies to both corners opposite, and to both copies there.
#[test]
fn edges_at_new_nodes_are_those_of_the_appendix() {
    for (set, ids) in every_case() {
        let mut edges: Vec<[PatternNode; 2]> = Vec::new();
        for tet in divide(set, ids) {
            for [i, j] in EDGES {
                let edge = [tet[i].min(tet[j]), tet[i].max(tet[j])];
                if edge.iter().any(|[near, far]| near != far) && !edges.contains(&edge) {
                    edges.push(edge);
                }
            }
        }
        let expected = match pattern_of(set).unwrap() {
            'A' => 6,
            'B' => 11,
            'C' => 19,
            'D' => 15,
            'E' => 22,
            _ => 4 + 4 * 2 + 2 * 2,
        };
        assert_eq!(edges.len(), expected, "{set:06b}");
    }
}

/// Complete cuts fall into exactly two parts without a common node; partial ones hang together at nodes (NUMERICS 4.1–4.6).
#[test]
fn complete_patterns_fall_apart() {
    for (set, ids) in every_case() {
        let tets = divide(set, ids);
        let mut part: Vec<usize> = (0..tets.len()).collect();
        for i in 0..tets.len() {
            for j in 0..i {
                let common = tets[i].iter().filter(|n| tets[j].contains(n)).count();
                if common == 3 {
                    let (from, to) = (part[i].max(part[j]), part[i].min(part[j]));
                    part.iter_mut()
                        .filter(|p| **p == from)
                        .for_each(|p| *p = to);
                }
            }
        }
        let mut parts = part.clone();
        parts.sort_unstable();
        parts.dedup();
        let expected = match pattern_of(set).unwrap() {
            'A' | 'B' | 'D' | 'E' => 2,
            'C' => 3,
            _ => 4,
        };
        assert_eq!(parts.len(), expected, "{set:06b}");
    }
}

/// A neighbour across any face has the same triangles on it, from the other side: the rule looks at ids and crossings of that
/// face alone, so it is enough that two tetrahedra with a common face and any crossings elsewhere agree there.
#[test]
fn neighbours_have_the_same_triangles_on_their_face() {
    // (0, 1, 2, 3) and its mirror image (1, 0, 2, 4) have the face 0, 1, 2 in common; ids by place, or reversed.
    for set in divisible() {
        for other in divisible() {
            let of_face = |set: EdgeSet| set & 0b001011;
            let mirrored = |set: EdgeSet| {
                EDGES.iter().enumerate().fold(0, |sum, (k, &[i, j])| {
                    let swap = |c: usize| [1, 0, 2, 3][c];
                    sum | (set >> k & 1) << edge_between(swap(i), swap(j))
                })
            };
            if of_face(set) != of_face(mirrored(other)) {
                continue;
            }
            for ids in permutations().map(|order| order.map(|i| i as u32)) {
                let on_face = |tets: Vec<[PatternNode; 4]>, swap: [u8; 4]| {
                    let named = |[i, j]: PatternNode| [swap[i as usize], swap[j as usize]];
                    let triangles = boundary(&tets).into_iter().map(|t| t.map(named));
                    let inside = |t: &[PatternNode; 3]| t.iter().flatten().all(|&c| c < 3);
                    let mut found: Vec<_> = triangles.filter(inside).map(turned).collect();
                    found.sort_unstable();
                    found
                };
                let mine = on_face(divide(set, ids), [0, 1, 2, 3]);
                let theirs = divide(other, [ids[1], ids[0], ids[2], ids[3]]);
                let mut theirs: Vec<_> = on_face(theirs, [1, 0, 2, 3])
                    .into_iter()
                    .map(|t| turned([t[0], t[2], t[1]]))
                    .collect();
                theirs.sort_unstable();
                assert_eq!(mine, theirs, "{set:06b} {other:06b} {ids:?}");
            }
        }
    }
}

/// The oracle of NUMERICS 4.8: one crossed edge after another, each halving every tetrahedron at it. What comes out of a complete cut has
/// no corners of both sides, and as much volume on each side where the cut is plane; so have the patterns.
#[test]
fn halving_edge_by_edge_comes_to_the_same_sides() {
    let mut random = SplitMix64(2);
    for (set, ids) in every_case() {
        let name = pattern_of(set).unwrap();
        if !matches!(name, 'D' | 'E') {
            continue;
        }
        let corners = tetrahedron(&mut random);
        let fractions: [f64; 6] = std::array::from_fn(|_| 0.5 + 0.4 * random.number());
        let mut halved = vec![[[0, 0], [1, 1], [2, 2], [3, 3]]];
        for (k, edge) in EDGES.iter().enumerate() {
            if set & 1 << k != 0 {
                let edge = edge.map(|c| c as u8);
                halved = halved
                    .into_iter()
                    .flat_map(|tet| halve(tet, edge))
                    .collect();
            }
        }
        let crossed = |i: u8, j: u8| i != j && set & 1 << edge_between(i as usize, j as usize) != 0;
        // Volumes of the children with a corner on this one's side; corners on one side are not crossed from it.
        let volume_at = |tets: &[[PatternNode; 4]], corner: u8| -> f64 {
            let here = |tet: &&[PatternNode; 4]| {
                let mut own = tet.iter().filter(|[i, j]| i == j);
                own.any(|[i, _]| !crossed(*i, corner))
            };
            let places = |tet: &[PatternNode; 4]| tet.map(|node| place(node, &corners, &fractions));
            tets.iter()
                .filter(here)
                .map(|tet| volume(places(tet)))
                .sum()
        };
        let divided = divide(set, ids);
        for tet in halved.iter().chain(&divided) {
            let own: Vec<u8> = tet.iter().filter(|[i, j]| i == j).map(|n| n[0]).collect();
            assert!(own.iter().all(|&i| own.iter().all(|&j| !crossed(i, j))));
        }
        if name == 'D' {
            for corner in 0..4 {
                let (ours, theirs) = (volume_at(&divided, corner), volume_at(&halved, corner));
                assert!((ours - theirs).abs() < 1e-14, "{set:06b} {ours} {theirs}");
            }
        }
    }
}

/// The two halves of a tetrahedron at an edge, or itself.
fn halve(tet: [PatternNode; 4], [u, v]: [u8; 2]) -> Vec<[PatternNode; 4]> {
    if !tet.contains(&[u, u]) || !tet.contains(&[v, v]) {
        return vec![tet];
    }
    let put = |corner: u8| tet.map(|n| if n == [corner, corner] { [u, v] } else { n });
    vec![put(v), put(u)]
}
