//! `cppr completions` and `cppr man`: what shells and manuals want to know of the program.

use crate::output::print;
use crate::{Cli, Failure};
use clap::CommandFactory;
use clap_complete::Shell;
use std::path::PathBuf;

/// Shown by `--help`.
pub const COMPLETIONS: &str = "\
Examples:
  cppr completions bash
  cppr completions zsh
  cppr completions fish
Where they go:
  $ cppr completions bash > ~/.local/share/bash-completion/completions/cppr
  $ cppr completions zsh > ~/.zfunc/_cppr     (a folder of $fpath)
  $ cppr completions fish > ~/.config/fish/completions/cppr.fish";

/// Shown by `--help`.
pub const MAN: &str = "\
Examples:
  cppr man --output man
Then:
  $ man man/cppr-solve.1
  $ cp man/* ~/.local/share/man/man1/";

/// Arguments of `cppr completions`.
#[derive(clap::Args)]
pub struct CompletionsArgs {
    /// The shell that is to complete
    shell: Shell,
}

/// Prints the script.
pub fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut bytes = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "cppr", &mut bytes);
    print(&String::from_utf8_lossy(&bytes))
}

/// Arguments of `cppr man`.
#[derive(clap::Args)]
pub struct ManArgs {
    /// Folder for the pages, made where it is missing; pages of the same names are replaced
    #[arg(long, short, value_name = "FOLDER")]
    output: PathBuf,
}

/// Writes a page for the program and one for each sub-command.
pub fn man(args: &ManArgs) -> Result<(), Failure> {
    let failed =
        |error: std::io::Error| Failure::Input(format!("--output {}: {error}", args.output.display()));
    std::fs::create_dir_all(&args.output).map_err(failed)?;
    let command = Cli::command().disable_help_subcommand(true);
    clap_mangen::generate_to(command, &args.output).map_err(failed)?;
    for page in std::fs::read_dir(&args.output).map_err(failed)? {
        let path = page.map_err(failed)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with("cppr") && name.ends_with(".1") {
            let text = std::fs::read_to_string(&path).map_err(failed)?;
            std::fs::write(&path, as_written(&text)).map_err(failed)?;
        }
    }
    print(&format!("{}: manual pages, cppr.1 first\n", args.output.display()))
}

/// The page with its examples line by line, as `--help` shows them, and under their name: what they are made of is filled into paragraphs otherwise.
fn as_written(page: &str) -> String {
    let Some((before, examples)) = page.split_once(".SH EXTRA\n") else { return page.to_owned() };
    let (examples, after) = examples.split_at(examples.find("\n.SH ").map_or(examples.len(), |at| at + 1));
    format!("{before}.SH EXAMPLES\n.nf\n{}\n.fi\n{after}", examples.trim_end())
}
