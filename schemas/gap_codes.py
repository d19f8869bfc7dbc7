"""Diagnostic codes of measurements and of simgap; part of the table in `schemas.codes`."""

from __future__ import annotations

from schemas.code_info import CodeInfo

GAP_CODES: dict[str, CodeInfo] = {}
