//! Which rung of a ladder keeps to a budget, by the times of frames. Nothing here knows what a rung is.

use std::collections::VecDeque;

/// Frames after a change that say nothing: they compile pipelines, draw shadow maps anew and fill histories.
const SKIPPED: u32 = 2;
/// So many frames from the first it may change as often as it likes.
const SETTLING_FRAMES: u32 = 30;
/// A median counts from so many frames on: one stall among three is none.
const SAMPLES_SETTLING: usize = 3;
/// The same afterwards, where a change is dear because there are few.
const SAMPLES: usize = 9;
/// The median is that of so many frames at most.
const WINDOW: usize = 31;
/// A median above so many times the budget is too much.
const OVER: f64 = 1.05;
/// A cheaper rung is one that is expected to take so much of the budget, and the second of a minute one that has room
/// for what was not foreseen.
const FIT: f64 = 0.95;
const FIT_SURELY: f64 = 0.8;
/// A better rung is taken if it is expected to take no more than this, well below [`OVER`]: so neither noise nor a
/// wrong guess leads back and forth.
const ROOM: f64 = 0.85;
/// After [`SETTLING_FRAMES`] there are so many changes in any minute.
const CHANGES_A_MINUTE: usize = 2;
const MINUTE_MS: f64 = 60_000.0;

/// Chooses a rung, 0 the best one, of a ladder.
#[derive(Clone, Debug)]
pub(super) struct Controller {
    budget_ms: f64,
    /// What frames of each rung take beside each other, in any unit, falling: first as it was guessed, then as it was
    /// found.
    costs: Vec<f64>,
    rung: usize,
    /// Frames since the last change, and the times of the last of them.
    frames_here: u32,
    times_ms: VecDeque<f64>,
    /// What it was before the last change: rung, median, and costs as they were known.
    before: Option<(usize, f64, Vec<f64>)>,
    frames: u32,
    /// The sum of all times: no more than what has passed, as frames that nobody asks for are none.
    clock_ms: f64,
    /// When the changes after [`SETTLING_FRAMES`] were, within the last minute.
    changed_ms: VecDeque<f64>,
    changes: u32,
    settled_after: u32,
}

impl Controller {
    /// At rung `start`, of rungs that take `costs` beside each other. At least one.
    pub fn new(budget_ms: f64, costs: Vec<f64>, start: usize) -> Self {
        Self {
            budget_ms,
            rung: start.min(costs.len().saturating_sub(1)),
            costs,
            frames_here: 0,
            times_ms: VecDeque::new(),
            before: None,
            frames: 0,
            clock_ms: 0.0,
            changed_ms: VecDeque::new(),
            changes: 0,
            settled_after: 0,
        }
    }

    /// The rung of the next frame.
    pub fn rung(&self) -> usize {
        self.rung
    }

    /// How often it changed.
    pub fn changes(&self) -> u32 {
        self.changes
    }

    /// How many frames there were up to the last change.
    pub fn settled_after(&self) -> u32 {
        self.settled_after
    }

    /// The median of the last frames since the change, without those that say nothing; none before there are any.
    pub fn median_ms(&self) -> Option<f64> {
        let mut sorted: Vec<f64> = self.times_ms.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let upper = *sorted.get(sorted.len() / 2)?;
        let lower = *sorted.get(sorted.len().saturating_sub(1) / 2)?;
        Some(0.5 * (lower + upper))
    }

    /// Takes what a frame took, and says whether the next one is to be of another rung. What is no time is passed over.
    pub fn take(&mut self, frame_ms: f64) -> bool {
        if !(frame_ms.is_finite() && frame_ms > 0.0) {
            return false;
        }
        self.frames = self.frames.saturating_add(1);
        self.frames_here = self.frames_here.saturating_add(1);
        self.clock_ms += frame_ms;
        if self.frames_here <= SKIPPED {
            return false;
        }
        self.times_ms.push_back(frame_ms);
        if self.times_ms.len() > WINDOW {
            self.times_ms.pop_front();
        }
        let is_settling = self.frames <= SETTLING_FRAMES;
        let samples = if is_settling { SAMPLES_SETTLING } else { SAMPLES };
        let Some(median_ms) = self.median_ms().filter(|_| self.times_ms.len() >= samples) else { return false };
        self.learn(median_ms);
        let clock_ms = self.clock_ms;
        self.changed_ms.retain(|at_ms| clock_ms - at_ms < MINUTE_MS);
        let recent = if is_settling { 0 } else { self.changed_ms.len() };
        let Some(rung) = self.wanted(median_ms, recent) else { return false };
        if !is_settling {
            self.changed_ms.push_back(clock_ms);
        }
        self.before = Some((self.rung, median_ms, self.costs.clone()));
        self.rung = rung;
        self.changes = self.changes.saturating_add(1);
        self.settled_after = self.frames;
        self.frames_here = 0;
        self.times_ms.clear();
        true
    }

