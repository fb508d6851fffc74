//! `librate sweep`: lines as they are made, on all cores, in parts, and continued where they stopped.

use std::collections::BTreeMap;
use std::io::Write;
use std::ops::Range as Places;
use std::path::Path;

use librate::diagnostic::Diagnostic;
use librate::report::{self, Remarks, SweepColumns, SweepCsv, SweepKept, SweepRow};
use librate::sweep::{Sweep, Worker};
use librate::{Error, modes, sensitivity, tracking};

use super::input::{self, Source};
use super::output::{self, visible};
use super::threads::{all, in_order};
use super::{Answer, Failure, args, fault, parsed, range, wrong_request};

/// A table of up to so many values has the columns that its lines need, and is written when all are there.
const HELD: usize = 1000;
/// Longer ones, parts, and what is resumed have those that so many values over the whole range need.
const SAMPLES: usize = 9;

/// More parts than a range has values are no use.
const MOST_PARTS: u32 = 1_000_000;

/// Shapes of more values are not kept for a picture.
const MOST_DRAWN: usize = 10_000;
const WHAT: &str = "computing the modes over the range";

pub(super) fn text(args: &args::Sweep) -> Result<Answer, Failure> {
    let range = range(&args.over, "write `--over NAME=a..b:count`, for example `--over k=0..8:17`")?;
    let (mut source, made) = parsed(&args.model, input::read_model(&args.model.file)?)?;
    let mut options = modes::Options::default().digits(args.digits);
    options.lowest = args.lowest;
    options.vectors = args.model.drawn || args.json && !args.no_vectors;
    let name = visible(range.name(), false).into_owned();
    let sweep = Sweep::new(made, range, options);
    let uncertain = sweep.derived().and_then(sensitivity::ignored).filter(|_| !args.json);
    let remarks = Remarks::new(&name);
    let mut run = Run { args, sweep: &sweep, name, remarks, uncertain };
    let mut text = String::new();
    if args.model.drawn {
        text = run.picture(&source)?;
    } else if args.json {
        output::write_rest(|out| run.objects(out, &source))?;
    } else {
        run.table(&mut source)?;
    }
    run.remarks.all.extend(run.uncertain);
    Ok(Answer::new(text, Some((source, run.remarks.all))))
}

/// A sweep under way.
struct Run<'a> {
    args: &'a args::Sweep,
    sweep: &'a Sweep,
    /// The parameter, as it is written.
    name: String,
    /// What is to be said of single values.
    remarks: Remarks,
    /// That uncertainties are ignored.
    uncertain: Option<Diagnostic>,
}

/// What became of a value.
struct Line {
    row: SweepRow,
    error: Option<Error>,
    uncertain: Option<Diagnostic>,
}

impl Line {
    /// With every digit certified.
    fn certified(sweep: &Sweep, place: usize) -> Self {
        let place = sweep.place(place);
        match &place.result {
            Ok((linearized, modes)) => {
                let row = SweepRow::new(place.value, modes, sweep.options().digits);
                Self { row, error: None, uncertain: sensitivity::ignored(linearized.model()) }
            }
            Err(error) => Self { row: SweepRow::empty(place.value), error: Some(error.clone()), uncertain: None },
        }
    }

    /// The same, from doubles with bounds where these decide.
    fn all(worker: &mut Worker<'_>, sweep: &Sweep, places: &[usize]) -> Vec<Self> {
        let enclosed = worker.enclosed(places);
        let line = |(place, modes): (&usize, Option<Vec<_>>)| {
            let row = modes.and_then(|modes| SweepRow::enclosed(sweep.value(*place), &modes, sweep.options().digits));
            match row {
                Some(row) => Self { row, error: None, uncertain: None },
                None => Self::certified(sweep, *place),
            }
        };
        places.iter().zip(enclosed).map(line).collect()
    }
}

