//! Planted defects: each is a mistake that some renderer makes, put back on purpose, so that a test
//! can show that the case which guards against it fails. Never on in a render.

use crate::kernel::abi;

macro_rules! defects {
    ($($(#[$meta:meta])* $variant:ident = $constant:ident;)*) => {
        /// A mistake to put back. The numbers are the kernels' (`abi`).
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[repr(u32)]
        pub enum Defect { $($(#[$meta])* $variant = abi::$constant,)* }
        impl Defect {
            /// All of them.
            pub const ALL: &[Defect] = &[$(Defect::$variant,)*];
        }
    };
}

defects! {
    /// Triangles by Moeller and Trumbore's test instead of the watertight one.
    MoellerTrumbore = DEFECT_MOELLER_TRUMBORE;
    /// Spheres by the schoolbook quadratic formula.
    NaiveQuadratic = DEFECT_NAIVE_QUADRATIC;
    /// Spheres by their nearer root alone.
    SmallerRoot = DEFECT_SMALLER_ROOT;
    /// A ray may hit the primitive it starts on.
    NoIdentity = DEFECT_NO_IDENTITY;
    /// Rays start on the surface, not off it.
    NoOffset = DEFECT_NO_OFFSET;
    /// A hit's t is not confined to the primitive's box.
    Unconfined = DEFECT_UNCONFINED;
    /// Box tests without the allowance for rounding, reciprocals of zero as they come.
    NarrowSlab = DEFECT_NARROW_SLAB;
    /// Ties in t go to whichever primitive is tested first.
    TraversalTies = DEFECT_TRAVERSAL_TIES;
    /// Samples are added without compensation.
    NaiveSum = DEFECT_NAIVE_SUM;
    /// A ray knows only inside and outside, not which solids it is in.
    OneMedium = DEFECT_ONE_MEDIUM;
    /// Priorities of solids are ignored.
    NoPriority = DEFECT_NO_PRIORITY;
    /// Schlick's cosine is the incident one on both sides.
    SchlickInside = DEFECT_SCHLICK_INSIDE;
    /// Total internal reflection is missed: the transmitted cosine is clamped at zero.
    ClampedCritical = DEFECT_CLAMPED_CRITICAL;
    /// Vectors are normalised without scaling first.
    BlindNormalise = DEFECT_BLIND_NORMALISE;
    /// Rays that are not finite are traced.
    NanAccepted = DEFECT_NAN_ACCEPTED;
    /// The distance to a light is not bounded from below.
    LightContact = DEFECT_LIGHT_CONTACT;
    /// Mirrored rays may go below the surface.
    BelowSurface = DEFECT_BELOW_SURFACE;
    /// Kernels see the user's coordinates.
    WorldFrame = DEFECT_WORLD_FRAME;
    /// Triangles without area are kept.
    KeepDegenerate = DEFECT_KEEP_DEGENERATE;
    /// The eye is taken to be outside all solids.
    EyeInAir = DEFECT_EYE_IN_AIR;
    /// Spheres beyond single precision are not told apart.
    NoWide = DEFECT_NO_WIDE;
    /// Primary rays start at the eye, however far.
    EyeOrigin = DEFECT_EYE_ORIGIN;
    /// The traversal stack has four entries.
    ShortStack = DEFECT_SHORT_STACK;
    /// Boxes of the hierarchy are not padded.
    TightBoxes = DEFECT_HOST_TINY_BOX;
    /// A ray's octant is that of its direction, in which -0 counts as positive, its reciprocal that of
    /// the sign bit.
    Octant = DEFECT_OCTANT;
    /// A surface between equal indices of refraction is treated as any other.
    EqualIndices = DEFECT_EQUAL_INDICES;
    /// The ratio of indices is not turned round where a ray leaves a solid.
    FlippedEta = DEFECT_FLIPPED_ETA;
    /// Rays that weigh less than 1/255 are dropped.
    Bailout = DEFECT_BAILOUT;
    /// A ray in more solids than its list holds is not counted.
    SilentMedia = DEFECT_SILENT_MEDIA;
    /// A shadow ray is stopped by what lies behind the light.
    ShadowBeyond = DEFECT_SHADOW_BEYOND;
    /// The squared cosine of refraction is 1 - eta^2 (1 - c^2), as in GLSL's refract.
    CosineForm = DEFECT_COSINE_FORM;
    /// Secondary rays start 0.1 of the user's units along their way and may hit what they left.
    FixedOrigin = DEFECT_FIXED_ORIGIN;
    /// Hits on an edge are left there.
    NoInset = DEFECT_NO_INSET;
    /// Shadow rays reach the light itself.
    ToTheLight = DEFECT_TO_THE_LIGHT;
}
