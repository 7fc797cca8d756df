//! The encoders, one manual each: what its user reads is what stands here. And a device after no manual at all.

pub mod lika_xac77;
pub mod plain;
