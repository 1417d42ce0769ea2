//! `study` of a dataset: what the rows of `sweep` say.

mod plot;

use super::super::text::{count, number, small};
use super::super::{Exit, inputs::Inputs, output};
use super::Arguments;
use crate::study::reader::Reader;
use crate::study::statistics::{CONFIDENCE, Moments, Regression, quantiles};
use crate::suggest::closest;
use anyhow::{anyhow, bail};
use serde_json::{Map, Value, json};

/// Quantiles that are told.
const PARTS: [f64; 5] = [0.01, 0.05, 0.5, 0.95, 0.99];
/// Less than this part of the variance leaves more to what is not a line than to all lines together: coefficients rank nothing.
const LINEAR: f64 = 0.5;
/// Inputs that are listed.
const MOST_INPUTS: usize = 10;

/// What is said of one column.
struct Output {
    name: String,
    unit: String,
    /// Of the inputs, and last of the column.
    moments: Moments,
    quantiles: Vec<f64>,
    regression: Option<Regression>,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let reader = Reader::open(&arguments.studied).map_err(|error| anyhow!(error))?;
    let study = Study { inputs: numeric(&reader, &reader.inputs), reader };
    let names = study.chosen(&arguments.dataset.of)?;
    if let Some(path) = &arguments.dataset.svg {
        Inputs::default().spare(path)?;
        if names.len() != 1 {
            bail!("`--svg` draws one column: name one with `--of`");
        }
    }
    let (mut rows, mut answered) = (0_u64, 0_u64);
    study.each(&[], &mut |ok, _| {
        rows += 1;
        answered += u64::from(ok);
    })?;
    let mut outputs = Vec::new();
    for (name, unit) in names {
        let asked = arguments.dataset.of.contains(&name);
        outputs.extend(study.output(name, unit, asked)?);
    }
    if let Some((path, output)) = arguments.dataset.svg.as_ref().zip(outputs.first()) {
        output::save(path, plot::draw(&study, output, arguments.dataset.theme)?.as_bytes())?;
    }
    if arguments.json {
        let list: Vec<Value> = outputs.iter().map(|output| study.json(output)).collect();
        let answer = json!({
            "dataset": arguments.studied.display().to_string(), "cases": study.reader.cases, "rows": rows,
            "failed": rows - answered, "outputs": list,
        });
        output::print(&answer.to_string())?;
    } else if !arguments.quiet {
        let there = if rows < study.reader.cases { format!(" of {}", study.reader.cases) } else { String::new() };
        let failed = rows - answered;
        let cases = if study.reader.cases == 1 { "case" } else { "cases" };
        output::print(&format!("{}: {rows}{there} {cases}, {failed} failed", arguments.studied.display()))?;
        for output in &outputs {
            output::print(&study.text(output))?;
        }
    }
    Ok(Exit::Done)
}

/// The names that are columns of numbers.
fn numeric(reader: &Reader, names: &[String]) -> Vec<String> {
    let is_number = |name: &&String| reader.numbers.iter().any(|(other, _)| other == *name);
    names.iter().filter(is_number).cloned().collect()
}

struct Study {
    reader: Reader,
    /// Inputs that are numbers.
    inputs: Vec<String>,
}

impl Study {
    /// The columns that are asked for, with their units; all answers if none is.
    fn chosen(&self, asked: &[String]) -> anyhow::Result<Vec<(String, String)>> {
        let is_answer = |name: &str| {
            let of_the_way = name == "case" || name == "iterations" || name.starts_with("residual_");
            !of_the_way && !name.starts_with("wall_") && !self.inputs.iter().any(|input| input == name)
        };
        if asked.is_empty() {
            return Ok(self.reader.numbers.iter().filter(|(name, _)| is_answer(name)).cloned().collect());
        }
        let mut chosen = Vec::new();
        for name in asked {
            match self.reader.numbers.iter().find(|(other, _)| other == name) {
                Some(found) => chosen.push(found.clone()),
                None => {
                    let names = self.reader.numbers.iter().map(|(name, _)| name.as_str());
                    let help = closest(name, names).map(|near| format!(": did you mean `{near}`?"));
                    bail!("there is no column of numbers `{name}`{}", help.unwrap_or_default());
                }
            }
        }
        Ok(chosen)
    }

    fn each(&self, columns: &[&str], take: &mut dyn FnMut(bool, &[f64])) -> anyhow::Result<()> {
        self.reader.each(columns, take).map_err(|error| anyhow!(error))
    }

