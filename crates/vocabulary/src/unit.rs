//! Physical units: from "0.12 mm" to 0.00012, exactly.
//!
//! A text quantity gives the same `f64` as the SI literal, because a power of ten is moved into the decimal exponent
//! before the one rounding that parsing does: "0.12 mm" is parsed as `0.12e-3`, not as `0.12 * 1e-3`, which would round
//! twice. What is not here: arithmetic with units; inside the program every value is SI.

use serde::{Deserialize, Serialize};

/// The dimension of a quantity. Values are always stored in the first symbol of [`Unit::symbols`], the SI unit.
///
/// In files and manifests a dimension is named by that symbol, for example `unit = "rad"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "&'static str")]
pub enum Unit {
    /// A pure number, a fraction, a score; `1` or `%`.
    Ratio,
    /// How many of something; `count`.
    Count,
    /// \[m\]
    Length,
    /// \[m²\]
    Area,
    /// \[m³\]
    Volume,
    /// \[s\]
    Time,
    /// \[rad\]
    Angle,
    /// \[Hz\], events per second.
    Frequency,
    /// \[1/s\], decay per second, such as drag per mass.
    Rate,
    /// \[m/s\]
    Speed,
    /// \[rad/s\]
    AngularSpeed,
    /// \[m/s²\]
    Acceleration,
    /// \[kg\]
    Mass,
    /// \[kg/m³\]
    Density,
    /// \[N\]
    Force,
    /// \[N s\]
    Impulse,
    /// \[Pa\]
    Pressure,
    /// \[Pa s\]
    Viscosity,
    /// \[J\]
    Energy,
    /// \[N m\]
    Torque,
    /// \[N/m\], force per change of a length; the same as energy per area, \[J/m²\].
    LengthStiffness,
    /// \[N/m³\], force per length and area: that of springs between surfaces, or of plain area springs.
    AreaStiffness,
    /// \[N/m⁵\], that of plain volume springs.
    VolumeStiffness,
    /// \[N s/m\], force per speed of a length.
    LengthDamping,
    /// \[N s/m³\], that of plain area springs.
    AreaDamping,
    /// \[N s/m⁵\], that of plain volume springs.
    VolumeDamping,
    /// \[J s\], damping of normalised springs.
    Action,
}

/// Why a text is no quantity of the wanted unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum QuantityError {
    /// The text does not begin with a decimal number.
    NotANumber,
    /// A number without a unit, where the unit cannot be guessed.
    NoUnit,
    /// The unit belongs to another dimension (given, if known) or to none.
    WrongUnit(Option<Unit>),
    /// The number is too large for an `f64`.
    NotFinite,
}

/// How a symbol relates to the SI unit.
#[derive(Clone, Copy)]
enum Scale {
    /// One of it is 10ⁿ of the SI unit.
    Ten(i32),
    /// Whole multiple of the SI unit.
    Times(f64),
    /// π/180 of the SI unit.
    Degree,
}

impl Scale {
    /// The SI value of a decimal number written with this symbol; `exponent` is the power of ten written in the text.
    fn parse(self, mantissa: &str, exponent: i64) -> Option<f64> {
        let shift = match self {
            Scale::Ten(n) => i64::from(n),
            Scale::Times(_) | Scale::Degree => 0,
        };
        // Beyond ±10000 every f64 is zero or infinite, unless the mantissa has thousands of digits.
        let exponent = exponent.saturating_add(shift).clamp(-10_000, 10_000);
        let value: f64 = format!("{mantissa}e{exponent}").parse().ok()?;
        Some(match self {
            Scale::Ten(_) => value,
            Scale::Times(factor) => value * factor,
            Scale::Degree => value.to_radians(),
        })
    }

    /// `si` expressed in this symbol.
    fn display(self, si: f64) -> f64 {
        match self {
            // Powers of ten up to 22 are exact in f64, their inverses are not: divide or multiply by the exact one.
            Scale::Ten(n) if n < 0 => si * exact_power_of_ten(n.unsigned_abs()),
            Scale::Ten(n) => si / exact_power_of_ten(n.unsigned_abs()),
            Scale::Times(factor) => si / factor,
            Scale::Degree => si.to_degrees(),
        }
    }

