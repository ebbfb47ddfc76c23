//! Draws one figure of every kind from made-up data: `cargo run --example gallery -- DIRECTORY`.

use std::error::Error;
use std::path::PathBuf;

use cppr_plot::{
    Axis, Colouring, Figure, Force, Line, Marks, Part, Pose, ProfileCurve, ProfileInput, Quantity,
    ShapeInput, XyCurve, XyInput, profile_figure, shape_figure, xy_figure,
};

const LENGTH: f64 = 0.15;
const POINTS: u32 = 120;

fn main() -> Result<(), Box<dyn Error>> {
    let to = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".to_owned()));
    for (name, figure) in [
        ("arc", arc_figure()?),
        ("family", family()?),
        ("family_pose", family_by_pose()?),
        ("loaded", loaded()?),
        ("straight", straight()?),
        ("helix", helix()?),
        ("star", star()?),
        ("sections", sections()?),
        ("effort", effort()?),
        ("combined", combined()?),
    ] {
        std::fs::write(to.join(format!("{name}.svg")), figure.to_svg()?)?;
        std::fs::write(to.join(format!("{name}.png")), figure.to_png(2.0)?)?;
    }
    Ok(())
}

fn along() -> impl Iterator<Item = f64> {
    (0..=POINTS).map(|i| f64::from(i) / f64::from(POINTS))
}

/// Circular arc of curvature kappa (1/m), offset sideways by `offset` (m), turned about X.
fn arc(kappa: f64, offset: f64, turn: f64) -> Vec<[f64; 3]> {
    along()
        .map(|u| {
            let (s, a) = (u * LENGTH, kappa * u * LENGTH);
            let (x, y) = if a.abs() < 1e-9 { (s, 0.0) } else { (a.sin() / kappa, (1.0 - a.cos()) / kappa) };
            let (x, y) = (x - offset * a.sin(), y + offset * a.cos());
            [x, y * turn.cos(), y * turn.sin()]
        })
        .collect()
}

fn tubes(kappa: f64) -> Vec<Line> {
    vec![
        Line { part: Part::Tube(1), points: arc(kappa, 0.003, 0.0) },
        Line { part: Part::Tube(2), points: arc(kappa, -0.003, 0.0) },
        Line { part: Part::Centreline, points: arc(kappa, 0.0, 0.0) },
    ]
}

fn arc_figure() -> Result<Figure, cppr_plot::PlotError> {
    shape_figure(&ShapeInput {
        title: "R3, pull 5 mm, 0.5 N at the tip".to_owned(),
        poses: vec![Pose {
            lines: tubes(7.0),
            forces: vec![Force { point: [0.124, 0.072, 0.0], vector: [0.0, -0.5, 0.0] }],
            ..Pose::default()
        }],
        rest: tubes(0.0),
        ..ShapeInput::default()
    })
}

fn poses() -> Vec<Pose> {
    (-7..=7)
        .map(|a| Pose {
            label: a.to_string().replace('-', "−"),
            lines: tubes(-f64::from(a) / (LENGTH * 0.006) / 1000.0),
            ..Pose::default()
        })
        .collect()
}

fn family() -> Result<Figure, cppr_plot::PlotError> {
    shape_figure(&ShapeInput {
        title: "R1, consistent formulation; labels: Δa in mm".to_owned(),
        poses: poses(),
        marks: vec![Marks {
            name: "measured tip".to_owned(),
            points: poses()
                .iter()
                .map(|p| {
                    let t = p.lines[2].points[120];
                    [t[0] + 0.001, t[1] - 0.0012, 0.0]
                })
                .collect(),
        }],
        colouring: Colouring::Alternate,
        ..ShapeInput::default()
    })
}

fn family_by_pose() -> Result<Figure, cppr_plot::PlotError> {
    shape_figure(&ShapeInput {
        title: "R1; labels: Δa in mm".to_owned(),
        poses: poses(),
        colouring: Colouring::Pose,
        ..ShapeInput::default()
    })
}

fn loaded() -> Result<Figure, cppr_plot::PlotError> {
    let poses = [-6.0, -3.0, 0.0, 3.0, 6.0].map(|a| {
        let lines = tubes(-a / (LENGTH * 0.006) / 1000.0);
        let point = lines[2].points[120];
        Pose {
            label: format!("{a} mm").replace('-', "−"),
            lines,
            forces: vec![Force { point, vector: [0.0, -0.196, 0.0] }],
        }
    });
    shape_figure(&ShapeInput {
        title: "R1, 20 g over a pulley".to_owned(),
        poses: poses.to_vec(),
        ..ShapeInput::default()
    })
}

fn straight() -> Result<Figure, cppr_plot::PlotError> {
    shape_figure(&ShapeInput {
        poses: vec![Pose { lines: tubes(0.0), ..Pose::default() }],
        ..ShapeInput::default()
    })
}

