//! Simulations in slices, between which others have the thread: the states are those of stepping at once, and a simulation
//! that is stopped on its way loses no step.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::renderer;
use manypass::{Renderer, SimulationProgress};
use manypass_scene::Scene;
use manypass_scene::simulation::Simulation;
use manypass_scene::turns::{Turn, at_once};
use std::cell::Cell;
use std::future::poll_fn;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

/// Waves under rain, which make 240 steps a second, at a time.
fn rain_at(time_secs: f32) -> Scene {
    let pond = Simulation { cells: Some((64, 64)), ..Simulation::built_in("pond", "ripples") };
    let simulations = vec![pond.with("drops_per_s", "40").with("drop_depth_m", "0.02")];
    Scene { simulations, time_secs, ..Scene::default() }
}

fn water(renderer: &Renderer) -> Vec<[f32; 4]> {
    renderer.read_simulation(0, "water").unwrap().unwrap()
}

fn steps(renderer: &Renderer) -> u64 {
    renderer.simulation_reports().unwrap()[0].steps
}

/// What stepping at once leads to.
fn expected_at(time_secs: f32) -> Vec<[f32; 4]> {
    let mut renderer = renderer();
    renderer.simulate(&rain_at(time_secs), &mut |_| true).unwrap();
    water(&renderer)
}

/// Gives others the thread whenever it is asked, and counts that; they give it back when they are polled again.
fn yielding(asked: &Cell<u32>) -> impl FnMut() -> Option<Turn> {
    || {
        asked.set(asked.get() + 1);
        let mut has_waited = false;
        let wait =
            poll_fn(move |_| if std::mem::replace(&mut has_waited, true) { Poll::Ready(()) } else { Poll::Pending });
        Some(Box::pin(wait) as Turn)
    }
}

#[test]
fn steps_in_slices_lead_to_the_same_states() {
    let (mut renderer, asked) = (renderer(), Cell::new(0));
    at_once(renderer.simulate_in_turns(&rain_at(1.0), &mut |_| true, &mut yielding(&asked))).unwrap();
    assert_eq!(asked.get(), 240, "after each step");
    let expected = expected_at(1.0);
    assert!(water(&renderer) == expected && expected.iter().any(|cell| cell[0].abs() > 1e-4));
}

#[test]
fn a_simulation_that_is_stopped_or_dropped_loses_no_step() {
    let (scene, mut renderer, asked) = (rain_at(1.0), renderer(), Cell::new(0));
    let error = renderer.simulate(&scene, &mut |progress| progress.done < 10).unwrap_err().to_string();
    assert!(error.contains("it was interrupted"), "{error}");
    assert_eq!(steps(&renderer), 10);
    {
        let (mut progress, mut turns) = (|_: SimulationProgress<'_>| true, yielding(&asked));
        let mut dropped = pin!(renderer.simulate_in_turns(&scene, &mut progress, &mut turns));
        for _ in 0..5 {
            assert!(dropped.as_mut().poll(&mut Context::from_waker(Waker::noop())).is_pending());
        }
    }
    assert_eq!(steps(&renderer), 15);
    let mut totals = Vec::new();
    let mut told = |progress: SimulationProgress<'_>| {
        totals.push(progress.total);
        true
    };
    renderer.simulate(&scene, &mut told).unwrap();
    assert!(water(&renderer) == expected_at(1.0), "it goes on otherwise");
    // An earlier time than what the states hold is replayed from the beginning.
    renderer.simulate(&rain_at(0.25), &mut told).unwrap();
    assert!(water(&renderer) == expected_at(0.25), "it begins otherwise");
    totals.dedup();
    assert_eq!(totals, [225, 60]);
}
