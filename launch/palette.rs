//! Colours that colour-blind people can tell apart, after M. Okabe and K. Ito, "Color Universal Design" (2008).

/// Red, green, blue in sRGB.
pub type Rgb = [u8; 3];

/// Robots, in order; a seventh begins again.
const ROBOTS: [Rgb; 6] = [
    [0x00, 0x72, 0xb2], // blue
    [0xd5, 0x5e, 0x00], // vermilion
    [0x00, 0x9e, 0x73], // bluish green
    [0xcc, 0x79, 0xa7], // reddish purple
    [0x56, 0xb4, 0xe9], // sky blue
    [0x9a, 0x6c, 0x3c], // brown, not of the eight: black is for text
];
/// Movable objects (yellow).
pub const OBJECT: Rgb = [0xf0, 0xd4, 0x42];
/// Fixed objects.
pub const FIXED: Rgb = [0xb9, 0xbf, 0xc8];
/// Regions.
pub const REGION: Rgb = [0x2a, 0x9d, 0x9d];

/// A robot's colour.
#[must_use]
pub fn robot(index: usize) -> Rgb {
    ROBOTS[index % ROBOTS.len()]
}

/// `part` of `b` in `a`, in sRGB.
#[must_use]
pub fn mix(a: Rgb, b: Rgb, part: f64) -> Rgb {
    std::array::from_fn(|i| (f64::from(a[i]) * (1.0 - part) + f64::from(b[i]) * part).round() as u8)
}

/// One component in linear light, 0 to 1 (IEC 61966-2-1).
#[must_use]
pub fn linear(component: u8) -> f64 {
    let value = f64::from(component) / 255.0;
    let linear = if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
    (linear * 1e6).round() / 1e6
}

/// As in a style sheet, e.g. `#0072b2`.
#[must_use]
pub fn hex(rgb: Rgb) -> String {
    rgb.iter().map(|component| format!("{component:02x}")).fold("#".to_owned(), |text, part| text + &part)
}
