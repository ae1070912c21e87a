//! When frames were drawn, from which exposure goes on.

use manypass::{Adaptation, FrameRequest};

/// After so many times of `exposure.adapt_…_s` an exposure has come to rest: of ten stops 0.003 are left.
const TIMES: f32 = 8.0;

/// A longer time in which no frame was drawn counts as this: nothing moved meanwhile.
const LONGEST_FRAME_MS: f64 = 100.0;

/// When the last frame was drawn, and the last that began a picture, in milliseconds; none before the first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FrameTimes(Option<[f64; 2]>);

impl FrameTimes {
    /// Of a frame that begins a picture now.
    pub fn begin(&mut self) -> Adaptation {
        let now_ms = js_sys::Date::now();
        let adaptation = self.after(now_ms);
        self.0 = Some([now_ms; 2]);
        adaptation
    }

    /// Of a frame that is added to the picture now.
    pub fn go_on(&mut self) -> Adaptation {
        let now_ms = js_sys::Date::now();
        let adaptation = self.after(now_ms);
        self.0 = self.0.map(|[_, begun_ms]| [now_ms, begun_ms]);
        adaptation
    }

    fn after(self, now_ms: f64) -> Adaptation {
        let since = |last_ms: f64| (1e-3 * (now_ms - last_ms).clamp(0.0, LONGEST_FRAME_MS)) as f32;
        self.0.map_or(Adaptation::Begins, |[last_ms, _]| Adaptation::After { secs: since(last_ms) })
    }

    /// Whether the exposure of a picture is still on its way.
    pub fn is_adapting(self, request: &FrameRequest) -> bool {
        let exposure = &request.settings.exposure;
        let longest_s = exposure.adapt_to_light_s.max(exposure.adapt_to_dark_s);
        let since_s = self.0.map_or(0.0, |[_, begun_ms]| 1e-3 * (js_sys::Date::now() - begun_ms));
        request.adapts() && since_s < f64::from(TIMES * longest_s)
    }
}