    /// The rung to change to, after `recent` changes within a minute.
    fn wanted(&self, median_ms: f64, recent: usize) -> Option<usize> {
        let last = self.costs.len().saturating_sub(1);
        let share_of = |rung: usize| {
            let (here, there) = (self.costs.get(self.rung)?, self.costs.get(rung)?);
            Some(median_ms * there / here / self.budget_ms)
        };
        let best = |mut rungs: std::ops::Range<usize>, most: f64| {
            rungs.find(|rung| share_of(*rung).is_some_and(|share| share <= most))
        };
        if recent >= CHANGES_A_MINUTE {
            return None;
        }
        if median_ms > OVER * self.budget_ms {
            let fit = if recent == 0 { FIT } else { FIT_SURELY };
            return (self.rung < last).then(|| best(self.rung + 1..last, fit).unwrap_or(last));
        }
        // A better rung that turns out to be too much leaves one change for the way back.
        if recent == 0 { best(0..self.rung, ROOM) } else { None }
    }

    /// Corrects what rungs cost by what the last change brought, while that is new: later another load may be the
    /// reason. What lies beyond the new rung is taken to be off by the same factor, what lies between by a part of it.
    fn learn(&mut self, median_ms: f64) {
        let Some((from, from_ms, costs)) = &self.before else { return };
        if self.times_ms.len() > SAMPLES {
            return;
        }
        let (Some(cost_from), Some(cost_here)) = (costs.get(*from), costs.get(self.rung)) else { return };
        let found = cost_from * median_ms / from_ms;
        let factor = found / cost_here;
        // Between them ratios are raised to the power that makes that of both ends what was found.
        let power = (found / cost_from).ln() / (cost_here / cost_from).ln();
        let is_down = self.rung > *from;
        self.costs = costs.clone();
        for (rung, cost) in self.costs.iter_mut().enumerate() {
            let is_beyond = if is_down { rung >= self.rung } else { rung <= self.rung };
            let is_between = if is_down { rung > *from } else { rung < *from };
            if is_beyond {
                *cost *= factor;
            } else if is_between {
                *cost = cost_from * (*cost / cost_from).powf(power);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What rungs are guessed to cost, as those of the ladder.
    const GUESSED: [f64; 8] = [2.5, 1.45, 1.0, 0.75, 0.5, 0.35, 0.25, 0.2];

    /// Numbers from 0 to 1 that look random.
    fn random() -> impl FnMut() -> f64 {
        let mut state = 1_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    /// Draws `count` frames of rungs that take `of_rungs`, times what `load` says of a frame; the first ones after a
    /// change take three times as long. The rung of every frame.
    fn drawn(
        controller: &mut Controller,
        count: usize,
        of_rungs: [f64; 8],
        mut load: impl FnMut(usize) -> f64,
    ) -> Vec<usize> {
        let mut new_frames = 2_u32;
        (0..count)
            .map(|frame| {
                let rung = controller.rung();
                let ms = of_rungs[rung] * load(frame) * if new_frames > 0 { 3.0 } else { 1.0 };
                new_frames = if controller.take(ms) { 2 } else { new_frames.saturating_sub(1) };
                rung
            })
            .collect()
    }

    /// The best rung within the budget by what rungs take.
    fn best(of_rungs: [f64; 8], budget_ms: f64) -> usize {
        of_rungs.iter().position(|ms| *ms <= budget_ms).unwrap_or(7)
    }

    fn of_medium(ms: f64) -> [f64; 8] {
        GUESSED.map(|cost| cost * ms)
    }

    #[test]
    fn after_thirty_frames_a_frame_is_within_the_budget_whatever_it_took_at_first() {
        // Rungs that cost what was guessed, much less of a difference, more of one, and steps that were not foreseen.
        let unlike = [9.0, 2.0, 1.0, 0.95, 0.9, 0.3, 0.28, 0.1];
        for shape in [GUESSED, GUESSED.map(f64::sqrt), GUESSED.map(|cost| cost * cost), unlike] {
            for medium_ms in [1.0, 5.0, 14.0, 16.0, 17.5, 20.0, 33.0, 60.0, 150.0, 1000.0] {
                let of_rungs = shape.map(|cost| cost * medium_ms);
                for noise in [0.0, 0.05, 0.2] {
                    let mut random = random();
                    let mut controller = Controller::new(16.0, GUESSED.to_vec(), 2);
                    drawn(&mut controller, 30, of_rungs, |_| 1.0 + noise * (2.0 * random() - 1.0));
                    let ms = of_rungs[controller.rung()];
                    let can = of_rungs[7] <= 16.0;
                    assert!(!can || ms <= 1.1 * 16.0, "{medium_ms} ms, noise {noise}: {ms} ms at {controller:?}");
                    assert!(can || controller.rung() == 7, "{medium_ms} ms: the cheapest where none can");
                    // And it does not give away what there is: better rungs are beyond the budget, or nearly.
                    if noise == 0.0 && shape != unlike && controller.rung() > 0 {
                        let better = of_rungs[controller.rung() - 1];
                        assert!(better > 0.84 * 16.0, "{medium_ms} ms: {better} ms would do as well, {controller:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn noise_changes_nothing_for_minutes_once_it_is_settled() {
        for noise in [0.05, 0.2, 0.4] {
            for medium_ms in [10.0, 13.0, 15.9, 16.5, 17.0, 24.0, 31.0] {
                let mut random = random();
                let mut controller = Controller::new(16.0, GUESSED.to_vec(), 2);
                let of_rungs = of_medium(medium_ms);
                let mut load = |_: usize| 1.0 + noise * (2.0 * random() - 1.0);
                drawn(&mut controller, 30, of_rungs, &mut load);
                let settled = controller.changes();
                // Ten minutes at 16 ms.
                let rungs = drawn(&mut controller, 37_500, of_rungs, &mut load);
                let changes = controller.changes() - settled;
                assert!(changes <= 3, "noise {noise}, {medium_ms} ms: {changes} changes in ten minutes");
                let late = rungs.last().map(|rung| of_rungs[*rung]);
                assert!(late.is_some_and(|ms| ms <= 1.1 * 16.0), "noise {noise}, {medium_ms} ms: {late:?}");
            }
        }
    }

    #[test]
    fn a_step_of_the_load_costs_two_changes_at_most() {
        for factor in [0.2, 0.4, 0.7, 1.4, 2.0, 4.0] {
            for shape in [GUESSED, GUESSED.map(f64::sqrt), GUESSED.map(|cost| cost.powf(1.5))] {
                let mut random = random();
                let mut controller = Controller::new(16.0, GUESSED.to_vec(), 2);
                let of_rungs = shape.map(|cost| 20.0 * cost);
                drawn(&mut controller, 3000, of_rungs, |_| 0.95 + 0.1 * random());
                let settled = controller.changes();
                let rungs = drawn(&mut controller, 600, of_rungs, |_| factor * (0.95 + 0.1 * random()));
                let changes = controller.changes() - settled;
                assert!(changes <= 2, "× {factor}: {changes} changes");
                let reached = of_rungs.map(|ms| factor * ms);
                let last = *rungs.last().expect("frames");
                assert!(reached[last] <= 1.1 * 16.0 || last == 7, "× {factor}: {} ms at rung {last}", reached[last]);
                // Where costs are as they were guessed it is there after thirty frames.
                if shape == GUESSED {
                    assert_eq!(rungs[31], last, "× {factor}");
                }
                assert!(factor > 0.5 || last < rungs[0], "× {factor}: what becomes free is used");
            }
        }
    }

    #[test]
    fn there_are_two_changes_a_minute_at_most_whatever_comes() {
        // A load that jumps up and down every second.
        let mut controller = Controller::new(16.0, GUESSED.to_vec(), 2);
        let of_rungs = of_medium(14.0);
        drawn(&mut controller, 30, of_rungs, |_| 1.0);
        let (mut clock_ms, mut changed_ms) = (0.0, Vec::new());
        for frame in 0..40_000 {
            let ms = of_rungs[controller.rung()] * if (frame / 60) % 2 == 0 { 1.0 } else { 2.2 };
            clock_ms += ms;
            if controller.take(ms) {
                changed_ms.push(clock_ms);
            }
        }
        assert!(changed_ms.len() > 2, "it does follow");
        let within = |from: &f64| changed_ms.iter().filter(|at| (*from..from + MINUTE_MS).contains(*at)).count();
        assert!(changed_ms.iter().map(within).max() <= Some(CHANGES_A_MINUTE), "{changed_ms:?}");
    }

    #[test]
    fn a_stall_changes_nothing_wherever_it_is() {
        for at in 0..60 {
            let mut controller = Controller::new(16.0, GUESSED.to_vec(), 2);
            for frame in 0..60 {
                assert!(!controller.take(if frame == at { 5000.0 } else { 15.0 }), "a stall in frame {at}");
            }
            assert_eq!((controller.rung(), controller.changes(), controller.settled_after()), (2, 0, 0));
        }
    }

    #[test]
    fn budgets_at_the_ends_and_times_that_are_none() {
        let mut huge = Controller::new(1e5, GUESSED.to_vec(), 2);
        drawn(&mut huge, 30, of_medium(100.0), |_| 1.0);
        assert_eq!((huge.rung(), huge.changes()), (0, 1));
        let mut tiny = Controller::new(1e-3, GUESSED.to_vec(), 2);
        drawn(&mut tiny, 300, of_medium(100.0), |_| 1.0);
        assert_eq!((tiny.rung(), tiny.changes()), (7, 1));
        let mut none = Controller::new(16.0, GUESSED.to_vec(), 2);
        for ms in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY].into_iter().cycle().take(500) {
            assert!(!none.take(ms));
        }
        assert_eq!((none.rung(), none.median_ms()), (2, None));
        let mut only = Controller::new(16.0, vec![1.0], 5);
        assert_eq!(drawn(&mut only, 100, [1000.0; 8], |_| 1.0), [0; 100]);
        assert_eq!(best(of_medium(20.0), 16.0), 3);
    }
}
