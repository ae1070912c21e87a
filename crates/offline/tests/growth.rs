//! What it takes to read a file, and to say what is in it, grows as its things do.

use manypass_offline::{camera, manifest};
use manypass_scene::{Framing, Scene, formats, stage};
use manypass_testkit::growth::GrowthAxis;
use std::hint::black_box;
use std::sync::LazyLock;
use std::time::Instant;

const FEW: usize = 1000;
const TIMES: usize = 10;
/// Ten times as many things take ten times as long, or a little more where caches are full; were it the square, a
/// hundred times.
const RATIO_MAX: f64 = 40.0;

/// Seconds that this thread has had a processor, so that what else the machine does counts for nothing; where the
/// system does not say it, seconds of a clock.
fn processor_secs() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = text.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |nanoseconds| 1e-9 * nanoseconds)
}

/// What `info` looks at, and what a picture at another time does first.
fn look_at(scene: &mut Scene) {
    let framing = Framing::of_scene(scene);
    black_box((framing.bounds_world(), scene.has_moving_cameras(), scene.first_camera(1.0)));
    black_box((manifest::nodes(scene), manifest::materials(scene), manifest::levels(scene)));
    black_box((manifest::object_ids(scene), manifest::material_ids(scene)));
    black_box(camera::scene_cameras(scene, 64, 64));
    if !scene.animations.is_empty() {
        scene.pose(0, 0.5);
        scene.update_transforms();
    }
}

/// What it takes to read a file of `count` things and to look at it so many times, in seconds.
fn seconds(many: GrowthAxis, count: usize, times: usize) -> f64 {
    let (name, bytes) = (many.file_name(count), many.text(count).into_bytes());
    let nodes = if many == GrowthAxis::Items { GrowthAxis::Nodes.text(count).into_bytes() } else { Vec::new() };
    let mut resolve = |_: &str| Ok(nodes.clone());
    let start = processor_secs();
    for _ in 0..times {
        let mut scene = if many == GrowthAxis::Items {
            stage::load_bytes(&bytes, &mut resolve, &name).expect("a stage").scene
        } else {
            formats::load_bytes(&bytes, &mut resolve, &name).expect("a model").scene
        };
        look_at(&mut scene);
    }
    processor_secs() - start
}

#[test]
fn ten_times_as_many_things_take_ten_times_as_long() {
    let mut wrong = Vec::new();
    for many in GrowthAxis::ALL {
        // As often as there are fewer, because systems count what a thread had in ticks of some milliseconds.
        let few_secs = seconds(many, FEW, TIMES) / TIMES as f64;
        let ratio = seconds(many, TIMES * FEW, 1) / few_secs.max(1e-3);
        println!(
            "{}: {FEW} take {:.1} ms, {TIMES} times as many {ratio:.1} times as long",
            many.name(),
            1e3 * few_secs
        );
        if ratio > RATIO_MAX {
            wrong.push(format!("{}: {TIMES} times as many as {FEW} take {ratio:.0} times as long", many.name()));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
