//! `librate repl`: a model that is entered line by line, and how its frequencies move.

mod statements;

use std::io::{self, BufRead, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::{Child, Command as Process, ExitCode, Stdio};

use clap::CommandFactory;
use librate::diagnostic::{Diagnostic, nearest};
use librate::model::{ModelError, Settings, TableTexts, elaborate, units_with_prefixes};
use librate::syntax::{self, FUNCTIONS, STATEMENT_WORDS, StatementKind};
use rustyline::completion::Completer;
use rustyline::error::ReadlineError;
use rustyline::highlight::Highlighter;
use rustyline::hint::Hinter;
use rustyline::history::DefaultHistory;
use rustyline::validate::Validator;
use rustyline::{Editor, Helper};
use serde_json::Value;

use super::args::{Cli, MessageFormat};
use super::input::{Source, read_model};
use super::lsp::complete::{is_letter, is_unit, without_word};
use super::output::{feed, same_file, write_file, write_messages, write_out};
use super::{Failure, complain, ended, fault};
use statements::{Typed, behind_equals, bindings_of, declared, declared_name, rank, with_member, with_value};

const HELP: &str = "\
a statement          declares, or takes the place of what declared the same name: `param k = 8`
NAME = VALUE         another value for a parameter or a `let`, `m[2] = 3` for a member of a family
modes, derive, …     a command of librate about the model, with its options: `modes --digits 20`
text                 the model so far
undo                 as before the last change
save FILE            writes the model; `save FILE --force` over what is there already
quit                 ends it, as Ctrl-D does
";

/// Words of our own, beside the commands.
const WORDS: [&str; 6] = ["help", "text", "undo", "save", "quit", "exit"];
/// Commands that have no model, or go on for ever.
const OTHERS: [&str; 6] = ["fmt", "watch", "repl", "lsp", "completions", "man"];

/// The model so far.
struct Session {
    /// One statement each, with the comments above it.
    entries: Vec<String>,
    before: Vec<Vec<String>>,
    /// The frequencies at the last change.
    omegas: Vec<String>,
    /// What it was opened from or saved to, which may be written over.
    file: Option<PathBuf>,
    format: MessageFormat,
}

/// Reads and answers until the input ends; `file`: a model to begin with.
pub(super) fn run(file: Option<&Path>, format: MessageFormat) -> ExitCode {
    let mut session = Session { entries: Vec::new(), before: Vec::new(), omegas: Vec::new(), file: None, format };
    let mut go = || -> Result<(), Failure> {
        if let Some(file) = file {
            session.open(file)?;
        }
        if io::stdin().is_terminal() { session.converse() } else { session.read(io::stdin().lock()) }
    };
    ended(go(), format)
}

/// Whether the conversation goes on.
type More = bool;

impl Session {
    /// With a prompt, history and completion.
    fn converse(&mut self) -> Result<(), Failure> {
        let cannot = |error: ReadlineError| fault(format!("can't read from the terminal: {error}"));
        let mut editor: Editor<Words, DefaultHistory> = Editor::new().map_err(cannot)?;
        let kept = history_file();
        // There is none the first time.
        let _ = kept.as_ref().map(|file| editor.load_history(file));
        let mut pending = String::new();
        loop {
            editor.set_helper(Some(Words { names: self.names() }));
            let prompt = if pending.is_empty() { "librate> " } else { "       > " };
            let line = match editor.readline(prompt) {
                Ok(line) => line,
                Err(ReadlineError::Interrupted) => {
                    pending.clear();
                    continue;
                }
                Err(ReadlineError::Eof) => return Ok(()),
                Err(error) => return Err(cannot(error)),
            };
            let _ = editor.add_history_entry(&line);
            let _ = kept.as_ref().map(|file| editor.append_history(file));
            if !self.take(&mut pending, &line)? {
                return Ok(());
            }
        }
    }

    fn read(&mut self, input: impl BufRead) -> Result<(), Failure> {
        let mut pending = String::new();
        for line in input.lines() {
            let line = line.map_err(|error| fault(format!("can't read from standard input: {error}")))?;
            if !self.take(&mut pending, &line)? {
                return Ok(());
            }
        }
        Ok(())
    }

    /// One line more; within brackets a statement goes on.
    fn take(&mut self, pending: &mut String, line: &str) -> Result<More, Failure> {
        if !pending.is_empty() {
            pending.push('\n');
        }
        pending.push_str(line);
        let code = || pending.lines().filter_map(|line| line.split('#').next()).flat_map(str::chars);
        let count = |set: &str| code().filter(|c| set.contains(*c)).count();
        if count("([{") > count(")]}") {
            return Ok(true);
        }
        let text = std::mem::take(pending);
        match self.answer(text.trim()) {
            Ok(more) => Ok(more),
            Err(Failure::BrokenPipe) => Err(Failure::BrokenPipe),
            Err(failure) => {
                complain(failure, self.format);
                Ok(true)
            }
        }
    }

    fn answer(&mut self, text: &str) -> Result<More, Failure> {
        let words = split(text);
        let Some(first) = words.first() else { return Ok(true) };
        let declares = words.get(1).is_some_and(|word| word.starts_with(['=', ':', '[']));
        let has_operand = words.get(1).is_some_and(|word| !word.starts_with('-'));
        match first.as_str() {
            _ if declares => self.change(text)?,
            "quit" | "exit" => return Ok(false),
            "help" => write_out(HELP)?,
            "text" => write_out(&self.text())?,
            "undo" => match self.before.pop() {
                Some(before) => {
                    self.entries = before;
                    self.show()?;
                }
                None => return Err(fault("nothing has been changed".to_owned())),
            },
            "save" => {
                let file = words.get(1).ok_or_else(|| fault("save it where? `save model.lag`".to_owned()))?;
                let is_own = self.file.as_ref().is_some_and(|own| same_file(own, Path::new(file)));
                if !is_own && Path::new(file).exists() && words.get(2).is_none_or(|word| word != "--force") {
                    return Err(fault(format!("`{file}` is there already: `save {file} --force` writes over it")));
                }
                let mut source = Source { name: String::new(), text: String::new(), taken: Vec::new() };
                write_file(Path::new(file), &self.text(), &mut source)?;
                self.file = Some(PathBuf::from(file));
            }
            // `period` is a statement as well, with an expression in place of options.
            command if is_command(command) && !(STATEMENT_WORDS.contains(&command) && has_operand) => {
                self.run(&words)?;
            }
            "set" if text.contains('=') => {
                return Err(fault(format!("write `{}`", text.trim_start_matches("set").trim_start())));
            }
            word if words.len() == 1 && is_name(word) && !STATEMENT_WORDS.contains(&word) => {
                return Err(fault(self.about(word)));
            }
            _ => self.change(text)?,
        }
        Ok(true)
    }

    /// What to do with a word alone.
    fn about(&self, word: &str) -> String {
        let command = Cli::command();
        let commands = command.get_subcommands().map(clap::Command::get_name).filter(|own| !OTHERS.contains(own));
        let text = self.text();
        let is_parameter =
            statements(&text).iter().any(|own| own.kind.parameters().iter().any(|own| *own.name.text == *word));
        match nearest(word, commands.chain(WORDS)) {
            _ if is_parameter => {
                format!("`{word} = VALUE` gives the parameter another value, `text` shows what is declared")
            }
            _ if self.names().iter().any(|own| own == word) => format!("`{word}` is declared: `text` shows the model"),
            Some(meant) => format!("there is no command `{word}`: did you mean `{meant}`?"),
            None => format!("there is no command `{word}`: `help` lists what can be typed"),
        }
    }

    /// Begins with a file.
    fn open(&mut self, file: &Path) -> Result<(), Failure> {
        self.file = Some(file.to_owned());
        let source = read_model(file)?;
        let told = |all: Vec<_>| Failure::Model(source.clone(), all.iter().map(Diagnostic::from).collect());
        let parsed = syntax::parse(&source.text).map_err(told)?;
        let mut done = 0;
        for statement in &parsed.statements {
            let end = statement.span.range().end;
            self.entries.push(source.text[done..end].trim().to_owned());
            done = end;
        }
        self.show()
    }

    fn text(&self) -> String {
        entered(&self.entries)
    }

    /// Statements, or another value.
    fn change(&mut self, text: &str) -> Result<(), Failure> {
        let before = self.entries.clone();
        let done = match given(text) {
            Some(name) => self.set(name, text).and_then(|()| self.check(&before)),
            None => self.declare(text),
        };
        if let Err(failure) = done {
            self.entries = before;
            return Err(failure);
        }
        self.before.push(before);
        self.show()
    }

    /// A value that makes a mistake is no value.
    fn check(&self, before: &[String]) -> Result<(), Failure> {
        let told = |text: &str| -> Vec<Diagnostic> { mistakes(text).iter().map(Diagnostic::from).collect() };
        let known: Vec<String> = told(&entered(before)).into_iter().map(|own| own.message).collect();
        let new: Vec<Diagnostic> = told(&self.text()).into_iter().filter(|own| !known.contains(&own.message)).collect();
        if new.is_empty() {
            return Ok(());
        }
        Err(Failure::Model(Source { name: "<input>".to_owned(), text: self.text(), taken: Vec::new() }, new))
    }

    fn declare(&mut self, text: &str) -> Result<(), Failure> {
        let parsed = syntax::parse(text).map_err(|errors| wrong(text, &errors))?;
        for statement in &parsed.statements {
            let own = declared(&statement.kind, text);
            let others = |entry: &String| -> Vec<String> {
                statements(entry).iter().flat_map(|other| declared(&other.kind, entry)).collect()
            };
            let new = text[statement.span.range()].to_owned();
            let places = |is_same: &dyn Fn(&String) -> bool| -> Vec<usize> {
                (0..self.entries.len()).filter(|at| others(&self.entries[*at]).iter().any(is_same)).collect()
            };
            let mut same = places(&|name| own.contains(name));
            // Members of a family that are declared one by one stand beside each other, unless one of them is given twice then.
            let family = |name: &str| name.split('[').next().unwrap_or_default().to_owned();
            let families: Vec<String> = own.iter().map(|own| family(own)).collect();
            let clashes = same.is_empty() && !given_twice(&self.text()) && given_twice(&(self.text() + &new));
            let is_member = |name: &String| name.contains('[') && !name.contains("..");
            if clashes && let Some(member) = own.iter().find(|name| is_member(name)) {
                return Err(fault(format!(
                    "`{member}` is declared with others of its family: declare all of them again"
                )));
            }
            if clashes {
                same = places(&|name| families.contains(&family(name)));
            }
            let is_replaced = |name: &String| own.contains(name) || clashes && families.contains(&family(name));
            let all = same.iter().flat_map(|at| others(&self.entries[*at])).collect::<Vec<_>>();
            if let Some(left) = all.iter().find(|name| !is_replaced(name)) {
                let has_value = matches!(statement.kind, StatementKind::Param(_));
                let how = if has_value { ", or give a value with `NAME = VALUE`" } else { "" };
                return Err(fault(format!("`{left}` is declared in the same statement: declare all of it again{how}")));
            }
            match same.split_first() {
                Some((at, rest)) => {
                    self.entries[*at] = new;
                    rest.iter().rev().for_each(|at| drop(self.entries.remove(*at)));
                }
                // What others are made from stands above them.
                None => {
                    let own = rank(&statement.kind);
                    let before = |entry: &String| statements(entry).iter().all(|other| rank(&other.kind) <= own);
                    let at = self.entries.iter().rposition(before).map_or(0, |at| at + 1);
                    self.entries.insert(at, new);
                }
            }
        }
        Ok(())
    }

    /// Puts the value of `NAME = VALUE` into the statements that give one to the name.
    fn set(&mut self, name: &str, text: &str) -> Result<(), Failure> {
        let typed = format!("param {}", text.replacen("][", ", ", text[..name.len()].matches("][").count()));
        let parsed = syntax::parse(&typed).map_err(|errors| wrong(&typed, &errors))?;
        let [syntax::Statement { kind: StatementKind::Param(bindings), span }] = parsed.statements.as_slice() else {
            return self.declare(text);
        };
        let [new] = bindings.as_slice() else { return self.declare(text) };
        let Some(value) = new.value else { return self.declare(text) };
        let value = Typed {
            text: typed[behind_equals(&typed, parsed.expr(value).span.start)..span.range().end].trim(),
            is_uncertain: new.uncertainty.is_some(),
        };
        let wanted = declared_name(&new.name, new.indices.as_deref(), &typed);
        let [mut is_declared, mut is_given] = [false; 2];
        for entry in &mut self.entries {
            let count = statements(entry).iter().map(|own| bindings_of(&own.kind).len()).sum();
            // From the last one on: what is changed moves none before it.
            for at in (0..count).rev() {
                let Ok(parsed) = syntax::parse(entry) else { continue };
                let Some(statement) = parsed.statements.first() else { continue };
                let Some(old) = bindings_of(&statement.kind).get(at) else { continue };
                if old.name.text != new.name.text {
                    continue;
                }
                is_declared = true;
                let own = declared_name(&old.name, old.indices.as_deref(), entry);
                let changed = if new.indices.is_none() || own == wanted {
                    Some(with_value(&parsed, statement, at, entry, &value))
                } else {
                    with_member(&parsed, statement, at, (entry, &typed, new), value.text)
                };
                let Some(changed) = changed else { continue };
                syntax::parse(&changed).map_err(|errors| wrong(&changed, &errors))?;
                *entry = changed;
                is_given = true;
            }
        }
        match (is_given, is_declared) {
            (true, _) => Ok(()),
            (false, true) => Err(fault(format!(
                "`{wanted}` has no value of its own: `{0} = VALUE` gives one to all of `{0}`",
                new.name.text
            ))),
            // As a line of the model it is explained.
            (false, false) => {
                let whole = self.text() + text;
                syntax::parse(&whole).map_err(|errors| wrong(&whole, &errors))?;
                self.declare(text)
            }
        }
    }

    /// All names that are declared.
    fn names(&self) -> Vec<String> {
        let text = self.text();
        let names = statements(&text).iter().flat_map(|statement| declared(&statement.kind, &text)).collect::<Vec<_>>();
        let name = |declared: String| Some(declared.split('[').next()?.split_whitespace().last()?.to_owned());
        names.into_iter().filter_map(name).collect()
    }

    /// The frequencies, and what they were, once there are energies.
    fn show(&mut self) -> Result<(), Failure> {
        let text = self.text();
        let Ok(parsed) = syntax::parse(&text) else { return Ok(()) };
        let has = |wanted: fn(&StatementKind) -> bool| parsed.statements.iter().any(|own| wanted(&own.kind));
        let whole = has(|kind| matches!(kind, StatementKind::Coord { .. }))
            && (has(|kind| matches!(kind, StatementKind::Lagrangian(_)))
                || has(|kind| matches!(kind, StatementKind::Kinetic(_)))
                    && has(|kind| matches!(kind, StatementKind::Potential(_))));
        if !whole {
            return Ok(());
        }
        let mut child = own_process(&["modes", "-", "--json", "--no-vectors"], Stdio::piped)?;
        feed(&mut child, &text);
        let output = child.wait_with_output().map_err(|error| fault(error.to_string()))?;
        // Warnings are for a model that is finished.
        let Ok(found) = serde_json::from_slice::<Value>(&output.stdout) else {
            write_messages(&String::from_utf8_lossy(&output.stderr));
            return Ok(());
        };
        let modes = found["modes"].as_array().map(Vec::as_slice).unwrap_or_default();
        let word = |mode: &Value, name: &str| mode[name].as_str().unwrap_or_default().to_owned();
        let omegas: Vec<String> = modes.iter().map(|mode| word(mode, "omega_digits")).collect();
        let none = if modes.is_empty() { "nothing moves freely: there are no modes\n" } else { "" };
        let mut out = none.to_owned();
        for (at, (mode, omega)) in modes.iter().zip(&omegas).enumerate() {
            let was = self.omegas.get(at).filter(|was| self.omegas.len() == omegas.len() && *was != omega);
            let was = was.map_or_else(String::new, |was| format!("   was {was}"));
            let growth = Some(word(mode, "growth_digits")).filter(|growth| growth != "0");
            let growth = growth.map_or_else(String::new, |growth| format!("   growth {growth}"));
            out.push_str(&format!("{:>4}  {:<12} omega {omega}{growth}{was}\n", at + 1, word(mode, "kind")));
        }
        self.omegas = omegas;
        write_out(&out)
    }

    /// Another command, about the model so far.
    fn run(&self, words: &[String]) -> Result<(), Failure> {
        let mut words: Vec<&str> = words.iter().map(String::as_str).collect();
        // `plot` has a word more before the file.
        let at = if words.first() == Some(&"plot") { 2 } else { 1 };
        if words.first() != Some(&"explain") {
            words.insert(at.min(words.len()), "-");
        }
        let mut child = own_process(&words, Stdio::inherit)?;
        feed(&mut child, &self.text());
        child.wait().map(drop).map_err(|error| fault(error.to_string()))
    }
}

/// The name or the member in `NAME = VALUE`.
fn given(text: &str) -> Option<&str> {
    let name = text.split_once('=')?.0.trim_end();
    let (head, indices) = name.find('[').map_or((name, "[]"), |at| name.split_at(at));
    (is_name(head.trim_end()) && !STATEMENT_WORDS.contains(&head.trim_end()) && indices.ends_with(']')).then_some(name)
}

/// A model of so many statements.
fn entered(entries: &[String]) -> String {
    entries.iter().map(|entry| format!("{entry}\n")).collect()
}

/// What is wrong with a text that can be read.
fn mistakes(text: &str) -> Vec<ModelError> {
    let found = syntax::parse(text).map(|file| elaborate(&file, &TableTexts::new(), &Settings::new()));
    found.ok().and_then(Result::err).unwrap_or_default()
}

/// Whether something is declared twice.
fn given_twice(text: &str) -> bool {
    mistakes(text).iter().any(|own| matches!(own, ModelError::GivenTwice { .. }))
}

/// Where the lines are kept that were typed on a terminal: in the folder for data of the user, where there can be one.
fn history_file() -> Option<PathBuf> {
    let folder = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|own| own.is_absolute());
    let data = if cfg!(windows) {
        folder("APPDATA")
    } else if cfg!(target_os = "macos") {
        folder("HOME").map(|home| home.join("Library/Application Support"))
    } else {
        folder("XDG_DATA_HOME").or_else(|| Some(folder("HOME")?.join(".local/share")))
    };
    let own = data?.join("librate");
    std::fs::create_dir_all(&own).ok()?;
    Some(own.join("history"))
}

