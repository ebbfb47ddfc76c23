//! Saint-Venant torsion constant J_t (m⁴) of the notched sections of [`super::section`].
//!
//! Prandtl's stress function solves ∇²ϕ = −2 with ϕ = 0 on the outer boundary and, where a whole bore of area
//! A_h remains, ϕ = c on its edge with c left free. Then J_t = 2 ∫ϕ dA + 2 c A_h, which is also the greatest
//! value of 2 ∫ 2ϕ dA + 4 c A_h − ∫|∇ϕ|² dA over all admissible ϕ (Timoshenko and Goodier, art. 107 and 115).
//!
//! The half Z ≥ 0 of the section is a strip between an inner and an outer line: s runs along it from the top
//! (Y axis) to the cut, or to the bottom where the ring is closed, and straight columns 0 ≤ η ≤ 1 lead from
//! the inner to the outer line. Where no bore is left, the inner line shrinks to the middle of the cut. On this
//! strip ϕ is a sum of products of integrated Legendre polynomials in s and η on exactly mapped elements (a
//! p-version Ritz method), which gives J_t from below, with an error that falls with the square of the error in
//! ∇ϕ. Across a thin wall ϕ is a parabola, which the basis contains, so that thin walls cost nothing; along
//! the strip ϕ changes within about one wall thickness of a corner, where elements are made short.

use super::section::{Contour, Outline, above, real};
use gauss_quad::GaussLegendre;
use std::num::NonZeroUsize;

/// Degrees along and across the strip of a round section. Doubling them moves J_t by less than 1e-4 for ρ/ρ̄ from
/// 0 to 0.99 at any depth, except for 1.4e-4 where the notch just reaches a bore of 0.02 ρ̄.
const ROUND_DEGREES: [usize; 2] = [10, 10];
/// Degrees for polygons of few columns. At the corners of a bore ∇ϕ grows as d^(λ − 1), λ = n/(n + 2), with the
/// distance d from the corner. With the short elements there, doubling the degrees moves J_t by less than 1e-3
/// for a triangular bore, 4e-4 for a square one, 2e-4 for more sides, and 6e-5 without a bore.
const POLYGON_DEGREES: [usize; 2] = [6, 6];
/// Elements across a polygonal ring end at these η: short ones at the bore.
const POLYGON_LAYERS: [f64; 3] = [0.0, 0.15, 1.0];
/// Most columns between blocks for which corners get elements of their own; a closed ring of 12 sides has as
/// many. With more columns, corners are so blunt (λ > 0.86) that doubling the degrees still moves J_t by less
/// than 1e-3 (ρ/ρ̄ = 0.98), and 3e-4 for ρ/ρ̄ ≤ 0.9.
const SHARP_COLUMNS: usize = 9;
/// Degrees for up to [`MANY_COLUMNS`] columns, and for more, where a side spans so little that 2 suffices.
const BLUNT_DEGREES: [[usize; 2]; 2] = [[4, 8], [2, 8]];
const MANY_COLUMNS: usize = 48;
/// Elements along a round section without a bore, whose columns fan out from the middle of the cut.
const FAN_ELEMENTS: usize = 2;
/// Elements along the wall between a cut and a whole round bore.
const BRIDGE_ELEMENTS: usize = 3;
/// Gauss nodes beyond the degree: one more integrates all products of gradients on a parallelogram; the other
/// two are for elements that are none.
const EXTRA_NODES: usize = 3;
/// Blocks shorter than this share of the outer radius are joined to the next one: moving a corner by that much
/// changes J_t by as little, while the Ritz matrix of so short an element would cost nine digits.
const SHORT: f64 = 1e-9;

/// A point or a vector (Y, Z) (m).
type Vector = [f64; 2];

/// Torsion constant (m⁴) of the section with a notch of the given depth (m). Dimensions must have been checked.
/// None where the Ritz matrix is singular to working precision.
pub(super) fn torsion_constant(outline: &Outline, depth: f64) -> Option<f64> {
    strip(outline, depth).torsion_constant()
}

/// One of the two lines that a block lies between, with parameter 0 ≤ u ≤ 1 towards the cut.
#[derive(Clone, Copy, Debug)]
enum Line {
    /// Straight.
    Straight { from: Vector, to: Vector },
    /// About the centre, between two angles from +Y.
    Arc { radius: f64, from: f64, to: f64 },
    /// Half of the cut, from its end to its middle.
    Chord(Chord),
    /// Radial projection of such a chord on a circle.
    Shadow { radius: f64, chord: Chord },
}

