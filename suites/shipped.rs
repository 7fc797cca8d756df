//! What the build script hands to the library: the texts, and the manuals compiled from them.

use serde::{Deserialize, Serialize};

/// The files of this folder by their path in it, in its order, and what was made of them.
#[derive(Debug, Default, Deserialize, Serialize)]
pub(crate) struct Shipped<'a> {
    /// The suites.
    #[serde(borrow)]
    pub(crate) suites: Vec<(&'a str, &'a str)>,
    /// The GSDML files.
    #[serde(borrow)]
    pub(crate) gsdml: Vec<(&'a str, &'a str)>,
    /// The GSD files.
    #[serde(borrow)]
    pub(crate) gsd: Vec<(&'a str, &'a str)>,
    /// The manuals by name, as `suite::compiled` writes them.
    #[serde(borrow)]
    pub(crate) manuals: Vec<(&'a str, &'a [u8])>,
}
