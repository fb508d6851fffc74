//! `librate lsp`: what an editor asks while a model is being written, by the Language Server Protocol on standard input and
//! output.
//!
//! At every change what was changed of the text is read, and all that needs nothing but the text is answered from it at
//! once. What needs the model is worked out beside it ([`check`]).

mod answers;
mod call;
mod check;
pub(super) mod complete;
mod document;
mod rest;

use std::collections::HashMap;
use std::io::{self, BufRead, Read, Write};
use std::process::ExitCode;
use std::sync::mpsc;
use std::time::{Duration, Instant};

use librate::budget::{Budget, Limit};
use lsp_server::{Connection, ErrorCode, Message, Notification, ProtocolError, Request, Response};
use serde_json::{Value, json};

use super::args::MessageFormat;
use super::{complain, fault};
use check::{Checker, Job};
use document::Document;

/// A model may take so many seconds, its modes included.
const SECONDS: u64 = 10;
/// The longest message read: the longest file, each of its bytes escaped.
const MOST_BYTES: u64 = 6 * librate::syntax::MOST_BYTES as u64 + (1 << 20);
/// How often is looked whether that time is over.
const INTERVAL: Duration = Duration::from_millis(100);

/// Serves one editor until it says that it ends.
pub(super) fn run() -> ExitCode {
    let (connection, client) = Connection::memory();
    let answers = client.receiver.clone();
    let writer = std::thread::spawn(move || answers.iter().try_for_each(|own| own.write(&mut io::stdout().lock())));
    let reader = std::thread::spawn(move || read(&client));
    let served = serve(&connection);
    // The threads end when nobody is left to send them anything.
    drop(connection);
    let told = |error: String| complain(fault(error), MessageFormat::Text);
    match served {
        Err(error) if !error.channel_is_disconnected() => ExitCode::from(told(format!("the editor: {error}"))),
        Err(_) => ExitCode::SUCCESS,
        Ok(()) => match reader.join().and_then(|read| Ok(read.and(writer.join()?))) {
            Ok(Err(error)) => ExitCode::from(told(format!("the editor: {error}"))),
            Ok(Ok(())) | Err(_) => ExitCode::SUCCESS,
        },
    }
}

/// The next message; one that is too long is passed over, and is none.
fn message(input: &mut impl BufRead) -> io::Result<Option<Message>> {
    let mut header = String::new();
    let mut length = 0;
    loop {
        let start = header.len();
        let read = input.read_line(&mut header)?;
        let line = header.get(start..).unwrap_or_default().trim_end();
        if read == 0 || line.is_empty() || !line.contains(": ") {
            break;
        }
        let value = line.split_once(": ").filter(|(name, _)| name.eq_ignore_ascii_case("Content-Length"));
        length = value.and_then(|(_, value)| value.parse().ok()).unwrap_or(length);
    }
    if length > MOST_BYTES {
        io::copy(&mut input.take(length), &mut io::sink())?;
        return Err(io::ErrorKind::InvalidData.into());
    }
    Message::read(&mut header.as_bytes().chain(input))
}

/// Hands on the messages of an editor until it ends; what is none has the answer of the protocol, and the next one is read.
fn read(editor: &Connection) -> io::Result<()> {
    loop {
        match message(&mut io::stdin().lock()) {
            Ok(Some(message)) => {
                let is_last = matches!(&message, Message::Notification(own) if own.method == "exit");
                if editor.sender.send(message).is_err() || is_last {
                    return Ok(());
                }
            }
            Ok(None) => return Ok(()),
            Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                let error = json!({"code": ErrorCode::ParseError as i32, "message": "this is no message"});
                let answer = json!({"jsonrpc": "2.0", "id": null, "error": error}).to_string();
                let mut output = io::stdout().lock();
                write!(output, "Content-Length: {}\r\n\r\n{answer}", answer.len())?;
                output.flush()?;
            }
            Err(error) => return Err(error),
        }
    }
}

fn capabilities() -> Value {
    json!({
        "positionEncoding": "utf-16",
        // Texts are sent whole.
        "textDocumentSync": {"openClose": true, "change": 1, "save": true},
        "hoverProvider": true,
        "definitionProvider": true,
        "referencesProvider": true,
        "renameProvider": {"prepareProvider": true},
        "completionProvider": {"triggerCharacters": [".", ":"]},
        "signatureHelpProvider": {"triggerCharacters": ["(", ","]},
        "documentSymbolProvider": true,
        "documentFormattingProvider": true,
        "inlayHintProvider": true,
        "codeLensProvider": {},
        "codeActionProvider": {"codeActionKinds": ["quickfix"]},
    })
}

fn serve(connection: &Connection) -> Result<(), ProtocolError> {
    let (id, client) = connection.initialize_start()?;
    let information = json!({"name": "librate", "version": env!("CARGO_PKG_VERSION")});
    connection.initialize_finish(id, json!({"capabilities": capabilities(), "serverInfo": information}))?;
    let (jobs, received) = mpsc::channel();
    let editor = connection.sender.clone();
    let send = Box::new(move |message| drop(editor.send(message)));
    let checker = Checker::new(send, &client["capabilities"]["workspace"]);
    let known = checker.known.clone();
    let worker = std::thread::spawn(move || checker.run(&received));
    let mut server = Server { documents: HashMap::new(), running: HashMap::new(), known, count: 0, jobs };
    let ended = server.messages(connection);
    server.running.values().for_each(|(budget, _)| drop(budget.stop(Limit::Time(SECONDS))));
    // Without its sender the worker ends.
    drop(server);
    let _ = worker.join();
    ended
}