    /// A number in this symbol as an SI value.
    fn si(self, number: f64) -> f64 {
        match self {
            Scale::Ten(n) if n < 0 => number / exact_power_of_ten(n.unsigned_abs()),
            Scale::Ten(n) => number * exact_power_of_ten(n.unsigned_abs()),
            Scale::Times(factor) => number * factor,
            Scale::Degree => number.to_radians(),
        }
    }
}

/// 10ⁿ by repeated exact multiplication; exact for n ≤ 22, and no symbol needs more.
fn exact_power_of_ten(n: u32) -> f64 {
    (0..n).fold(1.0, |power, _| power * 10.0)
}

use Scale::{Degree, Ten, Times};

impl Unit {
    /// Every dimension.
    pub const ALL: [Unit; 27] = [
        Unit::Ratio,
        Unit::Count,
        Unit::Length,
        Unit::Area,
        Unit::Volume,
        Unit::Time,
        Unit::Angle,
        Unit::Frequency,
        Unit::Rate,
        Unit::Speed,
        Unit::AngularSpeed,
        Unit::Acceleration,
        Unit::Mass,
        Unit::Density,
        Unit::Force,
        Unit::Impulse,
        Unit::Pressure,
        Unit::Viscosity,
        Unit::Energy,
        Unit::Torque,
        Unit::LengthStiffness,
        Unit::AreaStiffness,
        Unit::VolumeStiffness,
        Unit::LengthDamping,
        Unit::AreaDamping,
        Unit::VolumeDamping,
        Unit::Action,
    ];

