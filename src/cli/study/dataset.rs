//! `study` of a dataset: what the rows of `sweep` say.

mod means;
mod plot;

use super::super::text::{count, number, small};
use super::super::{Exit, inputs::Inputs, output};
use super::Arguments;
use crate::study::additive::Additive;
use crate::study::reader::Reader;
use crate::study::statistics::{CONFIDENCE, Effect, Moments, Regression, quantiles};
use crate::study::variance::{self, Classes, FEWEST_ROWS, FirstOrder};
use crate::suggest::closest;
use anyhow::{anyhow, bail};
use means::Means;
use serde_json::{Map, Value, json};
use std::cell::OnceCell;

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
    /// What each input explains alone.
    alone: Vec<Option<FirstOrder>>,
    /// Means of the column by the words of inputs.
    means: Means,
}

impl Output {
    /// Whether lines explain more than they leave.
    fn is_linear(&self) -> bool {
        self.regression.as_ref().is_some_and(|regression| regression.explained >= LINEAR)
    }

    /// Whether what each input explains alone ranks them: where lines explain little, if it is known.
    fn ranks_alone(&self) -> bool {
        let effects = self.regression.iter().flat_map(|regression| &regression.effects);
        !self.is_linear() && effects.into_iter().all(|effect| self.alone[effect.input].is_some())
    }

    /// The inputs that vary, with what each explains alone: what matters most first, by the coefficients, or by that where lines
    /// explain little.
    fn ranked(&self) -> Vec<(Effect, Option<FirstOrder>)> {
        let effects = self.regression.iter().flat_map(|regression| &regression.effects);
        let mut ranked: Vec<_> = effects.map(|effect| (*effect, self.alone[effect.input])).collect();
        if self.ranks_alone() {
            let index = |alone: &Option<FirstOrder>| alone.map_or(0.0, |alone| alone.index);
            ranked.sort_by(|a, b| index(&b.1).total_cmp(&index(&a.1)));
        }
        // Words whose means are one number do nothing by themselves: no column of them varies.
        let still = self.means.inputs().filter(|input| !ranked.iter().any(|(effect, _)| effect.input == *input));
        let still: Vec<usize> = if self.regression.is_some() { still.collect() } else { Vec::new() };
        ranked.extend(still.into_iter().map(|input| (Effect { input, ..Effect::default() }, None)));
        ranked
    }
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let reader = Reader::open(&arguments.studied).map_err(|error| anyhow!(error))?;
    if reader.silent > 0 && !arguments.quiet {
        output::warning(&silent(reader.silent as u64));
    }
    let numbers = numeric(&reader, &reader.inputs);
    let inputs = numbers.iter().chain(reader.words.iter().map(|words| &words.name)).cloned().collect();
    let study = Study { inputs, numbers: numbers.len(), reader, ends: OnceCell::new() };
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

/// What is said of parts that do not say which study they belong to, or have no sum.
pub(in super::super) fn silent(parts: u64) -> String {
    format!(
        "{} not say which study they belong to or what the sum of their bytes is, as those of earlier versions: taken as undamaged parts of this one",
        count(parts as usize, "part does", "parts do")
    )
}

/// The names that are columns of numbers.
fn numeric(reader: &Reader, names: &[String]) -> Vec<String> {
    let is_number = |name: &&String| reader.numbers.iter().any(|(other, _)| other == *name);
    names.iter().filter(is_number).cloned().collect()
}

struct Study {
    reader: Reader,
    /// Inputs that are numbers, then those of words.
    inputs: Vec<String>,
    /// How many are numbers.
    numbers: usize,
    /// Ends of the classes of each number, once they are asked for.
    ends: OnceCell<Vec<Vec<f64>>>,
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

    /// Hands over the inputs, of words their places, and the column of every case that has an answer there.
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
        let means = Means::new(self, &name)?;
        let mut moments = Moments::new(self.inputs.len() + 1);
        means.answered(self, &name, &mut |row| moments.add(row))?;
        if moments.count == 0 && asked {
            bail!("no case has an answer in `{name}`");
        }
        if moments.count == 0 || !(asked || moments.varies(self.inputs.len())) {
            return Ok(None);
        }
        let quantiles = quantiles(&PARTS, moments.count, &mut |take| {
            self.answered(&name, &mut |row| take(row[self.inputs.len()]))
        })?;
        let regression = Regression::beside(&moments, means.fitted());
        let alone = match regression.is_some() && moments.count >= FEWEST_ROWS {
            true => {
                self.alone(&name, &moments, &means, regression.as_ref().is_some_and(|one| one.correlated.is_none()))?
            }
            false => vec![None; self.inputs.len()],
        };
        Ok(Some(Output { name, unit, moments, quantiles, regression, alone, means }))
    }

