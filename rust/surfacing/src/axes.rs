//! The principal axes of points.

/// Sweeps over the off-diagonal elements: they converge in 5 to 8.
const MOST_SWEEPS: usize = 32;

/// The elements above the diagonal, each with the index that it lacks.
const ELEMENTS: [[usize; 3]; 3] = [[0, 1, 2], [0, 2, 1], [1, 2, 0]];

/// Return the eigenvalues of a symmetric matrix, ascending, and its unit eigenvectors as columns.
///
/// Source: the cyclic method of Jacobi (Golub and Van Loan 2013, section 8.5).
pub fn diagonalise(mut matrix: [[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..MOST_SWEEPS {
        if ELEMENTS.iter().all(|&[p, q, _]| matrix[p][q] == 0.0) {
            break;
        }
        for [p, q, r] in ELEMENTS {
            let element = matrix[p][q];
            if element == 0.0 {
                continue;
            }
            let ratio = (matrix[q][q] - matrix[p][p]) / (2.0 * element);
            let size = 1.0 / (ratio.abs() + (ratio * ratio + 1.0).sqrt());
            let tangent = if ratio >= 0.0 { size } else { -size };
            let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
            let sine = tangent * cosine;
            matrix[p][p] -= tangent * element;
            matrix[q][q] += tangent * element;
            matrix[p][q] = 0.0;
            matrix[q][p] = 0.0;
            let (x, y) = (matrix[p][r], matrix[q][r]);
            matrix[p][r] = cosine * x - sine * y;
            matrix[q][r] = sine * x + cosine * y;
            matrix[r][p] = matrix[p][r];
            matrix[r][q] = matrix[q][r];
            for row in &mut vectors {
                let (x, y) = (row[p], row[q]);
                row[p] = cosine * x - sine * y;
                row[q] = sine * x + cosine * y;
            }
        }
    }
    let mut values = [matrix[0][0], matrix[1][1], matrix[2][2]];
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if values[j] < values[i] {
            values.swap(i, j);
            vectors.iter_mut().for_each(|row| row.swap(i, j));
        }
    }
    (values, vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_scaled_by_their_values() {
        let matrix = [[2.0, -1.0, 0.5], [-1.0, 3.0, 0.25], [0.5, 0.25, 1.0]];
        let (values, vectors) = diagonalise(matrix);
        assert!(values.is_sorted());
        for column in 0..3 {
            let vector = vectors.map(|row| row[column]);
            let size: f64 = vector.iter().map(|x| x * x).sum();
            assert!((size - 1.0).abs() < 1e-15);
            for (row, along) in matrix.iter().zip(vector) {
                let product: f64 = row.iter().zip(vector).map(|(a, b)| a * b).sum();
                assert!((product - values[column] * along).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn a_diagonal_is_sorted() {
        let matrix = [[3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]];
        let (values, vectors) = diagonalise(matrix);
        assert_eq!(values, [1.0, 2.0, 3.0]);
        assert_eq!(vectors, [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    }

    #[test]
    fn a_plane_has_a_value_of_nothing() {
        // Twice the projection along (1, 1, 1).
        let matrix = [[4.0, -2.0, -2.0], [-2.0, 4.0, -2.0], [-2.0, -2.0, 4.0]];
        let (values, _) = diagonalise(matrix);
        assert!(values[0].abs() < 1e-15);
        assert!((values[1] - 6.0).abs() < 1e-14 && (values[2] - 6.0).abs() < 1e-14);
    }
}
