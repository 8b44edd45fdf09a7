//! The truth of a sweep: the scene in f64, at a depth with negligible truncation, sampled until its
//! own standard error is small. The standard error is estimated from replicates, which are
//! independent estimates of each pixel (Owen, "Monte Carlo Theory, Methods and Examples", chapter
//! 17.6).

use crate::accuracy::radiance_bound::RadianceLimit;
use crate::accuracy::truncation::{TruncationBound, truncation};
use crate::render::samples::{Source, Traced};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::io::{self, BufRead, Read, Write};

/// Independent estimates of each pixel.
pub const REPLICATES: u32 = 16;
/// Least samples of a pixel.
const FIRST: u32 = 4 * REPLICATES;
/// A pixel stops once its standard error is below this fraction of the target for the whole image.
/// The estimate from 16 replicates has a relative error of 18 %; the margin keeps pixels that
/// stopped by chance from mattering.
const LEAVES: f64 = 0.5;
/// Samples between two checks for cancellation.
const PART: u64 = 1 << 21;

/// Everything that the samples of a truth depend on.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// Tracer with versions.
    pub tracer: String,
    /// SHA-256 of the scene, with the Fresnel law used.
    pub scene: String,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Rays in the longest path.
    pub depth: u32,
    /// Sampler seed; no point of the sweep uses it.
    pub seed: u32,
}

/// Sums of samples for every pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Identity.
    pub identity: Identity,
    /// Bound on the light beyond its depth; `None` if its tracer does not measure it.
    pub truncation: Option<TruncationBound>,
    /// Sum of replicate r of pixel i at `i * REPLICATES + r`.
    sums: Vec<[f64; 3]>,
    /// Samples of each pixel, a multiple of [`REPLICATES`].
    counts: Vec<u32>,
}

/// Quality of a truth, as written to `sweep.json`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TruthInfo {
    /// Identity.
    #[serde(flatten)]
    pub identity: Identity,
    /// Mean samples per pixel.
    pub samples_mean: f64,
    /// Greatest number of samples of a pixel.
    pub samples_most: u32,
    /// Root mean square of the pixels' standard errors, linear light.
    pub standard_error: f64,
    /// Bound on the light beyond its depth; missing if its tracer does not measure it.
    pub truncation: Option<TruncationBound>,
    /// True if the standard error is at most a tenth of the smallest error measured against it.
    pub converged: bool,
}

impl Truth {
    /// A truth without samples.
    pub fn new(identity: Identity, truncation: Option<TruncationBound>) -> Truth {
        let pixels = identity.width as usize * identity.height as usize;
        Truth {
            identity,
            truncation,
            sums: vec![[0.0; 3]; pixels * REPLICATES as usize],
            counts: vec![0; pixels],
        }
    }

    /// Mean of each pixel, linear RGB, unclamped.
    pub fn linear(&self) -> Vec<DVec3> {
        let pixels = self.sums.chunks(REPLICATES as usize).zip(&self.counts);
        pixels
            .map(|(sums, count)| {
                sums.iter().map(|s| DVec3::from(*s)).sum::<DVec3>() / f64::from((*count).max(1))
            })
            .collect()
    }

    /// Squared standard error of each pixel, mean over the channels. A channel that is certainly
    /// above 1 is clamped and has none. Infinite before the first sample.
    fn variances(&self) -> Vec<f64> {
        let pixels = self.sums.chunks(REPLICATES as usize).zip(&self.counts);
        pixels.map(|(sums, count)| variance_shown(sums, *count)).collect()
    }

    /// Root mean square of the standard errors over all channels.
    pub fn standard_error(&self) -> f64 {
        let variances = self.variances();
        (variances.iter().sum::<f64>() / variances.len().max(1) as f64).sqrt()
    }

    /// True if [`Truth::refine`] would trace samples.
    pub fn can_improve(&self, target: f64, most: u32) -> bool {
        !self.wanting(target, cap(most)).is_empty()
    }

