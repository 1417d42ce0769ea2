//! Many runs, and many cases, on all processors.

use crate::NoEquilibrium;
use crate::dynamics::shown;
use crate::equilibrium::Equilibrium;
use crate::interrupt::Interrupt;
use crate::run::{Asked, Done};
use crate::scene::Scene;
use crate::start::{Keywords, Refused};
use numpy::PyArray1;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString};
use std::convert::Infallible;
use std::num::NonZeroUsize;
use std::ops::RangeInclusive;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use stillpoint::scenario::{Override, Scenario};
use stillpoint::spatial::lanes::WIDTH;
use stillpoint::study::plan::MOST_CASES;
use stillpoint::study::{Axis, Cases, Cell, Column, Draw, Kind, Plan, Question, Row, Sampling, Variation, pool};
use stillpoint::suggest::closest;

/// Rows that are handed over at once.
const ROWS: u64 = 16;

/// How many threads an argument `threads` stands for; without one as many as there are processors.
pub(crate) fn processors(threads: Option<usize>) -> PyResult<usize> {
    match threads {
        Some(0) => Err(PyValueError::new_err("`threads` is 0, allowed: at least 1")),
        Some(threads) => Ok(threads),
        None => Ok(std::thread::available_parallelism().map_or(1, NonZeroUsize::get)),
    }
}

/// The items of an argument that is a list, and no text.
pub(crate) fn list<'py>(name: &str, given: &Bound<'py, PyAny>, expected: &str) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let refused = || PyTypeError::new_err(format!("`{name}` is {}, expected: {expected}", shown(given)));
    if given.is_instance_of::<PyString>() || given.is_instance_of::<PyDict>() {
        return Err(refused());
    }
    given.try_iter().map_err(|_| refused())?.collect()
}

/// A case that has been worked on: what was asked for, and what came of it, or why there is nothing.
type Case = Result<(Asked, Option<Done>), Refused>;

/// The outcome of one case; what ends everything, as Ctrl-C does, is none of one.
pub(crate) fn unless_ended<T>(py: Python<'_>, of: PyResult<T>) -> PyResult<PyResult<T>> {
    match of {
        Err(error) if !error.is_instance_of::<PyException>(py) => Err(error),
        other => Ok(other),
    }
}

/// A run of a scene for each of several settings, on so many threads, side by side where `lanes` allows it: in the place of one that
/// fails its exception.
pub(crate) fn runs<'py>(
    scene: &Bound<'py, Scene>,
    sets: &[PyResult<Vec<String>>],
    keywords: &Keywords,
    (threads, lanes): (usize, bool),
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let py = scene.py();
    let interrupt = Interrupt::new();
    let (watched, this) = (&interrupt, scene.get());
    let some = if lanes { WIDTH } else { 1 };
    let texts: Vec<Option<&[String]>> = sets.iter().map(|set| set.as_deref().ok()).collect();
    let groups: Vec<&[Option<&[String]>]> = texts.chunks(some).collect();
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<Vec<Option<Case>>>> = Mutex::new(groups.iter().map(|_| Vec::new()).collect());
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(group) = groups.get(index) else { return };
            let cases = together(this, group, keywords, &|| watched.go_on());
            done.lock().unwrap_or_else(PoisonError::into_inner)[index] = cases;
        }
    };
    py.detach(|| {
        std::thread::scope(|scope| {
            for _ in 1..threads.min(groups.len().max(1)) {
                scope.spawn(work);
            }
            work();
        });
    });
    interrupt.check()?;
    let cases = done.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().flatten();
    let told = |(set, case): (&PyResult<Vec<String>>, Option<Case>)| {
        let run = match (set, case) {
            (Err(error), _) => Err(error.clone_ref(py)),
            (_, Some(Ok((asked, done)))) => asked.told(py, done),
            (_, Some(Err(refused))) => Err(raised(py, refused)),
            (_, None) => Err(PyKeyboardInterrupt::new_err(())),
        };
        match unless_ended(py, run)? {
            Ok(run) => Ok(Bound::new(py, run)?.into_any()),
            Err(error) => Ok(error.into_value(py).into_bound(py).into_any()),
        }
    };
    sets.iter().zip(cases).map(told).collect()
}

fn raised(py: Python<'_>, refused: Refused) -> PyErr {
    match refused {
        Refused::Scene(error) => error,
        Refused::Statics(why) => NoEquilibrium::new_err(why),
        Refused::NoEquilibrium(scene, found) => match Py::new(py, *scene) {
            Ok(scene) => Equilibrium::new(scene, found).refused(py),
            Err(error) => error,
        },
    }
}

/// Prepares some cases and runs them, side by side if they are as many as are computed so and differ in numbers alone. `None` for one
/// without settings, and for all that `go_on` ended.
fn together(
    scene: &Scene,
    group: &[Option<&[String]>],
    keywords: &Keywords,
    go_on: &dyn Fn() -> bool,
) -> Vec<Option<Case>> {
    let prepare = |set: &Option<&[String]>| keywords.prepared(scene, (*set)?, go_on);
    let prepared: Vec<Option<Result<Asked, Refused>>> = group.iter().map(prepare).collect();
    let ready: Vec<&Asked> = prepared.iter().flatten().filter_map(|one| one.as_ref().ok()).collect();
    let all: Option<[&Asked; WIDTH]> = ready.try_into().ok();
    let mut done = all.and_then(|all| Asked::go_together(all, go_on)).map(IntoIterator::into_iter);
    let mut run = |asked: Asked| {
        let own = match &mut done {
            Some(done) => done.next(),
            None => asked.go(&mut || go_on(), None),
        };
        (asked, own)
    };
    prepared.into_iter().map(|one| one.map(|one| one.map(&mut run))).collect()
}

