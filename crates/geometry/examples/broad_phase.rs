//! Which broad phase where: CPU time of one step (new positions in, pairs of overlapping boxes out) for comparing every box with
//! every other, for [`SpatialHash`] and for [`Bvh`]; with `--features parry` also for the tree of the library parry. All must find
//! the same pairs.
//!
//! 1. The dissertation's pair of tubes, nodes against tetrahedra, while one passes through the other (its section 4.3).
//! 2. Two waving sheets of 1,000 to 100,000 triangles that lie on one another, triangles against triangles.
//! 3. One such sheet against the eight capsules of two tools.
//! 4. A sheet whose triangles differ in size by a factor of 50, against itself.
//! 5. A sheet of 10,000 triangles that is rolled up, its layers 1 mm apart, against itself; the trees that are refitted were built when
//!    it was flat.
//!
//! `cargo run --release -p microsim-geometry [--features parry] --example broad_phase`

use microsim_geometry::{Aabb, BroadPhase, Bvh, Capsule, SpatialHash, point_in_tetrahedron};
use nalgebra::Vector3;
use rustix::time::{ClockId, clock_gettime};
use std::f64::consts::PI;

type Point = Vector3<f64>;

/// Finds the pairs `[tetrahedron, node]` for the nodes of one tube and those of the other.
type Finder<'a> = dyn FnMut(&[Point], &[Point], &mut Vec<[u32; 2]>) + 'a;

fn main() {
    println!("CPU time of a step in microseconds; the fastest of several.");
    tubes();
    for triangles in [1_000, 3_000, 10_000, 30_000, 100_000] {
        let cells = (triangles as f64 / 2.0).sqrt().round() as usize;
        let (below, above) = (Sheet::new(cells, 1.0), Sheet::new(cells, 1.0));
        let margin = 0.1 * below.mean_edge;
        let lower = below.boxes(0.0, margin);
        let upper = above.boxes(0.5 * below.mean_edge, margin);
        let name = format!("two sheets of {} triangles", below.triangles.len());
        compare(
            &name,
            below.mean_edge,
            &lower,
            &lower,
            &upper,
            lower.len() <= 30_000,
        );
        let tools = tools(cells as f64 * 1e-3);
        let name = format!("a sheet of {} triangles, two tools", below.triangles.len());
        compare(&name, below.mean_edge, &lower, &lower, &tools, true);
    }
    let uneven = Sheet::new(70, 50.0);
    let boxes = uneven.boxes(0.0, 0.1 * uneven.mean_edge);
    let name = format!("uneven sheet of {} triangles with itself", boxes.len());
    compare(&name, uneven.mean_edge, &boxes, &boxes, &boxes, true);
    let mut sheet = Sheet::new(71, 1.0);
    let margin = 0.1 * sheet.mean_edge;
    let flat = sheet.boxes(0.0, margin);
    sheet.roll();
    let rolled = sheet.boxes(0.0, margin);
    let name = format!("rolled sheet of {} triangles with itself", rolled.len());
    compare(&name, sheet.mean_edge, &flat, &rolled, &rolled, true);
}

/// Times all broad phases on the same work and prints a row for each. Trees that are refitted were built around `before`.
fn compare(
    name: &str,
    mean_edge: f64,
    before: &[Aabb],
    boxes: &[Aabb],
    queries: &[Aabb],
    brute: bool,
) {
    let mut expected = Vec::new();
    let mut hash = SpatialHash::new();
    hash.rebuild(mean_edge, boxes);
    hash.pairs(queries, &mut expected);
    println!("\n{name}: {} pairs", expected.len());
    println!("  {:<34}{:>12}{:>12}{:>12}", "", "build", "query", "both");
    if brute {
        let mut pairs = Vec::new();
        let query = fastest(|| {
            pairs.clear();
            for (i, query) in queries.iter().enumerate() {
                for (j, bounds) in boxes.iter().enumerate() {
                    if query.overlaps(bounds) {
                        pairs.push([i as u32, j as u32]);
                    }
                }
            }
        });
        assert_eq!(pairs, expected);
        row("every box with every other", 0.0, query);
    }
    for factor in [0.5, 1.0, 2.0, 4.0] {
        let name = format!("hash, cell {factor} mean edges");
        let mut hash = SpatialHash::new();
        let build = |set: &mut SpatialHash| set.rebuild(factor * mean_edge, boxes);
        time(&name, &mut hash, build, queries, &expected);
    }
    let mut bvh = Bvh::new();
    time(
        "bvh, rebuilt",
        &mut bvh,
        |set| set.rebuild(boxes),
        queries,
        &expected,
    );
    bvh.rebuild(before);
    time(
        "bvh, refitted",
        &mut bvh,
        |set| set.refit(boxes),
        queries,
        &expected,
    );
    #[cfg(feature = "parry")]
    parry::compare(before, boxes, queries, &expected);
}

