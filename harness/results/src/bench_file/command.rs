//! The command line of a hook: words and placeholders, and nothing that a shell would make of them.

use plain_text::nearest;

/// What can stand in braces, and for what.
const PLACEHOLDERS: [&str; 4] = ["value", "unit", "rpm", "acceleration"];

/// A command line taken apart into words; each word is one argument whatever is put into it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CommandLine {
    words: Vec<String>,
}

impl CommandLine {
    /// Takes a line apart at its spaces; what stands in `'...'` or `"..."` is one word with its spaces.
    ///
    /// Fails on an empty line, a quote that is not closed, and a `{word}` that is no placeholder.
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
            None => return Err("there is no command".to_owned()),
            Some(program) if program.is_empty() || program.contains('{') => {
                return Err("it begins with the program to be run".to_owned());
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

    /// The names in braces.
    pub fn placeholders(&self) -> Vec<&str> {
        self.words.iter().flat_map(|word| parts(word)).filter_map(|part| part.err()).collect()
    }

    /// The words with every placeholder filled in: the program and its arguments; one without a value is left empty.
    pub fn filled(&self, values: &[(&str, String)]) -> Vec<String> {
        self.words.iter().map(|word| filled(word, values)).collect()
    }
}

fn filled(word: &str, values: &[(&str, String)]) -> String {
    let value = |name: &str| values.iter().find(|(known, _)| *known == name).map_or("", |(_, value)| value.as_str());
    parts(word).into_iter().map(|part| part.unwrap_or_else(value)).collect()
}

/// A word in its pieces: text, or the name of a placeholder as an error.
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

/// What stands before, in and after the first braces with a name in them.
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
    fn words_are_words_whatever_a_shell_would_think(#[case] line: &str, #[case] words: &[&str]) {
        let command = CommandLine::parse(line).expect("a command");
        assert_eq!(command.filled(&[("value", "up".to_owned())]), words);
    }

    #[test]
    fn a_value_is_never_taken_apart() {
        let command = CommandLine::parse("set {value}").expect("a command");
        assert_eq!(command.filled(&[("value", "a b {rpm} 'c'".to_owned())]), ["set", "a b {rpm} 'c'"]);
        assert_eq!(command.placeholders(), ["value"]);
    }

    #[rstest]
    #[case("", "there is no command")]
    #[case("   ", "there is no command")]
    #[case("relay 'on", "the quote ' is not closed")]
    #[case("{value} on", "it begins with the program to be run")]
    #[case("relay {vlaue}", "unknown placeholder `{vlaue}`; did you mean `{value}`?")]
    #[case("relay {x}", "unknown placeholder `{x}`; did you mean `{value}`?")]
    fn what_is_no_command(#[case] line: &str, #[case] why: &str) {
        assert_eq!(CommandLine::parse(line).err().as_deref(), Some(why));
    }
}
