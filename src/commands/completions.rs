//! `robofin completions`: a script that completes verbs and flags in a shell.

use anyhow::Result;
use clap::{Args, Command};
use clap_complete::{Shell, generate};
use serde::Serialize;

use crate::console::Console;

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  robofin completions bash > ~/.local/share/bash-completion/completions/robofin\n  \
                        robofin completions fish > ~/.config/fish/completions/robofin.fish"
)]
pub(super) struct CompletionsArgs {
    /// Shell that reads the script.
    #[arg(value_enum)]
    shell: Shell,
}

/// The answer of `completions --json`.
#[derive(Serialize)]
struct CompletionsAnswer<'a> {
    shell: String,
    script: &'a str,
}

pub(super) fn run(args: &CompletionsArgs, program: Command, console: &Console) -> Result<()> {
    let mut script = Vec::new();
    generate(args.shell, &mut listed(program), "robofin", &mut script);
    let script = String::from_utf8(script)?;
    console.document(&script)?;
    console.answer(&CompletionsAnswer { shell: args.shell.to_string(), script: &script })
}

/// Returns the program without the verbs hidden from its help.
fn listed(program: Command) -> Command {
    let verbs: Vec<Command> = program.get_subcommands().filter(|verb| !verb.is_hide_set()).cloned().collect();
    let flags: Vec<_> = program.get_arguments().cloned().collect();
    Command::new("robofin").args(flags).subcommands(verbs)
}