fn time<T: BroadPhase>(
    name: &str,
    set: &mut T,
    mut build: impl FnMut(&mut T),
    queries: &[Aabb],
    expected: &[[u32; 2]],
) {
    let mut pairs = Vec::new();
    let built = fastest(|| build(set));
    let query = fastest(|| set.pairs(queries, &mut pairs));
    assert_eq!(pairs, expected, "{name}");
    row(name, built, query);
}

fn row(name: &str, build: f64, query: f64) {
    println!(
        "  {name:<34}{build:>12.1}{query:>12.1}{:>12.1}",
        build + query
    );
}

/// CPU time of this thread \[µs\].
fn now() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e6 + time.tv_nsec as f64 * 1e-3
}

/// The fastest of at least three runs and 100 ms \[µs\].
fn fastest(mut work: impl FnMut()) -> f64 {
    let start = now();
    let (mut best, mut runs) = (f64::INFINITY, 0);
    while runs < 3 || now() - start < 1e5 {
        let before = now();
        work();
        best = best.min(now() - before);
        runs += 1;
    }
    best
}

/// Nodes and tetrahedra of the dissertation's tube: 9 cells around, 13 along, 1 through the wall, six tetrahedra each.
fn tube() -> (Vec<Point>, Vec<[usize; 4]>) {
    const AROUND: usize = 9;
    let node = |[a, l, r]: [usize; 3]| (l * AROUND + a % AROUND) * 2 + r;
    let mut nodes = Vec::new();
    for l in 0..=13 {
        for a in 0..AROUND {
            for radius in [8e-3, 10e-3] {
                let angle = 2.0 * PI * a as f64 / AROUND as f64;
                let (y, z) = (radius * libm::cos(angle), radius * libm::sin(angle));
                nodes.push(Point::new(60e-3 * l as f64 / 13.0, y, z));
            }
        }
    }
    let mut tetrahedra = Vec::new();
    for cell in 0..AROUND * 13 {
        for order in [
            [0, 1, 2],
            [0, 2, 1],
            [1, 0, 2],
            [1, 2, 0],
            [2, 0, 1],
            [2, 1, 0],
        ] {
            let mut corner = [cell % AROUND, cell / AROUND, 0];
            let mut tetrahedron = [node(corner); 4];
            for (step, axis) in order.into_iter().enumerate() {
                corner[axis] += 1;
                tetrahedron[step + 1] = node(corner);
            }
            let [a, b, c, d] = tetrahedron.map(|k| nodes[k]);
            if (b - a).dot(&(c - a).cross(&(d - a))) < 0.0 {
                tetrahedron.swap(2, 3);
            }
            tetrahedra.push(tetrahedron);
        }
    }
    (nodes, tetrahedra)
}

