//! Ribs: the outlines of a model in planes across a curve, near the curve.
//!
//! The segments of a slice that belong to the nearest one ([`slice_segments`]) are the rib as they
//! are if they are one, else a picture of them is ([`trace_outline`]).

use super::polygon::{close, collect_points, cut_loops, thin_points};
use super::raster::find_passing_pixel;
use super::repair::{TOUCH, mend_segments};
use super::slicing::{Plane, Surface, cut_edges, join_edges};
use super::walking::{Contour, Drawn, Ended, Frame, LOOK, MARGIN, Way};
use super::{Place, Segments, advance, length, vector};

pub use super::polygon::measure_off_backbone;

/// Arc length to either side of the backbone, as a share of the radius, over which the side of a
/// surface is taken.
const WINDOW: f64 = 0.2;

/// Where the segments of a slice are nearest to the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The segment.
    pub segment: usize,
    /// The place on it.
    pub foot: Place,
    /// The segment's unit normal there, to the right.
    pub normal: Place,
}

/// The segments of a slice that belong to the one nearest to the origin.
#[derive(Clone, Debug)]
pub struct Sliced {
    /// The segments, without overhangs where segments cross, and joined where ends face each other.
    pub segments: Segments,
    /// The widest gap to be closed; None if the nearest segment is alone and has none.
    pub gap: Option<f64>,
    /// Where they are nearest to the origin; None without segments.
    pub nearest: Option<Nearest>,
    /// Whether any segment was shortened or joined.
    pub is_mended: bool,
}

/// Cut the segments out of a surface that belong to the one nearest to the plane's origin.
pub fn slice_segments(
    surface: &Surface<'_>,
    plane: &Plane<'_>,
    radius: f64,
    tolerance: f64,
) -> Sliced {
    let cut = cut_edges(surface, plane, radius);
    let mended = mend_segments(
        join_edges(&cut.ends, &cut.keys, tolerance),
        radius,
        tolerance,
    );
    let segments = mended.segments;
    let found = super::crossings::find_nearest_segment(&segments);
    let nearest = found.map(|(owned, foot)| {
        let own = segments.points_of(owned.segment);
        let k = owned.first - segments.offsets[owned.segment];
        Nearest {
            segment: owned.segment,
            foot: advance(own[k], foot.share, vector(own[k], own[k + 1])),
            normal: find_chord_normal(own, k, foot.share, WINDOW * radius),
        }
    });
    Sliced {
        segments,
        gap: mended.gap,
        nearest,
        is_mended: mended.is_changed,
    }
}

/// Find the right normal of a polyline about a place on its edge k: of the chord from `reach` before
/// to `reach` behind, or of the edge if that has no length.
fn find_chord_normal(points: &[Place], k: usize, share: f64, reach: f64) -> Place {
    let own = vector(points[k], points[k + 1]);
    let place = advance(points[k], share, own);
    let before = move_along(place, points[..=k].iter().rev(), reach);
    let behind = move_along(place, points[k + 1..].iter(), reach);
    let mut chord = vector(before, behind);
    let mut size = length(chord);
    if size <= 1e-6 * reach {
        chord = own;
        size = length(chord);
    }
    [chord[1] / size, -chord[0] / size]
}

/// Return the place that is a length along points from a place, or the last of them.
fn move_along<'a>(place: Place, points: impl Iterator<Item = &'a Place>, reach: f64) -> Place {
    let (mut at, mut left) = (place, reach);
    for &point in points {
        if left <= 0.0 {
            break;
        }
        let d = vector(at, point);
        let size = length(d);
        at = advance(at, if size <= left { 1.0 } else { left / size }, d);
        left -= size;
    }
    at
}

/// Return how many dilations close a gap: the paper's one, or as many as the gap needs, so long as
/// they stay within the margin.
///
/// Two pixels meet after k if they are 2 k + 1 apart, and the pixels of two places are apart by less
/// than one more than those.
pub fn count_rounds(gap: f64, scale: f64) -> usize {
    let needed = (0.5 * gap * scale).ceil() as usize;
    needed.clamp(1, MARGIN - 1)
}

