//! Colors of bodies.

use drystone::BodyKind;

/// An sRGB color: red, green, blue, opacity.
pub type Color = [u8; 4];

/// Static bodies: stone.
pub(crate) const STATIC: Color = [176, 173, 166, 255];
/// The ground.
pub(crate) const GROUND: Color = [178, 176, 170, 255];
/// Rods and ropes of joints.
pub(crate) const ROD: Color = [84, 80, 76, 255];
/// Particles of ropes and cloths, and the links between them.
pub(crate) const THREAD: Color = [196, 152, 96, 255];
/// Particles without links.
pub(crate) const DUST: Color = [214, 196, 150, 255];

/// Muted earth and slate colors. They differ in lightness, so that neighbors also differ in grey.
const PALETTE: [[u8; 3]; 8] = [
    [201, 121, 91],
    [222, 196, 148],
    [111, 143, 168],
    [143, 169, 139],
    [168, 96, 76],
    [226, 214, 190],
    [107, 154, 150],
    [201, 155, 74],
];

/// Bodies that a script or a film moves: slate, less vivid than the colors of dynamic bodies.
const SLATE: [[u8; 3]; 8] = [
    [92, 104, 120],
    [126, 134, 142],
    [104, 96, 112],
    [138, 126, 116],
    [84, 112, 118],
    [112, 122, 108],
    [122, 106, 98],
    [150, 148, 140],
];

/// The color of the body with this number, the same in every picture.
#[must_use]
pub fn body_color(kind: BodyKind, number: u32) -> Color {
    match kind {
        BodyKind::Static => STATIC,
        BodyKind::Kinematic => scattered(&SLATE, number),
        BodyKind::Dynamic => scattered(&PALETTE, number),
    }
}

/// Picks one of eight colors at random by number, so that rows of equal bodies show no stripes.
/// Bodies of one hue differ slightly.
fn scattered(colors: &[[u8; 3]; 8], number: u32) -> Color {
    let mixed = number.wrapping_add(1).wrapping_mul(0x9E37_79B9);
    let mixed = (mixed ^ (mixed >> 15)).wrapping_mul(0x85EB_CA6B);
    let [r, g, b] = colors[(mixed >> 29) as usize];
    let lighter = |c: u8| c.saturating_sub(9).saturating_add((mixed >> 9 & 15) as u8);
    [lighter(r), lighter(g), lighter(b), 255]
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::{BodyKind, body_color};

    #[test]
    fn neighbors_differ_and_colors_stay() {
        for kind in [BodyKind::Dynamic, BodyKind::Kinematic] {
            let colors: BTreeSet<_> = (0..64).map(|n| body_color(kind, n)).collect();
            assert!(colors.len() > 32);
            assert_eq!(body_color(kind, 7), body_color(kind, 7));
        }
    }
}
