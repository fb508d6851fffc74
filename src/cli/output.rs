//! Writing: what goes to standard output, to standard error and into files, all of it.

use std::borrow::Cow;
use std::fmt::Display;
use std::fs::{self, File, Metadata};
use std::io::{self, BufWriter, ErrorKind, IsTerminal, Seek, SeekFrom, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use anstream::stream::RawStream;
use anstream::{AutoStream, ColorChoice};
use tempfile::{Builder, NamedTempFile};

use super::input::{self, Source};
use super::{Failure, fault};

/// The text as a terminal may have it: what is not seen, and could hide, turn round or overwrite what is, stands as its
/// number. Ends of lines and tabs stay, and where there is colour our own escape sequences for it.
pub(super) fn visible(text: &str, color: bool) -> Cow<'_, str> {
    replaced(text, |rest, c| match c {
        '\n' | '\t' => None,
        '\r' if rest.starts_with("\r\n") => None,
        '\u{1b}' if color && is_style(rest) => None,
        _ => Some(format!("<U+{:04X}>", u32::from(c))),
    })
}

/// The same for JSON, in whose strings alone such characters may stand.
pub(super) fn visible_json(json: &str) -> Cow<'_, str> {
    replaced(json, |_, c| match c {
        '\n' | '\t' | '\r' => None,
        _ => {
            let mut units = [0; 2];
            Some(c.encode_utf16(&mut units).iter().map(|unit| format!("\\u{unit:04x}")).collect())
        }
    })
}

/// Replaces characters that are not seen by what `instead` gives for the rest of the text and its first character.
fn replaced(text: &str, instead: impl Fn(&str, char) -> Option<String>) -> Cow<'_, str> {
    // Many bytes at once, without a branch for each.
    let is_plain = |all: bool, byte: &u8| all & matches!(byte, b' '..=b'~' | b'\n' | b'\t');
    if text.as_bytes().chunks(256).all(|bytes| bytes.iter().fold(true, is_plain)) {
        return Cow::Borrowed(text);
    }
    let mut out = String::new();
    let mut done = 0;
    for (at, c) in text.char_indices().filter(|(_, c)| is_hidden(*c)) {
        if let Some(shown) = instead(&text[at..], c) {
            out.push_str(&text[done..at]);
            out.push_str(&shown);
            done = at + c.len_utf8();
        }
    }
    if done == 0 {
        return Cow::Borrowed(text);
    }
    out.push_str(&text[done..]);
    Cow::Owned(out)
}

/// Control characters, and Unicode's marks of direction, line ends, fillers and tags. Joiners, which words need, are none.
fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}

/// Whether the text begins with `ESC [ 1 ; 31 m`.
fn is_style(text: &str) -> bool {
    let numbers = text.strip_prefix("\u{1b}[").unwrap_or_default();
    numbers.trim_start_matches(|c: char| c.is_ascii_digit() || c == ';').starts_with('m')
}

/// Whether standard output was closed when the program began. Before `main`, the runtime opens `/dev/null` in its place,
/// and then nothing tells that from one that was meant.
#[cfg(unix)]
mod at_start {
    use std::sync::atomic::{AtomicBool, Ordering};

    static CLOSED: AtomicBool = AtomicBool::new(false);

    extern "C" fn look() {
        let flags = rustix::io::fcntl_getfd(rustix::stdio::stdout());
        CLOSED.store(flags.is_err(), Ordering::Relaxed);
    }

    #[used]
    #[allow(
        unsafe_code,
        reason = "a table of functions that run before `main`, filled with one of the right type; it calls the kernel once"
    )]
    #[cfg_attr(target_vendor = "apple", unsafe(link_section = "__DATA,__mod_init_func"))]
    #[cfg_attr(not(target_vendor = "apple"), unsafe(link_section = ".init_array"))]
    static LOOK: extern "C" fn() = look;

    pub(super) fn closed() -> bool {
        CLOSED.load(Ordering::Relaxed)
    }
}

#[cfg(not(unix))]
mod at_start {
    pub(super) fn closed() -> bool {
        false
    }
}

/// Whether what is written there may have colours.
pub(super) fn has_color(stream: &impl RawStream) -> bool {
    AutoStream::choice(stream) != ColorChoice::Never
}

/// Writes a result for people or programs.
pub(super) fn write_out(text: &str) -> Result<(), Failure> {
    write_bytes(visible(text, has_color(&io::stdout())).as_bytes())
}

/// Writes a result through the reader's pager where it is longer than the terminal: `PAGER`, else `less`; without one where
/// that is empty or can't be run.
pub(super) fn write_paged(text: &str) -> Result<(), Failure> {
    let shown = visible(text, has_color(&io::stdout()));
    let height = terminal_size::terminal_size().map(|(_, terminal_size::Height(lines))| usize::from(lines));
    let is_long = io::stdout().is_terminal() && height.is_some_and(|height| shown.lines().count() >= height);
    if is_long && is_read_in_pager(&shown) { Ok(()) } else { write_bytes(shown.as_bytes()) }
}

