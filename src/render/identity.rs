//! Identity of a render: everything that the bits of its image depend on.

use super::upload::{Upload, uploads};
use crate::kernel::abi::Buf;
use crate::kernel::abi::double::Camera;
use crate::prepare::Packed;
use crate::report::{DeviceInfo, ProgramInfo, SettingsInfo};
use crate::settings::Settings;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Why a resume state cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Mismatch(pub String);

/// Two renders with equal identities have the same image, bit for bit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    pub(super) program: ProgramInfo,
    pub(super) device: DeviceInfo,
    pub(super) settings: SettingsInfo,
    /// What is asked of the error, as options; empty for fixed settings.
    pub(super) request: String,
    /// SHA-256 over all that the kernels are given of the scene, the files it names included.
    pub(super) scene: String,
}

impl Identity {
    pub(super) fn new(
        device: &DeviceInfo,
        packed: &Packed,
        camera: Camera,
        settings: &Settings,
        request: String,
    ) -> Identity {
        let camera = [camera];
        let mut hash = Sha256::new();
        // Nodes decide no bit, and which form of them there is follows from the schedule.
        let is_node = |u: &Upload| matches!(u.buffer, Buf::Nodes | Buf::CompressedNodes);
        for upload in uploads(packed, &camera, settings.precision).into_iter().filter(|u| !is_node(u)) {
            // With its length, so that no byte can change buffers unseen.
            hash.update((upload.shape.bytes as u64).to_le_bytes());
            upload.pieces(|bytes| hash.update(bytes));
        }
        Identity {
            program: ProgramInfo::default(),
            device: device.clone(),
            settings: SettingsInfo::of(settings),
            request,
            scene: format!("{:x}", hash.finalize()),
        }
    }

    /// Compares `self`, the identity of an earlier render, with that of this one.
    ///
    /// # Errors
    /// If they differ; names the first difference.
    pub(super) fn check(&self, now: &Identity) -> Result<(), Mismatch> {
        let version = |p: &ProgramInfo| format!("{} {} ({})", p.name, p.version, p.git);
        let device = |d: &DeviceInfo| format!("{}, {}, Vulkan {}", d.name, d.driver, d.api);
        let request = |r: &str| if r.is_empty() { "no --error or --budget".into() } else { r.to_owned() };
        let differ = |what: &str, then: String, now: String| {
            (then != now).then(|| Mismatch(format!("it belongs to {what} {then}, this one has {now}")))
        };
        let faults = [
            differ("program", version(&self.program), version(&now.program)),
            differ("a render with", request(&self.request), request(&now.request)),
            differ("settings", options(&self.settings), options(&now.settings)),
            differ("device", device(&self.device), device(&now.device)),
        ];
        if let Some(fault) = faults.into_iter().flatten().next() {
            return Err(fault);
        }
        if self != now {
            return Err(Mismatch("the scene, or a file it refers to, has changed since".into()));
        }
        Ok(())
    }
}

/// Settings as options of the command line.
fn options(s: &SettingsInfo) -> String {
    let crop = s.crop.map_or(String::new(), |[x0, y0, x1, y1]| format!(" --crop {x0},{y0},{x1},{y1}"));
    format!(
        "--size {}x{}{crop} --samples {} --depth {} --cutoff {} --sampler {} --seed {} --precision {} --origin {} (replicates {})",
        s.width,
        s.height,
        s.samples,
        s.depth,
        s.cutoff,
        s.sampler,
        s.seed,
        s.precision,
        s.origin,
        s.replicates
    )
}