/// Half of a cut at Y = α below a bore: Z = b sinh(σ), σ falling uniformly to zero.
///
/// The wall left under a round bore grows as 1 + (Z/b)², where b is the half length of the tangent from the
/// bore's lowest level; its poles at Z = ± i b would spoil a polynomial in Z, but not one in σ.
#[derive(Clone, Copy, Debug)]
struct Chord {
    alpha: f64,
    scale: f64,
    sigma: f64,
}

impl Chord {
    fn new(alpha: f64, half_length: f64, scale: f64) -> Self {
        Self { alpha, scale, sigma: (half_length / scale).asinh() }
    }

    /// Z and its derivative with respect to u.
    fn at(self, u: f64) -> [f64; 2] {
        let sigma = self.sigma * (1.0 - u);
        [self.scale * sigma.sinh(), -self.scale * self.sigma * sigma.cosh()]
    }
}

impl Line {
    /// Position and its derivative with respect to u.
    fn at(self, u: f64) -> (Vector, Vector) {
        match self {
            Self::Straight { from, to } => {
                let along = [to[0] - from[0], to[1] - from[1]];
                ([from[0] + u * along[0], from[1] + u * along[1]], along)
            }
            Self::Arc { radius, from, to } => {
                let (sin, cos) = (from + u * (to - from)).sin_cos();
                let speed = radius * (to - from);
                ([radius * cos, radius * sin], [-speed * sin, speed * cos])
            }
            Self::Chord(chord) => {
                let [z, dz] = chord.at(u);
                ([chord.alpha, z], [0.0, dz])
            }
            Self::Shadow { radius, chord } => {
                let [z, dz] = chord.at(u);
                let distance = chord.alpha.hypot(z);
                let (cos, sin) = (chord.alpha / distance, z / distance);
                let speed = radius * cos * dz / distance;
                ([radius * cos, radius * sin], [-speed * sin, speed * cos])
            }
        }
    }
}

/// Part of the strip on which both lines are smooth, cut into elements at the given parameters.
#[derive(Clone, Debug)]
struct Block {
    inner: Line,
    outer: Line,
    breaks: Vec<f64>,
}

/// The half section as a strip.
#[derive(Clone, Debug)]
struct Strip {
    blocks: Vec<Block>,
    /// Half the area of the bore where its edge is whole; none where the strip ends at the cut, with ϕ = 0.
    half_hole: Option<f64>,
    /// Elements across the strip end at these η.
    layers: Vec<f64>,
    /// Degrees along and across the strip.
    degrees: [usize; 2],
}

fn strip(outline: &Outline, depth: f64) -> Strip {
    let (outer, inner) = outline.contours();
    let alpha = outline.cut(depth);
    match outer.sides {
        None => round_strip(outer.inradius, inner.inradius, alpha),
        Some(_) => polygon_strip(&outer, &inner, alpha),
    }
}

fn round_strip(outer: f64, inner: f64, alpha: f64) -> Strip {
    // Half the angle that the cut leaves of a circle, as in the moments of a disk.
    let reach = |radius: f64| 2.0 * (radius - alpha).max(0.0).sqrt().atan2((radius + alpha).max(0.0).sqrt());
    let arc = |radius: f64, from: f64, to: f64| Line::Arc { radius, from, to };
    let end = reach(outer);
    let (blocks, half_hole) = if inner <= 0.0 || alpha >= inner {
        let middle = Line::Straight { from: [alpha, 0.0], to: [alpha, 0.0] };
        (vec![Block { inner: middle, outer: arc(outer, 0.0, end), breaks: uniform(FAN_ELEMENTS) }], None)
    } else if alpha >= -inner * (1.0 + 4.0 * f64::EPSILON) {
        let wall = (outer * end.sin() - inner * reach(inner).sin()).abs();
        let breaks = vec![0.0, 1.0 - layer(wall, outer * end), 1.0];
        (vec![Block { inner: arc(inner, 0.0, reach(inner)), outer: arc(outer, 0.0, end), breaks }], None)
    } else {
        let half_length = outer * end.sin();
        let breaks = vec![0.0, 1.0 - layer(outer - inner, outer * end), 1.0];
        let mut blocks = vec![Block { inner: arc(inner, 0.0, end), outer: arc(outer, 0.0, end), breaks }];
        if half_length > SHORT * outer {
            let scale = ((-alpha - inner) * (inner - alpha)).sqrt();
            let chord = Chord::new(alpha, half_length, scale);
            blocks.push(Block {
                inner: Line::Shadow { radius: inner, chord },
                outer: Line::Chord(chord),
                breaks: uniform(BRIDGE_ELEMENTS),
            });
        }
        (blocks, Some(0.5 * std::f64::consts::PI * inner * inner))
    };
    Strip { blocks, half_hole, layers: vec![0.0, 1.0], degrees: ROUND_DEGREES }
}