/// All nodes of each tube against all tetrahedra of the other, from apart to half through.
fn tubes() {
    let (first, tetrahedra) = tube();
    let edges = tetrahedra
        .iter()
        .flat_map(|t| (0..4).flat_map(move |i| (0..i).map(move |j| [t[i], t[j]])));
    let lengths: Vec<f64> = edges.map(|[i, j]| (first[i] - first[j]).norm()).collect();
    let mean_edge = lengths.iter().sum::<f64>() / lengths.len() as f64;
    for overlap in [-2e-3, 5e-3, 30e-3] {
        // Turned by 10 degrees about the axis, 3 mm aside.
        let (sine, cosine) = (libm::sin(PI / 18.0), libm::cos(PI / 18.0));
        let second: Vec<Point> = first
            .iter()
            .map(|p| {
                let (y, z) = (cosine * p.y - sine * p.z, sine * p.y + cosine * p.z);
                Point::new(p.x + 60e-3 - overlap, y + 3e-3, z)
            })
            .collect();
        let tests = 2 * first.len() * tetrahedra.len();
        assert_eq!(tests, 353_808);
        let corners = |nodes: &[Point], t: &[usize; 4]| t.map(|k| nodes[k]);
        let boxes = |nodes: &[Point]| -> Vec<Aabb> {
            tetrahedra
                .iter()
                .map(|t| Aabb::of(&corners(nodes, t)))
                .collect()
        };
        let points = |nodes: &[Point]| nodes.iter().map(|p| Aabb::of([p])).collect::<Vec<_>>();
        let sides = [(&first, &second), (&second, &first)];

        let mut inside = 0;
        let all = fastest(|| {
            inside = 0;
            for (nodes, other) in sides {
                for t in &tetrahedra {
                    let corners = corners(other, t);
                    inside += nodes
                        .iter()
                        .filter(|p| point_in_tetrahedron(p, &corners).is_some())
                        .count();
                }
            }
        });
        println!(
            "\ntubes overlapping by {} mm: {inside} of {tests} tests inside",
            overlap * 1e3
        );
        println!("  {:<34}{all:>12.1}", "every test");
        let mut hash = SpatialHash::new();
        let mut bvh = Bvh::new();
        let mut pairs = Vec::new();
        let mut step = |name: &str, find: &mut Finder<'_>| {
            let mut found = 0;
            let mut candidates = 0;
            let time = fastest(|| {
                (found, candidates) = (0, 0);
                for (nodes, other) in sides {
                    find(nodes, other, &mut pairs);
                    candidates += pairs.len();
                    for &[t, p] in &pairs {
                        let corners = corners(other, &tetrahedra[t as usize]);
                        found += usize::from(
                            point_in_tetrahedron(&nodes[p as usize], &corners).is_some(),
                        );
                    }
                }
            });
            assert_eq!(found, inside, "{name}");
            println!("  {name:<34}{time:>12.1}  {candidates} candidates");
        };
        for factor in [0.5, 1.0, 2.0] {
            step(
                &format!("hash of nodes, cell {factor} mean edges"),
                &mut |nodes, other, pairs| {
                    hash.rebuild(factor * mean_edge, &points(nodes));
                    hash.pairs(&boxes(other), pairs);
                },
            );
        }
        step("bvh of nodes, rebuilt", &mut |nodes, other, pairs| {
            bvh.rebuild(&points(nodes));
            bvh.pairs(&boxes(other), pairs);
        });
        // Each side's tree is updated from step to step.
        let mut trees = [Bvh::new(), Bvh::new()];
        let mut side = 0;
        step("bvh of nodes, refitted", &mut |nodes, other, pairs| {
            trees[side].refit(&points(nodes));
            trees[side].pairs(&boxes(other), pairs);
            side = 1 - side;
        });
        #[cfg(feature = "parry")]
        {
            step(
                "parry's bvh of nodes, rebuilt",
                &mut |nodes, other, pairs| {
                    parry::Tree::new(&points(nodes)).pairs(&boxes(other), pairs);
                },
            );
            let mut trees = [&first, &second].map(|nodes| parry::Tree::new(&points(nodes)));
            let mut side = 0;
            step(
                "parry's bvh of nodes, refitted",
                &mut |nodes, other, pairs| {
                    trees[side].refit(&points(nodes));
                    trees[side].pairs(&boxes(other), pairs);
                    side = 1 - side;
                },
            );
        }
    }
}

/// A waving sheet of `cells` × `cells` squares of two triangles.
struct Sheet {
    nodes: Vec<Point>,
    triangles: Vec<[usize; 3]>,
    mean_edge: f64,
}

impl Sheet {
    /// Squares of 1 mm; with `ratio` above 1 they grow along x until the last is that many times as long as the first.
    fn new(cells: usize, ratio: f64) -> Self {
        let growth = libm::pow(ratio, 1.0 / (cells as f64 - 1.0));
        let mut along = vec![0.0];
        let mut length = 1e-3;
        for i in 0..cells {
            along.push(along[i] + length);
            length *= growth;
        }
        let mut nodes = Vec::new();
        for &x in &along {
            for j in 0..=cells {
                let y = j as f64 * 1e-3;
                nodes.push(Point::new(
                    x,
                    y,
                    2e-3 * libm::sin(300.0 * x) * libm::cos(200.0 * y),
                ));
            }
        }
        let mut triangles = Vec::new();
        for i in 0..cells {
            for j in 0..cells {
                let node = |i: usize, j: usize| i * (cells + 1) + j;
                triangles.push([node(i, j), node(i + 1, j), node(i + 1, j + 1)]);
                triangles.push([node(i, j), node(i + 1, j + 1), node(i, j + 1)]);
            }
        }
        let edges = triangles
            .iter()
            .flat_map(|t| (0..3).map(|k| (nodes[t[k]] - nodes[t[(k + 1) % 3]]).norm()));
        let mean_edge = edges.sum::<f64>() / (3 * triangles.len()) as f64;
        Self {
            nodes,
            triangles,
            mean_edge,
        }
    }

