"""All suites, in the order in which they run. A suite is one file here and one row below."""

from __future__ import annotations

from assetkit.acceptance.suites.common import CommonSuite
from assetkit.acceptance.suites.fixture import FixtureSuite
from assetkit.acceptance.suites.manipulated import ManipulatedSuite
from assetkit.acceptance.suites.suite import Suite

SUITES: tuple[Suite, ...] = (CommonSuite(), ManipulatedSuite(), FixtureSuite())
