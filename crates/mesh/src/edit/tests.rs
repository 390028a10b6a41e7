use super::*;
use nalgebra::Matrix3;

/// Two elements on both sides of the face 1, 2, 3.
fn pair() -> TetMesh {
    let points = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
    ];
    let positions = points.map(Vector3::from).to_vec();
    TetMesh::new(positions, vec![[0, 1, 2, 3], [1, 2, 3, 4]], vec![7, 8])
}

/// The edge 0–1 of the first element is divided in a quarter, and node 1 doubled for its second child.
fn division() -> TopologyEdit {
    let node = |between, fraction| NewNode { between, fraction };
    TopologyEdit {
        nodes: vec![node([0, 1], 0.25), node([5, 1], 0.5)],
        elements: vec![Replacement {
            element: 0,
            children: vec![[0, 5, 2, 3], [5, 6, 2, 3]],
        }],
        ..TopologyEdit::default()
    }
}

#[test]
fn an_edit_appends_replaces_and_names_anew() {
    let mut mesh = pair();
    let edit = division();
    let applied = mesh.apply(&edit).unwrap();
    assert_eq!(mesh.tets, [[0, 5, 2, 3], [1, 2, 3, 4], [5, 6, 2, 3]]);
    assert_eq!(mesh.regions, [7, 8, 7]);
    // 0.25, then half way from there to 1.
    assert_eq!(mesh.positions[5], Vector3::new(0.25, 0.0, 0.0));
    assert_eq!(mesh.positions[6], Vector3::new(0.625, 0.0, 0.0));
    assert_eq!(mesh.node_ids, [0, 1, 2, 3, 4, 5, 6]);
    assert_eq!(mesh.element_ids, [2, 1, 3]);
    assert_eq!(mesh.generation, 1);
    assert_eq!(
        applied.replaced,
        [Replaced {
            element: 0,
            id: 0,
            corners: [0, 1, 2, 3],
            children: vec![(0, 2), (2, 3)]
        }]
    );
}

#[test]
fn children_have_the_fibres_and_the_prestretch_of_their_parent() {
    let mut mesh = pair();
    let [first, second] = [
        [Vector3::x(), Vector3::z()],
        [Vector3::y(), Vector3::zeros()],
    ];
    mesh.directions = vec![first, second];
    let [slack, tight] = [1.0, 1.5].map(Matrix3::from_diagonal_element);
    mesh.prestretches = vec![tight, slack];
    mesh.apply(&division()).unwrap();
    assert_eq!(mesh.directions, [first, second, first]);
    assert_eq!(mesh.prestretches, [tight, slack, tight]);
    let edit = TopologyEdit {
        generation: 1,
        removed: vec![1],
        ..TopologyEdit::default()
    };
    mesh.apply(&edit).unwrap();
    assert_eq!(mesh.directions, [first; 2]);
    assert_eq!(mesh.fibres(1), first);
    assert_eq!(mesh.prestretch(1), tight);
}

/// What leaves is filled from the back; ids go with it and are never given again.
#[test]
fn what_leaves_is_filled_from_the_back() {
    let mut mesh = pair();
    mesh.apply(&division()).unwrap();
    let edit = TopologyEdit {
        generation: 1,
        removed: vec![0],
        removed_nodes: vec![0],
        renumbered: vec![(0, [5, 0, 2, 3])],
        ..TopologyEdit::default()
    };
    let applied = mesh.apply(&edit).unwrap();
    assert_eq!(mesh.tets, [[5, 0, 2, 3], [1, 2, 3, 4]]);
    assert_eq!(
        (applied.removed_ids, applied.element_moves),
        (vec![2], vec![(2, 0)])
    );
    assert_eq!(applied.node_moves, [(6, 0)]);
    assert_eq!(mesh.element_ids, [3, 1]);
    assert_eq!(mesh.node_ids, [6, 1, 2, 3, 4, 5]);
    assert_eq!(mesh.positions[0].x, 0.625);
    let copy = NewNode {
        between: [1, 1],
        fraction: 0.0,
    };
    let edit = TopologyEdit {
        generation: 2,
        nodes: vec![copy],
        elements: vec![Replacement {
            element: 1,
            children: vec![[6, 2, 3, 4]],
        }],
        ..TopologyEdit::default()
    };
    mesh.apply(&edit).unwrap();
    assert_eq!((mesh.node_ids[6], mesh.element_ids[1]), (7, 4));
    assert_eq!(mesh.positions[6], mesh.positions[1]);
}

#[test]
fn an_impossible_edit_changes_nothing() {
    type Spoil = fn(&mut TopologyEdit);
    let spoils: [Spoil; 9] = [
        |e| e.generation = 1,
        |e| e.nodes[0].between[1] = 5,
        |e| e.nodes[1].fraction = f64::INFINITY,
        |e| e.elements[0].children[0][1] = 7,
        |e| e.elements[0].children[1][0] = 6,
        |e| e.elements[0].children.clear(),
        |e| e.elements.push(e.elements[0].clone()),
        |e| e.removed = vec![1, 1],
        |e| e.renumbered.push((3, [0, 1, 2, 3])),
    ];
    let mut mesh = pair();
    for (k, spoil) in spoils.iter().enumerate() {
        let mut edit = division();
        spoil(&mut edit);
        assert!(mesh.apply(&edit).is_err(), "{k}");
        assert_eq!(mesh, pair());
    }
    assert!(mesh.apply(&division()).is_ok());
}