/// The outer contour of segments.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// The polygon, the outside on its right; empty if no contour passes the foot.
    pub polygon: Vec<Place>,
    /// Whether it is closed, the last point being the first again.
    pub is_closed: bool,
    /// How many dilations and erosions it took.
    pub rounds: usize,
    /// How both ends came about.
    pub ends: [Ended; 2],
}

/// Trace the outer contour of segments through a foot, by way of a picture.
///
/// * `foot`, `outward`: a place of a segment, and the unit normal there that points out.
/// * `rounds`: of dilation and erosion; None for what the widest gap needs.
pub fn trace_outline(
    segments: &Segments,
    [foot, outward]: [Place; 2],
    radius: f64,
    rounds: Option<usize>,
    gap: f64,
    tolerance: f64,
) -> Outline {
    let frame = Frame::fit(&segments.points, radius);
    let drawn = Drawn::new(segments, &frame);
    let rounds = rounds.unwrap_or_else(|| count_rounds(gap, frame.scale));
    let foot = frame.to_pixels(foot);
    let border = drawn.picture.close_gaps(rounds).find_outer_contour(foot);
    let contour = Contour {
        drawn: &drawn,
        border: &border,
    };
    let made = |polygon, is_closed, ends| Outline {
        polygon,
        is_closed,
        rounds,
        ends,
    };
    let none = || made(Vec::new(), false, [Ended::Around; 2]);
    let Some(start) = find_passing_pixel(&border, &drawn.picture, foot, outward) else {
        return none();
    };
    let most = LOOK.min(border.len());
    let both = [Way::Ahead, Way::Behind];
    let Some((segment, t)) = contour.choose_segment(start, &both, most) else {
        return none();
    };
    let (runs, last) = contour.walk(start, Way::Ahead, segment, t, &[]);
    let mut ahead = collect_points(&drawn, &runs, last != Ended::Around);
    let reach = TOUCH * tolerance;
    if last == Ended::Around {
        if ahead.len() < 3 {
            return none();
        }
        ahead.push(ahead[0]);
        let mut ring = thin_points(&ahead, tolerance);
        close(&mut ring);
        return made(cut_loops(ring, true, reach), true, [last; 2]);
    }
    let (runs, first) = contour.walk(start, Way::Behind, segment, t, &runs);
    let mut polygon = collect_points(&drawn, &runs, true);
    polygon.reverse();
    polygon.append(&mut ahead);
    // Contours run counter-clockwise, background on their right, as polygons do.
    let polygon = cut_loops(thin_points(&polygon, tolerance), false, reach);
    made(polygon, false, [first, last])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_stay_within_the_margin() {
        assert_eq!(count_rounds(0.0, 50.0), 1);
        assert_eq!(count_rounds(0.1, 50.0), 3);
        assert_eq!(count_rounds(9.0, 50.0), MARGIN - 1);
    }

    #[test]
    fn the_outline_of_two_squares_that_cross_goes_around_both() {
        let mut segments = Segments::default();
        for low in [-1.0, 0.0] {
            let high = low + 1.5;
            let ring = [
                [low, low],
                [high, low],
                [high, high],
                [low, high],
                [low, low],
            ];
            segments.points.extend(ring);
            segments.finish_segment(true, [false; 2]);
        }
        let about = [[-0.25, -1.0], [0.0, -1.0]];
        let outline = trace_outline(&segments, about, 4.0, None, 0.0, 1e-6);
        assert!(outline.is_closed);
        assert_eq!(outline.ends, [Ended::Around; 2]);
        let mut corners = outline.polygon;
        corners.pop();
        corners.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let mut wanted = [
            [-1.0, -1.0],
            [0.5, -1.0],
            [0.5, 0.0],
            [1.5, 0.0],
            [1.5, 1.5],
            [0.0, 1.5],
            [0.0, 0.5],
            [-1.0, 0.5],
        ];
        wanted.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(corners.len(), wanted.len());
        for (a, b) in corners.iter().zip(&wanted) {
            assert!(a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-6));
        }
    }

    #[test]
    fn normals_point_to_the_right_of_a_chord() {
        let line = [[-1.0, 2.0], [0.0, 2.0], [1.0, 2.0]];
        assert_eq!(find_chord_normal(&line, 0, 0.5, 0.25), [0.0, -1.0]);
    }
}
