//! The edit itself, once it is known to be possible: nodes, tetrahedra, sets, masses, parts.

use super::ModelEdit;
use super::plan::Plan;
use super::state::{ModelChange, SetChange};
use crate::elements::key::Key;
use crate::elements::splice::{places, splice};
use crate::elements::{Coupling, Elements, Followed, Sliding, patches};
use crate::material::{Carried, Part};
use crate::model::RowSums;
use crate::model::TissueModel;
use microsim_mesh::{TetMesh, signed_volume};
use std::any::Any;
use std::sync::{Arc, OnceLock};

/// What goes out of a set, and what comes in.
struct Exchange {
    /// Ascending.
    removed: Vec<u32>,
    added: Arc<dyn Elements>,
    /// For each added element the elements of the set from which it inherits.
    ancestors: Vec<Vec<u32>>,
}

/// Nodes that an edit touches, each once.
struct Touched {
    seen: Vec<bool>,
    nodes: Vec<u32>,
}

impl Touched {
    /// None of so many.
    fn none(nodes: usize) -> Self {
        Self {
            seen: vec![false; nodes],
            nodes: Vec::new(),
        }
    }

    fn add(&mut self, node: u32) {
        if !std::mem::replace(&mut self.seen[node as usize], true) {
            self.nodes.push(node);
        }
    }
}

impl TissueModel {
    /// Follows an edit that has been checked.
    pub(super) fn follow(&mut self, edit: &ModelEdit<'_>, plan: &Plan) -> ModelChange {
        // Ties need the rest positions before the edit.
        let first_coupling = self.made_of.len();
        let removed: Vec<Vec<u32>> = (0..first_coupling)
            .map(|set| self.removed(set, edit.mesh, plan))
            .collect();
        let ties: Vec<Option<Exchange>> = (first_coupling..self.sets.len())
            .map(|set| self.exchange_ties(set, edit, plan))
            .collect();
        let mut sums = self.row_sums.take();
        if let Some(sums) = &mut sums {
            for (set, removed) in removed.iter().enumerate() {
                self.add_rows(set, removed.iter().copied(), -1.0, sums);
            }
            for (set, ties) in (first_coupling..).zip(&ties) {
                let removed = ties.iter().flat_map(|ties| ties.removed.iter().copied());
                self.add_rows(set, removed, -1.0, sums);
            }
            sums.resize(self.node_count() + edit.new_nodes.len(), RowSums::default());
            splice(sums, &edit.removed_nodes, &[]);
        }
        self.follow_mesh(edit, plan);
        self.follow_components(plan, ties.iter().any(Option::is_some));

        let mut touched = Touched::none(plan.nodes.count());
        let mut changes = Vec::with_capacity(self.sets.len());
        let (mut removed, mut ties) = (removed.into_iter(), ties.into_iter());
        for set in 0..self.sets.len() {
            let exchange = match self.made_of.get(set).copied() {
                Some(part) => {
                    let removed = removed.next().unwrap_or_default();
                    match part.carried {
                        Carried::Patches(_) => {
                            self.exchange_patches(set, &part, removed, edit.mesh, plan)
                        }
                        _ => self.exchange_around(set, &part, removed, edit.mesh, plan),
                    }
                }
                None => ties.next().flatten(),
            };
            let change = match exchange {
                Some(exchange) => {
                    let change = self.exchange(set, &exchange, plan, &mut touched);
                    if let Some(sums) = &mut sums {
                        let added = &change.placed[..change.added];
                        self.add_rows(set, added.iter().copied(), 1.0, sums);
                    }
                    change
                }
                None => SetChange::none(self.sets[set].count(), self.internal[set].len()),
            };
            changes.push(change);
        }
        self.row_sums = sums.map_or_else(OnceLock::new, OnceLock::from);
        let mut index = self.take_index();
        index.resize(plan.nodes.count());
        self.put_index(index);
        let mut start = 0;
        for (set, change) in changes.iter().enumerate() {
            let blocks = change.blocks();
            let end = start + blocks * self.sets[set].count();
            self.internal[set] = start..end;
            start = end;
        }
        let changed = plan.changed().flat_map(|e| edit.mesh.tets[e as usize]);
        let gone = plan.gone.iter().flat_map(|(_, tet)| *tet);
        let gone = gone.filter_map(|node| plan.nodes.after(node));
        changed.chain(gone).for_each(|node| touched.add(node));
        let mut touched = touched.nodes;
        touched.sort_unstable();
        self.follow_masses(&touched, edit.mesh);
        let placed: Vec<&[u32]> = changes.iter().map(|change| &change.placed[..]).collect();
        self.follow_parts(&placed);
        ModelChange {
            touched,
            new_nodes: edit.new_nodes.clone(),
            removed_nodes: edit.removed_nodes.clone(),
            sets: changes,
        }
    }