    /// The pixels that need more samples for a standard error of `target` and have fewer than
    /// `most`, grouped by their number of samples.
    fn wanting(&self, target: f64, most: u32) -> BTreeMap<u32, Vec<u32>> {
        let variances = self.variances();
        let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        if variances.iter().sum::<f64>() <= target * target * variances.len() as f64 {
            return groups;
        }
        let least = (LEAVES * target).powi(2);
        for ((pixel, variance), count) in (0u32..).zip(&variances).zip(&self.counts) {
            if *variance > least && *count < most {
                groups.entry(*count).or_default().push(pixel);
            }
        }
        groups
    }

    /// Adds samples until the standard error is at most `target`, or every pixel above it has
    /// `most`. `after` is called after each part with the truth and the source, the samples traced and the
    /// samples planned in this round.
    ///
    /// # Errors
    /// Those of the source. Samples traced before are kept.
    pub fn refine<S: Source>(
        &mut self,
        source: &mut S,
        target: f64,
        most: u32,
        after: &mut dyn FnMut(&Truth, &mut S, u64, u64),
    ) -> Result<(), S::Error> {
        let most = cap(most);
        loop {
            let groups = self.wanting(target, most);
            if groups.is_empty() {
                return Ok(());
            }
            let next = |count: u32| (2 * count).max(FIRST).min(most);
            let planned: u64 =
                groups.iter().map(|(count, list)| list.len() as u64 * u64::from(next(*count) - count)).sum();
            let mut done = 0;
            for (count, list) in groups {
                let more = next(count) - count;
                for part in list.chunks((PART / u64::from(more)).max(1) as usize) {
                    let traced = source.trace(part, count..count + more)?;
                    self.add(part, &traced, more);
                    done += part.len() as u64 * u64::from(more);
                    after(self, source, done, planned);
                }
            }
        }
    }

    fn add(&mut self, pixels: &[u32], traced: &Traced, samples: u32) {
        let replicates = REPLICATES as usize;
        for (pixel, sums) in pixels.iter().zip(traced.sums.chunks(replicates)) {
            let at = *pixel as usize * replicates;
            for (mine, theirs) in self.sums[at..at + replicates].iter_mut().zip(sums) {
                *mine = std::array::from_fn(|c| mine[c] + theirs[c]);
            }
            self.counts[*pixel as usize] += samples;
        }
    }

    /// Its quality.
    pub fn info(&self, smallest_error: f64) -> TruthInfo {
        let standard_error = self.standard_error();
        let total: u64 = self.counts.iter().map(|c| u64::from(*c)).sum();
        TruthInfo {
            identity: self.identity.clone(),
            samples_mean: total as f64 / self.counts.len().max(1) as f64,
            samples_most: self.counts.iter().copied().max().unwrap_or(0),
            standard_error,
            truncation: self.truncation.clone(),
            converged: standard_error <= smallest_error / 10.0,
        }
    }

    /// Writes a line of JSON, then sums and counts, little-endian.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn save(&self, out: &mut dyn Write) -> io::Result<()> {
        let body = self.body();
        let header = Header {
            truth: self.identity.clone(),
            truncation: self.truncation.clone(),
            sha256: format!("{:x}", Sha256::digest(&body)),
        };
        serde_json::to_writer(&mut *out, &header)?;
        out.write_all(b"\n")?;
        out.write_all(&body)
    }

    /// Reads what [`Truth::save`] wrote; `None` if its identity is another or the file is damaged.
    ///
    /// # Errors
    /// Those of `from`.
    pub fn load(from: &mut dyn BufRead, identity: &Identity) -> io::Result<Option<Truth>> {
        let mut line = String::new();
        // Some other file may not be text.
        if from.take(1 << 16).read_line(&mut line).is_err() {
            return Ok(None);
        }
        let Ok(header) = serde_json::from_str::<Header>(&line) else { return Ok(None) };
        if header.truth != *identity {
            return Ok(None);
        }
        let mut truth = Truth::new(header.truth, header.truncation);
        let mut body = Vec::new();
        from.read_to_end(&mut body)?;
        let (sums, counts) = (truth.sums.len() * 24, truth.counts.len() * 4);
        if body.len() != sums + counts || format!("{:x}", Sha256::digest(&body)) != header.sha256 {
            return Ok(None);
        }
        let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap_or_default());
        for (sum, bytes) in truth.sums.iter_mut().zip(body.chunks(24)) {
            *sum = std::array::from_fn(|c| number(&bytes[8 * c..8 * c + 8]));
        }
        for (count, bytes) in truth.counts.iter_mut().zip(body[sums..].chunks(4)) {
            *count = u32::from_le_bytes(bytes.try_into().unwrap_or_default());
        }
        Ok(Some(truth))
    }

    fn body(&self) -> Vec<u8> {
        let sums = self.sums.iter().flatten().flat_map(|x| x.to_le_bytes());
        sums.chain(self.counts.iter().flat_map(|x| x.to_le_bytes())).collect()
    }
}

