//! What readers of a figure rely on, checked on the written SVG and PNG.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking, helpers included")]

use cppr_plot::{
    Annotation, Axis, Colouring, Figure, Force, Line, Marker, MarkerShape, Marks, Panel, Part, PlotError,
    Pose, ProfileCurve, ProfileInput, Quantity, Series, ShapeInput, XyCurve, XyInput, profile_figure,
    shape_figure, tube_stroke, xy_figure,
};

fn line(part: Part, f: impl Fn(f64) -> [f64; 3]) -> Line {
    Line { part, points: (0..=60).map(|i| f(f64::from(i) / 60.0)).collect() }
}

/// Quarter circle of radius 0.1 m in the plane spanned by X and a direction at `turn` from Y.
fn quarter(part: Part, turn: f64) -> Line {
    line(part, |u| {
        let a = std::f64::consts::FRAC_PI_2 * u;
        let y = 0.1 * (1.0 - a.cos());
        [0.1 * a.sin(), y * turn.cos(), y * turn.sin()]
    })
}

fn robot(turn: f64) -> ShapeInput {
    ShapeInput {
        title: "R3 <pulled> & \"turned\"".to_owned(),
        poses: vec![Pose {
            label: "5 mm".to_owned(),
            lines: vec![quarter(Part::Tube(1), turn), quarter(Part::Centreline, turn)],
            forces: vec![Force { point: [0.1, 0.1, 0.0], vector: [0.0, 0.0, 0.5] }],
        }],
        rest: vec![line(Part::Tube(1), |u| [0.15 * u, 0.0, 0.0])],
        marks: vec![Marks { name: "measured tip".to_owned(), points: vec![[0.1, 0.1, 0.0]] }],
        ..ShapeInput::default()
    }
}

fn planar() -> ShapeInput {
    let mut input = robot(0.0);
    input.poses[0].forces[0].vector = [0.0, -0.5, 0.0];
    input
}

/// Every kind of figure.
fn all() -> Vec<Figure> {
    let curve = |tube: usize| ProfileCurve {
        name: format!("tube {tube}"),
        tube,
        x_m: vec![0.0, 0.1, 0.1, 0.15],
        values: vec![1.0, 1.5, 15.0, 15.0],
    };
    let profile = ProfileInput {
        title: "sections".to_owned(),
        x_label: "X_{1}".to_owned(),
        quantities: vec![Quantity {
            label: "I_{Z}".to_owned(),
            unit: "mm⁴".to_owned(),
            include_zero: true,
            curves: vec![curve(1), curve(2)],
        }],
    };
    let xy = XyInput {
        title: String::new(),
        x: Axis::new("Δa", "mm").with_zero_line(),
        y: Axis::new("effort", "N"),
        curves: vec![XyCurve {
            stable: vec![false, true, true, false],
            marked: true,
            ..XyCurve::new("R4", vec![[0.0, 1.0], [1.0, 2.0], [2.0, 2.5], [3.0, 2.0]])
        }],
    };
    vec![
        shape_figure(&planar()).unwrap(),
        shape_figure(&robot(0.7)).unwrap(),
        profile_figure(&profile).unwrap(),
        xy_figure(&xy).unwrap(),
    ]
}

fn names(figure: &Figure) -> Vec<String> {
    let mut out: Vec<String> = figure.keys.iter().map(|k| k.name.clone()).collect();
    for panel in &figure.panels {
        out.extend(panel.series.iter().map(|s| s.name.clone()));
        out.extend(panel.annotations.iter().filter_map(|a| match a {
            Annotation::Arrow { name, .. } => Some(name.clone()),
            Annotation::Text { .. } => None,
        }));
    }
    out.retain(|n| !n.is_empty());
    out
}

/// Points in px of the first drawn line of a series within the given panel.
fn drawn(svg: &str, panel: usize, name: &str) -> Vec<[f64; 2]> {
    let doc = roxmltree::Document::parse(svg).unwrap();
    let group = doc.descendants().filter(|n| n.attribute("class") == Some("panel")).nth(panel).unwrap();
    let path = group
        .descendants()
        .find(|n| n.attribute("class") == Some("series") && n.attribute("data-name") == Some(name))
        .unwrap();
    let d = path.attribute("d").unwrap().replace(['M', 'L'], " ");
    let v: Vec<f64> = d.split_whitespace().map(|t| t.parse().unwrap()).collect();
    v.chunks(2).map(|c| [c[0], c[1]]).collect()
}

