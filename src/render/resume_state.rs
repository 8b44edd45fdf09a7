//! Resume state: what a render leaves to the one that goes on with it: an interrupted one to its continuation, a
//! share to the picture that it is a part of, a picture to one of more samples. All have the same file format:
//!
//! ```text
//! magic     a line of text that ends in the format's version
//! header    a line of JSON: kind, identity, times, counts, and the payload's fields
//! numbers   of the payload, little-endian
//! checksum  SHA-256 of all bytes before it, 32 bytes
//! ```

use super::identity::{Identity, Mismatch};
use super::tally::Tally;
use crate::report::{SettingsInfo, TimeInfo};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fmt;
use std::io::{self, ErrorKind, Read, Write};

const MAGIC: &[u8] = b"whitted resume state 2\n";
const CHECKSUM: usize = 32;

/// Kinds of renders that can be resumed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Fixed settings: every pixel gets the same number of samples.
    Sums,
    /// An error is asked for or stated: samples are counted pixel by pixel.
    Bounded,
}

impl fmt::Display for Kind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Kind::Sums => "a render without --error, --time and --budget",
            Kind::Bounded => "a render with --error, --time or --budget",
        })
    }
}

/// What one kind of render keeps. Its fields go to the header, large arrays to the numbers after it.
pub trait Payload: Serialize + DeserializeOwned {
    /// The kind.
    const KIND: Kind;

    /// Writes the numbers that are no fields.
    ///
    /// # Errors
    /// If `to` fails.
    fn put(&self, to: &mut dyn Write) -> io::Result<()>;

    /// Takes these numbers from `from`, which holds nothing else; `None` if they do not fit the fields or
    /// an image of `settings`.
    fn take(&mut self, from: &[u8], settings: &SettingsInfo) -> Option<()>;
}

/// A render on its way, or a finished one that more samples may follow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResumeState<P> {
    kind: Kind,
    pub(super) identity: Identity,
    /// Seconds of all parts so far.
    pub time: TimeInfo,
    pub(super) tally: Tally,
    pub(super) payload: P,
}

/// A state of any kind, to be written to a file.
pub trait State {
    /// Writes a file.
    ///
    /// # Errors
    /// If `out` fails.
    fn write(&self, out: &mut dyn Write) -> io::Result<()>;
}

impl<P: Payload> State for ResumeState<P> {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut out = Hashed { out, hash: Sha256::new() };
        out.write_all(MAGIC)?;
        serde_json::to_writer(&mut out, self)?;
        out.write_all(b"\n")?;
        self.payload.put(&mut out)?;
        let Hashed { out, hash } = out;
        out.write_all(&hash.finalize())
    }
}

/// Sees all bytes on their way.
struct Hashed<'a> {
    out: &'a mut dyn Write,
    hash: Sha256,
}

impl Write for Hashed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
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
        let sound = state.tally.is_sound() && state.time.is_sound();
        match state.payload.take(numbers, &state.identity.settings) {
            Some(()) if sound => Ok(state),
            _ => Err(invalid("the file is damaged: its numbers do not fit each other")),
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

#[cfg(test)]
mod tests;
