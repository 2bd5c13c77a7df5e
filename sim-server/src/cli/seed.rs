//! The argument of `--seed`.

/// Reads a seed.
///
/// # Errors
/// The range, in words.
pub(super) fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("a seed is a whole number from 0 to {}", u64::MAX))
}

#[cfg(test)]
mod tests {
    use crate::cli::Cli;
    use clap::Parser as _;

    #[test]
    fn a_seed_out_of_range_is_refused_with_the_range() {
        for verb in ["launch", "umbmark", "fork x --at 1"] {
            let parse = |seed: &str| {
                let words = ["sim-server"].into_iter().chain(verb.split(' '));
                Cli::try_parse_from(words.chain(["--seed", seed]))
            };
            assert!(parse("18446744073709551615").is_ok());
            for seed in ["-1", "1.5", "18446744073709551616"] {
                let error = parse(seed).err().unwrap().to_string();
                assert!(error.contains("--seed") && error.contains(seed), "{error}");
                assert!(error.contains("from 0 to 18446744073709551615"), "{error}");
            }
        }
    }
}
