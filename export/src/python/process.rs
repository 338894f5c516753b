//! Runs a program with a time limit and captures its output.

use std::fs::File;
use std::io::{Read, Seek};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::PythonError;

/// Exit status and output of a finished program.
pub(super) struct Finished {
    pub(super) status: ExitStatus,
    pub(super) stdout: String,
    stderr: String,
}

impl Finished {
    /// Returns the last non-empty lines of standard error, joined into one line.
    pub(super) fn last_lines(&self, count: usize) -> String {
        let lines: Vec<&str> = self.stderr.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        lines[lines.len().saturating_sub(count)..].join(" | ")
    }

    /// Returns true if either stream contains a phrase.
    pub(super) fn says(&self, phrase: &str) -> bool {
        self.stdout.contains(phrase) || self.stderr.contains(phrase)
    }
}

/// Runs `command` and kills it after `limit`. `what` names it in errors.
///
/// The streams go to files, not pipes: a grandchild could keep a pipe open beyond the limit.
pub(super) fn run(mut command: Command, what: &str, limit: Duration) -> Result<Finished, PythonError> {
    let io = |source| PythonError::Io { what: format!("running {what}"), source };
    let (mut out, mut err) = (tempfile::tempfile().map_err(io)?, tempfile::tempfile().map_err(io)?);
    command.stdin(Stdio::null());
    command.stdout(out.try_clone().map_err(io)?).stderr(err.try_clone().map_err(io)?);
    let mut child = command.spawn().map_err(io)?;
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait().map_err(io)? {
            let (stdout, stderr) = (text_of(&mut out).map_err(io)?, text_of(&mut err).map_err(io)?);
            return Ok(Finished { status, stdout, stderr });
        }
        if started.elapsed() > limit {
            child.kill().map_err(io)?;
            child.wait().map_err(io)?;
            return Err(PythonError::TimedOut { what: what.to_owned(), seconds: limit.as_secs() });
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn text_of(file: &mut File) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_does_not_end_is_stopped_with_its_name() {
        let mut command = Command::new("sh");
        // The sleeping grandchild keeps the streams open.
        command.args(["-c", "sleep 30 & sleep 30"]);
        let started = Instant::now();
        let Err(error) = run(command, "a sleeper", Duration::from_millis(50)) else {
            panic!("a sleeping program was waited for")
        };
        assert!(started.elapsed() < Duration::from_secs(20), "stopped by the limit, not by its own end");
        assert!(error.to_string().contains("a sleeper did not finish"), "{error}");
    }

    #[test]
    fn both_streams_and_the_status_are_kept() {
        let mut command = Command::new("sh");
        command.args(["-c", "echo out; echo one >&2; echo two >&2; exit 3"]);
        let done = run(command, "a talker", Duration::from_secs(10)).expect("sh runs");
        assert_eq!(done.status.code(), Some(3));
        assert_eq!(done.stdout, "out\n");
        assert_eq!(done.last_lines(1), "two");
        assert_eq!(done.last_lines(5), "one | two");
    }
}
