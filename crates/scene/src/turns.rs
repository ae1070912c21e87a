//! Long work in slices, between which others have the thread: a browser's page has only one.

use std::pin::{Pin, pin};
use std::task::{Context, Poll, Waker};

/// What is awaited while others have the thread.
pub type Turn = Pin<Box<dyn Future<Output = ()>>>;

/// Says whether others are to have the thread now. It is asked between parts of work of some milliseconds each.
pub type Turns<'t> = dyn FnMut() -> Option<Turn> + 't;

/// Lets others have the thread if `turns` says so.
pub async fn give_turn(turns: &mut Turns<'_>) {
    if let Some(turn) = turns() {
        turn.await;
    }
}

/// What `work` comes to where nobody else waits for the thread.
pub(crate) fn at_once<T>(work: impl Future<Output = T>) -> T {
    let mut work = pin!(work);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(result) = work.as_mut().poll(&mut context) {
            return result;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{load_bytes, load_bytes_in_turns};
    use std::cell::Cell;
    use std::future::poll_fn;
    use std::rc::Rc;

    /// Three meshes of two triangles each.
    const MODEL: &[u8] = br#"{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [{ "mesh": 0 }, { "mesh": 1 }, { "mesh": 2 }],
        "meshes": [
            { "primitives": [{ "attributes": { "POSITION": 0 } }, { "attributes": { "POSITION": 0 } }] },
            { "primitives": [{ "attributes": { "POSITION": 0 } }, { "attributes": { "POSITION": 0 } }] },
            { "primitives": [{ "attributes": { "POSITION": 0 } }, { "attributes": { "POSITION": 0 } }] }
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }
        ],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36,
            "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }] }"#;

    #[test]
    fn a_model_that_is_read_in_turns_is_the_same() {
        let mut refuse = |_: &str| Err(String::from("there is no other file"));
        let whole = load_bytes(MODEL, &mut refuse, "m.gltf").unwrap();
        let taken = Rc::new(Cell::new(0));
        let mut turns = || {
            let (taken, mut has_waited) = (taken.clone(), false);
            Some(Box::pin(poll_fn(move |_| {
                taken.set(taken.get() + 1);
                // It is asked again after others had the thread.
                if std::mem::replace(&mut has_waited, true) { Poll::Ready(()) } else { Poll::Pending }
            })) as Turn)
        };
        let in_turns = at_once(load_bytes_in_turns(MODEL, &mut refuse, "m.gltf", &mut turns)).unwrap();
        assert_eq!(taken.get(), 12, "a turn after each primitive, which was waited for");
        assert_eq!(whole.scene.meshes, in_turns.scene.meshes);
        assert_eq!((whole.scene.meshes.len(), whole.warnings), (3, in_turns.warnings));
    }
}