/// The lines of some values, block by block.
fn lines(
    args: &args::Sweep,
    sweep: &Sweep,
    places: &[usize],
    mut each: impl FnMut(&[usize], Vec<Line>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let blocks = sweep.blocks(places);
    let mut done = blocks.iter();
    let worker = || {
        let mut worker = sweep.worker();
        let blocks = &blocks;
        move |block: usize| Line::all(&mut worker, sweep, blocks[block])
    };
    in_order(args.threads, blocks.len(), WHAT, worker, |lines| each(done.next().copied().unwrap_or_default(), lines))
}

impl Run<'_> {
    /// All modes with their shapes, followed from value to value.
    fn picture(&mut self, source: &Source) -> Result<String, Failure> {
        let (args, sweep) = (self.args, self.sweep);
        let count = sweep.range().len();
        if count > MOST_DRAWN {
            let help = format!("a picture has room for {MOST_DRAWN} values");
            return Err(wrong_request(format!("{count} values are too many for a picture"), &help));
        }
        let places: Vec<usize> = (0..count).collect();
        let blocks = sweep.blocks(&places);
        let worker = || {
            let (mut worker, blocks) = (sweep.worker(), &blocks);
            move |block: usize| worker.tracked(blocks[block])
        };
        let places = all(args.threads, blocks.len(), WHAT, worker, || args.model.guard.go_on(source))?;
        let mut places = places.concat();
        let failed: Vec<_> = places.iter().filter_map(|own| Some((own.value, own.modes.as_ref().err()?))).collect();
        for (value, error) in &failed {
            self.remarks.add(*value, error.diagnostics());
        }
        if failed.len() == count {
            return Err(Failure::Model(source.clone(), std::mem::take(&mut self.remarks.all)));
        }
        let branches = tracking::branches(sweep, &mut places);
        Ok(report::sweep_svg(sweep, &places, &branches, &args.view))
    }

    /// The modes at each value as JSON.
    fn objects(&mut self, out: &mut dyn Write, source: &Source) -> Result<(), Failure> {
        let (args, sweep, name) = (self.args, self.sweep, self.name.clone());
        let worker = || {
            |at: usize| {
                let place = sweep.place_with_uncertainties(at);
                (report::sweep_json(&name, &place, sweep.options()), place.result.err())
            }
        };
        // Where there are modes nowhere, nothing is written.
        let mut waiting: Vec<String> = Vec::new();
        let mut first: Option<Error> = None;
        let (mut next, mut is_begun) = (0, false);
        in_order(args.threads, sweep.range().len(), WHAT, worker, |(object, error)| {
            args.model.guard.go_on(source)?;
            let place = next;
            next += 1;
            waiting.push(object);
            match error {
                Some(error) => {
                    self.remarks.add(self.sweep.value(place), error.diagnostics());
                    first.get_or_insert(error);
                    if !is_begun {
                        return Ok(());
                    }
                }
                None if !is_begun => out.write_all(b"[").map_err(output::failed)?,
                None => {}
            }
            for object in waiting.drain(..) {
                let comma = if std::mem::replace(&mut is_begun, true) { ",\n" } else { "" };
                write!(out, "{comma}{}", visible(&object, false)).map_err(output::failed)?;
            }
            out.flush().map_err(output::failed)
        })?;
        match first {
            Some(error) if !is_begun => Err(Failure::Model(source.clone(), error.diagnostics())),
            _ => out.write_all(b"]\n").map_err(output::failed),
        }
    }

    /// The table, or what of it is asked for and not there yet.
    fn table(&mut self, source: &mut Source) -> Result<(), Failure> {
        let (args, sweep) = (self.args, self.sweep);
        let part = args.part.unwrap_or_default();
        let own = part.of(sweep.range().len());
        let file = args.resume.as_deref();
        let kept = file.filter(|file| file.exists()).map(|file| self.kept(file, &own)).transpose()?;
        let kept = kept.unwrap_or_default();
        let open = own.start + kept.rows..own.end;
        let mut known: BTreeMap<usize, Line> = BTreeMap::new();
        let columns = match &kept.columns {
            Some(columns) => columns.clone(),
            None => {
                known = self.samples(source)?;
                SweepColumns::of(&self.name, known.values().map(|line| &line.row), args.growth)
            }
        };
        if let (Some(file), Some(last)) = (file, &kept.last) {
            let place = open.start - 1;
            let row = known.remove(&place).map_or_else(|| Line::certified(sweep, place).row, |line| line.row);
            let row = if columns.hold(&row) { row } else { SweepRow::empty(sweep.value(place)) };
            if columns.cells(&row) != *last {
                let (file, value) = (file.display(), sweep.value(place));
                let what =
                    format!("what it has for {} = {value} is not what this model and these options give", self.name);
                return Err(fault(format!("can't go on with `{file}`: {what}")));
            }
        }
        known.retain(|place, _| open.contains(place));
        let todo: Vec<usize> = open.filter(|place| !known.contains_key(place)).collect();
        let header = part.is_first() && kept.bytes == 0;
        match file {
            None => output::write_rest(|out| self.write(&columns, header, known, &todo, (out, source))),
            Some(file) => {
                let mut file = output::append(file, kept.bytes, source)?;
                self.write(&columns, header, known, &todo, (&mut file, source))
            }
        }
    }

    /// The lines at values that tell the columns.
    fn samples(&mut self, source: &Source) -> Result<BTreeMap<usize, Line>, Failure> {
        let (args, sweep) = (self.args, self.sweep);
        let count = sweep.range().len();
        let places: Vec<usize> = if args.part.is_none() && args.resume.is_none() && count <= HELD {
            (0..count).collect()
        } else {
            let mut places: Vec<usize> = (0..SAMPLES).map(|at| at * (count - 1) / (SAMPLES - 1)).collect();
            places.dedup();
            places
        };
        let mut known = BTreeMap::new();
        lines(args, sweep, &places, |places, lines| {
            args.model.guard.go_on(source)?;
            known.extend(places.iter().copied().zip(lines));
            Ok(())
        })?;
        let errors: Vec<&Error> = known.values().filter_map(|line| line.error.as_ref()).collect();
        match errors.first() {
            Some(error) if errors.len() == places.len() => Err(Failure::Model(source.clone(), error.diagnostics())),
            Some(_) | None => Ok(known),
        }
    }

    /// What a file has already.
    fn kept(&self, file: &Path, own: &Places<usize>) -> Result<SweepKept, Failure> {
        let bytes = input::read_bytes(file)?;
        let value = |row: usize| (row < own.len()).then(|| self.sweep.value(own.start + row));
        let header = self.args.part.unwrap_or_default().is_first();
        SweepKept::read(&bytes, &self.name, header, value)
            .map_err(|reason| fault(format!("can't go on with `{}`: {reason}", file.display())))
    }

    /// Writes lines in order, those that are known and those to be computed.
    fn write(
        &mut self,
        columns: &SweepColumns,
        header: bool,
        known: BTreeMap<usize, Line>,
        todo: &[usize],
        (out, source): (&mut dyn Write, &Source),
    ) -> Result<(), Failure> {
        let mut table = SweepCsv::new(out, columns.clone());
        if header {
            table.header().map_err(output::failed)?;
        }
        let mut known = known.into_iter().peekable();
        let (args, sweep) = (self.args, self.sweep);
        lines(args, sweep, todo, |places, lines| {
            args.model.guard.go_on(source)?;
            for (place, line) in places.iter().zip(lines) {
                while let Some((place, line)) = known.next_if(|(other, _)| other < place) {
                    self.put(&mut table, columns, place, line)?;
                }
                self.put(&mut table, columns, *place, line)?;
            }
            table.flush().map_err(output::failed)
        })?;
        for (place, line) in known {
            self.put(&mut table, columns, place, line)?;
        }
        table.flush().map_err(output::failed)
    }

    /// Writes a line; empty cells where there are no modes, or the table has no columns for them.
    fn put(
        &mut self,
        table: &mut SweepCsv<&mut dyn Write>,
        columns: &SweepColumns,
        place: usize,
        line: Line,
    ) -> Result<(), Failure> {
        let mut row = line.row;
        if let Some(error) = line.error {
            self.remarks.add(self.sweep.value(place), error.diagnostics());
        } else if !columns.hold(&row) {
            let message = "there are modes or growth that the table has no columns for".to_owned();
            let help =
                format!("columns are those that {SAMPLES} values over the range need; `--growth` adds those of growth");
            self.remarks.add(self.sweep.value(place), vec![Diagnostic::global(message).with_help(help)]);
            row = SweepRow::empty(self.sweep.value(place));
        }
        self.uncertain = self.uncertain.take().or(line.uncertain);
        table.row(&row).map_err(output::failed)
    }
}

/// One of several parts that follow each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// From 1.
    number: usize,
    parts: usize,
}

impl Default for Part {
    /// All of it.
    fn default() -> Self {
        Self { number: 1, parts: 1 }
    }
}

impl Part {
    pub(crate) fn is_first(self) -> bool {
        self.number == 1
    }

    /// Of so many.
    pub(crate) fn of(self, count: usize) -> Places<usize> {
        // Neither is above a million.
        count * (self.number - 1) / self.parts..count * self.number / self.parts
    }
}

/// Reads `--part`.
pub(super) fn part(text: &str) -> Result<Part, String> {
    let wrong = || "a part is its number and how many there are: `1/10` to `10/10`".to_owned();
    let (number, parts) = text.split_once('/').ok_or_else(wrong)?;
    let [number, parts] = [number, parts].map(|text| text.trim().parse::<u32>().ok());
    match (number, parts) {
        (Some(number), Some(parts)) if (1..=parts).contains(&number) && parts <= MOST_PARTS => {
            Ok(Part { number: number as usize, parts: parts as usize })
        }
        _ => Err(wrong()),
    }
}
