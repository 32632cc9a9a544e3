"""What every study is: jobs, what is collected from them, reported numbers, figures, limitations.

Study -> [run: jobs on a few processes, checkpoint, progress, Ctrl-C] -> Outcome
    -> [write] -> summary.json, data, figures, report: the same bytes for the same study; timing.json: what is not

A study names its cases and its jobs, collects their results and says what the report shows; all else is here: the folder,
resuming, the report's head and ends, summary.json, the files of the figures.
"""

import csv
import io
import json
import math
import time
import tomllib
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext, suppress
from dataclasses import dataclass, fields
from functools import cached_property
from html import escape
from pathlib import Path, PurePosixPath
from typing import Any, ClassVar, Generic, Literal, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rollerrig import __version__
from rollerrig.config import Case
from rollerrig.plot import figure_bytes
from rollerrig.plot.style import fewer_colours, watermark
from rollerrig.results import ResultFolder, check_folder, netcdf_bytes, sources_of
from rollerrig.study.charts import chart_of
from rollerrig.study.checkpoint import Checkpoint, check_jobs
from rollerrig.study.jobs import Chains, Done, Progress, Round, run_rounds
from rollerrig.study.limitations import limitations
from rollerrig.study.options import RUNNER
from rollerrig.study.quantities import Numbers, Quantities, finite
from rollerrig.study.report import VIEW, Block, Mark, Page, Picture, Preformatted, Section, Table, Text, render
from rollerrig.viewer import view_text

R = TypeVar("R")
FIRST_RESULTS = "First results: the command goes on, and this page is loaded again. Where it was stopped, repeat it."
PAGE_EVERY, PAGE_SHARE = 15.0, 0.05
"""Least time between two pages of a study that goes on [s], and largest share of the time that they take."""
SUMMARY, REPORT = "summary.json", "report.html"
TIMING = "timing.json"
"""The one file whose bytes differ between identical runs: measured times."""
Content = xr.Dataset | str | bytes | Mapping[str, ArrayLike] | Sequence[Sequence[object]]
"""Content of a file: a Dataset (.nc), text, bytes, or a CSV file: name of a column -> values, or rows, header first."""


