//! Lines along a cross field: traced from all starts at once, the shortest making the next step.

use std::f64::consts::PI;

use patterndb_geometry::vector::{max, min};

use crate::tracing::heap::Heap;

/// Traces keep this part of a side's length from its ends, and go into a triangle at this angle at
/// least, so that none runs into a vertex or along a side.
const OFF_ENDS: f64 = 1e-3;
const LEAST_ANGLE: f64 = 0.03;

/// A trace has at most this many steps: one that needs more turns round in a spike.
const MOST_STEPS: usize = 6000;

/// A place in the frame of a triangle.
pub type Place = [f64; 2];

/// A cross field on triangles, each with a frame of its own.
#[derive(Clone, Copy, Debug)]
pub struct CrossField<'a> {
    /// The corners of each triangle in its frame.
    pub flat: &'a [[Place; 3]],
    /// The direction of each side in its triangle's frame.
    pub side_angle: &'a [[f64; 3]],
    /// Of each side the one beyond, -1 at borders.
    pub across: &'a [i32],
    /// Of each triangle's cross one direction.
    pub angle: &'a [f64],
    /// Of each side: direction k of the triangle is direction k - quarters beyond.
    pub quarters: &'a [i32],
}

impl CrossField<'_> {
    /// Return the ends of a side.
    fn side(&self, triangle: usize, e: usize) -> [Place; 2] {
        let corners = &self.flat[triangle];
        [corners[e], corners[(e + 1) % 3]]
    }
}

/// Where a trace begins.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// The triangle that it goes into.
    pub triangle: i32,
    /// The corner of this that it leaves.
    pub corner: i32,
    /// Where that is.
    pub place: Place,
    /// Which way it goes.
    pub angle: f64,
    /// The direction of the cross, 0 to 3 and beyond, that is nearest to this.
    pub direction: i32,
}

/// A piece of a line within a triangle.
#[derive(Clone, Copy, Debug)]
pub struct LineSegment {
    /// Whose it is.
    pub line: i32,
    /// Where it lies.
    pub triangle: i32,
    /// Its ends.
    pub begin: Place,
    /// Its ends.
    pub end: Place,
    /// How far along its line it begins.
    pub along: f64,
    /// How long it is in the same measure.
    pub reach: f64,
}

/// How a trace ended. The numbers are also in patterndb_sketch.retopo.draft.tracing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ended {
    /// At another line.
    AtLine = 0,
    /// At a border.
    AtBorder = 1,
    /// Where it was cut off.
    CutOff = 2,
}

/// What became of a trace.
#[derive(Clone, Copy, Debug)]
pub struct Trace {
    /// How it ended.
    pub ended: Ended,
    /// How long it is.
    pub length: f64,
    /// The line that it met, or the border's side; -1 for neither.
    pub other: i32,
    /// How far along that.
    pub there: f64,
    /// Did it come from the left of what it met?
    pub left: bool,
}

/// What ends traces.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The number of the first trace as a line; walls have lower ones.
    pub first: i32,
    /// Where a trace is cut off.
    pub longest: f64,
    /// Do traces stop at lines? Else only at borders.
    pub stopping: bool,
}

/// Trace from all starts: return the segments of the walls and of all traces, in the order in which
/// they were laid, and what became of each trace.
///
/// `walls`: lines that are there already, at which traces stop.
pub fn trace_all(
    field: &CrossField,
    starts: &[Start],
    walls: &[LineSegment],
    limits: &Limits,
) -> (Vec<LineSegment>, Vec<Trace>) {
    let mut lines = Lines::new(field.angle.len());
    for &wall in walls {
        lines.lay(wall);
    }
    let mut traces: Vec<Trace> = vec![
        Trace {
            ended: Ended::CutOff,
            length: 0.0,
            other: -1,
            there: 0.0,
            left: false,
        };
        starts.len()
    ];
    let mut heads: Vec<Head> = starts.iter().map(Head::new).collect();
    let mut waiting = Heap::default();
    for i in 0..starts.len() {
        waiting.push(0.0, i as i32);
    }
    while let Some((_, i)) = waiting.pop() {
        let (head, trace) = (&mut heads[i as usize], &mut traces[i as usize]);
        if head.steps >= MOST_STEPS {
            continue;
        }
        let Some(step) = head.find_step(field) else {
            continue;
        };
        let mut segment = LineSegment {
            line: limits.first + i,
            triangle: head.triangle as i32,
            begin: head.place,
            end: step.end,
            along: trace.length,
            reach: step.size,
        };
        let met = if limits.stopping {
            lines.meet(&segment, &step, head.steps == 0)
        } else {
            None
        };
        if let Some(met) = &met {
            trace.there = met.there;
            trace.left = met.left;
            let cut = max(met.cut, 0.0);
            segment.end = [0, 1].map(|c| head.place[c] + cut * step.way[c]);
            segment.reach *= cut;
        }
        lines.lay(segment);
        trace.length += segment.reach;
        head.steps += 1;
        if let Some(met) = met {
            trace.ended = Ended::AtLine;
            trace.other = met.line;
            continue;
        }
        let side = 3 * head.triangle + step.side;
        let Ok(beyond) = usize::try_from(field.across[side]) else {
            trace.ended = Ended::AtBorder;
            trace.other = side as i32;
            trace.there = step.share;
            continue;
        };
        if trace.length > limits.longest {
            continue;
        }
        head.cross(field, side, beyond, step.share);
        waiting.push(trace.length, i);
    }
    (lines.segments, traces)
}

