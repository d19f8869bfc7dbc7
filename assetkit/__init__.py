"""Raw assets in, accepted simulation packages out, in seven explicit stages."""

from typing import TYPE_CHECKING

from schemas.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from assetkit.batch.run_batch import ingest
    from assetkit.library.search.search import search
    from assetkit.library.validate import validate_files
    from assetkit.options import Options

__all__ = ["Options", "ingest", "search", "validate_files"]
__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "Options": "assetkit.options",
        "ingest": "assetkit.batch.run_batch",
        "search": "assetkit.library.search.search",
        "validate_files": "assetkit.library.validate",
    },
)
