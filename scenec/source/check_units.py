"""Finds numbers that are plausible only in another unit: degrees where radians are read, centimetres where metres
are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import pi, radians

from scenec.source.listing import WrittenAsset, written_assets, written_yaws
from schemas.diagnostics import Diagnostic, Severity, finding
from schemas.scene.program import BoxAsset, CylinderAsset, Range, SceneProgram, SphereAsset
from source.tree import Path, Spans, written

# A full turn with its digits rounded up (6.2832, 6.29, 6.3) is still one.
MOST_ANGLE_RAD = 6.3
# Within a full turn only whole numbers are reported: beyond half a turn yaws in whole radians (4, 5, 6) are unlikely,
# and a `facing` tolerance of more than a quarter turn (2, 3) has no meaning.
WHOLE_HEADING_RAD, WHOLE_TOLERANCE_RAD = pi, pi / 2
# Objects are shorter than this (m); few objects given in centimetres are.
LARGEST_OBJECT_M = 3.0
# Fixed parts may be any number of metres wide, as floors and walls are; those are thin. One that is also this thick in
# every direction is a table or a shelf in centimetres (supports are at least 10 cm in each).
WIDE_FIXED_M, THICK_FIXED_M = 10.0, 1.0
FIXED_ROLES = ("support", "fixture")
# Numbers beyond these are too large even for centimetres (an object of 1 m, a table of 3 m): then they are millimetres.
MOST_OBJECT_CM, MOST_FIXED_CM = 100.0, 300.0


def check_units(program: SceneProgram, spans: Spans) -> Iterator[Diagnostic]:
    """A finding for each implausible angle (`scene/degrees-suspected`) and inline size (`scene/size-implausible`)."""
    for path, heading in written_yaws(program):
        if path[0] != "keep_outs" and heading.yaw is not None:  # A keep-out has no heading in any unit.
            yield from _angle((*path, "yaw"), heading.yaw, WHOLE_HEADING_RAD, spans)
    for i, lighting in enumerate(program.variants.lighting):
        if lighting.rotation is not None:
            path = ("variants", "lighting", i, "rotation")
            yield from _angle(path, lighting.rotation, WHOLE_HEADING_RAD, spans, in_degrees=False)
    for i, relation in enumerate(program.relations):
        angles = {key for row in relation.words for key in row.radians} if len(relation.words) == 1 else ()
        for key in sorted(angles):
            if (angle := getattr(relation, key)) is not None:
                yield from _angle(("relations", i, key), angle, WHOLE_TOLERANCE_RAD, spans)
    for asset in written_assets(program):
        yield from _size(asset, spans)


def _angle(
    path: Path, angle_rad: float | Range, whole_rad: float, spans: Spans, *, in_degrees: bool = True
) -> Iterator[Diagnostic]:
    """An error beyond a full turn, a warning for whole numbers beyond `whole_rad`; `in_degrees`: a key takes them."""
    angles = [float(angle) for angle in (angle_rad if isinstance(angle_rad, tuple) else (angle_rad,))]
    largest = max(angles, key=abs)
    beyond = abs(largest) > MOST_ANGLE_RAD
    if not beyond and not (abs(largest) > whole_rad and all(angle.is_integer() for angle in angles)):
        return
    key = f"{path[-1]}_deg" if in_degrees else f"{path[-1]}"
    meant = _text(angles if in_degrees else [radians(angle) for angle in angles])
    why = "more than a full turn" if beyond else "a round number of radians"
    yield finding(
        "scene/degrees-suspected",
        f"`{written(path)}` reaches {largest:g} rad, {why}; did you mean `{key}: {meant}`?",
        where=spans.place(path),
        value=largest,
        bound=2.0 * pi if beyond else whole_rad,
        unit="rad",
        severity=None if beyond else Severity.WARNING,
    )


def _size(item: WrittenAsset, spans: Spans) -> Iterator[Diagnostic]:
    """A warning when lengths of an inline asset are implausible in metres, also after scaling."""
    lengths = _lengths(item.asset)
    if not lengths:
        return
    # A scale below one may be the very conversion into metres; one above does not make the lengths another unit.
    factor = min(item.scale, 1.0)
    extents = {key: [factor * (2.0 if key == "radius_m" else 1.0) * v for v in of] for key, of in lengths.items()}
    key = max(extents, key=lambda name: max(extents[name]))
    largest, least = max(extents[key]), min(min(of) for of in extents.values())
    if item.background or item.role in FIXED_ROLES:
        bound, most_cm = WIDE_FIXED_M, MOST_FIXED_CM
        plausible = largest < bound or least < THICK_FIXED_M
    else:
        bound, most_cm = LARGEST_OBJECT_M, MOST_OBJECT_CM
        plausible = largest <= bound
    if plausible:
        return
    unit, per_metre = ("centimetres", 100.0) if largest <= most_cm else ("millimetres", 1000.0)
    meant = ", ".join(f"{name}: {_text([v / per_metre for v in of])}" for name, of in lengths.items())
    yield finding(
        "scene/size-implausible",
        f"`{written((*item.path, key))}` makes it {largest:g} m in size; {unit}? Then write `{meant}`",
        where=spans.place((*item.path, key)),
        value=largest,
        bound=bound,
        unit="m",
    )


def _lengths(asset: object) -> dict[str, Sequence[float]]:
    match asset:
        case BoxAsset():
            return {"size_m": asset.size_m}
        case CylinderAsset():
            return {"radius_m": (asset.radius_m,), "height_m": (asset.height_m,)}
        case SphereAsset():
            return {"radius_m": (asset.radius_m,)}
        case _:
            return {}


def _text(numbers: Sequence[float]) -> str:
    """Numbers in YAML: `[-90, 90]`, or `90` for a single one."""
    texts = [f"{number:.4g}" for number in numbers]
    return texts[0] if len(texts) == 1 else f"[{', '.join(texts)}]"
