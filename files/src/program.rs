//! The running program: the file of its code, and the command that starts another process of it.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::{env, io};

/// Set by [`Program::host`].
static HOSTED: OnceLock<Program> = OnceLock::new();

/// The program of this process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Program {
    /// File with its code; another build is another file.
    pub file: PathBuf,
    /// Command that starts it: the program and its first arguments.
    pub start: Vec<OsString>,
}

impl Program {
    /// The running program: the executable, unless a host was set.
    ///
    /// # Errors
    /// If the system does not report the executable.
    pub fn of_this_process() -> io::Result<Self> {
        if let Some(hosted) = HOSTED.get() {
            return Ok(hosted.clone());
        }
        let file = env::current_exe()?;
        Ok(Self { start: vec![file.clone().into()], file })
    }

    /// Sets the command that is started instead of the executable, which is an interpreter that has loaded the program.
    /// Only the first call has an effect.
    pub fn host(self) {
        HOSTED.get_or_init(|| self);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_executable_is_the_program_until_a_host_is_named() {
        let own = Program::of_this_process().unwrap();
        assert_eq!((own.start, Some(own.file)), (vec![env::current_exe().unwrap().into()], env::current_exe().ok()));
        let hosted = Program { file: "module.so".into(), start: ["python", "-m", "robofin"].map(Into::into).into() };
        hosted.clone().host();
        assert_eq!(Program::of_this_process().unwrap(), hosted);
        Program { file: "other.so".into(), start: Vec::new() }.host();
        assert_eq!(Program::of_this_process().unwrap(), hosted);
    }
}