/// The columns at the vertices and at the ends of the strip fix its blocks.
fn polygon_strip(outer: &Contour, inner: &Contour, alpha: f64) -> Strip {
    let solid = inner.inradius <= 0.0 || alpha >= inner.top();
    let outside = above(outer, alpha);
    let inside = if solid { vec![[alpha, 0.0]] } else { above(inner, alpha) };
    let closed = !solid && inside[inside.len() - 1][0] > alpha;
    let mut columns: Vec<[Vector; 2]> = Vec::new();
    if closed {
        let corner = outside.len() - 1;
        columns.extend((0..corner).map(|k| [inside[k], outside[k]]));
        // Radial columns: at the end of the cut the two outlines are similar; below it the outer one is the cut.
        let ratio = inner.inradius / outer.inradius;
        columns.push([outside[corner].map(|v| ratio * v), outside[corner]]);
        columns.extend(inside[corner..].iter().map(|&p| [p, p.map(|v| v * alpha / p[0])]));
    } else {
        // Vertices that only one outline keeps face the end of the other: seen from there, all lie outside.
        let facing = |path: &[Vector], k: usize| path[k.min(path.len() - 1)];
        let count = inside.len().max(outside.len());
        columns.extend((0..count).map(|k| [facing(&inside, k), facing(&outside, k)]));
    }
    let sharp = columns.len() <= SHARP_COLUMNS;
    // In a fan the scale of the corners is its height, not the length of the columns.
    let apart = |a: Vector, b: Vector| (a[0] - b[0]).hypot(a[1] - b[1]);
    let height = outer.top() - alpha;
    let wall = |column: [Vector; 2]| if solid { height } else { apart(column[0], column[1]) };
    let mut blocks = Vec::new();
    let mut start = columns[0];
    // The strip begins at a corner if the number of sides is odd.
    let mut at_corner = outer.sides.is_some_and(|n| n % 2 == 1);
    for (k, &end) in columns.iter().enumerate().skip(1) {
        let length = apart(start[0], end[0]).max(apart(start[1], end[1]));
        if length <= SHORT * outer.inradius {
            continue;
        }
        let (first, last) = (wall(start), wall(end));
        let tapered = first.max(last) > 2.0 * first.min(last);
        let breaks = if sharp || tapered || k == columns.len() - 1 {
            graded(length, first, last, at_corner)
        } else {
            vec![0.0, 1.0]
        };
        let line = |side: usize| Line::Straight { from: start[side], to: end[side] };
        blocks.push(Block { inner: line(0), outer: line(1), breaks });
        start = end;
        at_corner = true;
    }
    let half_hole =
        closed.then(|| 0.5 * inside.windows(2).map(|p| p[0][0] * p[1][1] - p[1][0] * p[0][1]).sum::<f64>());
    let width = outside.iter().fold(0.0_f64, |widest, p| widest.max(p[1]));
    let (layers, degrees) = if sharp && solid {
        (vec![0.0, 1.0 - layer(height, width), 1.0], POLYGON_DEGREES)
    } else if sharp {
        (POLYGON_LAYERS.to_vec(), POLYGON_DEGREES)
    } else {
        (vec![0.0, 1.0], BLUNT_DEGREES[usize::from(columns.len() > MANY_COLUMNS)])
    };
    Strip { blocks, half_hole, layers, degrees }
}

fn uniform(count: usize) -> Vec<f64> {
    (0..=count).map(|k| real(k) / real(count)).collect()
}

/// Share of a length that a layer of two walls takes at its end: half of it at most, and smooth in both.
fn layer(wall: f64, length: f64) -> f64 {
    1.0 / (2.0 + length / (2.0 * wall))
}

/// Breaks of a block with layers at its end and, if asked for, at its start.
fn graded(length: f64, first: f64, last: f64, at_start: bool) -> Vec<f64> {
    if at_start {
        let half = 0.5 * length;
        vec![0.0, 0.5 * layer(first, half), 0.5, 1.0 - 0.5 * layer(last, half), 1.0]
    } else {
        vec![0.0, 1.0 - layer(last, length), 1.0]
    }
}

/// Shape functions on [0, 1] at the nodes of a quadrature rule: 1 − x, x, then integrated Legendre polynomials
/// (P_k − P_{k−2}) / √(2 (2k − 1)), which vanish at both ends; last, the constant 1.
struct Shapes {
    nodes: Vec<(f64, f64)>,
    /// Value and derivative, by node and function.
    table: Vec<Vec<[f64; 2]>>,
}

