"""All suites, in the order in which they run. A suite is one file here and one row below."""

from __future__ import annotations

from assetkit.acceptance.suites.common import CommonSuite
from assetkit.acceptance.suites.fixture import FixtureSuite
from assetkit.acceptance.suites.manipulated import ManipulatedSuite
from assetkit.acceptance.suites.receptacle import ReceptacleSuite
from assetkit.acceptance.suites.suite import Suite
from assetkit.acceptance.suites.support import SupportSuite
from assetkit.acceptance.suites.tool import ToolSuite

SUITES: tuple[Suite, ...] = (
    CommonSuite(),
    ManipulatedSuite(),
    ReceptacleSuite(),
    SupportSuite(),
    ToolSuite(),
    FixtureSuite(),
)
