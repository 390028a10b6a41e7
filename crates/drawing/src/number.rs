//! Numbers as people read them. Only here are digits cut off; files for programs keep every bit.

/// Largest e with 10^e ≤ |x|; 0 for 0 and for what is not finite.
pub fn exponent(x: f64) -> i32 {
    // The printer finds it exactly, on every machine.
    format!("{x:e}")
        .split_once('e')
        .and_then(|(_, exponent)| exponent.parse().ok())
        .unwrap_or(0)
}

/// A number with this many decimals: a true minus sign, groups of three from five digits on, a point before the decimals.
pub fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let plain = format!("{:.decimals$}", value.abs());
    let (whole, fraction) = plain.split_once('.').unwrap_or((&plain, ""));
    let mut text = String::new();
    if value < 0.0 && plain.bytes().any(|b| b.is_ascii_digit() && b != b'0') {
        text.push('−');
    }
    push_groups(&mut text, whole);
    if !fraction.is_empty() {
        text.push('.');
        text.push_str(fraction);
    }
    text
}

/// A whole number with thin spaces.
pub fn count(number: usize) -> String {
    let mut text = String::new();
    push_groups(&mut text, &number.to_string());
    text
}

/// Digits in groups of three, from five digits on.
fn push_groups(text: &mut String, digits: &str) {
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && digits.len() > 4 && (digits.len() - k).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
}

/// A number with this many significant digits: plain from 10⁻⁴ to 10⁶, else with an exponent.
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let rounded = format!("{:.*e}", digits - 1, value);
    let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if value == 0.0 {
        return "0".into();
    }
    if (-4..6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        // Rounded once to the digits, so that 0.0999 with two of them is 0.10.
        let value: f64 = rounded.parse().unwrap_or(value);
        return format!("{value:.decimals$}").replace('-', "−");
    }
    let sign = if exponent < 0 { "⁻" } else { "" };
    let power: String = exponent
        .unsigned_abs()
        .to_string()
        .chars()
        .map(|digit| SUPERSCRIPT[digit as usize - '0' as usize])
        .collect();
    format!("{mantissa}·10{sign}{power}").replace('-', "−")
}

const SUPERSCRIPT: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/// A time given in \[s\], with the prefix that makes it readable.
pub fn time(seconds: f64) -> String {
    let (factor, unit) = match seconds.abs() {
        t if t >= 1.0 => (1.0, "s"),
        t if t >= 1e-3 => (1e3, "ms"),
        _ => (1e6, "µs"),
    };
    let text = significant(seconds * factor, 3);
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    format!("{text} {unit}")
}

/// A relative error in percent.
pub fn percent(error: f64) -> String {
    match error {
        e if e <= 1e-6 => "below 0.0001 %".into(),
        e => format!("{} %", significant(100.0 * e, 2)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_as_people_read_them() {
        // By hand.
        for (value, digits, text) in [
            (0.0999, 2, "0.10"),
            (34.496, 3, "34.5"),
            (1234.5, 2, "1200"),
            (-0.00123, 2, "−0.0012"),
            (2.5e-7, 2, "2.5·10⁻⁷"),
            (3e12, 1, "3·10¹²"),
            (0.0, 3, "0"),
            (f64::NAN, 3, "–"),
        ] {
            assert_eq!(significant(value, digits), text, "{value}");
        }
        for (value, decimals, text) in [
            (12.345, 2, "12.35"),
            (-2.104, 2, "−2.10"),
            (-0.001, 2, "0.00"),
            (23_456.7, 0, "23\u{202f}457"),
            (1_234.5, 1, "1234.5"),
            (f64::INFINITY, 1, "–"),
        ] {
            assert_eq!(fixed(value, decimals), text, "{value}");
        }
        for (seconds, text) in [
            (0.005, "5 ms"),
            (1.5, "1.5 s"),
            (6.3e-5, "63 µs"),
            (0.2, "200 ms"),
        ] {
            assert_eq!(time(seconds), text);
        }
        assert_eq!(percent(0.0294), "2.9 %");
        assert_eq!(percent(1e-9), "below 0.0001 %");
        assert_eq!(count(51840), "51\u{202f}840");
        assert_eq!(count(810), "810");
    }

    #[test]
    fn exponents() {
        for (x, e) in [(1.0, 0), (0.0999, -2), (1234.5, 3), (0.0, 0), (f64::NAN, 0)] {
            assert_eq!(exponent(x), e, "{x}");
        }
    }
}
