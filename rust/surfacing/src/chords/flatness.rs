//! How far from flat a piece of a cycle is: the spread of its vertices along three axes.
//!
//! Source: Abbasinejad et al. 2013, section 3.2.

use patterndb_geometry::vector::{Point, dot, max};

use crate::axes::diagonalise;

/// A cycle is planar if it spreads across its plane by less than this share of its largest spread:
/// files keep some six digits.
const PLANAR: f64 = 1e-6;

/// A piece is planar where, measured in the whole cycle's own spread, the variance across its plane
/// is below this. The moments carry errors of some 1e-15, of which the square root makes 3e-8 at 0,
/// but only 2e-10 here.
const PLANAR_PIECE: f64 = 1e-11;

/// Moments of points: how many, the sums of x, y and z, and those of xx, xy, xz, yy, yz and zz.
pub type Moments = [f64; 10];

/// Return the points in axes in which their covariance is the unit matrix, and the determinant of
/// their covariance, in units of length^6. If they are planar, points and determinant are 0.
///
/// Ratios of determinants are the same in any axes; in these, the moments of every part are of the
/// order of 1 and keep their digits, however flat, small or far away the points are.
pub fn standardise(points: &[Point]) -> (Vec<Point>, f64) {
    let n = points.len() as f64;
    let mut own = points.to_vec();
    // Twice: far from the origin, the first mean is off by the digits that the distance costs.
    for _ in 0..2 {
        for d in 0..3 {
            let mean = own.iter().fold(0.0, |mean, point| mean + point[d] / n);
            own.iter_mut().for_each(|point| point[d] -= mean);
        }
    }
    let size = own.as_flattened().iter().map(|x| x.abs()).fold(0.0, max);
    if size == 0.0 {
        return (vec![[0.0; 3]; points.len()], 0.0);
    }
    let mut covariance = [[0.0; 3]; 3];
    for point in &mut own {
        *point = point.map(|x| x / size);
        for (row, x) in covariance.iter_mut().zip(*point) {
            for (sum, y) in row.iter_mut().zip(*point) {
                *sum += x * y / n;
            }
        }
    }
    let (variances, axes) = diagonalise(covariance);
    if variances[0] <= PLANAR * PLANAR * variances[2] {
        return (vec![[0.0; 3]; points.len()], 0.0);
    }
    for point in &mut own {
        *point = [0, 1, 2].map(|d| {
            let axis = axes.map(|row| row[d]);
            dot(point, &axis) / variances[d].sqrt()
        });
    }
    let square = size * size;
    let determinant = variances[0] * variances[1] * variances[2] * (square * (square * square));
    (own, determinant)
}

/// Add a point to moments.
#[inline(always)]
pub fn add_moments(moments: &mut Moments, &[x, y, z]: &Point) {
    let terms = [1.0, x, y, z, x * x, x * y, x * z, y * y, y * z, z * z];
    for (moment, term) in moments.iter_mut().zip(terms) {
        *moment += term;
    }
}

/// Return the moments of points.
pub fn sum_moments<'a>(points: impl IntoIterator<Item = &'a Point>) -> Moments {
    let mut moments = Moments::default();
    for point in points {
        add_moments(&mut moments, point);
    }
    moments
}

/// Return the determinant of the covariance that moments have, 0 for a planar piece.
///
/// The points must be in the axes of [`standardise`].
#[inline(always)]
pub fn find_determinant(moments: &Moments) -> f64 {
    let share = 1.0 / moments[0];
    let [x, y, z] = [1, 2, 3].map(|m| moments[m] * share);
    let mut xx = moments[4] * share - x * x;
    let mut xy = moments[5] * share - x * y;
    let mut xz = moments[6] * share - x * z;
    let mut yy = moments[7] * share - y * y;
    let mut yz = moments[8] * share - y * z;
    let mut zz = moments[9] * share - z * z;
    // The largest variance is eliminated first: what remains keeps its digits in needles, too.
    if yy > xx && yy >= zz {
        (xx, yy, xz, yz) = (yy, xx, yz, xz);
    } else if zz > xx {
        (xx, zz, xy, yz) = (zz, xx, yz, xy);
    }
    if xx <= 0.0 {
        return 0.0;
    }
    let a = yy - xy * xy / xx;
    let b = yz - xy * xz / xx;
    let c = zz - xz * xz / xx;
    let area = a * c - b * b;
    // Divided by a + c, about the least variance where that is far below the others.
    if area <= PLANAR_PIECE * (a + c) {
        return 0.0;
    }
    xx * area
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Point; 5] = [
        [1.0, 0.0, 0.0],
        [0.0, 2.0, 0.5],
        [-1.0, 0.0, 1.0],
        [0.0, -2.0, 0.0],
        [1.0, -1.0, 3.0],
    ];

    #[test]
    fn standardised_points_have_the_unit_covariance() {
        let (own, determinant) = standardise(&CORNERS);
        assert!((find_determinant(&sum_moments(&own)) - 1.0).abs() < 1e-14);
        let printed = find_determinant(&sum_moments(&CORNERS));
        assert!((printed - determinant).abs() < 1e-13 * determinant);
    }

    #[test]
    fn planar_points_have_no_determinant() {
        let flat = CORNERS.map(|[x, y, _]| [x, y, 2.0 * x - y + 1e6]);
        assert_eq!(standardise(&flat), (vec![[0.0; 3]; 5], 0.0));
        assert_eq!(standardise(&[[1.0, 2.0, 3.0]; 4]), (vec![[0.0; 3]; 4], 0.0));
        let (own, _) = standardise(&CORNERS);
        assert_eq!(find_determinant(&sum_moments(&own[..3])), 0.0);
    }
}
