//! The time that is shown, and how simulations get there: in slices, between which the page has the thread.

use super::Viewer;
use manypass::gpu::readback::yield_now;
use manypass::scene::turns::Turn;
use manypass::{Gpu, SimulationProgress};
use std::cell::{Cell, RefCell};
use std::rc::Rc;
use wasm_bindgen::prelude::*;
use web_time::{Duration, Instant};

/// After so long the page has the thread: a frame at 60 a second.
const SLICE: Duration = Duration::from_millis(16);

/// Of a slice that takes longer until the device has done it, the next one has half the steps: pages share the device.
const LONG_SLICE: Duration = Duration::from_millis(50);

/// Of a shorter one the next one has twice the steps. The page's turn takes some 5 to 10 ms of it.
const SHORT_SLICE: Duration = Duration::from_millis(25);

/// Steps of the first slice, and of any.
const FIRST_STEPS: u32 = 8;
const STEPS_MIN: u32 = 4;
const STEPS_MAX: u32 = 512;

struct State {
    /// The time in seconds that no frame has taken yet.
    newest: Cell<Option<f32>>,
    /// The time that simulations are stepped to.
    aim: Cell<f32>,
    /// Whether a frame steps simulations.
    is_stepping: Cell<bool>,
    /// Steps of the next slice.
    slice_steps: Cell<u32>,
    listener: RefCell<Option<js_sys::Function>>,
}

/// The time that the next frame shows. It can be used while a call of the viewer is under way.
#[wasm_bindgen]
#[derive(Clone)]
pub struct ShownTime(Rc<State>);

#[wasm_bindgen]
impl ShownTime {
    /// Gives the frame that steps simulations another time to step to, in seconds. False if none does.
    pub fn redirect(&self, secs: f32) -> bool {
        let is_stepping = self.0.is_stepping.get();
        if is_stepping {
            self.give(secs);
        }
        is_stepping
    }

    /// Calls `listener` with a simulation's name, how many steps were made and how many there are: after each slice, and
    /// at the end of what took several.
    pub fn listen(&self, listener: js_sys::Function) {
        self.0.listener.replace(Some(listener));
    }
}

impl ShownTime {
    pub(super) fn new() -> Self {
        Self(Rc::new(State {
            newest: Cell::new(None),
            aim: Cell::new(0.0),
            is_stepping: Cell::new(false),
            slice_steps: Cell::new(FIRST_STEPS),
            listener: RefCell::new(None),
        }))
    }

    fn give(&self, secs: f32) {
        self.0.newest.set(Some(if secs.is_finite() { secs } else { 0.0 }));
    }

    /// Forgets a time that was for another scene.
    pub(super) fn forget(&self) {
        self.0.newest.set(None);
    }

    /// Forgets who listens.
    pub(super) fn forget_listener(&self) {
        self.0.listener.replace(None);
    }

    /// Whether there is a time before the one that a frame steps to, which is in vain then. A later time is the next
    /// frame's: where times come faster than steps, frames would never end.
    fn turns_back(&self) -> bool {
        self.0.newest.get().is_some_and(|secs| secs < self.0.aim.get())
    }

    /// The newest time, which is aimed at from now on.
    fn take(&self) -> Option<f32> {
        let newest = self.0.newest.take();
        self.0.aim.set(newest.unwrap_or(self.0.aim.get()));
        newest
    }

    fn tell(&self, progress: SimulationProgress<'_>) {
        // The listener may be another one afterwards.
        let listener = self.0.listener.borrow().clone();
        if let Some(listener) = listener {
            let name = JsValue::from(progress.name);
            let [done, total] = [progress.done, progress.total].map(|steps| JsValue::from(steps as f64));
            // What it throws is not for the frame.
            let _ = listener.call3(&JsValue::UNDEFINED, &name, &done, &total);
        }
    }
}

/// Says while it lasts that a frame steps simulations. The frame may be dropped on its way.
struct StepGuard(ShownTime);

impl StepGuard {
    fn begin(time: &ShownTime) -> Self {
        time.0.is_stepping.set(true);
        Self(time.clone())
    }
}

impl Drop for StepGuard {
    fn drop(&mut self) {
        self.0.0.is_stepping.set(false);
    }
}

