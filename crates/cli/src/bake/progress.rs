//! How far a bake is, on a terminal.

use super::bakers::BakeRequest;
use crate::interrupt::STOP;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use manypass_bake::{BakeSettings, Progress, Stage};
use std::io::IsTerminal as _;
use std::sync::atomic::Ordering;

/// Steps of the bar for all texels of one round.
const ROUND: u64 = 1000;

/// A bar with the time that is left.
pub struct Bar {
    bar: ProgressBar,
    bounces: u32,
    before_occlusion: u64,
    before_probes: u64,
    before_surroundings: u64,
}

impl Bar {
    /// For a bake.
    pub fn new(quiet: bool, wanted: &BakeRequest) -> Self {
        let rounds = |maps: &BakeSettings| if maps.light { 1 + u64::from(maps.bounces) } else { 0 };
        let before_occlusion = wanted.maps.as_ref().map_or(0, rounds);
        let before_probes = before_occlusion + u64::from(wanted.maps.is_some_and(|maps| maps.occlusion));
        let before_surroundings = before_probes + u64::from(wanted.probes.is_some());
        let rounds = before_surroundings + u64::from(wanted.surroundings.is_some());
        let bounces = wanted.maps.map_or(0, |maps| maps.bounces);
        let is_shown = !quiet && std::io::stderr().is_terminal();
        let target = if is_shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(ROUND * rounds), target);
        let style = ProgressStyle::with_template("{bar:30} {percent}%  {eta} left  {wide_msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self { bar, bounces, before_occlusion, before_probes, before_surroundings }
    }

    /// Takes it away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn step(&self, stage: Stage, done: u64, total: u64) -> bool {
        let share = (ROUND * done).checked_div(total).unwrap_or(0);
        match stage {
            Stage::Layout => self.bar.set_message("laying out surfaces"),
            Stage::Inside => self.bar.set_message("looking for texels inside of surfaces"),
            Stage::Occlusion => {
                self.bar.set_position(ROUND * self.before_occlusion + share);
                self.bar.set_message("occlusion");
            }
            Stage::Probes => {
                self.bar.set_position(ROUND * self.before_probes + share);
                self.bar.set_message("probes");
            }
            Stage::Surroundings => {
                self.bar.set_position(ROUND * self.before_surroundings + share);
                self.bar.set_message("reflection probes");
            }
            Stage::Finish => self.bar.set_message("taking out noise"),
            Stage::Direct => {
                self.bar.set_position(share);
                self.bar.set_message("light from where it is made");
            }
            Stage::Bounce(number) => {
                self.bar.set_position(ROUND * u64::from(number) + share);
                self.bar.set_message(format!("bounce {number} of {}", self.bounces));
            }
        }
        !STOP.load(Ordering::Relaxed)
    }
}
