//! A Python process with peers: it tells versions first, then answers lines of JSON with lines of JSON.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::Value;

/// The process, and what is installed there.
pub(crate) struct Peers {
    child: Child,
    requests: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
    /// Names and versions of what was looked for; `None` where it is not installed.
    pub(crate) versions: Vec<(String, Option<String>)>,
}

impl Peers {
    /// Starts a script with an interpreter.
    ///
    /// # Errors
    /// A sentence about why there are no peers.
    pub(crate) fn start(python: &str, script: &Path) -> Result<Self, String> {
        let mut child = Command::new(python)
            .arg(script)
            // Read when numpy is loaded.
            .env("OPENBLAS_NUM_THREADS", "1")
            .env("OMP_NUM_THREADS", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("`{python}` does not run: {error}"))?;
        let requests = child.stdin.take();
        let answers = child.stdout.take().ok_or("no pipe from Python")?;
        let mut peers = Self { child, requests, answers: BufReader::new(answers), versions: Vec::new() };
        let versions = peers.answer()?;
        let versions = versions.as_object().ok_or("Python does not tell its versions")?;
        peers.versions =
            versions.iter().map(|(name, version)| (name.clone(), version.as_str().map(str::to_owned))).collect();
        Ok(peers)
    }

    /// Sends a request.
    ///
    /// # Errors
    /// Where the process has ended.
    pub(crate) fn ask(&mut self, request: &Value) -> Result<(), String> {
        let requests = self.requests.as_mut().ok_or("no pipe to Python")?;
        let sent = writeln!(requests, "{request}").and_then(|()| requests.flush());
        sent.map_err(|error| format!("the peers are gone: {error}"))
    }

    /// The next answer.
    ///
    /// # Errors
    /// What the peer says where it gives up, or that the process has ended.
    pub(crate) fn answer(&mut self) -> Result<Value, String> {
        let mut line = String::new();
        let read = self.answers.read_line(&mut line);
        read.map_err(|error| format!("the peers are gone: {error}"))?;
        let answer: Value = serde_json::from_str(&line).map_err(|_| "the peers are gone")?;
        match answer["error"].as_str() {
            Some(error) => Err(error.to_owned()),
            None => Ok(answer),
        }
    }

    /// Whether a peer has what it needs.
    pub(crate) fn has(&self, package: &str) -> bool {
        self.versions.iter().any(|(name, version)| name == package && version.is_some())
    }
}

impl Drop for Peers {
    fn drop(&mut self) {
        // The script ends where its input ends.
        drop(self.requests.take());
        let _ = self.child.wait();
    }
}
