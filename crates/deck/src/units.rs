//! Units in strings: `"117 GPa"`, `"8930 kg/m^3"`, `"80 us"`.
//!
//! A decimal number times a power of ten is read as one decimal number, so that `"80 us"` is the number nearest to
//! 80·10⁻⁶ and not a product that was rounded twice.

use crate::diagnostics::nearest;
use std::fmt;

/// Powers of length, mass, time and temperature. Angles are pure numbers (rad).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension {
    length: i8,
    mass: i8,
    time: i8,
    temperature: i8,
}

impl Dimension {
    /// A pure number: also angles (rad) and fractions (%).
    pub const NUMBER: Self = Self::new(0, 0, 0);
    /// m.
    pub const LENGTH: Self = Self::new(1, 0, 0);
    /// s.
    pub const TIME: Self = Self::new(0, 0, 1);
    /// kg.
    pub const MASS: Self = Self::new(0, 1, 0);
    /// K.
    pub const TEMPERATURE: Self = Self { length: 0, mass: 0, time: 0, temperature: 1 };
    /// kg/m³.
    pub const DENSITY: Self = Self::new(-3, 1, 0);
    /// Pa.
    pub const STRESS: Self = Self::new(-1, 1, -2);
    /// N.
    pub const FORCE: Self = Self::new(1, 1, -2);
    /// J.
    pub const ENERGY: Self = Self::new(2, 1, -2);
    /// m/s.
    pub const VELOCITY: Self = Self::new(1, 0, -1);
    /// m/s².
    pub const ACCELERATION: Self = Self::new(1, 0, -2);
    /// kg m/s.
    pub const MOMENTUM: Self = Self::new(1, 1, -1);
    /// rad/s.
    pub const RATE: Self = Self::new(0, 0, -1);

    /// J/(kg K).
    pub const SPECIFIC_HEAT: Self = Self { length: 2, mass: 0, time: -2, temperature: -1 };

    const fn new(length: i8, mass: i8, time: i8) -> Self {
        Self { length, mass, time, temperature: 0 }
    }

    /// Name, SI unit and an example of the dimensions that have a name.
    const NAMED: [(Self, &'static str, &'static str, &'static str); 14] = [
        (Self::NUMBER, "a pure number", "1", "0.3"),
        (Self::LENGTH, "a length", "m", "32.4 mm"),
        (Self::TIME, "a time", "s", "80 us"),
        (Self::MASS, "a mass", "kg", "2 g"),
        (Self::TEMPERATURE, "a temperature", "K", "20 degC"),
        (Self::DENSITY, "a density", "kg/m^3", "8930 kg/m^3"),
        (Self::STRESS, "a stress", "Pa", "117 GPa"),
        (Self::FORCE, "a force", "N", "5 kN"),
        (Self::ENERGY, "an energy", "J", "240 J"),
        (Self::VELOCITY, "a velocity", "m/s", "227 m/s"),
        (Self::ACCELERATION, "an acceleration", "m/s^2", "9.81 m/s^2"),
        (Self::MOMENTUM, "a momentum", "kg m/s", "2 kg m/s"),
        (Self::RATE, "a rate", "1/s", "105 rad/s"),
        (Self::SPECIFIC_HEAT, "a specific heat", "J/(kg K)", "460 J/(kg K)"),
    ];

    fn named(self) -> Option<&'static (Self, &'static str, &'static str, &'static str)> {
        Self::NAMED.iter().find(|(dimension, ..)| *dimension == self)
    }

    /// The SI unit.
    pub fn si_unit(self) -> String {
        if let Some((_, _, unit, _)) = self.named() {
            return (*unit).to_owned();
        }
        let powers = [(self.length, "m"), (self.mass, "kg"), (self.time, "s"), (self.temperature, "K")];
        let parts = powers.into_iter().filter(|(power, _)| *power != 0);
        parts.map(|(power, unit)| format!("{unit}^{power}")).collect::<Vec<_>>().join("*")
    }

    /// A quantity of this dimension as one might write it.
    pub fn example(self) -> String {
        self.named().map_or_else(|| format!("1 {}", self.si_unit()), |(.., example)| (*example).to_owned())
    }

    fn times(self, other: Self, power: i8) -> Self {
        let sum = |a: i8, b: i8| a.saturating_add(b.saturating_mul(power));
        Self {
            length: sum(self.length, other.length),
            mass: sum(self.mass, other.mass),
            time: sum(self.time, other.time),
            temperature: sum(self.temperature, other.temperature),
        }
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.named() {
            Some((_, name, ..)) => formatter.write_str(name),
            None => write!(formatter, "a quantity in {}", self.si_unit()),
        }
    }
}

