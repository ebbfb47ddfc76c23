//! Bodies built station by station: vertices shared by everything at one abscissa, strips between stations, and
//! faces across the axis.

use crate::contour::Contour;
use crate::mesh::Mesh;
use crate::ring::{Cut, Reach, Sampling};
use cppr::Vector3;
use std::collections::HashMap;

/// Numbers of vertices along a line of a section; neighbours may be the same.
pub(crate) type Chain = Vec<u32>;

/// A section of which a notch keeps a part.
pub(crate) struct Notched {
    outer: Chain,
    bore: Chain,
    /// Middle of the cut where it is one line.
    middle: u32,
    reach: Reach,
}

/// A whole section; its arcs are split where the neighbouring notch ends them.
pub(crate) struct Whole {
    outer: [Chain; 2],
    bore: [Chain; 2],
}

/// A plane across the axis at one abscissa. Points of sections that share it are shared.
pub(crate) struct Station<'a> {
    body: &'a mut Body,
    x: f64,
    turn: [f64; 2],
    known: HashMap<[u64; 2], u32>,
}

/// A body in the making.
#[derive(Default)]
pub(crate) struct Body {
    mesh: Mesh,
}

impl Body {
    /// A new station at abscissa x (m), where the centroid direction is φ (rad).
    pub fn station(&mut self, x: f64, direction: f64) -> Station<'_> {
        let (sin, cos) = direction.sin_cos();
        Station { body: self, x, turn: [cos, sin], known: HashMap::new() }
    }

    /// The finished mesh, without vertices that nothing uses.
    pub fn finish(self) -> Mesh {
        let Mesh { positions, mut triangles } = self.mesh;
        let mut number = vec![None; positions.len()];
        let mut kept = Vec::with_capacity(positions.len());
        for vertex in triangles.iter_mut().flatten() {
            let old = *vertex as usize;
            *vertex = *number[old].get_or_insert_with(|| {
                kept.push(positions[old]);
                index(kept.len() - 1)
            });
        }
        Mesh { positions: kept, triangles }
    }

    fn triangle(&mut self, [a, b, c]: [u32; 3]) {
        if a != b && b != c && c != a {
            self.mesh.triangles.push([a, b, c]);
        }
    }

    fn distance(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a, b].map(|v| Vector3::from(self.mesh.positions[v as usize]));
        (a - b).norm()
    }

    /// Surface between two chains that run the same way. Seen from outside, `from` runs to the right below `to`.
    /// Each facet is divided along its shorter diagonal, which on a winding surface is the one closer to it.
    fn strip(&mut self, from: &[u32], to: &[u32]) {
        for (a, b) in from.windows(2).zip(to.windows(2)) {
            // Equal diagonals all lean the same way, whatever their rounding.
            let rising = self.distance(a[0], b[1]) < self.distance(a[1], b[0]) * (1.0 + 1e-9);
            self.facet([a[0], a[1]], [b[0], b[1]], rising);
        }
    }

    fn facet(&mut self, a: [u32; 2], b: [u32; 2], rising: bool) {
        if rising {
            self.triangle([a[0], a[1], b[1]]);
            self.triangle([a[0], b[1], b[0]]);
        } else {
            self.triangle([a[0], a[1], b[0]]);
            self.triangle([a[1], b[1], b[0]]);
        }
    }

    fn back(&mut self, from: &[u32], to: &[u32]) {
        self.strip(to, from);
    }

    /// Surfaces of a whole stretch between two stations.
    pub fn whole(&mut self, from: &Whole, to: &Whole) {
        for part in 0..2 {
            self.strip(&from.outer[part], &to.outer[part]);
            self.back(&from.bore[part], &to.bore[part]);
        }
    }

    /// Surfaces of a notched stretch between two stations.
    pub fn notched(&mut self, from: &Notched, to: &Notched) {
        self.strip(&from.outer, &to.outer);
        self.back(&from.bore, &to.bore);
        let [a, b] = [from, to].map(Notched::floor);
        // Mirrored diagonals: what one takes from a winding floor, the other adds.
        for side in 0..2 {
            self.facet(a[side], b[side], side == 0);
        }
        // Where the notch breaks through the wall, the wall ends in two facets.
        if (from.reach == Reach::Wall) != (to.reach == Reach::Wall) {
            let [a, b] = [from, to].map(Notched::edge);
            for side in 0..2 {
                self.facet(a[side], b[side], true);
            }
        }
    }

    /// The face that a notch leaves of a whole section; it looks towards the tip if the notch lies there.
    pub fn step(&mut self, whole: &Whole, notched: &Notched, towards_tip: bool) {
        let (outer, e) = (&whole.outer[1], notched.middle);
        let inner = if notched.reach == Reach::Wall { vec![e; outer.len()] } else { whole.bore[1].clone() };
        self.face(outer, &inner, towards_tip);
        if let (Reach::Beyond, [right, .., left], Some(&s)) = (notched.reach, &outer[..], inner.first()) {
            for triangle in [[*right, s, e], [*left, e, s]] {
                self.oriented(triangle, towards_tip);
            }
        }
    }

    fn oriented(&mut self, [a, b, c]: [u32; 3], towards_tip: bool) {
        self.triangle(if towards_tip { [a, b, c] } else { [a, c, b] });
    }

    /// The face between two chains of one station, `outer` farther from the axis.
    fn face(&mut self, outer: &[u32], inner: &[u32], towards_tip: bool) {
        for (o, i) in outer.windows(2).zip(inner.windows(2)) {
            self.oriented([o[0], o[1], i[1]], towards_tip);
            self.oriented([o[0], i[1], i[0]], towards_tip);
        }
    }

    /// The face of a whole section at an end of the body.
    pub fn end(&mut self, whole: &Whole, towards_tip: bool) {
        for part in 0..2 {
            self.face(&whole.outer[part], &whole.bore[part], towards_tip);
        }
    }

    /// The faces at which one whole section ends and another begins: `wide` has the larger outer contour or the smaller
    /// bore, and the faces look away from it.
    pub fn shoulder(&mut self, wide: &Whole, narrow: &Whole, towards_tip: bool) {
        for part in 0..2 {
            self.face(&wide.outer[part], &narrow.outer[part], towards_tip);
            self.face(&narrow.bore[part], &wide.bore[part], towards_tip);
        }
    }
}

