//! Threads over cases. Rows are handed over part by part, as soon as all rows of a part are there.

use super::case::{Cases, Row};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A part of a study: its number and its cases.
pub type Part = (u64, Range<u64>);

/// Takes what a part has become, and may stop everything by an error.
pub type Take<'t, E> = &'t (dyn Fn(u64, Vec<Row>) -> Result<(), E> + Sync);

/// What all threads share.
struct Work<P, E> {
    parts: P,
    /// The remaining cases of the part that is given out.
    current: Option<Part>,
    /// Parts of which rows are missing: rows that are there, and how many are missing. At most one more than there are threads.
    open: HashMap<u64, (Vec<Row>, u64)>,
    ended: Option<Ended<E>>,
}

enum Ended<E> {
    Interrupted,
    Failed(E),
}

/// Answers all cases of the parts by so many threads, as many of them as the system gives. `go_on` ends it when it says
/// `false`: parts that are not complete by then are dropped. `progress` is told of every row. Whether all parts are done.
///
/// # Errors
/// The first error of `take`; then nothing more is begun.
pub fn answer<E: Send>(
    cases: &Cases,
    parts: impl Iterator<Item = Part> + Send,
    threads: usize,
    go_on: &(dyn Fn() -> bool + Sync),
    progress: &(dyn Fn() + Sync),
    take: Take<'_, E>,
) -> Result<bool, E> {
    let work = Mutex::new(Work { parts, current: None, open: HashMap::new(), ended: None });
    let one = || {
        loop {
            let next = lock(&work).next();
            let Some((part, case)) = next else { return };
            let row = cases.row(case, go_on);
            progress();
            let complete = lock(&work).put(part, row);
            if let Some(rows) = complete
                && let Err(error) = take(part, rows)
            {
                lock(&work).ended = Some(Ended::Failed(error));
            }
        }
    };
    std::thread::scope(|scope| {
        let others = (1..threads).map_while(|_| std::thread::Builder::new().spawn_scoped(scope, one).ok());
        let others: Vec<_> = others.collect();
        one();
        drop(others);
    });
    match work.into_inner().unwrap_or_else(PoisonError::into_inner).ended {
        None => Ok(true),
        Some(Ended::Interrupted) => Ok(false),
        Some(Ended::Failed(error)) => Err(error),
    }
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<P: Iterator<Item = Part>, E> Work<P, E> {
    /// The next case and its part.
    fn next(&mut self) -> Option<(u64, u64)> {
        if self.ended.is_some() {
            return None;
        }
        loop {
            if let Some((part, cases)) = &mut self.current
                && let Some(case) = cases.next()
            {
                return Some((*part, case));
            }
            let (part, cases) = self.parts.next()?;
            self.open.insert(part, (Vec::new(), cases.end - cases.start));
            self.current = Some((part, cases));
        }
    }

    /// Keeps a row; all rows of the part, in order, if it was the last one.
    fn put(&mut self, part: u64, row: Option<Row>) -> Option<Vec<Row>> {
        let Some(row) = row else {
            self.ended.get_or_insert(Ended::Interrupted);
            return None;
        };
        let (rows, missing) = self.open.get_mut(&part)?;
        rows.push(row);
        *missing -= 1;
        if *missing > 0 {
            return None;
        }
        let (mut rows, _) = self.open.remove(&part)?;
        rows.sort_unstable_by_key(|row| row.case);
        Some(rows)
    }
}
