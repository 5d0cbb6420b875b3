"""Published calibrations as first guesses: a capture may start from them, no lookup returns them."""

import csv
import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from calibdb.camera_key import identify, public_label, public_platform
from calibdb.schema import FitRecord, PriorDocument
from calibsolver import Camera, models
from infra.console import track
from infra.ops import OpsError
from infra.ops.context import OpsContext

# Ratio of focal lengths beyond which rows are of several lenses or modes under one name: no guess at all.
_MAX_FOCAL_RATIO = 1.1
# Their quality is unknown: share of the image's width, about the error of an uninformed guess.
_UNKNOWN_ERROR = 0.05


@dataclass(frozen=True)
class SeedResult:
    """Numbers of stored guesses and of skipped rows."""

    priors: int
    cameras: int
    rows: int
    skipped: Mapping[str, int]  # rows, by reason


@dataclass(frozen=True)
class _Row:
    camera: str
    platform: str
    zoom: float
    fit: FitRecord


def seed(
    context: OpsContext,
    path: Path,
    camera: str,
    platform: str,
    model: str,
    source: str,
    *,
    dry_run: bool = False,
) -> SeedResult:
    """Store a guess for every camera, size, zoom and model in a CSV file.

    Columns: `w h fx fy cx cy`, the coefficients by their names, optionally `zoom` and `distortion_model`,
    and those of which `camera` and `platform` are made, such as `{brand} {model}`. Of several rows of one
    camera the one with the median focal length counts; if they are of several lenses, none does.
    """
    groups: dict[tuple[str, tuple[int, int], float, str], list[_Row]] = defaultdict(list)
    skipped: Counter[str] = Counter()
    rows = 0
    for number, fields in _fields(path, (camera, platform)):
        rows += 1
        row = _row(fields, camera, platform, model, number)
        if isinstance(row, str):
            skipped[row] += 1
            continue
        identity = identify(row.camera, row.platform)
        if identity.ambiguous or identity.virtual:
            skipped["the label does not say which camera it is"] += 1
            continue
        groups[identity.key, row.fit.img_size, row.zoom, row.fit.distortion_model].append(row)
    priors = 0
    cameras = set()
    for (key, _, zoom, _), members in track(groups.items(), path.name, len(groups)):
        focals = sorted(_focal(row) for row in members)
        if focals[-1] > _MAX_FOCAL_RATIO * focals[0]:
            skipped["several lenses or modes under one name"] += len(members)
            continue
        middle = sorted(members, key=_focal)[len(members) // 2]
        prior = guess(middle.camera, middle.platform, zoom, middle.fit, source or path.name, len(members))
        if not dry_run:
            context.store.priors.keep(prior)
        priors += 1
        cameras.add(key)
    return SeedResult(priors, len(cameras), rows, dict(skipped))


def guess(
    camera: str, platform: str, zoom: float, fit: FitRecord, source: str, measured: int = 1
) -> PriorDocument:
    """Make the first guess for a camera, as a browser reports it."""
    return PriorDocument(
        camera_key=identify(camera, platform).key,
        camera=public_label(camera),
        platform=public_platform(platform),
        zoom=zoom,
        fit=fit,
        source=source,
        measured=measured,
    )


def uncertain_fit(
    model: str, size: tuple[int, int], matrix: object, distortion: object, rms: float = 0.0
) -> FitRecord:
    """Make a fit of unknown accuracy; raises ValidationError."""
    off = _UNKNOWN_ERROR * size[0]
    return FitRecord.model_validate(
        {
            "img_size": size,
            "camera_matrix": matrix,
            "distortion_coefficients": distortion,
            "distortion_model": model,
            "avg_reprojection_error": rms,
            "uncertainty": {"rms": off, "max": off},
        }
    )


def _fields(path: Path, labels: tuple[str, str]) -> Iterator[tuple[int, dict[str, str]]]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        reader = csv.DictReader(file)
        missing = {"w", "h", "fx", "fy", "cx", "cy"} - set(reader.fieldnames or ())
        if missing:
            raise OpsError(f"{path} has no column {', '.join(sorted(missing))}")
        columns = dict.fromkeys(reader.fieldnames or (), "")
        for label in labels:
            try:
                label.format_map(columns)
            except (KeyError, ValueError, IndexError) as error:
                raise OpsError(f"{label!r} cannot be made of the columns of {path}: {error}") from error
        for row in reader:
            yield reader.line_num, {name: value or "" for name, value in row.items() if name is not None}


def _row(fields: Mapping[str, str], camera: str, platform: str, model: str, number: int) -> _Row | str:
    model = fields.get("distortion_model") or model
    if model not in models.REGISTRY:
        raise OpsError(f"line {number}: there is no distortion model {model!r}")
    coefficients = models.get(model).coefficients
    absent = [name for name in coefficients if name not in fields]
    if absent:
        raise OpsError(f"there is no column {absent[0]}, which {model} needs; see --model")
    if any(fields.get(name, "") not in ("", "1", "1.0") for name in ("hstretch", "vstretch")):
        return "the image is stretched"
    try:
        size = int(fields["w"]), int(fields["h"])
        fx, fy, cx, cy = (_number(fields[name]) for name in ("fx", "fy", "cx", "cy"))
        if not (0 < fx < 100 * size[0] and 0.5 < fy / fx < 2 and 0 < cx < size[0] and 0 < cy < size[1]):
            return "no camera is like that"
        matrix = ((fx, 0.0, cx), (0.0, fy, cy), (0.0, 0.0, 1.0))
        distortion = tuple(_number(fields[name]) for name in coefficients)
        fit = uncertain_fit(model, size, matrix, distortion, _number(fields.get("rms") or "0"))
        zoom = _number(fields.get("zoom") or "0")
    except ValidationError:
        return "no camera is like that"
    except ValueError:
        return "a number is missing"
    return _Row(_label(camera, fields), _label(platform, fields), zoom, fit)


def _label(made_of: str, fields: Mapping[str, str]) -> str:
    return " ".join(made_of.format_map(fields).split())


def _number(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(text)
    return number


def _focal(row: _Row) -> float:
    """Pixels per radian at the axis: of omnidirectional fits of one lens, fx differs with xi."""
    return float(Camera.from_record(row.fit.model_dump()).focal[0])