/// A number with its dimension, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The value in SI units.
    pub value: f64,
    /// The dimension that the unit has; none where only a number was written.
    pub dimension: Option<Dimension>,
    /// Whether the unit is the per cent sign.
    pub is_percentage: bool,
    /// The zero of the unit: that of degrees Celsius is 273.15 K.
    pub zero: f64,
}

/// 0 °C in K.
const CELSIUS_ZERO: f64 = 273.15;

/// A text that is no quantity.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnitError {
    /// It does not begin with a number.
    #[error("it does not begin with a number")]
    NoNumber,
    /// It has a decimal comma.
    #[error("it has a comma: the decimal sign is a point")]
    Comma,
    /// The unit is not known.
    #[error("the unit `{unit}` is not known")]
    Unknown {
        /// The unknown part of the unit.
        unit: String,
        /// A known unit that looks like it.
        similar: Option<String>,
    },
    /// The unit cannot be read.
    #[error("the unit `{unit}` cannot be read")]
    Malformed {
        /// The unit as written.
        unit: String,
    },
}

/// Reads a number with or without a unit.
///
/// # Errors
/// No number, or a unit that is unknown or cannot be read.
pub fn parse(text: &str) -> Result<Measured, UnitError> {
    let text = text.trim();
    let (decimal, rest) = Decimal::prefix(text).ok_or(UnitError::NoNumber)?;
    if rest.trim_start().starts_with(',') {
        return Err(UnitError::Comma);
    }
    let unit = rest.trim();
    if unit.is_empty() {
        return Ok(Measured { value: decimal.times_power_of_ten(0), dimension: None, is_percentage: false, zero: 0.0 });
    }
    if unit == "degC" || unit == "°C" {
        let (value, dimension) = (decimal.times_power_of_ten(0) + CELSIUS_ZERO, Some(Dimension::TEMPERATURE));
        return Ok(Measured { value, dimension, is_percentage: false, zero: CELSIUS_ZERO });
    }
    let unit_read = unit_product(unit)?;
    Ok(Measured {
        value: unit_read.scale.of(&decimal),
        dimension: Some(unit_read.dimension),
        is_percentage: unit == "%",
        zero: 0.0,
    })
}

/// A decimal number as written: digits with a point, and a power of ten.
struct Decimal<'a> {
    digits: &'a str,
    exponent: i32,
}

impl<'a> Decimal<'a> {
    /// The number at the beginning of a text, and what follows it.
    fn prefix(text: &'a str) -> Option<(Self, &'a str)> {
        let bytes = text.as_bytes();
        let digits_from = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let sign = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
        let whole = digits_from(sign);
        let mut end = sign + whole;
        let mut count = whole;
        if bytes.get(end) == Some(&b'.') {
            let fraction = digits_from(end + 1);
            count += fraction;
            end += 1 + fraction;
        }
        if count == 0 {
            return None;
        }
        let digits = &text[..end];
        let mut exponent = 0;
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let exponent_sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let exponent_digits =
                bytes.get(end + 1 + exponent_sign..).map_or(0, |_| digits_from(end + 1 + exponent_sign));
            if exponent_digits > 0 {
                let exponent_end = end + 1 + exponent_sign + exponent_digits;
                let limit = if bytes[end + 1] == b'-' { -100_000 } else { 100_000 };
                exponent = text[end + 1..exponent_end].parse().unwrap_or(limit).clamp(-100_000, 100_000);
                end = exponent_end;
            }
        }
        Some((Self { digits, exponent }, &text[end..]))
    }

    /// The f64 nearest to the number times 10^`power`.
    fn times_power_of_ten(&self, power: i32) -> f64 {
        let exponent = self.exponent + power;
        format!("{}e{exponent}", self.digits).parse().unwrap_or(f64::NAN)
    }

    /// The f64 nearest to the number times `factor` times 10^`power`, while the digits fit into 128 bits.
    fn times(&self, factor: u64, power: i32) -> f64 {
        let (whole, fraction) = self.digits.split_once('.').unwrap_or((self.digits, ""));
        let product = format!("{whole}{fraction}").parse::<i128>().ok();
        match product.and_then(|digits| digits.checked_mul(i128::from(factor))) {
            Some(product) => {
                let exponent = self.exponent + power - i32::try_from(fraction.len()).unwrap_or(i32::MAX / 2);
                format!("{product}e{exponent}").parse().unwrap_or(f64::NAN)
            }
            None => self.times_power_of_ten(power) * factor as f64,
        }
    }
}

