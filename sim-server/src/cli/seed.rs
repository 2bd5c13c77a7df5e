//! The argument of `--seed`.

/// Reads a seed.
///
/// # Errors
/// The range, in words.
pub(super) fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("a seed is a whole number from 0 to {}", u64::MAX))
}

/// Reads a seed, or draws one from the operating system for `random`.
///
/// # Errors
/// The range, in words, or the operating system's error.
pub(super) fn seed_or_random(text: &str) -> Result<u64, String> {
    if text == "random" {
        return getrandom::u64().map_err(|e| format!("no random numbers: {e}; give a number"));
    }
    seed(text).map_err(|e| format!("{e}, or random"))
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

    #[test]
    fn random_seeds_of_runs_use_64_bits_and_differ() {
        let drawn: Vec<u64> = (0..64).map(|_| super::seed_or_random("random").unwrap()).collect();
        let set = drawn.iter().fold((0, u64::MAX), |(or, and), seed| (or | seed, and & seed));
        // Each bit was once 1 and once 0, but for one case in 2^57.
        assert_eq!(set, (u64::MAX, 0), "{drawn:x?}");
        for (verb, taken) in
            [("launch", true), ("serve", true), ("fork x --at 1", true), ("umbmark", false)]
        {
            let words = ["sim-server"].into_iter().chain(verb.split(' '));
            let parsed = Cli::try_parse_from(words.chain(["--seed", "random"]));
            assert_eq!(parsed.is_ok(), taken, "{verb}");
        }
    }
}
