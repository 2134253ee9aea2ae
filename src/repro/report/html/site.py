"""The whole folder of pages: front page, claims, run cards, and what they share."""

import math
import shutil
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from repro.claims.verdict_kind import VerdictKind
from repro.claims.verdicts import Verdict, headline
from repro.report.animation import Animation
from repro.report.html.environment import ASSETS, rendered
from repro.report.html.run_page import LOOP_COLUMNS, SPLITS, run_pages
from repro.report.paper import load_animations
from repro.report.sections import Content
from repro.report.tables.verdicts import READING, cure, mark, measured
from repro.results.results import SENSITIVITY
from repro.tracking.files import replacing, write_bytes, write_text

CLAIMS, RUNS = "claims", "runs"


def write_site(content: Content, folder: Path, paper: Path) -> None:
    """Write index.html, claims/, runs/ and assets into a report's folder; animations come from the folder `paper`."""
    shutil.copytree(ASSETS, folder / "assets", dirs_exist_ok=True, copy_function=shutil.copyfile)
    cards = run_pages(content)
    claims = {verdict.claim.name: verdict for verdict in content.verdicts}
    shared = {
        "paper": content.paper,
        "scale": content.results.scale or "unknown",
        "claims": claims,
        "known_runs": {card["id"] for card in cards},
        "mark": mark,
        "measured": measured,
    }
    front = _front(content) | {
        "animations": _copied(load_animations(paper), paper / "animations", folder / "animations"),
        "finished": content.results.runs.loc[content.results.runs["outcome"] == "ok", "run"].nunique(),
        "pdf": content.texts.folder.is_dir(),
        "cards": cards,
    }
    pages = {Path("index.html"): rendered("index.html", base="", **shared, **front)}
    for before, name, after in zip(["", *claims], claims, [*claims, ""][1:], strict=False):
        own = {"verdict": claims[name], "rule": _rule(claims[name]), "before": before, "after": after}
        pages[Path(CLAIMS) / f"{name}.html"] = rendered("claim.html", base="../", **own, **shared)
    for card in cards:
        own = {"card": card, "splits": SPLITS, "loop_columns": LOOP_COLUMNS}
        pages[Path(RUNS) / f"{card['id']}.html"] = rendered("run.html", base="../", **own, **shared)
    for page, text in pages.items():
        write_text(folder / page, text, forced=False)
    for path in (path for kind in (CLAIMS, RUNS) for path in (folder / kind).glob("*.html")):
        if path.relative_to(folder) not in pages:  # of an earlier report
            path.unlink()


def _front(content: Content) -> dict[str, Any]:
    counted = Counter(verdict.verdict for verdict in content.verdicts)
    figures = {figure.name: figure for figure in content.figures}
    tables = {table.name: table for table in content.tables[1:]}
    # A figure may have the name of a table.
    drawn = {SENSITIVITY, *content.paper.front_figures, *(name for one in content.sections for name in one.figures)}
    trials = tables[SENSITIVITY].rows if SENSITIVITY in tables else ()
    tabled = {SENSITIVITY, *(name for one in content.sections for name in one.tables)}
    return {
        "counts": {name: counted[name] for name in VerdictKind if counted[name]},
        "headline": headline(content.verdicts),
        "cure": cure,
        "reading": READING,
        "figures": figures,
        "tables": tables,
        "sections": content.sections,
        "other_figures": [figure for name, figure in figures.items() if name not in drawn],
        "other_tables": [table for name, table in tables.items() if name not in tabled],
        "assumptions": content.assumptions,
        "trials": [row.data for row in trials if "alternative" in row.data],
    }


def _copied(animations: Sequence[Animation], source: Path, folder: Path) -> list[dict[str, Any]]:
    """Copy every GIF that was made, its first frame as PNG beside it; their file names, titles and sizes in pixels."""
    from PIL import Image

    shown = []
    for animation in animations:
        path = source / f"{animation.name}.gif"
        if not path.is_file():
            continue
        write_bytes(folder / path.name, path.read_bytes())
        with Image.open(path) as picture:
            width, height = picture.size
            with replacing(folder / f"{path.stem}.png", keep_suffix=True) as temporary:
                picture.save(temporary, optimize=True)
        files = {"moving": path.name, "still": f"{path.stem}.png"}
        shown.append({**files, "title": animation.title, "width": width, "height": height})
    return shown


def _rule(verdict: Verdict) -> Mapping[str, str]:
    """Return how a claim is judged in titled lines: the runs meant, the criterion, what the verdict depends on."""
    claim, (low, high) = verdict.claim, verdict.prediction
    criterion = claim.predicate.model_dump(exclude_unset=True) if claim.predicate else {}
    predicted = claim.printed is not None and not math.isnan(low)
    lines = {
        "experiment": claim.experiment,
        "runs meant": _yaml(claim.selector),
        "criterion": _yaml({key: value for key, value in criterion.items() if value != {}}),
        "consistent with": f"{low:.3g} to {high:.3g}, where one more member falls with 95 %" if predicted else "",
        "cannot fail": claim.by_construction,
        "needs of ours": claim.with_changes,
        "smallest change that makes it hold": cure(verdict),
        "changed after results": "\n".join(f"{one.commit}: {one.change}. {one.reason}" for one in claim.history),
        "declared": f"{claim.declared}: {claim.reason}" if claim.declared else "",
    }
    return {title: text for title, text in lines.items() if text}


def _yaml(mapping: Mapping[str, Any]) -> str:
    import yaml

    dumper = getattr(yaml, "CSafeDumper", yaml.SafeDumper)  # in C where PyYAML has it
    options: dict[str, Any] = {"sort_keys": False, "allow_unicode": True, "width": 90}
    return str(yaml.dump(dict(mapping), Dumper=dumper, **options)).strip() if mapping else ""
