//! Images in KTX2 containers and `KHR_texture_basisu`: containers written by hand, files of other programs beside the
//! same picture uncompressed, and broken ones.
#![allow(clippy::unwrap_used, reason = "A test that cannot go on should stop.")]

use manypass_scene::{BlockFormat, Image, ImageSource, load_bytes};
use manypass_testkit::data_uri;
use manypass_testkit::ktx2::{picture, solid_block};
use manypass_testkit::needs::assets;
use proptest::prelude::*;
use serde_json::json;

const UNDEFINED: u32 = 0;
const R8G8B8_UNORM: u32 = 23;

/// A container with one level.
fn container(format: u32, width: u32, height: u32, supercompression: u32, level: &[u8]) -> Vec<u8> {
    picture(format, [width, height], supercompression, &[level])
}

fn image(bytes: &[u8]) -> Image {
    Image { name: "test".into(), source: ImageSource::Encoded(bytes.into()) }
}

#[test]
fn blocks_of_one_colour_and_plain_bytes_come_back() {
    let colors = [[200, 30, 60, 255], [1, 2, 3, 128]];
    let data = container(UNDEFINED, 8, 4, 0, colors.map(solid_block).as_flattened());
    let pixels = image(&data).decode().unwrap();
    assert_eq!((pixels.width, pixels.height), (8, 4));
    for (i, texel) in pixels.data.as_chunks().0.iter().enumerate() {
        assert_eq!(*texel, colors[i % 8 / 4]);
    }
    // A block that the picture fills in part.
    let data = container(UNDEFINED, 3, 2, 0, &solid_block(colors[0]));
    assert_eq!(image(&data).decode().unwrap().data, colors[0].repeat(6));
    let data = container(R8G8B8_UNORM, 2, 1, 0, &[9, 8, 7, 6, 5, 4]);
    assert_eq!(image(&data).decode().unwrap().data, [9, 8, 7, 255, 6, 5, 4, 255]);
}

