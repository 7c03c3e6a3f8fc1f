//! Runs one external program: in a folder, its output into a log, stopped when it takes too long.
//!
//! ```text
//! this process ──pipe──► guard (sh: kills the group when the pipe breaks)
//!       └──────────────► program ──► its compilers, its simulators        one process group
//! ```
//!
//! The program leads a process group of its own, so that what it started ends with it. The guard ends
//! the group also when this process is interrupted or dies.

use super::Settings;
use super::{tools, workarounds};
use crate::{Error, Kind, Result};
use std::fs::{self, File};
use std::io::{Read, Seek, Write};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Lines of a failed program's output that the message shows.
const TAIL: usize = 12;
/// So often a program's owner is asked whether it goes on.
const ASKED: Duration = Duration::from_millis(300);
/// A question for a version takes no longer than this.
const QUESTION: Duration = Duration::from_secs(30);

/// Runs `line[0]` with its arguments; everything it prints goes to `log`.
///
/// [`Kind::ToolMissing`] when it is not installed, [`Kind::ToolFailed`] when it reports a failure (with
/// the tail of its output) or was stopped after `settings.timeout`.
pub(crate) fn run(line: &[String], folder: &Path, log: &Path, settings: &Settings) -> Result<()> {
    run_while(line, folder, log, settings, &|| true).map(drop)
}

/// The same as long as `goes_on` says so, which is asked several times a second; whether the program came to its end.
pub(crate) fn run_while(
    line: &[String],
    folder: &Path,
    log: &Path,
    settings: &Settings,
    goes_on: &dyn Fn() -> bool,
) -> Result<bool> {
    let output = File::create(log).map_err(|error| {
        Error::new(Kind::ToolFailed, format!("cannot write a log: {error}")).at(log.display())
    })?;
    let name = program_name(&line[0]);
    match start(line, folder, output, settings, goes_on)? {
        End::Stopped => Ok(false),
        End::Status(status) if status.success() => Ok(true),
        End::Status(status) => {
            Err(Error::new(Kind::ToolFailed, format!("{name} failed ({status}):\n{}", tail(log)))
                .at(log.display()))
        }
        End::Late => Err(Error::new(
            Kind::ToolFailed,
            format!("{name} was stopped: it ran longer than {:?}", settings.timeout),
        )
        .at(log.display())
        .help("raise the limit with --timeout SECONDS if it only needs longer")),
    }
}

/// What a program prints when asked something short, both streams together.
pub(crate) fn ask(line: &[String], settings: &Settings) -> Result<String> {
    ask_within(QUESTION, line, settings)
}

/// The same of a program that may need longer for its answer.
pub(crate) fn ask_within(limit: Duration, line: &[String], settings: &Settings) -> Result<String> {
    let cannot = |error: std::io::Error| Error::new(Kind::ToolFailed, error.to_string());
    let mut file = tempfile::tempfile().map_err(cannot)?;
    let output = file.try_clone().map_err(cannot)?;
    let settings = Settings { timeout: limit, ..settings.clone() };
    if start(line, Path::new("."), output, &settings, &|| true)? == End::Late {
        let what = format!("{} did not answer within {limit:?}", line.join(" "));
        return Err(Error::new(Kind::ToolFailed, what));
    }
    let mut bytes = Vec::new();
    file.rewind().and_then(|()| file.read_to_end(&mut bytes)).map_err(cannot)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// How a program came to an end.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Status(ExitStatus),
    /// It took too long.
    Late,
    /// Nobody wants it any more.
    Stopped,
}

/// A program with a `/` in its name is taken as it is.
fn start(
    line: &[String],
    folder: &Path,
    output: File,
    settings: &Settings,
    goes_on: &dyn Fn() -> bool,
) -> Result<End> {
    let program = match line[0].contains('/') {
        true => line[0].clone().into(),
        false => tools::find(&line[0], settings).ok_or_else(|| tools::missing(&line[0]))?,
    };
    let name = program_name(&line[0]);
    let cannot = |error: std::io::Error| {
        Error::new(Kind::ToolFailed, format!("cannot run {name}: {error}")).at(program.display())
    };
    let mut command = Command::new(&program);
    command.args(&line[1..]).current_dir(folder).env("LC_ALL", "C").process_group(0);
    command.stdin(Stdio::null()).stderr(output.try_clone().map_err(cannot)?).stdout(output);
    if let Some(path) = &settings.path {
        command.env("PATH", path);
    }
    // A surrounding make would pass its own flags to the make within.
    command.env_remove("MAKEFLAGS").env_remove("MAKELEVEL");
    let mut child = workarounds::spawn_when_not_busy(&mut command).map_err(cannot)?;
    let guard = match Guard::of(&child) {
        Ok(guard) => guard,
        Err(error) => {
            let _ = child.kill();
            return Err(cannot(error));
        }
    };
    let end = wait(&mut child, settings.timeout, goes_on).map_err(cannot)?;
    match end {
        End::Status(_) => guard.dismiss(),
        End::Late | End::Stopped => {
            guard.strike();
            child.wait().map_err(cannot)?;
        }
    }
    Ok(end)
}

