//! A comparison as text for a terminal and as Markdown.

use super::{ChangeKind, DeviceDiff, ResultChange, RunDiff};
use plain_text::{count, printable};
use std::fmt::Write as _;

/// Upper limit of the results that Markdown lists of one kind; the rest is counted.
const MOST: usize = 50;

impl RunDiff {
    /// The result in one sentence.
    pub fn sentence(&self) -> String {
        let each = ChangeKind::ALL.map(|kind| (self.count(kind), kind)).into_iter().filter(|(number, _)| *number > 0);
        let mut parts: Vec<String> = each.map(|(number, kind)| format!("{number} {}", kind.heading())).collect();
        let errors: usize = self.devices.iter().map(|of| of.new_errors.len()).sum();
        if errors > 0 {
            parts.push(count(errors, "new error", "new errors"));
        }
        if !self.gone.is_empty() {
            parts.push(format!("{} no longer tested", count(self.gone.len(), "device", "devices")));
        }
        parts.extend(self.reasons.iter().map(|reason| printable(reason.trim_end_matches('.'))));
        let same: usize = self.devices.iter().map(|of| of.same).sum();
        parts.push(format!("{same} as before"));
        let word = if self.is_regression() { "Worse" } else { "Not worse" };
        format!("{word}: {}.", parts.join(", "))
    }

    /// The comparison for a terminal.
    pub fn console(&self) -> String {
        let mut out = String::new();
        // Writing into a String cannot fail.
        let _ = self.write_console(&mut out);
        out
    }

    fn write_console(&self, out: &mut String) -> std::fmt::Result {
        for of in &self.devices {
            writeln!(out, "{}", printable(&of.device))?;
            for (name, before, after) in &of.facts {
                writeln!(out, "  {name:<13} {} -> {}", shown(before), shown(after))?;
            }
            for error in &of.new_errors {
                writeln!(out, "  new error     {}", printable(error))?;
            }
            for (kind, changes) in by_kind(of) {
                writeln!(out, "\n  {} ({}):", kind.heading(), count(changes.len(), "result", "results"))?;
                for change in changes {
                    writeln!(out, "    {}", printable(&change.id))?;
                    writeln!(out, "      before  {}", said(change.before.as_deref()))?;
                    writeln!(out, "      after   {}", said(change.after.as_deref()))?;
                }
            }
            if !of.requirements.is_empty() {
                writeln!(out, "\n  requirements ({}):", of.requirements.len())?;
                for (id, before, after) in &of.requirements {
                    writeln!(out, "    {id}: {before} -> {after}")?;
                }
            }
            if of.left_out > 0 {
                let left_out = count(of.left_out, "result", "results");
                writeln!(out, "\n  not compared, since a filter left it out: {left_out} of the older run")?;
            }
            out.push('\n');
        }
        self.others().try_for_each(|line| writeln!(out, "{line}"))?;
        writeln!(out, "{}", self.sentence())
    }

    fn others(&self) -> impl Iterator<Item = String> {
        let gone = self.gone.iter().map(|device| format!("{}: only in the older run", printable(device)));
        let added = self.added.iter().map(|device| format!("{}: only in the newer run", printable(device)));
        gone.chain(added).chain(self.notes.iter().map(|note| printable(note)))
    }

    /// The comparison as Markdown, for instance for a comment on a merge request.
    pub fn markdown(&self) -> String {
        let mut out = format!("**{}**\n", crate::markdown::escaped(&self.sentence()));
        // Writing into a String cannot fail.
        let _ = self.write_markdown(&mut out);
        out
    }

    fn write_markdown(&self, out: &mut String) -> std::fmt::Result {
        let escaped = crate::markdown::escaped;
        for of in &self.devices {
            writeln!(out, "\n## {}\n", escaped(&of.device))?;
            for (name, before, after) in &of.facts {
                writeln!(out, "- {name}: {} → {}", escaped(shown(before)), escaped(shown(after)))?;
            }
            for error in &of.new_errors {
                writeln!(out, "- new error: {}", escaped(error))?;
            }
            for (kind, changes) in by_kind(of) {
                writeln!(
                    out,
                    "\n### {} ({})\n\n| result | before | after |\n| --- | --- | --- |",
                    kind.heading(),
                    changes.len()
                )?;
                for change in changes.iter().take(MOST) {
                    let cell = |of: &Option<String>| escaped(of.as_deref().unwrap_or("not there"));
                    let (before, after) = (cell(&change.before), cell(&change.after));
                    writeln!(out, "| {} | {before} | {after} |", escaped(&change.id))?;
                }
                if changes.len() > MOST {
                    writeln!(out, "\nand {} more", changes.len() - MOST)?;
                }
            }
        }
        for line in self.others() {
            writeln!(out, "\n{}", escaped(&line))?;
        }
        Ok(())
    }
}

fn by_kind(of: &DeviceDiff) -> impl Iterator<Item = (ChangeKind, Vec<&ResultChange>)> {
    let of_kind = |kind| (kind, of.changes.iter().filter(|change| change.kind == kind).collect::<Vec<_>>());
    ChangeKind::ALL.into_iter().map(of_kind).filter(|(_, changes)| !changes.is_empty())
}

fn shown(text: &str) -> &str {
    if text.is_empty() { "none" } else { text }
}

fn said(of: Option<&str>) -> String {
    of.map_or_else(|| "not there".to_owned(), printable)
}
