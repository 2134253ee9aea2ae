"""The vocabulary in which claims.yaml puts a statement of the paper to stored runs, found by `name`."""

from typing import Annotated

from pydantic import Field

from repro.claims.loop_predicates import LoopsSucceed, LoopsSucceedMoreOften, StepTakesLonger
from repro.claims.ratio_predicates import BenchRatioAbove, PairedRatioBelow, RatioAtLeast
from repro.claims.setting_predicates import AllMembersAwayFrom, EverySettingBelow, MedianBound, ShareOfFailuresAtLeast

Predicate = Annotated[
    MedianBound
    | AllMembersAwayFrom
    | EverySettingBelow
    | ShareOfFailuresAtLeast
    | PairedRatioBelow
    | RatioAtLeast
    | BenchRatioAbove
    | LoopsSucceed
    | LoopsSucceedMoreOften
    | StepTakesLonger,
    Field(discriminator="name"),
]
