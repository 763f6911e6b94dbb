//! From segments to a picture and back: drawing them, finding where along them a pixel is, and
//! following a contour's pixels along them, from where to where.

use patterndb_geometry::vector::{max, min};

use super::crossings::{Owned, find_crossing, find_foot, list_edges};
use super::raster::{Cells, Picture, Pixel, render_edges};
use super::{Edge, Place, Segments, advance, distance, edge, vector};

/// Pixels of the whole picture, and of a cell's side; from the paper, section 4.3.2.
const WIDTH: f64 = 800.0;
const HEIGHT: f64 = 600.0;
const CELL: usize = 8;

/// Pixels left free at every side, so that dilation never meets the border. `MARGIN` in
/// `patterndb_sketch.features.ribs.raster` is the same.
pub(super) const MARGIN: usize = 12;

/// Pixels by which a segment may run ahead of the contour from one of its pixels to the next,
/// together with twice the contour's steps: an edge crosses a pixel in up to 1.5.
const AHEAD: f64 = 4.0;

/// Pixels that the contour must go back along a segment before it counts as turned round.
const BACK: f64 = 3.5;

/// Pixels from the circle at which a rib ends.
const AT_RIM: f64 = 1.5;

/// Pixels that a change between segments may lie before or behind where both are in one pixel.
const SLACK: f64 = 3.0;

/// Contour pixels looked ahead for whether a walk leaves the segment that it begins on.
const LEAVING: usize = 12;

/// Contour pixels looked back, and ahead, at a change between segments: half of the picture.
pub(super) const LOOK: usize = 400;

/// How a walk ends. `patterndb_sketch.features.ribs.walking` has the same numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Where it began.
    Around = 0,
    /// At the circle.
    RimMet = 1,
    /// At the free end of a sheet.
    SheetEnd = 2,
    /// Where it meets itself.
    MetItself = 3,
}

/// A way along a segment: lengths along it, in pixels, from where to where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Run {
    pub segment: usize,
    pub begin: f64,
    pub end: f64,
}

/// Where a picture is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    /// Pixels to a unit.
    pub scale: f64,
    /// The place of pixel 0, 0.
    low: Place,
    /// Rows and columns of cells.
    n_rows: usize,
    n_columns: usize,
}

impl Frame {
    /// Return the part of [`WIDTH`] x [`HEIGHT`] pixels that points need; [`MARGIN`] stays free,
    /// and a pixel is never smaller than if the whole circle lay across the picture.
    pub fn fit(points: &[Place], radius: f64) -> Self {
        let least = [0, 1].map(|c| points.iter().map(|p| p[c]).fold(f64::INFINITY, min));
        let most = [0, 1].map(|c| points.iter().map(|p| p[c]).fold(f64::NEG_INFINITY, max));
        let (wide, high) = (most[0] - least[0], most[1] - least[1]);
        let margin = MARGIN as f64;
        let mut scale = (WIDTH - 2.0 * margin) / (2.0 * radius);
        if high * scale > HEIGHT - 2.0 * margin {
            scale = (HEIGHT - 2.0 * margin) / high;
        }
        let n_cells = |size: f64| (size * scale + 2.0 * margin) as usize / CELL + 1;
        Self {
            scale,
            low: least.map(|x| x - margin / scale),
            n_rows: n_cells(high),
            n_columns: n_cells(wide),
        }
    }

    /// Return a place in pixels.
    pub fn to_pixels(self, [x, y]: Place) -> Place {
        [
            (x - self.low[0]) * self.scale,
            (y - self.low[1]) * self.scale,
        ]
    }
}

/// Segments drawn as a picture.
#[derive(Clone, Debug)]
pub(super) struct Drawn<'a> {
    /// The segments, in units of the model.
    pub segments: &'a Segments,
    /// Their points in pixels.
    pixels: Vec<Place>,
    /// Lengths along each segment, in pixels.
    pub along: Vec<f64>,
    /// All edges.
    edges: Vec<Owned>,
    /// The edges in each cell.
    cells: Cells,
    /// The picture.
    pub picture: Picture,
}