impl Shapes {
    fn new(degree: usize) -> Self {
        let count = NonZeroUsize::MIN.saturating_add(degree + EXTRA_NODES - 1);
        let nodes: Vec<(f64, f64)> =
            GaussLegendre::new(count).iter().map(|&(x, w)| (0.5 * (x + 1.0), 0.5 * w)).collect();
        let table = nodes.iter().map(|&(x, _)| shape_functions(degree, x)).collect();
        Self { nodes, table }
    }
}

fn shape_functions(degree: usize, x: f64) -> Vec<[f64; 2]> {
    let xi = 2.0 * x - 1.0;
    let mut legendre = vec![1.0, xi];
    for k in 2..=degree {
        let next = (real(2 * k - 1) * xi * legendre[k - 1] - real(k - 1) * legendre[k - 2]) / real(k);
        legendre.push(next);
    }
    let bubble = |k: usize| {
        let root = (2.0 * real(2 * k - 1)).sqrt();
        [(legendre[k] - legendre[k - 2]) / root, root * legendre[k - 1]]
    };
    [[1.0 - x, -1.0], [x, 1.0]].into_iter().chain((2..=degree).map(bubble)).chain([[1.0, 0.0]]).collect()
}

/// Number of a shape function of an element among those of all elements in a row, ordered along the row.
fn place(element: usize, function: usize, degree: usize) -> usize {
    match function {
        0 => element * degree,
        1 => (element + 1) * degree,
        k => element * degree + k - 1,
    }
}

impl Strip {
    fn torsion_constant(&self) -> Option<f64> {
        let [along, across] = self.degrees;
        let shapes = [Shapes::new(along), Shapes::new(across)];
        let elements: usize = self.blocks.iter().map(|b| b.breaks.len() - 1).sum();
        // Functions along the strip but for the one that does not vanish at the cut; those across it that
        // vanish at both lines; last, the value c on the edge of the bore: c (1 − η) on the first layer.
        let rows = elements * along + usize::from(self.half_hole.is_some());
        let width = (self.layers.len() - 1) * across - 1;
        let size = rows * width + usize::from(self.half_hole.is_some());
        let mut system = Envelope::new(size);
        let spans =
            self.blocks.iter().flat_map(|block| block.breaks.windows(2).map(move |span| (block, span)));
        for (element, (block, span)) in spans.enumerate() {
            for (index, layer) in self.layers.windows(2).enumerate() {
                let number = |i: usize, j: usize| {
                    if i > along || j > across {
                        let edge = i > along && j == 0 && index == 0 && self.half_hole.is_some();
                        return edge.then(|| size - 1);
                    }
                    let (row, column) = (place(element, i, along), place(index, j, across));
                    (row < rows && (1..=width).contains(&column)).then(|| row * width + column - 1)
                };
                let metric = metric(block, span, layer, &shapes)?;
                integrate(&metric, &shapes, number, &mut system);
            }
        }
        if let Some(half_hole) = self.half_hole {
            system.load[size - 1] += 2.0 * half_hole;
        }
        // The stationary value is loadᵀ K⁻¹ load for the half section.
        Some(2.0 * system.solve()?)
    }
}

/// Weighted at every node of an element (across first): the coefficients of ϕ_s², ϕ_s ϕ_η and ϕ_η² in |∇ϕ|² dA,
/// s and η being local, and dA. None where the columns cross.
fn metric(
    block: &Block,
    span: &[f64],
    layer: &[f64],
    [along, across]: &[Shapes; 2],
) -> Option<Vec<[f64; 4]>> {
    let (du, de) = (span[1] - span[0], layer[1] - layer[0]);
    let mut metric = Vec::with_capacity(along.nodes.len() * across.nodes.len());
    for &(x, weight_x) in &along.nodes {
        let (low, low_s) = block.inner.at(span[0] + du * x);
        let (high, high_s) = block.outer.at(span[0] + du * x);
        let column = [de * (high[0] - low[0]), de * (high[1] - low[1])];
        for &(y, weight_y) in &across.nodes {
            let eta = layer[0] + de * y;
            let step = [0, 1].map(|k| du * ((1.0 - eta) * low_s[k] + eta * high_s[k]));
            let jacobian = column[0] * step[1] - column[1] * step[0];
            if jacobian.is_nan() || jacobian <= 0.0 {
                return None;
            }
            let (weight, dot) = (weight_x * weight_y, |a: Vector, b: Vector| a[0] * b[0] + a[1] * b[1]);
            let scale = weight / jacobian;
            metric.push([
                scale * dot(column, column),
                -scale * dot(column, step),
                scale * dot(step, step),
                weight * jacobian,
            ]);
        }
    }
    Some(metric)
}

