//! Axis ticks at 1, 2 or 5 times a power of ten.

/// Ticks of one axis.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ticks {
    pub(crate) values: Vec<f64>,
    pub(crate) labels: Vec<String>,
    /// Labels are in units of ten to this power; 0 where plain numbers are short.
    pub(crate) exponent: i32,
}

/// A whole count as a number.
pub(crate) fn count(n: usize) -> f64 {
    u32::try_from(n).map_or(f64::from(u32::MAX), f64::from)
}

/// Step of 1, 2 or 5 × 10^k that divides `span` into at most `most` parts (at least two).
pub(crate) fn nice_step(span: f64, most: f64) -> f64 {
    let raw = span / most.max(2.0);
    let decade = 10_f64.powf(raw.log10().floor());
    for factor in [1.0, 2.0, 5.0, 10.0] {
        // The margin keeps a span of exactly n steps from being lost to rounding.
        if factor * decade >= raw * (1.0 - 1e-9) {
            return factor * decade;
        }
    }
    10.0 * decade
}

/// Ticks within `low..=high`, no more than `most + 1`.
pub(crate) fn ticks(low: f64, high: f64, most: f64) -> Ticks {
    ticks_at(low, high, nice_step(high - low, most))
}

/// Ticks within `low..=high` at the multiples of `step`.
pub(crate) fn ticks_at(low: f64, high: f64, step: f64) -> Ticks {
    let span = high - low;
    if !(step.is_finite() && step > 0.0) {
        return Ticks::default();
    }
    let slack = 1e-6 * span;
    let mut values = Vec::new();
    let mut k = ((low - slack) / step).ceil();
    // The bound only matters where rounding makes `k + 1` equal to `k`.
    while k * step <= high + slack && values.len() < 100 {
        values.push(k * step);
        k += 1.0;
    }
    let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let exponent = if largest >= 99_999.5 || (largest > 0.0 && step < 0.99e-3) {
        #[allow(clippy::cast_possible_truncation, reason = "between -308 and 308")]
        let e = largest.log10().floor() as i32;
        // Multiples of three read like the prefixes of units.
        3 * e.div_euclid(3)
    } else {
        0
    };
    let unit = 10_f64.powi(exponent);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped between 0 and 12")]
    let digits = (-(step / unit).log10() - 1e-9).ceil().clamp(0.0, 12.0) as usize;
    let labels = values.iter().map(|v| number(v / unit, digits)).collect();
    Ticks { values, labels, exponent }
}

/// Fixed decimals with a typographic minus, no negative zero.
pub(crate) fn number(v: f64, digits: usize) -> String {
    let text = format!("{:.digits$}", v.abs());
    let zero = !text.contains(|c: char| c.is_ascii_digit() && c != '0');
    if v < 0.0 && !zero { format!("−{text}") } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_numbers() {
        let t = ticks(-7.3, 7.3, 6.0);
        assert_eq!(t.labels, ["−5", "0", "5"]);
        let t = ticks(0.0, 0.1, 5.0);
        assert_eq!(t.labels, ["0.00", "0.02", "0.04", "0.06", "0.08", "0.10"]);
        let t = ticks(0.0, 1.2e7, 4.0);
        assert_eq!((t.exponent, t.labels.as_slice()), (6, ["0", "5", "10"].map(String::from).as_slice()));
    }

    #[test]
    fn small_numbers_share_a_power_of_ten() {
        let t = ticks(0.0, 4e-5, 4.0);
        assert_eq!(t.exponent, -6);
        assert_eq!(t.labels, ["0", "10", "20", "30", "40"]);
    }

    #[test]
    fn odd_ranges_end() {
        for (low, high) in [(0.0, 0.0), (1e9, 1e9 + 1e-9), (0.0, f64::INFINITY), (f64::NAN, 1.0)] {
            assert!(ticks(low, high, 5.0).values.len() <= 100);
        }
    }
}
