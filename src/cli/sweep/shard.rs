//! Which part of a study this process works on.

use anyhow::{Context, bail};

/// One of several processes that share a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shard {
    /// 0 … `of` − 1.
    pub(super) index: u64,
    /// How many there are.
    pub(super) of: u64,
}

impl Shard {
    /// The only one.
    pub(super) const WHOLE: Self = Self { index: 0, of: 1 };

    /// The shard that is asked for, and what says so if it is not the command line: the index that an engine gives its tasks.
    ///
    /// # Errors
    /// If there is no index, or one that is not below the number of shards.
    pub(super) fn chosen(
        of: Option<u64>,
        index: Option<u64>,
        environment: impl Fn(&str) -> Option<String>,
    ) -> anyhow::Result<(Self, Option<String>)> {
        let Some(of) = of else {
            if index.is_some() {
                bail!("`--shard` is one of several: say how many with `--shards`");
            }
            return Ok((Self::WHOLE, None));
        };
        let (index, source) = match index {
            Some(index) => (index, None),
            None => of_engine(of, environment)?,
        };
        if index >= of {
            let named =
                source.map_or(format!("`--shard {index}`"), |source| format!("{source} stands for shard {index}"));
            bail!("{named}: the shards of `--shards {of}` are 0 to {}", of.saturating_sub(1));
        }
        Ok((Self { index, of }, source))
    }

    /// Whether a part is one of its own.
    pub(super) fn has(self, part: u64) -> bool {
        part % self.of == self.index
    }
}

/// The index of a task: of the innermost engine, should one run inside another.
fn of_engine(of: u64, environment: impl Fn(&str) -> Option<String>) -> anyhow::Result<(u64, Option<String>)> {
    let number = |name: &str| -> anyhow::Result<Option<u64>> {
        let parse = |text: String| text.trim().parse().with_context(|| format!("{name}={text} is no index of a task"));
        environment(name).map(parse).transpose()
    };
    for name in ["HQ_TASK_ID", "JOB_COMPLETION_INDEX"] {
        if let Some(index) = number(name)? {
            return Ok((index, Some(format!("{name}={index}"))));
        }
    }
    let Some(task) = number("SLURM_ARRAY_TASK_ID")? else {
        bail!(
            "`--shards {of}` without `--shard`, and none of HQ_TASK_ID, JOB_COMPLETION_INDEX, SLURM_ARRAY_TASK_ID is set: say \
             which shard this is, 0 to {}",
            of.saturating_sub(1)
        );
    };
    let least = number("SLURM_ARRAY_TASK_MIN")?.unwrap_or(0);
    let most = number("SLURM_ARRAY_TASK_MAX")?;
    // An array of all shards may begin at any number. One of some of them, as `--missing` prints them, has their own numbers.
    let all = most.is_none_or(|most| most.checked_sub(least) == of.checked_sub(1));
    match task.checked_sub(least).filter(|_| all) {
        Some(index) => Ok((index, Some(format!("SLURM_ARRAY_TASK_ID={task} (an array that begins at {least})")))),
        None => Ok((task, Some(format!("SLURM_ARRAY_TASK_ID={task} (an array of some of the shards)")))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(of: u64, set: &[(&str, &str)]) -> Result<u64, String> {
        let environment =
            |name: &str| set.iter().find(|(other, _)| *other == name).map(|(_, value)| (*value).to_owned());
        Shard::chosen(Some(of), None, environment).map(|(shard, _)| shard.index).map_err(|error| error.to_string())
    }

    #[test]
    fn the_innermost_engine_says_which_shard_it_is() {
        assert_eq!(chosen(4, &[("HQ_TASK_ID", "3"), ("SLURM_ARRAY_TASK_ID", "1")]), Ok(3));
        assert_eq!(chosen(4, &[("JOB_COMPLETION_INDEX", "0")]), Ok(0));
        let slurm = |task: &'static str, least: &'static str, most: &'static str| {
            let names = ["SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_MAX"];
            chosen(4, &names.into_iter().zip([task, least, most]).collect::<Vec<_>>())
        };
        assert_eq!(slurm("1", "1", "4"), Ok(0));
        assert_eq!(slurm("4", "1", "4"), Ok(3));
        assert_eq!(slurm("2", "0", "3"), Ok(2));
        // Shards 1 and 3 again: their own numbers.
        assert_eq!(slurm("1", "1", "3"), Ok(1));
        assert_eq!(slurm("3", "1", "3"), Ok(3));
        let beyond = "SLURM_ARRAY_TASK_ID=4 (an array of some of the shards) stands for shard 4: the shards of `--shards 4` are 0 to 3";
        assert_eq!(slurm("4", "2", "4"), Err(beyond.to_owned()));
        assert!(chosen(4, &[]).is_err_and(|error| error.contains("say which shard")));
        assert!(chosen(4, &[("HQ_TASK_ID", "x")]).is_err());
        assert!(chosen(4, &[("HQ_TASK_ID", "4")]).is_err_and(|error| error.contains("HQ_TASK_ID=4")));
    }

    #[test]
    fn every_part_belongs_to_one_shard() {
        for of in 1..6 {
            for part in 0..20 {
                assert_eq!((0..of).filter(|index| Shard { index: *index, of }.has(part)).count(), 1);
            }
        }
    }
}
