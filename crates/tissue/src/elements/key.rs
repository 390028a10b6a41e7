//! By what an edit of the mesh finds elements.

/// The few nodes that make an element what it is, in ascending order: the ends of an edge, the corners of a face or a tetrahedron, the
/// node of a domain. Ordered by the first node, then the second and so on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key(u128);

/// No node.
const NONE: u32 = u32::MAX;

impl Key {
    /// That of at most four nodes in any order.
    pub fn new(nodes: &[u32]) -> Self {
        let mut all = [NONE; 4];
        match *nodes {
            [a] => all[0] = a,
            [a, b] => (all[0], all[1]) = (a.min(b), a.max(b)),
            _ => {
                all[..nodes.len()].copy_from_slice(nodes);
                for (i, j) in [(0, 1), (2, 3), (0, 2), (1, 3), (1, 2)] {
                    (all[i], all[j]) = (all[i].min(all[j]), all[i].max(all[j]));
                }
            }
        }
        // One number compares faster than four.
        Self(
            all.iter()
                .fold(0, |packed, node| packed << 32 | u128::from(*node)),
        )
    }

    /// The first node.
    pub fn first(self) -> u32 {
        (self.0 >> 96) as u32
    }

    /// Its nodes.
    pub fn nodes(self) -> KeyNodes {
        let all = [96, 64, 32, 0].map(|shift| (self.0 >> shift) as u32);
        let count = all.iter().take_while(|node| **node != NONE).count();
        KeyNodes { all, count }
    }

    /// The same with all nodes so many further on.
    pub fn shifted(self, by: u32) -> Self {
        let KeyNodes { mut all, count } = self.nodes();
        all[..count].iter_mut().for_each(|node| *node += by);
        Self::new(&all[..count])
    }

    /// The same with other numbers of its nodes; none where one has none.
    pub fn renamed(self, name: impl Fn(u32) -> Option<u32>) -> Option<Self> {
        let KeyNodes { mut all, count } = self.nodes();
        for node in &mut all[..count] {
            *node = name(*node)?;
        }
        Some(Self::new(&all[..count]))
    }
}

/// The nodes of a key.
#[derive(Clone, Copy, Debug)]
pub struct KeyNodes {
    all: [u32; 4],
    count: usize,
}

impl std::ops::Deref for KeyNodes {
    type Target = [u32];

    fn deref(&self) -> &[u32] {
        &self.all[..self.count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_do_not_depend_on_the_order_of_their_nodes() {
        for nodes in [&[5][..], &[3, 1], &[7, 0, 3], &[3, 1, 7, 0]] {
            let mut sorted = nodes.to_vec();
            sorted.sort_unstable();
            assert_eq!(*Key::new(nodes).nodes(), *sorted);
            assert_eq!(Key::new(nodes), Key::new(&sorted));
            assert_eq!(Key::new(nodes).first(), sorted[0]);
        }
        assert!(Key::new(&[1, 9]) < Key::new(&[2]) && Key::new(&[1, 2, 3]) < Key::new(&[1, 2]));
    }

    #[test]
    fn renamed_keys_are_ascending_again() {
        let key = Key::new(&[1, 2, 3]);
        assert_eq!(
            key.renamed(|node| Some(10 - node)),
            Some(Key::new(&[7, 8, 9]))
        );
        assert_eq!(key.renamed(|node| (node != 2).then_some(node)), None);
    }
}
