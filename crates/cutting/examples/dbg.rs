//! dbg
#[path = "../src/testing.rs"]
mod random;
use microsim_cutting::*;
use microsim_mesh::*;
use nalgebra::Vector3;
use random::Random;
type V3 = Vector3<f64>;
fn main() {
    let ways: usize = std::env::args().nth(1).unwrap().parse().unwrap();
    let planes: usize = std::env::args().nth(2).unwrap().parse().unwrap();
    for seed in 0..6 {
        let mut random = Random(seed);
        let cells = 6;
        let mut mesh = Block { center: [0.0; 3], size: [1.0; 3], cells: [cells; 3], split: CellSplit::Kuhn }.mesh().unwrap();
        for p in &mut mesh.positions {
            let inner = p.map(|x| if x.abs() > 0.499 { 0.0 } else { 1.0 });
            *p += random.vector().component_mul(&inner) * (0.15 / cells as f64);
        }
        let mut topology = Topology::new(&mesh);
        let samples: Vec<V3> = (0..200000).map(|_| random.vector() * 0.5).collect();
        let mut signs = vec![0u64; samples.len()];
        for n in 0..planes {
            let normal = random.vector().normalize();
            let center = random.vector() * 0.25;
            let along = normal.cross(&random.vector()).normalize();
            let across = normal.cross(&along);
            for (s, p) in signs.iter_mut().zip(&samples) { *s = *s << 1 | u64::from((p - center).dot(&normal) > 0.0); }
            let mut stroke = Stroke::new();
            let at = |t: f64| { let m = center + along * (4.0 * t - 2.0); [m - across * 2.0, m + across * 2.0] };
            let (mut pieces, mut snapped, mut joined, mut clamped, mut crumbs) = (0, 0, 0, 0, 0);
            for k in 0..ways {
                let positions = mesh.positions.clone();
                let [a, b] = [k as f64 / ways as f64, (k + 1) as f64 / ways as f64];
                let sweep = Sweep { before: at(a), now: at(b) };
                let blade = Blade::Sweep { sweep: &sweep, before: &positions, now: &positions };
                if let Some(cut) = topology.cut(&mesh, &mut stroke, &blade, &Settings::default()).unwrap() {
                    mesh.apply(&cut.edit).unwrap();
                    pieces += cut.pieces.len();
                    for piece in &cut.pieces { if piece.len() <= 4 {
                        println!("\nplane {n} step {k} piece {piece:?} generation {}", mesh.generation);
                        for &e in piece { println!("  {e} {:?} sides {:?} path {:?} heights {:?} neighbours {:?} surface {:?}", mesh.tets[e as usize], stroke.sides.get(&e), mesh.tets[e as usize].map(|n| u8::from(stroke.path.contains(&n))), mesh.tets[e as usize].map(|n| ((mesh.positions[n as usize] - center).dot(&normal)*6.0*1000.0).round()), [0,1,2,3].map(|k| topology.neighbour(e,k)),
                          topology.surface().iter().filter(|t| t.element == e).map(|t| (t.corner, t.sheet)).collect::<Vec<_>>()); }
                    } }
                    snapped += cut.snapped; joined += cut.joined; clamped += cut.clamped; crumbs += cut.edit.removed.len();
                }
            }
            let m = check(&mesh, &topology).unwrap();
            let mut regions = signs.clone(); regions.sort_unstable(); 
            let sizes: Vec<usize> = regions.chunk_by(|a, b| a == b).map(|c| c.len()).collect();
            print!("[{n}: parts {} of {} snapped {snapped} joined {joined} clamped {clamped} crumbs {crumbs} tets {}] ", m.parts, sizes.len(), mesh.tets.len());
            let _ = pieces;
            if n + 1 == planes {
                // volumes of the parts
                let mut seen = vec![false; mesh.tets.len()]; let mut vols = vec![];
                let v = mesh.volumes();
                for s in 0..seen.len() { if seen[s] { continue; } seen[s] = true; let mut q = vec![s]; let mut vol = 0.0; let mut c = 0; while let Some(e) = q.pop() { vol += v[e]; c += 1; for k in 0..4 { if let Some(o) = topology.neighbour(e as u32, k) { if !seen[o as usize] { seen[o as usize] = true; q.push(o as usize); } } } } vols.push((vol, c)); }
                vols.sort_by(|a, b| b.0.total_cmp(&a.0));
                println!(); 
                println!("{:?}", vols.iter().map(|(v, c)| format!("{:.5}/{c}", v)).collect::<Vec<_>>().join(" "));
                let mut s = sizes.clone(); s.sort_unstable(); s.reverse();
                println!("{:?}", s.iter().map(|n| format!("{:.5}", *n as f64 / 200000.0)).collect::<Vec<_>>().join(" "));
            }
        }
        println!();
    }
}