/// What a unit is in SI units: numerator/denominator · 10^power · (π/180)^degrees.
#[derive(Clone, Copy, Debug)]
struct Scale {
    numerator: u64,
    denominator: u64,
    power: i32,
    degrees: i32,
}

impl Scale {
    const fn power_of_ten(power: i32) -> Self {
        Self { numerator: 1, denominator: 1, power, degrees: 0 }
    }

    const fn factor(numerator: u64, power: i32) -> Self {
        Self { numerator, denominator: 1, power, degrees: 0 }
    }

    fn times(self, other: Self, power: i8) -> Option<Self> {
        let (up, down) =
            if power < 0 { (other.denominator, other.numerator) } else { (other.numerator, other.denominator) };
        let count = u32::from(power.unsigned_abs());
        Some(Self {
            numerator: self.numerator.checked_mul(up.checked_pow(count)?)?,
            denominator: self.denominator.checked_mul(down.checked_pow(count)?)?,
            power: self.power + other.power * i32::from(power),
            degrees: self.degrees + other.degrees * i32::from(power),
        })
    }

    fn of(self, decimal: &Decimal<'_>) -> f64 {
        let common = gcd(self.numerator, self.denominator);
        let value = decimal.times(self.numerator / common, self.power) / (self.denominator / common) as f64;
        if self.degrees == 0 { value } else { value * (std::f64::consts::PI / 180.0).powi(self.degrees) }
    }
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a.max(1) } else { gcd(b, a % b) }
}

/// A unit that has been read.
#[derive(Clone, Copy, Debug)]
struct Unit {
    scale: Scale,
    dimension: Dimension,
}

/// Units that take the prefixes of [`PREFIXES`]; the last number is the power of ten of the unit itself.
const PREFIXED: [(&str, Dimension, i32); 8] = [
    ("m", Dimension::LENGTH, 0),
    ("g", Dimension::MASS, -3),
    ("s", Dimension::TIME, 0),
    ("N", Dimension::FORCE, 0),
    ("Pa", Dimension::STRESS, 0),
    ("J", Dimension::ENERGY, 0),
    ("K", Dimension::TEMPERATURE, 0),
    ("rad", Dimension::NUMBER, 0),
];

const PREFIXES: [(&str, i32); 13] = [
    ("f", -15),
    ("p", -12),
    ("n", -9),
    ("u", -6),
    ("\u{b5}", -6),
    ("\u{3bc}", -6),
    ("m", -3),
    ("c", -2),
    ("d", -1),
    ("h", 2),
    ("k", 3),
    ("M", 6),
    ("G", 9),
];

/// Units that stand alone.
const PLAIN: [(&str, Dimension, Scale); 15] = [
    ("1", Dimension::NUMBER, Scale::power_of_ten(0)),
    ("%", Dimension::NUMBER, Scale::power_of_ten(-2)),
    ("deg", Dimension::NUMBER, Scale { numerator: 1, denominator: 1, power: 0, degrees: 1 }),
    ("°", Dimension::NUMBER, Scale { numerator: 1, denominator: 1, power: 0, degrees: 1 }),
    ("rpm", Dimension::RATE, Scale { numerator: 6, denominator: 1, power: 0, degrees: 1 }),
    ("min", Dimension::TIME, Scale::factor(60, 0)),
    ("h", Dimension::TIME, Scale::factor(3600, 0)),
    ("t", Dimension::MASS, Scale::power_of_ten(3)),
    ("bar", Dimension::STRESS, Scale::power_of_ten(5)),
    ("in", Dimension::LENGTH, Scale::factor(254, -4)),
    ("ft", Dimension::LENGTH, Scale::factor(3048, -4)),
    ("lb", Dimension::MASS, Scale::factor(45_359_237, -8)),
    ("lbf", Dimension::FORCE, Scale::factor(44_482_216_152_605, -13)),
    ("psi", Dimension::STRESS, Scale { numerator: 44_482_216_152_605, denominator: 64_516, power: -5, degrees: 0 }),
    ("ksi", Dimension::STRESS, Scale { numerator: 44_482_216_152_605, denominator: 64_516, power: -2, degrees: 0 }),
];

