//! A line of comma-separated numbers, from bytes and to bytes.

/// Which numbers are allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Rule {
    /// 0 to the largest count, where known.
    Counts { maximum: f64 },
    /// Every finite number.
    Finite,
}

impl Rule {
    /// The largest number that is allowed.
    pub(crate) fn most(self) -> f64 {
        match self {
            Self::Counts { maximum } => maximum,
            Self::Finite => f64::MAX,
        }
    }
}

/// What is wrong with a line, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Fault {
    /// Not as many numbers as were wanted.
    Count { found: usize },
    /// One value cannot be used; `from..to` are its bytes, `number` its place from 0.
    Value {
        number: usize,
        from: usize,
        to: usize,
        why: Why,
    },
}

/// What is wrong with a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Why {
    Word,
    NotFinite,
    Negative(f64),
    TooLarge(f64),
}

/// Digits that a 53-bit mantissa holds exactly.
const EXACT_DIGITS: usize = 15;

/// Reads `out.len()` numbers; a comma may close the line.
pub(crate) fn parse_line(line: &[u8], out: &mut [f64], rule: Rule) -> Result<(), Fault> {
    let mut at = 0;
    let mut number = 0;
    while at < line.len() {
        let start = at;
        let mut whole = 0u64;
        while let Some(digit) = line
            .get(at)
            .map(|b| b.wrapping_sub(b'0'))
            .filter(|d| *d < 10)
        {
            whole = whole.wrapping_mul(10).wrapping_add(u64::from(digit));
            at += 1;
        }
        let closed = line.get(at).is_none_or(|b| *b == b',');
        let value = if closed && (1..=EXACT_DIGITS).contains(&(at - start)) {
            whole as f64
        } else {
            at = end_of_field(line, start);
            parse_slow(line, number, start, at)?
        };
        if let Rule::Counts { maximum } = rule
            && !(0.0..=maximum).contains(&value)
        {
            return Err(outside(line, number, start, at, value));
        }
        match out.get_mut(number) {
            Some(place) => *place = value,
            None => {
                return Err(Fault::Count {
                    found: count_fields(line),
                });
            }
        }
        number += 1;
        at += 1;
    }
    if number == out.len() {
        Ok(())
    } else {
        Err(Fault::Count { found: number })
    }
}

fn end_of_field(line: &[u8], start: usize) -> usize {
    memchr::memchr(b',', &line[start..]).map_or(line.len(), |offset| start + offset)
}

#[cold]
fn outside(line: &[u8], number: usize, from: usize, to: usize, value: f64) -> Fault {
    let (from, to) = trimmed(line, from, to);
    let why = if value < 0.0 {
        Why::Negative(value)
    } else {
        Why::TooLarge(value)
    };
    Fault::Value {
        number,
        from,
        to,
        why,
    }
}

/// A number that is no short run of digits.
fn parse_slow(line: &[u8], number: usize, from: usize, to: usize) -> Result<f64, Fault> {
    let (from, to) = trimmed(line, from, to);
    let fault = |why| Fault::Value {
        number,
        from,
        to,
        why,
    };
    match fast_float2::parse::<f64, _>(&line[from..to]) {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(fault(Why::NotFinite)),
        Err(_) => Err(fault(Why::Word)),
    }
}

fn trimmed(line: &[u8], mut from: usize, mut to: usize) -> (usize, usize) {
    while from < to && matches!(line[from], b' ' | b'\t') {
        from += 1;
    }
    while from < to && matches!(line[to - 1], b' ' | b'\t') {
        to -= 1;
    }
    (from, to)
}

/// Comma-separated fields of a line, one comma at its end not counted.
pub(crate) fn count_fields(line: &[u8]) -> usize {
    let commas = memchr::memchr_iter(b',', line).count();
    commas + usize::from(!line.is_empty() && !line.ends_with(b","))
}

/// How many fields of a line are numbers.
pub(crate) fn count_numbers(line: &[u8]) -> usize {
    line.split(|b| *b == b',')
        .filter(|field| {
            let (from, to) = trimmed(field, 0, field.len());
            fast_float2::parse::<f64, _>(&field[from..to]).is_ok()
        })
        .count()
}

/// Whether there is nothing but space, and the commas that a spreadsheet leaves, on a line.
pub(crate) fn is_blank(line: &[u8]) -> bool {
    line.iter().all(|b| matches!(b, b' ' | b'\t' | b','))
}

/// Appends the shortest text that reads back as the same number; `inf` for what nothing bounds.
pub(crate) fn push_number(out: &mut Vec<u8>, buffer: &mut zmij::Buffer, value: f64) {
    // Counts and marks; minus nothing keeps its sign.
    let whole = value as u32;
    if f64::from(whole) == value && value.is_sign_positive() {
        if whole < 10 {
            out.push(b'0' + whole as u8);
            return;
        }
        out.extend_from_slice(itoa::Buffer::new().format(whole).as_bytes());
        return;
    }
    let text = if value.is_finite() {
        buffer.format_finite(value)
    } else {
        buffer.format(value)
    };
    out.extend_from_slice(text.strip_suffix(".0").unwrap_or(text).as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read<const N: usize>(line: &[u8], rule: Rule) -> Result<[f64; N], Fault> {
        let mut out = [0.0; N];
        parse_line(line, &mut out, rule).map(|()| out)
    }

    const COUNTS: Rule = Rule::Counts { maximum: 1023.0 };

    #[test]
    fn whole_fractional_and_spaced_numbers() {
        assert_eq!(read(b"1,2,3", COUNTS), Ok([1.0, 2.0, 3.0]));
        assert_eq!(read(b"1, 2.5 ,1e3,", COUNTS), Ok([1.0, 2.5, 1000.0]));
        assert_eq!(read(b"-1e-6,0.1", Rule::Finite), Ok([-1e-6, 0.1]));
        let long = b"12345678901234567890,0";
        assert_eq!(read(long, Rule::Finite), Ok([12345678901234567890.0, 0.0]));
    }

    #[test]
    fn every_fault_has_its_place() {
        let value = |number, from, to, why| Fault::Value {
            number,
            from,
            to,
            why,
        };
        for (line, fault) in [
            (&b"1,2"[..], Fault::Count { found: 2 }),
            (b"", Fault::Count { found: 0 }),
            (b"1,2,3,4,5,", Fault::Count { found: 5 }),
            (b"1,x,3", value(1, 2, 3, Why::Word)),
            (b"1,,3", value(1, 2, 2, Why::Word)),
            (b"1,2,3,,", value(3, 6, 6, Why::Word)),
            (b"1, nan,3", value(1, 3, 6, Why::NotFinite)),
            (b"1,1e999,3", value(1, 2, 7, Why::NotFinite)),
            (b"1,2,-3", value(2, 4, 6, Why::Negative(-3.0))),
            (b"1,1024,3", value(1, 2, 6, Why::TooLarge(1024.0))),
        ] {
            assert_eq!(read::<3>(line, COUNTS), Err(fault), "{line:?}");
        }
    }

    proptest! {
        #[test]
        fn every_finite_number_reads_back(value in proptest::num::f64::ANY) {
            prop_assume!(value.is_finite());
            let mut text = Vec::new();
            push_number(&mut text, &mut zmij::Buffer::new(), value);
            let back: [f64; 1] = read(&text, Rule::Finite).unwrap();
            prop_assert_eq!(back[0].to_bits(), value.to_bits());
            prop_assert!(text.len() <= 25);
        }
    }
}
