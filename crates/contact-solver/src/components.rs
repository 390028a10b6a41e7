//! Connected components of a body.

/// The components that elements hold together, in the order of their lowest nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Components {
    /// The component of each node.
    pub of_node: Vec<u32>,
    /// The lowest node of each component.
    pub lowest: Vec<u32>,
}

impl Components {
    /// Those of so many nodes with these groups.
    pub fn of_groups(groups: &mut Groups, nodes: usize) -> Self {
        let mut components = Self {
            of_node: Vec::with_capacity(nodes),
            lowest: Vec::new(),
        };
        for node in 0..nodes as u32 {
            let root = groups.root(node);
            if root == node {
                components.of_node.push(components.lowest.len() as u32);
                components.lowest.push(node);
            } else {
                // The root is the lowest node.
                components.of_node.push(components.of_node[root as usize]);
            }
        }
        components
    }

    /// Those of the union of bodies, one after another.
    pub fn joined<'a>(bodies: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut joined = Self::default();
        for own in bodies {
            let (first, part) = (joined.of_node.len() as u32, joined.lowest.len() as u32);
            joined
                .of_node
                .extend(own.of_node.iter().map(|own| own + part));
            joined
                .lowest
                .extend(own.lowest.iter().map(|node| node + first));
        }
        joined
    }
}

/// Disjoint groups of numbers, each with its lowest one (union–find).
pub struct Groups(Vec<u32>);

impl Groups {
    /// Each number alone.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// Joins the groups of these numbers.
    pub fn join(&mut self, members: &[u32]) {
        for pair in members.windows(2) {
            let (a, b) = (self.root(pair[0]), self.root(pair[1]));
            self.0[a.max(b) as usize] = a.min(b);
        }
    }

    /// The lowest number of a group.
    pub fn root(&mut self, mut member: u32) -> u32 {
        while self.0[member as usize] != member {
            let next = self.0[self.0[member as usize] as usize];
            self.0[member as usize] = next;
            member = next;
        }
        member
    }
}
