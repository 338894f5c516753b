//! Reports all faults of a command line at once; clap itself stops at the first one.

use std::error::Error as _;
use std::ffi::{OsStr, OsString};

use anyhow::Result;
use clap::builder::ValueParser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};

use crate::wrong_use;

/// Greatest number of characters of a value repeated in a message.
const LONGEST_VALUE: usize = 60;

/// Ends the program with the faults of the command line: one line for each wrong value, then `first`.
pub(super) fn refuse(program: &Command, words: &[OsString], first: clap::Error) -> ! {
    if !first.use_stderr() {
        first.exit()
    }
    let faults = of_values(program, words);
    if faults.is_empty() {
        print_error(&first);
        std::process::exit(2)
    }
    faults.iter().for_each(|fault| eprintln!("error: {fault}"));
    let beside = with_any_values(program.clone()).try_get_matches_from(words).err();
    if let Some(beside) = beside.filter(clap::Error::use_stderr) {
        print_error(&beside);
    }
    std::process::exit(2)
}

/// Prints an error of the parser; missing arguments on one line.
fn print_error(error: &clap::Error) {
    match missing(error) {
        Some(needed) => eprintln!("error: required arguments are missing: {needed}; see --help"),
        // If standard error is closed, the error cannot be reported.
        None => drop(error.print()),
    }
}

/// Returns an error of wrong use with all faults, one a line; no error without faults.
pub(super) fn refuse_all(faults: Vec<String>) -> Result<()> {
    if faults.is_empty() { Ok(()) } else { Err(wrong_use(faults.join("\nerror: "))) }
}

/// Collects the faults of all flags' values, in the order of the arguments.
fn of_values(program: &Command, words: &[OsString]) -> Vec<String> {
    let (mut verb, mut verbs) = (program, vec![program.get_name()]);
    let mut faults = Vec::new();
    let mut words = words.iter().skip(1).map(|word| word.to_string_lossy()).take_while(|word| word != "--").peekable();
    while let Some(word) = words.next() {
        let Some(flag) = word.strip_prefix("--") else {
            if let Some(next) = verb.find_subcommand(OsStr::new(&*word)) {
                verb = next;
                verbs.push(next.get_name());
            }
            continue;
        };
        let (name, value) = flag.split_once('=').map_or((flag, None), |(name, value)| (name, Some(value.to_owned())));
        let Some(known) = verb.get_opts().chain(program.get_opts()).find(|known| known.get_long() == Some(name)) else {
            continue;
        };
        let value = value.or_else(|| words.next_if(|next| !next.starts_with("--")).map(Into::into));
        // A missing value is not a faulty value.
        let Some(value) = value else { continue };
        let listed: Vec<&str> = known.get_value_delimiter().map_or(vec![&*value], |comma| value.split(comma).collect());
        for value in listed {
            let alone = verbs.iter().map(|&verb| verb.to_owned()).chain([format!("--{name}={value}")]);
            let parsed = program.clone().try_get_matches_from(alone);
            faults.extend(parsed.err().and_then(|error| of_value(name, &error)));
        }
    }
    faults
}

/// Lists the missing required arguments; `None` for errors of another kind.
fn missing(error: &clap::Error) -> Option<String> {
    match (error.kind(), error.get(ContextKind::InvalidArg)) {
        (ErrorKind::MissingRequiredArgument, Some(ContextValue::Strings(needed))) => Some(needed.join(", ")),
        _ => None,
    }
}

/// Describes a faulty value of a flag in the form of the other refusals; `None` for errors of another kind.
fn of_value(flag: &str, error: &clap::Error) -> Option<String> {
    let why = match (error.kind(), error.get(ContextKind::ValidValue)) {
        (ErrorKind::ValueValidation, _) => error.source()?.to_string(),
        (ErrorKind::InvalidValue, Some(ContextValue::Strings(known))) if !known.is_empty() => {
            format!("{} is accepted", known.join(" or "))
        }
        (ErrorKind::InvalidValue, _) => "a value is expected".to_owned(),
        _ => return None,
    };
    let value = error.get(ContextKind::InvalidValue).map(ToString::to_string).unwrap_or_default();
    let value = match value.char_indices().nth(LONGEST_VALUE) {
        Some((end, _)) => format!("{}…", &value[..end]),
        None if value.is_empty() => "\"\"".to_owned(),
        None => value,
    };
    Some(format!("--{flag} {value}: {why}"))
}

/// Returns the program with arguments that accept any value.
fn with_any_values(program: Command) -> Command {
    let any = |argument: Arg| {
        if argument.get_action().takes_values() { argument.value_parser(ValueParser::os_string()) } else { argument }
    };
    program.mut_args(any).mut_subcommands(with_any_values)
}
