//! A comparison as an HTML page.

use super::{ChangeKind, DeviceDiff, RunDiff};
use crate::page::{Chapter, HtmlPage, PageTable, Tone, html};

impl RunDiff {
    /// The comparison as one HTML file.
    pub fn html(&self) -> String {
        let tone = if self.is_regression() { Tone::Bad } else { Tone::Good };
        let mut chapters: Vec<Chapter> = self.devices.iter().map(chapter).collect();
        let gone = self.gone.iter().map(|device| ("only in the older run".to_owned(), device.clone()));
        let added = self.added.iter().map(|device| ("only in the newer run".to_owned(), device.clone()));
        let notes = self.notes.iter().map(|note| ("note".to_owned(), note.clone()));
        let facts: Vec<(String, String)> = gone.chain(added).chain(notes).collect();
        if !facts.is_empty() {
            chapters.push(Chapter { heading: "Both runs".to_owned(), facts, ..Chapter::default() });
        }
        html(&HtmlPage {
            title: "encspec diff".to_owned(),
            verdict: (tone, self.sentence()),
            chapters,
            ..HtmlPage::default()
        })
    }
}

fn chapter(of: &DeviceDiff) -> Chapter {
    let mut facts: Vec<(String, String)> = Vec::new();
    for (name, before, after) in &of.facts {
        facts.push(((*name).to_owned(), format!("{before} → {after}")));
    }
    facts.extend(of.new_errors.iter().map(|error| ("new error".to_owned(), error.clone())));
    if of.left_out > 0 {
        facts.push(("not compared".to_owned(), format!("{} results that a filter left out", of.left_out)));
    }
    let columns = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    let mut tables = Vec::new();
    for kind in ChangeKind::ALL {
        let rows: Vec<(Tone, Vec<String>)> = of
            .changes
            .iter()
            .filter(|change| change.kind == kind)
            .map(|change| {
                let cell = |of: &Option<String>| of.clone().unwrap_or_else(|| "not there".to_owned());
                let cells =
                    vec![change.id.clone(), change.covers.join(", "), cell(&change.before), cell(&change.after)];
                (tone(kind), cells)
            })
            .collect();
        if !rows.is_empty() {
            let heading = format!("{} ({})", kind.heading(), rows.len());
            tables.push(PageTable { heading, columns: columns(&["result", "requirements", "before", "after"]), rows });
        }
    }
    if !of.requirements.is_empty() {
        let row = |(id, before, after): &(String, _, _)| {
            (Tone::Plain, vec![id.clone(), format!("{before}"), format!("{after}")])
        };
        tables.push(PageTable {
            heading: format!("requirements ({})", of.requirements.len()),
            columns: columns(&["requirement", "before", "after"]),
            rows: of.requirements.iter().map(row).collect(),
        });
    }
    Chapter { heading: of.device.clone(), facts, tables, ..Chapter::default() }
}

fn tone(kind: ChangeKind) -> Tone {
    match kind {
        ChangeKind::NewlyFails | ChangeKind::NoLongerTested => Tone::Bad,
        ChangeKind::NewlyPasses => Tone::Good,
        ChangeKind::OtherVerdict | ChangeKind::OtherReason | ChangeKind::OtherReading | ChangeKind::Slower => {
            Tone::Open
        }
    }
}