/// The statements of a text, none where it can't be read.
fn statements(text: &str) -> Vec<syntax::Statement> {
    syntax::parse(text).map(|file| file.statements).unwrap_or_default()
}

/// This program once more, with what it says handed on or kept.
fn own_process(words: &[&str], output: fn() -> Stdio) -> Result<Child, Failure> {
    let start = |own| Process::new(own).args(words).stdin(Stdio::piped()).stdout(output()).stderr(output()).spawn();
    std::env::current_exe().and_then(start).map_err(|error| fault(format!("can't run the command: {error}")))
}

/// What is wrong with what was typed.
fn wrong(text: &str, errors: &[syntax::SyntaxError]) -> Failure {
    let source = Source { name: "<input>".to_owned(), text: text.to_owned(), taken: Vec::new() };
    Failure::Model(source, errors.iter().map(Diagnostic::from).collect())
}

fn is_command(word: &str) -> bool {
    !OTHERS.contains(&word) && Cli::command().get_subcommands().any(|own| own.get_name() == word)
}

fn is_name(text: &str) -> bool {
    let mut letters = text.chars();
    letters.next().is_some_and(char::is_alphabetic) && letters.all(is_letter)
}

/// Words between spaces, as a shell has them; quotes hold together.
fn split(text: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut quote = None;
    let mut within = false;
    for c in text.chars() {
        if quote == Some(c) {
            quote = None;
        } else if quote.is_none() && c.is_whitespace() {
            within = false;
        } else {
            if !within {
                words.push(String::new());
            }
            match words.last_mut() {
                // At the beginning of a word, or of a value.
                Some(word) if quote.is_none() && "'\"".contains(c) && (!within || word.ends_with('=')) => {
                    quote = Some(c)
                }
                Some(word) => word.push(c),
                None => {}
            }
            within = true;
        }
    }
    words
}

/// Completion of words and names.
struct Words {
    names: Vec<String>,
}

impl Completer for Words {
    type Candidate = String;

    fn complete(&self, line: &str, at: usize, _: &rustyline::Context<'_>) -> rustyline::Result<(usize, Vec<String>)> {
        let start = without_word(&line[..at]).len();
        let begun = &line[start..at];
        if is_unit(&line[..start]) {
            let mut units: Vec<String> = units_with_prefixes().filter(|unit| unit.starts_with(begun)).collect();
            units.sort();
            return Ok((start, units));
        }
        let command = Cli::command();
        let commands = command.get_subcommands().map(clap::Command::get_name).filter(|own| !OTHERS.contains(own));
        // Commands stand at the beginning.
        let commands = commands.chain(WORDS).filter(|_| start == 0);
        let all = commands.chain(STATEMENT_WORDS).chain(FUNCTIONS).chain(self.names.iter().map(String::as_str));
        let mut found: Vec<String> = all.filter(|word| word.starts_with(begun)).map(str::to_owned).collect();
        found.sort();
        found.dedup();
        Ok((start, found))
    }
}

impl Hinter for Words {
    type Hint = String;
}
impl Highlighter for Words {}
impl Validator for Words {}
impl Helper for Words {}
