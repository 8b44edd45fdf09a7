//! Hashes and texts that identify stored results: equal keys mean equal results.

use super::plan::Plan;
use super::point::Point;
use crate::report::{DeviceInfo, ProgramInfo};
use crate::scene::{Notes, Scene};
use crate::settings::Settings;
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::path::PathBuf;

/// Key of a point's row: program, device, scene, and every setting that its image or time depends
/// on. 16 hexadecimal digits.
pub(super) fn row_key(plan: &Plan, device: &DeviceInfo, scene_hash: &str, point: &Point) -> String {
    let s = &plan.base;
    let text = format!(
        "{:?} {:?} {} {:?} {}x{} {} {:?}",
        ProgramInfo::default(),
        device,
        scene_hash,
        point.words(),
        s.width,
        s.height,
        plan.repeats,
        s.schedule
    );
    format!("{:x}", Sha256::digest(text))[..16].into()
}

/// Key of a point's bias: every setting that the image depends on in the limit of many samples.
pub(super) fn bias_key(base: &Settings, truth_depth: u32, point: &Point) -> String {
    let Point { depth, cutoff, precision, .. } = point;
    format!(
        "{}x{} depth {depth} of {truth_depth} cutoff {cutoff} precision {} origin {} fresnel {} spheres {}",
        base.width,
        base.height,
        precision.name(),
        point.origin.name(),
        point.fresnel.name(),
        point.spheres.name()
    )
}

/// SHA-256 of a scene's content; the file's name does not count.
pub(super) fn scene_hash(scene: &Scene) -> String {
    struct Into<'a>(&'a mut Sha256);
    impl Write for Into<'_> {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            self.0.update(text);
            Ok(())
        }
    }
    let mut hash = Sha256::new();
    // `Debug` prints every field, and each number in digits that read back to the same number.
    let _ = write!(
        Into(&mut hash),
        "{:?}",
        Scene { file: PathBuf::new(), notes: Notes::default(), ..scene.clone() }
    );
    format!("{:x}", hash.finalize())
}
