//! Connected parts of a model.

use crate::model::TissueModel;

/// For each node the lowest node that elements couple it to, directly or through others.
pub(crate) fn components(model: &TissueModel) -> Vec<u32> {
    let mut lowest: Vec<u32> = (0..model.node_count() as u32).collect();
    let mut join = |nodes: &[u32]| {
        for pair in nodes.windows(2) {
            let ends = [root(&mut lowest, pair[0]), root(&mut lowest, pair[1])];
            lowest[ends[0].max(ends[1]) as usize] = ends[0].min(ends[1]);
        }
    };
    // What is made of materials couples the nodes of each tetrahedron, and no others.
    let made = model.parts_made().len();
    if made > 0 {
        model.tets().iter().for_each(|tet| join(tet));
    }
    for set in &model.sets()[made..] {
        (0..set.count()).for_each(|element| join(set.nodes(element)));
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
