"""Every public function says its parameters, what it returns and what it raises; ruff checks that they are complete."""

import inspect
import re

import pytest

import repro
from repro.library.fit_uncertainty import FitUncertainty
from repro.library.fitted_model import FittedModel

FUNCTIONS = {name: getattr(repro, name) for name in repro.__all__ if inspect.isfunction(getattr(repro, name))}
METHODS = {
    f"{owner.__name__}.{name}": method
    for owner in (FittedModel, FitUncertainty)
    for name, method in inspect.getmembers(owner, inspect.isfunction)
    if not name.startswith("_")
}
WITHOUT_EXAMPLE = ("load_run", "load_runs", "show")  # of stored results


@pytest.mark.parametrize("name", [*FUNCTIONS, *METHODS])
def test_a_docstring_has_its_sections(name):
    function = (FUNCTIONS | METHODS)[name]
    text = inspect.cleandoc(function.__doc__)
    sections = re.findall(r"^(\w+)\n-+$", text, re.MULTILINE)
    signature = inspect.signature(function)
    own = [each for each in signature.parameters if each != "self"]
    assert ("Parameters" in sections) == bool(own)
    assert ("Returns" in sections) == (signature.return_annotation not in (None, "None"))
    for parameter in own:
        assert re.search(rf"^(?:\w+, )*{parameter}(?:, \w+)*$", text, re.MULTILINE), parameter
    if name in FUNCTIONS:
        assert "Raises" in sections
        assert ("Examples" in sections) == (name not in WITHOUT_EXAMPLE)
