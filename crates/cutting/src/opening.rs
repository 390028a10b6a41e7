//! Which faces come apart where a blade has passed.

use crate::editor::Editor;
use crate::settings::Settings;
use crate::stroke::Stroke;
use crate::topology::{NONE, Topology};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// Elements of a flake, at most.
const FLAKE: usize = 128;

/// A face to open: element, opposite corner, and whether the element is on the negative side.
pub(crate) type FaceToOpen = (u32, usize, bool);

/// The inner faces of `elements` that the blade has passed: all nodes on the path, and the elements on different sides. Each
/// once, with whether the element is on the negative side.
pub(crate) fn faces_to_open(
    editor: &Editor,
    stroke: &Stroke,
    elements: &BTreeSet<u32>,
) -> Vec<FaceToOpen> {
    let topology = &*editor.topology;
    let given = give_flat_ones(editor, stroke, elements);
    let elements: BTreeSet<u32> = elements.iter().chain(given.keys()).copied().collect();
    let mut faces = Vec::new();
    for &element in &elements {
        for (corner, other) in closed_faces(topology, element) {
            let face = topology.face(element, corner);
            let once = other > element || !elements.contains(&other);
            if once && face.iter().all(|node| stroke.is_on_path(*node)) {
                let pair = [(element, corner), (other, topology.back(element, other))];
                let given = pair.map(|(element, _)| given.get(&element).copied());
                let [mine, theirs] = [0, 1].map(|k| {
                    let (element, corner) = pair[k];
                    let node = topology.tets[element as usize][corner];
                    given[k].unwrap_or_else(|| stroke.side(node))
                });
                // What lies beyond a face on the path and is not known lies on the other side.
                if mine != theirs {
                    faces.push((element, corner, mine < theirs));
                }
            }
        }
    }
    faces
}

