//! The eigenvalues of a small body, exactly.

use microsim_tissue::elements::{ElementMatrix, Tangent};
use microsim_tissue::{State, TissueModel};
use nalgebra::DMatrix;

/// All eigenvalues of M⁻¹K of the free nodes in a state \[1/s²\], ascending, from M^−½ K M^−½ as a dense matrix. For small bodies:
/// time grows with the third power of the nodes.
pub fn eigenvalues(model: &TissueModel, state: &State) -> Vec<f64> {
    let mut free = vec![None; model.node_count()];
    let mut count = 0;
    for (place, w) in free.iter_mut().zip(model.inverse_masses()) {
        if *w > 0.0 {
            *place = Some(count);
            count += 1;
        }
    }
    let mut matrix = DMatrix::<f64>::zeros(3 * count, 3 * count);
    let mut element_matrix = ElementMatrix::new();
    for (index, set) in model.sets().iter().enumerate() {
        let at = state.configuration(model, index);
        for element in 0..set.count() {
            set.stiffness(element, &at, Tangent::Exact, &mut element_matrix);
            let nodes = set.nodes(element);
            for (i, &row) in nodes.iter().enumerate() {
                for (j, &column) in nodes.iter().enumerate() {
                    let (Some(r), Some(c)) = (free[row as usize], free[column as usize]) else {
                        continue;
                    };
                    let w = model.inverse_masses();
                    let scale = (w[row as usize] * w[column as usize]).sqrt();
                    let mut block = matrix.fixed_view_mut::<3, 3>(3 * r, 3 * c);
                    block += element_matrix.block(i, j) * scale;
                }
            }
        }
    }
    let mut values: Vec<f64> = matrix.symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    values
}