#[test]
fn a_texture_takes_its_basis_image_or_the_plain_one_if_that_is_broken() {
    let png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\0\0\0\x01\x08\0\0\0\0\x3a\x7e\x9b\x55\0\0\0\nIDATx\x9cch\0\0\0\x82\0\x81\x77\xcd\x72\xb6\0\0\0\0IEND\xaeB`\x82";
    let basis = container(UNDEFINED, 4, 4, 0, &solid_block([1, 2, 3, 4]));
    let cube = {
        let mut cube = basis.clone();
        cube[36] = 6;
        cube
    };
    for (ktx2, expected, warnings) in [(&basis, 1, 0), (&cube, 0, 1)] {
        let file = json!({
            "asset": { "version": "2.0" }, "extensionsRequired": ["KHR_texture_basisu"],
            "images": [{ "uri": data_uri("image/png", png) }, { "uri": data_uri("image/ktx2", ktx2), "mimeType": "image/ktx2" }],
            "textures": [{ "source": 0, "extensions": { "KHR_texture_basisu": { "source": 1 } } }],
        });
        let loaded = load_bytes(file.to_string().as_bytes(), &mut |_| Err(String::new()), "test.gltf").unwrap();
        assert_eq!(loaded.scene.textures[0].image, expected);
        // One more says that nothing is drawn.
        assert_eq!(loaded.warnings.len(), 1 + warnings, "{:?}", loaded.warnings);
        assert!(warnings == 0 || loaded.warnings[0].contains("expected a KTX2 container of one flat picture"));
    }
}

#[test]
fn what_is_wrong_is_named_and_takes_no_memory() {
    let block = solid_block([5; 4]);
    let whole = || container(UNDEFINED, 4, 4, 0, &block);
    let changed = |at: usize, bytes: &[u8]| {
        let mut data = whole();
        data[at..at + bytes.len()].copy_from_slice(bytes);
        data
    };
    for (data, part) in [
        (whole()[..40].to_vec(), "the KTX2 container ends early"),
        (whole()[..150].to_vec(), "lies outside the file"),
        (changed(80, &[255; 16]), "lies outside the file"),
        (changed(96, &[255; 7]), "claims to hold more than its texels"),
        (changed(28, &[9]), "of one flat picture"),
        (changed(20, &70_000_u32.to_le_bytes()), "it has 70000 by 4 texels"),
        (changed(20, &4096_u32.to_le_bytes()), "Basis Universal data are broken"),
        (
            changed(12, &[97]),
            "its format R16G16B16A16_SFLOAT (97) cannot be read; textures of materials have eight bits",
        ),
        (changed(12, &[109]), "its format R32G32B32A32_SFLOAT (109) cannot be read"),
        (changed(12, &[200]), "its format 200 (a number of Vulkan) cannot be read"),
        (container(R8G8B8_UNORM, 2, 2, 0, &[0; 11]), "expected 12 bytes of texels in level 0, found 11"),
        (container(R8G8B8_UNORM, 2, 2, 2, &[0; 12]), "broken Zstandard"),
        (container(R8G8B8_UNORM, 2, 2, 3, &[0; 12]), "expected no supercompression or Zstandard"),
    ] {
        let error = image(&data).decode().unwrap_err().to_string();
        assert!(error.starts_with("image \"test\": ") && error.contains(part), "{error}");
    }
}

#[test]
fn pictures_of_an_encoder_show_what_they_say() {
    let Some(folder) = assets("threejs/ktx2") else { return };
    let read = |name: &str| image(&std::fs::read(folder.join(name)).unwrap()).decode().unwrap();
    // White letters name the format, on a ground of one colour each.
    for (name, ground) in
        [("2d_rgba8.ktx2", [220, 59, 0, 255]), ("2d_uastc.ktx2", [0, 220, 0, 255]), ("2d_etc1s.ktx2", [220, 0, 0, 255])]
    {
        let pixels = read(name);
        let texels = pixels.data.as_chunks::<4>().0;
        let share = |color: [u8; 4]| {
            let is_near =
                |texel: &&[u8; 4]| texel.iter().zip(color).all(|(found, expected)| found.abs_diff(expected) < 8);
            texels.iter().filter(is_near).count() as f64 / texels.len() as f64
        };
        assert_eq!((pixels.width, pixels.height, texels.len()), (512, 512, 512 * 512), "{name}");
        assert!(share(ground) > 0.9 && share([255; 4]) > 0.01, "{name}: {} {}", share(ground), share([255; 4]));
        assert!(share(ground) + share([255; 4]) > 0.95, "{name}: {}", share(ground) + share([255; 4]));
    }
    // A sheet of paper with panes of red, green and blue; letters on nothing.
    let paper = read("sample_uastc_zstd.ktx2");
    for ((x, y), lit) in [((500, 520), 0b111), ((200, 900), 0b001), ((340, 1000), 0b010), ((700, 1100), 0b100)] {
        let [red, green, blue, _] = paper.data.as_chunks::<4>().0[y * paper.width as usize + x];
        let found = [red, green, blue].iter().rev().fold(0, |bits, channel| 2 * bits + i32::from(*channel > 200));
        assert_eq!(found, lit, "at {x}, {y}: {red} {green} {blue}");
    }
    let letters = read("sample_etc1s.ktx2");
    assert_eq!((letters.width, letters.height, &letters.data[..4]), (1024, 1024, &[0; 4][..]));
}

#[test]
fn changed_files_end_without_a_panic() {
    let mut files = vec![container(UNDEFINED, 8, 4, 0, &[solid_block([1; 4]), solid_block([9; 4])].concat())];
    if let Some(folder) = assets("threejs/ktx2") {
        files.extend(["2d_etc1s.ktx2", "2d_uastc.ktx2"].map(|name| std::fs::read(folder.join(name)).unwrap()));
    }
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(60)
    });
    let any_changes = prop::collection::vec((any::<prop::sample::Index>(), any::<bool>(), any::<u8>()), 1..5);
    let changed = (any::<prop::sample::Index>(), any_changes, any::<prop::sample::Index>());
    let result = runner.run(&changed, |(which, changes, cut)| {
        let mut data = files[which.index(files.len())].clone();
        for (at, is_header, byte) in changes {
            let at = at.index(if is_header { data.len().min(200) } else { data.len() });
            data[at] = byte;
        }
        let _ = image(&data).decode();
        data.truncate(cut.index(data.len()));
        let _ = image(&data).decode();
        Ok(())
    });
    result.unwrap();
}

#[test]
fn pictures_with_all_levels_stay_compressed() {
    let colors = [[200, 30, 60, 255], [1, 2, 3, 128], [7, 7, 7, 7], [9, 200, 90, 255]].map(solid_block);
    let levels: [&[u8]; 4] = [&[colors[0]; 4].concat(), &colors[1], &colors[2], &colors[3]];
    let whole = picture(UNDEFINED, [8, 8], 0, &levels);
    for format in [BlockFormat::Bc7, BlockFormat::Etc2, BlockFormat::Astc] {
        let blocks = image(&whole).transcode(format).unwrap();
        let sizes: Vec<_> = blocks.iter().map(|level| (level.width, level.height, level.data.len())).collect();
        assert_eq!(sizes, [(8, 8, 64), (4, 4, 16), (2, 2, 16), (1, 1, 16)], "{format:?}");
    }
    let none = |bytes: &[u8]| assert!(image(bytes).transcode(BlockFormat::Bc7).is_none());
    // Without all levels, of no whole blocks, not of Basis, broken.
    none(&picture(UNDEFINED, [8, 8], 0, &levels[..3]));
    none(&picture(UNDEFINED, [6, 6], 0, &levels[..3]));
    none(&picture(R8G8B8_UNORM, [4, 4], 0, &[&[0; 48], &[0; 12], &[0; 3]]));
    (0..whole.len()).for_each(|length| none(&whole[..length]));
}
