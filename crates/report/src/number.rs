//! How numbers are shown to people: as many digits as their unit deserves, both decimal signs. Only here are digits cut
//! off; JSON and CSV keep every bit.

use microsim_drawing::exponent;
use microsim_message::LocalText;
use std::borrow::Cow;

/// A number with this many decimals, in both languages.
pub fn fixed(value: f64, decimals: usize) -> LocalText {
    let en = microsim_drawing::fixed(value, decimals);
    LocalText::new(en.replace('.', ","), en)
}

/// A value as people read it: three digits, but no more decimals than its unit deserves.
pub fn shown(value: f64, unit: &str) -> LocalText {
    with_unit(fixed(value, decimals(value, unit)), unit)
}

/// A value and its limits. A value outside must not look as if it were on the limit: digits are added until they differ.
pub fn against_limits(
    value: Option<f64>,
    limits: &[f64],
    unit: &str,
    within: Option<bool>,
) -> (Option<LocalText>, Vec<LocalText>) {
    let mut extra = 0;
    let text = |value: f64, extra| fixed(value, decimals(value, unit) + extra);
    let limit = |limit: f64, extra| trimmed(text(limit, extra));
    while let Some(value) = value
        && within == Some(false)
        && extra < 9
        && limits
            .iter()
            .any(|&l| trimmed(text(value, extra)) == limit(l, extra))
    {
        extra += 1;
    }
    (
        value.map(|value| with_unit(text(value, extra), unit)),
        limits
            .iter()
            .map(|&l| with_unit(limit(l, extra), unit))
            .collect(),
    )
}

/// Decimals for three digits, at most as many as make sense in the unit.
fn decimals(value: f64, unit: &str) -> usize {
    let most = match unit {
        // A count, or a dimensionless number.
        "" | "1" if value == value.trunc() => 0,
        "" | "1" => 2,
        "s" | "%" | "°" | "µm" | "mN" => 1,
        "mm³" => 0,
        _ => 3,
    };
    let digits = 2 - exponent(value);
    // A small value keeps at least its first digit.
    let least = if value == 0.0 { 0 } else { -exponent(value) };
    (digits.clamp(0, most).max(least.clamp(0, 9))) as usize
}

/// Without zeros at the end of the fraction.
fn trimmed(text: LocalText) -> LocalText {
    let cut = |text: Cow<'static, str>, sign| {
        if text.contains(sign) {
            let short = text.trim_end_matches('0').trim_end_matches(sign);
            short.to_owned().into()
        } else {
            text
        }
    };
    LocalText::new(cut(text.de, ','), cut(text.en, '.'))
}

fn with_unit(number: LocalText, unit: &str) -> LocalText {
    let space = match unit {
        "" | "1" => return number,
        "°" => "",
        _ => "\u{a0}",
    };
    LocalText::new(
        format!("{}{space}{unit}", number.de),
        format!("{}{space}{unit}", number.en),
    )
}

/// A moment in Coordinated Universal Time, to the minute; `seconds` since 1970.
pub fn date_time(seconds: u64) -> LocalText {
    // Days to a date of the Gregorian calendar, in years that begin in March, so that the leap day is the last one
    // (H. Hinnant, chrono-Compatible Low-Level Date Algorithms, civil_from_days).
    let days = seconds / 86_400 + 719_468;
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 {
        shifted + 3
    } else {
        shifted - 9
    };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    let (hour, minute) = (seconds / 3_600 % 24, seconds / 60 % 60);
    LocalText::new(
        format!("{day:02}.{month:02}.{year}, {hour:02}:{minute:02} UTC (Weltzeit, nicht Ortszeit)"),
        format!(
            "{year}-{month:02}-{day:02}, {hour:02}:{minute:02} UTC (universal, not local time)"
        ),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_both_languages() {
        for (value, unit, de, en) in [
            (1109.963, "mm", "1110\u{a0}mm", "1110\u{a0}mm"),
            (12.345, "mm", "12,3\u{a0}mm", "12.3\u{a0}mm"),
            (47.0, "s", "47,0\u{a0}s", "47.0\u{a0}s"),
            (-2.104, "", "−2,10", "−2.10"),
            (17.0, "", "17", "17"),
            (31.4, "°", "31,4°", "31.4°"),
            (
                23_456.7,
                "mm³",
                "23\u{202f}457\u{a0}mm³",
                "23\u{202f}457\u{a0}mm³",
            ),
            (0.00123, "mm", "0,001\u{a0}mm", "0.001\u{a0}mm"),
            (-0.0, "s", "0,0\u{a0}s", "0.0\u{a0}s"),
            (f64::NAN, "s", "–\u{a0}s", "–\u{a0}s"),
        ] {
            let text = shown(value, unit);
            assert_eq!((&text.de[..], &text.en[..]), (de, en), "{value} {unit}");
        }
    }

    /// 60.04 s and 60 s would both read 60.0 s; a failed metric must show the difference, a passed one need not.
    #[test]
    fn a_value_outside_does_not_look_like_the_limit() {
        let (value, limits) = against_limits(Some(60.04), &[60.0], "s", Some(false));
        assert_eq!(value.map(|v| v.en), Some("60.04\u{a0}s".into()));
        assert_eq!(limits[0].en, "60\u{a0}s");
        let (value, _) = against_limits(Some(59.96), &[60.0], "s", Some(true));
        assert_eq!(value.map(|v| v.en), Some("60.0\u{a0}s".into()));
    }

    /// From any calendar; `date -u -d @N` gives the same.
    #[test]
    fn moments() {
        for (seconds, en) in [
            (0, "1970-01-01, 00:00 UTC"),
            (951_782_399, "2000-02-28, 23:59 UTC"),
            (951_782_400, "2000-02-29, 00:00 UTC"),
            (1_700_000_000, "2023-11-14, 22:13 UTC"),
            (1_735_689_600, "2025-01-01, 00:00 UTC"),
        ] {
            let text = date_time(seconds);
            // Whoever does not know what UTC is would take it for the clock on the wall.
            assert_eq!(text.en, format!("{en} (universal, not local time)"));
            assert!(text.de.ends_with(" UTC (Weltzeit, nicht Ortszeit)"));
        }
    }
}
