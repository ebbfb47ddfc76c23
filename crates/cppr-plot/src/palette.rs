//! Colours and dashes.
//!
//! Tube colours keep apart for the common forms of colour blindness and, because their lightness
//! differs (CIE L* near 25, 54, 72 for tubes 1 to 3), also in grey print. Each colour has its own dash, so
//! that a line is told by its pattern alone.

use crate::figure::{Dash, Stroke};

/// An opaque colour, 8 bits per channel, sRGB.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colour {
    /// Red.
    pub r: u8,
    /// Green.
    pub g: u8,
    /// Blue.
    pub b: u8,
}

impl Colour {
    /// Black.
    pub const BLACK: Self = Self::rgb(0, 0, 0);
    /// White.
    pub const WHITE: Self = Self::rgb(255, 255, 255);
    /// Text and axes: softer than black, still far above the contrast that print needs.
    pub const INK: Self = Self::rgb(0x22, 0x22, 0x22);
    /// Shapes at rest and the baseplate.
    pub const DIM: Self = Self::rgb(0xa8, 0xa8, 0xa8);
    /// Grid lines.
    pub const GRID: Self = Self::rgb(0xe4, 0xe4, 0xe4);
    /// Tip marks.
    pub const TIP: Self = Self::rgb(0x8e, 0x2a, 0x8b);

    /// A colour from its three channels.
    #[must_use]
    pub const fn rgb(r: u8, g: u8, b: u8) -> Self {
        Self { r, g, b }
    }

    /// The mixture `(1 − t) self + t other`, `t` clamped to 0..=1 (NaN counts as 0).
    #[must_use]
    pub fn mix(self, other: Self, t: f64) -> Self {
        let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
        let channel = |a: u8, b: u8| {
            let v = f64::from(a) + t * (f64::from(b) - f64::from(a));
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between two bytes")]
            let v = v.round() as u8;
            v
        };
        Self::rgb(channel(self.r, other.r), channel(self.g, other.g), channel(self.b, other.b))
    }

    /// CIE lightness L* (0 black, 100 white): what is left of a colour in grey print.
    #[must_use]
    pub fn lightness(self) -> f64 {
        let linear = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        let y = 0.2126 * linear(self.r) + 0.7152 * linear(self.g) + 0.0722 * linear(self.b);
        if y <= 0.008_856 { 903.3 * y } else { 116.0 * y.cbrt() - 16.0 }
    }
}

const TUBES: [(Colour, Dash); 6] = [
    (Colour::rgb(0x0b, 0x3c, 0x6f), Dash::Solid),
    (Colour::rgb(0xd9, 0x54, 0x1e), Dash::Dashed),
    (Colour::rgb(0x4b, 0xbd, 0xae), Dash::DashDot),
    (Colour::rgb(0x8b, 0x2f, 0x7f), Dash::LongDash),
    (Colour::rgb(0xd0, 0xa2, 0x00), Dash::Dotted),
    (Colour::rgb(0x5a, 0x5a, 0x5a), Dash::DashDotDot),
];

/// Line of tube `number` (from 1, the leader), or of the curve of that rank in a plot. Patterns
/// repeat after six.
#[must_use]
pub fn tube_stroke(number: usize) -> Stroke {
    let (colour, dash) = TUBES[number.saturating_sub(1) % TUBES.len()];
    Stroke { colour, width: 2.0, dash }
}

/// The dark-blue to ochre part of the cividis map: lightness rises evenly, so that the order of values
/// survives grey print; the pale yellow end is left out because it fades on white paper.
const RAMP: [Colour; 6] = [
    Colour::rgb(0x00, 0x22, 0x4e),
    Colour::rgb(0x35, 0x45, 0x6c),
    Colour::rgb(0x66, 0x69, 0x70),
    Colour::rgb(0x94, 0x8e, 0x77),
    Colour::rgb(0xb5, 0xa5, 0x6c),
    Colour::rgb(0xd9, 0xbf, 0x55),
];

/// Colour of a value, `t` from 0 (dark blue) to 1 (ochre).
#[must_use]
pub fn ramp(t: f64) -> Colour {
    let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
    let mut left = t * 5.0;
    let mut at = 0;
    while left > 1.0 && at + 2 < RAMP.len() {
        left -= 1.0;
        at += 1;
    }
    RAMP[at].mix(RAMP[at + 1], left)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_three_tubes_differ_in_grey() {
        let l: Vec<f64> = (1..=3).map(|n| tube_stroke(n).colour.lightness()).collect();
        assert!(l[1] - l[0] > 15.0 && l[2] - l[1] > 15.0, "{l:?}");
        assert!(l[2] < 80.0, "too pale on white: {l:?}");
    }

    #[test]
    fn ramp_brightens_evenly() {
        let l: Vec<f64> = (0..=20).map(|i| ramp(f64::from(i) / 20.0).lightness()).collect();
        assert!(l.windows(2).all(|w| w[1] > w[0]), "{l:?}");
    }
}
