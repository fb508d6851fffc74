'use strict';
// The language server beside the editor, and the page of `librate show` beside the text.

const { execFile } = require('node:child_process');
const { randomBytes } = require('node:crypto');
const { dirname } = require('node:path');
const { ViewColumn, commands, window, workspace } = require('vscode');
const { LanguageClient } = require('vscode-languageclient/node');

const LANGUAGE = 'librate';
const SETTING = 'librate.path';
/** A page is a few hundred kilobytes; this is where a mistake begins. */
const MOST_BYTES = 64 * 1024 * 1024;

let client;
/** The pages that are open, by the address of their model. */
const pages = new Map();

const program = () => workspace.getConfiguration().get(SETTING) || 'librate';

/** What a program prints. It is given `input`, and ended by `signal`. */
function run(args, { input = '', cwd, signal } = {}) {
  return new Promise((resolve, reject) => {
    const child = execFile(program(), args, { cwd, signal, maxBuffer: MOST_BYTES }, (error, output, errors) => {
      if (error) reject(Object.assign(error, { errors })); else resolve(output);
    });
    // Whoever ends before it has read everything says why by itself.
    child.stdin?.on('error', () => {});
    child.stdin?.end(input);
  });
}

/** Says how to get the program, if that is what is missing. */
async function missing(error) {
  const reason = error.code === 'ENOENT' ? `There is no program “${program()}”.` : `“${program()}” doesn't run: ${error.message}`;
  const choose = 'Set its path';
  const help = 'Install it with `cargo install --path .` in the folder of librate, or set its path.';
  if (await window.showErrorMessage(`${reason} ${help}`, choose) === choose) {
    await commands.executeCommand('workbench.action.openSettings', SETTING);
  }
}

async function start() {
  try {
    await run(['--version']);
  } catch (error) {
    void missing(error);
    return;
  }
  client = new LanguageClient(LANGUAGE, 'librate', { command: program(), args: ['lsp'] }, { documentSelector: [{ language: LANGUAGE }] });
  await client.start();
}

async function stop() {
  const old = client;
  client = undefined;
  await old?.dispose();
}

const escaped = text => text.replace(/[&<>]/g, sign => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;' })[sign]);

/** The page as a webview may have it: only its own scripts run, and nothing is loaded. */
function guarded(page) {
  const nonce = randomBytes(16).toString('base64');
  const policy = `default-src 'none'; style-src 'unsafe-inline'; script-src 'nonce-${nonce}'`;
  // Text of the model has no `<` of its own in the page.
  return page
    .replaceAll('<script', `<script nonce="${nonce}"`)
    .replace('<head>', `<head>\n<meta http-equiv="Content-Security-Policy" content="${policy}">`);
}

async function render(document) {
  const page = pages.get(document.uri.toString());
  if (!page) return;
  page.running.abort();
  const { signal } = page.running = new AbortController();
  const cwd = document.uri.scheme === 'file' ? dirname(document.uri.fsPath) : undefined;
  let html;
  try {
    html = await run(['show', '-'], { input: document.getText(), cwd, signal });
  } catch (error) {
    if (signal.aborted) return;
    if (error.code === 'ENOENT') void missing(error);
    html = `<!DOCTYPE html>\n<html lang="en">\n<head>\n</head>\n<body><pre>${escaped(error.errors || error.message)}</pre></body>\n</html>\n`;
  }
  // A later run may have been started, or the page closed.
  if (!signal.aborted) page.panel.webview.html = guarded(html);
}

function showModes() {
  const document = window.activeTextEditor?.document;
  if (document?.languageId !== LANGUAGE) {
    void window.showInformationMessage('First open a model: a file that ends in .lag.');
    return undefined;
  }
  const key = document.uri.toString();
  const open = pages.get(key);
  if (open) {
    open.panel.reveal(undefined, true);
  } else {
    const title = `Modes of ${document.uri.path.split('/').pop()}`;
    const where = { viewColumn: ViewColumn.Beside, preserveFocus: true };
    const panel = window.createWebviewPanel('librate.modes', title, where, { enableScripts: true, localResourceRoots: [] });
    const page = { panel, running: new AbortController() };
    pages.set(key, page);
    panel.onDidDispose(() => {
      page.running.abort();
      pages.delete(key);
    });
  }
  return render(document);
}

exports.activate = async context => {
  context.subscriptions.push(
    commands.registerCommand('librate.showModes', showModes),
    workspace.onDidSaveTextDocument(render),
    workspace.onDidChangeConfiguration(async change => {
      if (change.affectsConfiguration(SETTING)) {
        await stop();
        await start();
      }
    }),
  );
  await start();
};

exports.deactivate = stop;
