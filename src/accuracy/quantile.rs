//! Quantiles of the normal, Student's t and Fisher's F distributions.

/// ln Γ(x) for x > 0: Stirling's series (DLMF 5.11.1) from 10 upward, where its first omitted term is
/// below 1e-15; the recurrence Γ(x + 1) = x Γ(x) leads there.
fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut below) = (x, 1.0);
    while x < 10.0 {
        below *= x;
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let series = (1.0 / 12.0
        - y * (1.0 / 360.0
            - y * (1.0 / 1260.0 - y * (1.0 / 1680.0 - y * (1.0 / 1188.0 - y * 691.0 / 360_360.0)))))
        / x;
    (x - 0.5) * x.ln() - x + 0.5 * std::f64::consts::TAU.ln() + series - f64::ln(below)
}

/// The regularised incomplete beta function `I_x(a, b)`: continued fraction DLMF 8.17.22 by Lentz's method
/// (Lentz, Applied Optics 15(3), 1976), on the side of the mean where it converges in about
/// `sqrt(max(a, b))` steps.
pub fn incomplete_beta(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(b, a, 1.0 - x);
    }
    let front = a * x.ln() + b * (-x).ln_1p() + ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b);
    // Lentz's guard against a zero denominator, and the change below which nothing changes any more.
    const TINY: f64 = 1e-300;
    const DONE: f64 = 1e-15;
    let steps = 200 + 10 * a.max(b).sqrt() as u64;
    let apart = |v: f64| if v.abs() < TINY { TINY } else { v };
    let (mut c, mut d) = (1.0, 1.0 / apart(1.0 - (a + b) * x / (a + 1.0)));
    let mut value = d;
    for m in (1..=steps).map(|m| m as f64) {
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut change = 1.0;
        for term in [even, odd] {
            d = 1.0 / apart(1.0 + term * d);
            c = apart(1.0 + term / c);
            change = c * d;
            value *= change;
        }
        if (change - 1.0).abs() < DONE {
            break;
        }
    }
    front.exp() * value / a
}

/// P(Z <= z) of the standard normal: Marsaglia, "Evaluating the Normal Distribution", Journal of
/// Statistical Software 11(4), 2004. Error about 1e-15 for |z| <= 7; 0 or 1 beyond 8.
pub fn normal_below(z: f64) -> f64 {
    if z.abs() > 8.0 {
        return if z > 0.0 { 1.0 } else { 0.0 };
    }
    let (mut term, mut sum, mut k) = (z, z, 1.0);
    while term.abs() > sum.abs() * 1e-17 {
        k += 2.0;
        term *= z * z / k;
        sum += term;
    }
    0.5 + sum * (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt()
}

/// The z that a standard normal stays below with probability `p`, 1e-14 < p < 1 - 1e-14.
pub fn normal(p: f64) -> f64 {
    bisect(-8.0, 8.0, |z| normal_below(z) < p)
}

/// The t that Student's distribution of `freedom` degrees stays below with probability `p` >= 0.5:
/// P(|T| > t) = I_(nu / (nu + t^2))(nu/2, 1/2) (DLMF 8.17, Abramowitz and Stegun 26.7.1).
pub fn student(p: f64, freedom: f64) -> f64 {
    let x = bisect(0.0, 1.0, |x| incomplete_beta(freedom / 2.0, 0.5, x) < 2.0 * (1.0 - p));
    (freedom * (1.0 - x) / x).sqrt()
}

/// More degrees of freedom than this are as good as this many: the quantile differs by less than 2e-3
/// of itself from the limit, and rises with fewer.
const MOST_FREEDOM: f64 = 4e6;

/// The f that Fisher's distribution of `above` and `below` degrees of freedom stays below with
/// probability `p`: P(F <= f) = I_x(above/2, below/2) with x = above f / (above f + below)
/// (Abramowitz and Stegun 26.6.2).
pub fn fisher(p: f64, above: f64, below: f64) -> f64 {
    let (above, below) = (above.min(MOST_FREEDOM), below.min(MOST_FREEDOM));
    // The complement keeps its digits where x is near 1.
    let y = bisect(0.0, 1.0, |y| incomplete_beta(below / 2.0, above / 2.0, y) < 1.0 - p);
    below * (1.0 - y) / (above * y)
}

/// The place in [low, high] where `before` turns false, to the last bit.
fn bisect(mut low: f64, mut high: f64, before: impl Fn(f64) -> bool) -> f64 {
    // 1100 halvings reach the least number; the middle meets an end long before that.
    for _ in 0..1100 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if before(middle) { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64, relative: f64) {
        assert!((a - b).abs() <= relative * b.abs(), "{a} is not {b}");
    }

    /// Printed tables: Abramowitz and Stegun 26.1, 26.10 and 26.9.
    #[test]
    fn quantiles_are_those_of_the_tables() {
        near(normal(0.975), 1.959_963_984_540_054, 1e-13);
        near(normal(0.05), -1.644_853_626_951_472, 1e-13);
        near(student(0.975, 15.0), 2.131, 3e-4);
        near(student(0.975, 3.0), 3.182, 3e-4);
        near(student(0.975, 1.0), 12.706, 3e-5);
        near(fisher(0.95, 1.0, 3.0), 10.13, 3e-4);
        near(fisher(0.95, 10.0, 30.0), 2.16, 3e-3);
        near(fisher(0.99, 4.0, 15.0), 4.89, 1e-3);
    }

    /// Closed forms: F(2, 2) has P(F <= f) = f / (1 + f); t^2 is F(1, nu); 1/F(a, b) is F(b, a).
    #[test]
    fn quantiles_obey_their_identities() {
        near(fisher(0.9, 2.0, 2.0), 9.0, 1e-12);
        near(student(0.98, 7.0).powi(2), fisher(0.96, 1.0, 7.0), 1e-11);
        near(fisher(0.7, 5.0, 11.0), 1.0 / fisher(0.3, 11.0, 5.0), 1e-11);
        near(fisher(0.95, 3.7, 11.1), 1.0 / fisher(0.05, 11.1, 3.7), 1e-11);
        near(ln_gamma(0.5), std::f64::consts::PI.sqrt().ln(), 1e-14);
        near(ln_gamma(11.0), 3_628_800f64.ln(), 1e-14);
    }

    /// With many degrees of freedom ln F is normal with variance 2/a + 2/b.
    #[test]
    fn large_degrees_of_freedom_tend_to_the_normal() {
        let (a, b) = (3e5, 9e5);
        near(fisher(0.95, a, b).ln(), normal(0.95) * (2.0 / a + 2.0 / b).sqrt(), 2e-3);
        assert!(fisher(0.95, 1e12, 1e12) > 1.0);
        assert!(fisher(0.95, 1e12, 1e12) < 1.0024);
    }
}