impl<'a> Drawn<'a> {
    /// Draw segments.
    pub fn new(segments: &'a Segments, frame: &Frame) -> Self {
        let pixels: Vec<Place> = segments
            .points
            .iter()
            .map(|&p| frame.to_pixels(p))
            .collect();
        let mut along = vec![0.0; pixels.len()];
        for s in 0..segments.len() {
            for k in segments.edges(s) {
                along[k + 1] = along[k] + distance(pixels[k], pixels[k + 1]);
            }
        }
        let edges = list_edges(segments);
        let first = edges.iter().map(|e| e.first);
        let (picture, cells) = render_edges(&pixels, first, frame.n_rows, frame.n_columns);
        Self {
            segments,
            pixels,
            along,
            edges,
            cells,
            picture,
        }
    }

    /// Return the length of a segment.
    pub fn whole(&self, segment: usize) -> f64 {
        self.along[self.segments.end(segment, 1)]
    }

    /// Return the edges, of one segment or of all, that pass through a pixel.
    #[inline(always)]
    fn edges_in(&self, pixel: Pixel, segment: Option<usize>) -> impl Iterator<Item = Owned> {
        let near = self.cells.edges(self.picture.cell(pixel));
        let edges = near.map(|i| self.edges[i]);
        edges.filter(move |e| {
            segment.is_none_or(|segment| segment == e.segment)
                && passes(&edge(&self.pixels, e.first), pixel)
        })
    }

    /// Return where along its segment an edge is nearest to the middle of a pixel.
    fn place_of(&self, owned: Owned, [x, y]: Pixel) -> f64 {
        let k = owned.first;
        let middle = [f64::from(x) + 0.5, f64::from(y) + 0.5];
        let share = find_foot(&edge(&self.pixels, k), middle).share;
        self.along[k] + share * (self.along[k + 1] - self.along[k])
    }

    /// Find where along a segment a pixel is: within reach of t, nearest to `expected`; on a closed
    /// segment the number goes on counting beyond its length.
    fn locate_pixel(
        &self,
        pixel: Pixel,
        segment: usize,
        t: f64,
        expected: f64,
        reach: f64,
    ) -> Option<f64> {
        let mut best: Option<f64> = None;
        for owned in self.edges_in(pixel, Some(segment)) {
            let mut place = self.place_of(owned, pixel);
            if self.segments.closed[segment] {
                let whole = self.whole(segment);
                place += whole * ((expected - place) / whole).round_ties_even();
            }
            if (place - t).abs() > reach {
                continue;
            }
            if best.is_none_or(|best| (place - expected).abs() < (best - expected).abs()) {
                best = Some(place);
            }
        }
        best
    }

    /// Return the side of a segment's end within reach of t, and its place.
    fn find_end(&self, segment: usize, t: f64, reach: f64) -> Option<(usize, f64)> {
        if self.segments.closed[segment] {
            return None;
        }
        let whole = self.whole(segment);
        if t <= reach && t <= whole - t {
            return Some((0, 0.0));
        }
        (whole - t <= reach).then_some((1, whole))
    }