/// Pixels per mm along both axes, least squares on the drawn points.
fn scales(svg: &str, panel: usize, truth: &[[f64; 2]], name: &str) -> [f64; 2] {
    let seen = drawn(svg, panel, name);
    assert_eq!(seen.len(), truth.len());
    [0, 1].map(|k| {
        let n = f64::from(u32::try_from(seen.len()).unwrap());
        let mean = |v: &[[f64; 2]]| v.iter().map(|p| p[k]).sum::<f64>() / n;
        let (ms, mt) = (mean(&seen), mean(truth));
        let up: f64 = seen.iter().zip(truth).map(|(s, t)| (s[k] - ms) * (t[k] - mt)).sum();
        let down: f64 = truth.iter().map(|t| (t[k] - mt).powi(2)).sum();
        up / down
    })
}

#[test]
fn a_millimetre_is_as_long_upwards_as_sideways() {
    let input = planar();
    let svg = shape_figure(&input).unwrap().to_svg().unwrap();
    let truth: Vec<[f64; 2]> =
        input.poses[0].lines[0].points.iter().map(|p| [1e3 * p[0], 1e3 * p[1]]).collect();
    let [sx, sy] = scales(&svg, 0, &truth, "tube 1");
    assert!(sx > 1.0, "{sx}");
    assert!((sx + sy).abs() < 1e-4 * sx, "{sx} {sy}");
}

#[test]
fn the_three_views_share_one_scale() {
    let input = robot(0.7);
    let figure = shape_figure(&input).unwrap();
    assert_eq!(figure.panels.len(), 4);
    let svg = figure.to_svg().unwrap();
    let mut seen = Vec::new();
    for (panel, [a, b]) in [(0, [0, 1]), (2, [0, 2]), (3, [1, 2])] {
        let truth: Vec<[f64; 2]> =
            input.poses[0].lines[0].points.iter().map(|p| [1e3 * p[a], 1e3 * p[b]]).collect();
        let [sx, sy] = scales(&svg, panel, &truth, "tube 1");
        seen.extend([sx, -sy]);
    }
    assert!(seen.iter().all(|s| (s - seen[0]).abs() < 1e-4 * seen[0]), "{seen:?}");
    // Below each other, so that a point of X stands above itself.
    let (top, below) = (drawn(&svg, 0, "tube 1"), drawn(&svg, 2, "tube 1"));
    assert!(top.iter().zip(&below).all(|(p, q)| (p[0] - q[0]).abs() < 2e-3));
}

#[test]
fn planar_robots_get_one_panel() {
    assert_eq!(shape_figure(&planar()).unwrap().panels.len(), 1);
    // Rounding does not make a robot spatial, a force out of the plane does.
    let mut nearly = planar();
    nearly.poses[0].lines[0].points[7][2] = 1e-13;
    assert_eq!(shape_figure(&nearly).unwrap().panels.len(), 1);
    assert_eq!(shape_figure(&robot(0.0)).unwrap().panels.len(), 4);
    let mut unloaded = robot(0.0);
    unloaded.poses[0].forces[0].vector = [1e-18, 0.0, 1e-17];
    let figure = shape_figure(&unloaded).unwrap();
    assert_eq!(figure.panels.len(), 1);
    assert!(!figure.to_svg().unwrap().contains("force"));
}

#[test]
fn every_name_stands_once_in_the_legend() {
    for figure in all() {
        let svg = figure.to_svg().unwrap();
        let doc = roxmltree::Document::parse(&svg).unwrap();
        let legend = doc.descendants().find(|n| n.attribute("class") == Some("legend")).unwrap();
        let entries: Vec<String> = legend
            .descendants()
            .filter(|n| n.has_tag_name("text"))
            .map(|n| n.text().unwrap_or_default().to_owned())
            .collect();
        for name in names(&figure) {
            let count = entries.iter().filter(|e| **e == name).count();
            assert_eq!(count, 1, "{name} in {entries:?}");
        }
    }
}

#[test]
fn unstable_branches_are_told_apart() {
    let figure = all().pop().unwrap();
    let names = names(&figure);
    assert_eq!(names, ["R4", "R4 (unstable)", "R4 (unstable)"]);
    let stable = figure.panels[0].series[0].line.unwrap();
    let unstable = figure.panels[0].series[1].line.unwrap();
    assert_ne!(stable.dash, unstable.dash);
}