/// Where a trace has come to.
struct Head {
    triangle: usize,
    place: Place,
    angle: f64,
    direction: i32,
    /// The sides of the triangle by which it may leave.
    ways_out: [bool; 3],
    steps: usize,
}

/// A step of a trace through a triangle.
struct Step {
    /// The side by which it leaves, 0 to 2.
    side: usize,
    /// Where on the side, from 0 to 1.
    share: f64,
    end: Place,
    /// From the beginning to the end.
    way: Place,
    size: f64,
}

impl Head {
    fn new(start: &Start) -> Head {
        let across = (start.corner as usize + 1) % 3;
        Head {
            triangle: start.triangle as usize,
            place: start.place,
            angle: start.angle,
            direction: start.direction,
            ways_out: [0, 1, 2].map(|e| e == across),
            steps: 0,
        }
    }

    /// Return the way to where the trace leaves its triangle; None where it does not.
    fn find_step(&self, field: &CrossField) -> Option<Step> {
        let [px, py] = self.place;
        let (dx, dy) = (self.angle.cos(), self.angle.sin());
        let (mut far, mut leaving) = (f64::INFINITY, None);
        for side in (0..3).filter(|&e| self.ways_out[e]) {
            let [[ax, ay], [bx, by]] = field.side(self.triangle, side);
            let (wx, wy) = (bx - ax, by - ay);
            let size = dx * wy - dy * wx;
            if size == 0.0 {
                continue;
            }
            let t = ((ax - px) * wy - (ay - py) * wx) / size;
            let s = ((ax - px) * dy - (ay - py) * dx) / size;
            if t > 0.0 && (-1e-6..=1.0 + 1e-6).contains(&s) && t < far {
                far = t;
                leaving = Some((side, s));
            }
        }
        let (side, share) = leaving?;
        let share = min(max(share, OFF_ENDS), 1.0 - OFF_ENDS);
        let end = interpolate(field.side(self.triangle, side), share);
        let way = [end[0] - px, end[1] - py];
        let size = (way[0] * way[0] + way[1] * way[1]).sqrt();
        (size != 0.0).then_some(Step {
            side,
            share,
            end,
            way,
            size,
        })
    }

    /// Go on into the next triangle.
    fn cross(&mut self, field: &CrossField, side: usize, beyond: usize, share: f64) {
        let (triangle, into) = (beyond / 3, beyond % 3);
        self.direction -= field.quarters[side];
        let along = field.side_angle[triangle][into];
        self.angle = field.angle[triangle] + f64::from(self.direction) * (PI / 2.0);
        let over = (self.angle - along).rem_euclid(2.0 * PI);
        if !(LEAST_ANGLE < over && over < PI - LEAST_ANGLE) {
            let turns_back = (PI / 2.0..=1.5 * PI).contains(&over);
            self.angle = along
                + if turns_back {
                    PI - LEAST_ANGLE
                } else {
                    LEAST_ANGLE
                };
        }
        self.triangle = triangle;
        let [a, b] = field.side(triangle, into);
        self.place = interpolate([b, a], share);
        self.ways_out = [0, 1, 2].map(|e| e != into);
    }
}

fn interpolate([a, b]: [Place; 2], share: f64) -> Place {
    [0, 1].map(|c| a[c] + share * (b[c] - a[c]))
}

