//! The half section Z ≥ 0 of a tube as a strip of straight columns, one of which is the cut.
//!
//! A column leads from a point of the inner line to a point of the outer contour. It is named by q (in outer radii): q = 0 is
//! the cut, q < 0 is the part that the notch keeps, up to q = −H at the top, q > 0 is what the notch takes away, down to the
//! bottom. The inner line runs along the axis Z = 0 where there is no bore and along the bore elsewhere; its parameter w is
//!
//!   w < 0: (Y_bore top − w, 0)     0 ≤ w ≤ π: the bore at angle w     w > π: (Y_bore bottom − (w − π), 0)
//!
//! (without a bore, the axis follows the axis, with 0 in place of π).
//! A plane cut is the column of all points at Y = α; where a fillet or the lack of a bore asks for it, its neighbours are level too.
//! A radial cut is a column at one angle, and so are its neighbours.

use crate::contour::Contour;
use std::f64::consts::PI;

/// A column: where it starts on the inner line, and the angle of its end on the outer contour.
#[derive(Clone, Copy, Debug)]
struct Column {
    inner: f64,
    outer: f64,
}

/// A column and its place.
#[derive(Clone, Copy, Debug)]
struct Station {
    q: f64,
    column: Column,
    /// Columns from here to the next station are level.
    level: bool,
}

/// The strip.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    outer: Contour,
    bore: Contour,
    /// Y of a plane cut.
    level: f64,
    /// Where the parameter of the inner line leaves the bore: π, or 0 without one.
    turn: f64,
    /// From the cut to here the column q lies at Y = α − q.
    fillet: f64,
    /// Columns between which others are interpolated, by rising q.
    stations: Vec<Station>,
}

impl Section {
    /// A plane cut at Y = `level`; columns down to q = `fillet` are level.
    pub fn plane(outer: Contour, bore: Contour, level: f64, fillet: f64) -> Self {
        let rod = bore.inradius <= 0.0;
        let turn = if rod { 0.0 } else { PI };
        let mut own = Self { outer, bore, level, turn, fillet, stations: Vec::new() };
        let (top, bottom) = (bore.top(), -bore.inradius);
        let wall = outer.inradius - bore.inradius;
        let cut = own.level_column(level);
        // Where next to nothing of the bore's contour is kept, or taken away, columns fanning out from it would be needles.
        let flat_top = bore.sides.is_some_and(|n| n % 2 == 0);
        let kept_bore = bore.inradius * cut.inner.max(0.0);
        if level > top * (1.0 + 1e-9) || rod || (!flat_top && kept_bore <= wall) {
            let path = own.level_path(outer.top(), level);
            own.place(&path, 0.0, true, true);
        } else {
            let mut path = vec![Column { inner: 0.0, outer: 0.0 }];
            if cut.inner > PI {
                let tangent = outer.angle_at(bottom);
                own.flat_corner(&mut path, PI, tangent);
                path.push(Column { inner: PI, outer: 0.5 * (tangent + cut.outer) });
            }
            path.push(cut);
            let path = own.with_corners(&path);
            own.place(&path, 0.0, true, false);
        }
        let end = level - fillet;
        let start = own.level_column(end);
        let taken_bore = bore.inradius * (PI - start.inner).max(0.0);
        if end <= -outer.inradius * (1.0 - 1e-9) {
            // The fillet ends at the outer surface.
            own.stations.push(Station { q: fillet, column: start, level: true });
        } else if level < bottom * (1.0 + 1e-9) || rod || (bore.sides.is_none() && taken_bore <= wall) {
            let path = own.level_path(end, -outer.inradius);
            own.place(&path, fillet, false, true);
        } else {
            let mut path = vec![start];
            if start.inner < 0.0 {
                let tangent = outer.angle_at(top);
                path.push(Column { inner: 0.0, outer: 0.5 * (tangent + start.outer) });
                own.flat_corner(&mut path, 0.0, tangent);
            }
            path.push(Column { inner: start.inner.max(PI), outer: PI });
            let path = own.with_corners(&path);
            own.place(&path, fillet, false, false);
        }
        own
    }

