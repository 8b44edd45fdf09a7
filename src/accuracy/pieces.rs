//! Work on all pixels of an image, on all cores: the same bits whatever their number.

use rayon::prelude::*;

/// Pixels that one core takes at a time. Sums are made within pieces, then over them in order.
const PIECE: usize = 4096;

/// What `of` gives for each of `0..count`, in order.
pub fn map<T: Send>(count: usize, of: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    match count <= PIECE {
        true => (0..count).map(of).collect(),
        false => (0..count).into_par_iter().with_min_len(PIECE).map(of).collect(),
    }
}

/// `add` applied to `0..count` in order, from `T::default()` in every piece; the pieces are joined in order.
pub fn fold<T: Default + Send>(
    count: usize,
    add: impl Fn(&mut T, usize) + Sync + Send,
    join: impl FnMut(T, T) -> T,
) -> T {
    let piece = |begin: usize| {
        let mut all = T::default();
        (begin..(begin + PIECE).min(count)).for_each(|at| add(&mut all, at));
        all
    };
    if count <= PIECE {
        return piece(0);
    }
    let pieces: Vec<T> = (0..count.div_ceil(PIECE)).into_par_iter().map(|p| piece(p * PIECE)).collect();
    pieces.into_iter().reduce(join).unwrap_or_default()
}

/// The sum of `of` over `0..count`.
pub fn sum(count: usize, of: impl Fn(usize) -> f64 + Sync + Send) -> f64 {
    fold(count, |sum: &mut f64, at| *sum += of(at), |a, b| a + b)
}

/// The same of integers.
pub fn total(count: usize, of: impl Fn(usize) -> u64 + Sync + Send) -> u64 {
    fold(count, |sum: &mut u64, at| *sum += of(at), |a, b| a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_have_the_same_bits_on_any_number_of_cores() {
        let of = |at: usize| 1.0 / (1.0 + at as f64);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| (sum(50_001, of).to_bits(), total(50_001, |at| at as u64), map(50_001, of)))
        };
        let one = on(1);
        assert_eq!(one, on(3));
        assert_eq!((one.1, one.2.len()), (50_000 * 50_001 / 2, 50_001));
        // A single piece is a plain sum.
        assert_eq!(sum(PIECE, of).to_bits(), (0..PIECE).map(of).sum::<f64>().to_bits());
        assert_eq!((sum(0, of), map(0, of).len()), (0.0, 0));
    }
}
