//! The mesh of a quarter of a cell: 27-node hexahedra that follow wall, cut and fillets.
//!
//! A cell is symmetric about the plane Z = 0 and about the middle of the notch, so that a quarter, Z ≥ 0 and from the middle of
//! the notch (x = 0) to the middle of the tooth (x = (ℓ + t)/2), carries all of it. Elements lie on a grid of x, of the columns q of
//! [`crate::section`], and of η along a column; where notch and q > 0 meet there are none. Lengths are in outer radii.
//!
//! Sizes grow from the corner of the notch as h(d) = s + g d, up to a greatest size. With a fillet of radius r the edge of the
//! corner is moved to the middle of the arc, and the grid around it by as much less as it is farther away: all elements
//! there keep angles near 60° or 90°.

use crate::element::Shape;
use crate::section::Section;
use std::collections::HashMap;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

/// Nodes of an element: 3 along x, times 3 along η, times 3 along q, the last running fastest.
pub(crate) type Element = [u32; 27];

/// Half lengths along the tube, and the fillet, in outer radii.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Profile {
    pub half_notch: f64,
    pub half_tooth: f64,
    pub fillet: f64,
}

/// How fine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fineness {
    /// Size at a sharp corner, in outer radii.
    pub smallest: f64,
    /// Growth of sizes with distance (-).
    pub growth: f64,
    /// Greatest size along x and q.
    pub largest: f64,
    /// Greatest size along a column.
    pub across: f64,
    /// Least number of elements along a column.
    pub layers: usize,
    /// Elements on half of a fillet.
    pub arc: usize,
}

/// Nodes and elements.
#[derive(Clone, Debug)]
pub(crate) struct Mesh {
    /// (x, Y, Z) in outer radii.
    pub nodes: Vec<[f64; 3]>,
    pub elements: Vec<Element>,
    /// Length of the quarter along x.
    pub half_pitch: f64,
}

/// A grid line by its reference coordinate.
struct Axis {
    /// Two per element and one more.
    at: Vec<f64>,
    /// Index in `at` of the corner.
    corner: usize,
}

impl Mesh {
    pub fn new(section: &Section, profile: &Profile, fineness: &Fineness) -> Self {
        let (x, q) = (x_axis(profile, fineness), q_axis(section, profile, fineness));
        let layers = fineness.layers.max(ceil(section.width() / fineness.across));
        let eta: Vec<f64> = (0..=2 * layers).map(|i| i as f64 / (2 * layers) as f64).collect();
        let warp = Warp::new(section, profile);
        let mut mesh = Self {
            nodes: Vec::new(),
            elements: Vec::new(),
            half_pitch: profile.half_notch + profile.half_tooth,
        };
        let mut known: HashMap<[i64; 3], u32> = HashMap::new();
        let mut ids: HashMap<[usize; 3], u32> = HashMap::new();
        for i in (0..x.at.len() - 1).step_by(2) {
            for j in (0..q.at.len() - 1).step_by(2) {
                if i < x.corner && j >= q.corner {
                    continue;
                }
                for k in (0..2 * layers).step_by(2) {
                    let mut element = [0; 27];
                    for (local, node) in element.iter_mut().enumerate() {
                        let at = [i + local / 9, j + local % 3, k + local / 3 % 3];
                        *node = *ids.entry(at).or_insert_with(|| {
                            let in_tooth = i >= x.corner;
                            let [along, column] = warp.moved(x.at[at[0]], q.at[at[1]], in_tooth);
                            let [y, z] = section.point(column, eta[at[2]]);
                            let point = [along, y, if z.abs() < 1e-12 { 0.0 } else { z }];
                            // Columns that shrink to a point share its node.
                            *known.entry(key(&point)).or_insert_with(|| {
                                mesh.nodes.push(point);
                                index(mesh.nodes.len() - 1)
                            })
                        });
                    }
                    mesh.elements.push(element);
                }
            }
        }
        mesh
    }
}

impl Mesh {
    /// Area of the section, averaged over the cell, in outer radii squared.
    pub fn mean_area(&self) -> f64 {
        let shape = Shape::new();
        let volume: f64 =
            self.elements.iter().map(|e| shape.volume(&e.map(|n| self.nodes[n as usize]))).sum();
        2.0 * volume / self.half_pitch
    }
}

/// Points nearer to each other than this are one (outer radii): far below the smallest element.
const SAME: f64 = 1e-8;

#[expect(clippy::cast_possible_truncation, reason = "coordinates are a few outer radii")]
fn key(point: &[f64; 3]) -> [i64; 3] {
    // The shift keeps round numbers away from the edges of the boxes.
    point.map(|c| (c / SAME + 0.377).floor() as i64)
}

