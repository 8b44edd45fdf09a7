//! What an interrupted render leaves to the one that goes on with it.

use super::batches::Drawn;
use super::tally::Tally;
use super::upload::{Upload, uploads};
use crate::image::linear_sha256;
use crate::kernel::abi::Buf;
use crate::kernel::abi::double::Camera;
use crate::plan::tiles::Tile;
use crate::prepare::Packed;
use crate::report::{DeviceInfo, ProgramInfo, SettingsInfo, TimeInfo};
use crate::settings::Settings;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io::{self, BufRead, ErrorKind, Write};

/// Why an unfinished render cannot be gone on with.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Mismatch(pub String);

/// Everything that the bits of an image depend on: where it is equal, they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Identity {
    program: ProgramInfo,
    device: DeviceInfo,
    settings: SettingsInfo,
    /// SHA-256 over all that the kernels are given of the scene, the files it names included.
    scene: String,
}

impl Identity {
    pub(super) fn new(device: &DeviceInfo, packed: &Packed, camera: Camera, settings: &Settings) -> Identity {
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
            scene: format!("{:x}", hash.finalize()),
        }
    }

    /// The first thing in which `self`, the earlier one, differs from `now`.
    fn check(&self, now: &Identity) -> Result<(), Mismatch> {
        let version = |p: &ProgramInfo| format!("{} {} ({})", p.name, p.version, p.git);
        let device = |d: &DeviceInfo| format!("{}, {}, Vulkan {}", d.name, d.driver, d.api);
        let differ = |what: &str, then: String, now: String| {
            (then != now).then(|| Mismatch(format!("it belongs to {what} {then}, this one has {now}")))
        };
        let faults = [
            differ("program", version(&self.program), version(&now.program)),
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

/// Which render it was that a survey was made for, and what had been counted when it was interrupted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Begun {
    identity: Identity,
    /// Seconds of all parts so far.
    pub time: TimeInfo,
    tally: Tally,
}

impl Begun {
    pub(super) fn new(identity: Identity) -> Begun {
        Begun { identity, time: TimeInfo::default(), tally: Tally::default() }
    }

    pub(super) fn with(self, tally: Tally) -> Begun {
        Begun { tally, ..self }
    }

    pub(super) fn tally(&self) -> &Tally {
        &self.tally
    }

    /// # Errors
    /// If `now` is another render than `self`, an earlier one: says in what they differ first.
    pub fn check(&self, now: &Begun) -> Result<(), Mismatch> {
        self.identity.check(&now.identity)
    }
}

/// The finished tiles of an interrupted render, and what they counted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unfinished {
    identity: Identity,
    /// Seconds of all parts so far.
    pub time: TimeInfo,
    tally: Tally,
    tiles: Vec<Tile>,
    /// Of `linear`, to notice a damaged file.
    linear_sha256: String,
    /// The pixels of `tiles`, one tile after the other.
    #[serde(skip)]
    linear: Vec<[f32; 3]>,
}

impl Unfinished {
    pub(super) fn new(identity: Identity, time: TimeInfo, drawn: &Drawn) -> Unfinished {
        let region = identity.settings.region();
        let offsets = drawn.finished.iter().flat_map(|tile| tile.offsets(region));
        let linear: Vec<_> = offsets.map(|at| drawn.linear[at]).collect();
        let linear_sha256 = linear_sha256(&linear);
        Unfinished {
            identity,
            time,
            tally: drawn.tally.clone(),
            tiles: drawn.finished.clone(),
            linear_sha256,
            linear,
        }
    }

    /// The image so far, if it is part of the render `now`.
    pub(super) fn into_drawn(self, now: &Identity) -> Result<(Drawn, TimeInfo), Mismatch> {
        self.identity.check(now)?;
        let [x0, y0, x1, y1] = now.settings.region();
        let mut linear = vec![[0.0; 3]; (x1 - x0) as usize * (y1 - y0) as usize];
        let offsets = self.tiles.iter().flat_map(|tile| tile.offsets([x0, y0, x1, y1]));
        for (at, pixel) in offsets.zip(self.linear) {
            linear[at] = pixel;
        }
        Ok((Drawn { linear, finished: self.tiles, tally: self.tally }, self.time))
    }

    /// Writes a line of JSON, then the pixels as little-endian `f32`.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        serde_json::to_writer(&mut *out, self)?;
        out.write_all(b"\n")?;
        self.linear.as_flattened().iter().try_for_each(|channel| out.write_all(&channel.to_le_bytes()))
    }

    /// Reads what [`Unfinished::write`] wrote.
    ///
    /// # Errors
    /// If reading fails, or the text is not of this version's form, or the pixels are not those that
    /// were written.
    pub fn read(from: &mut dyn BufRead) -> io::Result<Unfinished> {
        let damaged = |what: &str| io::Error::new(ErrorKind::InvalidData, what.to_owned());
        let mut header = Vec::new();
        from.read_until(b'\n', &mut header)?;
        if crate::accuracy::promise::is_kept(&header) {
            return Err(damaged("it belongs to a render with --error or --budget"));
        }
        let mut state: Unfinished = serde_json::from_slice(&header)?;
        let region = state.identity.settings.region();
        if !state.tiles.iter().all(|tile| tile.is_in(region)) {
            return Err(damaged("the file is damaged: a tile outside the image"));
        }
        let mut bytes = Vec::new();
        from.read_to_end(&mut bytes)?;
        let channels: Vec<f32> = bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        state.linear = channels.as_chunks().0.to_vec();
        let pixels: u64 = state.tiles.iter().map(|tile| u64::from(tile.pixels())).sum();
        if bytes.len() as u64 != 12 * pixels || linear_sha256(&state.linear) != state.linear_sha256 {
            return Err(damaged("the file is damaged: wrong checksum"));
        }
        Ok(state)
    }
}

#[cfg(test)]
mod tests;
