//! Sections and profiles against reference values, closed forms and properties that hold for any section.

// Where == is asserted below, the numbers are exact.
#![allow(clippy::unwrap_used, clippy::float_cmp)]

use cppr::design::section::Inertia;
use cppr::design::{Outline, Profile, ProfileError, SectionError};
use std::f64::consts::PI;

fn round(outer_radius: f64, inner_radius: f64) -> Outline {
    Outline::Round { outer_radius, inner_radius }
}

fn polygon(sides: usize, outer_apothem: f64, inner_apothem: f64) -> Outline {
    Outline::Polygon { sides, outer_apothem, inner_apothem }
}

fn torsion(outline: &Outline, depth: f64) -> f64 {
    outline.notched(depth).unwrap().torsion_constant
}

fn values(i: &Inertia) -> [f64; 5] {
    [i.area, i.centroid_offset, i.inertia_y, i.inertia_z, i.polar_about_centre]
}

#[track_caller]
fn close(got: f64, want: f64, tolerance: f64) {
    assert!((got - want).abs() <= tolerance * want.abs(), "{got} instead of {want}");
}

/// Outlines of all kinds, of unit outer inradius.
fn samples() -> Vec<Outline> {
    let mut all = Vec::new();
    for inner in [0.0, 0.3, 0.9, 0.98] {
        all.push(round(1.0, inner));
        all.extend([3, 4, 6, 13].map(|n| polygon(n, 1.0, inner)));
    }
    all
}

/// A depth in every regime: inside the wall, through the bore, beyond it, and at the borders.
fn depths(outline: &Outline) -> Vec<f64> {
    let borders = [0.0, outline.opening_depth(), outline.passing_depth(), outline.depth_limit()];
    let mut all = Vec::new();
    for pair in borders.windows(2) {
        all.extend([0.0, 0.01, 0.5, 0.99].map(|s| pair[0] + s * (pair[1] - pair[0])));
    }
    all
}