    /// Return whether a place of a segment is within one of the runs.
    fn is_covered<'r>(
        &self,
        mut runs: impl Iterator<Item = &'r Run>,
        segment: usize,
        t: f64,
    ) -> bool {
        runs.any(|run| {
            if run.segment != segment {
                return false;
            }
            let (low, high) = (min(run.begin, run.end), max(run.begin, run.end));
            let mut place = t;
            if self.segments.closed[segment] {
                let whole = self.whole(segment);
                place += whole * ((0.5 * (low + high) - t) / whole).round_ties_even();
            }
            low + SLACK < place && place < high - SLACK
        })
    }

    /// Return how long a turn around a segment is, infinite for an open one, and where the turn
    /// begins that a place is in.
    fn turn_at(&self, segment: usize, t: f64) -> (f64, f64) {
        if !self.segments.closed[segment] {
            return (f64::INFINITY, 0.0);
        }
        let whole = self.whole(segment);
        (whole, floor(t / whole) * whole)
    }

    /// Return the parts of a segment's edges that lie between two places on it, in turns.
    fn parts_between(&self, segment: usize, low: f64, high: f64) -> Vec<Part> {
        let (span, mut turn) = self.turn_at(segment, low);
        let mut parts = Vec::new();
        while turn <= high {
            for e in self.segments.edges(segment) {
                let (from, to) = (self.along[e], self.along[e + 1]);
                let begin = max(low, from + turn);
                let end = min(high, to + turn);
                if begin > end || to == from {
                    continue;
                }
                let size = to - from;
                let [p, q] = edge(&self.pixels, e);
                let at = |place: f64| advance(p, (place - turn - from) / size, vector(p, q));
                parts.push(Part {
                    begin,
                    end,
                    edge: [at(begin), at(end)],
                    turn,
                });
            }
            turn += span;
        }
        parts
    }

    /// Find where to change from one segment to another: their crossing nearest to place t of the
    /// first, or the nearest pair of places; between `low` and `high` of each.
    fn find_change(&self, one: Stretch, other: Stretch, t: f64) -> (f64, f64) {
        let mut nearest = f64::INFINITY;
        let mut result = (t, 0.5 * (other.low + other.high));
        let ones = self.parts_between(one.segment, one.low, one.high);
        let others = self.parts_between(other.segment, other.low, other.high);
        // Turn by turn of both, and edge by edge of both in each.
        for ones in ones.chunk_by(|a, b| a.turn == b.turn) {
            for others in others.chunk_by(|a, b| a.turn == b.turn) {
                for one in ones {
                    for other in others {
                        if let Some(share) = find_crossing(&one.edge, &other.edge) {
                            let place = one.at(share);
                            // Crossings come before any pair that is apart.
                            let rank = (place - t).abs() - 1e9;
                            if rank < nearest {
                                nearest = rank;
                                let back = find_crossing(&other.edge, &one.edge);
                                result = (place, other.at(back.unwrap_or(-1.0)));
                            }
                        } else if nearest >= 0.0 {
                            for (away, pair) in one.pairs(other) {
                                if away < nearest {
                                    nearest = away;
                                    result = pair;
                                }
                            }
                        }
                    }
                }
            }
        }
        result
    }
}

/// Return whether an edge passes through a pixel.
#[inline(always)]
fn passes([p, q]: &Edge, pixel: Pixel) -> bool {
    let (mut low, mut high) = (0.0, 1.0);
    for c in 0..2 {
        let begin = f64::from(pixel[c]) - 1e-9;
        let end = begin + 1.0 + 2e-9;
        let d = q[c] - p[c];
        if d == 0.0 {
            if p[c] < begin || p[c] > end {
                return false;
            }
        } else {
            let (one, two) = ((begin - p[c]) / d, (end - p[c]) / d);
            low = max(low, min(one, two));
            high = min(high, max(one, two));
        }
    }
    low <= high
}

/// Return the whole number below, never -0.
pub(super) fn floor(x: f64) -> f64 {
    x.floor() + 0.0
}

/// A part of a segment, between two lengths along it.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    segment: usize,
    low: f64,
    high: f64,
}

/// A part of an edge, with the lengths along its segment, and the turn that it is in.
#[derive(Clone, Copy, Debug)]
struct Part {
    begin: f64,
    end: f64,
    edge: Edge,
    turn: f64,
}

impl Part {
    fn at(&self, share: f64) -> f64 {
        self.begin + share * (self.end - self.begin)
    }

