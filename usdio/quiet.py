"""A context in which OpenUSD writes nothing to the terminal; callers report what matters as diagnostics."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from pxr import UsdUtils


@contextmanager
def quiet() -> Iterator[None]:
    """Within it, warnings and status messages of OpenUSD are collected and dropped; errors still raise."""
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        yield
    finally:
        delegate.TakeUncoalescedDiagnostics()
        del delegate
