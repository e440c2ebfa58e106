//! The shard argument `K/N`: given, or read from the environment of a scheduler.

use std::str::FromStr;

use anyhow::{Context, Result, bail, ensure};
use superegg_render::Shard;

/// `K/N`, `auto` or `auto/N`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShardArg {
    /// A given shard.
    Given(Shard),
    /// The shard of this job among the jobs of its scheduler; `count` is the number of shards if
    /// given.
    Auto { count: Option<u32> },
}

impl FromStr for ShardArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.strip_prefix("auto") {
            Some("") => Ok(Self::Auto { count: None }),
            Some(count) => {
                let count = count.strip_prefix('/').and_then(|digits| digits.parse().ok());
                let count =
                    count.filter(|&count: &u32| count > 0).ok_or("expected auto/N, such as auto/8")?;
                Ok(Self::Auto { count: Some(count) })
            }
            None => text.parse().map(Self::Given),
        }
    }
}

/// The number of a job in a Slurm array. The first number is arbitrary.
const SLURM_ID: &str = "SLURM_ARRAY_TASK_ID";
/// The index of a pod in an indexed Kubernetes job, from 0.
const KUBERNETES_INDEX: &str = "JOB_COMPLETION_INDEX";
/// The number of pods. Kubernetes does not set it; a manifest can.
const KUBERNETES_COUNT: &str = "JOB_COMPLETIONS";

impl ShardArg {
    /// The shard of this process.
    ///
    /// # Errors
    /// `auto` finds no scheduler in the environment, or inconsistent variables.
    pub(crate) fn resolve(self) -> Result<Shard> {
        self.resolve_in(&|name| std::env::var(name).ok())
    }

    fn resolve_in(self, variable: &dyn Fn(&str) -> Option<String>) -> Result<Shard> {
        let count = match self {
            Self::Given(shard) => return Ok(shard),
            Self::Auto { count } => count,
        };
        match (variable(SLURM_ID), variable(KUBERNETES_INDEX)) {
            (Some(_), None) => slurm_shard(count, variable),
            (None, Some(_)) => kubernetes_shard(count, variable),
            (Some(_), Some(_)) => {
                bail!("both {SLURM_ID} and {KUBERNETES_INDEX} are set; name the shard: K/N")
            }
            (None, None) => bail!(
                "'auto' looks for {SLURM_ID} (in a job of a Slurm array) or {KUBERNETES_INDEX} (in an indexed Kubernetes job), and neither is set; name the shard: K/N"
            ),
        }
    }
}

/// The value of an environment variable as a number.
fn number(name: &str, variable: &dyn Fn(&str) -> Option<String>) -> Result<Option<u32>> {
    let read = |text: String| {
        text.parse().with_context(|| format!("{name} is '{text}', and should be a number from 0 up"))
    };
    variable(name).map(read).transpose()
}

/// The shard of a job in a Slurm array: K of N by its number in the array, or with `count` by its
/// number alone.
fn slurm_shard(count: Option<u32>, variable: &dyn Fn(&str) -> Option<String>) -> Result<Shard> {
    let get = |what: &str| number(&format!("SLURM_ARRAY_TASK_{what}"), variable);
    let need = |what: &str| {
        get(what)?.with_context(|| format!("{SLURM_ID} is set, but not SLURM_ARRAY_TASK_{what}"))
    };
    let id = need("ID")?;
    if let Some(count) = count {
        // A later array can repeat some of the jobs: the number of the job is that of the shard in
        // any array.
        return Shard::new(id, count)
            .filter(|_| get("MIN").ok().flatten() != Some(0))
            .with_context(|| format!("with auto/{count} the jobs of the array are numbered from 1: --array=1-{count}; this one is {id}"));
    }
    let (min, max, step) = (need("MIN")?, need("MAX")?, get("STEP")?.unwrap_or(1).max(1));
    let in_range = (min..=max).contains(&id) && (id - min).is_multiple_of(step);
    let reported = get("COUNT")?;
    // Checked, because the range 0-4294967295 overflows.
    let shards = max.checked_sub(min).and_then(|span| (span / step).checked_add(1));
    let shards = shards.filter(|shards| in_range && reported.is_none_or(|count| count == *shards));
    let shard = shards.and_then(|shards| Shard::new((id - min) / step + 1, shards));
    shard.with_context(|| {
        let reported = reported.map_or_else(String::new, |count| format!(", COUNT {count}"));
        format!(
            "the jobs of this array are not numbered evenly (ID {id}, MIN {min}, MAX {max}, STEP {step}{reported} after SLURM_ARRAY_TASK_); to run some of them again, give the number of shards: auto/N, and number the jobs from 1"
        )
    })
}

