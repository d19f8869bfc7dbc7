"""USD files (OpenUSD, `pxr`): `read` foreign stages, `write` packages and scenes, `reread` what was written."""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from usdio.read.asset import read_stage
    from usdio.reread.body import reread_body
    from usdio.write.package import write_package
    from usdio.write.scene import write_scene

__all__ = ["read_stage", "reread_body", "write_package", "write_scene"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "read_stage": "usdio.read.asset",
        "reread_body": "usdio.reread.body",
        "write_package": "usdio.write.package",
        "write_scene": "usdio.write.scene",
    },
)