    /// What each input explains alone. Of `independent` inputs, what the others do is taken off before.
    fn alone(
        &self,
        name: &str,
        moments: &Moments,
        means: &Means,
        independent: bool,
    ) -> anyhow::Result<Vec<Option<FirstOrder>>> {
        if self.ends.get().is_none() {
            let ends =
                self.inputs[..self.numbers].iter().map(|input| self.ends_of(input)).collect::<anyhow::Result<_>>()?;
            self.ends.get_or_init(|| ends);
        }
        let mut ends = self.ends.get().cloned().unwrap_or_default();
        ends.extend(means.ends());
        let (ranges, mean) = (&moments.ends[..self.inputs.len()], moments.mean(self.inputs.len()));
        let mut additive = Additive::new(&ends, ranges, moments.count, mean).filter(|_| independent);
        if let Some(additive) = &mut additive {
            means.answered(self, name, &mut |row| additive.add(row))?;
            additive.fit();
        }
        let mut classes = Classes::new(ends, mean, self.reader.spread, additive);
        means.answered(self, name, &mut |row| classes.add(row))?;
        Ok((0..self.inputs.len()).map(|input| classes.first_order(input, CONFIDENCE)).collect())
    }

    /// Ends of classes that hold equally many of all cases with an answer.
    fn ends_of(&self, input: &str) -> anyhow::Result<Vec<f64>> {
        let mut rows = 0;
        self.answered(input, &mut |_| rows += 1)?;
        let at = self.inputs.len();
        quantiles(&variance::parts(rows), rows, &mut |take| self.answered(input, &mut |row| take(row[at])))
    }

    fn json(&self, output: &Output) -> Value {
        let last = self.inputs.len();
        let (low, high) = output.moments.ends[last];
        let quantiles: Map<String, Value> =
            PARTS.iter().zip(&output.quantiles).map(|(part, value)| (part.to_string(), json!(value))).collect();
        let effect = |(effect, alone): (Effect, Option<FirstOrder>)| {
            let mut told = json!({
                "input": self.inputs[effect.input], "coefficient": effect.coefficient,
                "confidence": effect.confidence, "correlation": effect.correlation,
                "first_order": alone.map(|alone| alone.index),
                "first_order_confidence": alone.map(|alone| alone.confidence),
            });
            if let Some(means) = output.means.json(self, effect.input) {
                told["means"] = means;
            }
            told
        };
        json!({
            "name": output.name, "unit": output.unit, "count": output.moments.count,
            "mean": output.moments.mean(last), "deviation": output.moments.deviation(last), "min": low, "max": high,
            "quantiles": quantiles,
            "explained": output.regression.as_ref().map(|regression| regression.explained),
            "effects": output.ranked().into_iter().map(effect).collect::<Vec<_>>(),
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
        text += &self.what_matters(output, regression);
        let ranked = output.ranked();
        let width = ranked.iter().map(|(effect, _)| self.inputs[effect.input].len()).max().unwrap_or(0);
        let by = 100.0 * CONFIDENCE;
        text += &format!("  {:width$}   coefficient ± {by} %        correlation   alone ± {by} %\n", "input");
        for (effect, alone) in ranked.iter().take(MOST_INPUTS) {
            let line = format!("{:+.4} ± {:.4}", effect.coefficient, effect.confidence);
            let alone = alone.map(|alone| format!("{:.4} ± {:.4}", alone.index, alone.confidence));
            let line = format!(
                "  {:width$}   {line:<25} {:+.4}       {}",
                self.inputs[effect.input],
                effect.correlation,
                alone.unwrap_or_default()
            );
            text += line.trim_end();
            text.push('\n');
        }
        let shown = ranked.iter().take(MOST_INPUTS);
        text.extend(shown.filter_map(|(effect, _)| output.means.text(self, effect.input)));
        if let Some(more) = ranked.len().checked_sub(MOST_INPUTS).filter(|more| *more > 0) {
            text += &format!("  … and {} (`--json` has all)\n", count(more, "more input", "more inputs"));
        }
        text.trim_end().to_owned()
    }

    /// A sentence on what matters most.
    fn what_matters(&self, output: &Output, regression: &Regression) -> String {
        let ranked = output.ranked();
        let Some((first, alone)) = ranked.first() else { return String::new() };
        let input = &self.inputs[first.input];
        let verb = if output.means.inputs().next().is_none() {
            "a line in all inputs explains"
        } else {
            "lines in all numbers and means for all words explain"
        };
        let lines = format!("{verb} {} %", small(100.0 * regression.explained));
        if let Some((one, other, by)) = regression.correlated {
            return format!(
                "  inputs are correlated (`{}` and `{}` by {}): none has a share of the variance of its own; {lines}\n",
                self.inputs[one],
                self.inputs[other],
                number(by),
            );
        }
        if output.is_linear() {
            let share = small(100.0 * first.coefficient * first.coefficient);
            return format!("  what matters most is `{input}`: {share} % of the variance; {lines}\n");
        }
        match alone {
            Some(alone) if alone.index > alone.confidence => format!(
                "  what matters most is `{input}`: {} % of the variance by itself; all inputs by themselves explain {} %, the \
                 rest is in how they act together; {lines}\n",
                small(100.0 * alone.index),
                small(100.0 * ranked.iter().filter_map(|(_, alone)| *alone).map(|alone| alone.index).sum::<f64>()),
            ),
            Some(_) => format!(
                "  no input explains anything by itself: what matters is how they act together, or nothing that varies here; \
                 {lines}\n"
            ),
            None => format!(
                "  {lines}: what matters most is not a line, coefficients do not rank it, and \
                 {FEWEST_ROWS} cases at least are needed to say more\n"
            ),
        }
    }
}
