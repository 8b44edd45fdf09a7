//! Host memory of an image: what it takes beside the scene and the device's buffers, known before anything starts.

use super::PlanError;

/// What is done with each pixel on the host; it decides the bytes per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HostWork {
    /// An image of fixed settings, as it comes from the device.
    Image,
    /// The same with sums of every pixel, from which the error is bounded.
    Bounded,
}

impl HostWork {
    /// Bytes per pixel, by the arrays that live at the same time. An image is 12 bytes of f32, its sums 24 and the number of
    /// their samples 4; the rest of the figure of a bounded one was measured as the growth of resident memory with pixels: 385 bytes
    /// (`render --budget --samples 2`, 6 million pixels).
    fn bytes_per_pixel(self) -> u64 {
        match self {
            HostWork::Image => 12 + 24 + 4,
            HostWork::Bounded => 400,
        }
    }
}

/// Bytes per pixel while the largest format is written: three channels apart, and what is encoded of them in a buffer
/// that doubles as it grows.
pub const LARGEST_FILE: u64 = 12 + 24;

/// Bytes for an image of `region`, written with `file` bytes per pixel.
pub fn needed(region: [u32; 4], work: HostWork, file: u64) -> u64 {
    let [x0, y0, x1, y1] = region;
    u64::from(x1 - x0) * u64::from(y1 - y0) * (work.bytes_per_pixel() + file)
}

/// Checks that an image of `region` fits `free` bytes; all fits where nothing is known.
///
/// # Errors
/// [`PlanError::ImageTooLarge`] with the size of the same shape that would fit.
pub fn check(region: [u32; 4], work: HostWork, file: u64, free: Option<u64>) -> Result<(), PlanError> {
    let bytes = needed(region, work, file);
    let Some(free) = free.filter(|free| bytes > *free) else { return Ok(()) };
    let [x0, y0, x1, y1] = region;
    let shrink = (free as f64 / bytes as f64).sqrt();
    let fit = [x1 - x0, y1 - y0].map(|side| (f64::from(side) * shrink) as u32);
    Err(PlanError::ImageTooLarge { size: [x1 - x0, y1 - y0], bytes, free, fit })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_fit_fits_and_a_little_more_does_not() {
        let all = [0, 0, 65_535, 40_000];
        for (work, free) in [(HostWork::Image, 1 << 30), (HostWork::Bounded, 22_000_000_000)] {
            let Err(PlanError::ImageTooLarge { bytes, fit: [width, height], .. }) =
                check(all, work, LARGEST_FILE, Some(free))
            else {
                panic!("{work:?}")
            };
            assert_eq!(bytes, needed(all, work, LARGEST_FILE));
            assert_eq!(check([0, 0, width, height], work, LARGEST_FILE, Some(free)), Ok(()));
            let more = [0, 0, width + width / 100, height + height / 100];
            assert!(check(more, work, LARGEST_FILE, Some(free)).is_err());
            // The same shape.
            assert!((f64::from(width) / f64::from(height) - 65_535.0 / 40_000.0).abs() < 1e-3);
            assert_eq!(check(all, work, LARGEST_FILE, None), Ok(()), "nothing is known");
        }
    }

    #[test]
    fn only_the_region_counts() {
        assert_eq!(needed([10, 20, 110, 70], HostWork::Image, 0), 100 * 50 * 40);
    }
}
