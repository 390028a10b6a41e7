//! The edit itself, once it is known to be possible: nodes, tetrahedra, sets, masses, parts.

use super::ModelEdit;
use super::plan::Plan;
use super::state::{ModelChange, SetChange};
use crate::elements::splice::{Key, NO_NODE, key, nodes_of, places, splice};
use crate::elements::{Coupling, Elements, Followed, patches};
use crate::material::Part;
use crate::model::TissueModel;
use microsim_mesh::{TetMesh, signed_volume};
use std::any::Any;
use std::sync::Arc;

/// What goes out of a set, and what comes in.
struct Exchange {
    /// Ascending.
    removed: Vec<u32>,
    added: Arc<dyn Elements>,
    /// For each added element the elements of the set from which it inherits.
    ancestors: Vec<Vec<u32>>,
}

impl TissueModel {
    /// Follows an edit that has been checked.
    pub(super) fn follow(&mut self, edit: &ModelEdit<'_>, plan: &Plan) -> ModelChange {
        // Ties need the rest positions before the edit.
        let first_coupling = self.made_of.len();
        let ties: Vec<Option<Exchange>> = (first_coupling..self.sets.len())
            .map(|set| self.exchange_ties(set, edit, plan))
            .collect();
        self.follow_mesh(edit, plan);

        let mut touched: Vec<u32> = Vec::new();
        let mut changes = Vec::with_capacity(self.sets.len());
        let mut ties = ties.into_iter();
        for set in 0..self.sets.len() {
            let exchange = match self.made_of.get(set).copied() {
                Some(part) if matches!(part.carried, crate::material::Carried::Patches(_)) => {
                    self.exchange_patches(set, &part, edit.mesh, plan)
                }
                Some(part) => self.exchange_around(set, &part, edit.mesh, plan),
                None => ties.next().flatten(),
            };
            let change = match exchange {
                Some(exchange) => self.exchange(set, &exchange, plan, &mut touched),
                None => SetChange::none(self.sets[set].count(), self.internal[set].len()),
            };
            changes.push(change);
        }
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
        touched.extend(plan.changed().flat_map(|e| edit.mesh.tets[e as usize]));
        let gone = plan.gone.iter().flat_map(|(_, tet)| *tet);
        touched.extend(gone.filter_map(|node| plan.nodes.after(node)));
        touched.sort_unstable();
        touched.dedup();
        self.follow_masses(&touched, edit.mesh);
        let placed: Vec<&[u32]> = changes.iter().map(|change| &change.placed[..]).collect();
        self.follow_parts(&placed);
        ModelChange {
            touched,
            new_nodes: edit.new_nodes.to_vec(),
            removed_nodes: edit.removed_nodes.to_vec(),
            moved: plan.moved.clone(),
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
        let removed = edit.removed_nodes;
        splice(&mut self.rest_positions, removed, &[]);
        splice(&mut self.masses, removed, &[]);
        splice(&mut self.added_inertia, removed, &[]);
        splice(&mut self.inverse_masses, removed, &[]);
        let new = before as u32..all as u32;
        let changed = new.chain(edit.moved.iter().copied());
        for node in changed.filter_map(|node| plan.nodes.after(node)) {
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

    /// Elements of a set that are made around keys.
    fn exchange_around(
        &self,
        set: usize,
        part: &Part,
        mesh: &TetMesh,
        plan: &Plan,
    ) -> Option<Exchange> {
        let index = self.index();
        let mut old: Vec<Key> = Vec::new();
        for (_, tet) in &plan.gone {
            part.carried.keys(tet, |key| old.push(key));
        }
        let mut new: Vec<Key> = Vec::new();
        for element in plan.changed() {
            if mesh.regions[element as usize] == part.region {
                let tet = &mesh.tets[element as usize];
                part.carried.keys(tet, |key| new.push(key));
            }
        }
        old.sort_unstable();
        old.dedup();
        new.extend(
            old.iter()
                .filter_map(|key| renamed(key, |node| plan.nodes.after(node))),
        );
        new.sort_unstable();
        new.dedup();
        let before = plan.nodes_before();
        old.extend(new.iter().filter_map(|key| {
            renamed(key, |node| {
                let node = plan.nodes.before(node);
                ((node as usize) < before).then_some(node)
            })
        }));
        old.sort_unstable();
        old.dedup();
        let found = old.iter().flat_map(|key| index.set(set).find(*key));
        let mut removed: Vec<u32> = found.collect();
        removed.sort_unstable();
        removed.dedup();
        let (mut around, mut tets) = (Vec::new(), Vec::new());
        for key in &new {
            tets.clear();
            index.tets_of(key, &self.tets, &mut tets);
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
        let wanted = nodes_of(&around[0].0);
        let mut support: Vec<u32> = Vec::new();
        for &node in wanted {
            let node = plan.nodes.before(node);
            match (node as usize).checked_sub(plan.nodes_before()) {
                None => support.push(node),
                Some(new) => support.extend_from_slice(&plan.supports[new]),
            }
        }
        support.sort_unstable();
        support.dedup();
        if support.len() == wanted.len() {
            let same: Vec<u32> = index.find(key(&support)).collect();
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

    /// Patches that were touched, formed anew among what is left of them and what is new; those that only have other numbers are made of
    /// the same elements.
    fn exchange_patches(
        &self,
        set: usize,
        part: &Part,
        mesh: &TetMesh,
        plan: &Plan,
    ) -> Option<Exchange> {
        let index = self.index();
        let found = |tets: &mut dyn Iterator<Item = [u32; 4]>| {
            let mut found: Vec<u32> = tets
                .flat_map(|tet| index.set(set).find(key(&tet)))
                .collect();
            found.sort_unstable();
            found.dedup();
            found
        };
        let dissolved = found(&mut plan.gone.iter().map(|(_, tet)| *tet));
        let before = |(_, after): &(u32, u32)| {
            mesh.tets[*after as usize].map(|node| plan.nodes.before(node))
        };
        let mut kept = found(&mut plan.reshaped.iter().map(before));
        kept.retain(|patch| dissolved.binary_search(patch).is_err());
        let members = |patch: u32| {
            let mut members: Vec<u32> = Vec::new();
            self.sets[set].keys(patch as usize, &mut |key| {
                let now = renamed(&key, |node| plan.nodes.after(node));
                if let Some(now) = now {
                    index.tets_of(&now, &self.tets, &mut members);
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
        let mut removed = dissolved;
        removed.extend(kept);
        removed.sort_unstable();
        if removed.is_empty() && pairs.is_empty() {
            return None;
        }
        Some(Exchange {
            removed,
            added: part.build_patches(mesh, &pairs)?,
            ancestors: Vec::new(),
        })
    }

    /// Ties of which a node or the tetrahedron of the point has changed.
    fn exchange_ties(&self, set: usize, edit: &ModelEdit<'_>, plan: &Plan) -> Option<Exchange> {
        let coupling = (&*self.sets[set] as &dyn Any).downcast_ref::<Coupling>()?;
        let index = self.index();
        let kept = plan.reshaped.iter().chain(&plan.renumbered);
        let kept = kept.map(|(element, _)| &self.tets[*element as usize]);
        let tets = plan.gone.iter().map(|(_, tet)| tet).chain(kept);
        let mut nodes: Vec<u32> = tets.flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let found = nodes
            .iter()
            .flat_map(|node| index.set(set).find(key(&[*node])));
        let mut removed: Vec<u32> = found.collect();
        removed.sort_unstable();
        removed.dedup();
        if removed.is_empty() {
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
            let has_moved = self.tets[element as usize]
                .iter()
                .any(|node| edit.moved.contains(node));
            (
                plan.elements.after(element).into_iter().collect(),
                has_moved,
            )
        };
        let (added, ancestors) = coupling.follow(
            &removed,
            &Followed {
                mesh: edit.mesh,
                rest_positions: &self.rest_positions,
                copies: &copies,
                children: &children,
            },
        );
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
        touched: &mut Vec<u32>,
    ) -> SetChange {
        let Exchange {
            removed,
            added,
            ancestors,
        } = exchange;
        let (count, internal) = (self.sets[set].count(), self.internal[set].len());
        for &element in removed {
            let nodes = self.sets[set].nodes(element as usize).iter();
            touched.extend(nodes.filter_map(|node| plan.nodes.after(*node)));
        }
        let inherited = self.sets[set].inherited(&**added, ancestors);
        let mut index = self.take_index();
        let (mut placed, moves) = places(count, removed, added.count());
        index
            .set_mut(set)
            .before_splice(&*self.sets[set], removed, added.count());
        self.own_set(set).splice(removed, &**added);
        placed.extend(moves.iter().map(|[_, to]| *to));
        index.set_mut(set).after_splice(&*self.sets[set], &placed);
        self.put_index(index);
        for &element in &placed {
            touched.extend_from_slice(self.sets[set].nodes(element as usize));
        }
        SetChange {
            count,
            internal,
            removed: removed.clone(),
            added: added.count(),
            inherited,
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

/// A key with other numbers of its nodes; none where one has none.
fn renamed(old: &Key, name: impl Fn(u32) -> Option<u32>) -> Option<Key> {
    let mut new = [NO_NODE; 4];
    for (new, node) in new.iter_mut().zip(nodes_of(old)) {
        *new = name(*node)?;
    }
    new.sort_unstable();
    Some(new)
}