#[test]
fn svg_is_well_formed_and_all_inside_the_page() {
    for figure in all() {
        let svg = figure.to_svg().unwrap();
        let doc = roxmltree::Document::parse(&svg).unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        let [w, h] = figure.size().unwrap();
        for text in doc.descendants().filter(|n| n.has_tag_name("text")) {
            let at = |k: &str| text.attribute(k).unwrap().parse::<f64>().unwrap();
            assert!(at("x") >= 0.0 && at("x") <= w && at("y") > 0.0 && at("y") < h, "{text:?}");
        }
        for path in doc.descendants().filter_map(|n| n.attribute("d")) {
            let d = path.replace(['M', 'L', 'Z'], " ");
            let v: Vec<f64> = d.split_whitespace().map(|t| t.parse().unwrap()).collect();
            assert!(v.chunks(2).all(|c| c[0] >= 0.0 && c[0] <= w && c[1] >= 0.0 && c[1] <= h));
        }
    }
}

#[test]
fn axes_carry_units_and_markup() {
    let svg = all()[2].to_svg().unwrap();
    let doc = roxmltree::Document::parse(&svg).unwrap();
    let texts: Vec<String> = doc
        .descendants()
        .filter(|n| n.has_tag_name("text"))
        .map(|n| n.descendants().filter_map(|c| if c.is_text() { c.text() } else { None }).collect())
        .collect();
    for label in ["X1 (mm)", "IZ (mm⁴)"] {
        assert!(texts.iter().any(|t| t == label), "{label} in {texts:?}");
    }
}

/// Texts as resvg sets them, with the bounds of their glyphs: left, top, right, bottom.
fn set_texts(svg: &str) -> Vec<(String, [f32; 4])> {
    fn collect(group: &resvg::usvg::Group, out: &mut Vec<(String, [f32; 4])>) {
        for node in group.children() {
            match node {
                resvg::usvg::Node::Group(group) => collect(group, out),
                resvg::usvg::Node::Text(text) => {
                    let content = text.chunks().iter().map(|c| c.text().to_owned()).collect();
                    let b = text.flattened().abs_bounding_box();
                    out.push((content, [b.left(), b.top(), b.right(), b.bottom()]));
                }
                _ => {}
            }
        }
    }
    let mut options = resvg::usvg::Options::default();
    options.fontdb_mut().load_font_data(notosans::REGULAR_TTF.to_vec());
    let mut out = Vec::new();
    collect(resvg::usvg::Tree::from_str(svg, &options).unwrap().root(), &mut out);
    out
}

/// Renderers other than browsers drop spaces at the ends of subscripts unless they are told to keep them.
#[test]
fn spaces_after_subscripts_are_kept() {
    let svg = all()[2].to_svg().unwrap();
    assert!(svg.matches("<text ").count() > 10);
    assert_eq!(svg.matches("<text ").count(), svg.matches("<text xml:space=\"preserve\" ").count());
    let texts = set_texts(&svg);
    assert!(texts.iter().any(|(text, _)| text == "IZ (mm⁴)"), "{texts:?}");
}

/// Also along the curves of a fan, and in a perspective whose box is low.
#[test]
fn no_text_covers_another() {
    let fan: Vec<Pose> = (-11..=11)
        .step_by(2)
        .map(|a| {
            let bend = 0.012 * f64::from(a);
            let along = |u: f64| [0.15 * u * (1.0 - bend * bend * u * u), 0.45 * bend * u * u, 0.0];
            Pose { label: format!("{a}"), lines: vec![line(Part::Tube(1), along)], ..Pose::default() }
        })
        .collect();
    let low = vec![Pose {
        lines: vec![line(Part::Centreline, |u| [0.13 * u, -0.06 * u * u, -0.012 * u * u])],
        ..Pose::default()
    }];
    let mut figures = all();
    for poses in [fan, low] {
        figures.push(shape_figure(&ShapeInput { poses, ..ShapeInput::default() }).unwrap());
    }
    for figure in figures {
        let texts = set_texts(&figure.to_svg().unwrap());
        assert!(texts.len() > 5);
        for (i, (a, p)) in texts.iter().enumerate() {
            for (b, q) in &texts[i + 1..] {
                let apart = p[2] <= q[0] || q[2] <= p[0] || p[3] <= q[1] || q[3] <= p[1];
                assert!(apart, "'{a}' and '{b}' overlap: {p:?} {q:?}");
            }
        }
    }
}

