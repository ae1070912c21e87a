//! Pictures that show nothing: black, white or empty nearly everywhere, and what to do about it.

use manypass::Background;

/// The share of the pixels from which on a picture counts as one tone.
const SHARE: f64 = 0.99;

/// What nearly all of a picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OneTone {
    /// Two of 255 at most.
    Black,
    /// 253 of 255 at least.
    White,
    /// Exactly the background's colour.
    Empty,
}

impl OneTone {
    /// What a picture of so many RGBA pixels is, over a background; none where it shows something, and of a cut-out,
    /// which may well be small.
    pub fn of(rgba: &[u8], background: Background) -> Option<Self> {
        if background == Background::Transparent || rgba.len() < 4 {
            return None;
        }
        let background = match background {
            Background::Color(color) => Some(color.map(|linear| (255.0 * encoded(linear)).round() as u8)),
            _ => None,
        };
        let mut counts = [0usize; 3];
        for pixel in rgba.chunks_exact(4) {
            let [r, g, b] = [pixel[0], pixel[1], pixel[2]];
            counts[0] += usize::from(r.max(g).max(b) <= 2);
            counts[1] += usize::from(r.min(g).min(b) >= 253);
            counts[2] += usize::from(background == Some([r, g, b]));
        }
        let most = SHARE * (rgba.len() / 4) as f64;
        let is_all = |count: usize| count as f64 >= most;
        match counts {
            [.., empty] if is_all(empty) => Some(Self::Empty),
            [black, ..] if is_all(black) => Some(Self::Black),
            [_, white, _] if is_all(white) => Some(Self::White),
            _ => None,
        }
    }

    /// The hint, with the flags that change it.
    pub fn hint(self) -> String {
        let what = match self {
            Self::Black => {
                "black: --exposure auto meters it, --preset product lights it, and --orbit 30,28,auto shows it from outside"
            }
            Self::White => "white: --exposure auto meters it, and --orbit 30,28,auto shows the whole model",
            Self::Empty => "the background: --orbit 30,28,auto shows the whole model",
        };
        format!("99 % of the picture or more is {what}")
    }
}

/// Of linear light, by the curve of sRGB.
fn encoded(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearly_all_is_counted() {
        let of = |pixels: &[([u8; 3], usize)], background| {
            let rgba: Vec<u8> = pixels.iter().flat_map(|([r, g, b], count)| [*r, *g, *b, 255].repeat(*count)).collect();
            OneTone::of(&rgba, background)
        };
        let environment = Background::Environment;
        assert_eq!(of(&[([1, 2, 0], 990), ([90; 3], 10)], environment), Some(OneTone::Black));
        assert_eq!(of(&[([1, 2, 0], 989), ([90; 3], 11)], environment), None);
        assert_eq!(of(&[([254; 3], 1000)], environment), Some(OneTone::White));
        assert_eq!(of(&[([255; 3], 995), ([9; 3], 5)], Background::Color([1.0; 3])), Some(OneTone::Empty));
        assert_eq!(of(&[([128, 128, 128], 1000)], Background::Color([0.2159; 3])), Some(OneTone::Empty));
        assert_eq!(of(&[([0; 3], 1000)], Background::Transparent), None);
    }
}