    /// A radial cut that meets the outer contour at Y = `level`.
    pub fn radial(outer: Contour, bore: Contour, level: f64) -> Self {
        let mut own = Self { outer, bore, level, turn: PI, fillet: 0.0, stations: Vec::new() };
        let cut = outer.angle_at(level);
        let mut angles = vec![0.0, cut, PI];
        angles.extend(outer.corners());
        angles.sort_by(f64::total_cmp);
        angles.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        let station = |angle: f64| Station {
            q: outer.inradius * (angle - cut),
            column: Column { inner: angle, outer: angle },
            level: false,
        };
        own.stations = angles.into_iter().map(station).collect();
        own
    }

    /// Places of the columns at which an edge of elements is wanted, rising from the top to the bottom; 0 is among them.
    pub fn breaks(&self) -> Vec<f64> {
        let mut breaks: Vec<f64> = self.stations.iter().map(|s| s.q).collect();
        breaks.push(0.0);
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        breaks
    }

    /// Length of the longest column.
    pub fn width(&self) -> f64 {
        let breaks = self.breaks();
        let (first, last) = (breaks[0], breaks[breaks.len() - 1]);
        (0..=64)
            .map(|i| {
                let q = first + (last - first) * f64::from(i) / 64.0;
                let ([y, z], [v, w]) = (self.point(q, 0.0), self.point(q, 1.0));
                (v - y).hypot(w - z)
            })
            .fold(0.0, f64::max)
    }

    /// The point (Y, Z) at the share η of a column.
    pub fn point(&self, q: f64, eta: f64) -> [f64; 2] {
        let column = self.column(q);
        let (inner, outer) = (self.inner(column.inner), self.outer.point(column.outer));
        [inner[0] + eta * (outer[0] - inner[0]), inner[1] + eta * (outer[1] - inner[1])]
    }

    fn column(&self, q: f64) -> Column {
        if q >= 0.0 && q <= self.fillet && self.fillet > 0.0 {
            return self.level_column(self.level - q);
        }
        let next = self.stations.partition_point(|s| s.q < q).clamp(1, self.stations.len() - 1);
        let (a, b) = (self.stations[next - 1], self.stations[next]);
        let share = ((q - a.q) / (b.q - a.q)).clamp(0.0, 1.0);
        let between = Column {
            inner: a.column.inner + share * (b.column.inner - a.column.inner),
            outer: a.column.outer + share * (b.column.outer - a.column.outer),
        };
        if !a.level {
            between
        } else if between.inner > 0.0 && between.inner < self.turn {
            // By the bore, whose angle changes faster than the outer one where the bore starts.
            let outer = self.outer.angle_at(self.bore.point(between.inner)[0]);
            Column { outer, ..between }
        } else {
            self.level_column(self.outer.point(between.outer)[0])
        }
    }

    /// The column at a level Y.
    fn level_column(&self, level: f64) -> Column {
        let inner = if level > self.bore.top() * (1.0 + 1e-9) {
            self.bore.top() - level
        } else if level < -self.bore.inradius * (1.0 + 1e-9) {
            self.turn - self.bore.inradius - level
        } else if self.turn <= 0.0 {
            0.0
        } else {
            self.bore.angle_at(level)
        };
        Column { inner, outer: self.outer.angle_at(level) }
    }

    /// Level columns from one level down to another, with those at corners and at the ends of the bore.
    fn level_path(&self, from: f64, to: f64) -> Vec<Column> {
        let mut levels = vec![from, to, self.bore.top(), -self.bore.inradius];
        levels.extend(self.outer.corners().into_iter().map(|angle| self.outer.point(angle)[0]));
        levels.extend(self.bore.corners().into_iter().map(|angle| self.bore.point(angle)[0]));
        levels.retain(|l| *l <= from + 1e-12 && *l >= to - 1e-12);
        levels.sort_by(|a, b| b.total_cmp(a));
        levels.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        levels.into_iter().map(|level| self.level_column(level)).collect()
    }

