//! Which share of the work is meant: said, or read from what a scheduler tells its jobs.

use std::str::FromStr;

use anyhow::{Context, Result, bail, ensure};
use superegg_render::Shard;

/// `K/N`, `auto` or `auto/N`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShareArg {
    /// This one.
    Said(Shard),
    /// That of this job among those of its scheduler, of so many shares where that is said.
    Auto { count: Option<u32> },
}

impl FromStr for ShareArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.strip_prefix("auto") {
            Some("") => Ok(Self::Auto { count: None }),
            Some(count) => {
                let count = count.strip_prefix('/').and_then(|digits| digits.parse().ok());
                let count = count.filter(|&count: &u32| count > 0).ok_or("it is auto/N, such as auto/8")?;
                Ok(Self::Auto { count: Some(count) })
            }
            None => text.parse().map(Self::Said),
        }
    }
}

/// A job of a Slurm array: its number, which need not begin at 0 or 1.
const SLURM_ID: &str = "SLURM_ARRAY_TASK_ID";
/// The number of a job of an indexed Kubernetes job, from 0.
const KUBERNETES_INDEX: &str = "JOB_COMPLETION_INDEX";
/// How many there are. Kubernetes does not set it; a manifest may.
const KUBERNETES_COUNT: &str = "JOB_COMPLETIONS";

impl ShareArg {
    /// The share that is meant.
    ///
    /// # Errors
    /// It is to be read from the environment, and that does not say it, or contradicts itself.
    pub(crate) fn share(self) -> Result<Shard> {
        self.share_in(&|name| std::env::var(name).ok())
    }

    fn share_in(self, variable: &dyn Fn(&str) -> Option<String>) -> Result<Shard> {
        let count = match self {
            Self::Said(share) => return Ok(share),
            Self::Auto { count } => count,
        };
        match (variable(SLURM_ID), variable(KUBERNETES_INDEX)) {
            (Some(_), None) => slurm_share(count, variable),
            (None, Some(_)) => kubernetes_share(count, variable),
            (Some(_), Some(_)) => {
                bail!("both {SLURM_ID} and {KUBERNETES_INDEX} are set; say which share is meant: K/N")
            }
            (None, None) => bail!(
                "'auto' looks for {SLURM_ID} (in a job of a Slurm array) or {KUBERNETES_INDEX} (in an indexed Kubernetes job), and neither is set; say which share is meant: K/N"
            ),
        }
    }
}

fn number(name: &str, variable: &dyn Fn(&str) -> Option<String>) -> Result<Option<u32>> {
    let read = |text: String| {
        text.parse().with_context(|| format!("{name} is '{text}', and should be a number from 0 up"))
    };
    variable(name).map(read).transpose()
}

fn slurm_share(count: Option<u32>, variable: &dyn Fn(&str) -> Option<String>) -> Result<Shard> {
    let get = |what: &str| number(&format!("SLURM_ARRAY_TASK_{what}"), variable);
    let need = |what: &str| {
        get(what)?.with_context(|| format!("{SLURM_ID} is set, but not SLURM_ARRAY_TASK_{what}"))
    };
    let id = need("ID")?;
    if let Some(count) = count {
        // Some of the jobs may be run again later, as another array: the number is the share's whatever the array.
        return Shard::new(id, count)
            .filter(|_| get("MIN").ok().flatten() != Some(0))
            .with_context(|| format!("with auto/{count} the jobs of the array are numbered from 1: --array=1-{count}; this one is {id}"));
    }
    let (min, max, step) = (need("MIN")?, need("MAX")?, get("STEP")?.unwrap_or(1).max(1));
    let in_range = (min..=max).contains(&id) && (id - min).is_multiple_of(step);
    let told = get("COUNT")?;
    // 0-4294967295 would be more than any array has.
    let shares = max.checked_sub(min).and_then(|span| (span / step).checked_add(1));
    let shares = shares.filter(|shares| in_range && told.is_none_or(|told| told == *shares));
    let share = shares.and_then(|shares| Shard::new((id - min) / step + 1, shares));
    share.with_context(|| {
        let told = told.map_or_else(String::new, |told| format!(", COUNT {told}"));
        format!(
            "the jobs of this array are not numbered evenly (ID {id}, MIN {min}, MAX {max}, STEP {step}{told} after SLURM_ARRAY_TASK_); to run some of them again, say how many shares there are: auto/N, and number the jobs from 1"
        )
    })
}

