"""The exceptions that Python raises for a damaged zip archive, whichever part of it is damaged."""

from __future__ import annotations

import zipfile
import zlib

# The directory (BadZipFile, ValueError), the packed bytes (zlib.error, EOFError), a flipped method or
# flag of encryption (RuntimeError and its subclasses), a size that no memory holds.
ZIP_DAMAGE = (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, RuntimeError, MemoryError)