#[expect(clippy::cast_possible_truncation, reason = "a mesh has far fewer than 2³² nodes")]
fn index(count: usize) -> u32 {
    count as u32
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive number")]
fn ceil(number: f64) -> usize {
    number.ceil().max(1.0) as usize
}

fn x_axis(profile: &Profile, fineness: &Fineness) -> Axis {
    let Profile { half_notch, half_tooth, fillet } = *profile;
    let mut at = vec![0.0];
    let size = |x: f64| size(fineness, fillet, (x - half_notch).abs());
    let flat = half_notch - fillet;
    if flat > 1e-9 {
        divide(&mut at, flat, size);
    }
    if fillet > 0.0 {
        equal(&mut at, half_notch, fineness.arc);
    }
    let corner = at.len() - 1;
    if half_tooth > 0.0 {
        divide(&mut at, half_notch + half_tooth, size);
    }
    Axis { at, corner }
}

fn q_axis(section: &Section, profile: &Profile, fineness: &Fineness) -> Axis {
    let breaks = section.breaks();
    let mut at = vec![breaks[0]];
    let mut corner = 0;
    let size =
        |q: f64| size(fineness, profile.fillet, if q > 0.0 { (q - profile.fillet).max(0.0) } else { -q });
    for &next in &breaks[1..] {
        let from = at[at.len() - 1];
        if from >= -1e-12 && next <= profile.fillet + 1e-9 {
            let share = (next - from) / profile.fillet;
            equal(&mut at, next, ceil(share * fineness.arc as f64));
        } else if from >= -1e-12 && from < profile.fillet - 1e-9 {
            equal(
                &mut at,
                profile.fillet,
                ceil((profile.fillet - from) / profile.fillet * fineness.arc as f64),
            );
            divide(&mut at, next, size);
        } else {
            divide(&mut at, next, size);
        }
        if next.abs() < 1e-12 {
            corner = at.len() - 1;
        }
    }
    Axis { at, corner }
}

/// Size of elements at a distance from the corner.
fn size(fineness: &Fineness, fillet: f64, distance: f64) -> f64 {
    let smallest = if fillet > 0.0 {
        (fillet * FRAC_PI_4 / fineness.arc as f64).min(fineness.largest)
    } else {
        fineness.smallest
    };
    // Half the harmonic mean: the smaller of both where they differ, and smooth.
    let growing = smallest + fineness.growth * distance;
    growing * fineness.largest / (growing + fineness.largest)
}

/// Goes on from the last place to `to` with elements of about the given sizes; adds middles and ends.
fn divide(at: &mut Vec<f64>, to: f64, size: impl Fn(f64) -> f64) {
    const STEPS: u16 = 4000;
    let from = at[at.len() - 1];
    if to - from < 1e-9 {
        return;
    }
    let step = (to - from) / f64::from(STEPS);
    let mut sums = vec![0.0];
    for i in 0..STEPS {
        let middle = from + (f64::from(i) + 0.5) * step;
        sums.push(sums[usize::from(i)] + step / size(middle));
    }
    let total = sums[usize::from(STEPS)];
    let count = ceil(total - 1e-9);
    let mut ends = vec![from];
    for i in 1..count {
        let wanted = total * i as f64 / count as f64;
        let next = sums.partition_point(|s| *s < wanted);
        let share = (wanted - sums[next - 1]) / (sums[next] - sums[next - 1]);
        ends.push(from + ((next - 1) as f64 + share) * step);
    }
    ends.push(to);
    for pair in ends.windows(2) {
        at.extend([0.5 * (pair[0] + pair[1]), pair[1]]);
    }
}

/// Goes on from the last place to `to` with `count` equal elements.
fn equal(at: &mut Vec<f64>, to: f64, count: usize) {
    let from = at[at.len() - 1];
    for i in 1..=2 * count {
        at.push(from + (to - from) * i as f64 / (2 * count) as f64);
    }
}

/// Moves the grid of a sharp corner so that it follows the fillet.
struct Warp {
    profile: Profile,
    /// Length along q on the kept side over which the motion dies away.
    reach: f64,
}

impl Warp {
    fn new(section: &Section, profile: &Profile) -> Self {
        let reach = section.breaks().into_iter().filter(|q| *q < -1e-9).fold(f64::NEG_INFINITY, f64::max);
        Self { profile: *profile, reach: -reach }
    }

    /// Place of the grid point (x, q).
    fn moved(&self, x: f64, q: f64, in_tooth: bool) -> [f64; 2] {
        let Profile { half_notch, half_tooth, fillet } = self.profile;
        if fillet <= 0.0 || half_tooth <= 0.0 {
            return [x, q];
        }
        let fade_q = (1.0 + q / self.reach).max(0.0);
        let fade_x = (1.0 - (x - half_notch) / half_tooth).max(0.0);
        let corner = fillet * (1.0 - FRAC_1_SQRT_2);
        let [dx, dq] = if in_tooth && q > 0.0 {
            // The flank: upper half of the arc, from 45° to 90°.
            if q >= fillet {
                return [x, q];
            }
            let angle = FRAC_PI_4 * (1.0 + q / fillet);
            let moved = [fillet * (angle.sin() - 1.0), fillet * (1.0 - angle.cos()) - q];
            moved.map(|d| d * fade_x)
        } else if in_tooth {
            [-corner, corner].map(|d| d * fade_x * fade_q)
        } else {
            // The bottom: lower half of the arc, from 0° to 45°.
            let start = half_notch - fillet;
            if x <= start {
                return [x, q];
            }
            let angle = FRAC_PI_4 * (x - start) / fillet;
            let moved = [start + fillet * angle.sin() - x, fillet * (1.0 - angle.cos())];
            moved.map(|d| d * fade_q)
        };
        [x + dx, q + dq]
    }
}
