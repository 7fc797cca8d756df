//! The encoders, one manual each: what its user reads is what stands here.

pub mod lika_xac77;
