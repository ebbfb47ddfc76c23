//! Offences against TOML itself, in the words of this crate.

use crate::problems::Collector;
use std::ops::Range;
use toml::de::Error;

/// Reports what the TOML parser found, without what merely follows from it.
pub(crate) fn report_syntax(text: &str, errors: &[Error], out: &mut Collector) {
    let mut errors: Vec<_> = errors.iter().map(|error| (error.span().unwrap_or_default(), error)).collect();
    errors.sort_by_key(|(span, _)| span.start);
    let headers = header_lines(text);
    // The header of the table that comes twice: its keys come twice as well, which is no news.
    let mut repeated = None;
    for (span, error) in errors {
        let before = headers.partition_point(|line| line.start <= span.start);
        let table = before.checked_sub(1).and_then(|index| headers.get(index));
        let is_header = table.is_some_and(|line| line.contains(&span.start));
        let duplicate = error.message().contains("duplicate");
        if duplicate && !is_header && table.is_some() && table == repeated {
            continue;
        }
        if duplicate && is_header {
            repeated = table;
        }
        let (message, help) = if duplicate && is_header {
            let help = "Keep one of the two; every further tube begins with [[tube]].";
            ("this table is there already".to_owned(), help)
        } else if duplicate {
            ("this key is there already".to_owned(), "Keep one of the two.")
        } else if error.message().contains("must be quoted") {
            let help = "Write texts in double quotes, and numbers with a point and without their unit.";
            ("this is neither a number nor a text in quotes".to_owned(), help)
        } else {
            let message = error.message().trim_end_matches('.').replace('\n', ", ");
            (message, "Write key = value, one per line, and headers in brackets.")
        };
        out.syntax(span, message, help.to_owned());
    }
}

/// The places of all lines that begin with a bracket.
fn header_lines(text: &str) -> Vec<Range<usize>> {
    let mut start = 0;
    let mut headers = Vec::new();
    for line in text.split_inclusive('\n') {
        let end = start + line.len();
        if line.trim_start().starts_with('[') {
            headers.push(start..end);
        }
        start = end;
    }
    headers
}
