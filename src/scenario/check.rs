//! Checks a parsed file against the declared format: unknown keys, missing keys, wrong types, lengths, ranges and
//! words. Knows no key by name but `name` and `type`.

use super::fields::{Kind, Range, Table, listed};
use super::findings::{Finding, Findings};
use super::naming::{Element, Item, found, written};
use super::reader::number;
use crate::budget::LARGEST;
use crate::formula::Formula;
use crate::suggest::closest;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Checks a table and everything in it.
pub(super) fn table(declared: &'static Table, table: &DeTable<'_>, findings: &Findings) {
    let whole = Element { table: declared, name: None, index: None, within: None };
    Check { findings }.table(&whole, table, 0..0);
}

struct Check<'f> {
    findings: &'f Findings,
}

impl Check<'_> {
    fn table(&self, element: &Element<'_>, table: &DeTable<'_>, span: std::ops::Range<usize>) {
        let of_type = self.of_type(element, table, &span);
        for (name, value) in table {
            if name.get_ref() == "type" && !element.table.types.is_empty() {
                continue;
            }
            let mut declared = element.table.declarations(name.get_ref()).peekable();
            if declared.peek().is_none() {
                self.unknown(element, name, of_type);
                continue;
            }
            match declared.find(|key| of_type.is_none_or(|t| key.belongs_to(t))) {
                Some(key) => {
                    let item = Item { element, key, path: key.name.to_owned() };
                    self.value(&key.kind, &item, name.span(), value);
                }
                None => self.misplaced(element, name, of_type.unwrap_or_default()),
            }
        }
        if element.within.is_none() {
            // What a whole file lacks has no place in it.
            return;
        }
        let missing = element.table.keys.iter().filter(|key| key.required && !table.contains_key(key.name));
        for key in missing.filter(|key| key.only.is_empty() || of_type.is_some_and(|t| key.belongs_to(t))) {
            let message = format!("{}`{}` is missing", element.prefix(), key.name);
            let help = format!("for example `{} = {}`", key.name, key.example);
            self.findings.push(Finding::error(span.clone(), message).help(help));
        }
    }

    /// The value of `type`, if there should be one and it is known.
    fn of_type(
        &self,
        element: &Element<'_>,
        table: &DeTable<'_>,
        span: &std::ops::Range<usize>,
    ) -> Option<&'static str> {
        let types = element.table.types;
        if types.is_empty() {
            return None;
        }
        // Only what is wrong is told of: a large scene has thousands of types.
        let all = || listed(types.iter().map(|(name, _)| *name));
        let Some(value) = table.get("type") else {
            let message = format!("{}`type` is missing", element.prefix());
            self.findings.push(Finding::error(span.clone(), message).help(format!("`type` is one of {}", all())));
            return None;
        };
        let Some(word) = value.get_ref().as_str() else {
            let (prefix, found) = (element.prefix(), found(value.get_ref()));
            let message = format!("{prefix}`type` must be one of {}, found {found}", all());
            self.findings.push_value(Finding::error(value.span(), message));
            return None;
        };
        let known = types.iter().map(|(name, _)| *name).find(|name| *name == word);
        if known.is_none() {
            let message = format!("{}unknown {} type `{word}`", element.prefix(), element.table.name);
            let help = did_you_mean(word, types.iter().map(|(name, _)| *name))
                .unwrap_or_else(|| format!("`type` is one of {}", all()));
            self.findings.push_value(Finding::error(value.span(), message).help(help));
        }
        known
    }

    fn unknown(&self, element: &Element<'_>, name: &Spanned<impl AsRef<str>>, of_type: Option<&str>) {
        let word = name.get_ref().as_ref();
        let message = format!("{}unknown key `{word}`", element.prefix());
        let inner =
            element.table.keys.iter().find(|key| tables(&key.kind).any(|table| table.names(None).any(|it| it == word)));
        let help = inner
            .map(|key| format!("it is a key of `{0}`: `{0} = {{ {word} = … }}`", key.name))
            .or_else(|| did_you_mean(word, element.table.names(of_type)))
            .or_else(|| singular(word, element.table.names(of_type)).map(|near| format!("did you mean `{near}`?")))
            .unwrap_or_else(|| format!("allowed: {}", listed(element.table.names(of_type))));
        self.findings.push(Finding::error(name.span(), message).help(help));
    }

    fn misplaced(&self, element: &Element<'_>, name: &Spanned<impl AsRef<str>>, of_type: &str) {
        let word = name.get_ref().as_ref();
        let what = element.table.name;
        let message = format!("{}{} {of_type} {what} has no `{word}`", element.prefix(), article(of_type));
        let owners: Vec<&str> = element.table.declarations(word).flat_map(|key| key.only.iter().copied()).collect();
        let help = if owners.len() + 1 == element.table.types.len() {
            "every other type has it".to_owned()
        } else {
            format!("for the types {}", listed(owners.into_iter()))
        };
        self.findings.push(Finding::error(name.span(), message).help(help));
    }

    fn value(
        &self,
        kind: &'static Kind,
        item: &Item<'_>,
        key_span: std::ops::Range<usize>,
        value: &Spanned<DeValue<'_>>,
    ) {
        match (kind, value.get_ref()) {
            (Kind::Refused(why), _) => {
                self.findings.push(Finding::error(key_span, format!("{}{why}", item.element.prefix())));
            }
            (Kind::Text, DeValue::String(_)) | (Kind::Flag, DeValue::Boolean(_)) => {}
            (Kind::Number(range), DeValue::Integer(_) | DeValue::Float(_)) => self.number(*range, item, value),
            (Kind::Integer(range), DeValue::Integer(_)) => self.number(*range, item, value),
            (Kind::Choice(words), DeValue::String(word)) => self.word(words, item, value, word),
            (Kind::List(of, lengths), DeValue::Array(items)) => {
                let wrong = match lengths {
                    [] => items.is_empty() && item.key.kind.elements().is_none(),
                    lengths => !lengths.contains(&items.len()),
                };
                if wrong {
                    let message =
                        format!("{} must be {}, found {}", item.subject(), kind.expected(), found(value.get_ref()));
                    self.findings.push_value(Finding::error(value.span(), message).maybe_help(item.example()));
                }
                self.items(of, item, items);
            }
            (Kind::Either(kinds), found) => match kinds.iter().find(|kind| fits(kind, found)) {
                Some(kind) => self.value(kind, item, key_span, value),
                None => self.wrong_type(kind, item, value),
            },
            (Kind::Table(declared), DeValue::Table(table)) => {
                let name = table.get("name").and_then(|name| name.get_ref().as_str());
                let element = Element { table: declared, name, index: None, within: Some(item.element) };
                self.table(&element, table, value.span());
            }
            (Kind::Map(of), DeValue::Table(table)) => {
                for (name, value) in table {
                    let path = format!("{}.{}", item.path, name.get_ref());
                    self.value(of, &Item { element: item.element, key: item.key, path }, name.span(), value);
                }
            }
            _ => self.wrong_type(kind, item, value),
        }
    }

    fn items(&self, of: &'static Kind, item: &Item<'_>, items: &[Spanned<DeValue<'_>>]) {
        for (index, value) in items.iter().enumerate() {
            if let (Kind::Table(declared), DeValue::Table(table)) = (of, value.get_ref()) {
                let name = table.get("name").and_then(|name| name.get_ref().as_str());
                let element = Element { table: declared, name, index: Some(index), within: Some(item.element) };
                self.table(&element, table, value.span());
            } else {
                let fine =
                    matches!(of, Kind::Number(range) if number(value.get_ref()).is_some_and(|n| range.contains(n)));
                if !fine {
                    let path = format!("{}[{index}]", item.path);
                    self.value(of, &Item { element: item.element, key: item.key, path }, value.span(), value);
                }
            }
        }
    }

    fn number(&self, range: Range, item: &Item<'_>, value: &Spanned<DeValue<'_>>) {
        let Some(number) = number(value.get_ref()).filter(|number| number.is_finite()) else {
            let message = format!("{} is {}, which is not a finite number", item.subject(), written(value.get_ref()));
            self.findings.push_value(Finding::error(value.span(), message));
            return;
        };
        if number.abs() > LARGEST {
            let allowed = range.allowed(item.key.unit);
            let message = format!(
                "{} is {}, allowed: {allowed}, up to {LARGEST:e} in size",
                item.subject(),
                written(value.get_ref())
            );
            self.findings.push_value(Finding::error(value.span(), message).help("squares of larger numbers overflow"));
            return;
        }
        if !range.contains(number) {
            let allowed = range.allowed(item.key.unit);
            let message = format!("{} is {}, allowed: {allowed}", item.subject(), written(value.get_ref()));
            self.findings.push_value(Finding::error(value.span(), message));
        }
    }

    fn word(
        &self,
        words: &'static [(&'static str, &'static str)],
        item: &Item<'_>,
        value: &Spanned<DeValue<'_>>,
        word: &str,
    ) {
        if words.iter().any(|(known, _)| *known == word) {
            return;
        }
        let all = listed(words.iter().map(|(known, _)| *known));
        let message = format!("{} does not know `{word}`", item.subject());
        let help = did_you_mean(word, words.iter().map(|(known, _)| *known)).unwrap_or_else(|| format!("one of {all}"));
        self.findings.push_value(Finding::error(value.span(), message).help(help));
    }

    fn wrong_type(&self, kind: &Kind, item: &Item<'_>, value: &Spanned<DeValue<'_>>) {
        // What is wrong with a text in the place of a number has been said.
        if value.get_ref().is_str() && self.findings.touch(&value.span()) {
            return;
        }
        let message = format!("{} must be {}, found {}", item.subject(), kind.expected(), found(value.get_ref()));
        let help = match (kind, value.get_ref()) {
            (Kind::List(Kind::Table(_), _), DeValue::Table(_)) => {
                Some(format!("write `[[{0}]]` in place of `[{0}]`", item.key.name))
            }
            (_, DeValue::String(text)) if holds_numbers(kind) => constant(text).or_else(|| item.example()),
            _ => item.example(),
        };
        self.findings.push_value(Finding::error(value.span(), message).maybe_help(help));
    }
}

