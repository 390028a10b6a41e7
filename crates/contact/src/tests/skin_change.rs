use super::*;
use crate::SkinChange;
use microsim_cutting::{Blade, Settings, Sheet, Stroke, SurfaceTriangle, Topology};
use microsim_mesh::Surface;

fn surface(triangles: &[SurfaceTriangle]) -> Surface {
    Surface::new(triangles.iter().map(|t| t.nodes).collect())
}

/// Where those of `one` stand that are not in `other`.
fn beyond(one: &[SurfaceTriangle], other: &[SurfaceTriangle]) -> Vec<u32> {
    let places = 0..one.len() as u32;
    places
        .filter(|&place| !other.contains(&one[place as usize]))
        .collect()
}

/// Blocks that are cut by planes and patches again and again, crumbs and pieces that come off among them: a skin that follows is, list by
/// list, the one that is made anew.
#[test]
fn a_skin_that_follows_cuts_is_the_one_made_anew() {
    let mut random = SplitMix64(11);
    let (mut cuts, mut removed_nodes) = (0, 0);
    for run in 0..12 {
        let mut mesh = block([0.0; 3], [4, 3, 3]);
        for p in &mut mesh.positions {
            *p += random.vector() * 0.12;
        }
        let mut topology = Topology::new(&mesh);
        let mut triangles = topology.surface();
        let inside = run % 2 == 0;
        let mut offset = 0;
        let made = |mesh: &TetMesh, triangles: &[SurfaceTriangle], offset| {
            Skin::of_surface(mesh, &surface(triangles), 1.0, offset, inside)
        };
        let mut skin = made(&mesh, &triangles, offset);
        for _ in 0..20 {
            let (center, half) = (random.vector() * 1.5, [0.7, 10.0][random.below(2) as usize]);
            let [along, across] = [random.vector(), random.vector()].map(|v| v.normalize() * half);
            let corner = |s: f64, t: f64| center + along * s + across * t;
            let sheet = Sheet::quad(
                [corner(-1.0, -1.0), corner(1.0, -1.0)],
                [corner(-1.0, 1.0), corner(1.0, 1.0)],
            );
            let positions = mesh.positions.clone();
            let blade = Blade::Sheet {
                sheet: &sheet,
                positions: &positions,
            };
            // What comes off with less than half of an element's volume is taken away: then nodes and elements leave.
            let settings = Settings {
                crumb_volume: 0.5,
                ..Settings::default()
            };
            let made_cut = topology
                .cut(&mesh, &mut Stroke::new(), &blade, &settings)
                .unwrap();
            let Some(cut) = made_cut else {
                continue;
            };
            let before = mesh.tets.clone();
            mesh.apply(&cut.edit).unwrap();
            let now = topology.surface();
            let changed = |e: &usize| before.get(*e) != mesh.tets.get(*e);
            let changed = (0..before.len().max(mesh.tets.len())).filter(changed);
            let corners = changed.flat_map(|e| [before.get(e), mesh.tets.get(e)]);
            let touched: Vec<u32> = corners.flatten().flatten().copied().collect();
            offset = [offset, 7][random.below(2) as usize];
            skin.follow(&SkinChange {
                mesh: &mesh,
                surface: &surface(&now),
                offset,
                removed: &beyond(&triangles, &now),
                added: &beyond(&now, &triangles),
                touched: &touched,
                elements_at: &|node| topology.elements_at(node),
            });
            assert!(skin == made(&mesh, &now, offset), "run {run}, cut {cuts}");
            triangles = now;
            cuts += 1;
            removed_nodes += cut.edit.removed_nodes.len();
        }
    }
    assert!(cuts > 100 && removed_nodes > 20, "{cuts}, {removed_nodes}");
}