/// The slices in which a frame steps simulations.
struct Slices {
    gpu: Gpu,
    time: ShownTime,
    /// When the present one began, and its steps so far.
    began: Cell<Instant>,
    steps: Cell<u32>,
    /// Whether the page had the thread.
    are_several: Cell<bool>,
    /// Whether a slice began that nobody was told of.
    is_news: Cell<bool>,
}

impl Slices {
    fn new(gpu: Gpu, time: ShownTime) -> Rc<Self> {
        Rc::new(Self {
            gpu,
            time,
            began: Cell::new(Instant::now()),
            steps: Cell::new(0),
            are_several: Cell::new(false),
            is_news: Cell::new(false),
        })
    }

    /// Tells how far a simulation is, and says whether to go on: until an earlier time comes.
    fn follow(&self, progress: SimulationProgress<'_>) -> bool {
        let has_ended = progress.total > 0 && progress.done == progress.total;
        if self.is_news.replace(false) || self.are_several.get() && has_ended {
            self.time.tell(progress);
        }
        !self.time.turns_back()
    }

    /// Asked after each step: whether the page is to have the thread.
    fn turns(self: &Rc<Self>) -> impl FnMut() -> Option<Turn> + use<> {
        let slices = self.clone();
        move || {
            let steps = slices.steps.get() + 1;
            slices.steps.set(steps);
            let is_over = steps >= slices.time.0.slice_steps.get() || slices.began.get().elapsed() >= SLICE;
            is_over.then(|| {
                let slices = slices.clone();
                let turn: Turn = Box::pin(async move { slices.give_turn().await });
                turn
            })
        }
    }

    /// Waits until the page had the thread and the device has done the slice, and begins the next one.
    async fn give_turn(&self) {
        self.are_several.set(true);
        yield_now().await;
        // A loss ends the whole call.
        let _ = self.gpu.done().await;
        let (took, steps) = (self.began.get().elapsed(), self.steps.replace(0));
        let next = &self.time.0.slice_steps;
        if took > LONG_SLICE {
            next.set((steps / 2).max(STEPS_MIN));
        } else if took < SHORT_SLICE && steps >= next.get() {
            next.set((2 * steps).min(STEPS_MAX));
        }
        self.is_news.set(true);
        self.began.set(Instant::now());
    }
}

#[wasm_bindgen]
impl Viewer {
    /// Shows the model as it is at a time in seconds from the next frame on: in its first animation, with waves and
    /// simulations after so many seconds. Simulations go on from the time before, and begin anew where that was later.
    /// `render` steps them in slices of some milliseconds, between which the page has the thread. An earlier
    /// time that comes meanwhile takes the place of the one before; a later one is the next frame's.
    ///
    /// # Errors
    /// When no model is loaded.
    #[wasm_bindgen(js_name = setTime)]
    pub fn set_time(&mut self, secs: f32) -> Result<(), JsError> {
        if self.scene.is_none() {
            return Err(JsError::new("no model is loaded"));
        }
        self.time.give(secs);
        // Without simulations there is nothing to wait for, and who frames the model finds it as it will be.
        if !self.scene.as_ref().is_some_and(manypass::scene::Scene::has_simulations) {
            self.pose_at_newest();
        }
        Ok(())
    }

    /// What gives a frame that is under way a newer time.
    #[wasm_bindgen(js_name = shownTime)]
    pub fn shown_time(&self) -> ShownTime {
        self.time.clone()
    }
}

impl Viewer {
    fn pose_at_newest(&mut self) {
        if let (Some(scene), Some(secs)) = (&mut self.scene, self.time.take()) {
            scene.pose(0, secs);
            scene.update_transforms();
        }
    }

    /// Poses the model at the newest time, and steps its simulations there. True if the page had the thread meanwhile.
    pub(super) async fn reach_time(&mut self) -> Result<bool, JsError> {
        let slices = Slices::new(self.renderer.gpu().clone(), self.time.clone());
        loop {
            self.pose_at_newest();
            let scene = self.scene.as_mut().ok_or_else(|| JsError::new("no model is loaded"))?;
            if !scene.has_simulations() {
                return Ok(slices.are_several.get());
            }
            let stepping = StepGuard::begin(&self.time);
            let mut follow = |progress: SimulationProgress<'_>| slices.follow(progress);
            let stepped = self.renderer.simulate_in_turns(scene, &mut follow, &mut slices.turns()).await;
            drop(stepping);
            if self.time.turns_back() {
                continue;
            }
            stepped?;
            return Ok(slices.are_several.get());
        }
    }
}
