//! The error of an image on its way, against a reference picture.

use super::{ImageSoFar, Observer};
use crate::compare::metrics::rmse;
use crate::report::ReferencePoint;
use std::time::{Duration, Instant};

/// An observer that compares the image on its way with a reference picture of the same size, and passes everything on
/// to another observer.
pub struct Convergence<'a> {
    reference: &'a [[f32; 3]],
    observer: &'a mut dyn Observer,
    points: Vec<ReferencePoint>,
    /// Time that the comparisons took, which counts as no time of the render.
    spent: Duration,
}

impl<'a> Convergence<'a> {
    /// `reference`: rows from the top, linear RGB.
    pub fn new(reference: &'a [[f32; 3]], observer: &'a mut dyn Observer) -> Convergence<'a> {
        Convergence { reference, observer, points: Vec::new(), spent: Duration::ZERO }
    }

    /// One point per image that was seen, in order.
    pub fn into_points(self) -> Vec<ReferencePoint> {
        self.points
    }
}

impl Observer for Convergence<'_> {
    fn progress(&mut self, done: u64, total: u64) {
        self.observer.progress(done, total);
    }

    fn cancelled(&self) -> bool {
        self.observer.cancelled()
    }

    fn watches(&self) -> bool {
        true
    }

    fn image(&mut self, so_far: &ImageSoFar<'_>) {
        let begin = Instant::now();
        let &ImageSoFar { linear, samples, rays, seconds } = so_far;
        if let Ok(rmse) = rmse(linear, self.reference) {
            let seconds = (seconds - self.spent.as_secs_f64()).max(0.0);
            self.points.push(ReferencePoint { seconds, samples, rays, rmse });
        }
        if self.observer.watches() {
            self.observer.image(so_far);
        }
        self.spent += begin.elapsed();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Quiet;

    #[test]
    fn each_image_gives_a_point_and_comparing_takes_no_time() {
        let reference = vec![[0.5, 0.5, 2.0]; 300_000];
        let mut quiet = Quiet;
        let mut convergence = Convergence::new(&reference, &mut quiet);
        assert!(convergence.watches());
        for (samples, level) in [(1.0, 0.0f32), (2.0, 0.5)] {
            let linear = vec![[level, level, 1.5]; 300_000];
            convergence.image(&ImageSoFar { linear: &linear, samples, rays: 7, seconds: 1.0 });
        }
        // An image of another size has no error.
        convergence.image(&ImageSoFar { linear: &[[0.0; 3]], samples: 4.0, rays: 9, seconds: 2.0 });
        let points = convergence.into_points();
        assert_eq!(points.len(), 2);
        // Two of three channels are off by one half; what is above 1 is shown as 1.
        assert!((points[0].rmse - (0.5f64 / 3.0).sqrt()).abs() < 1e-12 && points[1].rmse == 0.0);
        assert!(points[0].seconds == 1.0 && points[1].seconds < 1.0);
        assert_eq!((points[1].samples, points[1].rays), (2.0, 7));
    }
}