    /// Rolls the sheet up about the y axis: a spiral whose layers are 1 mm apart, with 1 mm within.
    fn roll(&mut self) {
        for p in &mut self.nodes {
            // Length of the spiral r = r0 + c·angle: r0·angle + c·angle²/2.
            let (inner, per_radian) = (1e-3, 1e-3 / (2.0 * PI));
            let angle = ((inner * inner + 2.0 * per_radian * p.x).sqrt() - inner) / per_radian;
            let radius = inner + per_radian * angle + 0.1 * p.z;
            (p.x, p.z) = (radius * libm::cos(angle), radius * libm::sin(angle));
        }
    }

    /// The boxes of its triangles at a height, grown by `margin`.
    fn boxes(&self, height: f64, margin: f64) -> Vec<Aabb> {
        let up = Point::new(0.0, 0.0, height);
        let bounds = |t: &[usize; 3]| Aabb::of(&t.map(|k| self.nodes[k] + up)).inflated(margin);
        self.triangles.iter().map(bounds).collect()
    }
}

/// Boxes of eight capsules of 10 mm that stand obliquely on the middle of a sheet of that size, over a step of 0.5 mm.
fn tools(size: f64) -> Vec<Aabb> {
    (0..8)
        .map(|k| {
            let tip = Point::new(0.4 * size + 1e-3 * f64::from(k), 0.5 * size, 1e-3);
            let at = |shift: f64| Capsule {
                a: tip + Point::new(0.0, 0.0, -shift),
                b: tip + Point::new(5e-3, 2e-3, 8.4e-3 - shift),
                radius: 0.2e-3,
            };
            at(0.0).swept_bounds(&at(0.5e-3))
        })
        .collect()
}

/// The tree of the library parry, behind the same interface.
#[cfg(feature = "parry")]
mod parry {
    use super::{fastest, row, time};
    use microsim_geometry::{Aabb, BroadPhase};
    use parry3d_f64::bounding_volume::Aabb as Bounds;
    use parry3d_f64::math::Vector;
    use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};

    pub struct Tree {
        bvh: Bvh,
        workspace: BvhWorkspace,
        boxes: Vec<Aabb>,
    }

    fn bounds(bounds: &Aabb) -> Bounds {
        let vector = |p: &nalgebra::Vector3<f64>| Vector::new(p.x, p.y, p.z);
        Bounds::new(vector(&bounds.min), vector(&bounds.max))
    }

    impl Tree {
        pub fn new(boxes: &[Aabb]) -> Self {
            let leaves: Vec<Bounds> = boxes.iter().map(bounds).collect();
            Self {
                bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &leaves),
                workspace: BvhWorkspace::default(),
                boxes: boxes.to_vec(),
            }
        }

        pub fn refit(&mut self, boxes: &[Aabb]) {
            for (index, aabb) in boxes.iter().enumerate() {
                self.bvh
                    .insert_or_update_partially(bounds(aabb), index as u32, 0.0);
            }
            self.bvh.refit(&mut self.workspace);
            self.boxes.copy_from_slice(boxes);
        }
    }

    impl BroadPhase for Tree {
        fn len(&self) -> usize {
            self.boxes.len()
        }

        fn bounds(&self, index: u32) -> &Aabb {
            &self.boxes[index as usize]
        }

        fn visit(&self, query: &Aabb, found: impl FnMut(u32)) {
            self.bvh.intersect_aabb(&bounds(query)).for_each(found);
        }
    }

    pub fn compare(before: &[Aabb], boxes: &[Aabb], queries: &[Aabb], expected: &[[u32; 2]]) {
        let mut pairs = Vec::new();
        let mut tree = Tree::new(boxes);
        let built = fastest(|| tree = Tree::new(boxes));
        let query = fastest(|| tree.pairs(queries, &mut pairs));
        assert_eq!(pairs, expected);
        row("parry's bvh, rebuilt", built, query);
        tree = Tree::new(before);
        time(
            "parry's bvh, refitted",
            &mut tree,
            |tree| tree.refit(boxes),
            queries,
            expected,
        );
    }
}