    /// Return the distances and places of the four pairs of an end and its foot on the other.
    fn pairs(&self, other: &Part) -> [(f64, (f64, f64)); 4] {
        let on_other = |k: usize| {
            let foot = find_foot(&other.edge, self.edge[k]);
            (foot.away, ([self.begin, self.end][k], other.at(foot.share)))
        };
        let on_self = |k: usize| {
            let foot = find_foot(&self.edge, other.edge[k]);
            (
                foot.away,
                (self.at(foot.share), [other.begin, other.end][k]),
            )
        };
        [on_other(0), on_other(1), on_self(0), on_self(1)]
    }
}

/// Which way a contour is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    Ahead,
    Behind,
}

impl Way {
    fn other(self) -> Self {
        match self {
            Way::Ahead => Way::Behind,
            Way::Behind => Way::Ahead,
        }
    }
}

/// How far a contour stays on a segment.
struct Followed {
    /// Pixels that it does; those without any segment count if more of the segment follows.
    length: usize,
    /// The least and the greatest place on the way.
    low: f64,
    high: f64,
}

/// A contour around drawn segments.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contour<'a> {
    /// The segments.
    pub drawn: &'a Drawn<'a>,
    /// The contour's pixels.
    pub border: &'a [Pixel],
}

impl<'a> Contour<'a> {
    /// Return the number of the pixel that is some steps from one; no more than there are pixels.
    #[inline(always)]
    fn after(&self, i: usize, way: Way, steps: usize) -> usize {
        let n = self.border.len();
        let k = match way {
            Way::Ahead => i + steps % n,
            Way::Behind => i + n - steps % n,
        };
        if k < n { k } else { k - n }
    }

    /// Return the pixel that is some steps from one, if it belongs to a segment.
    #[inline(always)]
    fn pixel_after(&self, i: usize, way: Way, steps: usize) -> Option<Pixel> {
        let pixel = self.border[self.after(i, way, steps)];
        self.drawn.picture.is_set(pixel).then_some(pixel)
    }

    /// Follow the contour along a segment from pixel i, where t is, for fewer than `most` pixels.
    fn follow_segment(&self, i: usize, way: Way, segment: usize, t: f64, most: usize) -> Followed {
        let mut followed = Followed {
            length: 0,
            low: t,
            high: t,
        };
        let mut t = t;
        for j in 1..most {
            let Some(pixel) = self.pixel_after(i, way, j) else {
                continue;
            };
            let reach = 2.0 * (j - followed.length) as f64 + AHEAD;
            let Some(found) = self.drawn.locate_pixel(pixel, segment, t, t, reach) else {
                break;
            };
            t = found;
            followed.length = j;
            followed.low = min(followed.low, t);
            followed.high = max(followed.high, t);
        }
        followed
    }

    /// Choose of the segments in pixel i the one that the contour stays on longest some ways, and
    /// where on it; None if there is none.
    pub fn choose_segment(&self, i: usize, ways: &[Way], most: usize) -> Option<(usize, f64)> {
        let pixel = self.border[i];
        let mut best: Option<(usize, usize, f64)> = None;
        for owned in self.drawn.edges_in(pixel, None) {
            let t = self.drawn.place_of(owned, pixel);
            let segment = owned.segment;
            let follow = |&way: &Way| self.follow_segment(i, way, segment, t, most).length;
            let length = ways.iter().map(follow).sum();
            let is_better = best.is_none_or(|(longest, chosen, _)| {
                length > longest || (length == longest && segment < chosen)
            });
            if is_better {
                best = Some((length, segment, t));
            }
        }
        best.map(|(_, segment, t)| (segment, t))
    }

