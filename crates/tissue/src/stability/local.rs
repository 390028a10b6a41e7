//! Remedies where an edit has been, in a time that goes with the nodes that it touched.

use crate::elements::key::Key;
use crate::model::TissueModel;

/// What a remedy did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Remedied {
    /// How many nodes had more than the step allows.
    pub nodes: usize,
    /// Inertia that was added [kg].
    pub added: f64,
    /// The smallest factor of a stiffness; 1 if none was lowered.
    pub smallest_factor: f64,
}

/// Gives these nodes, ascending, the inertia with which the step `h` [s] is stable at the share `safety` of the limit: of the inertia
/// that is beyond their mass what is needed, max(0, S_i h²/(4 s²) − m_i) by Gershgorin at rest, as
/// [`mass_floor`](super::mass_floor) for all. With every node of a body above its floor h·√λ_max ≤ 2 s.
///
/// Gershgorin's bound is 2 to 3.5 times λ_max (NUMERICS 3.2): at a `safety` close to 1 nodes that are well without it stay
/// as they are where the step is half of the limit or less. After 500 cuts in a cube of 10,368 tetrahedra, which make it 20,864, a step
/// of 0.6 of the limit before needs 15 % (selective) to 80 % more inertia (tetrahedra) at 60 to 90 % of the nodes; undamped the energy then
/// drifts by less than 0.3 % over 10,000 steps. Without it the body is gone after ten (`cargo run --release -p microsim-tissue
/// --example cut_stability`).
pub fn floor_nodes(model: &mut TissueModel, nodes: &[u32], h: f64, safety: f64) -> Remedied {
    let sums = model.row_sums();
    let sums: Vec<f64> = nodes.iter().map(|node| sums[*node as usize]).collect();
    let room = 4.0 * safety * safety / (h * h);
    let mut remedied = Remedied {
        smallest_factor: 1.0,
        ..Remedied::default()
    };
    for (&node, sum) in nodes.iter().zip(&sums) {
        let node = node as usize;
        if model.is_clamped(node) {
            continue;
        }
        let added = (sum / room - model.masses()[node]).max(0.0);
        remedied.nodes += usize::from(added > 0.0);
        remedied.added += added;
        model.add_inertia(node, added);
    }
    remedied
}

/// Lowers the stiffness of the elements at these nodes, ascending, so that the step `h` [s] is stable there at the share `safety` of the
/// limit, as [`stiffness_cap`](super::stiffness_cap) does for all: each by the smallest factor min(1, 4 s² m_i/(h² S_i)) of its nodes.
/// Inertia stays.
pub fn cap_nodes(model: &mut TissueModel, nodes: &[u32], h: f64, safety: f64) -> Remedied {
    let sums = model.row_sums();
    let sums: Vec<f64> = nodes.iter().map(|node| sums[*node as usize]).collect();
    let room = 4.0 * safety * safety / (h * h);
    let mut remedied = Remedied {
        smallest_factor: 1.0,
        ..Remedied::default()
    };
    let mut over: Vec<(u32, f64)> = Vec::new();
    for (&node, sum) in nodes.iter().zip(&sums) {
        let rate = sum * model.inverse_masses()[node as usize];
        if rate > room {
            over.push((node, room / rate));
            remedied.smallest_factor = remedied.smallest_factor.min(room / rate);
        }
    }
    remedied.nodes = over.len();
    let over_nodes: Vec<u32> = over.iter().map(|(node, _)| *node).collect();
    for set in 0..model.sets().len() {
        let mut factors: Vec<(u32, f64)> = Vec::new();
        for element in elements_at(model, set, &over_nodes) {
            let of_node = |node: &u32| {
                let place = over_nodes.binary_search(node).ok()?;
                Some(over[place].1)
            };
            let nodes = model.sets()[set].nodes(element as usize).iter();
            let factor = nodes.filter_map(of_node).fold(1.0, f64::min);
            if factor < 1.0 {
                factors.push((element, factor));
            }
        }
        if !factors.is_empty() {
            model.scale_elements(set, &factors);
        }
    }
    remedied
}

/// The elements of a set at these nodes, ascending, and others near.
fn elements_at(model: &TissueModel, set: usize, nodes: &[u32]) -> Vec<u32> {
    let index = model.index();
    let mut keys = Vec::new();
    match model.parts_made().get(set) {
        // Every element at a node has a key in one of its tetrahedra.
        Some(part) => {
            let tets = nodes.iter().flat_map(|node| index.tets_at(*node));
            let mut tets: Vec<u32> = tets.copied().collect();
            tets.sort_unstable();
            tets.dedup();
            for tet in tets {
                let tet = &model.tets()[tet as usize];
                part.carried.keys(tet, |key| keys.push(key));
            }
        }
        // Ties are found by each of their nodes.
        None => keys.extend(nodes.iter().map(|node| Key::new(&[*node]))),
    }
    keys.sort_unstable();
    keys.dedup();
    let found = keys.into_iter().flat_map(|key| index.set(set).find(key));
    let mut elements: Vec<u32> = found.collect();
    elements.sort_unstable();
    elements.dedup();
    elements
}
