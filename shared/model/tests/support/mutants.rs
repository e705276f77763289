//! Mutants of text files that mostly stay well-formed, so that what is behind the parsers is met too.

use std::ops::Range;

/// SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    fn pick<'a, T>(&mut self, items: &'a [T]) -> Option<&'a T> {
        items.get(self.below(items.len()))
    }
}

const NUMBERS: [&str; 24] = [
    "0",
    "-0",
    "-0.0",
    "1",
    "-1",
    "1e308",
    "-1e308",
    "1e-308",
    "1e-320",
    "1e400",
    ".nan",
    ".inf",
    "-.inf",
    "nan",
    "inf",
    "99999999999999999999",
    "1e4",
    "1e-6",
    "0x7f",
    "1_000",
    "0.5",
    "3.2",
    "''",
    "~",
];
const CHARACTERS: [&str; 8] = ["é", "\u{202E}", "\u{0}", "日本", "\u{1F916}", "\u{FEFF}", "\u{301}", " "];

/// A text with one to three changes.
pub fn mutant(random: &mut Random, text: &str) -> Vec<u8> {
    let mut text = text.to_owned();
    for _ in 0..1 + random.below(3) {
        text = change(random, &text);
    }
    // A few get arbitrary bytes besides.
    let mut bytes = text.into_bytes();
    if random.below(20) == 0 && !bytes.is_empty() {
        let at = random.below(bytes.len());
        bytes[at] = random.next().to_le_bytes()[0];
    }
    bytes
}

fn change(random: &mut Random, text: &str) -> String {
    let is_number = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
    let numbers = || runs(text, is_number).into_iter().filter(|r| text[r.clone()].parse::<f64>().is_ok()).collect();
    let words = || -> Vec<Range<usize>> { runs(text, |c| c.is_alphanumeric() || c == '_') };
    match random.below(13) {
        0 | 1 => {
            let by = random.pick(&NUMBERS).copied().unwrap_or("0");
            replaced(random, text, numbers(), |_| by.to_owned())
        }
        2 => {
            let factor = [-1.0, 1e3, 1e-3, 1.001, 2.0, 1e9][random.below(6)];
            replaced(random, text, numbers(), |old| (old.parse().unwrap_or(1.0) * factor).to_string())
        }
        3 => swapped(random, text, &numbers()),
        4 => swapped(random, text, &words()),
        5 | 6 => {
            let by = random.pick(&words()).map_or("x".to_owned(), |word| text[word.clone()].to_owned());
            replaced(random, text, words(), |_| by.clone())
        }
        7 => replaced(random, text, fields(text), |_| String::new()),
        8 => replaced(random, text, fields(text), |old| format!("{old}{old}")),
        9 => {
            let depth = [1, 3, 40, 3_000][random.below(4)];
            replaced(random, text, numbers(), |old| format!("{}{old}{}", "[".repeat(depth), "]".repeat(depth)))
        }
        10 => {
            let by = random.pick(&CHARACTERS).copied().unwrap_or("é");
            replaced(random, text, words(), |old| format!("{old}{by}"))
        }
        _ => lines_changed(random, text),
    }
}

/// Drops, doubles, repeats, moves or wraps lines: entries of lists, elements, whole blocks.
fn lines_changed(random: &mut Random, text: &str) -> String {
    let mut lines: Vec<String> = text.split('\n').map(str::to_owned).collect();
    let (at, other) = (random.below(lines.len()), random.below(lines.len()));
    match random.below(6) {
        0 => drop(lines.remove(at)),
        1 => lines.insert(at, lines[at].clone()),
        2 => lines.swap(at, other),
        3 => lines.insert(other, lines[at].clone()),
        4 => {
            let count = [10, 300, 2_000][random.below(3)];
            lines[at] = vec![lines[at].clone(); count].join("\n");
        }
        _ => {
            let depth = [1, 5, 70, 5_000][random.below(4)];
            lines[at] = format!("{}{}{}", "<link name=\"x\">".repeat(depth), lines[at], "</link>".repeat(depth));
        }
    }
    lines.join("\n")
}

/// Maximal runs of characters that fit.
fn runs(text: &str, fits: impl Fn(char) -> bool) -> Vec<Range<usize>> {
    let (mut found, mut start) = (Vec::new(), None);
    for (at, c) in text.char_indices().chain([(text.len(), '\n')]) {
        match (fits(c), start) {
            (true, None) => start = Some(at),
            (false, Some(from)) => {
                found.push(from..at);
                start = None;
            }
            _ => {}
        }
    }
    found
}

/// `key: value, ` in YAML's flow maps and ` key="value"` in XML.
fn fields(text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices("=\"") {
        let start = text[..at].rfind(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(0);
        let end = text[at + 2..].find('"').map(|end| at + end + 3);
        found.extend(end.map(|end| start..end));
    }
    for (at, _) in text.match_indices(", ") {
        let rest = &text[at + 2..];
        let mut depth = 0_i32;
        let end = rest.find(|c: char| {
            depth += i32::from("[{".contains(c)) - i32::from("]}".contains(c));
            depth < 0 || c == '\n' || (depth == 0 && c == ',')
        });
        found.extend(end.map(|end| at..at + 2 + end));
    }
    found
}

fn replaced(random: &mut Random, text: &str, spans: Vec<Range<usize>>, by: impl Fn(&str) -> String) -> String {
    let Some(span) = random.pick(&spans) else { return text.to_owned() };
    let mut text = text.to_owned();
    let new = by(&text[span.clone()]);
    text.replace_range(span.clone(), &new);
    text
}

fn swapped(random: &mut Random, text: &str, spans: &[Range<usize>]) -> String {
    let (a, b) = (random.below(spans.len()), random.below(spans.len()));
    let (Some(first), Some(second)) = (spans.get(a.min(b)), spans.get(a.max(b))) else { return text.to_owned() };
    if a == b {
        return text.to_owned();
    }
    let parts = [
        &text[..first.start],
        &text[second.clone()],
        &text[first.end..second.start],
        &text[first.clone()],
        &text[second.end..],
    ];
    parts.concat()
}
