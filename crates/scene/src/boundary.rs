//! The surface of a body that is cut: what edits change of it is collected, and taken over once for all edits of a tick.
//!
//! What is renewed costs what the edits touch, but for copies of lists whose order is that of elements: a surface that was kept up to
//! date is the same as one made anew, bit for bit.

use crate::scene::Body;
use microsim_cutting::{SurfaceChange, SurfaceTriangle, Topology};
use microsim_mesh::{Surface, TetMesh};
use std::collections::BTreeSet;

/// Changes of a surface that wait.
#[derive(Clone, Debug, Default)]
pub(crate) struct Waiting {
    removed: BTreeSet<SurfaceTriangle>,
    added: BTreeSet<SurfaceTriangle>,
    /// Nodes at which elements have changed.
    touched: Vec<u32>,
}

/// What became of a surface.
#[derive(Clone, Debug)]
pub(crate) struct Renewed {
    /// Where triangles stood that are gone, ascending.
    pub removed: Vec<u32>,
    /// Where new ones stand now, ascending.
    pub added: Vec<u32>,
    /// Nodes at which elements have changed, and others beyond all.
    pub touched: Vec<u32>,
}

impl Waiting {
    /// Adds those of an edit that comes after what waits.
    pub fn add(&mut self, change: &SurfaceChange, touched: &[u32]) {
        for triangle in &change.removed {
            if !self.added.remove(triangle) {
                self.removed.insert(*triangle);
            }
        }
        for triangle in &change.added {
            if !self.removed.remove(triangle) {
                self.added.insert(*triangle);
            }
        }
        self.touched.extend_from_slice(touched);
    }
}

/// What triangles of a surface stand in the order of.
fn place(triangle: &SurfaceTriangle) -> (u32, u8) {
    (triangle.element, triangle.corner)
}

/// Where a triangle stands among those of a surface, or would stand.
fn stands(triangles: &[SurfaceTriangle], triangle: &SurfaceTriangle) -> u32 {
    triangles.partition_point(|other| place(other) < place(triangle)) as u32
}

/// Takes out what stands at `removed` (ascending), and puts each of `added` before what stood at its place (not descending).
fn exchange<T: Copy>(list: &mut Vec<T>, removed: &[u32], added: &[(u32, T)]) {
    let mut all = Vec::with_capacity(list.len() + added.len());
    let mut added = added.iter().peekable();
    let mut from = 0;
    let ends = removed.iter().map(|&gone| (gone as usize, 1));
    for (end, gone) in ends.chain([(list.len(), 0)]) {
        while let Some((before, item)) = added.next_if(|(before, _)| *before as usize <= end) {
            all.extend_from_slice(&list[from..*before as usize]);
            from = *before as usize;
            all.push(*item);
        }
        all.extend_from_slice(&list[from..end]);
        from = end + gone;
    }
    *list = all;
}

/// The triangles of the surface at a node, in their order.
fn triangles_at(topology: &Topology, node: u32) -> impl Iterator<Item = SurfaceTriangle> + '_ {
    let elements = topology.elements_at(node).iter();
    let all = elements.flat_map(|&element| topology.triangles_of(element));
    all.filter(move |triangle| triangle.nodes.contains(&node))
}

/// A third of the area at rest of the triangles at a node \[m²\], summed as [`Surface::node_areas`] does.
fn node_area(topology: &Topology, mesh: &TetMesh, node: u32) -> f64 {
    let mut sum = 0.0;
    for triangle in triangles_at(topology, node) {
        let [a, b, c] = triangle.nodes.map(|node| mesh.positions[node as usize]);
        sum += ((b - a).cross(&(c - a)) / 2.0).norm() / 3.0;
    }
    sum
}

impl Body {
    /// Takes the surface from the topology, and what goes with it.
    pub(crate) fn make_surface(&mut self) {
        self.waiting = None;
        let Some(topology) = &self.topology else {
            return;
        };
        self.triangles = topology.surface();
        self.surface = Surface::new(self.triangles.iter().map(|t| t.nodes).collect());
        self.inner = self.triangles.iter().map(|t| t.sheet != 0).collect();
        self.node_areas = node_areas(&self.surface, &self.mesh);
        self.renew_parts();
    }

    /// Takes over the changes that wait; says what they were, if any do.
    pub(crate) fn renew_surface(&mut self) -> Option<Renewed> {
        let waiting = self.waiting.take()?;
        let topology = self.topology.as_ref()?;
        let sorted = |triangles: BTreeSet<SurfaceTriangle>| {
            let mut all: Vec<SurfaceTriangle> = triangles.into_iter().collect();
            all.sort_unstable_by_key(place);
            all
        };
        let (gone, new) = (sorted(waiting.removed), sorted(waiting.added));
        let removed: Vec<u32> = gone.iter().map(|t| stands(&self.triangles, t)).collect();
        let added = new.iter().map(|t| (stands(&self.triangles, t), *t));
        let added: Vec<(u32, SurfaceTriangle)> = added.collect();
        exchange(&mut self.triangles, &removed, &added);
        let nodes: Vec<_> = added.iter().map(|(at, t)| (*at, t.nodes)).collect();
        exchange(&mut self.surface.triangles, &removed, &nodes);
        let inner: Vec<_> = added.iter().map(|(at, t)| (*at, t.sheet != 0)).collect();
        exchange(&mut self.inner, &removed, &inner);

        let mut nodes: Vec<u32> = gone.iter().chain(&new).flat_map(|t| t.nodes).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let count = self.mesh.positions.len();
        self.node_areas.resize(count, 0.0);
        let (mut inside, mut outside) = (Vec::new(), Vec::new());
        for &node in &nodes {
            let exists = (node as usize) < count;
            let is_outside = exists && triangles_at(topology, node).next().is_some();
            if exists {
                self.node_areas[node as usize] = node_area(topology, &self.mesh, node);
            }
            match (self.surface.nodes.binary_search(&node), is_outside) {
                (Ok(at), false) => inside.push(at as u32),
                (Err(at), true) => outside.push((at as u32, node)),
                _ => {}
            }
        }
        exchange(&mut self.surface.nodes, &inside, &outside);
        self.renew_parts();
        let added = new.iter().map(|t| stands(&self.triangles, t));
        Some(Renewed {
            added: added.collect(),
            removed,
            touched: waiting.touched,
        })
    }

    /// The parts of the surface that have a use: ends of vessels, and where there are loads.
    fn renew_parts(&mut self) {
        if self.ends.is_empty() && !self.drive.has_loads() {
            return;
        }
        let outside = self.triangles.iter().filter(|t| t.sheet == 0);
        let outside: Vec<[u32; 3]> = outside.map(|t| t.nodes).collect();
        for (end, nodes) in self.ends.iter_mut().zip(&self.end_nodes) {
            let is_of_end = |node: &u32| nodes.binary_search(node).is_ok();
            let whole = outside.iter().filter(|t| t.iter().all(is_of_end));
            *end = whole.copied().collect();
        }
        self.drive.renew_loads(&self.mesh, &outside);
    }
}

/// Area at rest of the surface at each node \[m²\]; 0 inside.
pub(crate) fn node_areas(surface: &Surface, mesh: &TetMesh) -> Vec<f64> {
    let mut all = vec![0.0; mesh.positions.len()];
    let areas = surface.node_areas(&mesh.positions);
    for (&node, area) in surface.nodes.iter().zip(areas) {
        all[node as usize] = area;
    }
    all
}
