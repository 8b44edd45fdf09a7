//! Struct declarations for both languages: the Rust types, the GLSL text, and the offsets to check.

#[derive(Debug, Clone, Copy)]
pub struct GpuStruct {
    /// Name on both sides.
    pub name: &'static str,
    /// GLSL declaration.
    pub glsl: &'static str,
    /// Bytes.
    pub size: usize,
    /// Field names and their byte offsets.
    pub fields: &'static [(&'static str, usize)],
}

/// `first` and `second` in one array.
pub(super) const fn concat<const COUNT: usize>(
    first: &[GpuStruct],
    second: &[GpuStruct],
) -> [GpuStruct; COUNT] {
    let mut all = [first[0]; COUNT];
    let mut i = 1;
    while i < COUNT {
        all[i] = if i < first.len() { first[i] } else { second[i - first.len()] };
        i += 1;
    }
    all
}

macro_rules! rust_type {
    (real, $real:ty) => {
        $real
    };
    (real3, $real:ty) => {
        [$real; 3]
    };
    (vec3, $real:ty) => {
        [f32; 3]
    };
    (float, $real:ty) => {
        f32
    };
    (uint, $real:ty) => {
        u32
    };
}

macro_rules! to_single {
    (real, $value:expr) => {
        $value as f32
    };
    (real3, $value:expr) => {
        $value.map(|x| x as f32)
    };
    ($other:ident, $value:expr) => {
        $value
    };
}

macro_rules! layouts {
    ($table:ident; $($name:ident { $($field:ident: $ty:ident,)* })*) => {
        /// Layouts of the structs above, in declaration order.
        pub(in super::super) const $table: &[super::GpuStruct] = &[$(super::GpuStruct {
            name: stringify!($name),
            glsl: concat!("struct ", stringify!($name), " {\n",
                $("    ", stringify!($ty), " ", stringify!($field), ";\n",)* "};\n"),
            size: size_of::<$name>(),
            fields: &[$((stringify!($field), core::mem::offset_of!($name, $field)),)*],
        },)*];
    };
}

/// Declares structs that the host fills in f64 and rounds to f32 once. Their `real` fields are f32 in
/// `single` and f64 in `double`.
macro_rules! host_structs {
    ($($(#[$meta:meta])* struct $name:ident { $($(#[$field_meta:meta])* $field:ident: $ty:ident,)* })*) => {
        /// Structs of the single-precision kernels.
        pub mod single {
            use bytemuck::{Pod, Zeroable};
            $(
                $(#[$meta])*
                #[repr(C)]
                #[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
                pub struct $name { $($(#[$field_meta])* pub $field: rust_type!($ty, f32),)* }
                impl From<&super::double::$name> for $name {
                    fn from(wide: &super::double::$name) -> Self {
                        $name { $($field: to_single!($ty, wide.$field),)* }
                    }
                }
            )*
            layouts! { HOST; $($name { $($field: $ty,)* })* }
        }
        /// Structs of the double-precision kernels.
        pub mod double {
            use bytemuck::{Pod, Zeroable};
            $(
                $(#[$meta])*
                #[repr(C)]
                #[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
                pub struct $name { $($(#[$field_meta])* pub $field: rust_type!($ty, f64),)* }
            )*
            layouts! { HOST; $($name { $($field: $ty,)* })* }
        }
    };
}

/// Declares structs that exist only on the device. Their `real` fields are f32 in `single` and f64 in
/// `double`.
macro_rules! device_structs {
    ($($(#[$meta:meta])* struct $name:ident { $($(#[$field_meta:meta])* $field:ident: $ty:ident,)* })*) => {
        /// Structs of the single-precision kernels.
        pub mod single {
            use bytemuck::{Pod, Zeroable};
            $(
                $(#[$meta])*
                #[repr(C)]
                #[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
                pub struct $name { $($(#[$field_meta])* pub $field: rust_type!($ty, f32),)* }
            )*
            layouts! { DEVICE; $($name { $($field: $ty,)* })* }
        }
        /// Structs of the double-precision kernels.
        pub mod double {
            $(
                $(#[$meta])*
                #[repr(C)]
                #[derive(Debug, Clone, Copy, Default, PartialEq)]
                pub struct $name { $($(#[$field_meta])* pub $field: rust_type!($ty, f64),)* }
            )*
            layouts! { DEVICE; $($name { $($field: $ty,)* })* }
        }
    };
}