/// Adds ∫∇ϕ_m·∇ϕ_n dA and ∫2ϕ_n dA of one element, for products ϕ_n of function i along and j across, to the
/// rows and columns `number(i, j)`. Summed along the strip first, which leaves few products for each pair.
fn integrate(
    metric: &[[f64; 4]],
    [along, across]: &[Shapes; 2],
    number: impl Fn(usize, usize) -> Option<usize>,
    system: &mut Envelope,
) {
    let (count, heights) = (along.table[0].len(), across.nodes.len());
    let numbers: Vec<Vec<(usize, usize)>> = (0..count)
        .map(|i| (0..across.table[0].len()).filter_map(|j| number(i, j).map(|n| (j, n))).collect())
        .collect();
    for i in (0..count).filter(|&i| !numbers[i].is_empty()) {
        for b in 0..heights {
            let strip = (0..along.nodes.len()).map(|a| along.table[a][i][0] * metric[a * heights + b][3]);
            let load = 2.0 * strip.sum::<f64>();
            for &(j, row) in &numbers[i] {
                system.load[row] += load * across.table[b][j][0];
            }
        }
        for k in (0..=i).filter(|&k| !numbers[k].is_empty()) {
            let sums: Vec<[f64; 4]> = (0..heights)
                .map(|b| {
                    let mut sum = [0.0; 4];
                    for (a, shapes) in along.table.iter().enumerate() {
                        let ([v, dv], [w, dw], g) = (shapes[i], shapes[k], &metric[a * heights + b]);
                        sum[0] += g[0] * dv * dw;
                        sum[1] += g[1] * dv * w;
                        sum[2] += g[1] * v * dw;
                        sum[3] += g[2] * v * w;
                    }
                    sum
                })
                .collect();
            for &(l, column) in &numbers[k] {
                let pulls: Vec<[f64; 2]> = sums
                    .iter()
                    .zip(&across.table)
                    .map(|(s, shapes)| {
                        let [e, de] = shapes[l];
                        [s[0] * e + s[1] * de, s[2] * e + s[3] * de]
                    })
                    .collect();
                for &(j, row) in numbers[i].iter().filter(|(_, row)| i != k || column <= *row) {
                    let mut entry = 0.0;
                    for (pull, shapes) in pulls.iter().zip(&across.table) {
                        entry += shapes[j][0] * pull[0] + shapes[j][1] * pull[1];
                    }
                    system.add(row.max(column), row.min(column), entry);
                }
            }
        }
    }
}

/// Symmetric matrix of which every row is stored from its first entry to the diagonal, and a right-hand side.
struct Envelope {
    first: Vec<usize>,
    rows: Vec<Vec<f64>>,
    load: Vec<f64>,
}

impl Envelope {
    fn new(size: usize) -> Self {
        Self { first: (0..size).collect(), rows: vec![vec![0.0]; size], load: vec![0.0; size] }
    }

    fn add(&mut self, row: usize, column: usize, value: f64) {
        let first = self.first[row];
        if column < first {
            self.rows[row].splice(0..0, std::iter::repeat_n(0.0, first - column));
            self.first[row] = column;
        }
        self.rows[row][column - self.first[row]] += value;
    }

    /// loadᵀ K⁻¹ load by the Cholesky factorisation K = L Lᵀ, as |L⁻¹ load|².
    fn solve(mut self) -> Option<f64> {
        let mut sum = 0.0;
        for i in 0..self.rows.len() {
            let (done, rest) = self.rows.split_at_mut(i);
            let (row, start) = (&mut rest[0], self.first[i]);
            for j in start..i {
                let from = start.max(self.first[j]);
                let dot = product(&row[from - start..j - start], &done[j][from - self.first[j]..]);
                row[j - start] = (row[j - start] - dot) / done[j][j - self.first[j]];
            }
            let (left, pivot) = row.split_at_mut(i - start);
            pivot[0] -= product(left, left);
            if pivot[0].is_nan() || pivot[0] <= 0.0 {
                return None;
            }
            pivot[0] = pivot[0].sqrt();
            self.load[i] = (self.load[i] - product(left, &self.load[start..])) / pivot[0];
            sum += self.load[i] * self.load[i];
        }
        Some(sum)
    }
}

/// Scalar product over the shorter of the two.
fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
