//! Faults of a command line, all reported at once. The parser by itself stops at the first fault.

use std::error::Error as _;
use std::ffi::{OsStr, OsString};

use anyhow::Result;
use clap::builder::ValueParser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};

use crate::wrong_use;

/// Characters of a value that a message repeats.
const LONGEST_VALUE: usize = 60;

/// Ends the program with all that is wrong with the words of the command line, of which the parser found `first`: a line
/// for each value, then what is wrong beside the values.
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

/// Prints an error of the parser; of missing words in one line.
fn print_error(error: &clap::Error) {
    match missing(error) {
        Some(needed) => eprintln!("error: required, and not given: {needed}; --help says more"),
        // Where standard error is closed, that cannot be reported.
        None => drop(error.print()),
    }
}

/// Wrong use with all these faults, a line for each; nothing if there is none.
pub(super) fn refuse_all(faults: Vec<String>) -> Result<()> {
    if faults.is_empty() { Ok(()) } else { Err(wrong_use(faults.join("\nerror: "))) }
}

/// Faults of the values of all flags, in the order of the words.
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
        // A flag whose value is missing is no fault of a value.
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

/// The words that are needed and not there; `None` of an error of another kind.
fn missing(error: &clap::Error) -> Option<String> {
    match (error.kind(), error.get(ContextKind::InvalidArg)) {
        (ErrorKind::MissingRequiredArgument, Some(ContextValue::Strings(needed))) => Some(needed.join(", ")),
        _ => None,
    }
}

/// The fault of a flag's value in the words of the other refusals; none for errors of another kind.
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

/// The program with flags and words that take any value.
fn with_any_values(program: Command) -> Command {
    let any = |argument: Arg| {
        if argument.get_action().takes_values() { argument.value_parser(ValueParser::os_string()) } else { argument }
    };
    program.mut_args(any).mut_subcommands(with_any_values)
}
