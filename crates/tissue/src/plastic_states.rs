//! What has flowed in each tetrahedron of a body, whatever domains carry its material: for pictures and reports.

use crate::elements::key::Key;
use crate::elements::{Elements, PlasticState};
use crate::material::{Carried, Part};
use crate::model::TissueModel;
use crate::state::State;
use microsim_mesh::{PARTS, TetMesh};

impl TissueModel {
    /// What has flowed in each tetrahedron of `mesh`, that of the body as it is now: the mean over the domains of which it is a part. None
    /// in a body of which no continuum flows.
    pub fn plastic_states(&self, mesh: &TetMesh, state: &State) -> Option<Vec<PlasticState>> {
        let mut states: Option<Vec<PlasticState>> = None;
        for (set, part) in self.parts_made().iter().enumerate() {
            let elements = &*self.sets()[set];
            let internal = &state.internal[self.internal_range(set)];
            let at = |element: usize| elements.plastic_state(element, internal);
            if elements.count() == 0 || at(0).is_none() {
                continue;
            }
            let states = states.get_or_insert_with(|| vec![PlasticState::START; mesh.tets.len()]);
            let domains = domains_of_tets(mesh, part, elements);
            for (tet, domains) in domains {
                let of = domains.into_iter().filter_map(at);
                if let Some(mean) = PlasticState::mean(of) {
                    states[tet] = mean;
                }
            }
        }
        states
    }
}

/// Each tetrahedron of a part with the elements of its set of which it is one.
fn domains_of_tets(
    mesh: &TetMesh,
    part: &Part,
    elements: &dyn Elements,
) -> Vec<(usize, Vec<usize>)> {
    let of_region = (0..mesh.tets.len()).filter(|tet| mesh.regions[*tet] == part.region);
    if let Carried::Quadratic(_) = part.carried {
        // Eight parts have as many points, in order; the first parts, at the corners, one each.
        let tets: Vec<usize> = of_region.collect();
        let points = elements.count() * PARTS / tets.len();
        let points_of = |place: usize| {
            let (element, part) = (place / PARTS, place % PARTS);
            let own = if part < points {
                part..part + 1
            } else {
                0..points
            };
            own.map(|point| points * element + point).collect()
        };
        let parts = tets.into_iter().enumerate();
        return parts.map(|(place, tet)| (tet, points_of(place))).collect();
    }
    let mut keys: Vec<(Key, usize)> = Vec::new();
    for element in 0..elements.count() {
        elements.keys(element, &mut |key| keys.push((key, element)));
    }
    keys.sort_unstable();
    let domains = |tet: usize| {
        let mut found = Vec::new();
        part.carried.keys(&mesh.tets[tet], |key| {
            let first = keys.partition_point(|(other, _)| *other < key);
            let same = keys[first..].iter().take_while(|(other, _)| *other == key);
            found.extend(same.map(|(_, element)| *element));
        });
        found
    };
    of_region.map(|tet| (tet, domains(tet))).collect()
}
