//! Images above the largest size, which are halved until they fit.

use super::texels::MAX_IMAGE_SIZE_TEXELS;

/// How often an image is halved.
pub(super) fn times((width, height): (u32, u32)) -> u32 {
    (0..u32::BITS).find(|times| width.max(height) >> times <= MAX_IMAGE_SIZE_TEXELS).unwrap_or_default()
}

/// The size of an image that is halved so often.
pub(super) fn size((width, height): (u32, u32), times: u32) -> (u32, u32) {
    ((width >> times).max(1), (height >> times).max(1))
}

/// The texels of an image in the size in which it fits, each the mean of those that it stands for. A column or row that
/// is left over at the edge is dropped.
pub(super) fn until_it_fits<T>(data: Vec<T>, stored: (u32, u32), channels: usize) -> (Vec<T>, (u32, u32))
where
    T: Copy + Default + Into<u32> + TryFrom<u32>,
{
    let times = times(stored);
    if times == 0 {
        return (data, stored);
    }
    let (width, height) = size(stored, times);
    let (stored_width, stored_height) = (stored.0 as usize, stored.1 as usize);
    let step = 1usize << times;
    let mut halved = Vec::with_capacity(width as usize * height as usize * channels);
    for y in 0..height as usize {
        for x in 0..width as usize {
            let (across, down) = (step.min(stored_width), step.min(stored_height));
            for channel in 0..channels {
                let texels = (0..down).flat_map(|dy| (0..across).map(move |dx| (x * step + dx, y * step + dy)));
                let values = texels.filter_map(|(x, y)| data.get((y * stored_width + x) * channels + channel).copied());
                let sum: u64 = values.map(|value| u64::from(value.into())).sum();
                let mean = (sum + (across * down) as u64 / 2) / (across * down) as u64;
                halved.push(T::try_from(mean as u32).unwrap_or_default());
            }
        }
    }
    (halved, (width, height))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_large_is_halved_until_it_fits() {
        assert_eq!([(16384, 1), (16385, 2), (40_000, 7)].map(times), [0, 1, 2]);
        let stored: Vec<u8> =
            (0..2).flat_map(|y| (0..16_385).flat_map(move |x| [if x < 8192 { 10 } else { 20 }, y])).collect();
        let (halved, size) = until_it_fits(stored, (16_385, 2), 2);
        assert_eq!(
            (size, halved.len(), &halved[..2], &halved[2 * 8191..]),
            ((8192, 1), 2 * 8192, &[10, 1][..], &[20, 1][..])
        );
        let (heights, size) = until_it_fits(vec![60_000_u16; 33_000], (1, 33_000), 1);
        assert_eq!((size, heights.len(), heights[0]), ((1, 8250), 8250, 60_000));
    }
}
