//! What host and kernels share: structs, constants, buffers, specialisation constants, the compiled kernels.
//! A number that both sides use is written here once.

pub mod abi;
#[cfg(feature = "defects")]
#[doc(hidden)]
pub mod defects;
pub mod spirv;
pub mod table;
