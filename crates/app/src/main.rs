//! The `estar` program.

fn main() -> std::process::ExitCode {
    estar::cli::main(include_str!("../../../THIRD-PARTY-NOTICES"))
}
