//! Which faces come apart where a blade has passed.

use crate::editor::Editor;
use crate::settings::Settings;
use crate::stroke::Stroke;
use crate::topology::Topology;
use std::collections::BTreeSet;

/// Elements of a flake, at most.
const FLAKE: usize = 8;

/// A face to open: element, opposite corner, and whether the element is on the negative side.
pub(crate) type FaceToOpen = (u32, usize, bool);

/// The inner faces of `elements` that the blade has passed: all nodes on the path, and the elements not on the same side. Each
/// once, with whether the element is on the negative side.
pub(crate) fn faces_to_open(
    topology: &Topology,
    stroke: &Stroke,
    elements: &BTreeSet<u32>,
) -> Vec<FaceToOpen> {
    let mut faces = Vec::new();
    for &element in elements {
        for (corner, other) in closed_faces(topology, element) {
            let face = topology.face(element, corner);
            let once = other > element || !elements.contains(&other);
            if once && face.iter().all(|node| stroke.path.contains(node)) {
                let mine = side(topology, stroke, element, corner);
                let theirs = side(topology, stroke, other, topology.back(element, other));
                if mine != theirs {
                    faces.push((element, corner, mine < theirs));
                }
            }
        }
    }
    faces
}

/// The inner faces of an element that no sheet has passed: opposite corner, and element across.
fn closed_faces(topology: &Topology, element: u32) -> impl Iterator<Item = (usize, u32)> + '_ {
    (0..4).filter_map(move |corner| {
        let other = topology.neighbour(element, corner)?;
        let is_closed = topology.marks[element as usize][corner] == 0;
        is_closed.then_some((corner, other))
    })
}

/// The side on which an element lies that has its face opposite to `corner` on the path: that of the corner; of an element with all
/// corners on the path the one to which it was given.
fn side(topology: &Topology, stroke: &Stroke, element: u32, corner: usize) -> i8 {
    let node = topology.tets[element as usize][corner];
    if stroke.path.contains(&node) {
        stroke.given.get(&element).copied().unwrap_or_default()
    } else {
        stroke.sides_of(element)[corner]
    }
}

/// Elements with all corners on the path lie in the cut itself, as flat as what was clamped leaves them. They are given to a side
/// that they have a face to, together with all such that they hang together with: so nothing comes off that the blade has not
/// cut out.
pub(crate) fn give_flat_ones(topology: &Topology, stroke: &mut Stroke, elements: &BTreeSet<u32>) {
    let is_flat = |stroke: &Stroke, element: u32| {
        let tet = &topology.tets[element as usize];
        tet.iter().all(|node| stroke.path.contains(node)) && !stroke.given.contains_key(&element)
    };
    for &start in elements {
        if !is_flat(stroke, start) {
            continue;
        }
        let mut group = vec![start];
        let mut votes = 0;
        let mut next = 0;
        while let Some(&element) = group.get(next) {
            next += 1;
            votes += stroke.sides_of(element).iter().sum::<i8>().signum() as i32;
            for (_, other) in closed_faces(topology, element) {
                if !is_flat(stroke, other) {
                    // One face weighs more than what the group itself was divided from.
                    let theirs = side(topology, stroke, other, topology.back(element, other));
                    votes += 1000 * i32::from(theirs);
                } else if !group.contains(&other) {
                    group.push(other);
                }
            }
        }
        let given = if votes < 0 { -1 } else { 1 };
        stroke.given.extend(group.into_iter().map(|e| (e, given)));
    }
}

/// Whether the blade has passed a node of its path: no element there on one side hangs together with one on the other. Of an element that it
/// has not come to, its position decides.
fn is_passed(editor: &Editor, stroke: &Stroke, node: u32) -> bool {
    let topology = &*editor.topology;
    let here = editor.place(node)[1];
    let (mut negative, mut positive) = (false, false);
    for &element in topology.elements_at(node) {
        if stroke.given.contains_key(&element) {
            continue;
        }
        let tet = &topology.tets[element as usize];
        let (mut known, mut height) = (false, 0.0);
        for (&corner, side) in tet.iter().zip(stroke.sides_of(element)) {
            if !stroke.path.contains(&corner) {
                negative |= side < 0;
                positive |= side > 0;
                known |= side != 0;
                height += (editor.place(corner)[1] - here).dot(&stroke.normal);
            }
        }
        if !known {
            negative |= height < 0.0;
            positive |= height > 0.0;
        }
    }
    !(negative && positive)
}

/// Takes those of the parted nodes at `elements` out of the edge of the cut that the blade has passed.
pub(crate) fn leave_front(editor: &mut Editor, stroke: &Stroke, elements: &BTreeSet<u32>) {
    let topology = &*editor.topology;
    let nodes = elements.iter().flat_map(|&e| topology.tets[e as usize]);
    let nodes: BTreeSet<u32> = nodes
        .filter(|node| topology.parted.contains(node))
        .collect();
    for node in nodes {
        if is_passed(editor, stroke, node) {
            editor.topology.front.remove(&node);
            editor.topology.parted.remove(&node);
        }
    }
}

/// Takes faces out of the list that would set flakes free: a few small elements on the lip of an older cut. A flake keeps the
/// largest of its faces, and with it hangs on one side; it is no bridge to another.
pub(crate) fn retain_flakes(
    editor: &Editor,
    sheet: u32,
    faces: &mut Vec<FaceToOpen>,
    settings: &Settings,
) {
    let topology = &*editor.topology;
    let mut open: BTreeSet<(u32, usize)> = BTreeSet::new();
    for &(element, corner, _) in faces.iter() {
        open.insert((element, corner));
        if let Some(other) = topology.neighbour(element, corner) {
            open.insert((other, topology.back(element, other)));
        }
    }
    let starts: Vec<u32> = open.iter().map(|&(element, _)| element).collect();
    for start in starts {
        let Some(flake) = small_part(editor, start, &open, settings) else {
            continue;
        };
        let is_old = |&element: &u32| {
            let mut triangles = topology.triangles_of(element);
            triangles.any(|t| t.sheet != 0 && t.sheet != sheet)
        };
        if !flake.iter().any(is_old) {
            continue;
        }
        let own = open.iter().filter(|(element, _)| flake.contains(element));
        let largest = own.max_by(|a, b| {
            let area = |&&(element, corner): &&(u32, usize)| editor.face_area(element, corner);
            area(a).total_cmp(&area(b))
        });
        let Some(&(element, corner)) = largest else {
            continue;
        };
        open.remove(&(element, corner));
        if let Some(other) = topology.neighbour(element, corner) {
            open.remove(&(other, topology.back(element, other)));
        }
    }
    faces.retain(|&(element, corner, _)| open.contains(&(element, corner)));
}

/// All that `start` will hang together with, if that is little.
fn small_part(
    editor: &Editor,
    start: u32,
    open: &BTreeSet<(u32, usize)>,
    settings: &Settings,
) -> Option<Vec<u32>> {
    let topology = &*editor.topology;
    let least = settings.flake_volume * topology.mean_volume;
    let mut part = vec![start];
    let mut volume = 0.0;
    let mut next = 0;
    while let Some(&element) = part.get(next) {
        next += 1;
        volume += editor.rest_volume(element);
        for (corner, other) in closed_faces(topology, element) {
            if !open.contains(&(element, corner)) && !part.contains(&other) {
                part.push(other);
            }
        }
        if volume > least || part.len() > FLAKE {
            return None;
        }
    }
    Some(part)
}
