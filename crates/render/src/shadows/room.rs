//! Whether the atlas has room for maps that are twice as fine, as those of few lights at a place are.
//!
//! From frame to frame the answer is remembered: needs that swing around the limit, as with a moving camera, would have
//! maps drawn anew at another size in each frame, which is seen.

/// Once refused, finer maps are granted where they take this share of the atlas at most, so that a light that comes
/// into view rarely takes them away at once.
const GRANTED_SHARE: f64 = 0.5;
/// And where that is so even if each light wanted so many times as many texels a side.
pub(super) const GRANTED_SCALE: f32 = 1.25;

/// The texels of all maps, if they are as fine as there may be room for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Need {
    /// As they are wanted.
    pub texels: u64,
    /// As they would be if each light wanted [`GRANTED_SCALE`] times as many a side.
    pub texels_with_margin: u64,
}

/// What was answered in the frame before; nothing before the first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Room {
    was_granted: Option<bool>,
}

impl Room {
    /// Whether an atlas of `area` texels has room for what is needed. A frame that is no live one neither asks for what
    /// was answered before, nor changes it, so that a still depends on nothing but its scene.
    pub fn grants(&mut self, need: Need, area: u64, is_live: bool) -> bool {
        let is_enough = need.texels <= area;
        if !is_live {
            return is_enough;
        }
        let has_margin = need.texels_with_margin as f64 <= GRANTED_SHARE * area as f64;
        let is_granted = is_enough && (self.was_granted != Some(false) || has_margin);
        self.was_granted = Some(is_granted);
        is_granted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AREA: u64 = 2048 * 2048;

    /// The need of three point lights that want maps of so many texels a side.
    fn need(side: f32) -> Need {
        let texels = |side: f32| 18 * u64::from((side as u32).next_power_of_two()).pow(2);
        Need { texels: texels(side), texels_with_margin: texels(GRANTED_SCALE * side) }
    }

    /// How often the answer changes from one of these needs to the next.
    fn changes(room: &mut Room, needs: &[Need], is_live: bool) -> usize {
        let answers = Vec::from_iter(needs.iter().map(|need| room.grants(*need, AREA, is_live)));
        answers.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    #[test]
    fn a_need_that_swings_around_the_limit_changes_sizes_once_at_most() {
        // Of 18 maps, those of 256 texels a side fit, and those of 512 do not.
        assert!(need(256.0).texels <= AREA && need(257.0).texels > AREA);
        let swinging = Vec::from_iter((0..40u8).map(|frame| need(256.0 + 8.0 * f32::from(frame).sin())));
        assert_eq!(changes(&mut Room::default(), &swinging, true), 1);
        // Without memory, as in stills.
        assert!(changes(&mut Room::default(), &swinging, false) > 5);
        // A light at the edge of the view comes and goes: three of them fit, and four do not.
        let lights = |count: u64| {
            let texels = count * 6 * 470 * 470;
            Need { texels, texels_with_margin: texels }
        };
        assert!(lights(3).texels <= AREA && lights(4).texels > AREA);
        let coming = Vec::from_iter((0..40).map(|frame| lights(3 + frame % 2)));
        assert_eq!(changes(&mut Room::default(), &coming, true), 1);
    }

    #[test]
    fn the_first_answer_needs_no_margin_and_a_refusal_ends_with_one() {
        let mut room = Room::default();
        assert!(room.grants(need(256.0), AREA, true), "there is room");
        assert!(room.grants(need(256.0), AREA, true), "and it stays");
        assert!(!room.grants(need(300.0), AREA, true), "it is short");
        assert!(!room.grants(need(250.0), AREA, true), "there is room, and no margin");
        // What is no live frame changes nothing.
        assert!(room.grants(need(250.0), AREA, false));
        assert!(!room.grants(need(250.0), AREA, true));
        assert!(room.grants(need(200.0), AREA, true), "there is a margin");
        assert!(room.grants(need(250.0), AREA, true), "which is needed no more");
    }
}
