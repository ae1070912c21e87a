//! Long work in slices, between which others have the thread: a browser's page has only one.

use std::ops::Range;
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

/// Elements of a list that are worked on between two turns: a millisecond or two.
const SLICE_ELEMENTS: usize = 1 << 15;

/// Hands `work` the elements `0..count` range by range, in their order; between two ranges `turns` is asked.
pub async fn in_slices(count: usize, turns: &mut Turns<'_>, mut work: impl FnMut(Range<usize>)) {
    let mut start = 0;
    while start < count {
        let end = count.min(start + SLICE_ELEMENTS);
        work(start..end);
        start = end;
        if start < count {
            give_turn(turns).await;
        }
    }
}

/// What `work` comes to where nobody else waits for the thread.
pub fn at_once<T>(work: impl Future<Output = T>) -> T {
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
    fn slices_are_all_of_a_list_with_turns_between_them() {
        for (count, expected) in [(0, 0), (1, 0), (SLICE_ELEMENTS, 0), (SLICE_ELEMENTS + 1, 1), (3 * SLICE_ELEMENTS, 2)]
        {
            let (mut asked, mut seen) = (0, 0);
            let mut turns = || {
                asked += 1;
                None
            };
            at_once(in_slices(count, &mut turns, |range| {
                assert_eq!(range.start, seen);
                seen = range.end;
            }));
            assert_eq!((seen, asked), (count, expected));
        }
    }

    /// A strip of so many vertices with UVs, which is given normals and tangents: one primitive, and its buffer.
    fn strip(count: usize) -> (String, Vec<u8>) {
        let place = |i: usize| [(i / 2) as f32, (i % 2) as f32, (i as f32 * 0.7).sin()];
        let uv = |i: usize| [(i / 2) as f32, (i % 2) as f32];
        let floats = (0..count).flat_map(place).chain((0..count).flat_map(uv));
        let bytes: Vec<u8> = floats.flat_map(f32::to_le_bytes).collect();
        let (of_places, of_uvs) = (12 * count, 8 * count);
        let json = format!(
            r#"{{ "asset": {{ "version": "2.0" }},
            "scene": 0, "scenes": [{{ "nodes": [0] }}], "nodes": [{{ "mesh": 0 }}],
            "meshes": [{{ "primitives": [
                {{ "attributes": {{ "POSITION": 0, "TEXCOORD_0": 1 }}, "mode": 5, "material": 0 }}
            ] }}],
            "materials": [{{ "normalTexture": {{ "index": 0 }} }}], "textures": [{{ "source": 0 }}],
            "images": [{{ "uri": "late.png" }}],
            "accessors": [
                {{ "bufferView": 0, "componentType": 5126, "count": {count}, "type": "VEC3",
                    "min": [0, 0, -1], "max": [{count}, 1, 1] }},
                {{ "bufferView": 1, "componentType": 5126, "count": {count}, "type": "VEC2" }}
            ],
            "bufferViews": [
                {{ "buffer": 0, "byteLength": {of_places} }},
                {{ "buffer": 0, "byteOffset": {of_places}, "byteLength": {of_uvs} }}
            ],
            "buffers": [{{ "byteLength": {}, "uri": "all.bin" }}] }}"#,
            bytes.len()
        );
        (json, bytes)
    }

    #[test]
    fn a_large_primitive_is_read_in_slices_and_is_the_same() {
        let count = 2 * SLICE_ELEMENTS;
        let (json, bytes) = strip(count);
        let mut resolve = |name: &str| match name {
            "all.bin" => Ok(bytes.clone()),
            _ => Err(crate::ON_ITS_WAY.to_owned()),
        };
        let whole = load_bytes(json.as_bytes(), &mut resolve, "m.gltf").unwrap().scene;
        let mut asked = 0;
        let mut turns = || {
            asked += 1;
            None
        };
        let sliced = at_once(load_bytes_in_turns(json.as_bytes(), &mut resolve, "m.gltf", &mut turns)).unwrap().scene;
        assert!(whole.meshes == sliced.meshes);
        let primitive = &sliced.meshes[0].primitives[0];
        assert_eq!(primitive.indices.len(), 3 * (count - 2));
        let vertices = primitive.positions.len();
        assert_eq!((primitive.normals.len(), primitive.tangents.len()), (vertices, vertices));
        // Two attributes, and six slices of corners that are given normals.
        assert!(asked > 10, "{asked} turns");
    }

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
