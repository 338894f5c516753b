//! `robofin man`: prints the manual page of the program or of a verb, in roff.

use anyhow::Result;
use clap::{Args, Command};
use clap_mangen::Man;
use effects::hint;
use serde::Serialize;

use crate::console::Console;
use crate::wrong_use;

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  robofin man > ~/.local/share/man/man1/robofin.1\n  \
                        robofin man trial synth > ~/.local/share/man/man1/robofin-trial-synth.1")]
pub(super) struct ManArgs {
    /// Verb, with its own verb where it has some [default: the program].
    #[arg(value_name = "VERB")]
    verb: Vec<String>,
}

/// The answer of `man --json`.
#[derive(Serialize)]
struct ManAnswer<'a> {
    page: &'a str,
    roff: &'a str,
}

pub(super) fn run(args: &ManArgs, program: Command, console: &Console) -> Result<()> {
    let mut program = program.disable_help_subcommand(true);
    program.build();
    let verb = find(&program, &args.verb)?;
    let page = verb.get_display_name().unwrap_or("robofin").to_owned();
    let mut roff = Vec::new();
    Man::new(verb.clone()).source(concat!("RoboFin ", env!("CARGO_PKG_VERSION"))).render(&mut roff)?;
    let roff = String::from_utf8(roff)?;
    console.document(&roff)?;
    console.answer(&ManAnswer { page: &format!("{page}.1"), roff: &roff })
}

/// Finds a verb below a command, one word for each level.
fn find<'a>(command: &'a Command, words: &[String]) -> Result<&'a Command> {
    let Some((word, rest)) = words.split_first() else { return Ok(command) };
    let listed = || command.get_subcommands().filter(|verb| !verb.is_hide_set());
    match listed().find(|verb| verb.get_name() == word) {
        Some(verb) => find(verb, rest),
        None => {
            let known: Vec<&str> = listed().map(Command::get_name).collect();
            Err(wrong_use(format!("`{}` has no verb `{word}`; {}", command.get_name(), hint(word, &known))))
        }
    }
}
