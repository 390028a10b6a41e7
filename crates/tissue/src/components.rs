//! Connected parts of a model.

use crate::model::TissueModel;

/// For each node the lowest node that elements couple it to, directly or through others.
pub(crate) fn components(model: &TissueModel) -> Vec<u32> {
    let mut lowest: Vec<u32> = (0..model.node_count() as u32).collect();
    for set in model.sets() {
        for element in 0..set.count() {
            for pair in set.nodes(element).windows(2) {
                let ends = [root(&mut lowest, pair[0]), root(&mut lowest, pair[1])];
                lowest[ends[0].max(ends[1]) as usize] = ends[0].min(ends[1]);
            }
        }
    }
    for node in 0..lowest.len() as u32 {
        lowest[node as usize] = root(&mut lowest, node);
    }
    lowest
}

fn root(lowest: &mut [u32], mut node: u32) -> u32 {
    while lowest[node as usize] != node {
        let next = lowest[lowest[node as usize] as usize];
        lowest[node as usize] = next;
        node = next;
    }
    node
}
