//! Where elements and nodes come to lie when others are taken out and the last ones fill their places.

use std::collections::BTreeMap;

/// The last place of each that moves, from moves made one after the other.
pub(crate) fn last_places(moves: &[(u32, u32)]) -> BTreeMap<u32, u32> {
    let mut places = BTreeMap::new();
    let mut first_place = BTreeMap::new();
    for &(from, to) in moves {
        let first = first_place.remove(&from).unwrap_or(from);
        first_place.insert(to, first);
        places.insert(first, to);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 0 to 5 without 2 and 4: 5 comes to 4, and from there to 2.
    #[test]
    fn what_moves_twice_is_where_it_came_last() {
        assert_eq!(last_places(&[(5, 4), (4, 2)]), BTreeMap::from([(5, 2)]));
        assert_eq!(
            last_places(&[(5, 1), (4, 0)]),
            BTreeMap::from([(5, 1), (4, 0)])
        );
    }
}