/// The shard of a pod in an indexed Kubernetes job.
fn kubernetes_shard(count: Option<u32>, variable: &dyn Fn(&str) -> Option<String>) -> Result<Shard> {
    let index =
        number(KUBERNETES_INDEX, variable)?.with_context(|| format!("{KUBERNETES_INDEX} is not set"))?;
    let reported = number(KUBERNETES_COUNT, variable)?;
    if let (Some(count), Some(reported)) = (count, reported) {
        ensure!(count == reported, "auto/{count} contradicts {KUBERNETES_COUNT}, which is {reported}");
    }
    let count = count.or(reported).with_context(|| {
        format!("{KUBERNETES_INDEX} is set, but not the number of pods: use auto/N, with the job's 'completions' for N, or set {KUBERNETES_COUNT}")
    })?;
    ensure!(count > 0, "{KUBERNETES_COUNT} is 0, and should be at least 1");
    index.checked_add(1).and_then(|number| Shard::new(number, count)).with_context(|| {
        format!("{KUBERNETES_INDEX} is {index}, but of {count} shards the last has the index {}", count - 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The shard of an argument in an environment of `NAME=value` words.
    fn shard(argument: &str, environment: &str) -> Result<String, String> {
        let variable = |name: &str| {
            let pairs = environment.split_whitespace().filter_map(|pair| pair.split_once('='));
            pairs
                .filter(|(key, _)| key.replace("S_", "SLURM_ARRAY_TASK_") == name)
                .map(|(_, value)| value.to_owned())
                .next()
        };
        let shard = argument.parse::<ShardArg>()?.resolve_in(&variable);
        shard.map(|shard| shard.to_string()).map_err(|error| format!("{error:#}"))
    }

    #[test]
    fn shards_of_slurm_arrays() {
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
            assert_eq!(shard(argument, environment).as_deref(), Ok(expected), "{argument} {environment}");
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
            let error = shard(argument, environment).unwrap_err();
            assert!(error.contains(expected), "{argument} {environment}: {error}");
        }
    }

    #[test]
    fn shards_of_kubernetes_jobs() {
        for (argument, environment, expected) in [
            ("auto/8", "JOB_COMPLETION_INDEX=0", "1/8"),
            ("auto/8", "JOB_COMPLETION_INDEX=7", "8/8"),
            ("auto", "JOB_COMPLETION_INDEX=2 JOB_COMPLETIONS=3", "3/3"),
            ("auto/3", "JOB_COMPLETION_INDEX=2 JOB_COMPLETIONS=3", "3/3"),
        ] {
            assert_eq!(shard(argument, environment).as_deref(), Ok(expected), "{argument} {environment}");
        }
        for (argument, environment, expected) in [
            ("auto", "JOB_COMPLETION_INDEX=2", "use auto/N"),
            ("auto/8", "JOB_COMPLETION_INDEX=8", "the last has the index 7"),
            ("auto/8", "JOB_COMPLETION_INDEX=4294967295", "the last has the index 7"),
            ("auto/8", "JOB_COMPLETION_INDEX=", "should be a number"),
            ("auto/8", "JOB_COMPLETION_INDEX=1 JOB_COMPLETIONS=9", "contradicts JOB_COMPLETIONS"),
            ("auto", "JOB_COMPLETION_INDEX=0 JOB_COMPLETIONS=0", "should be at least 1"),
        ] {
            let error = shard(argument, environment).unwrap_err();
            assert!(error.contains(expected), "{argument} {environment}: {error}");
        }
    }

    #[test]
    fn words_that_are_no_shard() {
        for bad in ["", "auto/", "auto/0", "auto/x", "automatic", "auto8", "0/3", "4/3", "3"] {
            assert!(bad.parse::<ShardArg>().is_err(), "{bad}");
        }
    }
}