#[test]
fn png_has_the_asked_size_and_is_not_blank() {
    for figure in all() {
        let [w, h] = figure.size().unwrap();
        let bytes = figure.to_png(1.5).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert!((f64::from(info.width) - 1.5 * w).abs() <= 0.5);
        assert!((f64::from(info.height) - 1.5 * h).abs() <= 0.5);
        let dark = pixels.chunks(4).filter(|p| p[0] < 80 && p[1] < 80).count();
        assert!(dark > 1000, "{dark}");
    }
}

#[test]
fn same_figure_same_bytes() {
    for (a, b) in all().iter().zip(&all()) {
        assert_eq!(a.to_svg().unwrap(), b.to_svg().unwrap());
        assert!(a.to_png(0.5).unwrap() == b.to_png(0.5).unwrap());
    }
}

#[test]
fn nan_and_missing_points_are_refused() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut input = planar();
        input.poses[0].lines[0].points[3][1] = bad;
        let what = "pose 1, tube 1".to_owned();
        assert_eq!(shape_figure(&input).unwrap_err(), PlotError::NotFinite { what, index: 3 });
        let mut input = planar();
        input.poses[0].forces[0].vector[0] = bad;
        assert!(matches!(shape_figure(&input), Err(PlotError::NotFinite { .. })));
        let figure = Figure { panels: vec![plain(vec![[0.0, 0.0], [1.0, bad]])], ..Figure::default() };
        assert!(matches!(figure.to_svg(), Err(PlotError::NotFinite { index: 1, .. })));
        assert!(matches!(figure.to_png(1.0), Err(PlotError::NotFinite { .. })));
    }
    let mut input = planar();
    input.poses[0].lines[0].points.truncate(1);
    assert!(matches!(shape_figure(&input), Err(PlotError::SinglePoint { .. })));
    input.poses[0].lines[0].points.clear();
    assert!(matches!(shape_figure(&input), Err(PlotError::Empty { .. })));
    input.poses[0].lines[0] = quarter(Part::Tube(0), 0.0);
    assert!(matches!(shape_figure(&input), Err(PlotError::TubeZero { .. })));
    assert!(matches!(shape_figure(&ShapeInput::default()), Err(PlotError::Empty { .. })));
    assert!(matches!(profile_figure(&ProfileInput::default()), Err(PlotError::Empty { .. })));
    assert!(matches!(Figure::default().to_svg(), Err(PlotError::Empty { .. })));
}

fn plain(points: Vec<[f64; 2]>) -> Panel {
    let mut panel = Panel::new(Axis::new("x", "mm"), Axis::new("y", ""));
    panel.series.push(Series { points, line: Some(tube_stroke(1)), ..Series::default() });
    panel
}

#[test]
fn odd_ranges_are_drawn_or_refused() {
    let odd: [[[f64; 2]; 2]; 7] = [
        [[0.0, 0.0], [0.0, 0.0]],
        [[1.0, 5.0], [2.0, 5.0]],
        [[0.0, 1e9], [1.0, 1e9 + 1e-6]],
        [[0.0, -1e99], [1.0, 1e99]],
        [[0.0, 1e-300], [1e-300, 0.0]],
        [[-1e-320, 0.0], [1e-320, 3.0]],
        [[7.0, 1e-7], [7.0, 3e-7]],
    ];
    for points in odd {
        for equal in [false, true] {
            let mut panel = plain(points.to_vec());
            panel.equal = equal;
            let figure = Figure { panels: vec![panel], ..Figure::default() };
            let svg = figure.to_svg().unwrap();
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{points:?} {equal}");
            figure.to_png(1.0).unwrap();
        }
    }
    let huge = Figure { panels: vec![plain(vec![[0.0, 0.0], [1.0, 1e200]])], ..Figure::default() };
    assert!(matches!(huge.to_svg(), Err(PlotError::TooLarge { .. })));
    let mut panel = plain(vec![[0.0, 0.0], [1.0, 1.0]]);
    panel.x = panel.x.with_range(2.0, 2.0);
    let empty_range = Figure { panels: vec![panel], ..Figure::default() };
    assert!(matches!(empty_range.to_svg(), Err(PlotError::BadRange { .. })));
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e6] {
        assert!(matches!(all()[0].to_png(scale), Err(PlotError::ImageSize { .. })), "{scale}");
    }
}

