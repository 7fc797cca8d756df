//! Finds the places of a source file that can be changed, and writes the file with every change behind a switch.

use proc_macro2::Span;
use std::collections::BTreeMap;
use std::ops::Range;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{BinOp, Expr, ExprBinary, ExprIf, ExprLit, ExprUnary, Lit, Stmt, UnOp};

/// One change of a reference device.
#[derive(Clone, Debug)]
pub struct Change {
    /// The lines of the whole place, from 1; the changed file has the same lines.
    pub lines: Range<usize>,
    /// The function, and what is changed in it: ``Scaling::of `a < b`: `<=` for `<` ``. The same wherever the function stands in the
    /// file, and different for each change of the file.
    pub what: String,
    edits: Vec<Edit>,
}

#[derive(Clone, Debug)]
struct Edit {
    range: Range<usize>,
    text: String,
    /// Whether the text ends something: it comes before texts that begin at the same offset.
    is_end: bool,
    depth: usize,
}

/// Stands for the number of the change in a text.
const NUMBER: &str = "\u{1}";

/// Finds the changes of a file.
pub fn changes(source: &str) -> Result<Vec<Change>, syn::Error> {
    let file = syn::parse_file(source)?;
    let mut finder = Finder { source, depth: 0, function: Vec::new(), found: Vec::new() };
    finder.visit_file(&file);
    let mut found = finder.found;
    let mut times: BTreeMap<String, usize> = BTreeMap::new();
    for change in &mut found {
        let time = times.entry(change.what.clone()).or_default();
        *time += 1;
        if *time > 1 {
            change.what += &format!(" #{time}");
        }
    }
    Ok(found)
}

/// A text of at most 90 characters; of a longer one the beginning and a sum.
fn short(text: &str) -> String {
    const LONGEST: usize = 90;
    if text.chars().count() <= LONGEST {
        return text.to_owned();
    }
    let begin: String = text.chars().take(LONGEST - 6).collect();
    let sum = text
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    format!("{begin}…{:04x}", sum & 0xffff)
}

/// Writes the file with the given changes, each with its number.
pub fn instrumented(source: &str, changes: &[(u32, &Change)]) -> String {
    let mut edits: Vec<(Edit, u32)> =
        changes.iter().flat_map(|(number, change)| change.edits.iter().map(|edit| (edit.clone(), *number))).collect();
    edits.sort_by_key(|(edit, _)| {
        let order = if edit.is_end { usize::MAX - edit.depth } else { edit.depth };
        (edit.range.start, !edit.is_end, order)
    });
    let mut out = String::with_capacity(source.len() * 2);
    let mut at = 0;
    for (edit, number) in edits {
        out.push_str(&source[at..edit.range.start]);
        out.push_str(&edit.text.replace(NUMBER, &number.to_string()));
        at = edit.range.end;
    }
    out.push_str(&source[at..]);
    out
}

struct Finder<'a> {
    source: &'a str,
    depth: usize,
    /// The modules, the type and the function around.
    function: Vec<String>,
    found: Vec<Change>,
}

impl Finder<'_> {
    fn text(&self, span: Span) -> String {
        self.source[span.byte_range()].split_whitespace().collect::<Vec<_>>().join(" ")
    }

    fn within(&mut self, name: String, work: impl FnOnce(&mut Self)) {
        self.function.push(name);
        work(self);
        self.function.pop();
    }

    /// Notes a change of the place `whole`: each edit is a range with its new text, and whether it is an end.
    fn note(&mut self, whole: Span, how: &str, edits: &[(Range<usize>, String, bool)]) {
        let depth = self.depth;
        let edits = edits.iter().map(|(range, text, is_end)| Edit {
            range: range.clone(),
            text: text.clone(),
            is_end: *is_end,
            depth,
        });
        self.found.push(Change {
            lines: whole.start().line..whole.end().line + 1,
            what: format!("{} `{}`: {how}", self.function.join("::"), short(&self.text(whole))),
            edits: edits.collect(),
        });
    }

    fn around(&mut self, whole: Span, how: &str, before: &str, after: &str) {
        let range = whole.byte_range();
        let edits =
            [(range.start..range.start, before.to_owned(), false), (range.end..range.end, after.to_owned(), true)];
        self.note(whole, how, &edits);
    }

    fn binary(&mut self, binary: &ExprBinary) {
        let Some((own, other)) = alternative(&binary.op) else { return };
        let (left, right) = (binary.left.span().byte_range(), binary.right.span().byte_range());
        let operator = binary.op.span().byte_range();
        let on = format!("::mutant_switch::on({NUMBER})");
        let (open, middle, close) = match binary.op {
            BinOp::And(_) | BinOp::Or(_) => {
                // Both are one another with every side negated, so a side is written once and stays lazy.
                let sides = format!(" != {on}) {own} ((");
                ("((((".to_owned(), sides, format!(") != {on})) != {on})"))
            }
            BinOp::Eq(_) | BinOp::Ne(_) | BinOp::Lt(_) | BinOp::Le(_) | BinOp::Gt(_) | BinOp::Ge(_) => (
                "(match (&(".to_owned(),
                "), &(".to_owned(),
                format!(")) {{ (l, r) => ::mutant_switch::either({NUMBER}, l {own} r, l {other} r) }})"),
            ),
            _ => (
                "(match ((".to_owned(),
                "), (".to_owned(),
                format!(")) {{ (l, r) => if {on} {{ l {other} r }} else {{ l {own} r }} }})"),
            ),
        };
        let middle = if matches!(binary.op, BinOp::And(_) | BinOp::Or(_)) { format!("){middle}") } else { middle };
        let edits =
            [(left.start..left.start, open, false), (operator, middle, false), (right.end..right.end, close, true)];
        self.note(binary.span(), &format!("`{other}` for `{own}`"), &edits);
    }
}