    fn inner(&self, parameter: f64) -> [f64; 2] {
        if parameter < 0.0 {
            [self.bore.top() - parameter, 0.0]
        } else if parameter > self.turn {
            [-self.bore.inradius - (parameter - self.turn), 0.0]
        } else {
            self.bore.point(parameter)
        }
    }

    /// From the axis along a flat of the bore that lies towards the cut: no column may cross the bore, so that the corner at its end looks level.
    fn flat_corner(&self, path: &mut Vec<Column>, end: f64, tangent: f64) {
        if let Some(n) = self.bore.sides
            && (end > 0.0 || n % 2 == 0)
        {
            let corner = (end - PI / f64::from(n)).abs();
            path.push(Column { inner: corner, outer: tangent });
        }
    }

    /// The path with a column at every corner of bore and outer contour: from corner to corner where both lie within.
    fn with_corners(&self, path: &[Column]) -> Vec<Column> {
        let mut all = vec![path[0]];
        for pair in path.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let inside = |angle: f64, from: f64, to: f64| angle > from + 1e-9 && angle < to - 1e-9;
            let mut own: Vec<Column> = Vec::new();
            let mut single: Vec<Column> = Vec::new();
            for corner in self.outer.corners() {
                let (inner, outer) = (inside(corner, a.inner, b.inner), inside(corner, a.outer, b.outer));
                let share = |from: f64, to: f64| (corner - from) / (to - from);
                if inner && outer && self.bore.inradius > 0.0 {
                    own.push(Column { inner: corner, outer: corner });
                } else if outer {
                    let inner = a.inner + share(a.outer, b.outer) * (b.inner - a.inner);
                    single.push(Column { inner, outer: corner });
                } else if inner {
                    let outer = a.outer + share(a.inner, b.inner) * (b.outer - a.outer);
                    single.push(Column { inner: corner, outer });
                }
            }
            // A lone corner must not pass a pair of corners.
            single.retain(|s| {
                own.iter()
                    .all(|p| (s.inner > p.inner) == (s.outer > p.outer) && (s.outer - p.outer).abs() > 1e-3)
            });
            own.extend(single);
            own.sort_by(|p, q| p.outer.total_cmp(&q.outer));
            all.extend(own);
            all.push(b);
        }
        all
    }

    /// Gives the columns of a path places from `at` on or, backwards, up to `at`.
    fn place(&mut self, path: &[Column], at: f64, backwards: bool, level: bool) {
        let length = |a: &Column, b: &Column| {
            let (p, q) = (self.inner(a.inner), self.inner(b.inner));
            let (v, w) = (self.outer.point(a.outer), self.outer.point(b.outer));
            0.5 * ((p[0] - q[0]).hypot(p[1] - q[1]) + (v[0] - w[0]).hypot(v[1] - w[1]))
        };
        let arc = |a: &Column, b: &Column| {
            let mid = |s: f64| Column {
                inner: a.inner + s * (b.inner - a.inner),
                outer: a.outer + s * (b.outer - a.outer),
            };
            (0..16).map(|i| length(&mid(f64::from(i) / 16.0), &mid(f64::from(i + 1) / 16.0))).sum::<f64>()
        };
        let steps: Vec<f64> = path.windows(2).map(|pair| arc(&pair[0], &pair[1])).collect();
        let mut q = if backwards { at - steps.iter().sum::<f64>() } else { at };
        let mut placed = vec![Station { q, column: path[0], level }];
        for (column, step) in path[1..].iter().zip(steps) {
            q += step;
            placed.push(Station { q, column: *column, level });
        }
        if let (true, Some(last)) = (backwards, placed.last_mut()) {
            last.q = at;
        }
        self.stations.extend(placed);
    }
}