/// The inner faces at which elements that the blade has left are cut in part: between corners on different sides, with some nodes on the path.
pub(crate) fn cracks(
    editor: &Editor,
    stroke: &Stroke,
    elements: &BTreeSet<u32>,
) -> Vec<FaceToOpen> {
    let topology = &*editor.topology;
    let mut faces = Vec::new();
    for &element in elements {
        for (corner, other) in closed_faces(topology, element) {
            let once = other > element || !elements.contains(&other);
            let face = topology.face(element, corner);
            let on_path = face.iter().filter(|node| stroke.is_on_path(**node)).count();
            if !once || on_path % 3 == 0 || topology.is_waiting(stroke, [element, other]) {
                continue;
            }
            let far = topology.tets[other as usize][topology.back(element, other)];
            let mine = stroke.side(topology.tets[element as usize][corner]);
            if mine * stroke.side(far) == -1 {
                faces.push((element, corner, mine < 0));
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

/// The side of `node` by its position, as seen from a face on the path.
fn estimated_side(editor: &Editor, stroke: &Stroke, face: &[u32; 3], node: u32) -> i8 {
    let centroid: Vector3<f64> = face
        .iter()
        .map(|&n| editor.place(n)[1])
        .sum::<Vector3<f64>>()
        / 3.0;
    let height = (editor.place(node)[1] - centroid).dot(&stroke.across);
    if height < 0.0 { -1 } else { 1 }
}

/// Elements with all corners on the path lie in the cut itself, as flat as what strays leaves them. All such that hang together are given to the
/// side at which the larger area of them hangs: so nothing comes off that the blade has not cut out. 1, −1, or 0 where no side is known.
fn give_flat_ones(editor: &Editor, stroke: &Stroke, elements: &BTreeSet<u32>) -> BTreeMap<u32, i8> {
    let topology = &*editor.topology;
    let is_flat = |element: u32| is_flat(topology, stroke, element);
    let mut given: BTreeMap<u32, i8> = BTreeMap::new();
    for &start in elements {
        if given.contains_key(&start) || !is_flat(start) {
            continue;
        }
        let mut group = vec![start];
        // Of faces to known sides, and to others.
        let (mut area, mut estimated) = (0.0, 0.0);
        let mut next = 0;
        while let Some(&element) = group.get(next) {
            next += 1;
            for (corner, other) in closed_faces(topology, element) {
                if !is_flat(other) {
                    let far = topology.tets[other as usize][topology.back(element, other)];
                    let face = topology.face(element, corner);
                    let of_face = editor.face_area(element, corner);
                    area += f64::from(stroke.side(far)) * of_face;
                    estimated += f64::from(estimated_side(editor, stroke, &face, far)) * of_face;
                } else if !group.contains(&other) {
                    group.push(other);
                }
            }
        }
        let area = if area == 0.0 { estimated } else { area };
        let side = if area < 0.0 { -1 } else { 1 };
        given.extend(group.into_iter().map(|element| (element, side)));
    }
    given
}

/// Whether the blade has passed a node of its path: no element there on one side hangs together with one on the other. Of an element that it
/// has not come to, its position decides.
fn is_passed(editor: &Editor, stroke: &Stroke, node: u32) -> bool {
    let topology = &*editor.topology;
    let here = editor.place(node)[1];
    let (mut negative, mut positive) = (false, false);
    for &element in topology.elements_at(node) {
        let (mut known, mut height) = (false, 0.0);
        for &corner in &topology.tets[element as usize] {
            if !stroke.is_on_path(corner) {
                let side = stroke.side(corner);
                negative |= side < 0;
                positive |= side > 0;
                known |= side != 0;
                height += (editor.place(corner)[1] - here).dot(&stroke.across);
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

/// Takes faces out of the list that would set flakes free: a few small elements on the lip of an older cut, or elements that lie in the cut itself. A
/// flake keeps the largest of its faces, and with it hangs on one side; it is no bridge to another.
pub(crate) fn retain_flakes(
    editor: &Editor,
    stroke: &Stroke,
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
    // Elements of parts that are no flakes, as long as no more hangs together than was found.
    let mut whole: BTreeSet<u32> = BTreeSet::new();
    for start in starts {
        let is_old = |&element: &u32| {
            let mut triangles = topology.triangles_of(element);
            triangles.any(|t| t.sheet != 0 && t.sheet != stroke.sheet)
        };
        let on_lip = || {
            let part = small_part(editor, start, &open, &mut whole, settings)?;
            if !part.iter().any(is_old) {
                whole.extend(part);
                return None;
            }
            Some(part)
        };
        let Some(flake) = flat_part(topology, stroke, start, &open).or_else(on_lip) else {
            continue;
        };
        let own = open.iter().filter(|(element, _)| flake.contains(element));
        let largest = own.max_by(|a, b| {
            let area = |&&(element, corner): &&(u32, usize)| editor.face_area(element, corner);
            area(a).total_cmp(&area(b))
        });
        let Some(&(element, corner)) = largest else {
            continue;
        };
        whole.clear();
        open.remove(&(element, corner));
        if let Some(other) = topology.neighbour(element, corner) {
            open.remove(&(other, topology.back(element, other)));
        }
    }
    faces.retain(|&(element, corner, _)| open.contains(&(element, corner)));
}

/// All that `start` will hang together with, if all of it lies in the cut.
fn flat_part(
    topology: &Topology,
    stroke: &Stroke,
    start: u32,
    open: &BTreeSet<(u32, usize)>,
) -> Option<Vec<u32>> {
    let mut part = vec![start];
    let mut next = 0;
    while let Some(&element) = part.get(next) {
        next += 1;
        if !is_flat(topology, stroke, element) {
            return None;
        }
        for (corner, other) in closed_faces(topology, element) {
            if !open.contains(&(element, corner)) && !part.contains(&other) {
                part.push(other);
            }
        }
    }
    Some(part)
}

/// Whether all corners of an element are on the path.
fn is_flat(topology: &Topology, stroke: &Stroke, element: u32) -> bool {
    let tet = &topology.tets[element as usize];
    tet.iter().all(|node| stroke.is_on_path(*node))
}

/// All that `start` will hang together with, if that is little or thin; else what of it was looked at joins what is `whole`.
fn small_part(
    editor: &Editor,
    start: u32,
    open: &BTreeSet<(u32, usize)>,
    whole: &mut BTreeSet<u32>,
    settings: &Settings,
) -> Option<Vec<u32>> {
    let topology = &*editor.topology;
    let mut part = vec![start];
    let (mut volume, mut area) = (0.0, 0.0);
    let mut next = 0;
    while let Some(&element) = part.get(next) {
        next += 1;
        if whole.contains(&element) || part.len() > FLAKE {
            whole.extend(part);
            return None;
        }
        volume += editor.rest_volume(element);
        let is_inside = |corner: usize, other: u32| {
            let is_closed = topology.marks[element as usize][corner] == 0;
            is_closed && !open.contains(&(element, corner)) && other != NONE
        };
        for (corner, other) in topology.neighbours[element as usize]
            .into_iter()
            .enumerate()
        {
            if !is_inside(corner, other) {
                area += editor.face_area(element, corner);
            } else if !part.contains(&other) {
                part.push(other);
            }
        }
    }
    let thickness = 2.0 * volume / area;
    let is_flake = volume <= settings.flake_volume * topology.mean_volume
        || thickness <= settings.flake_thickness * topology.mean_edge;
    if !is_flake {
        whole.extend(part);
        return None;
    }
    Some(part)
}
