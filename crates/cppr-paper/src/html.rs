//! The report as one HTML file that needs nothing else.

use crate::{Page, PaperError, Table};
use std::fmt::Write;

const STYLE: &str = "
:root{color-scheme:light dark;--ink:#1b1b1b;--paper:#fff;--line:#ccc;--dim:#666}
@media(prefers-color-scheme:dark){:root{--ink:#e8e8e8;--paper:#181818;--line:#444;--dim:#aaa}}
body{font:16px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:62rem;margin:2rem auto;padding:0 1rem}
h1,h2{line-height:1.2}h2{margin-top:3rem;border-top:1px solid var(--line);padding-top:1rem}
nav ol{columns:2}figure{margin:1.5rem 0;background:#fff;color:#1b1b1b;padding:.5rem;border:1px solid var(--line)}
figure svg{max-width:100%;height:auto;display:block;margin:auto}figcaption,caption{color:#555;font-size:.9rem;text-align:left}
caption{color:var(--dim);padding:.3rem 0}.wide{overflow-x:auto}
table{border-collapse:collapse;font-size:.85rem;font-variant-numeric:tabular-nums}
th,td{border-bottom:1px solid var(--line);padding:.15rem .6rem;text-align:right}th:first-child,td:first-child{text-align:left}
.dim{color:var(--dim)}";

/// Text as HTML.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn table(table: &Table) -> String {
    let cells = |tag: &str, list: &[String]| -> String {
        list.iter().fold(String::new(), |row, c| row + &format!("<{tag}>{}</{tag}>", escape(c)))
    };
    let rows: String =
        table.rows.iter().fold(String::new(), |all, r| all + &format!("<tr>{}</tr>", cells("td", r)));
    format!(
        "<div class=wide><table><caption>{}</caption><thead><tr>{}</tr></thead><tbody>{rows}</tbody></table></div>",
        escape(&table.caption),
        cells("th", &table.head)
    )
}

/// All pages in one file.
///
/// # Errors
/// Where a figure cannot be drawn.
pub fn html(pages: &[Page]) -> Result<String, PaperError> {
    let mut body = String::new();
    let mut contents = String::new();
    for page in pages {
        let _ = write!(contents, "<li><a href=\"#{}\">{}</a></li>", page.name, escape(&page.title));
        let _ = write!(body, "<h2 id=\"{}\">{}</h2>", page.name, escape(&page.title));
        let _ = write!(body, "<p class=dim>Section {} of the paper</p>", escape(&page.section));
        for text in &page.text {
            let _ = write!(body, "<p>{}</p>", escape(text));
        }
        for (_, caption, figure) in &page.figures {
            let svg = figure.to_svg()?;
            // An XML declaration has no place inside a page.
            let svg = svg.find("<svg").map_or("", |at| &svg[at..]);
            let _ = write!(body, "<figure>{svg}<figcaption>{}</figcaption></figure>", escape(caption));
        }
        for own in &page.tables {
            body.push_str(&table(own));
        }
    }
    Ok(format!(
        "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width\">\
         <title>cppr: Tummers et al. 2024, computed again</title><style>{STYLE}</style>\
         <h1>Continuum concentric push-pull robots: section 4, computed again</h1>\
         <p>What Tummers et al. 2024 (<i>Continuum concentric push-pull robots: a Cosserat rod model</i>) compute, in the \
         consistent formulation and as printed. Robots: <code>robots/</code>; scenarios: <code>paper/</code>; \
         made by <code>cppr paper</code>. The experiments of the paper are not available as data; where they are needed the \
         printed model at the paper's factors stands in, and the text says so.</p>\
         <nav><ol>{contents}</ol></nav>{body}</html>\n"
    ))
}
