//! Whether samples determine a spline.

/// Return how many of the ascending parameters can have control points of their own.
///
/// A parameter can have a control point if its basis function is positive there; greedily, each has
/// the first that is free, which gives the most. As many as control points: the samples determine the
/// spline. As many as parameters: values there can be interpolated.
pub fn count_determined(parameters: &[f64], knots: &[f64], degree: usize) -> usize {
    let n = (knots.len()).saturating_sub(degree + 1);
    let [from, to] = [knots[0], knots[knots.len() - 1]];
    let mut free = 0;
    let mut count = 0;
    let mut previous = None;
    for &t in parameters {
        if previous == Some(t) {
            continue;
        }
        previous = Some(t);
        if t == to {
            // Only the last function is positive at the end.
            if free < n {
                free = n;
                count += 1;
            }
            continue;
        }
        while free < n && knots[free + degree + 1] <= t {
            free += 1;
        }
        if free < n && (knots[free] < t || (t == from && free == 0)) {
            free += 1;
            count += 1;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of degree 2, with four control points.
    const KNOTS: [f64; 7] = [0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0];

    #[test]
    fn samples_close_together_have_no_control_points_of_their_own() {
        assert_eq!(count_determined(&[0.0, 0.3, 0.3, 0.7, 1.0], &KNOTS, 2), 4);
        assert_eq!(count_determined(&[0.0, 0.1, 0.2, 0.3, 0.4], &KNOTS, 2), 3);
        assert_eq!(count_determined(&[], &KNOTS, 2), 0);
    }
}