/// The unit of one name.
fn unit_named(name: &str) -> Option<Unit> {
    if let Some((_, dimension, scale)) = PLAIN.iter().find(|(plain, ..)| *plain == name) {
        return Some(Unit { scale: *scale, dimension: *dimension });
    }
    PREFIXED.iter().find_map(|(base, dimension, power)| {
        let prefix = name.strip_suffix(base)?;
        let prefix_power = match prefix {
            "" => 0,
            _ => PREFIXES.iter().find(|(known, _)| *known == prefix)?.1,
        };
        Some(Unit { scale: Scale::power_of_ten(power + prefix_power), dimension: *dimension })
    })
}

/// The known unit that looks like an unknown one.
fn similar_unit(name: &str) -> Option<String> {
    let mut known: Vec<String> = PLAIN.iter().map(|(unit, ..)| (*unit).to_owned()).collect();
    for (base, ..) in PREFIXED {
        known.push(base.to_owned());
        known.extend(PREFIXES.iter().map(|(prefix, _)| format!("{prefix}{base}")));
    }
    known.push("degC".to_owned());
    let same_letters = known.iter().find(|unit| unit.eq_ignore_ascii_case(name));
    let nearest = || nearest(name, known.iter().map(String::as_str)).map(str::to_owned);
    same_letters.cloned().or_else(nearest)
}

/// Reads factors joined by `*`, `·`, blanks or `/`, each with a whole power: `kg/m^3`, `J/(kg K)`.
fn unit_product(text: &str) -> Result<Unit, UnitError> {
    let malformed = || UnitError::Malformed { unit: text.to_owned() };
    let mut product = Unit { scale: Scale::power_of_ten(0), dimension: Dimension::NUMBER };
    let mut sign = 1_i8;
    let mut sign_in_brackets = None;
    let mut rest = text;
    let mut factor_wanted = true;
    while let Some(first) = rest.chars().next() {
        match first {
            '/' | '*' | '·' if !factor_wanted => {
                sign = if first == '/' { -1 } else { 1 };
                factor_wanted = true;
                rest = &rest[first.len_utf8()..];
            }
            '(' if factor_wanted && sign_in_brackets.is_none() => {
                sign_in_brackets = Some(sign);
                sign = 1;
                rest = &rest[1..];
            }
            ')' if !factor_wanted && sign_in_brackets.is_some() => {
                sign_in_brackets = None;
                sign = 1;
                rest = &rest[1..];
            }
            blank if blank.is_whitespace() => rest = &rest[blank.len_utf8()..],
            _ => {
                let end = rest.find(|c: char| !is_unit_letter(c)).unwrap_or(rest.len());
                // a bare 1 stands for no unit at all, as in 1/s
                let end = if end == 0 && rest.starts_with('1') { 1 } else { end };
                let (name, after) = rest.split_at(end);
                if name.is_empty() {
                    return Err(malformed());
                }
                let unit = unit_named(name)
                    .ok_or_else(|| UnitError::Unknown { unit: name.to_owned(), similar: similar_unit(name) })?;
                let (power, after) = unit_power(after).ok_or_else(malformed)?;
                let power = power * if factor_wanted { sign } else { 1 } * sign_in_brackets.unwrap_or(1);
                product = Unit {
                    scale: product.scale.times(unit.scale, power).ok_or_else(malformed)?,
                    dimension: product.dimension.times(unit.dimension, power),
                };
                sign = 1;
                factor_wanted = false;
                rest = after;
            }
        }
    }
    if factor_wanted || sign_in_brackets.is_some() { Err(malformed()) } else { Ok(product) }
}

fn is_unit_letter(c: char) -> bool {
    (c.is_alphabetic() || c == '%' || c == '°') && c != '²' && c != '³'
}

