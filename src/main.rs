//! The binary `kutta`: methods, problems and comparisons from the command line.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
