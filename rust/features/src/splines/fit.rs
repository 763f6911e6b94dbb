//! The matrix of a spline's basis functions at samples, and its products.

/// The matrix N of basis functions at samples: in each row a few successive functions are not 0.
#[derive(Clone, Copy, Debug)]
pub struct Basis<'a> {
    /// The functions that are not 0, row by row.
    pub values: &'a [f64],
    /// How many of a row are not 0: the degree and 1.
    pub width: usize,
    /// The number of the first of each row.
    pub first: &'a [i32],
}

impl Basis<'_> {
    /// Return the rows, with the numbers of their first functions.
    fn rows(&self) -> impl Iterator<Item = (&[f64], usize)> {
        let first = self.first.iter().map(|&first| first as usize);
        self.values.chunks_exact(self.width).zip(first)
    }

    /// Return N'N for `n` control points: its diagonal, and the diagonals below it, `width` rows.
    pub fn normal_bands(&self, n: usize) -> Vec<f64> {
        let mut bands = vec![0.0; self.width * n];
        for (row, first) in self.rows() {
            for (a, one) in row.iter().enumerate() {
                for (k, other) in row[a..].iter().enumerate() {
                    bands[k * n + first + a] += one * other;
                }
            }
        }
        bands
    }

    /// Return N times control points, each a row of `n_columns` items.
    pub fn multiply(&self, control: &[f64], n_columns: usize) -> Vec<f64> {
        let mut result = vec![0.0; self.first.len() * n_columns];
        let made = result.chunks_exact_mut(n_columns.max(1));
        for (made, (row, first)) in made.zip(self.rows()) {
            let control = control[first * n_columns..].chunks_exact(n_columns);
            for (value, control) in row.iter().zip(control) {
                for (made, x) in made.iter_mut().zip(control) {
                    *made += value * x;
                }
            }
        }
        result
    }

    /// Return the transpose of N, for `n` control points, times points at the samples, each a row of
    /// `n_columns` items.
    pub fn multiply_transposed(&self, n: usize, points: &[f64], n_columns: usize) -> Vec<f64> {
        let mut result = vec![0.0; n * n_columns];
        let points = points.chunks_exact(n_columns.max(1));
        for (point, (row, first)) in points.zip(self.rows()) {
            let made = result[first * n_columns..].chunks_exact_mut(n_columns);
            for (value, made) in row.iter().zip(made) {
                for (made, x) in made.iter_mut().zip(point) {
                    *made += value * x;
                }
            }
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (1, 2, 0), (0, 3, 4)
    const BASIS: Basis = Basis {
        values: &[1.0, 2.0, 3.0, 4.0],
        width: 2,
        first: &[0, 1],
    };

    #[test]
    fn products_are_those_of_the_whole_matrix() {
        let control = [1.0, 10.0, 2.0, 20.0, 3.0, 30.0];
        assert_eq!(BASIS.multiply(&control, 2), [5.0, 50.0, 18.0, 180.0]);
        assert_eq!(
            BASIS.multiply_transposed(3, &[1.0, 2.0], 1),
            [1.0, 8.0, 8.0]
        );
        let bands = BASIS.normal_bands(3);
        assert_eq!(bands, [1.0, 13.0, 16.0, 2.0, 12.0, 0.0]);
    }
}
