//! What an edit of the mesh does to a set of elements: some go, others take their places.
//!
//! Places are filled so that as few as possible move: added elements take those of removed ones in ascending order, further ones come
//! at the end; what stays empty is filled from the end.

/// Takes the entries at `removed`, ascending, out of an array, and puts `added` in.
pub fn splice<T: Clone>(array: &mut Vec<T>, removed: &[u32], added: &[T]) {
    let both = removed.len().min(added.len());
    for (&place, value) in removed.iter().zip(added) {
        array[place as usize] = value.clone();
    }
    array.extend_from_slice(&added[both..]);
    for &place in removed[both..].iter().rev() {
        array.swap_remove(place as usize);
    }
}

/// Makes room for half as many entries again: an array that grows by a little must not be copied while a body is cut. Memory that is not
/// used costs nothing.
pub fn make_room<T>(array: &mut Vec<T>) {
    array.reserve(array.len() / 2);
}

/// Where [`splice`] of `added` entries puts them, and which others move in an array of `count`: pairs of old and new place.
pub fn places(count: usize, removed: &[u32], added: usize) -> (Vec<u32>, Vec<[u32; 2]>) {
    let both = removed.len().min(added);
    let further = (count..).take(added - both).map(|place| place as u32);
    let placed = removed[..both].iter().copied().chain(further).collect();
    let mut moves: Vec<[u32; 2]> = Vec::new();
    let mut last = count;
    for &place in removed[both..].iter().rev() {
        last -= 1;
        let last = last as u32;
        // The last one may have come from behind itself.
        match moves.iter_mut().find(|[_, to]| *to == last) {
            Some(moved) => moved[1] = place,
            None if last != place => moves.push([last, place]),
            None => {}
        }
    }
    (placed, moves)
}

/// An internal variable of an added element: a sum over those of elements before the edit, of the same set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inherited {
    /// What it is without any.
    pub constant: f64,
    /// Places among the internal variables of the set before the edit, each with its factor.
    pub terms: Vec<(u32, f64)>,
}

/// What makes the internal variables of an added element of the sums that it inherits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// They are the sums.
    #[default]
    Sum,
    /// They are means of a [`PlasticState`](super::PlasticState), whose determinant has to be 1 again.
    PlasticState,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against an array of names: each place holds what it should.
    #[test]
    fn places_are_those_of_the_splice() {
        for (removed, added) in [
            (&[][..], 0),
            (&[], 3),
            (&[0, 4, 9], 2),
            (&[1, 2, 3, 8, 9], 1),
            (&[3, 5, 7, 8], 0),
            (&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9], 0),
            (&[6, 9], 5),
        ] {
            let before: Vec<u32> = (0..10).collect();
            let mut after = before.clone();
            let values: Vec<u32> = (100..).take(added).collect();
            splice(&mut after, removed, &values);
            let (placed, moves) = places(before.len(), removed, added);
            assert_eq!(after.len(), before.len() + added - removed.len());
            for (place, value) in placed.iter().zip(&values) {
                assert_eq!(after[*place as usize], *value);
            }
            for [from, to] in &moves {
                assert_eq!(after[*to as usize], *from);
            }
            for value in before.iter().filter(|v| !removed.contains(v)) {
                let moved = moves.iter().find(|[from, _]| from == value);
                assert_eq!(after[moved.map_or(*value, |m| m[1]) as usize], *value);
            }
        }
    }
}
