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
            let next = lock(&work).next(cases.width() as u64);
            let Some((part, some)) = next else { return };
            let count = some.end - some.start;
            let rows = cases.rows(some, go_on);
            (0..count).for_each(|_| progress());
            let complete = lock(&work).put(part, rows);
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
    /// The next cases, so many of one part or what remains of it, and that part.
    fn next(&mut self, most: u64) -> Option<Part> {
        if self.ended.is_some() {
            return None;
        }
        loop {
            if let Some((part, cases)) = &mut self.current
                && !cases.is_empty()
            {
                let some = cases.start..cases.end.min(cases.start + most);
                cases.start = some.end;
                return Some((*part, some));
            }
            let (part, cases) = self.parts.next()?;
            self.open.insert(part, (Vec::new(), cases.end - cases.start));
            self.current = Some((part, cases));
        }
    }

    /// Keeps rows; all rows of the part, in order, if they were the last ones.
    fn put(&mut self, part: u64, some: Option<Vec<Row>>) -> Option<Vec<Row>> {
        let Some(some) = some else {
            self.ended.get_or_insert(Ended::Interrupted);
            return None;
        };
        let (rows, missing) = self.open.get_mut(&part)?;
        *missing -= some.len() as u64;
        rows.extend(some);
        if *missing > 0 {
            return None;
        }
        let (mut rows, _) = self.open.remove(&part)?;
        rows.sort_unstable_by_key(|row| row.case);
        Some(rows)
    }
}