/// Whether a pager could be started; one that is left before the end has shown enough.
fn is_read_in_pager(text: &str) -> bool {
    let pager = std::env::var("PAGER").unwrap_or_else(|_| "less".to_owned());
    let mut words = pager.split_whitespace();
    let Some(program) = words.next() else { return false };
    let mut command = Command::new(program);
    command.args(words).stdin(Stdio::piped());
    if std::env::var_os("LESS").is_none() {
        // Colours as they are, nothing cleared, and no wait where all fits.
        command.env("LESS", "FRX");
    }
    let Ok(mut child) = command.spawn() else { return false };
    feed(&mut child, text);
    child.wait().is_ok()
}

/// Hands a text to a process; one that ends before it has read everything has seen enough.
pub(super) fn feed(child: &mut Child, text: &str) {
    if let Some(mut input) = child.stdin.take() {
        let _ = input.write_all(text.as_bytes());
    }
}

/// Writes a text of the user's own: as it is, unless somebody looks at it.
pub(super) fn write_data(text: &str) -> Result<(), Failure> {
    if io::stdout().is_terminal() { write_out(text) } else { write_bytes(text.as_bytes()) }
}

fn write_bytes(bytes: &[u8]) -> Result<(), Failure> {
    write_rest(|out| out.write_all(bytes).map_err(failed))
}

/// Writes what is worked out meanwhile, numbers and names of a model.
pub(super) fn write_rest(rest: impl FnOnce(&mut dyn Write) -> Result<(), Failure>) -> Result<(), Failure> {
    if at_start::closed() {
        return Err(not_written(&"standard output is closed"));
    }
    let mut out = BufWriter::new(io::stdout().lock());
    rest(&mut out)?;
    out.flush().map_err(failed)
}

/// Why a result was not written.
pub(super) fn failed(error: io::Error) -> Failure {
    if error.kind() == ErrorKind::BrokenPipe { Failure::BrokenPipe } else { not_written(&error) }
}

fn not_written(reason: &dyn Display) -> Failure {
    fault(format!("can't write the result: {reason}"))
}

/// Writes messages. Where not even this can be done, the exit status has to do.
pub(super) fn write_messages(text: &str) {
    let stream = io::stderr();
    let shown = visible(text, has_color(&stream));
    let _ = stream.lock().write_all(shown.as_bytes());
}

/// Leaves a terminal empty for what comes next.
pub(super) fn clear_screen() {
    let mut stream = io::stdout().lock();
    let _ = stream.write_all(b"\x1b[2J\x1b[3J\x1b[H").and_then(|()| stream.flush());
}

/// What writes a file; it may be called more than once.
pub(super) type Content<'a> = &'a dyn Fn(&File) -> io::Result<()>;

/// Writes a picture or a table into a file, but over nothing that was read or written by the same command.
pub(super) fn write_file(file: &Path, text: &str, source: &mut Source) -> Result<(), Failure> {
    write_content(file, &|mut out| out.write_all(text.as_bytes()), source)
}

/// The same for what is written piece by piece.
pub(super) fn write_content(file: &Path, content: Content<'_>, source: &mut Source) -> Result<(), Failure> {
    claim(file, source)?;
    replace(file, content, None).map_err(|error| unwritten(file, &error))
}

/// Opens a file to go on behind its first bytes; the rest of it is dropped.
pub(super) fn append(file: &Path, bytes: u64, source: &mut Source) -> Result<File, Failure> {
    claim(file, source)?;
    let open = || -> io::Result<File> {
        let mut file = File::options().write(true).create(true).truncate(false).open(file)?;
        file.set_len(bytes)?;
        file.seek(SeekFrom::End(0))?;
        Ok(file)
    };
    open().map_err(|error| unwritten(file, &error))
}

/// Takes a file to write, if nothing was read from it or written there by the same command.
fn claim(file: &Path, source: &mut Source) -> Result<(), Failure> {
    let mut taken = source.taken.iter().map(|path| path.as_path());
    if taken.any(|own| same_file(own, file)) || same_file(Path::new("/dev/stdout"), file) {
        let name = file.display();
        return Err(fault(format!("can't write `{name}`: this command reads that file, or has written it already")));
    }
    source.taken.push(file.to_owned());
    Ok(())
}

fn unwritten(file: &Path, error: &io::Error) -> Failure {
    fault(format!("can't write `{}`: {}", file.display(), in_words(error)))
}

/// Makes a folder and those above it, where they are not there.
pub(super) fn make_folder(folder: &Path) -> Result<(), Failure> {
    let made = fs::create_dir_all(folder);
    made.map_err(|error| fault(format!("can't make the folder `{}`: {}", folder.display(), in_words(&error))))
}

/// What kept a file from being written.
pub(super) fn in_words(error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::PermissionDenied => "writing it is not permitted".to_owned(),
        ErrorKind::NotFound => "there is no such folder".to_owned(),
        ErrorKind::AlreadyExists | ErrorKind::NotADirectory => "there is a file of this name".to_owned(),
        _ => input::in_words(error),
    }
}