/// Whether a number may stand there, alone or in a list.
fn holds_numbers(kind: &Kind) -> bool {
    match kind {
        Kind::Number(_) => true,
        Kind::List(of, _) => holds_numbers(of),
        Kind::Either(kinds) => kinds.iter().any(holds_numbers),
        _ => false,
    }
}

/// What to write in place of a formula in constants alone.
fn constant(text: &str) -> Option<String> {
    let value = Formula::parse(text, &[]).ok()?.value(&[]);
    value.is_finite().then(|| {
        format!("write {value:?}: a text is a formula only if it has a name of `[parameters]` in braces, as `\"{{a}} * pi\"`")
    })
}

/// The known name of which a word is the regular English plural.
fn singular<'a>(word: &str, mut known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    known.find(|name| {
        let stem = name.strip_suffix('y').map(|stem| format!("{stem}ies"));
        stem.is_some_and(|plural| plural == word)
            || [format!("{name}s"), format!("{name}es")].iter().any(|it| it == word)
    })
}

/// Whether a value has the outer type of a kind, so that what is wrong with it is said in that kind's words.
fn fits(kind: &Kind, value: &DeValue<'_>) -> bool {
    match (kind, value) {
        (Kind::List(of, _), DeValue::Array(items)) => {
            let first = items.first().map(toml::Spanned::get_ref);
            match of {
                Kind::Table(_) => true,
                Kind::List(..) => first.is_some_and(DeValue::is_array),
                Kind::Number(_) => !first.is_some_and(|first| first.is_array() || first.is_table()),
                _ => !first.is_some_and(DeValue::is_array),
            }
        }
        (Kind::Number(_), DeValue::Float(_) | DeValue::Integer(_))
        | (Kind::Integer(_), DeValue::Integer(_))
        | (Kind::Text | Kind::Choice(_), DeValue::String(_))
        | (Kind::Flag, DeValue::Boolean(_))
        | (Kind::Table(_) | Kind::Map(_), DeValue::Table(_)) => true,
        (Kind::Either(kinds), value) => kinds.iter().any(|kind| fits(kind, value)),
        _ => false,
    }
}

