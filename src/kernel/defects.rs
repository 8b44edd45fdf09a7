//! Planted mistakes, each one that some renderer makes. Tests plant them to show that the case that
//! guards against a mistake fails on it (mutation testing: DeMillo, Lipton, Sayward, IEEE Computer
//! 11(4), 1978). They exist with the feature `defects` alone, which the tests and benches switch on
//! and a release build does not.
//!
//! A mistake in a kernel is a list of edits of the GLSL. `build.rs` makes all of them in a copy of the
//! sources, each behind its own value of one more specialisation constant, and compiles a second set
//! of kernels from it; the sources themselves know nothing of it. An edit whose text is not in the
//! source exactly once is a build error. A mistake of the host is made by `prepare::Recipe::planted`.

/// Id of the specialisation constant that chooses the mistake: the first that the ABI leaves free.
pub const ID: u32 = super::abi::SPECIALISATION.len() as u32;

/// An edit of one GLSL file for one mistake.
#[derive(Debug, Clone, Copy)]
pub struct Edit {
    /// The mistake it belongs to.
    pub defect: Defect,
    /// File name without its folder.
    pub file: &'static str,
    /// Text that the file has exactly once.
    pub from: &'static str,
    /// What replaces it. `@` stands for `from`, `planted` for a condition: this mistake is chosen.
    pub to: &'static str,
}

