//! What host and kernels share: structs, constants, buffers, specialisation constants, the compiled kernels.
//! A number that both sides use is written here once.

pub mod abi;
pub mod spirv;
pub mod table;