#[test]
fn reference_sections() {
    let file: serde_json::Value = serde_json::from_str(include_str!("data/sections.json")).unwrap();
    let cases = file["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 14);
    let mut torsions = 0;
    for case in cases {
        let get = |key: &str| case[key].as_f64();
        let s = round(get("rho_out").unwrap() * 1e-3, get("rho_in").unwrap() * 1e-3)
            .notched(get("gamma").unwrap() * 1e-3)
            .unwrap();
        close(s.area * 1e6, get("A").unwrap(), 1e-10);
        close(s.centroid_offset * 1e3, get("D").unwrap(), 1e-10);
        close(s.inertia_y * 1e12, get("J_Y").unwrap(), 1e-10);
        close(s.polar_about_centre * 1e12, get("J_Y").unwrap() + get("J_Z").unwrap(), 1e-10);
        close(s.inertia_z * 1e12, get("I_Z").unwrap(), 1e-9);
        if let Some(constant) = get("J_t_fe") {
            // The reference is good to 1e-4; the section is within 1e-4 of its limit and measured at 2e-5.
            close(s.torsion_constant * 1e12, constant, 1e-4);
            torsions += 1;
        }
    }
    assert_eq!(torsions, 7);
}

/// The closed forms of appendix B, about the centre: A, S, J_Y and J_Z of the part Y > α of a disk.
fn appendix_b(r: f64, alpha: f64) -> [f64; 4] {
    let s = (alpha / r).clamp(-1.0, 1.0);
    let (psi, a) = (s.asin(), r * s);
    // Not √(r² − a²), whose rounding error would differ from that of ψ where both have an infinite slope.
    let w = r * psi.cos();
    [
        r * r * (PI / 2.0 - psi) - a * w,
        2.0 / 3.0 * w.powi(3),
        r.powi(4) / 48.0 * (6.0 * PI - 12.0 * psi - 8.0 * (2.0 * psi).sin() - (4.0 * psi).sin()),
        r.powi(4) / 16.0 * (2.0 * PI - 4.0 * psi + (4.0 * psi).sin()),
    ]
}

#[test]
fn round_sections_follow_appendix_b() {
    for inner in [0.1, 0.5, 0.9] {
        for step in 1..90 {
            let depth = 0.02 * f64::from(step);
            let (big, small) = (appendix_b(1.0, depth - 1.0), appendix_b(inner, (depth - 1.0).max(-inner)));
            let small = if depth - 1.0 < inner { small } else { [0.0; 4] };
            let [a, s, jy, jz] = [0, 1, 2, 3].map(|k| big[k] - small[k]);
            let d = s / a;
            let got = round(1.0, inner).inertia(depth).unwrap();
            for (got, want) in values(&got).into_iter().zip([a, d, jy, jz - a * d * d, jy + jz]) {
                // Closed forms about the centre lose digits against quantities of order one.
                assert!((got - want).abs() < 1e-14, "{inner} {depth}: {got} instead of {want}");
            }
        }
    }
}

#[test]
fn closed_forms() {
    let ring = round(3e-3, 2e-3).plain().unwrap();
    close(ring.area, PI * 5e-6, 1e-14);
    close(ring.inertia_y, PI / 4.0 * 65e-12, 1e-14);
    close(ring.inertia_z, PI / 4.0 * 65e-12, 1e-14);
    close(ring.polar_about_centre, PI / 2.0 * 65e-12, 1e-14);
    assert!(ring.centroid_offset.abs() <= 0.0);

    let half = round(2.0, 0.0).inertia(2.0).unwrap();
    let offset = 8.0 / (3.0 * PI);
    let polar = 4.0 * PI;
    for (got, want) in values(&half).into_iter().zip([
        2.0 * PI,
        offset,
        2.0 * PI,
        2.0 * PI - 2.0 * PI * offset * offset,
        polar,
    ]) {
        close(got, want, 1e-14);
    }

    let tube = polygon(4, 1.0, 0.5).inertia(0.0).unwrap();
    close(tube.area, 3.0, 1e-14);
    close(tube.inertia_y, (16.0 - 1.0) / 12.0, 1e-14);
    close(tube.inertia_z, (16.0 - 1.0) / 12.0, 1e-14);
    // Notched down to the middle: a channel of wall ½ around a bore of height ½ and width 1.
    let channel = polygon(4, 1.0, 0.5).inertia(1.0).unwrap();
    let (area, first, second) = (2.0 - 0.5, 1.0 - 0.125, 2.0 / 3.0 - 1.0 / 24.0);
    close(channel.area, area, 1e-14);
    close(channel.centroid_offset, first / area, 1e-14);
    close(channel.inertia_z, second - first * first / area, 1e-14);
    close(channel.inertia_y, 8.0 / 12.0 - 0.5 / 12.0, 1e-14);

    // A regular hexagon of side t: A = 3√3/2 t², I = 5√3/16 t⁴; its upper half is a trapezium.
    let root = 3.0_f64.sqrt();
    let hexagon = polygon(6, root / 2.0, 0.0);
    let whole = hexagon.inertia(0.0).unwrap();
    close(whole.area, 1.5 * root, 1e-14);
    close(whole.inertia_y, 5.0 * root / 16.0, 1e-14);
    close(whole.inertia_z, 5.0 * root / 16.0, 1e-14);
    let half = hexagon.inertia(root / 2.0).unwrap();
    close(half.area, 0.75 * root, 1e-14);
    close(half.centroid_offset, 2.0 * root / 9.0, 1e-14);

    // An odd number of sides points upwards.
    let triangle = polygon(3, 1.0, 0.0);
    close(triangle.depth_limit(), 3.0, 1e-14);
    let tip = triangle.inertia(2.0).unwrap();
    close(tip.area, 1.0 / root, 1e-13);
    close(tip.centroid_offset, 1.0 + 1.0 / 3.0, 1e-14);
}

#[test]
fn slivers_keep_their_digits() {
    // A thin segment of a disk is a parabola of height h on a chord 2w: A = 4wh/3, ∫Z² = 4w³h/15,
    // I_Z = 16wh³/175, up to terms of the relative order h.
    for h in [1e-3_f64, 1e-6, 1e-9] {
        let height = 2.0 - (2.0 - h);
        let s = round(1.0, 0.4).inertia(2.0 - h).unwrap();
        let w = (height * (2.0 - height)).sqrt();
        close(s.area, 4.0 * w * height / 3.0, height);
        close(s.inertia_y, 4.0 * w.powi(3) * height / 15.0, 2.0 * height);
        close(s.inertia_z, 16.0 * w * height.powi(3) / 175.0, 2.0 * height);
    }
}

#[test]
fn lengths_of_an_outline() {
    let tube = round(3.0, 2.0);
    for (got, want) in [
        (tube.outer_reach(), 3.0),
        (tube.inner_clearance(), 2.0),
        (tube.opening_depth(), 1.0),
        (tube.passing_depth(), 5.0),
        (tube.depth_limit(), 6.0),
    ] {
        close(got, want, 1e-15);
    }
    let square = polygon(4, 3.0, 2.0);
    close(square.outer_reach(), 3.0 * 2.0_f64.sqrt(), 1e-15);
    close(square.inner_clearance(), 2.0, 1e-15);
    close(polygon(3, 3.0, 2.0).passing_depth(), 7.0, 1e-15);
}

#[test]
fn many_sides_tend_to_a_circle() {
    for depth in [0.0, 0.1, 0.2, 0.8, 1.5, 1.8, 1.9] {
        let circle = round(1.0, 0.8).notched(depth).unwrap();
        let deviation = |n: usize| {
            let p = polygon(n, 1.0, 0.8).notched(depth).unwrap();
            [
                p.area / circle.area - 1.0,
                p.inertia_y / circle.inertia_y - 1.0,
                p.polar_about_centre / circle.polar_about_centre - 1.0,
                p.torsion_constant / circle.torsion_constant - 1.0,
            ]
        };
        // A side is at most r π²/2n² = 1e-5 r away from the circle. In the thinnest of these segments, 0.1 r
        // high, J_t ~ h³ feels it thirty times, and the two discretisations differ by 1e-4.
        for (got, bound) in deviation(720).into_iter().zip([2e-4, 2e-4, 2e-4, 5e-4]) {
            assert!(got.abs() < bound, "{depth}: {got}");
        }
        let (coarse, fine) = (deviation(90)[0], deviation(720)[0]);
        assert!((coarse / fine - 64.0).abs() < 8.0, "{depth}: {coarse} {fine}");
    }
}

#[test]
fn borders_between_regimes_have_no_step_and_no_kink() {
    for inner in [0.3, 2.0 / 3.0, 0.9] {
        for tube in [round(1.0, inner), polygon(5, 1.0, inner)] {
            for border in [tube.opening_depth(), tube.passing_depth()] {
                let h = 1e-7;
                let at = |x: f64| values(&tube.inertia(border + x).unwrap());
                let [far, left, here, right, beyond] = [-2.0 * h, -h, 0.0, h, 2.0 * h].map(at);
                for k in 0..5 {
                    let (before, after) = ((left[k] - far[k]) / h, (beyond[k] - right[k]) / h);
                    assert!((here[k] - left[k] - h * before).abs() < 1e-9, "{tube:?} {k}");
                    // A pentagon's bore has a flat bottom: its slope there jumps by the width of the flat.
                    let flat = matches!(tube, Outline::Polygon { .. }) && border < 0.9;
                    // Slopes change as √h where a circle begins.
                    assert!(flat || (before - after).abs() < 2e-2, "{tube:?} {k}: {before} {after}");
                }
            }
        }
    }
}

#[test]
fn an_ulp_beside_a_border_changes_nothing() {
    for (outer, inner) in [(3e-3, 2e-3), (1.5e-3, 0.5e-3), (4.5e-3, 3.7e-3)] {
        for tube in [round(outer, inner), polygon(6, outer, inner), polygon(5, outer, inner)] {
            for border in [tube.opening_depth(), tube.passing_depth()] {
                let here = tube.notched(border).unwrap();
                for depth in [border.next_down(), border.next_up()] {
                    let beside = tube.notched(depth).unwrap();
                    close(beside.area, here.area, 1e-13);
                    close(beside.inertia_z, here.inertia_z, 1e-12);
                    // The columns change direction at the border of a hexagon's bore, and at the opening a
                    // wall of a few ulp carries √ulp of a closed ring.
                    close(beside.torsion_constant, here.torsion_constant, 1e-3);
                }
            }
        }
    }
}

#[test]
fn properties_scale_with_powers_of_length() {
    for tube in samples() {
        for depth in depths(&tube) {
            let one = tube.notched(depth).unwrap();
            let s = 7.3e-3;
            let small = match tube {
                Outline::Round { outer_radius, inner_radius } => round(s * outer_radius, s * inner_radius),
                Outline::Polygon { sides, outer_apothem, inner_apothem } => {
                    polygon(sides, s * outer_apothem, s * inner_apothem)
                }
            };
            let two = small.notched(s * depth).unwrap();
            // What is left is known to a rounding error of the depth; I_Z goes with its 3.5th power.
            let tolerance = 1e-13 + 1e-15 * tube.depth_limit() / (tube.depth_limit() - depth);
            close(two.area, s.powi(2) * one.area, 2.0 * tolerance);
            // Rounding in units of the radius, times radius over wall (up to 50 here).
            assert!((two.centroid_offset - s * one.centroid_offset).abs() < 1e-13 * s);
            close(two.inertia_y, s.powi(4) * one.inertia_y, 4.0 * tolerance);
            close(two.inertia_z, s.powi(4) * one.inertia_z, 8.0 * tolerance);
            // Rounding may put a depth on the other side of a border, as above.
            close(two.torsion_constant, s.powi(4) * one.torsion_constant, 1e-3);
        }
    }
}

#[test]
fn torsion_of_shapes_with_a_series_or_a_closed_form() {
    for inner in [0.0, 0.01, 0.5, 0.99] {
        close(torsion(&round(1.0, inner), 0.0), PI / 2.0 * (1.0 - inner.powi(4)), 1e-12);
    }
    // Timoshenko and Goodier: half disk, square, equilateral triangle of side 1.
    close(torsion(&round(1.0, 0.0), 1.0), PI / 2.0 - 4.0 / PI, 1e-6);
    close(torsion(&polygon(4, 0.5, 0.0), 0.0), 0.140_577_014_955, 1e-5);
    close(torsion(&polygon(3, 0.5 / 3.0_f64.sqrt(), 0.0), 0.0), 3.0_f64.sqrt() / 80.0, 1e-12);
    // What is left of a square is a rectangle.
    for depth in [0.1, 0.5, 0.9, 0.99, 0.999] {
        let h = 1.0 - depth;
        let series: f64 =
            (0..20).map(|k| f64::from(2 * k + 1)).map(|n| (n * PI / (2.0 * h)).tanh() / n.powi(5)).sum();
        let exact = h.powi(3) / 3.0 * (1.0 - 192.0 * h / PI.powi(5) * series);
        close(torsion(&polygon(4, 0.5, 0.0), depth), exact, 1e-5);
    }
}

#[test]
fn torsion_of_thin_walls() {
    // Bredt: 4 A_m² / ∮ds/t, in error by the order (t/r)² for a ring of uniform wall and t/r at corners.
    let (r, t) = (1.0, 0.02);
    let middle = 2.0 * r - t;
    close(torsion(&polygon(4, r, r - t), 0.0), middle.powi(3) * t, 0.02);
    // A shallow notch leaves a wall that grows from δ as the cut moves away from the bore.
    let delta = 0.01;
    let (alpha, inner) = (-(r - t) - delta, r - t);
    let end = (-alpha / r).acos();
    let steps = 20_000;
    let flow: f64 = (0..steps)
        .map(|k| PI * (f64::from(k) + 0.5) / f64::from(steps))
        .map(|angle| {
            let wall = if angle < end { -alpha / angle.cos() - inner } else { t };
            (inner + 0.5 * wall) / wall * PI / f64::from(steps) * 2.0
        })
        .sum();
    let enclosed = PI * (r - 0.5 * t).powi(2);
    close(torsion(&round(r, inner), t - delta), 4.0 * enclosed * enclosed / flow, 0.01);
    // Open rings: ⅓ length × wall³, less 0.63 of a wall at the ends together.
    let half_ring = torsion(&round(r, inner), r);
    close(half_ring, t.powi(3) / 3.0 * (PI * (r - 0.5 * t) - 0.63 * t), 1e-3);
}

#[test]
fn torsion_falls_with_depth_and_stays_below_the_polar_moment() {
    // ϕ of a smaller section, continued by zero, is admissible for the larger one.
    for tube in samples() {
        let mut before = f64::INFINITY;
        for depth in depths(&tube) {
            let s = tube.notched(depth).unwrap();
            let polar = s.inertia_y + s.inertia_z;
            assert!(s.torsion_constant <= polar * (1.0 + 1e-12), "{tube:?} {depth}");
            // The slack is the error of the Ritz solution of a triangular bore.
            assert!(s.torsion_constant < before * (1.0 + 1e-3), "{tube:?} {depth}");
            before = s.torsion_constant;
        }
    }
}

/// Largest relative error of the polynomial through 17 Chebyshev points of the depth.
fn interpolation_error(tube: &Outline, least: f64, greatest: f64) -> f64 {
    let count = 16;
    let sign = |i: i32| if i % 2 == 0 { 1.0 } else { -1.0 };
    let nodes: Vec<[f64; 3]> = (0..=count)
        .map(|i| {
            let depth =
                0.5 * (least + greatest + (greatest - least) * (PI * f64::from(i) / f64::from(count)).cos());
            [depth, torsion(tube, depth), sign(i) * if i == 0 || i == count { 0.5 } else { 1.0 }]
        })
        .collect();
    (0..40)
        .map(|k| least + (greatest - least) * (f64::from(k) + 0.5) / 40.0)
        .map(|depth| {
            let (above, below) = nodes
                .iter()
                .fold((0.0, 0.0), |(a, b), [x, v, w]| (a + w * v / (depth - x), b + w / (depth - x)));
            (above / below / torsion(tube, depth) - 1.0).abs()
        })
        .fold(0.0, f64::max)
}

#[test]
fn torsion_is_smooth_within_a_regime() {
    let tube = round(1.0, 2.0 / 3.0);
    assert!(interpolation_error(&tube, 0.03, 0.25) < 1e-7);
    assert!(interpolation_error(&tube, 0.36, 1.5) < 1e-6);
    assert!(interpolation_error(&tube, 1.7, 1.95) < 1e-9);
}

#[test]
fn impossible_sections_say_why() {
    use SectionError as E;
    let cases = [
        (round(f64::NAN, 1.0), 0.0, "outer radius is NaN"),
        (round(2.0, f64::INFINITY), 0.0, "inner radius is inf"),
        (round(2.0, 1.0), f64::NAN, "notch depth is NaN"),
        (polygon(4, 1.0, f64::NAN), 0.0, "inner apothem is NaN"),
        (round(0.0, 0.0), 0.0, "must be positive"),
        (round(2e-3, -1e-3), 0.0, "-1.000000 mm"),
        (round(2e-3, 2e-3), 0.0, "leaves no wall"),
        (polygon(2, 2.0, 1.0), 0.0, "at least 3"),
        (round(3e-3, 2e-3), 6e-3, "6.000000 mm deep leaves nothing"),
        (polygon(3, 1e-3, 0.0), 3.0001e-3, "make it shallower"),
    ];
    for (tube, depth, text) in cases {
        let error = tube.notched(depth).unwrap_err();
        assert!(error.to_string().contains(text), "{error}");
        assert_eq!(tube.inertia(depth).map(|_| ()).unwrap_err().to_string(), error.to_string());
    }
    assert_eq!(round(2.0, 3.0).plain(), Err(E::NoWall { inner: 3.0, outer: 2.0 }));
    assert_eq!(round(2.0, 1.0).inertia(4.5), Err(E::NothingLeft { depth: 4.5, limit: 4.0 }));
    // A negative depth is no notch.
    assert_eq!(round(2.0, 1.0).notched(-1.0), round(2.0, 1.0).plain());
}

/// Profiles of every kind on a tube of length 2.
fn profiles() -> Vec<Profile> {
    let x = [0.1, 0.35, 0.9, 1.1, 1.7];
    vec![
        Profile::constant(3.0),
        Profile::linear(1.0, -2.0),
        Profile::per_notch(&[1.0, 4.0, 2.0, 2.5, -1.0], &x).unwrap(),
        Profile::table(&x, &[1.0, 4.0, 2.0, 2.5, 7.0]).unwrap(),
    ]
}

#[test]
fn derivatives_of_profiles() {
    let h = 1e-5;
    for profile in profiles() {
        for step in 0..100 {
            // Between knots, and before and beyond the outermost points.
            let x = -0.193 + 0.0231 * f64::from(step);
            let [[before, slope_before, _], [_, slope, second], [after, slope_after, _]] =
                [x - h, x, x + h].map(|x| profile.eval(x, 2.0));
            // Third derivatives are below 3e3 here, and h² of that is 3e-7.
            assert!(((after - before) / (2.0 * h) - slope).abs() < 1e-6, "{profile:?} {x}");
            assert!(((slope_after - slope_before) / (2.0 * h) - second).abs() < 1e-6, "{profile:?} {x}");
        }
    }
    let [_, slope, second] = profiles()[2].eval(0.5, 2.0);
    assert!(slope.abs() > 0.1 && second.abs() > 0.1);
}

#[test]
fn spline_through_notches_is_natural_and_twice_continuous() {
    let (x, y) = ([0.1, 0.35, 0.9, 1.1, 1.7], [1.0, 4.0, 2.0, 2.5, -1.0]);
    let spline = Profile::per_notch(&y, &x).unwrap();
    for (&x, &y) in x.iter().zip(&y) {
        let [left, right] = [x - 1e-9, x + 1e-9].map(|x| spline.eval(x, 2.0));
        close(spline.eval(x, 2.0)[0], y, 1e-14);
        assert!((left[1] - right[1]).abs() < 1e-5 && (left[2] - right[2]).abs() < 1e-5, "{left:?} {right:?}");
    }
    assert!(spline.knots(2.0).is_empty());
    for (x, end) in [(-0.4, 0.1), (2.3, 1.7)] {
        let ([value, slope, second], [at, tangent, bend]) = (spline.eval(x, 2.0), spline.eval(end, 2.0));
        close(value, at + tangent * (x - end), 1e-14);
        assert!((slope - tangent).abs() < 1e-14 && second.abs() <= 0.0 && bend.abs() < 1e-12);
    }
    // Three equal steps of a hat: the natural spline has slopes 1.5, 0, −1.5 and second derivative −3 on top.
    let hat = Profile::per_notch(&[0.0, 1.0, 0.0], &[0.0, 1.0, 2.0]).unwrap();
    let [value, slope, second] = hat.eval(1.0, 2.0);
    assert!((value - 1.0).abs() < 1e-15 && slope.abs() < 1e-15 && (second + 3.0).abs() < 1e-14);
    close(hat.eval(0.0, 2.0)[1], 1.5, 1e-14);
    close(hat.eval(2.0, 2.0)[1], -1.5, 1e-14);
    // A straight line stays one.
    let line = Profile::per_notch(&[2.0, 3.0, 6.0], &[0.0, 0.5, 2.0]).unwrap();
    for x in [-1.0, 0.2, 1.3, 4.0] {
        close(line.eval(x, 2.0)[0], 2.0 + 2.0 * x, 1e-14);
    }
}

#[test]
fn tables_reproduce_a_parabola_and_keep_monotone_data_monotone() {
    let x = [0.0, 0.5, 0.8, 1.6, 2.0];
    let parabola = |x: f64| 1.0 + 2.0 * x + 0.5 * x * x;
    let table = Profile::table(&x, &x.map(parabola)).unwrap();
    for step in 0..200 {
        let at = 0.01 * f64::from(step);
        let got = table.eval(at, 2.0);
        for (got, want) in got.into_iter().zip([parabola(at), 2.0 + at, 1.0]) {
            assert!((got - want).abs() < 1e-12, "{at}: {got} {want}");
        }
    }
    // Steps of very different height and width, flats included, from a linear congruential generator.
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1_u32 << 24)
    };
    for _ in 0..50 {
        let (mut xs, mut ys) = (vec![0.0], vec![0.0]);
        for i in 0..12 {
            xs.push(xs[i] + 0.01 + random());
            ys.push(ys[i] + (random() - 0.3).max(0.0).powi(4));
        }
        let table = Profile::table(&xs, &ys).unwrap();
        let length = xs[12];
        let mut before = f64::NEG_INFINITY;
        for step in -10..=1010 {
            let [value, slope, _] = table.eval(length * f64::from(step) / 1000.0, length);
            assert!(value >= before - 1e-14 && slope >= -1e-13, "{xs:?} {ys:?}");
            before = value;
        }
        for (&x, &y) in xs.iter().zip(&ys) {
            assert!((table.eval(x, length)[0] - y).abs() < 1e-14);
        }
    }
    // Constant beyond the points; a local extremum is not overshot.
    let table = Profile::table(&[0.2, 0.6, 1.0], &[1.0, 3.0, 2.0]).unwrap();
    assert_eq!(table.eval(0.1, 2.0), [1.0, 0.0, 0.0]);
    assert_eq!(table.eval(1.5, 2.0), [2.0, 0.0, 0.0]);
    assert!((0..100).all(|k| table.eval(0.01 * f64::from(k), 2.0)[0] <= 3.0));
    assert_eq!(table.knots(0.8), [0.2, 0.6]);
    assert_eq!(table.knots(2.0), [0.2, 0.6, 1.0]);
}

