//! Cuts through nodes, and beside them.

use super::*;

/// A plane through a layer of nodes of a block: everything lies in it exactly, nodes, edges and faces. It goes along them, and
/// divides nothing.
#[test]
fn a_plane_through_nodes_opens_the_faces_in_it() {
    for path in 0..2 {
        let mut body = Body::new(block([4, 4, 4]));
        let elements = body.mesh.tets.len();
        let cut = if path == 0 {
            let sheet = plane(V3::zeros(), V3::z());
            body.cut(&mut Stroke::new(), &sheet).unwrap()
        } else {
            let at = |x: f64| [V3::new(x, -3.0, 0.0), V3::new(x, 3.0, 0.0)];
            let sweep = Sweep {
                before: at(-3.0),
                now: at(3.0),
            };
            body.sweep(&mut Stroke::new(), &sweep).unwrap()
        };
        let after = body.check().unwrap();
        assert_eq!(
            (after.parts, cut.divided, body.mesh.tets.len()),
            (2, 0, elements)
        );
        // 4 × 4 cells of 1; 5 × 5 nodes twice.
        assert!((cut.opened[0].area - 16.0).abs() < 1e-12);
        assert_eq!(cut.edit.nodes.len(), 25);
        assert_eq!(cut.opened[0].normal.z.abs(), 1.0);
    }
}

/// Through a node, along an edge, along a diagonal of cells, in other planes that hold nodes: valid, and in two.
#[test]
fn planes_through_single_nodes_and_edges_separate() {
    let normals = [
        V3::new(1.0, 1.0, 0.0),
        V3::new(1.0, -1.0, 0.0),
        V3::new(1.0, 1.0, 1.0),
        V3::new(1.0, 2.0, 0.0),
        V3::new(1.0, 2.0, 3.0),
        V3::new(0.1, 0.0, 1.0),
    ];
    for normal in normals {
        for shift in [0.0, 1e-17, -1e-13, 1e-9] {
            let mut body = Body::new(block([4, 4, 4]));
            let before = body.check().unwrap();
            let sheet = plane(V3::repeat(shift), normal);
            body.cut(&mut Stroke::new(), &sheet).unwrap();
            let after = body.check().unwrap();
            assert_eq!(after.parts, 2, "{normal:?}");
            assert!((after.volume / before.volume - 1.0).abs() < 1e-12);
            // The same once more: what is there is cut, no more than rounding of the first is left between.
            body.cut(&mut Stroke::new(), &sheet);
            let after = body.check().unwrap();
            assert!((after.volume / before.volume - 1.0).abs() < 1e-12);
        }
    }
}

/// The least fraction of an edge beside a layer of nodes a blade goes through these, and divides what is farther away. Back along its own cut, nearer to the nodes that it has parted than
/// to the next layer, it cuts nothing, where another stroke does.
#[test]
fn a_cut_goes_through_nodes_beside_it_and_follows_itself() {
    // A block of 2 × 2 × 2 cells of 1: edges across layers of nodes are 1 high.
    let pass = |z: f64, back: bool| {
        let at = |x: f64| [V3::new(x, -2.0, z), V3::new(x, 2.0, z)];
        let [from, to] = if back { [1.2, -1.2] } else { [-1.2, 1.2] };
        Sweep {
            before: at(from),
            now: at(to),
        }
    };
    for (z, divides) in [(0.1, false), (-0.14, false), (0.16, true), (-0.3, true)] {
        let mut body = Body::new(block([2, 2, 2]));
        let elements = body.mesh.tets.len();
        let cut = body.sweep(&mut Stroke::new(), &pass(z, false)).unwrap();
        assert_eq!(cut.divided > 0, divides, "{z}");
        assert_eq!(body.mesh.tets.len() > elements, divides, "{z}");
        assert_eq!(cut.snapped > 0, !divides, "{z}");
        assert_eq!(body.check().unwrap().parts, 2, "{z}");
        assert!((cut.opened[0].area - 4.0).abs() < 1e-12, "{z}");
    }
    for (z, own) in [(0.1, true), (0.4, true), (-0.4, true), (0.4, false)] {
        let mut body = Body::new(block([2, 2, 2]));
        let mut stroke = Stroke::new();
        body.sweep(&mut stroke, &pass(0.1, false)).unwrap();
        let before = body.mesh.clone();
        let mut other = Stroke::new();
        let stroke = if own { &mut stroke } else { &mut other };
        let cut = body.sweep(stroke, &pass(z, true));
        assert_eq!(cut.is_none(), own, "{z} {cut:?}");
        assert_eq!(body.mesh == before, own, "{z}");
        body.check().unwrap();
    }
}
