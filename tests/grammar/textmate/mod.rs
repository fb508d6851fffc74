//! Runs a TextMate grammar, as far as ours goes: `match`, `begin`/`end`, captures, includes of
//! the repository.

use std::collections::BTreeMap;

use fancy_regex::{Captures, Regex};
use serde_json::Value;

/// A stretch of the text with a scope.
pub(crate) struct Scoped {
    pub(crate) start: usize,
    pub(crate) end: usize,
    pub(crate) scope: String,
}

struct Rule {
    regex: Regex,
    name: Option<String>,
    captures: BTreeMap<usize, String>,
    /// For `begin`: what ends the context, its captures, and the rules in it.
    context: Option<usize>,
}

struct Context {
    end: Regex,
    captures: BTreeMap<usize, String>,
    patterns: Vec<Value>,
}

/// A grammar.
pub(crate) struct Grammar {
    repository: Value,
    contexts: Vec<Context>,
    /// The rules of the file, and of each context.
    rules: Vec<Vec<Rule>>,
}

fn captures(value: &Value) -> BTreeMap<usize, String> {
    value
        .as_object()
        .into_iter()
        .flatten()
        .map(|(number, what)| {
            let name = what["name"].as_str().unwrap().to_owned();
            (number.parse().unwrap(), name)
        })
        .collect()
}

impl Grammar {
    pub(crate) fn new(json: &Value) -> Self {
        let mut grammar = Self { repository: json["repository"].clone(), contexts: Vec::new(), rules: Vec::new() };
        let top = json["patterns"].as_array().unwrap();
        let rules = grammar.compile(top);
        grammar.rules.push(rules);
        let mut done = 0;
        while done < grammar.contexts.len() {
            let patterns = grammar.contexts[done].patterns.clone();
            let rules = grammar.compile(&patterns);
            grammar.rules.push(rules);
            done += 1;
        }
        grammar
    }

    fn compile(&mut self, patterns: &[Value]) -> Vec<Rule> {
        let mut rules = Vec::new();
        for pattern in patterns {
            self.rule(pattern, &mut rules);
        }
        rules
    }

    fn rule(&mut self, pattern: &Value, rules: &mut Vec<Rule>) {
        let known =
            ["include", "patterns", "match", "name", "captures", "begin", "beginCaptures", "end", "endCaptures"];
        for key in pattern.as_object().unwrap().keys() {
            assert!(known.contains(&key.as_str()), "`{key}` is not understood");
        }
        let name = pattern["name"].as_str().map(str::to_owned);
        if let Some(include) = pattern["include"].as_str() {
            let included = self.repository[include.trim_start_matches('#')].clone();
            assert!(included.is_object(), "{include} is missing");
            self.rule(&included, rules);
        } else if let Some(begin) = pattern["begin"].as_str() {
            let end = pattern["end"].as_str().unwrap();
            let patterns = pattern["patterns"].as_array().unwrap();
            let same = |one: &Context| one.end.as_str() == end && one.patterns == *patterns;
            let context = self.contexts.iter().position(same);
            let context = context.unwrap_or_else(|| {
                self.contexts.push(Context {
                    end: Regex::new(end).unwrap(),
                    captures: captures(&pattern["endCaptures"]),
                    patterns: patterns.clone(),
                });
                self.contexts.len() - 1
            });
            rules.push(Rule {
                regex: Regex::new(begin).unwrap(),
                name,
                captures: captures(&pattern["beginCaptures"]),
                context: Some(context),
            });
        } else if let Some(regex) = pattern["match"].as_str() {
            rules.push(Rule {
                regex: Regex::new(regex).unwrap(),
                name,
                captures: captures(&pattern["captures"]),
                context: None,
            });
        } else {
            for inner in pattern["patterns"].as_array().unwrap() {
                self.rule(inner, rules);
            }
        }
    }

    /// The scopes of a text, as an editor finds them, line by line.
    pub(crate) fn scopes(&self, text: &str) -> Vec<Scoped> {
        let mut found = Vec::new();
        let mut stack: Vec<usize> = Vec::new();
        let mut start = 0;
        for line in text.split_inclusive('\n') {
            self.line(line.trim_end_matches(['\n', '\r']), start, &mut stack, &mut found);
            start += line.len();
        }
        found
    }

    fn line(&self, line: &str, start: usize, stack: &mut Vec<usize>, found: &mut Vec<Scoped>) {
        let mut at = 0;
        let mut moves = 0;
        loop {
            let inside = stack.last().copied();
            let rules = &self.rules[inside.map_or(0, |context| context + 1)];
            let mut best: Option<(Captures<'_, str>, Option<&Rule>)> = None;
            let end = inside.map(|context| (&self.contexts[context].end, None));
            let candidates = rules.iter().map(|rule| (&rule.regex, Some(rule)));
            for (regex, rule) in end.into_iter().chain(candidates) {
                let Some(hit) = regex.captures_from_pos(line, at).unwrap() else {
                    continue;
                };
                let before = best.as_ref().map(|(other, _)| other.get(0).unwrap().start());
                if before.is_none_or(|before| hit.get(0).unwrap().start() < before) {
                    best = Some((hit, rule));
                }
            }
            let Some((hit, rule)) = best else {
                return;
            };
            let whole = hit.get(0).unwrap();
            let mut note = |from: usize, to: usize, scope: &str| {
                found.push(Scoped { start: start + from, end: start + to, scope: scope.to_owned() });
            };
            let names = match (rule, inside) {
                (Some(rule), _) => {
                    if let Some(name) = &rule.name {
                        note(whole.start(), whole.end(), name);
                    }
                    stack.extend(rule.context);
                    &rule.captures
                }
                (None, Some(context)) => {
                    stack.pop();
                    &self.contexts[context].captures
                }
                (None, None) => return,
            };
            for (number, name) in names {
                if let Some(part) = hit.get(*number) {
                    note(part.start(), part.end(), name);
                }
            }
            moves = if whole.end() > at { 0 } else { moves + 1 };
            assert!(moves < 20, "no way on in: {line}");
            at = whole.end();
        }
    }
}