/// A whole number within a range.
fn whole(name: &str, given: i128, range: RangeInclusive<u64>) -> PyResult<u64> {
    u64::try_from(given).ok().filter(|number| range.contains(number)).ok_or_else(|| {
        let (low, high) = range.into_inner();
        PyValueError::new_err(format!("`{name}` is {given}, allowed: a whole number from {low} to {high}"))
    })
}

/// The plan of the arguments of a sweep.
pub(crate) fn plan(
    over: Option<&Bound<'_, PyDict>>,
    vary: Option<&Bound<'_, PyDict>>,
    cases: Option<i128>,
    seed: i128,
    sample: Option<&str>,
) -> PyResult<Plan> {
    let wrong = |message: String| PyValueError::new_err(message);
    let cases = cases.map(|cases| whole("cases", cases, 1..=MOST_CASES)).transpose()?;
    let seed = whole("seed", seed, 0..=u64::MAX)?;
    let mut axes = Vec::new();
    for (path, values) in over.iter().flat_map(|over| over.iter()) {
        let path: String = path.extract()?;
        if path.trim().is_empty() {
            return Err(wrong("`over` has an empty address, expected: one as \"arm.mass\"".to_owned()));
        }
        let text = match values.extract::<String>() {
            Ok(text) => text,
            Err(_) => {
                let inline = values.py().import("stillpoint._toml")?.getattr("inline")?;
                let name = format!("over[{path:?}]");
                let items = list(&name, &values, "a list of values")?;
                if items.is_empty() {
                    return Err(wrong(format!("`{name}` is an empty list, expected: a list of values")));
                }
                let items = items.into_iter().map(|item| inline.call1((item,))?.extract::<String>());
                items.collect::<PyResult<Vec<_>>>()?.join(",")
            }
        };
        if text.trim().is_empty() {
            let message = format!("`over[{path:?}]` is an empty text, expected: values, as \"1:5:9\" or \"1,2,5\"");
            return Err(wrong(message));
        }
        axes.push(Axis::parse(&format!("{path}={text}")).map_err(wrong)?);
    }
    let mut varied = Vec::new();
    for (path, distribution) in vary.iter().flat_map(|vary| vary.iter()) {
        let path = path.extract::<String>()?;
        let distribution = distribution.extract::<String>().map_err(|_| {
            let given = shown(&distribution);
            PyTypeError::new_err(format!("`vary[{path:?}]` is {given}, expected: a text, as \"normal(2, 0.1)\""))
        })?;
        let text = format!("{path}={distribution}");
        varied.push(Variation::parse(&text).map_err(wrong)?);
    }
    if axes.is_empty() && varied.is_empty() {
        return Err(wrong("give values in `over` or distributions in `vary`".to_owned()));
    }
    if varied.is_empty() != cases.is_none() {
        return Err(wrong("`vary` and `cases` belong together".to_owned()));
    }
    let sampling = match sample {
        None => Sampling::default(),
        Some(name) => Sampling::ALL.into_iter().find(|one| one.name() == name).ok_or_else(|| {
            let near = closest(name, Sampling::ALL.iter().map(|one| one.name()));
            let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
            wrong(format!("no way to sample is called `{name}`{near}"))
        })?,
    };
    let draw = Draw { sampling, samples: cases.unwrap_or(1), seed };
    Plan::new(axes, varied, draw, None).map_err(wrong)
}

/// Answers all cases; columns by name.
pub(crate) fn sweep<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    set: Vec<Override>,
    plan: Plan,
    (run, time_limit): (bool, f64),
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyDict>> {
    let threads = processors(threads)?;
    let question = Question { run, time_limit };
    let cases = Cases::new(scenario.clone(), set, plan, question);
    let cases = cases.map_err(|refusal| PyValueError::new_err(refusal.to_string()))?;
    let count = cases.plan.cases();
    let interrupt = Interrupt::new();
    let watched = &interrupt;
    let rows = Mutex::new(Vec::<Row>::new());
    let take = |_: u64, answered: Vec<Row>| -> Result<(), Infallible> {
        rows.lock().unwrap_or_else(PoisonError::into_inner).extend(answered);
        Ok(())
    };
    py.detach(|| {
        let parts = (0..count.div_ceil(ROWS)).map(|part| (part, part * ROWS..((part + 1) * ROWS).min(count)));
        pool::answer(&cases, parts, threads, &|| watched.go_on(), &|| (), &take)
    })
    .unwrap_or(false);
    interrupt.check()?;
    let mut rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
    rows.sort_by_key(|row| row.case);
    let all = PyDict::new(py);
    for (index, column) in cases.columns().iter().enumerate() {
        all.set_item(&column.name, array(py, column, rows.iter().map(|row| &row.cells[index]))?)?;
    }
    Ok(all)
}

/// A column: numbers as an array, `nan` where there is none; all else as a list.
fn array<'py, 'c>(
    py: Python<'py>,
    column: &Column,
    cells: impl Iterator<Item = &'c Cell>,
) -> PyResult<Bound<'py, PyAny>> {
    if column.kind == Kind::Number {
        let number = |cell: &Cell| if let Cell::Number(number) = cell { *number } else { f64::NAN };
        return Ok(PyArray1::from_vec(py, cells.map(number).collect()).into_any());
    }
    let list = PyList::empty(py);
    for cell in cells {
        match cell {
            Cell::Empty => list.append(py.None())?,
            Cell::Number(number) => list.append(number)?,
            Cell::Whole(number) => list.append(number)?,
            Cell::Word(word) => list.append(word.as_ref())?,
            Cell::Flag(flag) => list.append(flag)?,
        }
    }
    Ok(list.into_any())
}