/// The power after a unit (`^2`, `²`, a bare `2` or `-1`, nothing), from −9 to 9, and what follows.
fn unit_power(text: &str) -> Option<(i8, &str)> {
    for (mark, power) in [("²", 2), ("³", 3)] {
        if let Some(rest) = text.strip_prefix(mark) {
            return Some((power, rest));
        }
    }
    let marked = text.strip_prefix('^').or_else(|| text.strip_prefix("**"));
    let is_bare = text.strip_prefix('-').unwrap_or(text).starts_with(|c: char| c.is_ascii_digit());
    let Some(rest) = marked.or(is_bare.then_some(text)) else { return Some((1, text)) };
    let sign = usize::from(rest.starts_with('-'));
    let end = sign + rest[sign..].bytes().take_while(u8::is_ascii_digit).count();
    let power: i8 = rest[..end].parse().ok()?;
    (-9..=9).contains(&power).then_some((power, &rest[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_scale_to_the_nearest_number() {
        let cases = [
            ("117 GPa", 117e9, Dimension::STRESS),
            ("32.4 mm", 32.4e-3, Dimension::LENGTH),
            ("80 us", 80e-6, Dimension::TIME),
            ("80 \u{b5}s", 80e-6, Dimension::TIME),
            ("80 \u{3bc}s", 80e-6, Dimension::TIME),
            ("8930 kg/m^3", 8930.0, Dimension::DENSITY),
            ("8.93 g/cm^3", 8930.0, Dimension::DENSITY),
            ("8.93 g/cm³", 8930.0, Dimension::DENSITY),
            ("7.85e-9 t/mm^3", 7850.0, Dimension::DENSITY),
            ("20 degC", 293.15, Dimension::TEMPERATURE),
            ("0.3 %", 0.003, Dimension::NUMBER),
            ("0.3%", 0.003, Dimension::NUMBER),
            ("-227 m/s", -227.0, Dimension::VELOCITY),
            ("105 rad/s", 105.0, Dimension::RATE),
            ("5 1/s", 5.0, Dimension::RATE),
            ("1.5 min", 90.0, Dimension::TIME),
            ("10 rpm", std::f64::consts::PI / 3.0, Dimension::RATE),
            ("180 deg", std::f64::consts::PI, Dimension::NUMBER),
            ("9.81 m/s^2", 9.81, Dimension::ACCELERATION),
            ("9.81 m s^-2", 9.81, Dimension::ACCELERATION),
            ("9.81 m/s2", 9.81, Dimension::ACCELERATION),
            ("9.81 m s-2", 9.81, Dimension::ACCELERATION),
            ("117 N/mm2", 117e6, Dimension::STRESS),
            ("8.93 g/cm3", 8930.0, Dimension::DENSITY),
            ("20us", 20e-6, Dimension::TIME),
            ("3 N/mm^2", 3e6, Dimension::STRESS),
            ("1 in", 0.0254, Dimension::LENGTH),
            ("+1.e3 kN", 1e6, Dimension::FORCE),
            (".5 m", 0.5, Dimension::LENGTH),
            ("36 km/h", 10.0, Dimension::VELOCITY),
        ];
        for (text, value, dimension) in cases {
            let measured = parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
            assert_eq!((measured.value, measured.dimension), (value, Some(dimension)), "{text}");
        }
        let psi = parse("1 psi").unwrap().value;
        assert!((psi - 6_894.757_293_168_361).abs() < 1e-9, "{psi}");
        assert_eq!(parse("460 J/(kg K)").unwrap().value, 460.0);
        assert_eq!(parse("12").unwrap(), Measured { value: 12.0, dimension: None, is_percentage: false, zero: 0.0 });
        assert!(parse("2 %").unwrap().is_percentage);
    }

    #[test]
    fn impossible_units_are_named() {
        assert_eq!(parse("GPa"), Err(UnitError::NoNumber));
        assert_eq!(parse(""), Err(UnitError::NoNumber));
        assert_eq!(parse("-"), Err(UnitError::NoNumber));
        assert_eq!(parse("3,5 mm"), Err(UnitError::Comma));
        let unknown = |unit: &str, similar: Option<&str>| {
            Err(UnitError::Unknown { unit: unit.to_owned(), similar: similar.map(str::to_owned) })
        };
        assert_eq!(parse("3 gpa"), unknown("gpa", Some("GPa")));
        assert_eq!(parse("3 furlong"), unknown("furlong", None));
        for text in [
            "3 m/",
            "3 /",
            "3 m^",
            "3 m^99",
            "3 m^x",
            "3 m99",
            "3 m2x",
            "3 2",
            "3 (m",
            "3 m)",
            "3 m//s",
            "3 kg/((m))",
            "1e",
            "3 m 2",
        ] {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn absurd_numbers_do_no_harm() {
        assert_eq!(parse("1e999999999999 m").unwrap().value, f64::INFINITY);
        assert_eq!(parse("1e-999999999999 m").unwrap().value, 0.0);
        let long = format!("{} in", "9".repeat(5000));
        assert_eq!(parse(&long).unwrap().value, f64::INFINITY);
        assert!(parse(&format!("1 {}", "m".repeat(100_000))).is_err());
        assert!(parse(&format!("1 {}", "m ".repeat(100_000))).is_ok());
    }
}
