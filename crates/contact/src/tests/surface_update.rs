use super::*;
use crate::SurfaceUpdate;
use microsim_cutting::{Blade, Settings, Sheet, Stroke, SurfaceTriangle, Topology};
use microsim_mesh::Surface;

fn mesh_surface(triangles: &[SurfaceTriangle]) -> Surface {
    Surface::new(triangles.iter().map(|t| t.nodes).collect())
}

/// Indices of those of `one` that are not in `other`.
fn beyond(one: &[SurfaceTriangle], other: &[SurfaceTriangle]) -> Vec<u32> {
    let places = 0..one.len() as u32;
    places
        .filter(|&place| !other.contains(&one[place as usize]))
        .collect()
}

/// Blocks that are cut by planes and patches again and again, crumbs and pieces that come off among them: an updated surface is, list by
/// list, the rebuilt one.
#[test]
fn a_surface_updated_after_cuts_is_the_rebuilt_one() {
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
            ContactSurface::of_surface(mesh, &mesh_surface(triangles), 1.0, offset, inside)
        };
        let mut surface = made(&mesh, &triangles, offset);
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
            surface.update_after_edit(&SurfaceUpdate {
                mesh: &mesh,
                surface: &mesh_surface(&now),
                offset,
                removed: &beyond(&triangles, &now),
                added: &beyond(&now, &triangles),
                touched: &touched,
                elements_at: &|node| topology.elements_at(node),
            });
            assert!(
                surface == made(&mesh, &now, offset),
                "run {run}, cut {cuts}"
            );
            triangles = now;
            cuts += 1;
            removed_nodes += cut.edit.removed_nodes.len();
        }
    }
    assert!(cuts > 100 && removed_nodes > 20, "{cuts}, {removed_nodes}");
}
