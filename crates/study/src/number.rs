//! How numbers are shown to people. CSV keeps every bit.

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

/// A time with the prefix that makes it readable.
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

/// CPU time per simulated time, and what that is in real time.
pub fn speed(cost: f64) -> String {
    if cost <= 1.0 {
        format!("{}× real time", significant(1.0 / cost, 2))
    } else {
        format!("{}× too slow", significant(cost, 2))
    }
}

/// Large whole numbers with thin spaces.
pub fn count(number: usize) -> String {
    let plain = number.to_string();
    let mut text = String::new();
    for (k, digit) in plain.chars().enumerate() {
        if k > 0 && plain.len() > 4 && (plain.len() - k).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
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
        assert_eq!(speed(0.125), "8.0× real time");
        assert_eq!(speed(12.0), "12× too slow");
        assert_eq!(count(51840), "51\u{202f}840");
        assert_eq!(count(810), "810");
    }
}
