from concurrent.futures import ThreadPoolExecutor

import pytest
from optional import needs_compiler

from repro.codegen import c_library
from repro.codegen.c_library import CompilerError, library_file, load_library

SOURCE = "double twice(double x) { return 2 * x; }"
pytestmark = needs_compiler


@pytest.fixture(autouse=True)
def _own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


def test_a_library_that_several_need_at_once_is_compiled_once(monkeypatch):
    compiled = []
    compile_source = c_library._compile
    monkeypatch.setattr(c_library, "_compile", lambda *of: (compiled.append(of), compile_source(*of)))
    with ThreadPoolExecutor(4) as threads:
        files = set(threads.map(lambda _: library_file(SOURCE, ("-O1",)), range(4)))
    assert len(compiled) == 1
    (library,) = files
    assert list(library.parent.iterdir()) == [library]


def test_what_the_compiler_refuses_is_refused_again():
    for _ in range(2):
        with pytest.raises(CompilerError, match="failed"):
            load_library("double twice(", ("-O1",))
