//! Strokes of a trembling hand right through a body, and whether they separate what the blade has swept between.

use crate::hand::{Course, Hand};
use crate::regions::Regions;
use microsim_cutting::{Blade, Settings, Stroke, Topology, check};
use microsim_geometry::Aabb;
use microsim_mesh::format::{MeshFormat, read_tet_mesh};
use microsim_mesh::{Block, CellSplit, TetMesh};
use microsim_random::SplitMix64;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

type V3 = Vector3<f64>;

/// Size of all bodies \[m\].
const SIZE: [f64; 3] = [6e-3, 4e-3, 3e-3];

/// A part with less of the mean element's volume is a shard: no region is as small.
const SHARD: f64 = 0.2;

/// A region has at least so many mean elements: of the box, and in elements whose centroid lies in it. What the mesh does not resolve is none.
const REGION: f64 = 3.0;

/// What was cut and how it went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    pub strokes: usize,
    pub regions: usize,
    /// Strokes after which two regions still hang together.
    pub joined: Vec<u64>,
    /// Strokes after which a region lies in several parts, each with a mean element of it or more: tissue that no blade has passed came apart.
    pub split: Vec<u64>,
    /// Parts that hold no region.
    pub shards: usize,
    /// Of these, strokes that left one larger than a shard.
    pub crumbled: Vec<u64>,
    pub edits: usize,
    /// Faces opened as they alone held together what had been swept between.
    pub mended: usize,
    pub divided: usize,
}

fn block(random: &mut SplitMix64) -> TetMesh {
    if random.below(3) == 0 {
        let file = include_bytes!("../../../../tests/data/cuts/block-3002.msh");
        let import = read_tet_mesh(MeshFormat::Gmsh, &[file]).expect("the file of this test");
        let mut mesh = import.mesh;
        mesh.positions.iter_mut().for_each(|p| *p *= 1e-3);
        return mesh;
    }
    let cell = [0.5e-3, 1e-3][random.below(2) as usize];
    let block = Block {
        center: [0.0; 3],
        size: SIZE,
        cells: SIZE.map(|length| (length / cell).round() as usize),
        split: CellSplit::Kuhn,
    };
    let mut mesh = block.mesh().expect("a block");
    for p in &mut mesh.positions {
        *p += random.vector() * (0.1 * cell);
    }
    mesh
}

/// One stroke through a new body.
pub fn cut_body(seed: u64, course: Course, summary: &mut Summary) -> Result<(), String> {
    let mut random = SplitMix64(seed);
    let mut mesh = block(&mut random);
    let mut topology = Topology::new(&mesh);
    let (mean_edge, mean_volume) = (topology.mean_edge(), topology.mean_volume());
    let hand = Hand::random(&mut random, course);
    let mut stroke = Stroke::new();
    for tick in 0..hand.ticks() {
        let positions = mesh.positions.clone();
        let blade = Blade::Sweep {
            sweeps: &[hand.sweep(tick)],
            before: &positions,
            now: &positions,
        };
        let cut = topology.cut(&mesh, &mut stroke, &blade, &Settings::default());
        let Some(cut) = cut.map_err(|e| format!("seed {seed}: {e}"))? else {
            continue;
        };
        mesh.apply(&cut.edit)
            .map_err(|e| format!("seed {seed}: {e}"))?;
        check(&mesh, &topology).map_err(|e| format!("seed {seed} tick {tick}: {e:?}"))?;
        summary.edits += 1;
        summary.divided += cut.divided;
        summary.mended += cut.mended;
    }
    summary.strokes += 1;
    // The path strays by half an edge at most.
    let bounds = Aabb::of(&mesh.positions);
    let regions = Regions::of(&bounds, &hand, 0.5 * mean_edge, REGION * mean_volume);
    let volumes = mesh.volumes();
    let region_of = |element: usize| {
        let corners = mesh.corners(element);
        regions.at(&(corners.iter().sum::<V3>() / 4.0))
    };
    let mut resolved = vec![0.0; regions.count as usize];
    let all: Vec<Option<u32>> = (0..mesh.tets.len()).map(region_of).collect();
    for (region, volume) in all.iter().zip(&volumes) {
        if let Some(region) = region {
            resolved[*region as usize] += volume;
        }
    }
    let is_resolved = |region: &u32| resolved[*region as usize] >= REGION * mean_volume;
    summary.regions += (0..regions.count).filter(|r| is_resolved(r)).count();
    let mut holders: BTreeMap<u32, usize> = BTreeMap::new();
    for part in parts(&topology, mesh.tets.len()) {
        let mut of_region: BTreeMap<u32, f64> = BTreeMap::new();
        for &element in &part {
            if let Some(region) = all[element as usize] {
                *of_region.entry(region).or_default() += volumes[element as usize];
            }
        }
        for (region, volume) in of_region {
            if volume >= mean_volume && is_resolved(&region) {
                *holders.entry(region).or_default() += 1;
            }
        }
        let held = part.iter().filter_map(|element| all[*element as usize]);
        let held: BTreeSet<u32> = held.filter(|region| is_resolved(region)).collect();
        let volume: f64 = part.iter().map(|e| volumes[*e as usize]).sum();
        match held.len() {
            0 => {
                summary.shards += 1;
                if volume > SHARD * mean_volume {
                    summary.crumbled.push(seed);
                }
            }
            1 => {}
            _ => {
                summary.joined.push(seed);
            }
        }
    }
    if holders.values().any(|count| *count > 1) {
        summary.split.push(seed);
    }
    summary.joined.dedup();
    summary.crumbled.dedup();
    Ok(())
}

/// Elements that hang together by faces: between different ones a minimum cut of the face graph has no face.
fn parts(topology: &Topology, count: usize) -> Vec<Vec<u32>> {
    let mut parts: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    let mut seen = vec![false; count];
    for start in 0..count as u32 {
        if std::mem::replace(&mut seen[start as usize], true) {
            continue;
        }
        let mut part = vec![start];
        let mut next = 0;
        while let Some(&element) = part.get(next) {
            next += 1;
            for corner in 0..4 {
                if let Some(other) = topology.neighbour(element, corner)
                    && !std::mem::replace(&mut seen[other as usize], true)
                {
                    part.push(other);
                }
            }
        }
        parts.insert(start, part);
    }
    parts.into_values().collect()
}

/// So many strokes, each through a new body.
pub fn run(
    strokes: usize,
    seed: u64,
    course: Course,
    mut report: impl FnMut(&Summary),
) -> Result<Summary, String> {
    let mut summary = Summary::default();
    let mut bodies = SplitMix64(seed);
    while summary.strokes < strokes {
        cut_body(bodies.bits(), course, &mut summary)?;
        report(&summary);
    }
    Ok(summary)
}
