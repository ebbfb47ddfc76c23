//! Lines in px: thinning and cutting at the frame.

/// Lines of more points are thinned.
const MANY: usize = 2000;
/// A tenth of what anti-aliasing can show at four image pixels per px.
const TOLERANCE: f64 = 0.02;
/// Bounds the quadratic worst case of the splitting below.
const CHUNK: usize = 512;

/// Leaves out points that lie within a fiftieth of a px of the remaining polyline (Douglas and
/// Peucker, chunk by chunk). Lines of up to 2000 points come back as they are.
pub(crate) fn thin(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    if points.len() <= MANY {
        return points;
    }
    let mut out = Vec::with_capacity(MANY);
    let mut from = 0;
    while from + 1 < points.len() {
        let to = (from + CHUNK).min(points.len() - 1);
        split(&points[from..=to], &mut out);
        from = to;
    }
    out.extend(points.last());
    out
}

/// Appends the kept points of a chunk except its last.
fn split(points: &[[f64; 2]], out: &mut Vec<[f64; 2]>) {
    let mut keep = vec![false; points.len()];
    keep[0] = true;
    let mut open = vec![(0, points.len() - 1)];
    while let Some((a, b)) = open.pop() {
        let mut worst = (TOLERANCE, 0);
        for i in a + 1..b {
            let d = distance(points[i], points[a], points[b]);
            if d > worst.0 {
                worst = (d, i);
            }
        }
        if worst.1 > 0 {
            keep[worst.1] = true;
            open.push((a, worst.1));
            open.push((worst.1, b));
        }
    }
    out.extend(points.iter().zip(&keep).filter(|(_, k)| **k).map(|(p, _)| *p));
}

/// Distance of a point from a segment.
fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let square = dx * dx + dy * dy;
    let t =
        if square > 0.0 { (((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
    (p[0] - a[0] - t * dx).hypot(p[1] - a[1] - t * dy)
}

/// A rectangle in px.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Rect {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) w: f64,
    pub(crate) h: f64,
}

impl Rect {
    pub(crate) fn contains(&self, p: [f64; 2], slack: f64) -> bool {
        p[0] >= self.x - slack
            && p[0] <= self.x + self.w + slack
            && p[1] >= self.y - slack
            && p[1] <= self.y + self.h + slack
    }

    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        self.x < other.x + other.w
            && other.x < self.x + self.w
            && self.y < other.y + other.h
            && other.y < self.y + self.h
    }
}

/// The pieces of a polyline inside a rectangle (Liang and Barsky).
pub(crate) fn clip(points: &[[f64; 2]], frame: &Rect) -> Vec<Vec<[f64; 2]>> {
    let mut pieces: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut joined = false;
    for pair in points.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let Some((s, t)) = inside(a, b, frame) else {
            joined = false;
            continue;
        };
        let at = |u: f64| [a[0] + u * (b[0] - a[0]), a[1] + u * (b[1] - a[1])];
        if !(joined && s <= 0.0) {
            pieces.push(vec![if s <= 0.0 { a } else { at(s) }]);
        }
        if let Some(piece) = pieces.last_mut() {
            piece.push(if t >= 1.0 { b } else { at(t) });
        }
        joined = t >= 1.0;
    }
    pieces
}

/// Parameters between which the segment a–b lies inside.
fn inside(a: [f64; 2], b: [f64; 2], frame: &Rect) -> Option<(f64, f64)> {
    // Points on the frame itself must not be lost to rounding.
    const SLACK: f64 = 1e-6;
    let (mut s, mut t) = (0.0_f64, 1.0_f64);
    let lows = [frame.x - SLACK, frame.y - SLACK];
    let highs = [frame.x + frame.w + SLACK, frame.y + frame.h + SLACK];
    for k in 0..2 {
        let d = b[k] - a[k];
        for (p, q) in [(-d, a[k] - lows[k]), (d, highs[k] - a[k])] {
            if p < 0.0 {
                s = s.max(q / p);
            } else if p > 0.0 {
                t = t.min(q / p);
            } else if q < 0.0 {
                return None;
            }
        }
    }
    (s <= t).then_some((s, t))
}

/// The part of a polygon inside a rectangle (Sutherland and Hodgman).
pub(crate) fn clip_polygon(mut points: Vec<[f64; 2]>, frame: &Rect) -> Vec<[f64; 2]> {
    let edges =
        [(0, frame.x, 1.0), (0, frame.x + frame.w, -1.0), (1, frame.y, 1.0), (1, frame.y + frame.h, -1.0)];
    for (k, bound, sign) in edges {
        let depth = |p: [f64; 2]| sign * (p[k] - bound);
        let mut next = Vec::with_capacity(points.len() + 4);
        for (i, &b) in points.iter().enumerate() {
            let a = points[(i + points.len() - 1) % points.len()];
            let (da, db) = (depth(a), depth(b));
            if (da < 0.0) != (db < 0.0) {
                let u = da / (da - db);
                next.push([a[0] + u * (b[0] - a[0]), a[1] + u * (b[1] - a[1])]);
            }
            if db >= 0.0 {
                next.push(b);
            }
        }
        points = next;
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_curve() {
        let full: Vec<[f64; 2]> = (0..100_000)
            .map(|i| {
                let u = f64::from(i) / 99_999.0;
                [600.0 * u, 100.0 * (9.0 * u).sin()]
            })
            .collect();
        let few = thin(full.clone());
        assert!(few.len() <= 2000, "{}", few.len());
        assert!(few.first() == full.first() && few.last() == full.last());
        for p in full.iter().step_by(97) {
            let d = few.windows(2).map(|w| distance(*p, w[0], w[1])).fold(f64::MAX, f64::min);
            assert!(d < 0.021, "{d}");
        }
    }

    #[test]
    fn clipping_cuts_at_the_frame() {
        let frame = Rect { x: 0.0, y: 0.0, w: 10.0, h: 10.0 };
        let pieces = clip(&[[-5.0, 5.0], [5.0, 5.0], [5.0, 20.0], [8.0, 20.0], [8.0, 5.0]], &frame);
        assert_eq!(pieces.len(), 2);
        assert!(pieces.iter().flatten().all(|p| frame.contains(*p, 1e-5)));
        let area = clip_polygon(vec![[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]], &frame);
        assert!(area.len() >= 4 && area.iter().all(|p| frame.contains(*p, 1e-9)));
    }
}
