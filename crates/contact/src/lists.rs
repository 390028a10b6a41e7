//! Lists of different lengths.

/// Lists of different lengths, one after another.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Lists {
    firsts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    /// For each of `count` nodes the triangles at it, ascending.
    pub fn at_corners(count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut firsts = vec![0; count + 1];
        for &node in triangles.iter().flatten() {
            firsts[node as usize + 1] += 1;
        }
        for list in 0..count {
            firsts[list + 1] += firsts[list];
        }
        let mut next = firsts.clone();
        let mut items = vec![0; 3 * triangles.len()];
        for (triangle, nodes) in (0u32..).zip(triangles) {
            for &node in nodes {
                let place = &mut next[node as usize];
                items[*place as usize] = triangle;
                *place += 1;
            }
        }
        Self { firsts, items }
    }

    /// The items of a list.
    #[inline]
    pub fn of(&self, list: u32) -> &[u32] {
        let list = list as usize;
        &self.items[self.firsts[list] as usize..self.firsts[list + 1] as usize]
    }
}