struct Server {
    documents: HashMap<String, Document>,
    /// What is being checked, since when.
    running: HashMap<String, (Budget, Instant)>,
    known: check::Known,
    /// How many checks there were.
    count: u64,
    jobs: mpsc::Sender<Job>,
}

impl Server {
    fn messages(&mut self, connection: &Connection) -> Result<(), ProtocolError> {
        loop {
            // Without anything under way there is no time to watch.
            let message = if self.running.is_empty() {
                connection.receiver.recv().ok()
            } else {
                match connection.receiver.recv_timeout(INTERVAL) {
                    Ok(message) => Some(message),
                    Err(error) if error.is_timeout() => {
                        self.stop_overdue();
                        continue;
                    }
                    Err(_) => None,
                }
            };
            match message {
                // The editor is gone.
                None => return Ok(()),
                Some(Message::Request(request)) => {
                    if connection.handle_shutdown(&request)? {
                        return Ok(());
                    }
                    let _ = connection.sender.send(Message::Response(self.respond(request)));
                }
                Some(Message::Notification(told)) => {
                    if let Some(answer) = self.note(&told) {
                        let _ = connection.sender.send(Message::Notification(answer));
                    }
                }
                // That a display was renewed.
                Some(Message::Response(_)) => {}
            }
        }
    }

    fn stop_overdue(&mut self) {
        self.running.retain(|_, (budget, since)| {
            let is_over = since.elapsed() > Duration::from_secs(SECONDS);
            if is_over {
                budget.stop(Limit::Time(SECONDS));
            }
            !is_over
        });
    }

    /// Follows the texts that are open.
    fn note(&mut self, told: &Notification) -> Option<Notification> {
        let document = &told.params["textDocument"];
        let uri = document["uri"].as_str()?;
        let text = match told.method.as_str() {
            "textDocument/didOpen" => document["text"].as_str()?,
            "textDocument/didChange" => told.params["contentChanges"].as_array()?.last()?["text"].as_str()?,
            // Its tables may have changed as well.
            "textDocument/didSave" => return self.check(uri),
            "textDocument/didClose" => {
                self.documents.remove(uri);
                if let Some((budget, _)) = self.running.remove(uri) {
                    budget.stop(Limit::Time(SECONDS));
                }
                check::lock(&self.known).remove(uri);
                return Some(check::published(uri, None, Vec::new()));
            }
            _ => return None,
        };
        let read = Document::read(uri, document["version"].as_i64(), text, self.documents.get(uri));
        self.documents.insert(uri.to_owned(), read);
        self.check(uri)
    }

    /// Has a text checked; what was under way with it is of no use any more.
    fn check(&mut self, uri: &str) -> Option<Notification> {
        let document = self.documents.get(uri)?.clone();
        if let Some((budget, _)) = self.running.remove(uri) {
            budget.stop(Limit::Time(SECONDS));
        }
        let budget = Budget::default();
        self.running.insert(uri.to_owned(), (budget.clone(), Instant::now()));
        self.count += 1;
        check::lock(&self.known).entry(uri.to_owned()).or_default().latest = self.count;
        // The worker lives as long as the server.
        let _ = self.jobs.send(Job { document, budget, number: self.count });
        None
    }

    fn respond(&self, request: Request) -> Response {
        let Request { id, method, params } = request;
        let not_answered =
            |id, method| Response::new_err(id, ErrorCode::MethodNotFound as i32, format!("`{method}` is not answered"));
        let Some(uri) = params["textDocument"]["uri"].as_str() else { return not_answered(id, method) };
        let Some(document) = self.documents.get(uri) else {
            return Response::new_err(id, ErrorCode::InvalidParams as i32, format!("`{uri}` is not open"));
        };
        let facts = check::lock(&self.known).get(uri).map(|own| own.facts.clone()).unwrap_or_default();
        let at = document.lines().offset(&params["position"]);
        let answer = match method.as_str() {
            "textDocument/hover" => answers::hover(document, &facts, at),
            "textDocument/definition" => answers::definition(document, at),
            "textDocument/references" => {
                answers::references(document, at, params["context"]["includeDeclaration"] == json!(true))
            }
            "textDocument/prepareRename" => answers::renamed_place(document, at),
            "textDocument/rename" => {
                match answers::rename(document, at, params["newName"].as_str().unwrap_or_default()) {
                    Ok(edit) => edit,
                    Err(reason) => return Response::new_err(id, ErrorCode::RequestFailed as i32, reason),
                }
            }
            "textDocument/completion" => complete::completion(document, &facts, at),
            "textDocument/signatureHelp" => call::help(document, at),
            "textDocument/documentSymbol" => answers::outline(document),
            "textDocument/formatting" => answers::formatted(document),
            "textDocument/inlayHint" => answers::hints(document, &facts, &params["range"]),
            "textDocument/codeLens" => answers::lens(&facts),
            "textDocument/codeAction" => answers::fixes(document, &facts, &params["range"]),
            _ => return not_answered(id, method),
        };
        Response::new_ok(id, answer)
    }
}
