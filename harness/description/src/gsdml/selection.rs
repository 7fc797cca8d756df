//! Selects the GSDML file that describes a variant best.

use super::{Gsdml, matching, read};

/// Of the GSDML files of a manual, as pairs of name and text, the one that describes `variant`; `None` if there is none.
///
/// The name of an access point decides; a single file describes every variant.
pub fn best_described<'t>(files: impl Iterator<Item = (&'t str, &'t str)>, variant: &str) -> Option<(&'t str, Gsdml)> {
    let files: Vec<(&str, Gsdml)> = files.filter_map(|(name, text)| Some((name, read(text).ok()?))).collect();
    let is_single = files.len() == 1;
    let like = |gsdml: &Gsdml| matching::called_like(gsdml, variant).or(is_single.then_some(0));
    let likest = files.iter().filter_map(|(_, gsdml)| like(gsdml)).max()?;
    files.into_iter().find(|(_, gsdml)| like(gsdml) == Some(likest))
}
