//! What is wrong with a file: every problem at once, with its place, its reason and its remedy.

use std::fmt;
use std::ops::Range;
use unicode_width::UnicodeWidthStr;

/// Problems that one report lists; a file with more of them is damaged as a whole.
const LISTED: usize = 50;
/// Longest piece of a source line that is quoted (characters).
const QUOTED: usize = 100;
/// Characters of a long line that are quoted before the place of the problem.
const LEAD: usize = 40;

/// One problem of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Line, from 1; 0 where the problem concerns the file as a whole.
    pub line: usize,
    /// Column in characters, from 1; 0 where the problem concerns the file as a whole.
    pub column: usize,
    /// The value concerned, such as `tube 2, notches.depth_mm`; empty for the file as a whole.
    pub key: String,
    /// What is wrong: a clause without capital and full stop.
    pub message: String,
    /// What to write instead: whole sentences, or empty.
    pub help: String,
    /// The line of the file, where there is one.
    pub excerpt: Option<Excerpt>,
}

/// The quoted line of a problem. Control characters are replaced, long lines are cut.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excerpt {
    /// The text.
    pub text: String,
    /// Where the underlined part begins in `text` (characters, from 0).
    pub start: usize,
    /// Length of the underlined part (characters, at least 1).
    pub length: usize,
}

impl Problem {
    /// Of the file as a whole.
    pub(crate) fn of_file(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self {
            line: 0,
            column: 0,
            key: String::new(),
            message: message.into(),
            help: help.into(),
            excerpt: None,
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.key.is_empty() {
            write!(f, "{}: ", self.key)?;
        }
        write!(f, "{}.", self.message)?;
        if !self.help.is_empty() {
            write!(f, " {}", self.help)?;
        }
        if let Some(excerpt) = &self.excerpt {
            let number = self.line.to_string();
            // Columns of a terminal: some characters take two, some none.
            let columns =
                |from, count| excerpt.text.chars().skip(from).take(count).collect::<String>().width();
            let margin = " ".repeat(number.len());
            let indent = " ".repeat(columns(0, excerpt.start));
            let carets = "^".repeat(columns(excerpt.start, excerpt.length).max(1));
            write!(f, "\n{margin} |\n{number} | {}\n{margin} | {indent}{carets}", excerpt.text)?;
        }
        Ok(())
    }
}

/// All problems of a file, in the order of its lines.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Problems {
    /// Name of the file, as the messages print it.
    pub file: Option<String>,
    /// The problems.
    pub list: Vec<Problem>,
    /// Number of problems beyond those listed.
    pub omitted: usize,
}

impl Problems {
    /// The same problems under the name of the file that has them.
    #[must_use]
    pub fn in_file(self, name: impl Into<String>) -> Self {
        Self { file: Some(name.into()), ..self }
    }

    /// One problem of the file as a whole.
    pub(crate) fn of_file(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { list: vec![Problem::of_file(message, help)], ..Self::default() }
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.list.iter().enumerate() {
            if index > 0 {
                write!(f, "\n\n")?;
            }
            match (&self.file, problem.line) {
                (Some(file), 0) => write!(f, "{file}: ")?,
                (Some(file), line) => write!(f, "{file}:{line}: ")?,
                (None, 0) => {}
                (None, line) => write!(f, "line {line}: ")?,
            }
            write!(f, "{problem}")?;
        }
        if self.omitted > 0 {
            write!(f, "\n\n{} more problems are not listed.", self.omitted)?;
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

/// A problem before its place is looked up.
struct Found {
    span: Range<usize>,
    key: String,
    message: String,
    help: String,
    /// True where something is missing, which a file with syntax errors may only seem to lack.
    absence: bool,
}

/// Collects problems while a text is read.
pub(crate) struct Collector<'t> {
    text: &'t str,
    syntax: Vec<Found>,
    found: Vec<Found>,
}

impl<'t> Collector<'t> {
    pub fn new(text: &'t str) -> Self {
        Self { text, syntax: Vec::new(), found: Vec::new() }
    }

    /// An offence against TOML itself.
    pub fn syntax(&mut self, span: Range<usize>, message: String, help: String) {
        self.syntax.push(Found { span, key: String::new(), message, help, absence: false });
    }

    /// Something that is there and wrong.
    pub fn wrong(
        &mut self,
        span: Range<usize>,
        key: impl Into<String>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let (key, message, help) = (key.into(), message.into(), help.into());
        self.found.push(Found { span, key, message, help, absence: false });
    }

    /// Something that should be there and is not.
    pub fn missing(
        &mut self,
        span: Range<usize>,
        key: impl Into<String>,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        let (key, message, help) = (key.into(), message.into(), help.into());
        self.found.push(Found { span, key, message, help, absence: true });
    }

    pub fn is_empty(&self) -> bool {
        self.syntax.is_empty() && self.found.is_empty()
    }

    /// All problems with their places. Where TOML itself is offended, what stands before the first
    /// offence is trusted and what follows it is not: it may have been read wrongly.
    pub fn finish(mut self) -> Problems {
        let lines = Lines::new(self.text);
        if let Some(first) = self.syntax.iter().map(|p| lines.place(p.span.start).0).min() {
            self.found.retain(|p| !p.absence && lines.place(p.span.end).0 < first);
            // One slip often offends several rules in a row on its line.
            self.syntax.sort_by_key(|p| p.span.start);
            self.syntax.dedup_by_key(|p| lines.place(p.span.start).0);
        }
        let mut all = self.syntax;
        all.append(&mut self.found);
        all.sort_by_key(|p| (p.span.start, p.span.end));
        let omitted = all.len().saturating_sub(LISTED);
        all.truncate(LISTED);
        let list = all.into_iter().map(|p| lines.problem(p)).collect();
        Problems { file: None, list, omitted }
    }
}

/// Places in a text by line and column.
struct Lines<'t> {
    text: &'t str,
    starts: Vec<usize>,
}

impl<'t> Lines<'t> {
    fn new(text: &'t str) -> Self {
        let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        Self { text, starts }
    }

    /// Line from 1, and the byte where it begins.
    fn place(&self, at: usize) -> (usize, usize) {
        let line = self.starts.partition_point(|&start| start <= at).max(1);
        (line, self.starts.get(line - 1).copied().unwrap_or_default())
    }

    fn problem(&self, found: Found) -> Problem {
        let (line, start) = self.place(found.span.start);
        let rest = self.text.get(start..).unwrap_or_default();
        let content = rest.split('\n').next().unwrap_or_default().trim_end_matches('\r');
        let characters = |bytes: usize| content.char_indices().take_while(|(at, _)| *at < bytes).count();
        let from = characters(found.span.start - start);
        let to = characters(found.span.end.saturating_sub(start)).max(from + 1);
        let cut = if content.chars().count() > QUOTED { from.saturating_sub(LEAD) } else { 0 };
        let text = content
            .chars()
            .skip(cut)
            .take(QUOTED)
            .map(|c| if c.is_control() { ' ' } else { c })
            .collect::<String>();
        let excerpt = Excerpt { start: from - cut, length: (to - from).min(QUOTED + cut + 1 - from), text };
        Problem {
            line,
            column: from + 1,
            key: found.key,
            message: found.message,
            help: found.help,
            excerpt: (!content.is_empty()).then_some(excerpt),
        }
    }
}