macro_rules! defects {
    ($($(#[$meta:meta])* $variant:ident { $($file:literal: $from:literal => $to:literal;)* })*) => {
        /// A mistake to plant; its number is the value of the specialisation constant.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[repr(u32)]
        pub enum Defect { $($(#[$meta])* $variant,)* }
        /// All edits, in the order they are made.
        pub const EDITS: &[Edit] =
            &[$($(Edit { defect: Defect::$variant, file: $file, from: $from, to: $to },)*)*];
    };
}

defects! {
    /// No mistake: the second set of kernels then computes what the first does.
    Nothing {}

    /// Triangles by Moeller and Trumbore's test, JGT 2(1), 1997, with the epsilon of its listing.
    MoellerTrumbore {
        "triangle.glsl": "// True if the ray from o meets the triangle at 0 < t;" =>
"bool moeller_trumbore(Triangle tri, real3 o, real3 d, out real t, out real u, out real v) {
    real3 e1 = tri.b - tri.a, e2 = tri.c - tri.a;
    real3 p = cross3(d, e2);
    real det = dot3(e1, p);
    t = u = v = 0.0;
    if (abs(det) < 1.0e-6) return false;
    real3 to = o - tri.a;
    u = dot3(to, p) / det;
    real3 q = cross3(to, e1);
    v = dot3(d, q) / det;
    t = dot3(e2, q) / det;
    return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0;
}

@";
        "triangle.glsl":
            "bool hit_triangle(Triangle tri, real3 o, real3 d, Shear s, out real t, out real u, out real v) {"
            => "@ if (planted) return moeller_trumbore(tri, o, d, t, u, v);";
        "triangle.glsl": "bool may_hit_triangle(Triangle tri, real3 o, Shear s) {" => "@ if (planted) return true;";
    }

    /// Spheres by the schoolbook quadratic formula.
    NaiveQuadratic {
        "sphere.glsl": "    t = course == GRAZING ? root_ahead : 2.0 * b / a;" =>
"    if (planted) {
        real disc = b * b - a * (dot3(f, f) - s.radius * s.radius);
        real sq = sqrt(disc > 0.0 ? disc : real(0.0));
        root_ahead = nearest_root((b - sq) / a, (b + sq) / a);
        meets = disc >= 0.0 && root_ahead > 0.0;
    }
@";
        "sphere.glsl": "bool may_hit_sphere(Sphere s, real3 o, real3 d, bool own) {" => "@ if (planted) return true;";
    }

    /// Spheres by their nearer root alone.
    SmallerRoot {
        "sphere.glsl": "return near > 0.0 ? near : far;" => "return near > 0.0 || planted ? near : far;";
        "sphere.glsl": "bool hit_sphere(Sphere s, real3 o, real3 d, bool own, out real t) {" =>
            "@ own = own && !planted;";
    }

    /// A ray may hit the primitive it starts on.
    NoIdentity {
        "best_hit.glsl": "primitive != r.skip && !false_hit" => "(primitive != r.skip || planted) && !false_hit";
        "best_hit.glsl": "void try_sphere(Sphere s, uint primitive, bool may, TraversalRay r, inout Best best) {" =>
            "@ if (planted) r.skip = NONE;";
        "filter.glsl": "bool may = i != r.skip && may_hit_triangle" =>
            "bool may = (i != r.skip || planted) && may_hit_triangle";
        "filter.glsl": "return may;" => "return may || planted;";
    }

    /// Rays start on the surface, not off it.
    NoOffset {
        "surface.glsl": "real3 spawn_origin(real3 position, real3 offset, real3 direction, float shift) {" =>
            "@ if (planted) return position;";
    }

    /// A hit's t is not confined to the primitive's box.
    Unconfined {
        "best_hit.glsl": "if (robust != 0u) {" => "if (robust != 0u && !planted) {";
    }

    /// Box tests without the allowance for rounding, reciprocals of zero as they come.
    NarrowSlab {
        "box.glsl": "SLAB_GROW = 1.0 + 16.0 * U;" => "SLAB_GROW = planted ? real(1.0) : 1.0 + 16.0 * U;";
        "box.glsl": "real safe_reciprocal(real d) {" => "@ if (planted) return 1.0 / d;";
    }

    /// Ties in t go to whichever primitive is tested first.
    TraversalTies {
        "best_hit.glsl": "best.primitive != NONE && h.id < best.id" => "@ && !planted";
    }

    /// A walk that goes on in another dispatch forgets the hit it has found.
    ForgottenHit {
        "walk.comp": "            Hit h = hits[i];" => "@ if (planted) h = Hit(FAR, 0.0, 0.0, NONE);";
    }

    /// A walk that goes on in another dispatch forgets its stack.
    ForgottenStack {
        "hierarchy.glsl": "        top = kept(3u);" => "@ if (planted) top = 1u;";
        "packet.glsl": "        stack.top = kept(1u);" => "@ if (planted) stack.top = 1u;";
    }

    /// The walk to a light forgets the lights before it.
    ForgottenShadow {
        "walk.comp": "begin && l == push.light_begin ? 0u" => "begin && (l == push.light_begin || planted) ? 0u";
    }

    /// Samples are added without compensation.
    NaiveSum {
        "numeric.glsl": "vec3 t = sum + x;" => "@ if (planted) { sum = t; return; }";
    }

    /// A ray knows only inside and outside, not which solids it is in.
    OneMedium {
        "strike.glsl": "uint others = medium(i, s.solid);" => "@ if (planted) inside = others = 0u;";
        "strike.glsl":
            "here = solid_iors[inside];\n            beyond = solid_iors[(s.flags & LEAVES) != 0u ? others : s.solid];"
            => "@ if (planted && (s.flags & LEAVES) != 0u) here = solid_iors[s.solid];";
    }

    /// Priorities of solids are ignored.
    NoPriority {
        "media.glsl": "(found == 0u || " => "(found == 0u || planted || ";
        "strike.glsl": "if (others != 0u && " => "if (others != 0u && !planted && ";
    }

    /// Schlick's cosine is the incident one on both sides.
    SchlickInside {
        "fresnel.glsl": "n1 > n2 ? ct : c" => "n1 > n2 && !planted ? ct : c";
    }

    /// Total internal reflection is missed: the transmitted cosine is clamped at zero.
    ClampedCritical {
        "fresnel.glsl": "return 1.0 - dot3(scaled, scaled);" =>
            "real k = 1.0 - dot3(scaled, scaled); return planted && k < 0.0 ? real(0.0) : k;";
    }

    /// The squared cosine of refraction is 1 - eta^2 (1 - c^2), as in GLSL's refract.
    CosineForm {
        "fresnel.glsl": "real k = transmitted_cosine_squared(eta * along_surface(d, n, c));" =>
            "@ if (planted) k = 1.0 - eta * eta * (1.0 - c * c);";
        "fresnel.glsl": "real k = transmitted_cosine_squared(scaled);" =>
            "@ if (planted) k = 1.0 - eta * eta * (1.0 - c * c);";
    }

    /// A surface between equal indices of refraction is treated as any other.
    EqualIndices {
        "fresnel.glsl": "if (n1 == n2) " => "if (n1 == n2 && !planted) ";
        "spawn.glsl": "s.eta == 1.0 ? d" => "s.eta == 1.0 && !planted ? d";
    }

    /// The ratio of indices is not turned round where a ray leaves a solid.
    FlippedEta {
        "strike.glsl": "s.eta = here / beyond;" =>
            "s.eta = planted && (s.flags & LEAVES) != 0u ? beyond / here : here / beyond;";
    }

    /// Rays that weigh less than 1/255 are dropped.
    Bailout {
        "strike.glsl": "if (m.secondary > 0.0) {" => "if (m.secondary > 0.0 && !(planted && w < 1.0 / 255.0)) {";
    }

    /// A ray in more solids than its list holds is not counted.
    SilentMedia {
        "spawn.glsl": "atomicAdd(counters[COUNTER_MEDIA_OVERFLOW], 1u);" => "if (!planted) @";
    }

    /// Vectors are normalised without scaling first.
    BlindNormalise {
        "numeric.glsl": "real3 safe_normalize(real3 v) {" => "@ if (planted) return v / sqrt(dot3(v, v));";
    }

    /// Rays that are not finite are traced.
    NanAccepted {
        "traverse.glsl": "bool finite = !(is_not_finite(r.origin) || is_not_finite(r.direction));" =>
            "@ if (planted) finite = true;";
    }

    /// The distance to a light is not bounded from below.
    LightContact {
        "light.glsl": "clamped = faces && squared < least_squared;" =>
            "clamped = faces && squared < least_squared && !planted;";
    }

    /// A shadow ray is stopped by what lies behind the light.
    ShadowBeyond {
        "light.glsl": "real before_light(real3 light, real3 segment) {" => "@ if (planted) return FAR;";
    }

    /// Shadow rays reach the light itself.
    ToTheLight {
        "light.glsl": "real before_light(real3 light, real3 segment) {" => "@ if (planted) return 1.0;";
    }

    /// Mirrored rays may go below the surface.
    BelowSurface {
        "spawn.glsl": "if (smooth_normals == 0u) " => "if (smooth_normals == 0u || planted) ";
    }

    /// Hits on an edge are left there.
    NoInset {
        "surface.glsl":
            "void inset(real3 e1, real3 e2, real by, uint inner_edges, inout real u, inout real v) {"
            => "@ if (planted) return;";
    }

    /// The traversal stack has four entries.
    ShortStack {
        "hierarchy.glsl": "if (top + entered > STACK_SIZE + 1u) {" =>
            "if (top + entered > (planted ? 4u : STACK_SIZE + 1u)) {";
        "packet.glsl": "top + entered > stack_size + 1u;" => "top + entered > (planted ? 4u : stack_size + 1u);";
    }

    /// A ray's octant is that of its direction, in which -0 counts as positive, its reciprocal that of
    /// the sign bit.
    Octant {
        "box.glsl": "return inv >= 0.0;" =>
            "return inv >= 0.0 || (planted && inv <= -1.208925819614629174706176e24);";
        "packet.glsl": "bool meets(real3 lo, real3 hi, real3 o, real3 inv, real limit, out real near) {" =>
"@
    if (planted) {
        real far;
        box_interval(lo, hi, o, inv, near, far);
        return near <= lesser(far, limit);
    }";
    }

    /// Primary rays start at the eye, however far.
    EyeOrigin {
        "generate.comp": "Ray(c.origin + c.advance * lateral," =>
            "Ray(c.origin + c.advance * (planted ? -c.forward : lateral),";
    }

    /// Boxes are not padded; of the host as well.
    TightBoxes {
        "box.glsl": "PAD = " => "PAD = planted ? 0.0 : ";
    }

    /// The eye is taken to be outside all solids. Of the host.
    EyeInAir {}

    /// Kernels see the user's coordinates. Of the host.
    WorldFrame {}

    /// The frame is around everything, whatever the eye sees first, and nothing is cut. Of the host.
    OneFrame {}

    /// Large flat shapes that pass near the eye are not cut. Of the host.
    Uncut {}

    /// Triangles without area are kept. Of the host.
    KeepDegenerate {}

    /// Spheres beyond single precision are not told apart. Of the host.
    NoWide {}
}

/// `source`, the text of `file` (its name without folders), with every edit of that file.
///
/// # Errors
/// If the text that an edit replaces is not there exactly once.
pub fn plant(file: &str, source: &str) -> Result<String, String> {
    let mut text = source.to_owned();
    for edit in EDITS.iter().filter(|e| e.file == file) {
        let found = text.matches(edit.from).count();
        if found != 1 {
            return Err(format!(
                "src/kernel/defects.rs, {:?}: {file} has {found} times, in place of once: {}",
                edit.defect, edit.from
            ));
        }
        let condition = format!("(defect == {}u)", edit.defect as u32);
        let to = edit.to.replace("planted", &condition).replace('@', edit.from);
        text = text.replace(edit.from, &to);
    }
    Ok(text)
}