    /// Nodes and tetrahedra, and which are where. Nodes that leave keep their place in the index until the sets have followed.
    fn follow_mesh(&mut self, edit: &ModelEdit<'_>, plan: &Plan) {
        let mesh = edit.mesh;
        let before = self.rest_positions.len();
        for (place, fixed) in edit.clamped.iter().enumerate() {
            // Positions and masses come below.
            self.rest_positions.push(nalgebra::Vector3::zeros());
            self.masses.push(0.0);
            self.added_inertia.push(0.0);
            self.inverse_masses.push(if *fixed { 0.0 } else { 1.0 });
            if *fixed {
                self.clamped.push((before + place) as u32);
            }
        }
        let all = self.rest_positions.len();
        let removed = &edit.removed_nodes;
        splice(&mut self.rest_positions, removed, &[]);
        splice(&mut self.masses, removed, &[]);
        splice(&mut self.added_inertia, removed, &[]);
        splice(&mut self.inverse_masses, removed, &[]);
        let new = before as u32..all as u32;
        for node in new.filter_map(|node| plan.nodes.after(node)) {
            self.rest_positions[node as usize] = mesh.positions[node as usize];
        }
        if !removed.is_empty() {
            let clamped = self.clamped.iter().filter_map(|&n| plan.nodes.after(n));
            self.clamped = clamped.collect();
            self.clamped.sort_unstable();
        }
        self.drags[0].0 = 0..self.rest_positions.len();

        let mut index = self.take_index();
        index.resize(all);
        for (element, tet) in &plan.gone {
            index.remove_tet(*element, tet);
        }
        let kept = || plan.reshaped.iter().chain(&plan.renumbered);
        for (element, _) in kept() {
            index.remove_tet(*element, &self.tets[*element as usize]);
        }
        let elements = plan.elements.count();
        let (tet, volume) = ([0; 4], 0.0);
        self.tets.resize(elements.max(self.tets.len()), tet);
        self.rest_volumes
            .resize(elements.max(self.tets.len()), volume);
        let after = kept().map(|(_, element)| *element);
        for element in plan.fresh.iter().map(|(element, _)| *element).chain(after) {
            let tet = mesh.tets[element as usize];
            self.tets[element as usize] = tet;
            let [a, b, c, d] = mesh.corners(element as usize);
            self.rest_volumes[element as usize] = signed_volume(&a, &b, &c, &d);
            index.add_tet(element, &tet);
        }
        self.tets.truncate(elements);
        self.rest_volumes.truncate(elements);
        self.put_index(index);
    }

    /// The elements that go out of a set, ascending.
    fn removed(&self, set: usize, mesh: &TetMesh, plan: &Plan) -> Vec<u32> {
        let carried = self.made_of[set].carried;
        let mut keys = self.keys_gone(set, plan);
        let before = plan.nodes_before();
        // A key of the mesh after the edit that there was before, too.
        let was = |node: u32| {
            let node = plan.nodes.before(node);
            ((node as usize) < before).then_some(node)
        };
        for element in plan.changed() {
            if mesh.regions[element as usize] == self.made_of[set].region {
                let tet = &mesh.tets[element as usize];
                carried.keys(tet, |key| keys.extend(key.renamed(was)));
            }
        }
        keys.sort_unstable();
        keys.dedup();
        let index = self.index().set(set);
        let found = keys.into_iter().flat_map(|key| index.find(key));
        let mut removed: Vec<u32> = found.collect();
        removed.sort_unstable();
        removed.dedup();
        removed
    }

    /// The keys of tetrahedra that are gone.
    fn keys_gone(&self, set: usize, plan: &Plan) -> Vec<Key> {
        let mut keys: Vec<Key> = Vec::new();
        for (_, tet) in &plan.gone {
            self.made_of[set].carried.keys(tet, |key| keys.push(key));
        }
        keys
    }

