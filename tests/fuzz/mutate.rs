//! Random numbers, and what is done to texts and bytes.

/// SplitMix64.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5bf0_3635)
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    /// True once in `n`.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    pub fn of<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len())]
    }

    /// 0 to 1.
    pub fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Numbers that readers should have an opinion about.
pub const NUMBERS: &[&str] = &[
    "0",
    "-0.0",
    "1",
    "-1",
    "2.5",
    "10",
    "-10",
    "100",
    "1e3",
    "-1e3",
    "1e4",
    "1e5",
    "1e6",
    "1e7",
    "1e9",
    "1e12",
    "1e16",
    "1e30",
    "1e300",
    "-1e300",
    "1e308",
    "0.5",
    "0.1",
    "1e-2",
    "1e-3",
    "1e-4",
    "1e-6",
    "1e-9",
    "1e-12",
    "1e-16",
    "1e-300",
    "5e-324",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "-9223372036854775808",
    "4294967296",
    "0.9999999999999999",
];

/// What may stand behind an equals sign.
const VALUES: &[&str] = &[
    "\"\"",
    "\"x\"",
    "\"3 deg\"",
    "\"10 mm\"",
    "\"-1e300 m\"",
    "\"1:0\"",
    "\"0:0\"",
    "\"inf\"",
    "\"nan m\"",
    "\"1e400 km\"",
    "true",
    "false",
    "[]",
    "{}",
    "[1, 2, 3]",
    "[0, 0, 0]",
    "[nan, 0, 0]",
    "[1e300, 1e300, 1e300]",
    "[[0, 0], [1, 1]]",
    "[[]]",
    "{ kind = \"arc\", radius = 2 }",
    "\"\\u0000\"",
    "\"\u{fffd}ä\"",
    "1979-05-27",
    "0x7fffffffffffffff",
    "\"../../../../etc/passwd\"",
    "\"/dev/zero\"",
];

/// Places of numbers in a text: begin and end.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut i = 0;
    while i < bytes.len() {
        let begins = bytes[i].is_ascii_digit() && (i == 0 || !(bytes[i - 1].is_ascii_alphanumeric() || bytes[i - 1] == b'_'));
        if !begins {
            i += 1;
            continue;
        }
        let mut end = i;
        while end < bytes.len() {
            let exponent = end > i && matches!(bytes[end - 1], b'e' | b'E') && matches!(bytes[end], b'-' | b'+');
            if !(bytes[end].is_ascii_digit() || bytes[end] == b'.' || matches!(bytes[end], b'e' | b'E') || exponent) {
                break;
            }
            end += 1;
        }
        found.push((i, end));
        i = end;
    }
    found
}

/// Another number for one.
fn other(random: &mut Random, text: &str) -> String {
    let value: f64 = text.parse().unwrap_or(1.0);
    match random.below(4) {
        0 | 1 => (*random.of(NUMBERS)).into(),
        2 => format!("{:e}", value * 10f64.powi(random.below(25) as i32 - 12)),
        _ => format!("{:e}", -value * (0.2 + 2.0 * random.share())),
    }
}

fn floor(text: &str, mut at: usize) -> usize {
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// One change of a text of lines with keys and values or numbers.
pub fn text(random: &mut Random, text: &str) -> String {
    let places = numbers(text);
    if !places.is_empty() && !random.once_in(3) {
        let (from, to) = *random.of(&places);
        return format!("{}{}{}", &text[..from], other(random, &text[from..to]), &text[to..]);
    }
    let mut lines: Vec<String> = text.lines().map(str::to_string).collect();
    if lines.is_empty() {
        return text.into();
    }
    let at = random.below(lines.len());
    match random.below(8) {
        0 => drop(lines.remove(at)),
        1 => lines.insert(at, lines[at].clone()),
        2 => {
            let other = random.below(lines.len());
            lines.swap(at, other);
        }
        3 | 4 => {
            if let Some((key, _)) = lines[at].clone().split_once('=') {
                lines[at] = format!("{key}= {}", random.of(VALUES));
            }
        }
        5 => {
            let to = random.below(lines.len());
            let line = lines.remove(at);
            lines.insert(to.min(lines.len()), line);
        }
        6 => {
            let cut = floor(text, random.below(text.len() + 1));
            return text[..cut].into();
        }
        _ => {
            let mut bytes = text.as_bytes().to_vec();
            for _ in 0..=random.below(4) {
                let at = random.below(bytes.len());
                bytes[at] = random.next() as u8;
            }
            return String::from_utf8_lossy(&bytes).into_owned();
        }
    }
    lines.join("\n")
}

/// One change of bytes.
pub fn bytes(random: &mut Random, bytes: &mut Vec<u8>) {
    if bytes.is_empty() {
        return bytes.push(random.next() as u8);
    }
    let at = random.below(bytes.len());
    match random.below(6) {
        0 => bytes.truncate(at),
        1 => bytes[at] ^= 1 << random.below(8),
        2 => bytes[at] = *random.of(&[0, 1, 0x7f, 0x80, 0xff]),
        3 => bytes.insert(at, random.next() as u8),
        4 => {
            let more: Vec<u8> = (0..=random.below(64)).map(|_| random.next() as u8).collect();
            bytes.splice(at..at, more);
        }
        _ => {
            let end = (at + 1 + random.below(16)).min(bytes.len());
            bytes.drain(at..end);
        }
    }
}