fn kubernetes_share(count: Option<u32>, variable: &dyn Fn(&str) -> Option<String>) -> Result<Shard> {
    let index =
        number(KUBERNETES_INDEX, variable)?.with_context(|| format!("{KUBERNETES_INDEX} is not set"))?;
    let told = number(KUBERNETES_COUNT, variable)?;
    if let (Some(count), Some(told)) = (count, told) {
        ensure!(count == told, "auto/{count} contradicts {KUBERNETES_COUNT}, which is {told}");
    }
    let count = count.or(told).with_context(|| {
        format!("{KUBERNETES_INDEX} is set, but not how many there are: say auto/N, with the job's 'completions' for N, or set {KUBERNETES_COUNT}")
    })?;
    ensure!(count > 0, "{KUBERNETES_COUNT} is 0, and should be at least 1");
    index.checked_add(1).and_then(|number| Shard::new(number, count)).with_context(|| {
        format!("{KUBERNETES_INDEX} is {index}, but of {count} shares the last has the index {}", count - 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The share of these words in an environment of `NAME=value` words.
    fn share(argument: &str, environment: &str) -> Result<String, String> {
        let variable = |name: &str| {
            let pairs = environment.split_whitespace().filter_map(|pair| pair.split_once('='));
            pairs
                .filter(|(key, _)| key.replace("S_", "SLURM_ARRAY_TASK_") == name)
                .map(|(_, value)| value.to_owned())
                .next()
        };
        let share = argument.parse::<ShareArg>()?.share_in(&variable);
        share.map(|share| share.to_string()).map_err(|error| format!("{error:#}"))
    }

    #[test]
    fn shares_of_slurm_arrays() {
        for (argument, environment, expected) in [
            ("auto", "S_ID=0 S_MIN=0 S_MAX=6 S_STEP=1 S_COUNT=7", "1/7"),
            ("auto", "S_ID=6 S_MIN=0 S_MAX=6 S_STEP=1 S_COUNT=7", "7/7"),
            ("auto", "S_ID=3 S_MIN=1 S_MAX=7 S_STEP=1 S_COUNT=7", "3/7"),
            ("auto", "S_ID=30 S_MIN=10 S_MAX=39 S_STEP=10 S_COUNT=3", "3/3"),
            ("auto", "S_ID=5 S_MIN=5 S_MAX=5", "1/1"),
            ("auto/8", "S_ID=5 S_MIN=5 S_MAX=5 S_STEP=1 S_COUNT=1", "5/8"),
            ("auto/8", "S_ID=5 S_MIN=2 S_MAX=5 S_COUNT=3", "5/8"),
            ("2/3", "S_ID=5 JOB_COMPLETION_INDEX=7", "2/3"),
        ] {
            assert_eq!(share(argument, environment).as_deref(), Ok(expected), "{argument} {environment}");
        }
        for (argument, environment, expected) in [
            ("auto", "S_ID=3 S_MIN=1 S_MAX=7 S_STEP=1 S_COUNT=3", "not numbered evenly"),
            ("auto", "S_ID=8 S_MIN=1 S_MAX=7 S_STEP=1 S_COUNT=7", "not numbered evenly"),
            ("auto", "S_ID=2 S_MIN=1 S_MAX=7 S_STEP=2 S_COUNT=4", "not numbered evenly"),
            ("auto", "S_ID=7 S_MIN=7 S_MAX=1", "not numbered evenly"),
            ("auto", "S_ID=0 S_MIN=0 S_MAX=4294967295", "not numbered evenly"),
            ("auto", "S_ID=x S_MIN=1 S_MAX=7", "SLURM_ARRAY_TASK_ID is 'x'"),
            ("auto", "S_ID=-1 S_MIN=1 S_MAX=7", "SLURM_ARRAY_TASK_ID is '-1'"),
            ("auto", "S_ID=1", "not SLURM_ARRAY_TASK_MIN"),
            ("auto/8", "S_ID=0", "numbered from 1: --array=1-8"),
            ("auto/8", "S_ID=3 S_MIN=0", "numbered from 1: --array=1-8"),
            ("auto/8", "S_ID=9", "numbered from 1: --array=1-8"),
            ("auto", "S_ID=1 JOB_COMPLETION_INDEX=1", "both"),
            ("auto", "", "looks for SLURM_ARRAY_TASK_ID"),
        ] {
            let error = share(argument, environment).unwrap_err();
            assert!(error.contains(expected), "{argument} {environment}: {error}");
        }
    }

    #[test]
    fn shares_of_kubernetes_jobs() {
        for (argument, environment, expected) in [
            ("auto/8", "JOB_COMPLETION_INDEX=0", "1/8"),
            ("auto/8", "JOB_COMPLETION_INDEX=7", "8/8"),
            ("auto", "JOB_COMPLETION_INDEX=2 JOB_COMPLETIONS=3", "3/3"),
            ("auto/3", "JOB_COMPLETION_INDEX=2 JOB_COMPLETIONS=3", "3/3"),
        ] {
            assert_eq!(share(argument, environment).as_deref(), Ok(expected), "{argument} {environment}");
        }
        for (argument, environment, expected) in [
            ("auto", "JOB_COMPLETION_INDEX=2", "say auto/N"),
            ("auto/8", "JOB_COMPLETION_INDEX=8", "the last has the index 7"),
            ("auto/8", "JOB_COMPLETION_INDEX=4294967295", "the last has the index 7"),
            ("auto/8", "JOB_COMPLETION_INDEX=", "should be a number"),
            ("auto/8", "JOB_COMPLETION_INDEX=1 JOB_COMPLETIONS=9", "contradicts JOB_COMPLETIONS"),
            ("auto", "JOB_COMPLETION_INDEX=0 JOB_COMPLETIONS=0", "should be at least 1"),
        ] {
            let error = share(argument, environment).unwrap_err();
            assert!(error.contains(expected), "{argument} {environment}: {error}");
        }
    }

    #[test]
    fn words_that_are_no_share() {
        for bad in ["", "auto/", "auto/0", "auto/x", "automatic", "auto8", "0/3", "4/3", "3"] {
            assert!(bad.parse::<ShareArg>().is_err(), "{bad}");
        }
    }
}