/// The tables that a value may be.
fn tables(kind: &'static Kind) -> Box<dyn Iterator<Item = &'static Table>> {
    match kind {
        Kind::Table(table) => Box::new(std::iter::once(*table)),
        Kind::Either(kinds) => Box::new(kinds.iter().flat_map(tables)),
        _ => Box::new(std::iter::empty()),
    }
}

fn did_you_mean<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<String> {
    closest(word, known).map(|near| format!("did you mean `{near}`?"))
}

/// The indefinite article of a word of the format.
pub(super) fn article(word: &str) -> &'static str {
    let vowel = word.starts_with(['a', 'e', 'i', 'o', 'u']) && !word.starts_with("uni");
    if vowel { "an" } else { "a" }
}

#[cfg(test)]
mod tests {
    use super::super::format::{ATTACHMENT, BODY, BUSHING_VALUES, FORCE, HINGE, RECORD, ROUND, SCENARIO, SHAPE};
    use super::super::format::{SIMULATE, STATICS};
    use super::super::sources::Sources;
    use super::*;

    #[test]
    fn every_example_and_default_passes_its_own_check() {
        let tables = [
            &SCENARIO,
            &SIMULATE,
            &STATICS,
            &RECORD,
            &BODY,
            &SHAPE,
            &ROUND,
            &HINGE,
            &FORCE,
            &ATTACHMENT,
            &BUSHING_VALUES,
        ];
        for (declared, key) in tables.iter().flat_map(|table| table.keys.iter().map(move |key| (table, key))) {
            // A number without a list is what most values per coordinate default to.
            for value in [key.example, key.default].into_iter().filter(|value| !value.is_empty()) {
                let text = format!("{} = {value}", key.name);
                let document = DeTable::parse(&text).expect("examples are TOML").into_inner();
                let findings = Findings::default();
                let element = Element { table: declared, name: None, index: None, within: None };
                for value in document.values() {
                    let item = Item { element: &element, key, path: key.name.to_owned() };
                    Check { findings: &findings }.value(&key.kind, &item, 0..0, value);
                }
                let found = findings.into_diagnostics(&Sources::new("example", &text));
                assert_eq!(found, [], "{} of {}", text, declared.name);
            }
        }
    }
}
