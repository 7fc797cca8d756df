//! Tables: the rows of a case, its variants, the bugs it catches.

use super::case::Entry;
use super::device_yaml::{labels, named};
use super::error::{Mistake, Read};
use super::frame::Column;
use super::keys::Keyed;
use super::names::Names;
use super::step::Ground;
use super::yaml::Node;

/// Keys of a row that are no columns.
const RESERVED: [&str; 3] = ["row", "covers", "variants"];

/// A row of a table, or the only trial of a case without one.
pub(super) struct Row<'n> {
    pub at: Option<&'n Node>,
    pub label: Option<String>,
    pub columns: Vec<Column>,
    pub covers: Option<&'n Node>,
    pub variants: Option<&'n Node>,
}

pub(super) fn rows<'n>(entry: &Entry<'n>, names: &Names<'_>, give: &[Column]) -> Read<Vec<Row<'n>>> {
    let Some(node) = entry.keyed.get("with") else {
        return Ok(vec![Row { at: None, label: None, columns: Vec::new(), covers: None, variants: None }]);
    };
    let mut rows: Vec<Row<'n>> = Vec::new();
    for item in node.items("with")? {
        let entries = named(item, "a row")?;
        let mut columns = Vec::new();
        for (name, value) in entries.iter().filter(|(name, _)| !RESERVED.contains(name)) {
            if names.find(name).is_some() {
                return Err(item
                    .key(name)
                    .wrong(format!("`{name}` is a name of the device"))
                    .help("call the column otherwise"));
            }
            if give.iter().any(|given| given.name == *name) {
                return Err(item
                    .key(name)
                    .wrong(format!("`{name}` is given to the common suite already"))
                    .help("call the column otherwise"));
            }
            columns.push(Column::new(name, (*value).clone()));
        }
        let Some(first) = columns.first() else { return Err(item.wrong("a row without columns")) };
        let label = match item.get("row") {
            Some(row) => row.text("a row's label")?.to_owned(),
            None => first.value.scalar().map_or_else(|| first.value.to_string(), str::to_owned),
        };
        if let Some(row) = rows.first() {
            let same = row.columns.len() == columns.len()
                && row.columns.iter().all(|known| columns.iter().any(|column| column.name == known.name));
            if !same {
                let names: Vec<&str> = row.columns.iter().map(|column| column.name.as_str()).collect();
                return Err(item
                    .wrong("this row has other columns than the first")
                    .help(format!("the columns are {}", names.join(", "))));
            }
        }
        if rows.iter().any(|row| row.label.as_deref() == Some(&label)) {
            return Err(item.wrong(format!("two rows are called `{label}`")).help("give them labels: `row: ...`"));
        }
        rows.push(Row {
            at: Some(item),
            label: Some(label),
            columns,
            covers: item.get("covers"),
            variants: item.get("variants"),
        });
    }
    if rows.is_empty() { Err(node.wrong("an empty table")) } else { Ok(rows) }
}

/// The variants of a list, all without one.
pub(super) fn variants(node: Option<&Node>, names: &Names<'_>) -> Read<Vec<usize>> {
    let known = &names.device().variants;
    let Some(node) = node else { return Ok((0..known.len()).collect()) };
    let list = labels(node, "variants")?;
    let index = |(at, name): (usize, &String)| {
        let at = node.sequence().and_then(|items| items.get(at)).unwrap_or(node);
        let found = known.iter().position(|known| known == name);
        found.ok_or_else(|| Mistake::unknown(at.spot, "variant", name, known.iter().map(String::as_str)))
    };
    list.iter().enumerate().map(index).collect()
}

pub(super) fn catches(keyed: Keyed<'_>, ground: &Ground<'_>, names: &Names<'_>) -> Read<Vec<String>> {
    let Some(node) = keyed.get("catches") else { return Ok(Vec::new()) };
    let list = labels(node, "catches")?;
    for (at, name) in list.iter().enumerate() {
        if !ground.bugs.iter().any(|bug| bug.name == *name) {
            let at = node.sequence().and_then(|items| items.get(at)).unwrap_or(node);
            return Err(Mistake::unknown(at.spot, "bug", name, ground.bugs.iter().map(|bug| bug.name.as_str())));
        }
        names.mark("bug", name);
    }
    Ok(list)
}