#[derive(Debug, Serialize, Deserialize)]
struct Header {
    truth: Identity,
    truncation: Option<TruncationBound>,
    sha256: String,
}

/// A limit on samples per pixel, rounded down to whole sets of replicates, at least [`FIRST`].
fn cap(most: u32) -> u32 {
    most.max(FIRST) / REPLICATES * REPLICATES
}

/// Mean over the channels of the squared standard error of a pixel's mean, from its replicates'
/// sums.
fn variance_shown(sums: &[[f64; 3]], count: u32) -> f64 {
    if count == 0 {
        return f64::INFINITY;
    }
    let each = f64::from(count) / sums.len() as f64;
    let channel = |c: usize| {
        let (mean, variance) = mean_and_variance(sums.iter().map(|s| s[c] / each));
        // Four standard errors above 1, a channel is clamped for certain.
        if mean - 4.0 * variance.sqrt() >= 1.0 { 0.0 } else { variance }
    };
    (0..3).map(channel).sum::<f64>() / 3.0
}

/// Mean of independent estimates, and the variance of that mean.
fn mean_and_variance(values: impl ExactSizeIterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.clone().sum::<f64>() / n;
    let spread: f64 = values.map(|v| (v - mean) * (v - mean)).sum();
    (mean, spread / (n * (n - 1.0)))
}

/// RMSE between two settings in the limit of many samples, estimated from the same samples of both:
/// the mean square difference minus the mean squared standard error of the difference. `samples` is
/// the number in each sum.
pub fn limit_error(a: &Traced, b: &Traced, samples: u32) -> f64 {
    let replicates = a.replicates.max(2);
    let each = f64::from(samples) / replicates as f64;
    let mut square = 0.0;
    let mut channels = 0u64;
    for (a, b) in a.sums.chunks(replicates).zip(b.sums.chunks(replicates)) {
        for c in 0..3 {
            let shown =
                |s: &[[f64; 3]]| (s.iter().map(|s| s[c]).sum::<f64>() / f64::from(samples)).clamp(0.0, 1.0);
            let differences = a.iter().zip(b).map(|(a, b)| (a[c] - b[c]) / each);
            let difference = shown(a) - shown(b);
            square += difference * difference - mean_and_variance(differences).1.min(difference * difference);
            channels += 1;
        }
    }
    (square / channels.max(1) as f64).max(0.0).sqrt()
}

/// Bound on the light beyond the depth of a survey, from `samples` of each pixel.
pub fn hidden_by_depth(traced: &Traced, samples: u32, limit: &RadianceLimit) -> TruncationBound {
    let n = f64::from(samples);
    let pixels = traced.sums.chunks(traced.replicates.max(1)).zip(&traced.marks).map(|(sums, mark)| {
        let mean = sums.iter().map(|s| DVec3::from(*s)).sum::<DVec3>() / n;
        (mean.to_array(), mark.cut / n)
    });
    truncation(&pixels.collect::<Vec<_>>(), limit)
}

#[cfg(test)]
mod tests;