    /// Symbols with their scale, the SI unit first, then from large to small.
    fn table(self) -> &'static [(&'static str, Scale)] {
        match self {
            Unit::Ratio => &[("1", Ten(0)), ("%", Ten(-2))],
            Unit::Count => &[("count", Ten(0))],
            Unit::Length => &[
                ("m", Ten(0)),
                ("cm", Ten(-2)),
                ("mm", Ten(-3)),
                ("um", Ten(-6)),
                ("nm", Ten(-9)),
            ],
            Unit::Area => &[("m^2", Ten(0)), ("cm^2", Ten(-4)), ("mm^2", Ten(-6))],
            Unit::Volume => &[("m^3", Ten(0)), ("cm^3", Ten(-6)), ("mm^3", Ten(-9))],
            Unit::Time => &[
                ("s", Ten(0)),
                ("min", Times(60.0)),
                ("ms", Ten(-3)),
                ("us", Ten(-6)),
                ("ns", Ten(-9)),
            ],
            Unit::Angle => &[("rad", Ten(0)), ("deg", Degree), ("mrad", Ten(-3))],
            Unit::Frequency => &[("Hz", Ten(0)), ("kHz", Ten(3))],
            Unit::Rate => &[("1/s", Ten(0)), ("1/ms", Ten(3))],
            Unit::Speed => &[("m/s", Ten(0)), ("mm/s", Ten(-3)), ("um/s", Ten(-6))],
            Unit::AngularSpeed => &[("rad/s", Ten(0)), ("deg/s", Degree)],
            Unit::Acceleration => &[("m/s^2", Ten(0)), ("mm/s^2", Ten(-3))],
            Unit::Mass => &[
                ("kg", Ten(0)),
                ("g", Ten(-3)),
                ("mg", Ten(-6)),
                ("ug", Ten(-9)),
            ],
            Unit::Density => &[("kg/m^3", Ten(0)), ("g/cm^3", Ten(3))],
            Unit::Force => &[("N", Ten(0)), ("mN", Ten(-3)), ("uN", Ten(-6))],
            Unit::Impulse => &[("N s", Ten(0)), ("mN s", Ten(-3)), ("uN s", Ten(-6))],
            Unit::Pressure => &[
                ("Pa", Ten(0)),
                ("GPa", Ten(9)),
                ("MPa", Ten(6)),
                ("kPa", Ten(3)),
            ],
            Unit::Viscosity => &[("Pa s", Ten(0)), ("kPa s", Ten(3)), ("mPa s", Ten(-3))],
            Unit::Energy => &[
                ("J", Ten(0)),
                ("mJ", Ten(-3)),
                ("uJ", Ten(-6)),
                ("nJ", Ten(-9)),
            ],
            Unit::Torque => &[("N m", Ten(0)), ("mN m", Ten(-3)), ("uN m", Ten(-6))],
            Unit::LengthStiffness => &[("N/m", Ten(0)), ("kN/m", Ten(3)), ("J/m^2", Ten(0))],
            Unit::AreaStiffness => &[("N/m^3", Ten(0)), ("N/mm^3", Ten(9))],
            Unit::VolumeStiffness => &[("N/m^5", Ten(0))],
            Unit::LengthDamping => &[("N s/m", Ten(0)), ("mN s/m", Ten(-3))],
            Unit::AreaDamping => &[("N s/m^3", Ten(0))],
            Unit::VolumeDamping => &[("N s/m^5", Ten(0))],
            Unit::Action => &[("J s", Ten(0)), ("nJ s", Ten(-9))],
        }
    }

    /// The symbol of the SI unit, in which values are stored.
    pub fn symbol(self) -> &'static str {
        self.table()[0].0
    }

    /// Every symbol that a file may use, the SI unit first.
    pub fn symbols(self) -> impl Iterator<Item = &'static str> {
        self.table().iter().map(|(symbol, _)| *symbol)
    }

    /// The dimension that has this symbol, in any of its scales ("mm" gives `Length`).
    pub fn of_symbol(symbol: &str) -> Option<Unit> {
        let symbol = plain_symbol(symbol);
        Unit::ALL
            .into_iter()
            .find(|unit| unit.symbols().any(|known| known == symbol))
    }

    /// What it is, in words, with its article: "a length".
    pub fn noun(self) -> &'static str {
        match self {
            Unit::Ratio => "a number",
            Unit::Count => "a count",
            Unit::Length => "a length",
            Unit::Area => "an area",
            Unit::Volume => "a volume",
            Unit::Time => "a time",
            Unit::Angle => "an angle",
            Unit::Frequency => "a frequency",
            Unit::Rate => "a rate",
            Unit::Speed => "a speed",
            Unit::AngularSpeed => "an angular speed",
            Unit::Acceleration => "an acceleration",
            Unit::Mass => "a mass",
            Unit::Density => "a density",
            Unit::Force => "a force",
            Unit::Impulse => "an impulse",
            Unit::Pressure => "a pressure",
            Unit::Viscosity => "a viscosity",
            Unit::Energy => "an energy",
            Unit::Torque => "a torque",
            Unit::LengthStiffness => "a stiffness per length",
            Unit::AreaStiffness => "a stiffness per area",
            Unit::VolumeStiffness => "a stiffness per volume",
            Unit::LengthDamping => "a damping per length",
            Unit::AreaDamping => "a damping per area",
            Unit::VolumeDamping => "a damping per volume",
            Unit::Action => "a damping of relative changes",
        }
    }

    /// The SI value of a text such as "0.12 mm", "62.5 Hz" or "15 deg".
    pub fn parse(self, text: &str) -> Result<f64, QuantityError> {
        let (mantissa, exponent, symbol) = split(text).ok_or(QuantityError::NotANumber)?;
        // A pure number and a count have no unit that could be forgotten.
        let symbol = match (self, symbol.as_str()) {
            (Unit::Ratio | Unit::Count, "") => self.symbol(),
            (_, "") => return Err(QuantityError::NoUnit),
            (_, symbol) => symbol,
        };
        let scale = self
            .scale(symbol)
            .ok_or_else(|| QuantityError::WrongUnit(Unit::of_symbol(symbol)))?;
        match scale.parse(mantissa, exponent) {
            Some(value) if value.is_finite() => Ok(value),
            _ => Err(QuantityError::NotFinite),
        }
    }

    /// The SI value of a number given in `symbol`; `None` if the symbol is none of this unit. It is scaled after it was
    /// rounded to an `f64`, so the last bit may differ from that of [`Unit::parse`].
    pub fn to_si(self, number: f64, symbol: &str) -> Option<f64> {
        Some(self.scale(symbol)?.si(number))
    }

    /// An SI value as a number in `symbol`, for people to read; `None` if the symbol is none of this unit.
    pub fn from_si(self, si: f64, symbol: &str) -> Option<f64> {
        Some(self.scale(symbol)?.display(si))
    }

    /// An SI value as a short text in the symbol that suits its size: 0.008 s as "8 ms", at most 12 digits.
    pub fn describe(self, si: f64) -> String {
        let table = self.table();
        let fitting = |(_, scale): &&(&str, Scale)| {
            let shown = scale.display(si.abs());
            (1.0..1000.0).contains(&shown)
        };
        let degrees = ("deg", Degree);
        let (symbol, scale) = match self {
            Unit::Angle => &degrees,
            Unit::Ratio => &table[0],
            _ => table.iter().find(fitting).unwrap_or(&table[0]),
        };
        let number = round_to_digits(scale.display(si));
        match *symbol {
            "1" => format!("{number}"),
            symbol => format!("{number} {symbol}"),
        }
    }

    fn scale(self, symbol: &str) -> Option<Scale> {
        let symbol = plain_symbol(symbol);
        self.table()
            .iter()
            .find(|(known, _)| *known == symbol)
            .map(|(_, scale)| *scale)
    }
}

