//! Four elements at once are what each is alone.

use super::*;
use crate::law::{Lame, LawName, MaterialLaw, with_law};
use crate::testing::{fibres, numbers, soft_block};

const LAME: Lame = Lame {
    mu: 4e3,
    lambda: 3e4,
};

/// Positions of a strained block, and its elements; their number, 48 less 5, is no multiple of four.
fn strained() -> (Tetrahedra, Vec<Vector3<f64>>) {
    let mut mesh = soft_block([2, 2, 2]);
    fibres(&mut mesh);
    let elements: Vec<u32> = (0..mesh.tets.len() as u32 - 5).collect();
    let mut next = numbers();
    let moved = mesh.positions.iter();
    let size = mesh.mean_edge_length();
    let positions = moved.map(|x| x * 1.1 + Vector3::from_fn(|_, _| next()) * (0.15 * size));
    (Tetrahedra::new(&mesh, &elements), positions.collect())
}

fn check<L: Law>(tetrahedra: &Tetrahedra, positions: &[Vector3<f64>]) {
    let constants = L::constants(&LAME, &L::Parameters::default());
    let forces = |ranges: &[Range<usize>]| {
        let mut values = vec![Vector3::zeros(); positions.len()];
        let mut window = NodeWindow {
            first: 0,
            values: &mut values,
        };
        for range in ranges {
            tetrahedra.add_elastic_forces::<L>(range.clone(), positions, &constants, &mut window);
        }
        values
    };
    let count = tetrahedra.count();
    let all = forces(std::slice::from_ref(&(0..count)));
    // To the bit: parts of a body begin anywhere.
    assert_eq!(
        all,
        forces(&[0..3, 3..3, 3..18, 18..count]),
        "{:?}",
        L::NAME
    );

    let mut single = vec![Vector3::zeros(); positions.len()];
    let mut window = NodeWindow {
        first: 0,
        values: &mut single,
    };
    let mut size = 0.0f64;
    for element in 0..count {
        let f = tetrahedra.deformation(element, positions);
        let stress = L::stress(&f, &constants.along(tetrahedra.directions(element)));
        for (corner, node) in tetrahedra.nodes(element).iter().enumerate() {
            let gradient = tetrahedra.gradient(element, corner);
            window.add(*node, stress * gradient * -tetrahedra.volume(element));
        }
        let gradients = tetrahedra.gradients(element).map(|g| g.norm());
        let largest = gradients.into_iter().fold(0.0, f64::max);
        size = size.max(tetrahedra.volume(element) * stress.norm() * largest);
    }
    for (all, single) in all.iter().zip(&single) {
        // Sums of 24 elements' forces at a node, each of some hundred operations; near rest stresses are differences of larger numbers.
        assert!((all - single).norm() < 1e-12 * size, "{:?}", L::NAME);
    }
}

#[test]
fn four_elements_at_once_are_what_each_is_alone() {
    let (mut tetrahedra, positions) = strained();
    for _ in 0..2 {
        for law in LawName::ALL {
            with_law!(MaterialLaw::from(law), L, _ => check::<L>(&tetrahedra, &positions));
        }
        for element in 0..tetrahedra.count() {
            tetrahedra.scale_volume(element, 0.5 + (element % 3) as f64);
        }
    }
}
