//! Whether this processor has the instructions that the program or library was compiled to use.

/// A sentence where it lacks some; to be asked first, since the first of them ends the process without a word.
#[must_use]
pub fn lacking() -> Option<&'static str> {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
    {
        let processor = raw_cpuid::CpuId::new();
        let has = processor.get_feature_info().is_some_and(|own| own.has_fma())
            && processor.get_extended_feature_info().is_some_and(|own| own.has_avx2() && own.has_bmi2());
        if !has {
            return Some(
                "this cppr is compiled for processors with AVX2 (most since 2015), which this one has not. Compile it here, from the sources, \
                 with the environment variable RUSTFLAGS set to nothing",
            );
        }
    }
    None
}

#[cfg(test)]
mod tests {
    #[test]
    fn whoever_runs_this_may() {
        assert_eq!(super::lacking(), None);
    }
}