/// The operator and the one that replaces it.
fn alternative(operator: &BinOp) -> Option<(&'static str, &'static str)> {
    Some(match operator {
        BinOp::Add(_) => ("+", "-"),
        BinOp::Sub(_) => ("-", "+"),
        BinOp::Mul(_) => ("*", "/"),
        BinOp::Div(_) => ("/", "*"),
        BinOp::Rem(_) => ("%", "/"),
        BinOp::And(_) => ("&&", "||"),
        BinOp::Or(_) => ("||", "&&"),
        BinOp::BitXor(_) => ("^", "|"),
        BinOp::BitAnd(_) => ("&", "|"),
        BinOp::BitOr(_) => ("|", "&"),
        BinOp::Shl(_) => ("<<", ">>"),
        BinOp::Shr(_) => (">>", "<<"),
        BinOp::Eq(_) => ("==", "!="),
        BinOp::Ne(_) => ("!=", "=="),
        BinOp::Lt(_) => ("<", "<="),
        BinOp::Le(_) => ("<=", "<"),
        BinOp::Gt(_) => (">", ">="),
        BinOp::Ge(_) => (">=", ">"),
        _ => return None,
    })
}

/// Whether an expression has a `let` in its conditions.
fn has_let(expression: &Expr) -> bool {
    match expression {
        Expr::Let(_) => true,
        Expr::Binary(binary) => has_let(&binary.left) || has_let(&binary.right),
        Expr::Paren(inner) => has_let(&inner.expr),
        _ => false,
    }
}

fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("test")
            || (attribute.path().is_ident("cfg")
                && attribute.meta.require_list().is_ok_and(|list| list.tokens.to_string().contains("test")))
    })
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_item_const(&mut self, _: &'ast syn::ItemConst) {}
    fn visit_item_static(&mut self, _: &'ast syn::ItemStatic) {}
    fn visit_impl_item_const(&mut self, _: &'ast syn::ImplItemConst) {}
    fn visit_trait_item_const(&mut self, _: &'ast syn::TraitItemConst) {}
    fn visit_item_enum(&mut self, _: &'ast syn::ItemEnum) {}
    fn visit_type(&mut self, _: &'ast syn::Type) {}
    fn visit_pat(&mut self, _: &'ast syn::Pat) {}
    fn visit_generic_argument(&mut self, _: &'ast syn::GenericArgument) {}
    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}
    fn visit_macro(&mut self, _: &'ast syn::Macro) {}

    fn visit_expr_repeat(&mut self, repeat: &'ast syn::ExprRepeat) {
        self.visit_expr(&repeat.expr);
    }

    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !is_for_tests(&module.attrs) {
            self.within(module.ident.to_string(), |finder| visit::visit_item_mod(finder, module));
        }
    }

    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        if function.sig.constness.is_none() && !is_for_tests(&function.attrs) {
            self.within(function.sig.ident.to_string(), |finder| visit::visit_item_fn(finder, function));
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        if function.sig.constness.is_none() && !is_for_tests(&function.attrs) {
            self.within(function.sig.ident.to_string(), |finder| visit::visit_impl_item_fn(finder, function));
        }
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        self.within(self.text(item.self_ty.span()), |finder| visit::visit_item_impl(finder, item));
    }

    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        self.within(item.ident.to_string(), |finder| visit::visit_item_trait(finder, item));
    }

    fn visit_trait_item_fn(&mut self, function: &'ast syn::TraitItemFn) {
        self.within(function.sig.ident.to_string(), |finder| visit::visit_trait_item_fn(finder, function));
    }

    fn visit_expr(&mut self, expression: &'ast Expr) {
        self.depth += 1;
        visit::visit_expr(self, expression);
        self.depth -= 1;
    }

    fn visit_expr_binary(&mut self, binary: &'ast ExprBinary) {
        if !has_let(&binary.left) && !has_let(&binary.right) {
            self.binary(binary);
        }
        visit::visit_expr_binary(self, binary);
    }

    fn visit_expr_unary(&mut self, unary: &'ast ExprUnary) {
        if let UnOp::Not(not) = &unary.op {
            let (whole, operator) = (unary.span(), not.span().byte_range());
            let after = format!(") {{ v => if ::mutant_switch::on({NUMBER}) {{ v }} else {{ !v }} }})");
            let end = whole.byte_range().end;
            self.note(whole, "without `!`", &[(operator, "(match (".to_owned(), false), (end..end, after, true)]);
        }
        // A negative number is a literal of its own; its digits are changed.
        visit::visit_expr_unary(self, unary);
    }

    fn visit_expr_lit(&mut self, literal: &'ast ExprLit) {
        let whole = literal.span();
        match &literal.lit {
            Lit::Bool(value) => {
                let not = if value.value { "!" } else { "" };
                let text = format!("({not}::mutant_switch::on({NUMBER}))");
                self.note(whole, &format!("`{}`", !value.value), &[(whole.byte_range(), text, false)]);
            }
            Lit::Int(number) => {
                let Ok(value) = number.base10_parse::<u128>() else { return };
                let suffix = number.suffix();
                // The highest number of a width has no next one.
                let is_highest = [8, 16, 32, 64].iter().any(|width| value == (1 << width) - 1);
                let other = if is_highest { value - 1 } else { value + 1 };
                let after =
                    format!(") {{ v => if ::mutant_switch::on({NUMBER}) {{ {other}{suffix} }} else {{ v }} }})");
                self.around(whole, &format!("`{other}`"), "(match (", &after);
            }
            _ => {}
        }
    }

    fn visit_expr_if(&mut self, conditional: &'ast ExprIf) {
        if !has_let(&conditional.cond) {
            let on = format!(")) != ::mutant_switch::on({NUMBER})");
            self.around(conditional.cond.span(), "the opposite", "((", &on);
        }
        visit::visit_expr_if(self, conditional);
    }

    fn visit_arm(&mut self, arm: &'ast syn::Arm) {
        if let Some((_, guard)) = arm.guard.as_ref().filter(|(_, guard)| !has_let(guard)) {
            let on = format!(")) != ::mutant_switch::on({NUMBER})");
            self.around(guard.span(), "the opposite", "((", &on);
        }
        visit::visit_arm(self, arm);
    }

    fn visit_stmt(&mut self, statement: &'ast Stmt) {
        if let Stmt::Expr(expression @ (Expr::MethodCall(_) | Expr::Call(_) | Expr::Assign(_)), Some(_)) = statement
            && !self.text(expression.span()).contains("hooks.notify(")
        {
            let before = format!("if !::mutant_switch::on({NUMBER}) {{ ");
            self.around(expression.span(), "left out", &before, "; }");
        }
        visit::visit_stmt(self, statement);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(source: &str) -> (Vec<String>, String) {
        let found = changes(source).expect("a file");
        let numbered: Vec<(u32, &Change)> = (1..).zip(&found).collect();
        (found.iter().map(|change| change.what.clone()).collect(), instrumented(source, &numbered))
    }

    #[test]
    fn a_comparison_is_evaluated_once_and_keeps_its_lines() {
        let (what, text) = all("fn f(a: u8, b: u8) -> bool {\n    a\n        < b\n}\n");
        assert_eq!(what, ["f `a < b`: `<=` for `<`"]);
        assert_eq!(text.lines().count(), 4);
        assert!(text.contains("::mutant_switch::either(1, l < r, l <= r)"), "{text}");
    }

    #[test]
    fn constants_patterns_and_tests_are_left_alone() {
        let source = "const A: u8 = 1;\nfn f(x: u8) -> u8 { match x { 1 => 0, _ => x } }\n#[cfg(test)]\nmod tests { fn g() -> u8 { 3 } }\n";
        assert_eq!(all(source).0, ["f `0`: `1`"]);
    }

    #[test]
    fn nested_places_nest() {
        let (what, text) = all("fn f(a: u8) -> bool { !(a + 1 > 2 && a != 3) }");
        assert_eq!(what.len(), 8);
        syn::parse_file(&text).expect("the changed file is Rust");
    }
}