class Study(ABC, Generic[R]):
    """A study of kind `R`, which is what its jobs are collected into; subclasses are frozen dataclasses of what is asked for.

    Attributes:
        command: of the command line, for messages.
        heading: title of the report; {names} are fields of the study.
        assumes, leaves_out: limitations that stand before and after those of the cases, a sentence each.
        quantities: what it reports; by default what is registered for the command.
        quick_means: what is said of a study whose field `quick` is true, without a full stop.
        writes: names of its own files, with wildcards: looked for in the folder before the work begins.
        formats: of the figures' files; the first one is shown in the report.
        resumable: whether finished jobs are kept until the report is written.
        keeps_jobs: whether they stay, for another study of the same folder to take over.
        irrelevant: dotted keys of the plan that change no job.
        round_ends: fraction of the whole at the end of each round of jobs, for the progress.
    """

    command: ClassVar[str]
    heading: ClassVar[str] = ""
    assumes: ClassVar[tuple[str, ...]] = ()
    leaves_out: ClassVar[tuple[str, ...]] = ()
    quantities: ClassVar[Quantities]
    quick_means: ClassVar[str] = ""
    writes: ClassVar[tuple[str, ...]] = ()
    formats: ClassVar[tuple[Literal["svg", "png"], ...]] = ("png",)
    resumable: ClassVar[bool] = True
    keeps_jobs: ClassVar[bool] = False
    irrelevant: ClassVar[tuple[str, ...]] = ("description",)
    round_ends: ClassVar[tuple[float, ...]] = (1.0,)

    def __init_subclass__(cls) -> None:
        """Report what is registered for the command, where a study does not say otherwise."""
        super().__init_subclass__()
        if "command" in vars(cls) and not hasattr(cls, "quantities"):
            cls.quantities = Quantities(cls.command)

    @property
    def title(self) -> str:
        """Title of the report."""
        return self.heading.format(**vars(self))

    @property
    def mark(self) -> Mark | None:
        """What every page says of the whole study where its numbers are not to be relied on: of a `quick` one; else None."""
        return Mark("quick", self.quick_means) if getattr(self, "quick", False) else None

    def cases(self) -> Mapping[str, Case]:
        """Label -> case, those whose limitations, sources and configuration the report states; by default the study's one."""
        case = getattr(self, "case", None)
        return {case.name: case} if isinstance(case, Case) else {}

    @abstractmethod
    def rounds(self, done: Done) -> Iterator[Round | Chains]:
        """Jobs by name, round by round; `done` has the results of the rounds before."""

    def collect(self, done: Done) -> R | None:
        """What the jobs found, by default the one that is named as the command; None where Ctrl-C left too little to report."""
        return done.get(self.command)

    @abstractmethod
    def numbers(self, results: R) -> dict[str, Any]:
        """What goes into summary.json, each under a key of `quantities`."""

    @abstractmethod
    def summary(self, results: R, numbers: Numbers) -> list[str]:
        """The findings, a sentence each."""

    @abstractmethod
    def sections(self, results: R, numbers: Numbers) -> list[Section]:
        """Sections of the report, but for its ends."""

    def files(self, results: R, numbers: Numbers) -> Mapping[str, Content]:
        """File name -> content, beside report, figures and summary.json."""
        return {}

    def shown(self, results: R) -> Mapping[str, xr.Dataset]:
        """One run, or two side by side, that a page beside the report shows in motion, by what they are called."""
        return {}

    def timings(self, results: R) -> Mapping[str, Mapping[str, float]]:
        """What was measured with its unit -> of what -> time: the only numbers that differ between identical runs."""
        return {}

    def limitations(self) -> list[str]:
        """What the models leave out, a sentence each: of all cases, each once."""
        of_cases = dict.fromkeys(line for case in self.cases().values() for line in limitations(case))
        return [*self.assumes, *of_cases, *self.leaves_out]

    def sources(self, results: R) -> Mapping[str, str]:
        """What -> publication: of the models and data of all cases."""
        found: dict[str, str] = {}
        for label, case in self.cases().items():
            for what, source in sources_of(case).items():
                found[what if found.get(what, source) == source else f"{what}, {label}"] = source
        return {what: source for what, source in found.items() if source}

    def progress_text(self, done: Done, seconds: float) -> str:
        """Text of the progress in place of the name of the last job: finished jobs, seconds so far; '' as a rule."""
        return ""

    def statuses(self, results: R) -> Sequence[str]:
        """How the runs ended that the exit code speaks of."""
        return ()

    def plan(self) -> dict[str, Any]:
        """All that decides the jobs' results: finished jobs of another plan are refused. Cases as their tables."""
        return {name: value for field in fields(self) for name, value in _plain(field.name, getattr(self, field.name))}  # type: ignore[arg-type]

    def run(
        self,
        *,
        folder: str | Path | None = None,
        processes: int = 1,
        progress: Progress | None = None,
        force: bool = False,
        executor: Executor | None = None,
        first_results: "Callable[[Outcome[R]], object] | None" = None,
    ) -> "Outcome[R] | None":
        """Do the jobs and collect their results.

        Args:
            folder: where finished jobs are kept and looked for, and where the outcome shall be written; None: nowhere.
            processes: jobs at a time.
            progress: called with the fraction done and a short text.
            force: whether results of other commands and files of the user may be replaced there.
            executor: that does the jobs in place of processes of this machine.
            first_results: called with what is found so far, every PAGE_EVERY at most.

        Returns:
            What was found; None where Ctrl-C left too little to report.

        Raises:
            ConfigError: a case cannot be run, or `folder` has the jobs of another plan.
            StartError: a case finds no equilibrium to start from.
            OutputError: `folder` takes no files, or holds what must not be replaced.
        """
        begun, checkpoint = time.perf_counter(), None
        if folder is not None:
            own = (*self.writes, *(f"figures/*.{kind}" for kind in self.formats), SUMMARY, TIMING, REPORT)
            checked = check_folder(folder, self.command, own, force=force)
            if self.resumable:
                checkpoint = Checkpoint(checked, self.command, self.plan(), self.irrelevant)
            else:
                check_jobs(checked, self.command)
        taken_over, next_page = 0 if checkpoint is None else len(checkpoint.done), PAGE_EVERY

        def so_far(results: Callable[[], Done]) -> None:
            nonlocal next_page
            seconds = time.perf_counter() - begun
            if first_results is None or seconds < next_page:
                return
            with suppress(Exception):  # too little for a page yet: that ends no study, the last page says what is wrong
                if (found := self.collect(results())) is not None:
                    first_results(Outcome(self, found, True, taken_over, checkpoint, seconds, refined=True))
            now = time.perf_counter() - begun
            next_page = now + max(PAGE_EVERY, (now - seconds) / PAGE_SHARE)

        with checkpoint or nullcontext():
            done, interrupted = run_rounds(
                self.rounds,
                checkpoint,
                self.round_ends,
                processes,
                progress,
                progress_text=self.progress_text,
                executor=executor,
                so_far=so_far,
            )
        if checkpoint is not None and self.keeps_jobs:
            checkpoint.write_in_order(done)
        results = self.collect(done)
        seconds = time.perf_counter() - begun
        return None if results is None else Outcome(self, results, interrupted, taken_over, checkpoint, seconds)

    def outcome(
        self, processes: int = 1, progress: Progress | None = None, folder: str | Path | None = None
    ) -> "Outcome[R]":
        """What was found, without files; on the command line, what it does with a study. Arguments as of `run`.

        Raises:
            KeyboardInterrupt: Ctrl-C left too little to report.
        """
        runner = RUNNER.get()
        found = runner(self, processes) if runner else self.run(folder=folder, processes=processes, progress=progress)
        if found is None:
            raise KeyboardInterrupt
        return found


