//! Numbers as sums of two f64 (Dekker 1971, Knuth's TwoSum): some 104 bits, enough to judge f64
//! kernels. Only for expected results.

use glam::DVec3;

/// An unevaluated sum of two numbers.
#[derive(Debug, Clone, Copy)]
struct Sum(f64, f64);

impl Sum {
    fn add(self, o: Sum) -> Sum {
        let s = self.0 + o.0;
        let bb = s - self.0;
        let e = (self.0 - (s - bb)) + (o.0 - bb) + self.1 + o.1;
        Sum::quick(s, e)
    }

    fn quick(a: f64, b: f64) -> Sum {
        let s = a + b;
        Sum(s, b - (s - a))
    }

    fn sub(self, o: Sum) -> Sum {
        self.add(Sum(-o.0, -o.1))
    }

    fn mul(self, o: Sum) -> Sum {
        let p = self.0 * o.0;
        Sum::quick(p, self.0.mul_add(o.0, -p) + (self.0 * o.1 + self.1 * o.0))
    }

    fn div(self, o: Sum) -> Sum {
        let q = self.0 / o.0;
        let r = self.sub(o.mul(Sum(q, 0.0)));
        Sum::quick(q, (r.0 + r.1) / o.0)
    }

    fn sqrt(self) -> Sum {
        let s = self.0.max(0.0).sqrt();
        if s == 0.0 {
            return Sum(0.0, 0.0);
        }
        let r = self.sub(Sum(s, 0.0).mul(Sum(s, 0.0)));
        Sum::quick(s, (r.0 + r.1) / (2.0 * s))
    }

    fn dot(a: [Sum; 3], b: [Sum; 3]) -> Sum {
        a[0].mul(b[0]).add(a[1].mul(b[1])).add(a[2].mul(b[2]))
    }

    fn value(self) -> f64 {
        self.0 + self.1
    }
}

fn sums(v: DVec3) -> [Sum; 3] {
    v.to_array().map(|x| Sum(x, 0.0))
}

/// A ray and a sphere.
#[derive(Debug, Clone, Copy)]
pub struct Pass {
    /// Both roots in units of the direction, the nearer first; NaN if it misses.
    pub roots: [f64; 2],
    /// Distance of the ray's line from the centre - radius.
    pub gap: f64,
    /// Distance of the centre from the ray's origin.
    pub distance: f64,
}

/// The ray o + t d and the sphere of centre c and radius r.
pub fn pass(o: DVec3, d: DVec3, c: DVec3, r: f64) -> Pass {
    let [f, d] = [[0, 1, 2].map(|i| Sum(o[i], 0.0).sub(Sum(c[i], 0.0))), sums(d)];
    let r = Sum(r, 0.0);
    let (a, b, ff) = (Sum::dot(d, d), Sum::dot(f, d), Sum::dot(f, f));
    let b = Sum(-b.0, -b.1);
    let lack = ff.sub(r.mul(r));
    let discriminant = b.mul(b).sub(a.mul(lack));
    let impact = ff.sub(b.mul(b).div(a)).sqrt();
    let gap = impact.sub(r).value();
    let mut roots = [f64::NAN; 2];
    if discriminant.0 >= 0.0 {
        let root = discriminant.sqrt();
        let q = if b.0 < 0.0 { b.sub(root) } else { b.add(root) };
        let (x, y) = (lack.div(q).value(), q.div(a).value());
        roots = [x.min(y), x.max(y)];
    }
    Pass { roots, gap, distance: ff.sqrt().value() }
}
