//! Damage to bytes and to text: bits, pieces, numbers, counts.

use crate::rng::Rng;

/// Damages bytes in one to four places.
pub fn bytes(bytes: &mut Vec<u8>, rng: &mut Rng) {
    for _ in 0..rng.from_to(1, 4) {
        if bytes.is_empty() {
            return;
        }
        let at = rng.below(bytes.len());
        match rng.below(9) {
            0 | 1 => bytes[at] ^= 1 << rng.below(8),
            2 => bytes[at] = rng.pick(&[0, 1, 0x7f, 0x80, 0xff]),
            3 => overwrite(bytes, at, &crate::generate::extreme_number(rng).to_le_bytes()),
            4 => {
                let word = rng.pick(&[0_u32, 1, 0x7fff_ffff, 0x8000_0000, u32::MAX, 0x0010_0000]);
                overwrite(bytes, at, &word.to_le_bytes());
            }
            // An integer of any length, in a format with seven bits per byte.
            5 => overwrite(bytes, at, &[0xff; 9][..rng.below(9)]),
            6 => {
                let piece = piece(bytes, rng);
                bytes.splice(at..at, piece);
            }
            7 => {
                let end = (at + rng.below(16)).min(bytes.len());
                bytes.drain(at..end);
            }
            _ => {
                if rng.chance(0.2) {
                    bytes.truncate(at);
                } else {
                    let piece = piece(bytes, rng);
                    overwrite(bytes, at, &piece);
                }
            }
        }
    }
}

/// A random part of the bytes.
fn piece(bytes: &[u8], rng: &mut Rng) -> Vec<u8> {
    let from = rng.below(bytes.len());
    let most = if rng.chance(0.1) { 4096 } else { 32 };
    let end = (from + 1 + rng.below(most)).min(bytes.len());
    bytes[from..end].to_vec()
}

fn overwrite(bytes: &mut [u8], at: usize, by: &[u8]) {
    let count = by.len().min(bytes.len() - at);
    bytes[at..at + count].copy_from_slice(&by[..count]);
}

/// Numbers that often break code that does not expect them.
const NUMBERS: [&str; 24] = [
    "0",
    "-0",
    "1",
    "-1",
    "0.5",
    "1e-45",
    "1e-38",
    "1e-30",
    "1e-9",
    "1e-5",
    "1e5",
    "1e7",
    "1e9",
    "1e20",
    "3.4028235e38",
    "-3.4028235e38",
    "1e39",
    "nan",
    "inf",
    "-inf",
    "65536",
    "4294967295",
    "4294967296",
    "18446744073709551615",
];

/// Damages text in one to three places, preferably at numbers, names and brackets.
pub fn text(bytes: &mut Vec<u8>, rng: &mut Rng) {
    for _ in 0..rng.from_to(1, 3) {
        match rng.below(10) {
            0..=4 => number(bytes, rng),
            5 => token(bytes, rng),
            6 => element(bytes, rng),
            7 => swap_words(bytes, rng),
            _ => self::bytes(bytes, rng),
        }
    }
}

/// Replaces a number by another one.
fn number(bytes: &mut Vec<u8>, rng: &mut Rng) {
    let is_part = |b: u8| b.is_ascii_digit() || b"+-.eE".contains(&b);
    let all = runs(bytes, is_part, |run| run.iter().any(u8::is_ascii_digit));
    if all.is_empty() {
        return;
    }
    let (from, to) = rng.pick(&all);
    let value = if rng.chance(0.2) {
        crate::generate::extreme_number(rng).to_string()
    } else {
        rng.pick(&NUMBERS).to_owned()
    };
    bytes.splice(from..to, value.into_bytes());
}

/// Duplicates or deletes a word.
fn token(bytes: &mut Vec<u8>, rng: &mut Rng) {
    let all = words(bytes);
    if all.is_empty() {
        return;
    }
    let (from, to) = rng.pick(&all);
    if rng.chance(0.5) {
        bytes.drain(from..to);
    } else {
        let word = bytes[from..to].to_vec();
        let count = if rng.chance(0.05) { 5000 } else { 1 };
        let copies: Vec<u8> = [&b" "[..], &word].concat().repeat(count);
        bytes.splice(to..to, copies);
    }
}

/// Overwrites one word with another.
fn swap_words(bytes: &mut Vec<u8>, rng: &mut Rng) {
    let all = words(bytes);
    if all.is_empty() {
        return;
    }
    let (from, to) = rng.pick(&all);
    let (other_from, other_to) = rng.pick(&all);
    let word = bytes[other_from..other_to].to_vec();
    bytes.splice(from..to, word);
}

/// Duplicates, nests or deletes the text between two brackets.
fn element(bytes: &mut Vec<u8>, rng: &mut Rng) {
    let opens: Vec<usize> = (0..bytes.len()).filter(|i| b"{[<".contains(&bytes[*i])).collect();
    if opens.is_empty() {
        return;
    }
    let from = rng.pick(&opens);
    let closing = match bytes[from] {
        b'{' => b'}',
        b'[' => b']',
        _ => b'>',
    };
    let mut depth = 0_usize;
    let end = (from..bytes.len()).find(|i| {
        if bytes[*i] == bytes[from] {
            depth += 1;
        } else if bytes[*i] == closing {
            depth -= 1;
        }
        depth == 0
    });
    let Some(end) = end.map(|end| end + 1) else { return };
    match rng.below(3) {
        0 => {
            bytes.drain(from..end);
        }
        1 => {
            let mut copy = bytes[from..end].to_vec();
            if closing != b'>' {
                copy.insert(0, b',');
            }
            let copies = copy.repeat(if rng.chance(0.1) { 100 } else { 1 });
            bytes.splice(end..end, copies);
        }
        _ => {
            let depth = rng.pick(&[1, 100, 20_000]);
            bytes.splice(end..end, vec![closing; depth]);
            bytes.splice(from..from, vec![bytes[from]; depth]);
        }
    }
}

fn words(bytes: &[u8]) -> Vec<(usize, usize)> {
    runs(bytes, |b| b.is_ascii_alphanumeric() || b"_-.\"".contains(&b), |run| run.len() > 1)
}

/// Runs of adjacent bytes of a kind: start, and end (exclusive).
fn runs(
    bytes: &[u8],
    is_part: impl Fn(u8) -> bool,
    counts: impl Fn(&[u8]) -> bool,
) -> Vec<(usize, usize)> {
    let mut all = Vec::new();
    let mut from = None;
    for i in 0..=bytes.len() {
        let inside = bytes.get(i).is_some_and(|b| is_part(*b));
        match from {
            None if inside => from = Some(i),
            Some(start) if !inside => {
                if counts(&bytes[start..i]) {
                    all.push((start, i));
                }
                from = None;
            }
            _ => {}
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{bytes, text};
    use crate::rng::Rng;

    #[test]
    fn damage_repeats_and_panics_nowhere() {
        let seed = br#"{"bodies": [{"mass": 1.5e0, "at": [0, -1, 2]}], "name": "a"}"#.to_vec();
        for i in 0..3000 {
            let (mut a, mut b) = (seed.clone(), seed.clone());
            text(&mut a, &mut Rng::new(i));
            text(&mut b, &mut Rng::new(i));
            assert_eq!(a, b);
            bytes(&mut a, &mut Rng::new(i));
        }
        text(&mut Vec::new(), &mut Rng::new(0));
    }
}
