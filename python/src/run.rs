//! Runs as arrays, and the recordings that they become.

use crate::RunError;
use crate::arrow::{self, Column};
use crate::control::{Controller, Failed};
use crate::equilibrium::Searched;
use crate::interrupt::Interrupt;
use crate::recorder::{self, Columns};
use crate::scene::by_kind;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyKeyError, PyMemoryError, PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyBytes, PyCapsule, PyDict, PyList};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stillpoint::model::Model;
use stillpoint::record::{self, Event, Opening, Outcome, Recorder, Recording, RecordingFile};
use stillpoint::simulate::control::Function;
use stillpoint::simulate::{self, Settings, State, Summary};
use stillpoint::spatial::lanes::WIDTH;

/// A run: `run.time`, `run["arm.angle"]`, and what it came to.
#[pyclass(frozen, mapping, module = "stillpoint")]
pub(crate) struct Run {
    scene: record::Scene,
    /// The scenario, word for word.
    text: String,
    /// What `run --json` prints, without the equilibrium that it starts from.
    outcome: String,
    /// That equilibrium, if it starts from one and is no recording.
    held: Option<Arc<Searched>>,
    events: Vec<Event>,
    time: Py<PyArray1<f64>>,
    /// Name and unit, in order.
    names: Vec<(String, String)>,
    columns: Vec<Py<PyArray1<f64>>>,
    by_name: HashMap<String, usize>,
}

/// More samples than this are refused: each column would have 80 GB.
const MOST_SAMPLES: f64 = 1e10;

/// What is run: a model with its scenario, and from where.
#[derive(Clone)]
pub(crate) struct Asked {
    pub(crate) model: Arc<Model>,
    pub(crate) settings: Settings,
    pub(crate) rate: f64,
    pub(crate) start: State,
    /// The equilibrium that it is, if it is one.
    pub(crate) held: Option<Arc<Searched>>,
    /// Name and text of the scenario.
    pub(crate) name: String,
    pub(crate) text: String,
}

/// What came of it: columns, and a summary or why there is none.
pub(crate) type Done = (Columns, Result<Summary, simulate::RunError>);

impl Asked {
    /// Runs without Python; `None` if there is no memory for the samples.
    pub(crate) fn go(&self, go_on: &mut dyn FnMut() -> bool, function: Option<Function<'_>>) -> Option<Done> {
        let Self { model, settings, rate, start, .. } = self;
        let scene = simulate::scene(model);
        let samples = rate * settings.duration + 2.0;
        let mut columns = (samples < MOST_SAMPLES).then(|| Columns::new(&scene, samples as usize)).flatten()?;
        let go_on = &mut |_: f64, _: &State| go_on();
        let done = match function {
            Some(function) => simulate::run_controlled(model, settings, *rate, start, &mut columns, go_on, function),
            None => simulate::run(model, settings, *rate, start, &mut columns, go_on),
        };
        Some((columns, done))
    }

    /// Runs several side by side; `None` if they differ in more than numbers, if their scenes or methods are not computed so, or if
    /// there is no memory for the samples.
    pub(crate) fn go_together(all: [&Self; WIDTH], go_on: &dyn Fn() -> bool) -> Option<[Done; WIDTH]> {
        let Self { model, settings, rate, .. } = all[0];
        let is_alike = |one: &&Self| one.settings == *settings && one.rate == *rate;
        let samples = rate * settings.duration + 2.0;
        if !all.iter().all(is_alike) || !simulate::runs_together(model, settings) || samples >= MOST_SAMPLES {
            return None;
        }
        let room = |one: &Self| Columns::new(&simulate::scene(&one.model), samples as usize);
        let columns: Vec<Columns> = all.iter().map(|one| room(one)).collect::<Option<_>>()?;
        let mut columns: [Columns; WIDTH] = columns.try_into().ok()?;
        let (models, starts) = (all.map(|one| Arc::clone(&one.model)), all.map(|one| one.start.clone()));
        let mut recorders = columns.each_mut().map(|one| one as &mut dyn Recorder);
        let ran = simulate::run_together(&models, settings, *rate, &starts, &mut recorders, &mut |_, _| go_on())?;
        let mut ran = ran.into_iter();
        let done = columns.map(|columns| ran.next().map(|ran| (columns, ran)));
        done.into_iter().collect::<Option<Vec<_>>>()?.try_into().ok()
    }

