//! Numbers for people.

/// A time span: `12 s`, `3 min 20 s`, `2 h 5 min`.
pub fn duration(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "unknown".to_owned();
    }
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 60.0 => format!("{s:.0} s"),
        s if s < 3600.0 => format!("{} min {} s", (s / 60.0) as u64, (s % 60.0) as u64),
        s => format!("{} h {} min", (s / 3600.0) as u64, (s % 3600.0 / 60.0) as u64),
    }
}

/// A count with a space between thousands.
pub fn count(number: f64) -> String {
    let digits = format!("{number:.0}");
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index) % 3 == 0 {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// A number with an SI prefix: `12.3 M`.
pub fn prefixed(number: f64) -> String {
    let prefixes = [(1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k")];
    match prefixes.into_iter().find(|(size, _)| number >= *size) {
        Some((size, prefix)) => format!("{:.2} {prefix}", number / size),
        None => format!("{number:.1} "),
    }
}

/// A number in four digits: `0.25`, `-12.5`, `3.2e8`.
pub fn short(number: f64) -> String {
    digits(number, 4)
}

/// A number in so many digits, without zeros at its end.
pub fn digits(number: f64, count: usize) -> String {
    let without_zeros = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    let magnitude = number.abs();
    if number == 0.0 || (1e-3..1e5).contains(&magnitude) {
        let before_point = if number == 0.0 { 1 } else { magnitude.log10().floor() as i32 + 1 };
        let decimals = (count as i32 - before_point).max(0) as usize;
        return without_zeros(&format!("{number:.decimals$}"));
    }
    let text = format!("{number:.*e}", count - 1);
    match text.split_once('e') {
        Some((digits, power)) => format!("{}e{power}", without_zeros(digits)),
        None => text,
    }
}

/// Bytes: `3.2 MiB`.
pub fn bytes(number: f64) -> String {
    let units = [(30, "GiB"), (20, "MiB"), (10, "KiB")];
    match units.into_iter().find(|(power, _)| number >= f64::from(1u32 << power)) {
        Some((power, unit)) => format!("{:.1} {unit}", number / f64::from(1u32 << power)),
        None => format!("{number:.0} B"),
    }
}

/// How many elements there are of each shape, in words.
pub fn elements(mesh: &estar_mesh::Mesh, number: impl Fn(usize) -> String) -> String {
    let of_shape = |(shape, count): (estar_mesh::Shape, usize)| {
        format!("{} {}", number(count), if count == 1 { shape.singular() } else { shape.plural() })
    };
    mesh.elements().counts().map(of_shape).collect::<Vec<_>>().join(", ")
}

/// Numbers as the ranges that they make: `29 to 172`, `1, 5 to 8`; of many ranges the first three and the last.
pub fn ranges(numbers: impl IntoIterator<Item = u64>) -> String {
    const MOST_SHOWN: usize = 4;
    let mut numbers: Vec<u64> = numbers.into_iter().collect();
    numbers.sort_unstable();
    numbers.dedup();
    let range = |run: &[u64]| match run {
        [] => String::new(),
        [one] => one.to_string(),
        [first, .., last] => format!("{first} to {last}"),
    };
    let runs: Vec<&[u64]> = numbers.chunk_by(|one, next| next - one == 1).collect();
    match runs.split_last() {
        Some((last, rest)) if runs.len() > MOST_SHOWN => {
            let shown: Vec<String> = rest[..MOST_SHOWN - 1].iter().map(|run| range(run)).collect();
            format!("{}, ... (with {} gaps more), {}", shown.join(", "), rest.len() + 1 - MOST_SHOWN, range(last))
        }
        _ => runs.into_iter().map(range).collect::<Vec<_>>().join(", "),
    }
}

/// A count with its noun: `1 face`, `12 faces`.
pub fn number_of(count: usize, one: &str, many: &str) -> String {
    if count == 1 { format!("1 {one}") } else { format!("{count} {many}") }
}

/// Characters of a column of names, in which a name that is longer than most stands out.
pub fn column_width<'a>(names: impl IntoIterator<Item = &'a str>) -> usize {
    const WIDEST: usize = 40;
    names.into_iter().map(|name| name.chars().count()).max().unwrap_or(0).min(WIDEST)
}

/// Bytes in hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(duration(3.12), "3.1 s");
        assert_eq!(duration(200.0), "3 min 20 s");
        assert_eq!(duration(7500.0), "2 h 5 min");
        assert_eq!(duration(f64::INFINITY), "unknown");
        assert_eq!(count(1_234_567.0), "1 234 567");
        assert_eq!(count(12.0), "12");
        assert_eq!(prefixed(12_345_678.0), "12.35 M");
        assert_eq!(bytes(3.5 * 1_048_576.0), "3.5 MiB");
        for (number, text) in [(0.0, "0"), (0.25, "0.25"), (-12.5, "-12.5"), (3.2e8, "3.2e8"), (8e-5, "8e-5")] {
            assert_eq!(short(number), text);
        }
        assert_eq!(
            (short(1.0), short(0.015_844), short(99_999.9)),
            ("1".to_owned(), "0.01584".to_owned(), "100000".to_owned())
        );
        assert_eq!(digits(189_933.9, 6), "1.89934e5");
        assert_eq!(short(f64::NAN), "NaN");
    }

    #[test]
    fn numbers_in_a_row_are_a_range() {
        assert_eq!(ranges(29..=172), "29 to 172");
        assert_eq!(ranges([8, 1, 7, 5, 6, 5]), "1, 5 to 8");
        assert_eq!(ranges([]), "");
        assert_eq!(ranges([u64::MAX, 0, u64::MAX - 1]), format!("0, {} to {}", u64::MAX - 1, u64::MAX));
        assert_eq!(ranges((0..20).map(|number| 10 * number)), "0, 10, 20, ... (with 16 gaps more), 190");
    }
}
