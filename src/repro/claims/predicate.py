"""The vocabulary in which claims.yaml puts a statement of the paper to stored runs, found by `name`."""

from typing import Annotated

from pydantic import Field

from repro.claims.loop_predicates import LoopsSucceed, LoopsSucceedMoreOften, TimeTakesLonger
from repro.claims.ratio_predicates import BenchRatioAbove, PairedRatioBelow, RatioAtLeast
from repro.claims.setting_predicates import (
    AllMembersAwayFrom,
    EverySettingBelow,
    FailsMoreOften,
    MedianBound,
    ShareOfFailures,
)

Predicate = Annotated[
    MedianBound
    | AllMembersAwayFrom
    | EverySettingBelow
    | ShareOfFailures
    | FailsMoreOften
    | PairedRatioBelow
    | RatioAtLeast
    | BenchRatioAbove
    | LoopsSucceed
    | LoopsSucceedMoreOften
    | TimeTakesLonger,
    Field(discriminator="name"),
]