    /// Elements of a set that are made around keys.
    fn exchange_around(
        &self,
        set: usize,
        part: &Part,
        removed: Vec<u32>,
        mesh: &TetMesh,
        plan: &Plan,
    ) -> Option<Exchange> {
        let index = self.index();
        let gone = self.keys_gone(set, plan).into_iter();
        let now = gone.filter_map(|key| key.renamed(|node| plan.nodes.after(node)));
        let mut new: Vec<Key> = now.collect();
        for element in plan.changed() {
            if mesh.regions[element as usize] == part.region {
                let tet = &mesh.tets[element as usize];
                part.carried.keys(tet, |key| new.push(key));
            }
        }
        new.sort_unstable();
        new.dedup();
        let (mut around, mut tets) = (Vec::new(), Vec::new());
        for key in &new {
            tets.clear();
            index.tets_of(*key, &self.tets, &mut tets);
            let of_region = |e: &&u32| mesh.regions[**e as usize] == part.region;
            around.extend(
                tets.iter()
                    .filter(of_region)
                    .map(|element| (*key, *element)),
            );
        }
        if removed.is_empty() && around.is_empty() {
            return None;
        }
        let ancestors = match self.internal[set].is_empty() {
            true => Vec::new(),
            false => around
                .chunk_by(|a, b| a.0 == b.0)
                .map(|members| self.ancestors(set, part, members, plan))
                .collect(),
        };
        Some(Exchange {
            removed,
            added: part.build_around(mesh, &around),
            ancestors,
        })
    }

