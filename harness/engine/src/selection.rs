//! Which cases and rules a run selects: by their ids, by what they cover, and by what was not green in an earlier run.

use std::collections::BTreeSet;
use suite::model::{Level, Manual, Requirement, SuiteRule, SuiteVariant, Trial};

/// What one filter selects.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Selector {
    /// Ids that contain this text.
    Part(String),
    /// The case or rule of this id, with or without the manual in front.
    Whole(String),
    /// What covers the requirement of this id, or one whose id begins with it.
    Requirement(String),
    /// What covers a requirement that cites this clause, and ids that contain it.
    Clause(String),
    /// What covers a requirement of this level.
    Level(Level),
}

/// The cases and rules that the filters of a command line select; all of them by default.
///
/// What any filter selects is included, what a filter after `!` selects is excluded. The name of a manual narrows what the other
/// filters include.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    manuals: Vec<String>,
    included: Vec<(String, Selector)>,
    excluded: Vec<(String, Selector)>,
    not_green: Option<BTreeSet<NotGreen>>,
    is_only_own: bool,
}

/// A case or rule that was not green in an earlier run.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct NotGreen {
    /// Its whole id, with the manual in front.
    pub id: String,
    /// The variant of the manual on which it ran.
    pub variant: String,
}

/// Ids that contain this text.
impl From<&str> for Selection {
    fn from(text: &str) -> Selection {
        Selection { included: vec![(text.to_owned(), Selector::Part(text.to_owned()))], ..Selection::default() }
    }
}

impl Selection {
    /// The selection of these filters; with `exact` each is a whole id. The requirements and names are those of `manuals`.
    pub fn of(filters: &[String], exact: bool, manuals: &[Manual]) -> Selection {
        let mut selection = Selection::default();
        for filter in filters {
            let (text, list) = match filter.strip_prefix('!') {
                Some(text) => (text, &mut selection.excluded),
                None if !exact && manuals.iter().any(|manual| manual.device.name == *filter) => {
                    selection.manuals.push(filter.clone());
                    continue;
                }
                None => (filter.as_str(), &mut selection.included),
            };
            let selector = if exact { Selector::Whole(text.to_owned()) } else { selector(text, manuals) };
            list.push((filter.clone(), selector));
        }
        selection
    }

    /// The same, of what was not green in an earlier run.
    #[must_use]
    pub fn not_green(self, before: BTreeSet<NotGreen>) -> Selection {
        Selection { not_green: Some(before), ..self }
    }

    /// The cases and rules of each manual alone, without those of the suites that it uses too.
    pub fn own() -> Selection {
        Selection { is_only_own: true, ..Selection::default() }
    }

    /// Whether everything is selected.
    pub fn is_all(&self) -> bool {
        *self == Selection::default()
    }

    /// Whether a trial is selected.
    pub fn trial(&self, manual: &Manual, variant: &SuiteVariant, trial: &Trial) -> bool {
        self.has(manual, variant, &trial.id, &covered(trial))
    }

    /// Whether a rule is selected.
    pub fn rule(&self, manual: &Manual, variant: &SuiteVariant, rule: &SuiteRule) -> bool {
        self.has(manual, variant, &rule.id, &rule.covers)
    }

    /// Whether any trial or rule of a variant is selected.
    pub fn selects_in(&self, manual: &Manual, variant: &SuiteVariant) -> bool {
        variant.trials.iter().any(|of| self.trial(manual, variant, of))
            || variant.rules.iter().any(|of| self.rule(manual, variant, of))
    }

    /// Whether a rule is left out by a filter after `!`: then it is not even reported where it breaks.
    pub fn excludes(&self, manual: &Manual, rule: &SuiteRule) -> bool {
        self.excluded.iter().any(|(_, selector)| selector.has(manual, &whole_id(manual, &rule.id), &rule.covers))
    }

    /// Whether a rule of this variant was broken before: then every trial runs again, since a trial that passed may have broken it.
    pub fn has_broken_rule(&self, manual: &Manual, variant: &SuiteVariant) -> bool {
        self.not_green.is_some() && variant.rules.iter().any(|rule| self.rule(manual, variant, rule))
    }

