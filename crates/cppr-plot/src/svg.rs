//! Writes a scene as SVG 1.1.
//!
//! Text stays text (searchable, editable) in a generic sans-serif; all other marks are paths. Coordinates
//! carry three decimals, a thousandth of a px, those of dots one. The same scene gives the same bytes.

use std::fmt::Write;

use crate::font::{SCRIPT, runs};
use crate::palette::Colour;
use crate::scene::{Anchor, Item, Path, Scene, Text};

/// The document.
pub(crate) fn write(scene: &Scene) -> String {
    let mut out = String::with_capacity(16_384);
    let (w, h) = (num(scene.width), num(scene.height));
    put(
        &mut out,
        format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" \
             viewBox=\"0 0 {w} {h}\" font-family=\"'Noto Sans', Arial, Helvetica, sans-serif\" \
             role=\"img\">\n"
        ),
    );
    if !scene.title.is_empty() {
        let plain: String = runs(&scene.title).into_iter().map(|r| r.text).collect();
        put(&mut out, format_args!("<title>{}</title>\n", escape(&plain)));
    }
    put(&mut out, format_args!("<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n"));
    for item in &scene.items {
        match item {
            Item::Open { class } => put(&mut out, format_args!("<g class=\"{class}\">\n")),
            Item::Close => out.push_str("</g>\n"),
            Item::Path(path) => write_path(&mut out, path),
            Item::Dots { points, size, colour } => write_dots(&mut out, points, *size, *colour),
            Item::Text(text) => write_text(&mut out, text),
        }
    }
    out.push_str("</svg>\n");
    out
}

fn put(out: &mut String, args: std::fmt::Arguments<'_>) {
    // Writing to a String cannot fail.
    let _ = out.write_fmt(args);
}

fn write_path(out: &mut String, path: &Path) {
    if path.points.is_empty() {
        return;
    }
    out.push_str("<path");
    if !path.class.is_empty() {
        put(out, format_args!(" class=\"{}\"", path.class));
    }
    if !path.name.is_empty() {
        let plain: String = runs(&path.name).into_iter().map(|r| r.text).collect();
        put(out, format_args!(" data-name=\"{}\"", escape(&plain)));
    }
    out.push_str(" d=\"");
    for (i, p) in path.points.iter().enumerate() {
        let letter = match i {
            0 => "M",
            1 => "L",
            _ => " ",
        };
        put(out, format_args!("{letter}{} {}", num(p[0]), num(p[1])));
    }
    if path.closed {
        out.push('Z');
    }
    out.push('"');
    match path.fill {
        Some((colour, opacity)) => {
            put(out, format_args!(" fill=\"{}\"", hex(colour)));
            if opacity < 1.0 {
                put(out, format_args!(" fill-opacity=\"{}\"", num(opacity)));
            }
        }
        None => out.push_str(" fill=\"none\""),
    }
    if let Some(pen) = &path.pen {
        put(
            out,
            format_args!(
                " stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
                hex(pen.colour),
                num(pen.width)
            ),
        );
        if !pen.dash.is_empty() {
            let dash: Vec<String> = pen.dash.iter().map(|d| num(*d)).collect();
            put(out, format_args!(" stroke-dasharray=\"{}\"", dash.join(" ")));
        }
    }
    out.push_str("/>\n");
}

/// One path for all: lines of no length with round ends.
fn write_dots(out: &mut String, points: &[[f64; 2]], size: f64, colour: Colour) {
    put(out, format_args!("<path class=\"dots\" fill=\"none\" stroke=\"{}\"", hex(colour)));
    put(out, format_args!(" stroke-width=\"{}\" stroke-linecap=\"round\" d=\"", num(size)));
    for p in points {
        put(out, format_args!("M{:.1} {:.1}h0", p[0], p[1]));
    }
    out.push_str("\"/>\n");
}

fn write_text(out: &mut String, text: &Text) {
    let anchor = match text.anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
        Anchor::End => "end",
    };
    let (x, y) = (num(text.at[0]), num(text.at[1]));
    put(
        out,
        format_args!(
            "<text xml:space=\"preserve\" x=\"{x}\" y=\"{y}\" font-size=\"{}\" text-anchor=\"{anchor}\" fill=\"{}\"",
            num(text.size),
            hex(text.colour)
        ),
    );
    if text.upwards {
        put(out, format_args!(" transform=\"rotate(-90 {x} {y})\""));
    }
    if text.rim {
        out.push_str(
            " stroke=\"#ffffff\" stroke-width=\"3\" stroke-linejoin=\"round\" paint-order=\"stroke\"",
        );
    }
    out.push('>');
    let mut drop = 0.0;
    for run in runs(&text.content) {
        let step = (run.drop - drop) * text.size;
        drop = run.drop;
        let script = run.size < 1.0;
        if script || step.abs() > 0.0 {
            put(out, format_args!("<tspan dy=\"{}\"", num(step)));
            if script {
                put(out, format_args!(" font-size=\"{}\"", num(SCRIPT * text.size)));
            }
            put(out, format_args!(">{}</tspan>", escape(&run.text)));
        } else {
            out.push_str(&escape(&run.text));
        }
    }
    out.push_str("</text>\n");
}

fn hex(c: Colour) -> String {
    format!("#{:02x}{:02x}{:02x}", c.r, c.g, c.b)
}

/// Three decimals at most, no trailing zeros, no negative zero.
fn num(v: f64) -> String {
    let text = format!("{v:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // Outside the characters of XML 1.0.
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}
