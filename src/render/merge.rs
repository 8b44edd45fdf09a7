//! Shares of an image joined to the image that one render would have given.

use super::prepared::rendered;
use super::{Mismatch, Rendered, ResumeState, Sums};
use crate::report::DeviceInfo;
use crate::settings::Share;
use std::collections::BTreeMap;

/// Why shares are not joined. Shares are named as they were given.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// A share of another render than the first.
    #[error("{name} is no share of the same render as {first}: {why}")]
    Different {
        /// The share.
        name: String,
        /// The first one that was given.
        first: String,
        /// What differs.
        why: Mismatch,
    },
    /// One that was interrupted.
    #[error("{name} is not finished: render share {share} again, with --resume")]
    Unfinished {
        /// The share.
        name: String,
        /// Its number.
        share: Share,
    },
    /// The same share twice.
    #[error("{name} and {other} are both share {share}: leave one of them out")]
    Twice {
        /// The share.
        name: String,
        /// The other one.
        other: String,
        /// Their number.
        share: Share,
    },
    /// Not all shares are there.
    #[error("{}", missing(*.count, .absent))]
    Missing {
        /// Number of shares.
        count: u32,
        /// Those that are missing, in order.
        absent: Vec<u32>,
    },
    /// No share was given.
    #[error("there is no share to merge")]
    Nothing,
    /// More rays than a render can have.
    #[error("the counts of the shares are no counts of a render: one of the files is forged")]
    Counts,
}

/// Names shares that are missing.
fn missing(count: u32, absent: &[u32]) -> String {
    let named: Vec<String> = absent.iter().take(20).map(|index| format!("{index}/{count}")).collect();
    let more = absent.len().saturating_sub(named.len());
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let (is, are) = (if absent.len() == 1 { "share" } else { "shares" }, named.join(", "));
    format!(
        "{} of {count} {is} missing: {are}{more}; render each with --share and merge again",
        absent.len(),
        is = if absent.len() == 1 { format!("{is} is") } else { format!("{is} are") }
    )
}

/// Shares joined so far, in any order.
#[derive(Default)]
pub struct Merge {
    whole: Option<ResumeState<Sums>>,
    names: BTreeMap<u32, String>,
    first: String,
    /// Shares by device, where devices may differ.
    devices: Vec<(DeviceInfo, Vec<u32>)>,
    mixed: bool,
}

impl Merge {
    /// No share yet. `mixed`: they may be of different devices, which need not give the same bits.
    pub fn new(mixed: bool) -> Merge {
        Merge { mixed, ..Merge::default() }
    }

    /// Joins one more share, called `name` in errors.
    ///
    /// # Errors
    /// If it is unfinished, of another render, or there already.
    pub fn add(&mut self, name: &str, share: ResumeState<Sums>) -> Result<(), MergeError> {
        let name = name.to_owned();
        if !share.is_finished() {
            return Err(MergeError::Unfinished { name, share: share.share() });
        }
        if let Some(whole) = &self.whole {
            let mut identity = share.identity.clone();
            if self.mixed {
                identity.device = whole.identity.device.clone();
            }
            let same = identity.check(&whole.identity);
            let count = |of: u32| format!("{of} shares");
            let (here, there) = (share.share().count, whole.payload.share.count);
            let same = same.and(match here == there {
                true => Ok(()),
                false => Err(Mismatch(format!("it is one of {}, not of {}", count(here), count(there)))),
            });
            same.map_err(|why| MergeError::Different { name: name.clone(), first: self.first.clone(), why })?;
        }
        if let Some(other) = self.names.get(&share.share().index) {
            return Err(MergeError::Twice { name, other: other.clone(), share: share.share() });
        }
        let (index, device) = (share.share().index, share.identity.device.clone());
        match self.devices.iter_mut().find(|(known, _)| *known == device) {
            Some((_, shares)) => shares.push(index),
            None => self.devices.push((device, vec![index])),
        }
        match &mut self.whole {
            None => {
                self.first.clone_from(&name);
                self.whole = Some(share);
            }
            Some(whole) => {
                whole.payload.join(&share.payload);
                whole.tally.add(&share.tally);
                whole.time.add(&share.time);
                let warnings = &mut whole.payload.outline.warnings;
                for warning in &share.payload.outline.warnings {
                    if !warnings.contains(warning) {
                        warnings.push(warning.clone());
                    }
                }
            }
        }
        self.names.insert(index, name);
        Ok(())
    }

    /// The image of all shares. Its times are the sums of theirs.
    ///
    /// # Errors
    /// If shares are missing.
    pub fn finish(self) -> Result<Rendered, MergeError> {
        let Some(mut whole) = self.whole else { return Err(MergeError::Nothing) };
        let count = whole.payload.share.count;
        let absent: Vec<u32> = (1..=count).filter(|index| !self.names.contains_key(index)).collect();
        if !absent.is_empty() {
            return Err(MergeError::Missing { count, absent });
        }
        if !whole.tally.is_sound() {
            return Err(MergeError::Counts);
        }
        whole.payload.share = Share::WHOLE;
        if self.devices.len() > 1 {
            let outline = &mut whole.payload.outline;
            outline.device = mixed(&self.devices);
            outline.warnings.push(format!(
                "shares were rendered on different devices, whose bits may differ: {}",
                outline.device.name
            ));
            whole.identity.device = outline.device.clone();
        }
        Ok(rendered(whole, 1.0))
    }
}

/// Several devices as one, each with the number of its shares.
fn mixed(devices: &[(DeviceInfo, Vec<u32>)]) -> DeviceInfo {
    let all = |part: fn(&DeviceInfo) -> &str| -> String {
        let parts = devices.iter().map(|(device, shares)| format!("{} ({})", part(device), shares.len()));
        format!("mixed: {}", parts.collect::<Vec<_>>().join(", "))
    };
    DeviceInfo {
        name: all(|d| &d.name),
        kind: "mixed".into(),
        driver: all(|d| &d.driver),
        api: all(|d| &d.api),
    }
}
