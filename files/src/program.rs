//! The program itself: the file that holds its code, and the words that start another process of it.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::{env, io};

/// Set by [`Program::host`].
static HOSTED: OnceLock<Program> = OnceLock::new();

/// The program of this process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Program {
    /// Holds its code: another build is another file.
    pub file: PathBuf,
    /// Program that is started, with its first arguments.
    pub start: Vec<OsString>,
}

impl Program {
    /// The program that runs: the executable, unless a host was named.
    ///
    /// # Errors
    /// When the system does not know the executable.
    pub fn of_this_process() -> io::Result<Self> {
        if let Some(hosted) = HOSTED.get() {
            return Ok(hosted.clone());
        }
        let file = env::current_exe()?;
        Ok(Self { start: vec![file.clone().into()], file })
    }

    /// Names what is started instead of the executable, which is an interpreter that has loaded the program. Only the first
    /// call counts.
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