    /// Hands over the inputs and the column of every case that has an answer there.
    fn answered(&self, name: &str, take: &mut dyn FnMut(&[f64])) -> anyhow::Result<()> {
        let columns: Vec<&str> = self.inputs.iter().map(String::as_str).chain([name]).collect();
        self.each(&columns, &mut |ok, row| {
            if ok && row.iter().all(|cell| !cell.is_nan()) {
                take(row);
            }
        })
    }

    /// What is said of a column; nothing of one that no case has, nor of one that is the same in all, unless it is asked for.
    fn output(&self, name: String, unit: String, asked: bool) -> anyhow::Result<Option<Output>> {
        let mut moments = Moments::new(self.inputs.len() + 1);
        self.answered(&name, &mut |row| moments.add(row))?;
        if moments.count == 0 && asked {
            bail!("no case has an answer in `{name}`");
        }
        if moments.count == 0 || !(asked || moments.varies(self.inputs.len())) {
            return Ok(None);
        }
        let quantiles = quantiles(&PARTS, moments.count, &mut |take| {
            self.answered(&name, &mut |row| take(row[self.inputs.len()]))
        })?;
        let regression = Regression::new(&moments);
        Ok(Some(Output { name, unit, moments, quantiles, regression }))
    }

    fn json(&self, output: &Output) -> Value {
        let last = self.inputs.len();
        let (low, high) = output.moments.ends[last];
        let quantiles: Map<String, Value> =
            PARTS.iter().zip(&output.quantiles).map(|(part, value)| (part.to_string(), json!(value))).collect();
        let effects = output.regression.iter().flat_map(|regression| &regression.effects);
        let effect = |effect: &crate::study::statistics::Effect| {
            json!({
                "input": self.inputs[effect.input], "coefficient": effect.coefficient,
                "confidence": effect.confidence, "correlation": effect.correlation,
            })
        };
        json!({
            "name": output.name, "unit": output.unit, "count": output.moments.count,
            "mean": output.moments.mean(last), "deviation": output.moments.deviation(last), "min": low, "max": high,
            "quantiles": quantiles,
            "explained": output.regression.as_ref().map(|regression| regression.explained),
            "effects": effects.map(effect).collect::<Vec<_>>(),
        })
    }

    fn text(&self, output: &Output) -> String {
        let last = self.inputs.len();
        let (low, high) = output.moments.ends[last];
        let unit = if output.unit.is_empty() { String::new() } else { format!(" ({})", output.unit) };
        let mut text = format!(
            "\n{}{unit}\n  mean {}, standard deviation {}, from {} to {} in {}\n",
            output.name,
            number(output.moments.mean(last)),
            number(output.moments.deviation(last)),
            number(low),
            number(high),
            count(output.moments.count as usize, "case", "cases"),
        );
        let named = PARTS.iter().zip(&output.quantiles);
        let quantiles: Vec<String> =
            named.map(|(part, value)| format!("{} % below {}", 100.0 * part, number(*value))).collect();
        text += &format!("  {}\n", quantiles.join(", "));
        let Some(regression) = &output.regression else { return text.trim_end().to_owned() };
        if let Some(first) = regression.effects.first() {
            let share = 100.0 * first.coefficient * first.coefficient;
            let explained = 100.0 * regression.explained;
            let input = &self.inputs[first.input];
            text += &match (regression.explained >= LINEAR, regression.correlated) {
                (true, None) => format!(
                    "  what matters most is `{input}`: {} % of the variance; a line in all inputs explains {} %\n",
                    small(share),
                    small(explained)
                ),
                (true, Some((one, other, by))) => format!(
                    "  inputs are correlated (`{}` and `{}` by {}): none has a share of the variance of its own; a line in all \
                     inputs explains {} %\n",
                    self.inputs[one],
                    self.inputs[other],
                    number(by),
                    small(explained)
                ),
                (false, _) => format!(
                    "  a line in all inputs explains {} %: what matters most is not a line, and coefficients do not rank it\n",
                    small(explained)
                ),
            };
        }
        let width = regression.effects.iter().map(|effect| self.inputs[effect.input].len()).max().unwrap_or(0);
        text += &format!("  {:width$}   coefficient ± {} %        correlation\n", "input", 100.0 * CONFIDENCE);
        for effect in regression.effects.iter().take(MOST_INPUTS) {
            let line = format!("{:+.4} ± {:.4}", effect.coefficient, effect.confidence);
            text += &format!("  {:width$}   {line:<25} {:+.4}\n", self.inputs[effect.input], effect.correlation);
        }
        if let Some(more) = regression.effects.len().checked_sub(MOST_INPUTS).filter(|more| *more > 0) {
            text += &format!("  … and {} (`--json` has all)\n", count(more, "more input", "more inputs"));
        }
        text.trim_end().to_owned()
    }
}
