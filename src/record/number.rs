//! Decimal numbers from bytes, correctly rounded, without a detour over text.

/// Powers of ten that a double holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// The number that `bytes` begin with, and how many bytes it takes; `mark` is the decimal mark.
///
/// Up to 19 digits with a mantissa below 2^53 and a power of ten up to 22 are one exact product or quotient (Clinger 1990); what is longer goes
/// through the standard library.
#[inline]
pub(super) fn leading(bytes: &[u8], mark: u8) -> Option<(f64, usize)> {
    let next = |at: &mut usize| {
        let byte = bytes.get(*at).copied();
        *at += 1;
        byte
    };
    let first = bytes.first().copied()?;
    let negative = first == b'-';
    let mut at = usize::from(negative | (first == b'+'));
    let (mut mantissa, mut digits, mut exponent) = (0_u64, 0_u32, 0_i32);
    let mut byte;
    loop {
        byte = next(&mut at);
        match byte {
            Some(digit @ b'0'..=b'9') => {
                mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
                digits += 1;
            }
            _ => break,
        }
    }
    if byte == Some(mark) {
        let before = digits;
        loop {
            byte = next(&mut at);
            match byte {
                Some(digit @ b'0'..=b'9') => {
                    mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
                    digits += 1;
                }
                _ => break,
            }
        }
        exponent = before as i32 - digits as i32;
    }
    if digits == 0 {
        return None;
    }
    if matches!(byte, Some(b'e' | b'E')) {
        let mut sign = 1;
        let mut power = 0_i32;
        byte = next(&mut at);
        if matches!(byte, Some(b'+' | b'-')) {
            sign = if byte == Some(b'-') { -1 } else { 1 };
            byte = next(&mut at);
        }
        let start = at;
        while let Some(digit @ b'0'..=b'9') = byte {
            power = power.saturating_mul(10).saturating_add(i32::from(digit - b'0'));
            byte = next(&mut at);
        }
        if at == start {
            return None;
        }
        exponent = exponent.saturating_add(sign * power);
    }
    let power = POWERS.get(exponent.unsigned_abs() as usize).filter(|_| digits <= 19 && mantissa < 1 << 53);
    let Some(power) = power else { return Some((exactly(bytes.get(..at - 1)?, mark)?, at - 1)) };
    let size = if exponent < 0 { mantissa as f64 / power } else { mantissa as f64 * power };
    // signs of readings come by chance: no branch by them
    Some((f64::from_bits(size.to_bits() | (u64::from(negative) << 63)), at - 1))
}

/// Any decimal number, with another mark than a point of up to [`LONGEST`] bytes.
#[cold]
fn exactly(bytes: &[u8], mark: u8) -> Option<f64> {
    if mark == b'.' {
        return std::str::from_utf8(bytes).ok()?.parse().ok();
    }
    let mut room = [0; LONGEST];
    let text = room.get_mut(..bytes.len())?;
    text.iter_mut().zip(bytes).for_each(|(to, byte)| *to = if *byte == mark { b'.' } else { *byte });
    std::str::from_utf8(text).ok()?.parse().ok()
}

/// Bytes of a number: the digits of any double, written out, are fewer.
const LONGEST: usize = 1100;

/// A whole cell as a number: `Some(NaN)` where it says that nothing was read, `None` where it is a text.
pub(super) fn number(cell: &[u8], mark: u8) -> Option<f64> {
    let cell = cell.trim_ascii();
    if let Some((value, length)) = leading(cell, mark)
        && length == cell.len()
    {
        return Some(value);
    }
    if is_absent(cell) {
        return Some(f64::NAN);
    }
    let plain = ungrouped(cell, mark)?;
    leading(&plain, mark).filter(|(_, length)| *length == plain.len()).map(|(value, _)| value)
}

/// A number with the minus of typesetters, or whose digits before the decimal mark are grouped in threes by blanks or apostrophes (ISO 80000-1), without these. Of comma and point
/// the one that is no decimal mark groups as well, where it stands twice or a decimal mark behind it: alone (`20,998`) it may be the decimal mark of another program.
fn ungrouped(cell: &[u8], mark: u8) -> Option<Vec<u8>> {
    let (sign, digits) = match cell {
        [0xE2, 0x88, 0x92, rest @ ..] => (Some(b'-'), rest),
        [sign @ (b'+' | b'-'), rest @ ..] => (Some(*sign), rest),
        rest => (None, rest),
    };
    if cell.len() > LONGEST || !digits.first()?.is_ascii_digit() {
        return None;
    }
    let other: &[u8] = if mark == b',' { b"." } else { b"," };
    let (mut plain, mut rest): (Vec<u8>, &[u8]) = (sign.into_iter().collect(), digits);
    let mut group = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let (short, mut by_other, mut groups) = (group <= 3, 0, 0);
    while let [byte, ..] = rest
        && *byte != mark
        && group > 0
    {
        plain.extend_from_slice(rest.get(..group)?);
        rest = rest.get(group..)?;
        let marks: [&[u8]; 7] = [b" ", b"'", b"\xC2\xA0", b"\xA0", "\u{202f}".as_bytes(), "\u{2019}".as_bytes(), other];
        let Some(behind) = marks.iter().find_map(|mark| rest.strip_prefix(*mark)) else { break };
        (by_other, groups) = (by_other + usize::from(rest.starts_with(other)), groups + 1);
        group = behind.iter().take_while(|byte| byte.is_ascii_digit()).count();
        if group != 3 || plain.len() > LONGEST {
            return None;
        }
        rest = behind;
    }
    // one kind of mark alone, which is not that of a decimal number
    let is_sure = by_other == groups && short && (groups > 1 || rest.first() == Some(&mark));
    plain.extend_from_slice(rest);
    Some(plain).filter(|_| by_other == 0 || is_sure)
}

/// The bytes of a number as other programs read it: with a decimal point, and without what groups its digits.
pub(super) fn pointed(cell: &[u8], mark: u8) -> Vec<u8> {
    let is_plain = leading(cell, mark).is_some_and(|(_, length)| length == cell.len());
    let plain = if is_plain { None } else { ungrouped(cell, mark) };
    let bytes = plain.unwrap_or_else(|| cell.to_vec());
    bytes.into_iter().map(|byte| if byte == mark { b'.' } else { byte }).collect()
}

/// Does a cell say that nothing was read, or nothing that is a number (the errors of spreadsheets, and of divisions by zero)?
pub(super) fn is_absent(cell: &[u8]) -> bool {
    const ABSENT: [&[u8]; 27] = [
        b"",
        b"nan",
        b"na",
        b"n/a",
        b"n.a.",
        b"null",
        b"nil",
        b"none",
        b"-nan",
        b"nan(ind)",
        b"-nan(ind)",
        b"#n/a",
        b"1.#qnan",
        b"1.#ind",
        b"-1.#ind",
        b"1.#inf",
        b"-1.#inf",
        b"inf",
        b"+inf",
        b"-inf",
        b"infinity",
        b"-infinity",
        b"#div/0!",
        b"#value!",
        b"#num!",
        b"#ref!",
        b"#name?",
    ];
    cell.len() <= 9
        && (ABSENT.iter().any(|word| cell.eq_ignore_ascii_case(word)) || cell.iter().all(|byte| *byte == b'-'))
}
