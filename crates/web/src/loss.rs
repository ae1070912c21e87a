//! The loss of a context or a device: the call that is under way ends, and who listens is told.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::future::poll_fn;
use std::pin::pin;
use std::rc::{Rc, Weak};
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Poll, Waker};
use wasm_bindgen::prelude::*;

/// The number of the next device of WebGPU.
static NEXT: AtomicU64 = AtomicU64::new(0);

thread_local! {
    /// The viewers of devices that are watched, by the device's number: what a device calls is `Send`, and what belongs
    /// to JavaScript is not.
    static WATCHED: RefCell<BTreeMap<u64, Vec<Weak<State>>>> = const { RefCell::new(BTreeMap::new()) };
}

/// Begins to watch a device of WebGPU, and gives its number.
pub(crate) fn watch_device(device: &wgpu::Device) -> u64 {
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    WATCHED.with_borrow_mut(|watched| watched.insert(number, Vec::new()));
    device.set_device_lost_callback(move |_, _| {
        let viewers = WATCHED.with_borrow_mut(|watched| watched.remove(&number));
        for viewer in viewers.into_iter().flatten().filter_map(|viewer| viewer.upgrade()) {
            viewer.happen();
        }
    });
    number
}

/// Whether the device of a number was lost.
pub(crate) fn is_lost(number: u64) -> bool {
    WATCHED.with_borrow(|watched| !watched.contains_key(&number))
}

struct State {
    is_lost: Cell<bool>,
    /// Wakes the call that is under way.
    waker: RefCell<Option<Waker>>,
    listener: RefCell<Option<js_sys::Function>>,
    /// The canvas's context, if it is one of WebGL.
    webgl: Option<web_sys::WebGl2RenderingContext>,
}

impl State {
    fn happen(&self) {
        if self.is_lost.replace(true) {
            return;
        }
        if let Some(waker) = self.waker.take() {
            waker.wake();
        }
        self.tell();
    }

    /// Calls the listener, once.
    fn tell(&self) {
        if let Some(listener) = self.listener.take() {
            // What a listener throws is not for whoever lost the device.
            let _ = listener.call0(&JsValue::UNDEFINED);
        }
    }

    fn context_is_lost(&self) -> bool {
        self.webgl.as_ref().is_some_and(|webgl| webgl.is_context_lost())
    }
}

/// Says that the context or the device of a viewer was lost. It can be used while a call of the viewer is under way.
#[wasm_bindgen]
#[derive(Clone)]
pub struct Loss(Rc<State>);

#[wasm_bindgen]
impl Loss {
    /// Ends the call that is under way with an error, and refuses later ones. A WebGL context tells the page of its
    /// loss, and the page this; a device of WebGPU does it by itself.
    pub fn happen(&self) {
        self.0.happen();
    }

    /// Calls `listener` once the device is lost; at once if it is lost already.
    pub fn listen(&self, listener: js_sys::Function) {
        self.0.listener.replace(Some(listener));
        if self.0.is_lost.get() {
            self.0.tell();
        }
    }
}

impl Loss {
    /// Of the device of WebGPU with a number, or of the WebGL context of `canvas`.
    pub(crate) fn watch(number: Option<u64>, canvas: &web_sys::HtmlCanvasElement) -> Self {
        let context = if number.is_none() { canvas.get_context("webgl2").ok().flatten() } else { None };
        let webgl = context.and_then(|context| context.dyn_into::<web_sys::WebGl2RenderingContext>().ok());
        let state = Rc::new(State {
            is_lost: Cell::new(false),
            waker: RefCell::new(None),
            listener: RefCell::new(None),
            webgl,
        });
        if let Some(number) = number {
            let is_there = WATCHED.with_borrow_mut(|watched| {
                let viewers = watched.get_mut(&number)?;
                viewers.retain(|viewer| viewer.strong_count() > 0);
                viewers.push(Rc::downgrade(&state));
                Some(())
            });
            if is_there.is_none() {
                state.happen();
            }
        }
        Self(state)
    }

    /// Whether it is a context of WebGL that is lost: nothing may be asked of its objects any more.
    pub(crate) fn is_of_context(&self) -> bool {
        self.0.context_is_lost()
    }

    /// What `action` comes to, unless the device is lost before: then it is dropped where it is.
    ///
    /// # Errors
    /// Those of `action`, or the device was lost.
    pub(crate) async fn or<T>(&self, action: impl Future<Output = Result<T, JsError>>) -> Result<T, JsError> {
        let mut action = pin!(action);
        let state = &self.0;
        poll_fn(|context| {
            // WebGL contexts tell of their loss only some time after it.
            if state.is_lost.get() || state.context_is_lost() {
                return Poll::Ready(Err(JsError::new("the device was lost")));
            }
            state.waker.replace(Some(context.waker().clone()));
            action.as_mut().poll(context)
        })
        .await
    }
}