    /// Return the sense, +1 or -1, in which a contour that leaves a segment at pixel `start` came
    /// along it; 0 if it stays on it, or does not show any.
    fn find_sense(&self, start: usize, way: Way, segment: usize, t: f64) -> f64 {
        let Followed { low, high, .. } = self.follow_segment(start, way, segment, t, LEAVING);
        if high - low > 2.0 {
            return 0.0;
        }
        let back = self.follow_segment(start, way.other(), segment, t, LEAVING);
        let (above, below) = (back.high - t, t - back.low);
        if max(above, below) <= 2.0 {
            0.0
        } else if below > above {
            1.0
        } else {
            -1.0
        }
    }

    /// Follow a contour from pixel `start`, at place t of a segment, until it comes upon runs that
    /// are taken, its own or those given.
    ///
    /// Return the runs along segments, and how the walk ended. The contour stays on a segment as
    /// long as that is in its pixels, then changes to the one that it will stay on longest: where
    /// segments lie within one pixel it does not change to and fro. Where it comes back along a
    /// segment from a free end, a fin on another segment is left out; any other end of a sheet ends
    /// the rib, for behind it the other side begins.
    ///
    /// Source: feature curve recovery paper, section 4.3.2, figure 4. Differs from the paper: it
    /// changes at once to the first segment on a cell's border, cell by cell, and takes both sides
    /// of open sheets.
    pub fn walk(
        &self,
        start: usize,
        way: Way,
        segment: usize,
        t: f64,
        taken: &[Run],
    ) -> (Vec<Run>, Ended) {
        let sense = self.find_sense(start, way, segment, t);
        let mut walk = Walk {
            contour: self,
            start,
            way,
            taken,
            legs: vec![Leg::new(segment, t, t, 0, sense)],
            t,
            farthest: t,
            is_back: false,
            last: 0,
            saved: None,
            history: vec![Some(t)],
        };
        let n = self.border.len();
        let mut ended = (1..n).find_map(|j| walk.step(j)).unwrap_or(Ended::Around);
        if walk.is_back && walk.saved.is_some() {
            ended = Ended::SheetEnd;
        }
        let runs = walk.saved.take().filter(|_| ended != Ended::Around);
        (runs.unwrap_or_else(|| walk.runs()), ended)
    }
}

/// A run of a walk that goes on.
#[derive(Clone, Copy, Debug)]
struct Leg {
    run: Run,
    /// Where the contour came onto the segment, which is not where the change was put.
    entry: f64,
    /// After how many pixels it came there.
    came: usize,
    /// +1 or -1, the way along the segment; 0 before it shows.
    sense: f64,
}

impl Leg {
    fn new(segment: usize, begin: f64, place: f64, came: usize, sense: f64) -> Self {
        Self {
            run: Run {
                segment,
                begin,
                end: place,
            },
            entry: place,
            came,
            sense,
        }
    }
}

/// A walk along a contour.
struct Walk<'a> {
    contour: &'a Contour<'a>,
    start: usize,
    way: Way,
    taken: &'a [Run],
    legs: Vec<Leg>,
    /// Where the walk is on the segment of the last leg, and the farthest that it was.
    t: f64,
    farthest: f64,
    /// Whether it comes back along the segment.
    is_back: bool,
    /// The last pixel that belonged to a segment.
    last: usize,
    /// The runs up to a free end, from which the walk comes back.
    saved: Option<Vec<Run>>,
    /// The place at each pixel.
    history: Vec<Option<f64>>,
}

