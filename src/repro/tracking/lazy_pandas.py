"""pandas, loaded when one of its functions is first used: commands that read no table start without it.

    from repro.tracking.lazy_pandas import pd

Its names stand in quotes in annotations.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd
else:

    class _Pandas:
        """The module, once an attribute of it is read."""

        def __getattr__(self, name: str) -> Any:
            import pandas as loaded

            return getattr(loaded, name)

    pd = _Pandas()

__all__ = ["pd"]