    /// The run as Python sees it; the error of one that ended before its time has what there is as `run`.
    pub(crate) fn told(&self, py: Python<'_>, done: Option<Done>) -> PyResult<Run> {
        let Some((columns, done)) = done else {
            let samples = self.rate * self.settings.duration;
            let message = format!("{samples:.0} samples do not fit into memory: take a smaller `rate` or `duration`");
            return Err(PyMemoryError::new_err(message));
        };
        let scene = simulate::scene(&self.model);
        let run = |outcome: String| {
            Ok(Run { held: self.held.clone(), ..Run::new(py, scene, self.text.clone(), outcome, columns)? })
        };
        match done {
            Ok(summary) => run(stillpoint::cli::run_answer(&self.name, self.held.is_none(), &summary).to_string()),
            Err(error) => {
                let message = error.to_string();
                let outcome = py.import("json")?.call_method1("dumps", ([("error", &message)].into_py_dict(py)?,))?;
                let failed = RunError::new_err(message);
                failed.value(py).setattr("run", Py::new(py, run(outcome.extract()?)?)?)?;
                Err(failed)
            }
        }
    }
}

/// Runs a model and keeps its samples; `control` sets the inputs.
pub(crate) fn run(py: Python<'_>, asked: &Asked, control: Option<Controller>) -> PyResult<Run> {
    let interrupt = Interrupt::new();
    let watched = &interrupt;
    let failed = Failed::default();
    let noted = &failed;
    let done = py.detach(move || {
        let go_on = &mut || watched.go_on();
        match &control {
            None => asked.go(go_on, None),
            Some(controller) => {
                let mut law = controller.law(&asked.model, noted);
                asked.go(go_on, Some(Function { period: controller.period, law: &mut law }))
            }
        }
    });
    interrupt.check()?;
    asked.told(py, done).map_err(|error| failed.instead_of(py, error))
}

impl Run {
    fn new(py: Python<'_>, scene: record::Scene, text: String, outcome: String, columns: Columns) -> PyResult<Self> {
        let names = columns.names();
        let by_name = names.iter().enumerate().map(|(at, (name, _))| (name.clone(), at)).collect();
        let array = |numbers: Vec<f64>| -> PyResult<Py<PyArray1<f64>>> {
            let array = PyArray1::from_vec(py, numbers);
            array.call_method1("setflags", (false,))?;
            Ok(array.unbind())
        };
        Ok(Self {
            scene,
            text,
            outcome,
            held: None,
            events: columns.events,
            time: array(columns.time)?,
            names,
            columns: columns.columns.into_iter().map(array).collect::<PyResult<_>>()?,
            by_name,
        })
    }

    /// Reads a recording.
    pub(crate) fn open(py: Python<'_>, path: &Path) -> PyResult<Self> {
        let wrong = |error: record::RecordError| {
            let text = error.to_string();
            match &error {
                record::RecordError::Read { source, .. } => by_kind(source, text),
                _ => PyOSError::new_err(text),
            }
        };
        let recording = Recording::open(path).map_err(wrong)?;
        let mut columns = Columns::new(&recording.scene, 0).ok_or_else(|| PyMemoryError::new_err("no memory"))?;
        for sample in recording.samples().map_err(wrong)? {
            columns.take(&sample.map_err(wrong)?);
        }
        columns.events = recording.events().map_err(wrong)?;
        let Recording { scene, scenario, outcome, .. } = recording;
        Self::new(py, scene, scenario, outcome.unwrap_or_else(|| "{}".to_owned()), columns)
    }

