//! Codes as the database stores them: each edge between two quads is named once, and not twice.
//!
//! A code ([`crate::code`]) names the edge across from every edge. Where that comes later in the
//! code it is stored, as the number of places ahead; where it came before it follows from what was
//! stored there; on the border 0 is stored. Numbers are packed, seven bits a byte, lowest first.

use crate::code::MAX_QUADS;

/// Rows of numbers one after the other.
pub struct Rows<T> {
    /// All numbers.
    pub flat: Vec<T>,
    /// Where each row ends, after a 0. Rows from `bad` on are 0 long.
    pub ends: Vec<i64>,
    /// The first row that was not a code.
    pub bad: Option<usize>,
}

/// Return the numbers that are stored of codes: row i is `symbols[offsets[i]..offsets[i + 1]]`.
pub fn name_once(symbols: &[i32], offsets: &[i64]) -> Rows<i32> {
    let mut numbers = Vec::with_capacity(symbols.len());
    let mut ends = vec![0; offsets.len()];
    for (row, at) in offsets.windows(2).enumerate() {
        let code = &symbols[at[0] as usize..at[1] as usize];
        if !push_forward(code, &mut numbers) {
            return Rows {
                flat: numbers,
                ends,
                bad: Some(row),
            };
        }
        ends[row + 1] = numbers.len() as i64;
    }
    Rows {
        flat: numbers,
        ends,
        bad: None,
    }
}

/// Add what is stored of a code; return whether it pairs its edges.
fn push_forward(code: &[i32], numbers: &mut Vec<i32>) -> bool {
    if code.is_empty() || !code.len().is_multiple_of(4) {
        return false;
    }
    for (h, &symbol) in code.iter().enumerate() {
        if symbol == 0 {
            numbers.push(0);
            continue;
        }
        // A negative symbol becomes too large an index.
        let across = (i64::from(symbol) - 1) as usize;
        if across == h || code.get(across) != Some(&(h as i32 + 1)) {
            return false;
        }
        if across > h {
            numbers.push((across - h) as i32);
        }
    }
    true
}

/// Return the symbols of short codes: row i is `raw[ends[i]..ends[i + 1]]`.
///
/// No symbols are returned if one of the rows is not a short code.
pub fn name_twice(raw: &[u8], ends: &[i64]) -> Rows<u16> {
    let mut restored = Rows {
        flat: Vec::with_capacity(2 * raw.len()),
        ends: vec![0; ends.len()],
        bad: None,
    };
    let mut code = ShortCode::default();
    for (row, at) in ends.windows(2).enumerate() {
        if code.read(&raw[at[0] as usize..at[1] as usize]).is_none() {
            restored.flat.clear();
            restored.bad = Some(row);
            return restored;
        }
        restored.flat.extend(&code.symbols);
        restored.ends[row + 1] = restored.flat.len() as i64;
    }
    restored
}

/// One short code while it is read.
#[derive(Default)]
struct ShortCode {
    symbols: Vec<u16>,
    named: Vec<bool>,
}

impl ShortCode {
    /// Read a row; `None` if it is not a short code.
    fn read(&mut self, row: &[u8]) -> Option<()> {
        // Every byte is a number or a part of one, and a number names two edges at most.
        let most = (2 * row.len()).min(4 * MAX_QUADS);
        self.symbols.clear();
        self.symbols.resize(most, 0);
        self.named.clear();
        self.named.resize(most, false);
        let mut rest = row;
        let mut h = 0;
        let mut count = 0;
        loop {
            while h < most && self.named[h] {
                h += 1;
            }
            if rest.is_empty() {
                break;
            }
            if h >= most {
                return None;
            }
            let ahead = read_number(&mut rest)?;
            self.named[h] = true;
            count += 1;
            if ahead > 0 {
                let across = h + ahead;
                if across >= most || self.named[across] {
                    return None;
                }
                self.named[across] = true;
                count += 1;
                self.symbols[h] = across as u16 + 1;
                self.symbols[across] = h as u16 + 1;
            }
            h += 1;
        }
        // All edges up to the last are named, of whole quads.
        self.symbols.truncate(h);
        (h > 0 && h.is_multiple_of(4) && count == h).then_some(())
    }
}

/// Read one packed number of at most three bytes off the row; `None` if it is cut, longer, or
/// written with more bytes than it needs.
fn read_number(row: &mut &[u8]) -> Option<usize> {
    let mut number = 0;
    for place in 0..3 {
        let (&byte, rest) = row.split_first()?;
        *row = rest;
        number |= usize::from(byte & 127) << (7 * place);
        if byte < 128 {
            return (place == 0 || byte > 0).then_some(number);
        }
    }
    None
}

/// Append a number to a row, seven bits a byte, lowest first.
pub fn push_packed(row: &mut Vec<u8>, number: u64) {
    let mut number = number;
    while number > 127 {
        row.push((number & 127) as u8 | 128);
        number >>= 7;
    }
    row.push(number as u8);
}

/// Pack codes, seven bits a byte: code i is `symbols[offsets[i]..offsets[i + 1]]`.
pub fn pack_symbols(symbols: &[u16], offsets: &[i64]) -> Rows<u8> {
    let mut packed = Rows {
        flat: Vec::with_capacity(symbols.len() + symbols.len() / 8),
        ends: vec![0],
        bad: None,
    };
    for at in offsets.windows(2) {
        for &symbol in &symbols[at[0] as usize..at[1] as usize] {
            push_packed(&mut packed.flat, symbol.into());
        }
        packed.ends.push(packed.flat.len() as i64);
    }
    packed
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAIR: [i32; 8] = [0, 8, 0, 0, 0, 0, 0, 2];

    #[test]
    fn a_code_comes_back() {
        let once = name_once(&PAIR, &[0, 8]);
        assert_eq!(once.flat, [0, 6, 0, 0, 0, 0, 0]);
        let raw: Vec<u8> = once.flat.iter().map(|&n| n as u8).collect();
        let twice = name_twice(&raw, &[0, 7]);
        assert_eq!(twice.flat, PAIR.map(|symbol| symbol as u16));
        assert_eq!(twice.ends, [0, 8]);
    }

    #[test]
    fn codes_that_do_not_pair_up_are_refused() {
        for code in [[0, 0, 9, 0], [0, 2, 0, 0], [0, 3, 0, 0], [0, -7, 0, 0]] {
            assert_eq!(name_once(&code, &[0, 4]).bad, Some(0));
        }
        assert_eq!(name_once(&[], &[0, 0]).bad, Some(0));
    }

    #[test]
    fn rows_that_are_not_short_codes_are_refused() {
        for raw in [
            &[0; 3][..],
            &[128, 0],
            &[],
            &[0, 0, 0, 200],
            &[7, 0, 0, 0],
            &[255; 4],
        ] {
            assert_eq!(
                name_twice(raw, &[0, raw.len() as i64]).bad,
                Some(0),
                "{raw:?}"
            );
        }
    }

    #[test]
    fn numbers_are_packed_lowest_bits_first() {
        let packed = pack_symbols(&[1, 127, 128, 65535], &[0, 2, 4]);
        assert_eq!(packed.flat, [1, 127, 128, 1, 255, 255, 3]);
        assert_eq!(packed.ends, [0, 2, 7]);
    }
}