#[test]
fn profiles_scale_and_shift() {
    for profile in profiles() {
        let (scaled, shifted) = (profile.scaled(-2.5), profile.shifted(0.7));
        for step in -5..50 {
            let x = 0.05 * f64::from(step);
            let ([v, d, dd], s, t) = (profile.eval(x, 2.0), scaled.eval(x, 2.0), shifted.eval(x, 2.0));
            for (got, want) in s.into_iter().chain(t).zip([-2.5 * v, -2.5 * d, -2.5 * dd, v + 0.7, d, dd]) {
                assert!((got - want).abs() < 1e-12 * (1.0 + want.abs()), "{profile:?} {x}");
            }
        }
        assert_eq!(scaled.is_constant(), profile.is_constant());
        assert_eq!(shifted.knots(2.0), profile.knots(2.0));
    }
    assert_eq!(profiles().iter().map(Profile::is_constant).collect::<Vec<_>>(), [true, false, false, false]);
    assert!(Profile::linear(2.0, 2.0).is_constant());
    assert!(Profile::per_notch(&[2.0; 3], &[0.0, 1.0, 1.5]).unwrap().is_constant());
    assert!(Profile::table(&[0.0, 1.0], &[2.0; 2]).unwrap().is_constant());
    assert_eq!(Profile::table(&[0.3], &[2.0]).unwrap(), Profile::constant(2.0));
    assert_eq!(Profile::linear(1.0, 3.0).eval(0.5, 2.0), [1.5, 1.0, 0.0]);
}

#[test]
fn impossible_profiles_say_why() {
    use ProfileError as E;
    assert_eq!(Profile::table(&[], &[]), Err(E::Empty));
    assert_eq!(Profile::table(&[0.0], &[1.0, 2.0]), Err(E::Lengths { values: 2, abscissae: 1 }));
    assert_eq!(Profile::per_notch(&[1.0, 2.0], &[0.0]), Err(E::Lengths { values: 2, abscissae: 1 }));
    assert_eq!(
        Profile::per_notch(&[1.0, 2.0, 3.0], &[0.0, 1.0, 1.0]),
        Err(E::Order { point: 3, before: 1.0, x: 1.0 })
    );
    assert_eq!(
        Profile::table(&[0.0, 1.0], &[1.0, f64::INFINITY]),
        Err(E::Value { point: 2, value: f64::INFINITY })
    );
    let error = Profile::table(&[f64::NAN], &[1.0]).unwrap_err();
    assert_eq!(error.to_string(), "abscissa 1 is NaN; it must be a finite number");
}
