//! Text: the embedded font (Noto Sans, SIL Open Font License 1.1), its widths, and sub- and
//! superscripts.

use ttf_parser::{Face, GlyphId};

use crate::error::PlotError;

/// Size of sub- and superscripts relative to the text.
pub(crate) const SCRIPT: f64 = 0.72;

/// A stretch of text at one height.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Run {
    pub(crate) text: String,
    /// Relative size.
    pub(crate) size: f64,
    /// Downward shift of the baseline in ems of the surrounding text.
    pub(crate) drop: f64,
}

/// Splits `I_{Z} (mm^{4})` into runs. Braces that do not close stay as they are.
pub(crate) fn runs(text: &str) -> Vec<Run> {
    let mut out = Vec::new();
    let mut push = |text: &str, size: f64, drop: f64| {
        // Control characters have no glyph and most of them are not allowed in XML.
        let text: String = text.chars().filter(|c| !c.is_control()).collect();
        if !text.is_empty() {
            out.push(Run { text, size, drop });
        }
    };
    let mut rest = text;
    while let Some(at) = next_script(rest) {
        let inner = &rest[at + 2..];
        let Some(end) = inner.find('}') else { break };
        push(&rest[..at], 1.0, 0.0);
        let drop = if rest[at..].starts_with('_') { 0.18 } else { -0.36 };
        push(&inner[..end], SCRIPT, drop);
        rest = &inner[end + 1..];
    }
    push(rest, 1.0, 0.0);
    out
}

fn next_script(text: &str) -> Option<usize> {
    match (text.find("_{"), text.find("^{")) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}

/// The embedded font.
pub(crate) struct Font {
    pub(crate) face: Face<'static>,
}

impl Font {
    pub(crate) fn load() -> Result<Self, PlotError> {
        let face = Face::parse(notosans::REGULAR_TTF, 0).map_err(|_| PlotError::Font)?;
        Ok(Self { face })
    }

    /// Glyph of a character and its advance in ems.
    pub(crate) fn glyph(&self, c: char) -> (GlyphId, f64) {
        let id = self.face.glyph_index(c).unwrap_or_default();
        let advance = self.face.glyph_hor_advance(id).unwrap_or_default();
        (id, f64::from(advance) / f64::from(self.face.units_per_em()))
    }

    /// Width in px of a text, markup taken into account.
    pub(crate) fn width(&self, text: &str, size: f64) -> f64 {
        runs(text)
            .iter()
            .map(|run| {
                let ems: f64 = run.text.chars().map(|c| self.glyph(c).1).sum();
                ems * run.size * size
            })
            .sum()
    }

    /// Breaks a text at spaces into lines no wider than `width` px where words allow.
    pub(crate) fn wrap(&self, text: &str, size: f64, width: f64) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            match lines.last_mut() {
                Some(line) if self.width(&format!("{line} {word}"), size) <= width => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_becomes_runs() {
        let r = runs("I_{Z} (mm^{4})");
        let texts: Vec<&str> = r.iter().map(|r| r.text.as_str()).collect();
        assert_eq!(texts, ["I", "Z", " (mm", "4", ")"]);
        assert!(r[1].drop > 0.0 && r[3].drop < 0.0);
        assert_eq!(runs("a_b ^{open").len(), 1);
        assert!(runs("").is_empty());
    }

    #[test]
    fn font_has_every_character_figures_use() -> Result<(), PlotError> {
        let font = Font::load()?;
        for c in "ABCXYZabc019ΔαβγδθκρμπΩ−±×·°²³⁴(),./%é".chars() {
            assert_ne!(font.glyph(c).0, GlyphId(0), "{c}");
        }
        Ok(())
    }
}