/// Whether two paths lead to one file, by whatever name.
pub(super) fn same_file(one: &Path, other: &Path) -> bool {
    let (Ok(first), Ok(second)) = (fs::metadata(one), fs::metadata(other)) else { return false };
    #[cfg(unix)]
    let same = {
        use std::os::unix::fs::MetadataExt;
        (first.dev(), first.ino()) == (second.dev(), second.ino())
    };
    #[cfg(not(unix))]
    let same = one.canonicalize().ok() == other.canonicalize().ok();
    first.is_file() && second.is_file() && same
}

/// Puts something into a file, whole or not at all: it is written to a new file, which then takes the place of the old one
/// with its permissions. A symbolic link stays one. What has several names or another's owner is written where it is.
///
/// `before` is what the file is taken to hold; if somebody has changed it meanwhile, nothing is written.
pub(super) fn replace(file: &Path, content: Content<'_>, before: Option<&str>) -> io::Result<()> {
    let target = match file.canonicalize() {
        Ok(target) => target,
        // What a shell has opened, or a link to what is not there yet.
        Err(_) if file.is_symlink() => return content(&File::create(file)?),
        Err(_) => file.to_owned(),
    };
    let old = match fs::metadata(&target) {
        Ok(old) if old.permissions().readonly() => return Err(ErrorKind::PermissionDenied.into()),
        Ok(old) if !old.is_file() => return content(&File::create(&target)?),
        Ok(old) => Some(old),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) => return Err(error),
    };
    let folder = input::folder(&target);
    let Some(old) = old else {
        let fresh = fresh(folder, content, None, true)?;
        return Ok(fresh.persist(&target).map(drop)?);
    };
    // That the file may be written is for the file to say, not for its folder.
    let own = File::options().write(true).open(&target)?;
    let (fresh, stays) = match fresh(folder, content, Some(&old), true) {
        Ok(fresh) => (fresh, names(&old) > 1),
        // A file of somebody else's can't be made anew.
        Err(error) if error.kind() == ErrorKind::PermissionDenied => (fresh(folder, content, Some(&old), false)?, true),
        Err(error) => return Err(error),
    };
    if let Some(before) = before
        && fs::read(&target)? != before.as_bytes()
    {
        let reason = "it has been changed since it was read, and is left as it is";
        return Err(io::Error::other(reason));
    }
    if !stays {
        return Ok(fresh.persist(&target).map(drop)?);
    }
    write_in_place(own, content).or_else(|error| {
        let (_, path) = fresh.keep()?;
        let path = path.display();
        Err(io::Error::other(format!("{error}; all of it is in `{path}`")))
    })
}

fn write_in_place(mut file: File, content: Content<'_>) -> io::Result<()> {
    content(&file)?;
    let end = file.stream_position()?;
    file.set_len(end)?;
    file.sync_all()
}

/// How files begin that are about to take another's place; short, whatever the name of that is.
const PREFIX: &str = ".librate-";

/// A file with the content, beside the one that it is to replace, with its permissions and, if asked for, its owner. It has a
/// name only from the moment on in which it is whole, so that an interruption leaves nothing behind.
fn fresh(folder: &Path, content: Content<'_>, old: Option<&Metadata>, owner: bool) -> io::Result<NamedTempFile> {
    let fill = |file: &File| -> io::Result<()> {
        content(file)?;
        if let Some(old) = old {
            if owner {
                keep_owner(file, old)?;
            }
            file.set_permissions(old.permissions())?;
        }
        file.sync_all()
    };
    let mut builder = Builder::new();
    builder.prefix(PREFIX);
    #[cfg(target_os = "linux")]
    {
        let nameless = tempfile::tempfile_in(folder)?;
        fill(&nameless)?;
        let named = builder.make_in(folder, |path| {
            link(&nameless, path)?;
            nameless.try_clone()
        });
        if named.is_ok() {
            return named;
        }
    }
    // Not every file system has files without a name.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let named = builder.tempfile_in(folder)?;
    fill(named.as_file())?;
    Ok(named)
}

/// Gives a file without a name one.
#[cfg(target_os = "linux")]
fn link(file: &File, path: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    use std::os::fd::AsRawFd;
    let own = format!("/proc/self/fd/{}", file.as_raw_fd());
    Ok(linkat(CWD, own, CWD, path, AtFlags::SYMLINK_FOLLOW)?)
}

#[cfg(unix)]
fn keep_owner(file: &File, old: &Metadata) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, fchown};
    let new = file.metadata()?;
    if (new.uid(), new.gid()) == (old.uid(), old.gid()) {
        return Ok(());
    }
    fchown(file, Some(old.uid()), Some(old.gid()))
}

#[cfg(not(unix))]
fn keep_owner(_: &File, _: &Metadata) -> io::Result<()> {
    Ok(())
}

/// How many names a file has.
#[cfg(unix)]
fn names(file: &Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::nlink(file)
}

#[cfg(not(unix))]
fn names(_: &Metadata) -> u64 {
    1
}