/// All lines, with those in each triangle linked, the last one first.
struct Lines {
    segments: Vec<LineSegment>,
    /// Of each segment the one before it in its triangle.
    before: Vec<Option<u32>>,
    /// Of each triangle its last segment.
    last: Vec<Option<u32>>,
}

/// Where a step meets a line.
struct Meeting {
    line: i32,
    /// The part of the step up to there.
    cut: f64,
    /// How far along the line.
    there: f64,
    /// Does the step come from the line's left?
    left: bool,
}

impl Lines {
    fn new(n_triangles: usize) -> Lines {
        Lines {
            segments: Vec::new(),
            before: Vec::new(),
            last: vec![None; n_triangles],
        }
    }

    fn lay(&mut self, segment: LineSegment) {
        let last = &mut self.last[segment.triangle as usize];
        self.before.push(*last);
        *last = Some(self.segments.len() as u32);
        self.segments.push(segment);
    }

    /// Return where a trace's next segment first meets a line in its triangle.
    fn meet(&self, next: &LineSegment, step: &Step, begins: bool) -> Option<Meeting> {
        let [px, py] = next.begin;
        let [ux, uy] = step.way;
        // Beginnings at one vertex touch there, and do not meet.
        let least = if begins { 1e-6 } else { -1e-9 };
        let mut found: Option<Meeting> = None;
        let mut at = self.last[next.triangle as usize];
        while let Some(k) = at {
            at = self.before[k as usize];
            let other = &self.segments[k as usize];
            // What a trace has just left behind itself is not met.
            if other.line == next.line && next.along - other.along < 8.0 * step.size {
                continue;
            }
            let (vx, vy) = (other.end[0] - other.begin[0], other.end[1] - other.begin[1]);
            let size = ux * vy - uy * vx;
            if size == 0.0 {
                continue;
            }
            let (ox, oy) = (other.begin[0] - px, other.begin[1] - py);
            let t = (ox * vy - oy * vx) / size;
            let s = (ox * uy - oy * ux) / size;
            if (least..=1.0 + 1e-9).contains(&t)
                && (-1e-6..=1.0 + 1e-6).contains(&s)
                && found.as_ref().is_none_or(|found| t < found.cut)
            {
                found = Some(Meeting {
                    line: other.line,
                    cut: t,
                    there: other.along + min(max(s, 0.0), 1.0) * other.reach,
                    left: size > 0.0,
                });
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of two triangles: side 1 of the first is side 0 of the second.
    const FIELD: CrossField = CrossField {
        flat: &[
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            [[0.0, 1.0], [1.0, 0.0], [1.0, 1.0]],
        ],
        side_angle: &[[0.0, 0.75 * PI, -0.5 * PI], [-0.25 * PI, 0.5 * PI, PI]],
        across: &[-1, 3, -1, 1, -1, -1],
        angle: &[0.0, 0.0],
        quarters: &[0; 6],
    };

    const LIMITS: Limits = Limits {
        first: 1,
        longest: 10.0,
        stopping: true,
    };

    const START: Start = Start {
        triangle: 0,
        corner: 0,
        place: [0.0, 0.0],
        angle: 0.25 * PI,
        direction: 0,
    };

    #[test]
    fn a_trace_ends_at_the_border() {
        let (segments, traces) = trace_all(&FIELD, &[START], &[], &LIMITS);
        assert_eq!(segments.len(), 2);
        let trace = traces[0];
        assert_eq!((trace.ended, trace.other), (Ended::AtBorder, 4));
        assert!((trace.there - 0.5).abs() < 1e-12);
        assert!((trace.length - (0.5_f64.sqrt() + 0.5)).abs() < 1e-12);
    }

    #[test]
    fn a_trace_ends_at_a_wall() {
        let wall = LineSegment {
            line: 0,
            triangle: 0,
            begin: [0.0, 0.25],
            end: [1.0, 0.25],
            along: 2.0,
            reach: 1.0,
        };
        let (segments, traces) = trace_all(&FIELD, &[START], &[wall], &LIMITS);
        assert_eq!(segments.len(), 2);
        let trace = traces[0];
        assert_eq!(
            (trace.ended, trace.other, trace.left),
            (Ended::AtLine, 0, false)
        );
        assert!((trace.there - 2.25).abs() < 1e-12);
    }
}
