//! Images that come after their model.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use crate::common::{Model, push};
use manypass_scene::{Image, ImageSource, LateImages, ON_ITS_WAY, Scene, load_bytes};
use serde_json::json;

/// A picture of one texel.
const PNG: &[u8] = &[
    137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 1, 0, 0, 0, 1, 8, 0, 0, 0, 0, 58, 126, 155,
    85, 0, 0, 0, 10, 73, 68, 65, 84, 120, 156, 99, 104, 0, 0, 0, 130, 0, 129, 119, 205, 114, 182, 0, 0, 0, 0, 73, 69,
    78, 68, 174, 66, 96, 130,
];

/// A triangle with two textures, of which `late` come later and the others are not there.
fn load(late: &str) -> (Scene, Vec<String>) {
    let mut model = Model::triangle();
    for uri in ["wood%20floor.png", "bumps.png"] {
        push(&mut model.json["images"], json!({ "uri": uri, "name": "picture" }));
    }
    push(&mut model.json["textures"], json!({ "source": 0 }));
    push(&mut model.json["textures"], json!({ "source": 1 }));
    let material =
        json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } }, "normalTexture": { "index": 1 } });
    push(&mut model.json["materials"], material);
    model.json["buffers"][0]["byteLength"] = json!(model.buffer.len());
    let buffer = model.buffer.clone();
    let mut resolve = |uri: &str| match uri {
        "buffer.bin" => Ok(buffer.clone()),
        uri if uri == late => Err(ON_ITS_WAY.to_owned()),
        uri => Err(format!("there is no {uri}")),
    };
    let loaded = load_bytes(model.json.to_string().as_bytes(), &mut resolve, "model.gltf").unwrap();
    (loaded.scene, loaded.warnings)
}

#[test]
fn an_image_on_its_way_is_there_once_it_is_given() {
    let (mut scene, warnings) = load("wood floor.png");
    assert!(warnings.len() == 1 && warnings[0].contains("bumps.png"), "{warnings:?}");
    assert!(scene.materials[0].base_color_texture.is_some() && scene.materials[0].normal_texture.is_none());
    assert_eq!(scene.missing_images().iter().map(|uri| &**uri).collect::<Vec<_>>(), ["wood floor.png"]);
    assert!(scene.images[0].decode().unwrap_err().message.contains("still on its way"));
    let error = scene.give_image("wood floor.png", b"no picture".to_vec()).unwrap_err();
    assert!(error.to_string().contains("wood floor.png"), "{error}");
    assert_eq!(scene.missing_images().len(), 1);
    assert_eq!(scene.give_image("other.png", PNG.to_vec()), Ok(0));
    assert_eq!(scene.give_image("wood floor.png", PNG.to_vec()), Ok(1));
    assert_eq!(scene.images[0].dimensions(), Ok((1, 1)));
    assert!(scene.missing_images().is_empty());
}

#[test]
fn images_are_taken_out_and_put_back() {
    let (mut scene, _) = load("wood floor.png");
    scene.give_image("wood floor.png", PNG.to_vec()).unwrap();
    let withheld = scene.withhold_images();
    assert_eq!(withheld.iter().map(|(index, _)| *index).collect::<Vec<_>>(), [0]);
    assert!(matches!(scene.images[0].source, ImageSource::Loading(_)) && scene.missing_images().len() == 1);
    for (index, source) in withheld {
        scene.images[index].source = source;
    }
    assert_eq!(scene.images[0].dimensions(), Ok((1, 1)));
}

#[test]
fn what_does_not_come_is_not_waited_for() {
    let (mut scene, _) = load("wood floor.png");
    let mut late = LateImages::withheld(&mut scene);
    assert_eq!(late.missing().collect::<Vec<_>>(), ["wood floor.png"]);
    assert!(!late.is_complete());
    assert!(late.give(&mut scene, "wood floor.png", b"no picture".to_vec()).is_err() && !late.is_complete());
    assert_eq!((late.give_up("other.png"), late.give_up("wood floor.png"), late.give_up("wood floor.png")), (0, 1, 0));
    assert!(late.is_complete());
    // It is drawn as without it.
    assert!(matches!(scene.images[0].source, ImageSource::Loading(_)));
}

#[test]
fn withheld_images_are_shown_one_by_one() {
    let (mut scene, _) = load("wood floor.png");
    scene.give_image("wood floor.png", PNG.to_vec()).unwrap();
    let mut late = LateImages::withheld(&mut scene);
    assert!(late.missing().next().is_none() && !late.is_complete() && scene.images[0].dimensions().is_err());
    assert!(late.show_next(&mut scene) && late.is_complete() && !late.show_next(&mut scene));
    assert_eq!(scene.images[0].dimensions(), Ok((1, 1)));
}

/// Looking at all images for each that comes would be a hundred million headers here: minutes.
#[test]
fn many_images_come_in_linear_time() {
    let started = std::time::Instant::now();
    let mut scene = Scene::default();
    for index in 0..10_000 {
        let source = ImageSource::Loading(format!("{index}.png").into());
        scene.images.push(Image { name: String::new(), source });
    }
    let mut late = LateImages::of(&scene);
    for index in 0..10_000 {
        assert_eq!(late.give(&mut scene, &format!("{index}.png"), PNG.to_vec()), Ok(1));
    }
    assert!(late.is_complete() && scene.missing_images().is_empty());
    assert!(started.elapsed().as_secs() < 10, "{:?}", started.elapsed());
}
