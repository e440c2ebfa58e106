"""Progress of a render: a function, tqdm, or a line in the terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, Union

Progress = Union[bool, Callable[[int, int], object], None]


@contextmanager
def shown(progress: Progress) -> Iterator[Callable[[int, int], object] | None]:
    """The function that is called with the finished and all pixels."""
    if progress is None or progress is False:
        yield None
    elif callable(progress):
        yield progress
    elif progress is not True:
        raise TypeError(f"progress: expected True, False or a function, found {type(progress).__name__}")
    else:
        bar = _bar()
        try:
            yield bar.update_to
        finally:
            bar.close()


def _bar() -> Any:
    try:
        return _Tqdm(import_module("tqdm.auto").tqdm)
    except ImportError:
        return _Line()


class _Tqdm:
    def __init__(self, tqdm: Any) -> None:
        self._bar = tqdm(total=None, unit="px", unit_scale=True, desc="rendering")

    def update_to(self, done: int, total: int) -> None:
        self._bar.total = total
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        self._bar.close()


class _Line:
    def __init__(self) -> None:
        self._shown = -1

    def update_to(self, done: int, total: int) -> None:
        percent = 100 * done // max(total, 1)
        if percent != self._shown:
            self._shown = percent
            print(f"\rrendering: {percent:3d} %", end="", file=sys.stderr, flush=True)

    def close(self) -> None:
        print(file=sys.stderr)