#[test]
fn a_robot_of_no_length_is_drawn() {
    for at in [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.0, 0.1]] {
        let lines = vec![Line { part: Part::Tube(1), points: vec![at, at] }];
        let poses = vec![Pose { label: "a".to_owned(), lines, ..Pose::default() }];
        let figure = shape_figure(&ShapeInput { poses, ..ShapeInput::default() }).unwrap();
        assert!(!figure.to_svg().unwrap().contains("NaN"));
    }
}

#[test]
fn a_single_marked_point_is_drawn() {
    let mut panel = plain(vec![[1.0, 2.0]]);
    let figure = |panel: &Panel| Figure { panels: vec![panel.clone()], ..Figure::default() };
    assert!(matches!(figure(&panel).to_svg(), Err(PlotError::SinglePoint { .. })));
    let colour = tube_stroke(1).colour;
    panel.series[0].marker = Some(Marker { shape: MarkerShape::Diamond, size: 6.0, colour, filled: true });
    assert!(figure(&panel).to_svg().unwrap().contains("class=\"marker\""));
}

#[test]
fn prescribed_ends_cut_the_lines() {
    let mut panel = plain(vec![[-10.0, 0.0], [10.0, 1.0]]);
    panel.x = panel.x.with_range(0.0, 5.0);
    panel.series[0].name = "cut".to_owned();
    let figure = Figure { panels: vec![panel], ..Figure::default() };
    let seen = drawn(&figure.to_svg().unwrap(), 0, "cut");
    let [w, _] = figure.size().unwrap();
    assert_eq!(seen.len(), 2);
    assert!(seen[0][0] > 20.0 && seen[1][0] < w, "{seen:?}");
}

#[test]
fn long_lines_stay_small() {
    let points = (0..200_000).map(|i| f64::from(i) * 1e-4).map(|x| [x, x.sin()]).collect();
    let figure = Figure { panels: vec![plain(points)], ..Figure::default() };
    assert!(figure.to_svg().unwrap().len() < 100_000);
}

#[test]
fn poses_keep_their_labels() {
    let poses: Vec<Pose> = (-7..=7)
        .map(|a| Pose {
            label: format!("pose {a}"),
            lines: vec![line(Part::Tube(1), |u| [0.15 * u, 0.01 * f64::from(a) * u * u, 0.0])],
            ..Pose::default()
        })
        .collect();
    for colouring in [Colouring::Tube, Colouring::Alternate, Colouring::Pose] {
        let input = ShapeInput { poses: poses.clone(), colouring, ..ShapeInput::default() };
        let svg = shape_figure(&input).unwrap().to_svg().unwrap();
        for a in -7..=7 {
            assert_eq!(svg.matches(&format!(">pose {a}<")).count(), 1);
        }
    }
}

/// Numbers of every magnitude, the same in every run.
struct Wild(u64);

impl Wild {
    fn next(&mut self) -> f64 {
        const SET: [f64; 12] = [0.0, 1.0, -1.0, 1e-320, 1e-200, -1e-9, 0.15, -0.07, 1e6, -1e50, 9e95, 1e97];
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        SET[usize::try_from(self.0 >> 33).unwrap() % SET.len()]
    }

    fn point(&mut self) -> [f64; 3] {
        [self.next(), self.next(), self.next()]
    }
}

#[test]
fn wild_numbers_never_panic() {
    let mut wild = Wild(7);
    for round in 0..120 {
        let flat = |mut p: [f64; 3]| {
            if round % 2 == 0 {
                p[2] = 0.0;
            }
            p
        };
        let points = (0..4).map(|_| flat(wild.point())).collect();
        let force = Force { point: flat(wild.point()), vector: flat(wild.point()) };
        let input = ShapeInput {
            poses: vec![Pose {
                label: "wild".to_owned(),
                lines: vec![Line { part: Part::Tube(1), points }],
                forces: vec![force],
            }],
            ..ShapeInput::default()
        };
        let mut figure = shape_figure(&input).unwrap();
        figure.max_width = wild.next();
        figure.max_height = wild.next();
        figure.columns = round % 6;
        for panel in &mut figure.panels {
            panel.height = 1e3 * wild.next();
            panel.equal ^= round % 3 == 0;
        }
        match figure.to_svg() {
            Ok(svg) => assert!(!svg.contains("NaN") && !svg.contains("inf"), "round {round}"),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
        // A page of this size may be refused, not more.
        if round % 10 == 0 {
            let _ = figure.to_png(0.05);
        }
    }
}
