"""From stored runs, or from results alone, to the whole report."""

from collections.abc import Collection
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from repro.claims.assumption_effects import assumption_effects, gather_sensitivity
from repro.claims.assumptions import load_assumptions
from repro.claims.claims import load_claims
from repro.claims.verdicts import Verdict, judge_all
from repro.errors import UserError
from repro.launch.pool import start_server
from repro.report.drawing import PRELOAD, draw_all
from repro.report.html.site import write_site
from repro.report.paper import load_paper, paper_folder
from repro.report.pdf.document import write_pdf
from repro.report.placeholders import Texts
from repro.report.sections import Content, ReportSection, load_sections
from repro.report.summary import Summary, store_summary, stored_summary, summarise
from repro.report.tables.every import all_tables
from repro.report.tables.sensitivity import sensitivity_table
from repro.report.tables.table import Table
from repro.results.gather import Gathering, gather
from repro.results.results import SENSITIVITY, Results
from repro.results.stored import Stored, StoredRun, read_stored
from repro.tracking import progress
from repro.tracking.files import file_digest, write_text
from repro.tracking.paths import Paths
from repro.tracking.plain_data import Json, digest


def build(outputs: Path, scale: str, *, stale: Collection[str] = ()) -> Summary:
    """Gather a scale's runs and make outputs/report/<scale>, once from the same. NothingToJudgeError without runs."""
    stored, tried = read_stored(outputs, scale, stale), read_stored(outputs, SENSITIVITY, stale)
    if not stored.runs and not stored.benches:
        raise NothingToJudgeError(_advice(outputs, scale))
    folder, recordings = outputs / "report" / scale, outputs / "recordings"
    fingerprint = _fingerprint(stored, tried)
    unchanged = stored_summary(folder, recordings, fingerprint)
    if unchanged is not None:
        return unchanged
    progress.report(0.0, f"{len(stored.runs)} runs are read")
    paper = Gathering.load(paper_folder())
    results = replace(gather(stored, paper), sensitivity=gather_sensitivity(tried, paper))
    results.save(folder / "results")
    summary = summarise(results, render(results, folder), folder, recordings)
    summary = replace(summary, fingerprint=fingerprint)
    store_summary(summary)
    return summary


class NothingToJudgeError(UserError):
    """No experiment of a scale has been run, so no claim can be judged."""


def _advice(outputs: Path, scale: str) -> str:
    listed = sorted({path.parent.name for path in (outputs / "experiments").glob("*/[!.]*.json")} - {SENSITIVITY})
    own = len(Paths(outputs).ids("runs"))
    parts = [f"no experiment of scale {scale} has been run in {outputs}"]
    parts += [f"{own} run{'s' * (own > 1)} there belong{'s' * (own == 1)} to none" if not listed else ""] if own else []
    parts += [f"run so far: scale {', '.join(listed)}"] if listed else []
    start = "reproduce" if scale == "quick" else f"reproduce scale={scale}"
    return "; ".join(filter(None, parts)) + f". To judge the claims: repro {start}"


def redraw(source: Path, folder: Path) -> Summary:
    """Make the report from a folder of results alone, such as paper/results: nothing is run, no store is needed."""
    results = Results.load(source)
    progress.report(0.0, f"results of {source}")
    return summarise(results, render(results, folder), folder, folder / "recordings")


def render(results: Results, folder: Path) -> list[Verdict]:
    """Judge the claims, and write results/claims.csv, tables, figures, report.pdf and the pages under a folder."""
    start_server(PRELOAD)  # loads what drawing needs while the effects of assumptions are judged
    paper = paper_folder()
    claims, assumptions = load_claims(paper / "claims.yaml"), load_assumptions(paper / "assumptions.yaml")
    progress.report(0.1, f"{len(claims)} claims are judged")
    effects = assumption_effects(results.sensitivity, claims) if results.sensitivity is not None else []

    def judged() -> tuple[list[Verdict], list[Table], Texts, list[ReportSection]]:
        """Judge the claims, write the tables, and fill the texts."""
        verdicts = judge_all(claims, results)
        tables = all_tables(results, verdicts, load_paper(paper))
        if results.sensitivity is not None:
            tables.append(sensitivity_table(assumptions, effects))
            write_text(folder / "results" / "sensitivity.csv", tables[-1].csv())
        for table in tables:
            table.save(folder / "tables")
        write_text(folder / "results" / "claims.csv", tables[0].csv())
        texts = Texts(paper / "report", results, verdicts)
        return verdicts, tables, texts, load_sections(texts)

    # Figures are drawn in processes of their own, and the PDF is set outside of Python: the rest need not wait.
    with ThreadPoolExecutor(max_workers=1) as beside:
        judging = beside.submit(judged)
        progress.report(0.2, "figures are drawn")
        figures = draw_all(results, effects, folder / "figures")
        verdicts, tables, texts, sections = judging.result()
        content = Content(load_paper(paper), results, verdicts, effects, tables, figures, assumptions, sections, texts)
        progress.report(0.7, "the PDF is set, pages are written")
        typesetting = beside.submit(write_pdf, content, folder / "figures", folder / "report.pdf")
        write_site(content, folder, paper)
        typesetting.result()
    return verdicts


def _fingerprint(stored: Stored, tried: Stored) -> str:
    """Digest all that a report is made from: the runs, the claims, and the code that gathers, judges and draws."""
    paper, sources = paper_folder(), [*paper_folder().glob("*.yaml")]
    rooms = [Path(__file__).parents[1] / name for name in ("claims", "report", "results")]
    for folder in (*rooms, *(paper / name for name in ("report", "draw", "animations"))):
        sources += [path for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc"]
    made_by = [record and vars(record.provenance) for record in (run.record for run in (*stored.runs, *tried.runs))]
    return digest(
        {
            "runs": [(run.experiment, run.stale, _listed(run)) for run in (*stored.runs, *tried.runs)],
            "stages": [*made_by, *(vars(bench.provenance) for bench in stored.benches)],
            "cases": [vars(case) for case in tried.cases],
            "sources": [file_digest(path) for path in sorted(sources)],
        }
    )


def _listed(run: StoredRun) -> Json:
    """What a list adds to a run: of a finished one not its settings, which are listed only before it is made."""
    finished = run.outcome == "ok"
    return vars(replace(run.listed, settings={}, changed=()) if finished else run.listed)
