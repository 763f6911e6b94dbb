//! How well the midlines of strands follow strokes.

use patterndb_geometry::Point;
use patterndb_geometry::vector::{length, max, min, subtract};

/// Places along a stroke where its distance to a midline is measured, at the middles of as many equal
/// parts. As `SAMPLES` of the Python module `query.placing.flow`.
const SAMPLES: usize = 64;

/// A polyline and the arc length up to each of its points; of a closed one also once round.
struct Polyline<'a> {
    points: &'a [Point],
    lengths: Vec<f64>,
}

impl<'a> Polyline<'a> {
    fn open(points: &'a [Point]) -> Polyline<'a> {
        let mut total = 0.0;
        let steps = points.windows(2).map(|pair| gap(&pair[1], &pair[0]));
        let along = steps.map(|step| {
            total += step;
            total
        });
        let lengths = std::iter::once(0.0).chain(along).collect();
        Polyline { points, lengths }
    }

    fn closed(points: &'a [Point]) -> Polyline<'a> {
        let mut line = Polyline::open(points);
        let last = points.len() - 1;
        let once = line.length() + gap(&points[0], &points[last]);
        line.lengths.push(once);
        line
    }

    fn length(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    /// Return the arc lengths up to the points, as parts of the whole.
    fn parts(&self) -> impl Iterator<Item = f64> {
        let whole = max(self.length(), 1e-300);
        let up_to = self.lengths[..self.points.len()].iter();
        up_to.map(move |along| along / whole)
    }

    /// Return the points at arc lengths, soonest where these ascend.
    fn interpolate(&self, wanted: impl Iterator<Item = f64>) -> impl Iterator<Item = Point> {
        let lengths = &self.lengths;
        let mut i = 0;
        wanted.map(move |along| {
            if lengths[i] >= along {
                i = 0;
            }
            while i + 2 < lengths.len() && lengths[i + 1] < along {
                i += 1;
            }
            let step = lengths[i + 1] - lengths[i];
            let t = if step > 0.0 {
                (along - lengths[i]) / step
            } else {
                0.0
            };
            let t = min(max(t, 0.0), 1.0);
            let (a, b) = (&self.points[i], &self.points[(i + 1) % self.points.len()]);
            [0, 1, 2].map(|c| a[c] * (1.0 - t) + b[c] * t)
        })
    }

    /// Return the points at the middles of as many equal parts as there are samples.
    fn samples(&self) -> [Point; SAMPLES] {
        let middle = |n| (f64::from(n) + 0.5) / SAMPLES as f64 * self.length();
        let mut samples = [[0.0; 3]; SAMPLES];
        for (sample, point) in samples.iter_mut().zip(self.interpolate((0..).map(middle))) {
            *sample = point;
        }
        samples
    }
}

fn gap(a: &Point, b: &Point) -> f64 {
    length(&subtract(a, b))
}

/// How far a stroke is from a midline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Integral of the distance over the stroke's length.
    pub integral: f64,
    /// The mean over the stroke.
    pub mean: f64,
    /// The greatest.
    pub most: f64,
}

impl Distance {
    /// Return the distance whose samples have a sum and a greatest.
    fn new(total: f64, most: f64, stroke: &Polyline) -> Distance {
        let mean = total / SAMPLES as f64;
        Distance {
            integral: mean * stroke.length(),
            mean,
            most,
        }
    }
}

/// Measure the distance of an open midline to an open stroke, by arc length.
pub fn measure_open_distance(stroke: &[Point], middle: &[Point]) -> Distance {
    let (one, two) = (Polyline::open(stroke), Polyline::open(middle));
    let ends = [stroke, middle].map(|line| (&line[0], &line[line.len() - 1]));
    let mut most = max(gap(ends[0].0, ends[1].0), gap(ends[0].1, ends[1].1));
    let mut total = 0.0;
    for (a, b) in one.samples().iter().zip(&two.samples()) {
        let d = gap(a, b);
        total += d;
        most = max(most, d);
    }
    Distance::new(total, most, &one)
}

/// How far a closed stroke is from a closed midline, and how the two lie to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopDistance {
    /// The distance.
    pub distance: Distance,
    /// The part of the stroke's length at which the midline's first point falls.
    pub offset: f64,
    /// Whether the midline runs the other way.
    pub against: bool,
}

/// Measure the distance of a closed midline to a closed stroke, by arc length.
///
/// Of all starts and both senses the nearest counts.
pub fn measure_loop_distance(stroke: &[Point], middle: &[Point]) -> LoopDistance {
    let one = Polyline::closed(stroke);
    let (a, b) = (&one.samples(), &Polyline::closed(middle).samples());
    // The gaps for a start and a sense, in order.
    let gaps = |shift: usize, against: bool| {
        (0..SAMPLES).map(move |n| {
            let m = if against { SAMPLES - 1 - n } else { n };
            gap(&a[(n + shift) % SAMPLES], &b[m])
        })
    };
    let (mut best, mut shift, mut against) = (f64::INFINITY, 0, false);
    for s in 0..SAMPLES {
        for turned in [false, true] {
            let mut total = 0.0;
            for gap in gaps(s, turned) {
                total += gap;
                if total >= best {
                    break;
                }
            }
            if total < best {
                (best, shift, against) = (total, s, turned);
            }
        }
    }
    let most = gaps(shift, against).fold(0.0, max);
    LoopDistance {
        distance: Distance::new(best, most, &one),
        offset: shift as f64 / SAMPLES as f64,
        against,
    }
}

/// Return the points of an open stroke at the arc lengths of a midline's, in proportion.
pub fn list_open_targets(stroke: &[Point], middle: &[Point]) -> Vec<Point> {
    let one = Polyline::open(stroke);
    let two = Polyline::open(middle);
    let wanted = two.parts().map(|part| part * one.length());
    one.interpolate(wanted).collect()
}

/// As [`list_open_targets`] of a closed stroke, the midline's first point falling at the part
/// `offset` of the stroke.
pub fn list_loop_targets(stroke: &[Point], middle: &[Point], offset: f64) -> Vec<Point> {
    let one = Polyline::closed(stroke);
    let two = Polyline::closed(middle);
    let wanted = two.parts().map(|part| (part + offset) % 1.0 * one.length());
    one.interpolate(wanted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [Point; 4] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];

    #[test]
    fn parallel_lines_are_equally_far_everywhere() {
        let stroke = [[0.0; 3], [1.0, 0.0, 0.0], [4.0, 0.0, 0.0]];
        let middle = [[0.0, 3.0, 0.0], [4.0, 3.0, 0.0]];
        let found = measure_open_distance(&stroke, &middle);
        assert_eq!((found.integral, found.mean, found.most), (12.0, 3.0, 3.0));
        let targets = list_open_targets(&stroke, &middle);
        assert_eq!(targets, [[0.0; 3], [4.0, 0.0, 0.0]]);
    }

    #[test]
    fn a_loop_is_on_itself_from_any_start_in_both_senses() {
        let turned = [SQUARE[2], SQUARE[1], SQUARE[0], SQUARE[3]];
        let found = measure_loop_distance(&SQUARE, &turned);
        assert!(found.distance.most < 1e-12);
        assert!(found.against);
        let shifted = [SQUARE[1], SQUARE[2], SQUARE[3], SQUARE[0]];
        let found = measure_loop_distance(&SQUARE, &shifted);
        assert_eq!((found.offset, found.against), (0.25, false));
        assert_eq!(list_loop_targets(&SQUARE, &shifted, 0.25), shifted);
    }
}