fn helix() -> Result<Figure, cppr_plot::PlotError> {
    let line = |offset: f64, grow: f64| -> Vec<[f64; 3]> {
        along()
            .map(|u| {
                let a = std::f64::consts::TAU * u;
                let r = grow * u;
                [0.13 * u, r * a.sin() + offset * a.cos(), r * (1.0 - a.cos()) + offset * a.sin()]
            })
            .collect()
    };
    let lines = |grow: f64| {
        vec![
            Line { part: Part::Tube(1), points: line(0.003, grow) },
            Line { part: Part::Tube(2), points: line(-0.003, grow) },
            Line { part: Part::Centreline, points: line(0.0, grow) },
        ]
    };
    shape_figure(&ShapeInput {
        title: "Helicoid, pull 10 mm".to_owned(),
        poses: vec![Pose {
            lines: lines(0.03),
            forces: vec![Force { point: [0.13, 0.0, 0.0], vector: [0.0, 0.0, -0.5] }],
            ..Pose::default()
        }],
        rest: lines(0.0),
        ..ShapeInput::default()
    })
}

fn star() -> Result<Figure, cppr_plot::PlotError> {
    let poses: Vec<Pose> = (0..6)
        .map(|k| {
            let turn = std::f64::consts::PI / 3.0 * f64::from(k);
            let lines = (1..=3u8)
                .map(|n| {
                    let side = 0.002 * (f64::from(n) * 2.1 - turn).cos();
                    Line { part: Part::Tube(usize::from(n)), points: arc(11.0, side, turn) }
                })
                .chain([Line { part: Part::Centreline, points: arc(11.0, 0.0, turn) }])
                .collect();
            Pose { label: format!("{}°", 60 * k), lines, ..Pose::default() }
        })
        .collect();
    shape_figure(&ShapeInput {
        title: "Three tubes, pulled in turn".to_owned(),
        poses,
        ..ShapeInput::default()
    })
}

fn sections() -> Result<Figure, cppr_plot::PlotError> {
    let curve = |tube: usize, f: &dyn Fn(f64) -> f64| {
        let mut x_m: Vec<f64> = along().map(|u| u * LENGTH).collect();
        let mut values: Vec<f64> = along().map(f).collect();
        if tube == 2 {
            // Plain tube beyond the notches: a tenfold step.
            let (x, v) = (*x_m.last().unwrap_or(&0.0), *values.last().unwrap_or(&0.0));
            x_m.extend([x, x + 0.007]);
            values.extend([10.0 * v, 10.0 * v]);
        }
        ProfileCurve { name: format!("tube {tube}"), tube, x_m, values }
    };
    let quantity = |label: &str, unit: &str, a: &dyn Fn(f64) -> f64, b: &dyn Fn(f64) -> f64| Quantity {
        label: label.to_owned(),
        unit: unit.to_owned(),
        include_zero: true,
        curves: vec![curve(1, a), curve(2, b)],
    };
    profile_figure(&ProfileInput {
        title: "Sections of R3".to_owned(),
        x_label: "X_{1}".to_owned(),
        quantities: vec![
            quantity("A", "mm²", &|u| 4.0 + 2.0 * u, &|u| 3.0 + 1.5 * u),
            quantity("D", "mm", &|u| 3.9 - 0.8 * u, &|u| -3.2 + 0.6 * u),
            quantity("I_{Z}", "mm⁴", &|u| 1.1 + 2.4 * u * u, &|u| 0.7 + 1.4 * u * u),
        ],
    })
}

fn effort_input() -> XyInput {
    let points: Vec<[f64; 2]> =
        (-55..=55).map(|i| f64::from(i) / 5.0).map(|a| [a, 1.9 * a - 0.009 * a * a * a]).collect();
    let stable = points.iter().map(|p| p[0].abs() < 8.4).collect();
    let other = points.iter().map(|p| [p[0], 1.4 * p[0]]).collect();
    XyInput {
        title: String::new(),
        x: Axis::new("actuation Δa", "mm").with_zero_line(),
        y: Axis::new("axial load", "N").with_zero_line(),
        curves: vec![
            XyCurve { stable, ..XyCurve::new("R3", points) },
            XyCurve::new("R4", other),
            XyCurve { reference: true, ..XyCurve::new("Euler's load", vec![[-11.0, 10.6], [11.0, 10.6]]) },
            XyCurve {
                scattered: true,
                ..XyCurve::new(
                    "measured",
                    vec![[-9.0, -11.2], [-4.0, -6.6], [0.0, 0.2], [4.0, 6.8], [9.0, 11.0]],
                )
            },
        ],
    }
}

fn effort() -> Result<Figure, cppr_plot::PlotError> {
    xy_figure(&effort_input())
}

fn combined() -> Result<Figure, cppr_plot::PlotError> {
    let mut figure = family()?;
    let mut error = xy_figure(&XyInput {
        title: String::new(),
        x: Axis::new("actuation Δa", "mm"),
        y: Axis::new("tip error", "mm"),
        curves: vec![XyCurve {
            marked: true,
            ..XyCurve::new("tip error", (-7..=7).map(f64::from).map(|a| [a, 0.4 + 0.03 * a * a]).collect())
        }],
    })?;
    error.panels[0].height = 160.0;
    figure.panels.append(&mut error.panels);
    Ok(figure)
}
