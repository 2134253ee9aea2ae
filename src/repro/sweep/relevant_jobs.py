"""Which jobs of an experiment answer a claim, predicted from their settings before any of them runs."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from repro.claims.claims import Claim
from repro.config.schema import Config
from repro.data.data_options import RandomForce
from repro.pipeline.card import card_of
from repro.results.schema import as_text
from repro.results.selectors import agrees
from repro.sweep.planned_job import PlannedJob


def answering(claim: Claim, jobs: Sequence[PlannedJob]) -> list[PlannedJob]:
    """Those jobs of the claim's experiment that its selectors mean, in their order."""
    predicted = [(job, _predicted(job.pipeline.config)) for job in jobs]
    return [job for job, text in predicted if any(agrees(text, where) for where in claim.selectors)]


def _predicted(config: Config) -> Callable[[str], str]:
    """The texts of the card that a run will have, or of its closed loops where it has any; `config` is at its scale."""
    n_train = None
    if isinstance(config.data, RandomForce):
        share = int(config.data.samples * config.data.train_fraction)
        n_train = min(share, config.data.train_samples or share)
    card = card_of(config)
    card = replace(card, measured={"n_train": n_train, "epochs": card.settings.get("optimiser.epochs", 0)})
    loops = {} if config.control.kind == "none" else card.loop_columns()
    known = {**card.settings, **card.run_columns(), **loops}
    return lambda name: as_text(known.get(name))