/// Waits at most so long.
fn wait(child: &mut Child, timeout: Duration, goes_on: &dyn Fn() -> bool) -> std::io::Result<End> {
    let begun = Instant::now();
    let mut asked = Duration::ZERO;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(End::Status(status));
        }
        let elapsed = begun.elapsed();
        if elapsed >= timeout {
            return Ok(End::Late);
        }
        if elapsed - asked >= ASKED {
            asked = elapsed;
            if !goes_on() {
                return Ok(End::Stopped);
            }
        }
        let pause = (elapsed / 50).clamp(Duration::from_micros(200), Duration::from_millis(20));
        std::thread::sleep(pause.min(timeout - elapsed));
    }
}

/// A shell that waits for one line and kills the process group if it does not come.
struct Guard(Child);

impl Guard {
    fn of(leader: &Child) -> std::io::Result<Guard> {
        let script = r#"read -r dismissed || kill -s KILL -- "-$1""#;
        let mut shell = Command::new("/bin/sh");
        shell.args(["-c", script, "guard", &leader.id().to_string()]).process_group(0);
        let guard = shell.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
        Ok(Guard(guard.spawn()?))
    }
    /// The program has ended by itself.
    fn dismiss(mut self) {
        if let Some(mut pipe) = self.0.stdin.take() {
            let _ = pipe.write_all(b"done\n");
        }
        let _ = self.0.wait();
    }
    /// Kills the group.
    fn strike(mut self) {
        drop(self.0.stdin.take());
        let _ = self.0.wait();
    }
}

/// The last part of a path, for messages.
fn program_name(program: &str) -> &str {
    program.rsplit('/').next().unwrap_or(program)
}

/// The last lines of a log, indented.
pub(super) fn tail(log: &Path) -> String {
    let text = fs::read(log).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    let text = text.unwrap_or_default();
    let lines: Vec<_> = text.lines().filter(|line| !line.trim().is_empty()).collect();
    let last: Vec<_> =
        lines[lines.len().saturating_sub(TAIL)..].iter().map(|line| format!("    {line}")).collect();
    if last.is_empty() { "    (it printed nothing)".into() } else { last.join("\n") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str, timeout: Duration) -> (Result<()>, tempfile::TempDir) {
        let folder = tempfile::tempdir().unwrap();
        let line = ["/bin/sh", "-c", script].map(String::from);
        let settings = Settings { timeout, ..Settings::default() };
        let result = run(&line, folder.path(), &folder.path().join("log"), &settings);
        (result, folder)
    }

    #[test]
    fn a_failure_shows_the_tail_of_the_output() {
        let (result, _folder) = shell("seq 100; echo broken >&2; exit 3", Duration::from_secs(20));
        let error = result.unwrap_err();
        assert_eq!(error.kind, Kind::ToolFailed);
        assert!(error.what.starts_with("sh failed (exit status: 3)"), "{error}");
        assert!(error.what.ends_with("    100\n    broken"), "{error}");
    }

    #[test]
    fn a_program_that_hangs_is_stopped_with_all_it_started() {
        let script = "(sleep 1; touch survived) & sleep 60";
        let begun = Instant::now();
        let (result, folder) = shell(script, Duration::from_millis(100));
        let error = result.unwrap_err();
        assert!(error.what.contains("longer than 100ms"), "{error}");
        assert!(error.help.unwrap().contains("--timeout"));
        assert!(begun.elapsed() < Duration::from_secs(10));
        std::thread::sleep(Duration::from_millis(1500));
        assert!(!folder.path().join("survived").exists(), "the grandchild was not stopped");
    }

    #[test]
    fn a_question_is_given_the_time_it_needs_and_no_more() {
        let line = ["/bin/sh", "-c", "sleep 1; echo 0.57"].map(String::from);
        let ask = |limit| ask_within(Duration::from_millis(limit), &line, &Settings::default());
        assert!(ask(100).unwrap_err().what.contains("did not answer within 100ms"));
        assert_eq!(ask(20_000).unwrap(), "0.57\n");
    }

    #[test]
    fn a_missing_program_says_how_to_install_it() {
        let settings = Settings { path: Some("".into()), ..Settings::default() };
        let error = ask(&["verilator".into(), "--version".into()], &settings).unwrap_err();
        assert_eq!((error.kind, error.exit_status()), (Kind::ToolMissing, 4));
    }
}