def _plain(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Fields of a study as JSON; the tables of its one case stand at the top, so that a message has their keys."""
    if isinstance(value, Case):
        yield from tomllib.loads(value.to_toml()).items()
    elif isinstance(value, Mapping):
        yield name, {str(key): dict(_plain("", inner)).get("", dict(_plain("", inner))) for key, inner in value.items()}
    else:
        yield name, json.loads(json.dumps(value, default=lambda other: getattr(other, "__dict__", None) or str(other)))


@dataclass(frozen=True)
class Outcome(Generic[R]):
    """What a study found: what its jobs were collected into, and how many of them were finished before (`taken_over`).

    `refined`: the study goes on, and these are its first results.
    """

    study: Study[R]
    results: R
    interrupted: bool = False
    taken_over: int = 0
    checkpoint: Checkpoint | None = None
    seconds: float = math.nan
    refined: bool = False

    def __repr__(self) -> str:
        return "\n".join((self._headline, *self.summary.splitlines()))

    def _repr_html_(self) -> str:
        lines = "".join(f"<li>{escape(line)}</li>" for line in self.summary.splitlines())
        return f"<p><b>{escape(self._headline)}</b></p><ul>{lines}</ul>"

    @property
    def _headline(self) -> str:
        """What was asked for, how its runs ended and how long it took."""
        ended = ", ".join(f"{count} {status}" for status, count in Counter(self.statuses).items())
        took = "" if math.isnan(self.seconds) else f"; took {self.seconds:.3g} s"
        return f"{self.study.title}" + (f" (runs: {ended}{took})" if ended else "")

    @cached_property
    def numbers(self) -> dict[str, Any]:
        """The reported numbers; None for what is no finite number."""
        found: dict[str, Any] = finite(self.study.numbers(self.results))
        mark = self.study.mark
        said = {} if mark is None else {mark.name: True}
        return {**found, **said, "interrupted": self.interrupted, "rollerrig_version": __version__}

    @property
    def summary(self) -> str:
        """The findings, a line each."""
        mark = self.study.mark
        return "\n".join([*([] if mark is None else [f"{mark.title}: {mark.meaning}."]), *self._findings])

    @property
    def _findings(self) -> list[str]:
        """The findings without the mark, which a page has on its top."""
        head = [FIRST_RESULTS] if self.refined else ["Interrupted: what was computed until then."]
        head = head if self.interrupted else []
        return [*head, *self.study.summary(self.results, self.numbers)]

    @property
    def timing(self) -> dict[str, Any]:
        """Measured times, which go to the terminal and to timing.json alone."""
        own: dict[str, Any] = finite(self.study.timings(self.results))
        return {"wall time [s]": finite(round(self.seconds, 3)), "jobs taken over": self.taken_over, **own}

    @property
    def statuses(self) -> Sequence[str]:
        """How the runs ended; 'interrupted' where Ctrl-C ended the study early."""
        return ["interrupted"] if self.interrupted else self.study.statuses(self.results)

    def write(self, out: str | Path, *, force: bool = False) -> list[Path]:
        """Write the study's files, figures/, summary.json, timing.json and report.html: all of them, or nothing is changed.

        What the same command wrote there before is replaced; what it does not write again is removed.

        Args:
            out: folder, made if need be.
            force: whether results of other commands and files of the user may be replaced.

        Raises:
            OutputError: a file could not be written, or `out` holds what must not be replaced.
        """
        study = self.study
        with ResultFolder(out, study.command, study.cases(), interrupted=self.interrupted, force=force) as folder:
            written = self._add_data(folder)
            view = self._add_view(folder, written)
            sections = self._sections()
            for picture in (block for section in sections for block in section.blocks if isinstance(block, Picture)):
                written += self._add_picture(folder, picture)
            summary = {**self.numbers, "keys": study.quantities.described()}
            written.append(folder.add(SUMMARY, _json(summary)))
            written.append(folder.add(TIMING, _json(self.timing), varies=True))
            findings, footer = "\n".join(self._findings), f"rollerrig {__version__}"
            page = Page(study.title, findings, sections, footer, study.mark, view, self.refined)
            written.append(folder.add(REPORT, render(page).encode()))
            folder.commit()
        if self.checkpoint is not None and not (self.interrupted or study.keeps_jobs):
            self.checkpoint.discard()
        return written

    def _add_data(self, folder: ResultFolder) -> list[Path]:
        """The study's files; the name of a marked study is part of theirs."""
        mark, written = self.study.mark, []
        for name, content in self.study.files(self.results, self.numbers).items():
            path = PurePosixPath(name)
            assert any(path.match(pattern) for pattern in self.study.writes), f"{name} is missing in `writes`"
            marked = path if mark is None else path.with_stem(f"{path.stem}_{mark.name}")
            written.append(folder.add(marked.as_posix(), _bytes(content)))
        return written

    def _add_view(self, folder: ResultFolder, written: list[Path]) -> str:
        """The page that shows runs in motion; what it shows, "" where nothing moves."""
        runs = {name: run for name, run in self.study.shown(self.results).items() if run.sizes.get("time", 2) > 1}
        if not runs:
            return ""
        marked = "" if self.study.mark is None else f"{self.study.mark.title}: "
        written.append(folder.add(VIEW, view_text(list(runs.values()), [f"{marked}{name}" for name in runs]).encode()))
        return ", ".join(runs)

    def _add_picture(self, folder: ResultFolder, picture: Picture) -> list[Path]:
        """The files of a figure; the first one is shown in the report."""
        mark = "" if self.study.mark is None else self.study.mark.title
        picture.chart = chart_of(picture.figure, picture.name, mark)
        if mark:
            watermark(picture.figure, mark)
        written = []
        for number, kind in enumerate(self.study.formats):
            content = figure_bytes(picture.figure, kind, dpi=150 if number == 0 else 200)
            picture.figure.set_layout_engine("none")  # the places found for the first stay
            if number == 0:
                seen_on_paper_only = picture.chart is not None and kind == "png"
                picture.image = fewer_colours(content) if seen_on_paper_only else content
            written.append(folder.add(f"figures/{picture.name}.{kind}", content))
        return written

    def _sections(self) -> list[Section]:
        study = self.study
        sections = study.sections(self.results, self.numbers)
        lines = study.limitations()
        if lines:
            sections.append(Section("Limitations", [Text(f"• {line}") for line in lines]))
        sources, cases = study.sources(self.results), study.cases()
        blocks: list[Block] = [Table(("of", "source"), list(sources.items()))] if sources else []
        blocks += [Preformatted(f"The whole configuration: {label}", case.to_toml()) for label, case in cases.items()]
        return [*sections, Section("Case and sources", blocks, folded=True)] if blocks else sections


def _json(numbers: Mapping[str, Any]) -> bytes:
    return (json.dumps(numbers, indent=2, ensure_ascii=False) + "\n").encode()


def _bytes(content: Content) -> bytes | memoryview:
    if isinstance(content, bytes):
        return content
    if isinstance(content, xr.Dataset):
        return netcdf_bytes(content)
    if isinstance(content, Mapping):
        columns = (np.asarray(values).tolist() for values in content.values())
        content = [list(content), *zip(*columns, strict=True)]
    return (content if isinstance(content, str) else csv_text(content)).encode()


def dataset_rows(data: xr.Dataset, columns: Mapping[str, str], *dims: str) -> list[list[object]]:
    """Rows of a CSV file, header first: name of a column -> variable or coordinate, each over all of `dims`."""
    arrays = (one.transpose(*dims) for one in xr.broadcast(*(data[name] for name in columns.values())))
    return [list(columns), *map(list, zip(*(one.to_numpy().ravel().tolist() for one in arrays), strict=True))]


def csv_text(rows: Sequence[Sequence[object]]) -> str:
    """Rows as CSV, header first; nine digits, nothing for what does not exist."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([_cell(cell) for cell in row] for row in rows)
    return text.getvalue()


def _cell(value: object) -> object:
    if not isinstance(value, float):
        return value
    return f"{value:z.9g}" if math.isfinite(value) else ""
