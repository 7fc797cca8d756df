//! The command line of a hook: words and placeholders, without shell syntax.

use plain_text::nearest;

/// The names of placeholders.
const PLACEHOLDERS: [&str; 4] = ["value", "unit", "rpm", "acceleration"];

/// A command line split into words; each word is one argument, whatever value is filled in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CommandLine {
    words: Vec<String>,
}

impl CommandLine {
    /// Splits a line at its spaces; text in `'...'` or `"..."` is one word.
    ///
    /// Fails on an empty line, an open quote, and a `{word}` that is not a placeholder.
    pub fn parse(line: &str) -> Result<CommandLine, String> {
        let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
        for c in line.chars() {
            match (quote, c) {
                (Some(open), c) if c == open => quote = None,
                (None, '\'' | '"') => {
                    quote = Some(c);
                    word.get_or_insert_default();
                }
                (None, c) if c.is_whitespace() => words.extend(word.take()),
                (_, c) => word.get_or_insert_default().push(c),
            }
        }
        if let Some(open) = quote {
            return Err(format!("the quote {open} is not closed"));
        }
        words.extend(word);
        match words.first() {
            None => return Err("the command is empty".to_owned()),
            Some(program) if program.is_empty() || program.contains('{') => {
                return Err("the first word must be the program to run".to_owned());
            }
            Some(_) => {}
        }
        let line = CommandLine { words };
        for name in line.placeholders() {
            if !PLACEHOLDERS.contains(&name) {
                let meant = nearest(name, PLACEHOLDERS).unwrap_or_else(|| "value".to_owned());
                return Err(format!("unknown placeholder `{{{name}}}`; did you mean `{{{meant}}}`?"));
            }
        }
        Ok(line)
    }

    /// The names of the placeholders.
    pub fn placeholders(&self) -> Vec<&str> {
        self.words.iter().flat_map(|word| parts(word)).filter_map(|part| part.err()).collect()
    }

    /// The program and its arguments with every placeholder filled in; a placeholder without a value becomes empty.
    pub fn filled(&self, values: &[(&str, String)]) -> Vec<String> {
        self.words.iter().map(|word| filled(word, values)).collect()
    }
}

fn filled(word: &str, values: &[(&str, String)]) -> String {
    let value = |name: &str| values.iter().find(|(known, _)| *known == name).map_or("", |(_, value)| value.as_str());
    parts(word).into_iter().map(|part| part.unwrap_or_else(value)).collect()
}

/// Splits a word into text (`Ok`) and names of placeholders (`Err`).
fn parts(word: &str) -> Vec<Result<&str, &str>> {
    let (mut parts, mut rest) = (Vec::new(), word);
    while let Some((before, name, after)) = placeholder(rest) {
        parts.push(Ok(before));
        parts.push(Err(name));
        rest = after;
    }
    parts.push(Ok(rest));
    parts
}

/// Splits a text at its first placeholder: the text before it, its name, the text after it.
fn placeholder(text: &str) -> Option<(&str, &str, &str)> {
    let mut from = 0;
    while let Some(open) = text.get(from..)?.find('{').map(|at| from + at) {
        let inside = text.get(open + 1..)?;
        if let Some((name, after)) = inside.split_once('}')
            && !name.is_empty()
            && name.bytes().all(|octet| octet.is_ascii_lowercase() || octet == b'_')
        {
            return Some((text.get(..open)?, name, after));
        }
        from = open + 1;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    #[rstest]
    #[case("relay 1 {value}", &["relay", "1", "up"])]
    #[case("  ssh  'bench host' \"set {value}\"  ", &["ssh", "bench host", "set up"])]
    #[case("relay --to={value};{value} $(reboot) `x` *", &["relay", "--to=up;up", "$(reboot)", "`x`", "*"])]
    #[case("a'b c'd ''", &["ab cd", ""])]
    #[case("json {\"a\":1} { } {}", &["json", "{a:1}", "{", "}", "{}"])]
    fn shell_syntax_has_no_meaning(#[case] line: &str, #[case] words: &[&str]) {
        let command = CommandLine::parse(line).expect("a command");
        assert_eq!(command.filled(&[("value", "up".to_owned())]), words);
    }

    #[test]
    fn a_value_is_never_split() {
        let command = CommandLine::parse("set {value}").expect("a command");
        assert_eq!(command.filled(&[("value", "a b {rpm} 'c'".to_owned())]), ["set", "a b {rpm} 'c'"]);
        assert_eq!(command.placeholders(), ["value"]);
    }

    #[rstest]
    #[case("", "the command is empty")]
    #[case("   ", "the command is empty")]
    #[case("relay 'on", "the quote ' is not closed")]
    #[case("{value} on", "the first word must be the program to run")]
    #[case("relay {vlaue}", "unknown placeholder `{vlaue}`; did you mean `{value}`?")]
    #[case("relay {x}", "unknown placeholder `{x}`; did you mean `{value}`?")]
    fn invalid_commands_are_refused(#[case] line: &str, #[case] why: &str) {
        assert_eq!(CommandLine::parse(line).err().as_deref(), Some(why));
    }
}