/// Number of a vertex; the number of triangles is limited beforehand.
#[expect(clippy::cast_possible_truncation, reason = "far fewer than 2³² vertices")]
pub(crate) fn index(count: usize) -> u32 {
    count as u32
}

impl Whole {
    /// The same ring, all of it kept, sampled from another of its points on: that which `count` others come before.
    pub fn turned(mut self, count: usize) -> Self {
        for [kept, removed] in [&mut self.outer, &mut self.bore] {
            // Closed: the last point is the first again.
            kept.pop();
            let points = kept.len().max(1);
            kept.rotate_left(count % points);
            if let Some(&first) = kept.first() {
                kept.push(first);
                removed.fill(first);
            }
        }
        self
    }
}

impl Station<'_> {
    fn vertex(&mut self, [y, z]: [f64; 2]) -> u32 {
        let [cos, sin] = self.turn;
        let position = [self.x, cos * y - sin * z, sin * y + cos * z];
        // −0 and 0 are one place.
        let key = [(y + 0.0).to_bits(), (z + 0.0).to_bits()];
        let positions = &mut self.body.mesh.positions;
        *self.known.entry(key).or_insert_with(|| {
            positions.push(position);
            index(positions.len() - 1)
        })
    }

    fn chain(&mut self, contour: &Contour, angles: impl Iterator<Item = f64>) -> Chain {
        angles.map(|angle| self.vertex(contour.point(angle))).collect()
    }

    /// The whole section, with the given contours; arcs are split at `cut`.
    pub fn whole(&mut self, sampling: &Sampling, [outer, bore]: [&Contour; 2], cut: [f64; 2]) -> Whole {
        let mut arcs = |contour: &Contour, half: f64| {
            [self.chain(contour, sampling.kept(half)), self.chain(contour, sampling.removed(half))]
        };
        Whole { outer: arcs(outer, cut[0]), bore: arcs(bore, cut[1]) }
    }

    /// What a notch keeps of the section.
    pub fn notched(&mut self, sampling: &Sampling, cut: &Cut) -> Notched {
        let reach = cut.reach(&sampling.bore);
        let outer = self.chain(&sampling.outer, sampling.kept(cut.outer));
        let middle = self.vertex([cut.alpha, 0.0]);
        let bore = match reach {
            Reach::Beyond => vec![middle; outer.len()],
            _ => self.chain(&sampling.bore, sampling.kept(cut.bore)),
        };
        Notched { outer, bore, middle, reach }
    }
}

impl Notched {
    /// First and last vertex of a chain.
    fn ends(chain: &[u32]) -> [u32; 2] {
        [chain.first(), chain.last()].map(|v| v.copied().unwrap_or_default())
    }

    /// Where the cut line ends inside, on the side of −Z and of +Z.
    fn inner_ends(&self) -> [u32; 2] {
        if self.reach == Reach::Wall { [self.middle; 2] } else { Self::ends(&self.bore) }
    }

    /// The two parts of the cut line, anticlockwise seen from the tip.
    fn floor(&self) -> [[u32; 2]; 2] {
        let ([left, right], [inner_left, inner_right]) = (Self::ends(&self.outer), self.inner_ends());
        [[right, inner_right], [inner_left, left]]
    }

    /// From the cut line to the bore and back.
    fn edge(&self) -> [[u32; 2]; 2] {
        let ([inner_left, inner_right], [bore_left, bore_right]) =
            (self.inner_ends(), Self::ends(&self.bore));
        [[inner_right, bore_right], [bore_left, inner_left]]
    }
}