    /// Writes the recording: what `stillpoint run` would have written.
    fn record(&self, py: Python<'_>, path: &Path) -> PyResult<()> {
        let time = self.time.bind(py).readonly();
        let columns: Vec<_> = self.columns.iter().map(|column| column.bind(py).readonly()).collect();
        let numbers: Vec<&[f64]> = columns.iter().map(|column| column.as_slice()).collect::<Result<_, _>>()?;
        let summary = self.whole(py)?;
        let write = || -> Result<(), record::RecordError> {
            let opening = Opening { scene: &self.scene, scenario: &self.text, statics: None };
            let mut file = RecordingFile::create(path)?.begin(&opening)?;
            let mut events = self.events.iter().peekable();
            for (index, now) in time.as_slice().unwrap_or_default().iter().enumerate() {
                while let Some(event) = events.next_if(|event| event.time < *now) {
                    file.event(event)?;
                }
                file.sample(&recorder::sample(&self.scene, *now, |at| numbers[at][index]).borrow())?;
            }
            events.try_for_each(|event| file.event(event))?;
            file.finish(&Outcome { summary: summary.clone() })
        };
        write().map_err(|error| PyOSError::new_err(error.to_string()))
    }

    /// The bytes of the recording.
    fn bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let folder = py.import("tempfile")?.call_method0("TemporaryDirectory")?;
        let path = PathBuf::from(folder.getattr("name")?.extract::<String>()?).join("run.mcap");
        let bytes = self.record(py, &path).and_then(|()| Ok(std::fs::read(&path)?));
        folder.call_method0("cleanup")?;
        Ok(PyBytes::new(py, &bytes?))
    }

    /// A number of the summary.
    fn told<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        self.summary(py)?.call_method1("get", (key,))
    }

    /// The summary, without the equilibrium that the run starts from.
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (&self.outcome,))
    }

    /// The text of the whole summary.
    fn whole(&self, py: Python<'_>) -> PyResult<String> {
        match self.held {
            Some(_) => py.import("json")?.call_method1("dumps", (self.as_dict(py)?,))?.extract(),
            None => Ok(self.outcome.clone()),
        }
    }

    /// The last numbers of columns.
    fn last<'py>(&self, py: Python<'py>, from: usize, count: usize) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let of = |column: &Py<PyArray1<f64>>| {
            let numbers = column.bind(py).readonly();
            numbers.as_slice().ok().and_then(|numbers| numbers.last().copied()).unwrap_or(f64::NAN)
        };
        Ok(PyArray1::from_vec(py, self.columns[from..from + count].iter().map(of).collect()))
    }
}

#[pymethods]
impl Run {
    /// Times of the samples (s).
    #[getter]
    fn time(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.time.clone_ref(py)
    }

