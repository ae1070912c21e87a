use super::*;

fn gradient() -> Picture {
    let pixels = (0..64 * 48)
        .map(|i| {
            let (x, y) = (i % 64, i / 64);
            [(x * 4) as u8, (y * 4) as u8, ((x * x + 3 * y) % 97) as u8, 255]
        })
        .collect();
    Picture { width: 64, height: 48, pixels }
}

#[test]
fn a_picture_is_the_same_as_itself_and_as_none_of_its_mutations() {
    assert_same(&gradient(), &gradient(), Tolerance::default());
    assert_rejects_mutations(&gradient(), Tolerance::default());
}

#[test]
#[should_panic(expected = "flipped in x, flipped in y")]
fn a_plain_picture_cannot_prove_anything() {
    let plain = Picture { width: 8, height: 8, pixels: vec![[90, 120, 30, 255]; 64] };
    assert_rejects_mutations(&plain, Tolerance::default());
}

#[test]
#[should_panic(expected = "the worst pixel, (3, 2), is off by 200")]
fn the_message_names_the_worst_pixel() {
    let mut spoilt = gradient();
    let pixel = &mut spoilt.pixels[2 * 64 + 3];
    pixel[0] += 200;
    spoilt.pixels[0][1] += 9;
    spoilt.pixels[1][1] += 9;
    spoilt.pixels[5][1] += 9;
    assert_same(&gradient(), &spoilt, Tolerance::default());
}

#[test]
fn pixels_that_hang_together_are_counted_by_edges_and_corners() {
    let rows = ["##...", "..#..", ".....", "#.###", "#.#.#", "..###"];
    let marked = rows.iter().flat_map(|row| row.bytes().map(|mark| mark == b'#')).collect();
    assert_eq!(largest_area(marked, 5), 8);
    assert_eq!(largest_area(vec![false; 6], 3), 0);
    assert_eq!(largest_area(vec![true; 6], 3), 6);
}

/// `gradient` with its blue off by 120 levels where `is_wrong` says so.
fn spoilt(is_wrong: impl Fn(usize, usize) -> bool) -> Picture {
    let mut picture = gradient();
    for (i, pixel) in picture.pixels.iter_mut().enumerate() {
        if is_wrong(i % 64, i / 64) {
            pixel[2] += 120;
        }
    }
    picture
}

#[test]
fn wrong_pixels_may_be_scattered_but_not_lie_together() {
    // 3,072 pixels, of which a share of 0.97 lets 92 be wrong.
    let tolerance = Tolerance { share: 0.97, share_between: 0.97, mean: 1.0, ..Tolerance::default() };
    let scattered = spoilt(|x, y| x % 7 == 3 && y % 6 == 2);
    let block = spoilt(|x, y| (20..29).contains(&x) && (30..39).contains(&y));
    let diagonal = spoilt(|x, y| x == y && x < 9);
    for (picture, count, is_accepted) in [(scattered, 72, true), (block, 81, false), (diagonal, 9, false)] {
        let found = difference(&gradient(), &picture, tolerance.within);
        assert_eq!(((1.0 - found.share) * 3072.0).round() as u32, count);
        assert!(found.share >= tolerance.share && found.mean <= tolerance.mean, "{found}");
        assert_eq!(found.is_within(tolerance), is_accepted, "{found}");
        // They are nothing of what is beside them, so that edges are no excuse.
        assert_eq!(found.is_within(Tolerance { area_px: usize::MAX, ..tolerance }), is_accepted, "{found}");
    }
}

#[test]
fn an_edge_that_moved_is_excused_where_only_edges_may_move() {
    let edge = |at: usize, height: usize| {
        let pixels =
            (0..64 * 48).map(|i| if i % 64 < at && i / 64 < height { [200, 90, 30, 255] } else { [10; 4] }).collect();
        Picture { width: 64, height: 48, pixels }
    };
    let found = difference(&edge(30, 24), &edge(31, 24), 2);
    assert_eq!((found.area_px, found.area_between_px), (24, 0));
    assert!(found.is_within(Tolerance { mean: 3.0, ..Tolerance::RASTERIZERS }), "{found}");
    assert!(!found.is_within(Tolerance { mean: 3.0, share: 0.98, ..Tolerance::default() }), "{found}");
}

#[test]
fn linear_errors_are_relative_to_the_reference_or_the_floor() {
    let result =
        linear_difference(&[[1.0, 2.0, 4.0], [0.0; 3], [1.0; 3]], &[[1.0, 2.0, 4.2], [0.001; 3], [1.0; 3]], 0.1);
    assert!((result.percentile(1.0) - 0.05).abs() < 1e-6);
    assert!((result.percentile(0.5) - 0.01).abs() < 1e-6);
    assert_eq!(result.percentile(0.3), 0.0);
    assert_eq!(result.worst, 0);
}

#[test]
#[should_panic(expected = "pixel 1")]
fn nan_never_agrees() {
    assert_within_one_percent(&[[1.0; 3]; 2], &[[1.0; 3], [f32::NAN; 3]], 0.01, 1.0);
}