impl TryFrom<String> for Unit {
    type Error = String;

    fn try_from(symbol: String) -> Result<Self, String> {
        Unit::ALL
            .into_iter()
            .find(|unit| unit.symbol() == symbol)
            .ok_or_else(|| format!("`{symbol}` is no SI unit"))
    }
}

impl From<Unit> for &'static str {
    fn from(unit: Unit) -> Self {
        unit.symbol()
    }
}

/// Rounded to 12 digits, so that 0.1 + 0.2 reads 0.3; for messages only.
fn round_to_digits(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// Typographic forms in plain ones: µm as um, m² as m^2, ° as deg.
fn plain_symbol(symbol: &str) -> String {
    symbol
        .replace(['µ', 'μ'], "u")
        .replace('²', "^2")
        .replace('³', "^3")
        .replace('⁵', "^5")
        .replace('°', "deg")
}

/// Splits "-1.5e3 mm" into mantissa "-1.5", exponent 3 and symbol "mm". `None` unless it begins with a decimal number.
fn split(text: &str) -> Option<(&str, i64, String)> {
    let text = text.trim();
    let bytes = text.as_bytes();
    let digits = |from: usize| {
        bytes[from..]
            .iter()
            .take_while(|b| b.is_ascii_digit())
            .count()
    };
    let sign = |at: usize| usize::from(matches!(bytes.get(at), Some(b'+' | b'-')));

    let mut end = sign(0);
    let whole = digits(end);
    end += whole;
    let mut fraction = 0;
    if bytes.get(end) == Some(&b'.') {
        fraction = digits(end + 1);
        end += 1 + fraction;
    }
    if whole == 0 || (text[..end].contains('.') && fraction == 0) {
        return None;
    }
    let mantissa = &text[..end];

    // An `e` belongs to the number only if digits follow it.
    let mut exponent = 0;
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let start = end + 1;
        let after_sign = start + sign(start);
        let count = bytes.get(after_sign..).map_or(0, |_| digits(after_sign));
        if count > 0 {
            end = after_sign + count;
            // An exponent too long for i64 is as good as the largest one.
            let negative = text[start..].starts_with('-');
            let limit = if negative { i64::MIN } else { i64::MAX };
            exponent = text[start..end].parse().unwrap_or(limit);
        }
    }
    Some((mantissa, exponent, text[end..].trim().to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected values are the literals of the Rust compiler, which rounds a decimal correctly.
    #[test]
    fn a_text_gives_the_bits_of_the_si_literal() {
        let cases = [
            (Unit::Length, "0.12 mm", 0.00012),
            (Unit::Length, "0.7 mm", 0.0007),
            (Unit::Length, "25mm", 0.025),
            (Unit::Length, "-22 µm", -0.000022),
            (Unit::Length, "1.1e1 mm", 0.011),
            (Unit::Length, "3 nm", 0.000000003),
            (Unit::Frequency, "62.5 Hz", 62.5),
            (Unit::Pressure, "30 kPa", 30e3),
            (Unit::Pressure, "2.9 GPa", 2.9e9),
            (Unit::Time, "2 s", 2.0),
            (Unit::Time, "8 ms", 0.008),
            (Unit::Time, "1.5 min", 90.0),
            (Unit::Force, "40 mN", 0.04),
            (Unit::Impulse, "3 mN s", 0.003),
            (Unit::Acceleration, "-9.81 m/s^2", -9.81),
            (Unit::Acceleration, "9.81 m/s²", 9.81),
            (Unit::Density, "1060 kg/m^3", 1060.0),
            (Unit::Density, "1.06 g/cm³", 1060.0),
            (Unit::Area, "0.3 mm²", 0.3e-6),
            (Unit::Volume, "0.3 mm^3", 0.3e-9),
            (Unit::Viscosity, "250 mPa s", 0.25),
            (Unit::AreaStiffness, "2 N/mm³", 2e9),
            (Unit::VolumeStiffness, "5 N/m⁵", 5.0),
            (Unit::Rate, "100 1/s", 100.0),
            (Unit::Speed, "0.3 mm/s", 0.0003),
            (Unit::Ratio, "35 %", 0.35),
            (Unit::Ratio, "0.5", 0.5),
            (Unit::Count, "4", 4.0),
            (Unit::Angle, "180 deg", std::f64::consts::PI),
            (Unit::Angle, "90°", std::f64::consts::FRAC_PI_2),
        ];
        for (unit, text, expected) in cases {
            let value = unit.parse(text).expect(text);
            assert_eq!(value.to_bits(), expected.to_bits(), "{text}: {value}");
        }
    }

    /// Why the exponent is shifted in the text: scaling a rounded number rounds a second time, in either direction.
    #[test]
    fn scaling_a_rounded_number_would_round_twice() {
        assert_ne!(0.9 * 1e-3, 0.0009);
        assert_ne!(2.1 / 1e3, 0.0021);
        assert_eq!(Unit::Length.parse("0.9 mm"), Ok(0.0009));
        assert_eq!(Unit::Length.parse("2.1 mm"), Ok(0.0021));
    }

    #[test]
    fn numbers_are_scaled_both_ways() {
        assert_eq!(Unit::Length.to_si(25.0, "mm"), Some(0.025));
        assert_eq!(Unit::Length.from_si(0.025, "mm"), Some(25.0));
        assert_eq!(Unit::Pressure.to_si(30.0, "kPa"), Some(30e3));
        assert_eq!(Unit::Time.from_si(90.0, "min"), Some(1.5));
        let right_angle = std::f64::consts::FRAC_PI_2;
        assert_eq!(Unit::Angle.to_si(90.0, "deg"), Some(right_angle));
        assert_eq!(Unit::Length.to_si(1.0, "s"), None);
    }

    #[test]
    fn what_is_no_quantity_says_why() {
        use QuantityError::*;
        let cases = [
            ("", NotANumber),
            ("mm", NotANumber),
            ("- mm", NotANumber),
            (".5 mm", NotANumber),
            ("1. mm", NotANumber),
            ("nan m", NotANumber),
            ("inf m", NotANumber),
            ("1_000 m", WrongUnit(None)),
            ("5", NoUnit),
            ("5 kg", WrongUnit(Some(Unit::Mass))),
            ("5 inch", WrongUnit(None)),
            ("5 mm mm", WrongUnit(None)),
            ("1e999 m", NotFinite),
            ("1e99999999999999999999 m", NotFinite),
            ("5 e", WrongUnit(None)),
            ("5e", WrongUnit(None)),
            ("5e-", WrongUnit(None)),
        ];
        for (text, expected) in cases {
            assert_eq!(Unit::Length.parse(text), Err(expected), "{text}");
        }
        assert_eq!(Unit::Length.parse("1e-99999999999999999999 m"), Ok(0.0));
    }

    #[test]
    fn messages_show_the_symbol_that_suits_the_size() {
        let cases = [
            (Unit::Time, 0.008, "8 ms"),
            (Unit::Time, 0.05, "50 ms"),
            (Unit::Length, 0.0, "0 m"),
            (Unit::Length, 1e-6, "1 um"),
            (Unit::Pressure, 30e3, "30 kPa"),
            (Unit::Angle, 0.5235987755982988, "30 deg"),
            (Unit::Ratio, 0.25, "0.25"),
            (Unit::Count, 3.0, "3 count"),
        ];
        for (unit, si, expected) in cases {
            assert_eq!(unit.describe(si), expected);
        }
    }

    #[test]
    fn symbols_are_unique_and_name_their_unit() {
        for unit in Unit::ALL {
            for symbol in unit.symbols() {
                assert_eq!(Unit::of_symbol(symbol), Some(unit), "{symbol}");
            }
            assert_eq!(Unit::try_from(unit.symbol().to_owned()), Ok(unit));
        }
    }
}
