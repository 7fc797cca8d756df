//! The GSD files of the reference devices, which the binary carries.

include!(concat!(env!("OUT_DIR"), "/embedded_gsd.rs"));

/// The GSD files of the reference devices: `<manual>/<file>` and the text.
pub fn embedded() -> &'static [(&'static str, &'static str)] {
    EMBEDDED_GSD
}
