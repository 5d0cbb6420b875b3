"""Result of a rig as another tool's files."""

from __future__ import annotations

import numpy as np

from calibdb.compute.values import camera_of, in_time
from calibdb.errors import InvalidError
from calibdb.http.call import Call
from calibdb.schema.rig import RIG_FORMATS, RigResult
from calibsolver import CalibrationError
from calibsolver.formats import ExportedFile
from calibsolver.rig import formats

WRITERS = {name: name for name in RIG_FORMATS} | {"opencv_stereo": "opencv-yaml"}


def write(call: Call, result: RigResult, name: str) -> ExportedFile:
    """Write a result in a format; raises InvalidError if the format cannot hold it."""
    source = formats.RigSource(
        cameras=[camera_of(one) for one in result.calibrations],
        poses=np.array([[*one.rvec, *one.tvec] for one in result.extrinsics]),
        unit=result.unit,
        names=[f"cam{i} {one.camera}" for i, one in enumerate(result.calibrations)],
        identifier=result.rig_id,
        record=result.model_dump(),
    )
    slow = "takes longer to compute than a request may; ask for another format"
    try:
        with in_time(call, InvalidError.field("format", slow)):
            return formats.write(source, WRITERS[name])
    except CalibrationError as error:
        raise InvalidError.field("format", error.message) from error