    /// The elements of a set before the edit from which one with this key around these elements inherits.
    fn ancestors(&self, set: usize, part: &Part, around: &[(Key, u32)], plan: &Plan) -> Vec<u32> {
        let index = self.index().set(set);
        let wanted = around[0].0.nodes();
        let mut support: Vec<u32> = Vec::new();
        for &node in &*wanted {
            let node = plan.nodes.before(node);
            match (node as usize).checked_sub(plan.nodes_before()) {
                None => support.push(node),
                Some(new) => support.extend_from_slice(&plan.supports[new]),
            }
        }
        support.sort_unstable();
        support.dedup();
        if support.len() == wanted.len() {
            let same: Vec<u32> = index.find(Key::new(&support)).collect();
            if !same.is_empty() {
                return same;
            }
        }
        let mut found: Vec<u32> = Vec::new();
        for (_, element) in around {
            let Ok(place) = plan.fresh.binary_search_by_key(element, |f| f.0) else {
                continue;
            };
            let parent = plan.fresh[place].1;
            // A parent that is as it was still stands where it did.
            let tet = match plan.gone.binary_search_by_key(&parent, |g| g.0) {
                Ok(place) => plan.gone[place].1,
                Err(_) => continue,
            };
            part.carried.keys(&tet, |key| found.extend(index.find(key)));
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Patches that were touched, formed again among what is left of them and what is new; those that only have other numbers are made of
    /// the same elements.
    fn exchange_patches(
        &self,
        set: usize,
        part: &Part,
        removed: Vec<u32>,
        mesh: &TetMesh,
        plan: &Plan,
    ) -> Option<Exchange> {
        let index = self.index();
        let gone = plan
            .gone
            .iter()
            .flat_map(|(_, tet)| index.set(set).find(Key::new(tet)));
        let mut dissolved: Vec<u32> = gone.collect();
        dissolved.sort_unstable();
        dissolved.dedup();
        let mut kept = removed.clone();
        kept.retain(|patch| dissolved.binary_search(patch).is_err());
        let members = |patch: u32| {
            let mut members: Vec<u32> = Vec::new();
            self.sets[set].keys(patch as usize, &mut |key| {
                let now = key.renamed(|node| plan.nodes.after(node));
                if let Some(now) = now {
                    index.tets_of(now, &self.tets, &mut members);
                }
            });
            members
        };
        let mut free: Vec<u32> = dissolved.iter().flat_map(|patch| members(*patch)).collect();
        let fresh = plan.fresh.iter().map(|(element, _)| *element);
        free.extend(fresh.filter(|e| mesh.regions[*e as usize] == part.region));
        free.sort_unstable();
        free.dedup();
        let mut pairs: Vec<(u32, u32)> = patches(mesh, &free)
            .into_iter()
            .zip(free.iter().copied())
            .collect();
        let formed = pairs.iter().map(|(patch, _)| patch + 1).max().unwrap_or(0);
        for (patch, old) in (formed..).zip(&kept) {
            pairs.extend(members(*old).into_iter().map(|element| (patch, element)));
        }
        pairs.sort_unstable();
        if removed.is_empty() && pairs.is_empty() {
            return None;
        }
        Some(Exchange {
            removed,
            added: part.build_patches(mesh, &pairs)?,
            ancestors: Vec::new(),
        })
    }

    /// Ties of which a node or the tetrahedron of the point has changed; of those that slide all, as the surface has other faces.
    fn exchange_ties(&self, set: usize, edit: &ModelEdit<'_>, plan: &Plan) -> Option<Exchange> {
        let elements: &dyn Any = &*self.sets[set];
        let index = self.index();
        let kept = plan.reshaped.iter().chain(&plan.renumbered);
        let kept = kept.map(|(element, _)| &self.tets[*element as usize]);
        let tets = plan.gone.iter().map(|(_, tet)| tet).chain(kept);
        let mut nodes: Vec<u32> = tets.flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let found = nodes
            .iter()
            .flat_map(|node| index.set(set).find(Key::new(&[*node])));
        let mut removed: Vec<u32> = found.collect();
        removed.sort_unstable();
        removed.dedup();
        if removed.is_empty() && elements.is::<Coupling>() {
            return None;
        }
        let before = plan.nodes_before() as u32;
        let copies = |node: u32| {
            let new = (before..).zip(&plan.supports);
            let copies = new.filter(|(_, support)| **support == [node]);
            let all = [node].into_iter().chain(copies.map(|(new, _)| new));
            all.filter_map(|node| plan.nodes.after(node)).collect()
        };
        let children = |element: u32| {
            if plan.gone.binary_search_by_key(&element, |g| g.0).is_ok() {
                let fresh = plan.fresh.iter().filter(|(_, parent)| *parent == element);
                return (fresh.map(|(child, _)| *child).collect(), true);
            }
            (plan.elements.after(element).into_iter().collect(), false)
        };
        let followed = Followed {
            mesh: edit.mesh,
            rest_positions: &self.rest_positions,
            copies: &copies,
            children: &children,
        };
        if let Some(sliding) = elements.downcast_ref::<Sliding>() {
            let (added, ancestors) = sliding.follow(&followed);
            return Some(Exchange {
                removed: (0..sliding.count() as u32).collect(),
                added: Arc::new(added),
                ancestors,
            });
        }
        let coupling = elements.downcast_ref::<Coupling>()?;
        let (added, ancestors) = coupling.follow(&removed, &followed);
        Some(Exchange {
            removed,
            added: Arc::new(added),
            ancestors,
        })
    }

    /// Takes elements out of a set and puts others in; adds the nodes of both to `touched`.
    fn exchange(
        &mut self,
        set: usize,
        exchange: &Exchange,
        plan: &Plan,
        touched: &mut Touched,
    ) -> SetChange {
        let Exchange {
            removed,
            added,
            ancestors,
        } = exchange;
        let (count, internal) = (self.sets[set].count(), self.internal[set].len());
        for &element in removed {
            let nodes = self.sets[set].nodes(element as usize).iter();
            let nodes = nodes.filter_map(|node| plan.nodes.after(*node));
            nodes.for_each(|node| touched.add(node));
        }
        let inherited = self.sets[set].inherited(&**added, ancestors);
        let mut index = self.take_index();
        let (mut placed, moves) = places(count, removed, added.count());
        index
            .set_mut(set)
            .before_splice(&*self.sets[set], removed, added.count());
        let fits = self.own_set(set).splice(removed, &**added);
        assert!(fits, "a part of a material makes sets of one kind");
        placed.extend(moves.iter().map(|[_, to]| *to));
        index.set_mut(set).after_splice(&*self.sets[set], &placed);
        self.put_index(index);
        for &element in &placed {
            let nodes = self.sets[set].nodes(element as usize).iter();
            nodes.for_each(|node| touched.add(*node));
        }
        SetChange {
            count,
            internal,
            removed: removed.clone(),
            added: added.count(),
            inherited,
            blend: self.sets[set].blend(),
            placed,
        }
    }

    /// Masses of these nodes from the volumes of their tetrahedra; what was added to their inertia is taken off.
    fn follow_masses(&mut self, nodes: &[u32], mesh: &TetMesh) {
        let mut at: Vec<u32> = Vec::new();
        for &node in nodes {
            at.clear();
            at.extend_from_slice(self.index().tets_at(node));
            at.sort_unstable();
            let mut mass = 0.0;
            for &element in &at {
                let density = self.density(mesh.regions[element as usize]).unwrap_or(0.0);
                mass += 0.25 * density * self.rest_volumes[element as usize];
            }
            self.masses[node as usize] = mass;
            self.added_inertia[node as usize] = 0.0;
            self.update_inverse_mass(node as usize);
        }
    }
}
