//! Tables: the rows of a case, and the bugs it catches.

use super::device_yaml::{labels, named};
use super::entry::TopicEntry;
use super::error::{Mistake, Read, every};
use super::frame::Column;
use super::names::Names;
use super::step::LoadContext;
use super::taken;
use super::topic_keys::{case, row};
use super::yaml::Node;

/// Whether a key of a row is no column.
pub(super) fn is_reserved(key: &str) -> bool {
    row::KEYS.key(key).is_some()
}

/// A row of a table, or the only trial of a case without one.
pub(super) struct Row<'n> {
    pub at: Option<&'n Node>,
    pub label: Option<String>,
    pub columns: Vec<Column>,
    pub covers: Option<&'n Node>,
    pub catches: Option<&'n Node>,
    pub variants: Option<&'n Node>,
}

pub(super) fn rows<'n>(entry: &TopicEntry<'n>, names: &Names<'_>, give: &[Column]) -> Read<Vec<Row<'n>>> {
    let Some(node) = entry.keyed.get(&case::with) else {
        return Ok(vec![Row {
            at: None,
            label: None,
            columns: Vec::new(),
            covers: None,
            catches: None,
            variants: None,
        }]);
    };
    let given = entry.shared.as_ref().and_then(|shared| shared.rows);
    let mut items: Vec<&'n Node> = Vec::new();
    match (node.mapping(), &entry.shared, given) {
        (Some(_), None, _) => {
            return Err(node
                .wrong("a table is a list of rows here")
                .help("only a case of a common suite leaves its rows to the manual"));
        }
        (Some(_), Some(shared), None) => {
            let example: Vec<&str> = taken::columns(node)?.iter().map(|(name, _)| *name).collect();
            return Err(shared.at.wrong(format!("`{}` has to be given its rows", entry.id)).help(format!(
                "write `rows: {{ {}: [ {{ {}: ... }} ] }}`",
                entry.id,
                example.join(": ..., ")
            )));
        }
        (Some(_), Some(_), Some(_)) => {}
        (None, ..) => items.extend(node.items("with")?),
    }
    if let Some(given) = given {
        items.extend(given.items("rows")?);
    }
    let mut rows: Vec<Row<'n>> = Vec::new();
    for item in items {
        let entries = named(item, "a row")?;
        let mut columns = Vec::new();
        for (name, value) in entries.iter().filter(|(name, _)| !is_reserved(name)) {
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
        let label = match item.get(row::row.name) {
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
            covers: item.get(row::covers.name),
            catches: item.get(row::catches.name),
            variants: item.get(row::variants.name),
        });
    }
    if rows.is_empty() { Err(given.unwrap_or(node).wrong("an empty table")) } else { Ok(rows) }
}

/// The bugs that make a case or rule fail, or one `row` of a case: those of the whole case and those of the row.
///
/// A common suite names bugs of all manuals that use it: those of others are passed over, and one at least has to be left for the
/// case or one of its rows. A manual without a reference device lists no bugs, and nothing is asked of it. Nor is anything asked of a suite
/// that a manual uses too: that its cases fail is proven where it stands.
pub(super) fn catches<'n>(
    entry: &TopicEntry<'n>,
    row: Option<(&Row<'n>, &[Row<'n>])>,
    ground: &LoadContext<'_>,
    names: &Names<'_>,
) -> Read<Vec<String>> {
    if ground.is_generic {
        return Ok(Vec::new());
    }
    let mut list: Vec<String> = Vec::new();
    let mut passed_over = false;
    let added = entry.shared.as_ref().and_then(|shared| shared.catches);
    let of_row = row.and_then(|(row, _)| row.catches);
    // The rows of a common case may be the manual's own.
    let is_given = entry.shared.as_ref().is_some_and(|shared| shared.rows.is_some());
    for (node, is_own) in [(entry.keyed.get(&case::catches), false), (added, true), (of_row, is_given)] {
        let Some(node) = node else { continue };
        let mut bug = |(at, name): (usize, String)| {
            let at = node.sequence().and_then(|items| items.get(at)).unwrap_or(node);
            let own = || ground.bugs.iter().map(|bug| bug.name.as_str());
            if !own().any(|known| known == name) {
                if is_own || entry.shared.is_none() {
                    let unknown = Mistake::unknown(at.spot, "bug", &name, own());
                    return Err(match ground.bugs.is_empty() {
                        true => {
                            unknown.help("this manual lists no bugs: list it in bugs.yaml, or remove it from `catches`")
                        }
                        false => unknown,
                    });
                }
                ground.elsewhere.lists(ground.sources, &name, at)?;
                passed_over = true;
                return Ok(());
            }
            if list.contains(&name) {
                return Err(match is_own {
                    true => at.wrong(format!("the common suite names `{name}` already")),
                    false => at.wrong(format!("`{name}` is named already, for every row")),
                });
            }
            names.mark("bug", &name);
            list.push(name);
            Ok(())
        };
        every(labels(node, "catches")?.into_iter().enumerate().map(&mut bug))?;
    }
    let is_any_row_left = row.is_some_and(|(_, rows)| rows.iter().any(|row| row.catches.is_some()));
    match &entry.shared {
        Some(shared) if passed_over && list.is_empty() && !is_any_row_left && !ground.bugs.is_empty() => Err(shared
            .at
            .wrong(format!("no bug of this manual makes `{}` fail", entry.id))
            .help(format!("name one in this file: `catches: {{ {}: [...] }}`", entry.id))),
        _ => Ok(list),
    }
}
