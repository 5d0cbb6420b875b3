"""Commands that write and read files: dumps, bundles, calibrations of other tools.

A command imports its module when it runs: some load slowly (the solver, pyarrow).
"""

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from infra.console import track
from infra.ops import OpsError
from infra.ops.session import DryRun, Json, Size, data_folder, open_output, open_run, parse_size


def _complete_model(start: str) -> list[str]:
    from calibdb.schema import DISTORTION_MODELS

    return [model for model in DISTORTION_MODELS if model.startswith(start)]


Folder = Annotated[Path, typer.Argument(metavar="FOLDER")]
File = Annotated[Path, typer.Argument(metavar="FILE")]


def dump(
    folder: Folder,
    private: Annotated[
        bool,
        typer.Option("--private", help="Also contributions without a licence. Keep it private."),
    ] = False,
    as_json: Json = False,
) -> None:
    """Write all calibrations and keypoints that were given under CC0 to a new folder."""
    with open_run(as_json=as_json) as (context, output):
        from infra.ops.dump import dump

        calibrations, votes = dump(context, folder, private=private)
        output.line(f"{calibrations} calibrations and {votes} votes written to {folder}")
        output.value({"calibrations": calibrations, "votes": votes, "folder": str(folder)})


def publish_dump(as_json: Json = False) -> None:
    """Write the public dump of the site now, as its schedule does once a week."""
    with open_run(as_json=as_json) as (context, output):
        from infra.ops.public_dump import publish_dump

        dump = publish_dump(context)
        counts = dump.counts
        output.line(
            f"{counts.calibrations} calibrations and {counts.votes} votes in {len(dump.files)} files, "
            f"{dump.size} bytes: dumps/{dump.name}/"
        )
        output.value(dump.model_dump(mode="json"))


def backup(file: File, as_json: Json = False) -> None:
    """Back up a data folder, whose server may run, to a new file. It contains secrets: keep it private."""
    with open_output(as_json=as_json) as output:
        from infra.ops.backup import write_backup

        size = write_backup(data_folder(), file)
        output.line(f"{data_folder()} backed up to {file}, {size} bytes")
        output.value({"file": str(file), "size": size})


def restore(file: File, as_json: Json = False) -> None:
    """Restore a backup to a data folder whose server is stopped; its content is kept in a folder there."""
    with open_output(as_json=as_json) as output:
        from infra.ops.backup import restore_backup

        previous = restore_backup(data_folder(), file)
        output.line(
            f"{file} restored to {data_folder()}" + (f"; it was {previous} before" if previous else "")
        )
        output.value({"folder": str(data_folder()), "before": previous and str(previous)})


def load(folder: Folder, dry_run: DryRun = False, as_json: Json = False) -> None:
    """Store the content of a dump."""
    with open_run(as_json=as_json) as (context, output):
        from infra.ops.restore import load

        calibrations, votes = load(context, folder, dry_run=dry_run)
        done = "would be stored" if dry_run else "stored"
        output.line(f"{calibrations} calibrations and {votes} votes {done}")
        output.value({"calibrations": calibrations, "votes": votes})


def bundle(
    file: File,
    most: Annotated[int, typer.Option(min=1, metavar="CAMERAS", help="Number of cameras.")] = 500,
    as_json: Json = False,
) -> None:
    """Write the reliable calibrations of the most common cameras to one file."""
    with open_run(as_json=as_json) as (context, output):
        from infra.ops.bundle import bundle

        done = bundle(context, file, most)
        output.value(asdict(done))
        output.table(
            ("#bytes", "camera"),
            [(size, camera) for camera, size in done.cameras.items()],
            (f"{size:6} bytes  {camera}" for camera, size in done.cameras.items()),
        )
        output.line(
            f"{len(done.cameras)} cameras, {done.calibrations} calibrations, {done.labels} labels written to "
            f"{file}: {done.size} bytes, {done.compressed} compressed"
        )


def import_files(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE", help="OpenCV, ROS, Kalibr, camodocal, PhotonVision, mrcal, Gyroflow, COLMAP, …"
        ),
    ],
    camera: Annotated[str, typer.Option(help="Label, as a browser reports it.")],
    platform: Annotated[str, typer.Option(help="Platform, as a browser reports it.")],
    zoom: Annotated[float, typer.Option(help="Zoom of the track.")] = 0.0,
    img_size: Annotated[
        Size | None,
        typer.Option(parser=parse_size, metavar="WxH", help="Size of the pictures, for files that lack it."),
    ] = None,
    camera_number: Annotated[
        int, typer.Option(min=0, max=999, metavar="N", help="Of a file with several cameras, from 0.")
    ] = 0,
    squares: Annotated[
        Size | None,
        typer.Option(parser=parse_size, metavar="WxH", help="Of the board, for tables of corners."),
    ] = None,
    model: Annotated[
        str,
        typer.Option(
            help="Model to fit to keypoints (default: the one that suits them), or of unnamed coefficients.",
            autocompletion=_complete_model,
        ),
    ] = "",
    licence: Annotated[
        str | None,
        typer.Option(
            metavar="CC0-1.0",
            help="Licence under which the keypoints may be given away. Without it, no dump has them.",
        ),
    ] = None,
    dry_run: DryRun = False,
    as_json: Json = False,
) -> None:
    """Store calibration files: with keypoints as a calibration, else as a first guess.

    Several files are stored or refused one by one.
    """
    with open_run(as_json=as_json) as (context, output):
        from calibsolver.formats.base import ReaderOptions
        from infra.ops.imports import ReportedCamera, import_file, licence_of

        reported = ReportedCamera(camera, platform, zoom, licence_of(licence))
        options = ReaderOptions(img_size, camera_number, squares)
        results: list[dict[str, str]] = []
        output.value(results)
        failed: list[str] = []
        for file in track(files, "files", len(files)):
            try:
                done = import_file(context, file, reported, options, model, dry_run=dry_run)
            except (OpsError, OSError) as error:
                if len(files) == 1:
                    raise
                failed.append(str(file))
                results.append({"file": str(file), "error": str(error)})
                print(f"calibDB: {error}", file=sys.stderr)
                continue
            results.append({"file": str(file), "result": done})
            output.line(done if len(files) == 1 else f"{file}: {done}")
        if failed:
            output.finish()
            raise OpsError(f"{len(failed)} of {len(files)} files could not be used: {', '.join(failed)}")


def seed(
    files: Annotated[list[Path], typer.Argument(metavar="FILE")],
    camera: Annotated[
        str, typer.Option(help="Label, made of columns, such as '{brand} {model} {lens}'.")
    ] = "{camera}",
    platform: Annotated[str, typer.Option(help="Platform, in the same way.")] = "{platform}",
    model: Annotated[
        str, typer.Option(help="Model of rows that name none.", autocompletion=_complete_model)
    ] = "rectilinear",
    source: Annotated[str, typer.Option(help="Source of the file; stored with each guess.")] = "",
    dry_run: DryRun = False,
    as_json: Json = False,
) -> None:
    """Store published calibrations (CSV) as first guesses."""
    with open_run(as_json=as_json) as (context, output):
        from infra.ops.seed import seed

        results = []
        for file in files:
            done = seed(context, file, camera, platform, model, source, dry_run=dry_run)
            name = f"{file}: " if len(files) > 1 else ""
            would = " would be stored" if dry_run else ""
            output.line(
                f"{name}{done.rows} rows: {done.priors} first guesses for {done.cameras} cameras{would}"
            )
            for reason, count in done.skipped.items():
                output.line(f"{count} skipped: {reason}")
            results.append({"file": str(file), **asdict(done)})
        output.value(results)