impl Walk<'_> {
    fn leg(&mut self) -> &mut Leg {
        let last = self.legs.len() - 1;
        &mut self.legs[last]
    }

    fn runs(&self) -> Vec<Run> {
        self.legs.iter().map(|leg| leg.run).collect()
    }

    /// Go back to the end of the leg before.
    fn drop_leg(&mut self) {
        self.legs.pop();
        self.resume();
    }

    /// Go on from the end of the last leg.
    fn resume(&mut self) {
        let end = self.leg().run.end;
        (self.t, self.farthest, self.is_back) = (end, end, false);
    }

    fn is_taken(&self, segment: usize, t: f64) -> bool {
        self.contour.drawn.is_covered(self.taken.iter(), segment, t)
    }

    /// Go on to pixel j; return how the walk ends if it does.
    fn step(&mut self, j: usize) -> Option<Ended> {
        let contour = self.contour;
        self.history.push(None);
        let pixel = contour.pixel_after(self.start, self.way, j)?;
        let steps = (j - self.last) as f64;
        let reach = 2.0 * steps + AHEAD;
        let (leg, t) = (*self.leg(), self.t);
        let ahead = leg.sense * steps;
        let expected = if self.is_back { t - ahead } else { t + ahead };
        let drawn = contour.drawn;
        let mut found = drawn.locate_pixel(pixel, leg.run.segment, t, expected, reach);
        if found.is_none() && self.is_back {
            if (t - leg.entry).abs() > reach + SLACK {
                return Some(Ended::SheetEnd);
            }
            if self.legs.len() == 1 {
                // The walk began on a fin, next to its foot.
                let leg = self.leg();
                (leg.run.end, leg.sense) = (leg.run.begin, 0.0);
                self.resume();
            } else {
                self.drop_leg();
            }
            let (leg, t) = (*self.leg(), self.t);
            found = drawn.locate_pixel(pixel, leg.run.segment, t, t + leg.sense, reach + SLACK);
        }
        match found {
            Some(found) => {
                self.t = found;
                if let Some(ended) = self.stay() {
                    return Some(ended);
                }
            }
            None => {
                let here = contour.after(self.start, self.way, j);
                let look = LOOK.min(contour.border.len());
                let (segment, place) = contour.choose_segment(here, &[self.way], look)?;
                if drawn.is_covered(self.legs.iter().map(|leg| &leg.run), segment, place)
                    || self.is_taken(segment, place)
                {
                    return Some(Ended::MetItself);
                }
                self.change(j, here, segment, place, SLACK + steps);
            }
        }
        self.history[j] = Some(self.t);
        self.last = j;
        if !self.is_back && self.meets_rim() {
            return Some(Ended::RimMet);
        }
        None
    }

    /// Change to a place of another segment at pixel j, number `here` of the contour.
    fn change(&mut self, j: usize, here: usize, segment: usize, place: f64, pad: f64) {
        let contour = self.contour;
        let leg = *self.leg();
        let most = (j - leg.came).min(LOOK) + 1;
        let back = contour.follow_segment(here, self.way.other(), segment, place, most);
        let (mut low, mut high) = (self.t, self.t);
        let both = j.saturating_sub(back.length)..j;
        for &was in self.history[both].iter().flatten() {
            low = min(low, was);
            high = max(high, was);
        }
        let from = Stretch {
            segment: leg.run.segment,
            low: low - pad,
            high: high + pad,
        };
        let to = Stretch {
            segment,
            low: back.low - pad,
            high: back.high + pad,
        };
        let (end, begin) = contour.drawn.find_change(from, to, self.t);
        self.leg().run.end = end;
        self.legs.push(Leg::new(segment, begin, place, j, 0.0));
        (self.t, self.farthest) = (place, place);
        self.saved = None;
    }

    /// Take note of a place on the segment of the last leg; return how the walk ends if it does.
    fn stay(&mut self) -> Option<Ended> {
        let drawn = self.contour.drawn;
        let t = self.t;
        let segment = self.leg().run.segment;
        if self.is_taken(segment, t) {
            return Some(Ended::MetItself);
        }
        let leg = self.leg();
        if leg.sense == 0.0 && (t - leg.entry).abs() > 2.0 {
            leg.sense = if t > leg.entry { 1.0 } else { -1.0 };
            leg.run.end = t;
            self.farthest = t;
        }
        let Leg {
            run, entry, sense, ..
        } = *self.leg();
        if self.is_back {
            let over = (t - entry) * sense;
            let is_first = self.legs.len() == 1;
            if is_first && over <= -SLACK {
                return Some(Ended::SheetEnd);
            }
            if !is_first && over <= SLACK {
                self.drop_leg();
            }
        } else if (t - self.farthest) * sense > 0.0 {
            if (t - run.end) * sense > BACK {
                self.saved = None;
            }
            self.farthest = t;
            if self.saved.is_none() {
                self.leg().run.end = t;
            }
        } else if (self.farthest - t) * sense > BACK {
            let tip = drawn.find_end(segment, self.farthest, SLACK);
            if self.saved.is_none() {
                self.leg().run.end = tip.map_or(self.farthest, |(_, place)| place);
                self.saved = Some(self.runs());
            }
            if tip.is_some_and(|(side, _)| drawn.segments.rims[segment][side]) {
                return Some(Ended::RimMet);
            }
            self.is_back = true;
        }
        None
    }

    /// Return whether the walk comes to the circle; end the last leg there.
    fn meets_rim(&mut self) -> bool {
        let drawn = self.contour.drawn;
        let Leg {
            run, entry, sense, ..
        } = *self.leg();
        let Some((side, exact)) = drawn.find_end(run.segment, self.t, AT_RIM) else {
            return false;
        };
        // At the very beginning, at the circle, the walk may lead away from it.
        let is_leaving = (exact - entry) * sense <= 0.0 && sense != 0.0;
        let is_met = drawn.segments.rims[run.segment][side]
            && !is_leaving
            && (self.legs.len() > 1 || sense != 0.0);
        if is_met {
            self.leg().run.end = exact;
            self.saved = None;
        }
        is_met
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Segments {
        let mut made = Segments {
            points: vec![
                [1.0, 1.0],
                [-1.0, 1.0],
                [-1.0, -1.0],
                [1.0, -1.0],
                [1.0, 1.0],
            ],
            ..Segments::default()
        };
        made.finish_segment(true, [false; 2]);
        made
    }

    #[test]
    fn a_picture_has_a_margin_around_what_it_shows() {
        let segments = square();
        let frame = Frame::fit(&segments.points, 4.0);
        assert_eq!(frame.scale, 97.0);
        assert_eq!((frame.n_rows, frame.n_columns), (28, 28));
        let low = frame.to_pixels([-1.0, -1.0]);
        assert!(low.iter().all(|&x| (x - MARGIN as f64).abs() < 1e-9));
    }

    #[test]
    fn places_on_a_closed_segment_go_on_counting() {
        let segments = square();
        let drawn = Drawn::new(&segments, &Frame::fit(&segments.points, 4.0));
        let whole = drawn.whole(0);
        assert!((whole - 8.0 * 97.0).abs() < 1e-9);
        let pixel = drawn.pixels[1].map(|x| x.floor() as i32);
        let near = drawn.locate_pixel(pixel, 0, 0.25 * whole, 0.25 * whole, 3.0);
        let next = drawn.locate_pixel(pixel, 0, 1.25 * whole, 1.25 * whole, 3.0);
        assert!((next.unwrap() - near.unwrap() - whole).abs() < 1e-9);
        assert_eq!(
            drawn.locate_pixel(pixel, 0, 0.5 * whole, 0.5 * whole, 3.0),
            None
        );
    }

    #[test]
    fn segments_change_where_they_cross() {
        let mut segments = Segments::default();
        for line in [[[-1.0, 0.0], [1.0, 0.0]], [[0.0, -0.5], [0.0, 0.5]]] {
            segments.points.extend(line);
            segments.finish_segment(false, [false; 2]);
        }
        let drawn = Drawn::new(&segments, &Frame::fit(&segments.points, 4.0));
        let all = |segment| Stretch {
            segment,
            low: 0.0,
            high: drawn.whole(segment),
        };
        let (one, other) = drawn.find_change(all(0), all(1), 0.0);
        assert!((one - 97.0).abs() < 1e-9 && (other - 48.5).abs() < 1e-9);
    }
}
