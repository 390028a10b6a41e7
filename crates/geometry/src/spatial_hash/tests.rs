use super::*;
use nalgebra::Vector3;

fn unit_box(corner: [f64; 3]) -> Aabb {
    let corner = Vector3::from(corner);
    Aabb::of(&[corner, corner + Vector3::repeat(0.5)])
}

/// Rounded towards zero, −0.4 and 0.4 would be in one cell (NUMERICS 1.4).
#[test]
fn cells_are_rounded_down() {
    let range = CellRange::of(
        &Aabb::of(&[Vector3::new(-0.4, -1.0, 0.4), Vector3::new(0.4, -0.5, 1.0)]),
        1.0,
    );
    assert_eq!((range.first, range.last), ([-1, -1, 0], [0, -1, 1]));
    assert_eq!(range.count(), 4);
}

/// Two cells with the same hash: a factor times 2³² is 0 modulo 2³², so no two cells nearer than that collide on one axis alone;
/// a pair over two axes is searched.
#[test]
fn two_cells_with_one_hash_are_told_apart() {
    let mut seen = std::collections::BTreeMap::new();
    let mut collision = None;
    'search: for i in 0..400 {
        for j in 0..400 {
            let cell = [i, j, 0];
            if let Some(other) = seen.insert(hash(&cell), cell) {
                collision = Some((cell, other));
                break 'search;
            }
        }
    }
    let (a, b) = collision.expect("160,000 cells in 2^32 places: about 3 collisions");
    let at = |cell: [i32; 3]| unit_box(cell.map(|c| f64::from(c) + 0.25));
    let mut set = SpatialHash::new();
    set.rebuild(1.0, &[at(a), at(b)]);
    assert_eq!(set.used.len(), 2);
    // Only the cells' own boxes are looked at.
    for (cell, index) in [(a, 0), (b, 1)] {
        let slot = set.slots[probe(&set.slots, set.stamp, &cell)];
        assert_eq!(
            set.members[slot.first as usize..][..slot.count as usize],
            [index]
        );
    }
}

/// The last stamp is followed by the first, and what older sets left in the table does not come back.
#[test]
fn stamps_start_again_without_a_trace() {
    let mut set = SpatialHash::new();
    let (here, there) = (unit_box([0.0; 3]), unit_box([7.0; 3]));
    let mut found = Vec::new();
    set.rebuild(1.0, &[here; 3]);
    set.stamp = u32::MAX - 1;
    set.rebuild(1.0, &[here; 3]);
    for _ in 0..3 {
        set.rebuild(1.0, &[there; 3]);
        set.query(&here, &mut found);
        assert!(found.is_empty());
        set.query(&there, &mut found);
        assert_eq!(found, [0, 1, 2]);
    }
    assert_eq!(set.stamp, 3);
}

/// A pair of boxes in 64 common cells is reported once; a box through more cells than may be entered is found as well.
#[test]
fn a_pair_is_reported_once_however_many_cells_it_shares() {
    let wide = Aabb::of(&[Vector3::zeros(), Vector3::repeat(3.5)]);
    let endless = Aabb::of(&[Vector3::repeat(-1e3), Vector3::repeat(1e3)]);
    let mut set = SpatialHash::new();
    let boxes = [wide, endless, unit_box([1.2; 3])].repeat(100);
    set.rebuild(1.0, &boxes);
    assert_eq!(set.large.len(), 100);
    let mut found = Vec::new();
    set.query(&wide, &mut found);
    assert_eq!(found, (0..300).collect::<Vec<u32>>());
}