    /// The filters that select nothing of these manuals and variants, as they were written.
    pub fn unmatched<'s>(&'s self, selected: &[(&Manual, &SuiteVariant)]) -> Vec<&'s str> {
        let matches = |selector: &Selector| {
            selected.iter().any(|(manual, variant)| {
                variant.trials.iter().any(|of| selector.has(manual, &whole_id(manual, &of.id), &covered(of)))
                    || variant.rules.iter().any(|of| selector.has(manual, &whole_id(manual, &of.id), &of.covers))
            })
        };
        let manuals =
            self.manuals.iter().filter(|name| selected.iter().all(|(manual, _)| manual.device.name != **name));
        let selectors = self.included.iter().chain(&self.excluded).filter(|(_, selector)| !matches(selector));
        manuals.map(String::as_str).chain(selectors.map(|(filter, _)| filter.as_str())).collect()
    }

    fn has(&self, manual: &Manual, variant: &SuiteVariant, id: &str, covers: &[usize]) -> bool {
        let full = whole_id(manual, id);
        let has = |list: &[(String, Selector)]| list.iter().any(|(_, selector)| selector.has(manual, &full, covers));
        let was_not_green = |before: &BTreeSet<NotGreen>| {
            before.contains(&NotGreen { id: full.clone(), variant: variant.name.clone() })
        };
        (self.manuals.is_empty() || self.manuals.contains(&manual.device.name))
            && (self.included.is_empty() || has(&self.included))
            && !has(&self.excluded)
            && self.not_green.as_ref().is_none_or(was_not_green)
            && !(self.is_only_own && manual.suite_of(id).is_some())
    }
}

/// The id of a case or rule with the manual in front.
fn whole_id(manual: &Manual, id: &str) -> String {
    format!("{}/{id}", manual.device.name)
}

/// The requirements that a trial covers, as a whole and by its checks.
fn covered(trial: &Trial) -> Vec<usize> {
    [&trial.covers[..], &trial.outline.checks[..]].concat()
}

/// What a filter means that is no whole id.
fn selector(text: &str, manuals: &[Manual]) -> Selector {
    let level = [("must", Level::Must), ("should", Level::Should), ("info", Level::Info)];
    if let Some((_, level)) = level.into_iter().find(|(word, _)| *word == text) {
        return Selector::Level(level);
    }
    let requirements = || manuals.iter().flat_map(|manual| &manual.requirements);
    if requirements().any(|of| is_or_begins(&of.id, text)) {
        return Selector::Requirement(text.to_owned());
    }
    let is_dotted = text.split('.').count() > 1 && text.split('.').all(|part| part.parse::<u16>().is_ok());
    match (is_dotted || text.contains(' ')) && requirements().any(|of| has_clause(&of.cites, text)) {
        true => Selector::Clause(text.to_owned()),
        false => Selector::Part(text.to_owned()),
    }
}

impl Selector {
    fn has(&self, manual: &Manual, full: &str, covers: &[usize]) -> bool {
        let covers = |holds: &dyn Fn(&Requirement) -> bool| {
            covers.iter().filter_map(|&index| manual.requirements.get(index)).any(holds)
        };
        match self {
            Selector::Part(text) => full.contains(text.as_str()),
            Selector::Whole(text) => full == text || full.split_once('/').is_some_and(|(_, id)| id == text),
            Selector::Requirement(id) => covers(&|of| is_or_begins(&of.id, id)),
            Selector::Clause(text) => full.contains(text.as_str()) || covers(&|of| has_clause(&of.cites, text)),
            Selector::Level(level) => covers(&|of| of.level == *level),
        }
    }
}

/// Whether a requirement has this id in any case of letters, or an id that begins with it and goes on with `-`.
fn is_or_begins(id: &str, text: &str) -> bool {
    id.eq_ignore_ascii_case(text) || id.strip_prefix(text).is_some_and(|rest| !text.is_empty() && rest.starts_with('-'))
}

/// Whether a text cites this clause or a part of it: `16.3` is in `section 16.3.1`, and not in `section 16.31`.
fn has_clause(cites: &str, text: &str) -> bool {
    cites.match_indices(text).any(|(at, _)| {
        let before = cites[..at].chars().next_back();
        let after = cites[at + text.len()..].chars().next();
        !before.is_some_and(|letter| letter.is_alphanumeric() || letter == '.')
            && !after.is_some_and(char::is_alphanumeric)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clause_is_found_by_whole_numbers() {
        assert!(has_clause("section 16.3, diagram (p. 149)", "16.3"));
        assert!(has_clause("section 16.3.1", "section 16.3"));
        assert!(has_clause("section 16.3, diagram (p. 149)", "p. 149"));
        assert!(!has_clause("section 16.31", "16.3"));
        assert!(!has_clause("section 116.3", "16.3"));
        assert!(!has_clause("section 2.16.3", "16.3"));
    }

    #[test]
    fn an_id_of_a_requirement_may_end_at_a_hyphen() {
        assert!(is_or_begins("XAC77-PRK-004", "xac77-prk-004"));
        assert!(is_or_begins("XAC77-PRK-004", "XAC77-PRK"));
        assert!(!is_or_begins("XAC77-PRK-004", "XAC77-PR"));
        assert!(!is_or_begins("XAC77-PRK-004", ""));
    }
}
