//! Sparse symmetric matrices of 3×3 blocks: assembly, ordering, Cholesky factor, conjugate gradients.
