"""A check: a function whose docstring is the promise, and that raises `Broken` where it is not kept."""

import inspect
import random
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

T = TypeVar("T")


class Broken(Exception):  # noqa: N818 (it names what became of the promise)
    """A promise that is not kept; the message says in plain words how."""


@dataclass(frozen=True)
class Outcome:
    """What a check found.

    Attributes
    ----------
    check : str
        Name of the check.
    promise : str
        What it checks, as one sentence.
    fault : str
        What is wrong; empty where the promise is kept.
    """

    check: str
    promise: str
    fault: str = ""


def examine(component: T, checks: Iterable[Callable[[T], None]]) -> Iterator[Outcome]:
    """Run checks on a component, each whether or not those before it passed.

    Parameters
    ----------
    component : Attack or Scheme
    checks : iterable of callable
        `ATTACK_CHECKS` or `SCHEME_CHECKS`.
    """
    for check in checks:
        promise = (inspect.getdoc(check) or "").partition("\n")[0]
        yield Outcome(check.__name__.replace("_", "-"), promise, _fault(component, check))


def _fault(component: T, check: Callable[[T], None]) -> str:
    try:
        check(component)
    except Broken as broken:
        return str(broken)
    except MemoryError:
        raise  # that is about this machine
    except Exception as error:  # whatever foreign code may do
        return f"it raises {type(error).__name__}: {' '.join(str(error).split())}"
    return ""


@contextmanager
def global_state(seed: int) -> Iterator[None]:
    """Set the global random states of Python and numpy for a while, to see who draws from them."""
    ours, numpys = random.getstate(), np.random.get_state()  # noqa: NPY002 (it is the global one)
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002
    try:
        yield
    finally:
        random.setstate(ours)
        np.random.set_state(numpys)  # noqa: NPY002
