//! Resume state: what an interrupted render leaves to the one that continues it. Every kind of render has
//! the same file format:
//!
//! ```text
//! magic     a line of text that ends in the format's version
//! header    a line of JSON: kind, identity, times, counts, and the payload's fields
//! numbers   of the payload, little-endian
//! checksum  SHA-256 of all bytes before it, 32 bytes
//! ```

use super::batches::Drawn;
use super::identity::{Identity, Mismatch};
use super::tally::Tally;
use crate::plan::tiles::Tile;
use crate::report::{SettingsInfo, TimeInfo};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fmt;
use std::io::{self, ErrorKind, Read, Write};

const MAGIC: &[u8] = b"whitted resume state 1\n";
const CHECKSUM: usize = 32;

/// Kinds of renders that can be resumed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Fixed settings: whole tiles are finished one after the other.
    Tiles,
    /// An error is asked for or stated: samples are counted pixel by pixel.
    Bounded,
}

impl fmt::Display for Kind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Kind::Tiles => "a render without --error and --budget",
            Kind::Bounded => "a render with --error or --budget",
        })
    }
}

/// What one kind of render keeps. Its fields go to the header, large arrays to the numbers after it.
pub trait Payload: Serialize + DeserializeOwned {
    /// The kind.
    const KIND: Kind;

    /// Appends the numbers that are no fields.
    fn put(&self, to: &mut Vec<u8>);

    /// Takes these numbers from `from`, which holds nothing else; `None` if they do not fit the fields or
    /// an image of `settings`.
    fn take(&mut self, from: &[u8], settings: &SettingsInfo) -> Option<()>;
}

/// An interrupted render.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResumeState<P> {
    kind: Kind,
    identity: Identity,
    /// Seconds of all parts so far.
    pub time: TimeInfo,
    tally: Tally,
    payload: P,
}

impl<P: Payload> ResumeState<P> {
    pub(super) fn new(identity: Identity, time: TimeInfo, tally: Tally, payload: P) -> ResumeState<P> {
        ResumeState { kind: P::KIND, identity, time, tally, payload }
    }

    /// Its parts, if it belongs to the render `now`.
    pub(super) fn into_parts(self, now: &Identity) -> Result<(P, Tally, TimeInfo), Mismatch> {
        self.identity.check(now)?;
        Ok((self.payload, self.tally, self.time))
    }

    /// Writes a file.
    ///
    /// # Errors
    /// If `out` fails.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut bytes = MAGIC.to_vec();
        serde_json::to_writer(&mut bytes, self)?;
        bytes.push(b'\n');
        self.payload.put(&mut bytes);
        out.write_all(&bytes)?;
        out.write_all(&Sha256::digest(&bytes))
    }

    /// Reads a file. No byte of it is used before its checksum is found to be right.
    ///
    /// # Errors
    /// If reading fails, or the file is damaged, of another kind of render or of another version.
    pub fn read(from: &mut dyn Read) -> io::Result<ResumeState<P>> {
        let mut bytes = Vec::new();
        from.read_to_end(&mut bytes)?;
        if !bytes.starts_with(MAGIC) {
            return Err(invalid("it is no resume state, or one of another version"));
        }
        let (content, sum) = bytes.split_last_chunk::<CHECKSUM>().unwrap_or((&[], &[0; CHECKSUM]));
        if Sha256::digest(content)[..] != sum[..] {
            return Err(invalid("the file is damaged: wrong checksum"));
        }
        let rest = content.get(MAGIC.len()..).unwrap_or_default();
        let mut parts = rest.splitn(2, |b| *b == b'\n');
        let (header, numbers) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
        let other = |e| invalid(&format!("another version of this program wrote it: {e}"));
        let Header { kind } = serde_json::from_slice(header).map_err(other)?;
        if kind != P::KIND {
            return Err(invalid(&format!("it belongs to {kind}")));
        }
        let mut state: ResumeState<P> = serde_json::from_slice(header).map_err(other)?;
        match state.payload.take(numbers, &state.identity.settings) {
            Some(()) => Ok(state),
            None => Err(invalid("the file is damaged: its numbers do not fit its header")),
        }
    }
}

/// What is read first.
#[derive(Deserialize)]
struct Header {
    kind: Kind,
}

fn invalid(why: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, why)
}

/// The finished tiles of an image of fixed settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tiles {
    tiles: Vec<Tile>,
    /// The pixels of `tiles`, one tile after the other.
    #[serde(skip)]
    linear: Vec<[f32; 3]>,
}

impl Tiles {
    /// The finished part of an image of `region`.
    pub(super) fn of(drawn: &Drawn, region: [u32; 4]) -> Tiles {
        let offsets = drawn.finished.iter().flat_map(|tile| tile.offsets(region));
        Tiles { linear: offsets.map(|at| drawn.linear[at]).collect(), tiles: drawn.finished.clone() }
    }
}

impl ResumeState<Tiles> {
    /// The image so far, if it is part of the render `now`.
    pub(super) fn into_drawn(self, now: &Identity) -> Result<(Drawn, TimeInfo), Mismatch> {
        let (Tiles { tiles, linear: pixels }, tally, time) = self.into_parts(now)?;
        let region = now.settings.region();
        let [x0, y0, x1, y1] = region;
        let mut linear = vec![[0.0; 3]; (x1 - x0) as usize * (y1 - y0) as usize];
        for (at, pixel) in tiles.iter().flat_map(|tile| tile.offsets(region)).zip(pixels) {
            linear[at] = pixel;
        }
        Ok((Drawn { linear, finished: tiles, tally }, time))
    }
}

impl Payload for Tiles {
    const KIND: Kind = Kind::Tiles;

    fn put(&self, to: &mut Vec<u8>) {
        self.linear.as_flattened().iter().for_each(|channel| to.extend(channel.to_le_bytes()));
    }

    fn take(&mut self, from: &[u8], settings: &SettingsInfo) -> Option<()> {
        let region = settings.region();
        let bytes = |tile: &Tile| 12 * u128::from(tile.width) * u128::from(tile.height);
        let fits = from.len() as u128 == self.tiles.iter().map(bytes).sum();
        if !fits || !self.tiles.iter().all(|tile| tile.is_in(region)) {
            return None;
        }
        let channels: Vec<f32> = from.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        self.linear = channels.as_chunks().0.to_vec();
        Some(())
    }
}

#[cfg(test)]
mod tests;