    /// Names of the columns.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.names.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// The SI unit of each column.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let units = PyDict::new(py);
        self.names.iter().try_for_each(|(name, unit)| units.set_item(name, unit))?;
        Ok(units)
    }

    fn __getitem__(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyArray1<f64>>> {
        match self.by_name.get(name) {
            Some(at) => Ok(self.columns[*at].clone_ref(py)),
            None if name == "time" => Ok(self.time.clone_ref(py)),
            None => {
                let known = self.names.iter().map(|(name, _)| name.as_str());
                let near = stillpoint::suggest::closest(name, known).map(|near| format!("; did you mean `{near}`?"));
                Err(PyKeyError::new_err(format!("no column is called `{name}`{}", near.unwrap_or_default())))
            }
        }
    }

    fn __len__(&self) -> usize {
        self.names.len()
    }

    fn __contains__(&self, name: &str) -> bool {
        name == "time" || self.by_name.contains_key(name)
    }

    fn __iter__(slf: &Bound<'_, Self>) -> PyResult<Py<PyAny>> {
        let names = PyList::new(slf.py(), slf.get().columns())?;
        Ok(names.call_method0("__iter__")?.unbind())
    }

    fn keys(&self) -> Vec<&str> {
        self.columns()
    }

    /// The samples as a table, the time first, for programs that speak Arrow: `polars.DataFrame(run)`. Nothing is copied.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let _ = requested_schema;
        let column = |(name, unit): (&str, &str), values: &Py<PyArray1<f64>>| Column {
            name: name.to_owned(),
            unit: unit.to_owned(),
            values: values.bind(py).clone().into_any(),
        };
        let rest = self
            .names
            .iter()
            .zip(&self.columns)
            .map(|((name, unit), values)| column((name.as_str(), unit.as_str()), values));
        arrow::stream(py, [column(("time", "s"), &self.time)].into_iter().chain(rest).collect(), false)
    }

    /// Everything that `stillpoint run --json` prints; of a recording what its run printed.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let told = self.summary(py)?;
        // A run that ended before its time has an error in place of the summary.
        if let Some(held) = self.held.as_ref().filter(|_| told.contains("start").unwrap_or(false)) {
            told.set_item("start", py.import("json")?.call_method1("loads", (held.text(),))?)?;
        }
        Ok(told)
    }

    /// Reached time (s).
    #[getter]
    fn end_time(&self, py: Python<'_>) -> PyResult<f64> {
        let told: Option<f64> = self.told(py, "end_time")?.extract()?;
        // Of one that ended before its time the last sample.
        let last = || self.time.bind(py).readonly().as_slice().ok().and_then(|time| time.last().copied());
        Ok(told.or_else(last).unwrap_or(0.0))
    }

    /// The last positions.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.last(py, 0, self.scene.positions.len())
    }

    /// The last velocities.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.last(py, self.scene.positions.len(), self.scene.velocities.len())
    }

    /// The last positions by hinge.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let last = self.told(py, "final")?;
        if last.is_none() { Ok(last) } else { last.get_item("positions") }
    }

    /// What happened: dictionaries with `time`, `kind`, `name`, `value`, `speed`.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.summary(py)?.call_method1("get", ("events", PyList::empty(py)))
    }

    /// Steps that were taken.
    #[getter]
    fn steps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.told(py, "steps")
    }

    /// Largest energy that is unaccounted for (J).
    #[getter]
    fn energy_drift<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.told(py, "energy_drift")
    }

    /// The methods that stepped.
    #[getter]
    fn integrators(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let told: Option<String> = self.told(py, "integrator")?.extract()?;
        Ok(told.map_or(Vec::new(), |told| told.split(", ").map(str::to_owned).collect()))
    }

    /// Writes a recording (`.mcap`), or the columns as a table (`.csv`).
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        match path.extension().and_then(|end| end.to_str()) {
            Some("mcap") => self.record(py, &path),
            Some("csv") => {
                let columns: Vec<_> = self.columns.iter().map(|column| column.clone_ref(py)).collect();
                let table = (path, self.names.clone(), self.time.clone_ref(py), columns);
                py.import("stillpoint._table")?.call_method1("save", table)?;
                Ok(())
            }
            _ => {
                let message = format!("`{}`: the name ends in .mcap (a recording) or .csv (a table)", path.display());
                Err(PyValueError::new_err(message))
            }
        }
    }

    /// Writes a page that opens anywhere, as `stillpoint report` makes of the recording.
    fn report(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.import("stillpoint._files")?.call_method1("report", (self.bytes(py)?, path))?;
        Ok(())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let samples = self.time.bind(py).len()?;
        let (end, methods) = (self.end_time(py)?, self.integrators(py)?.join(", then "));
        let methods = if methods.is_empty() { "it ended before its time".to_owned() } else { methods };
        Ok(format!("<Run of `{}` to {end} s: {samples} samples, {methods}>", self.scene.title))
    }

    /// For notebooks.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("stillpoint._html")?.call_method1("run", (slf,))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let py = slf.py();
        Ok((py.get_type::<Self>().getattr("_again")?, (slf.get().bytes(py)?,)))
    }

    #[staticmethod]
    fn _again<'py>(py: Python<'py>, bytes: &Bound<'py, PyBytes>) -> PyResult<Bound<'py, PyAny>> {
        py.import("stillpoint._files")?.call_method1("opened", (bytes,))
    }
}

/// Reads a recording (`.mcap`), finished or not.
#[pyfunction]
pub(crate) fn open(py: Python<'_>, path: PathBuf) -> PyResult<Run> {
    Run::open(py, &path)
}
