"""The SDK as it is published with a site: a copy that never changes, its integrity, and a package for npm.

`/sdk/` moves with each deployment. `/sdk/<version>/` stays as it is: a release has its version, all between
releases has also a digest of its content. `integrity.json` has the hashes of a version's modules (Subresource
Integrity); `calibdb.tgz` is what `npm install <address>` takes.
"""

import base64
import gzip
import hashlib
import io
import json
import re
import shutil
import subprocess
import tarfile
import tempfile
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

from calibdb import __version__
from infra.release.changelog import is_released

ROOT = Path(__file__).resolve().parents[2]
SDK_FOLDER = "sdk/"
VERSIONED = re.compile(r"sdk/\d+\.\d+\.\d+[^/]*/")
"""Keys of files that never change."""
_ARCHIVE = "calibdb.tgz"
_API = b'"../v1"'  # from the folder of the files to the service's API
_TYPESCRIPT = (
    *("--ignoreConfig", "--allowJs", "--checkJs", "--declaration", "--emitDeclarationOnly", "--strict"),
    *("--target", "es2023", "--module", "esnext", "--moduleResolution", "bundler", "--types", ""),
)
_MAX_BUILD_S = 120


class SiteError(RuntimeError):
    """A file of the site cannot be made. The message says why."""


def run_node(made: str, program: str, *arguments: str, text: str = "") -> subprocess.CompletedProcess[str]:
    """Run `node` or `npx`; raises SiteError without Node.js. `made`: what needs it, with its verb."""
    path = shutil.which(program)
    if path is None:
        raise SiteError(f"{made} made with Node.js, which is not there: install it, version 20 or newer")
    return subprocess.run(
        [path, *arguments],
        cwd=ROOT,
        input=text,
        capture_output=True,
        text=True,
        timeout=_MAX_BUILD_S,
        check=False,
    )


def sdk_files(web: Path) -> Mapping[str, bytes]:
    """Make the version's files, by key; none for a folder without an SDK."""
    sources = _sources(web)
    return dict(_files(tuple(sorted(sources.items())))) if sources else {}


def sdk_package(web: Path, version: str) -> bytes:
    """Pack the SDK as npm installs it."""
    return _package(_sources(web), version)


def sdk_version(web: Path) -> str:
    """Name the version: 0.2.0 of a release, 0.2.0-dev.1f0c7a3e of anything else."""
    return _version(_sources(web))


def import_map(web: Path, site: str) -> str:
    """Write an import map that pins every module of the version to its content."""
    sources = _sources(web)
    hashes = _integrity(sources)
    at = f"{site}/{SDK_FOLDER}{_version(sources)}"
    names: dict[str, str] = {}
    for name, export in json.loads(sources["package.json"])["exports"].items():
        file = export["default"].removeprefix("./")
        pattern = re.compile(re.escape(file).replace(r"\*", "(.+)"))
        for match in filter(None, map(pattern.fullmatch, hashes)):
            specifier = f"calibdb{name.removeprefix('.')}".replace("*", (match.groups() or ("",))[0])
            names[specifier] = f"{at}/{match[0]}"
    pinned = {f"{at}/{name}": each for name, each in hashes.items()}
    return json.dumps({"imports": names, "integrity": pinned}, indent=2)


def _integrity(sources: Mapping[str, bytes]) -> dict[str, str]:
    """Return the hash of each module as it lies in the version's folder."""
    return {name: sri(content) for name, content in sorted(_modules(sources).items())}


def sri(content: bytes) -> str:
    """Return a hash in the form of Subresource Integrity (W3C, 3.5)."""
    return f"sha384-{base64.b64encode(hashlib.sha384(content).digest()).decode()}"


def _sources(web: Path) -> dict[str, bytes]:
    folder = web / SDK_FOLDER
    if not (folder / "calibdb.js").is_file():
        return {}
    names = [*folder.glob("*.js"), *folder.glob("adapters/*.js"), folder / "dom.d.ts", folder / "README.md"]
    package = folder / "package.json"
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() for path in [*names, package] if path.is_file()
    }


def digest(files: Mapping[str, bytes], start: bytes = b"") -> str:
    """Digest of the files' names and contents, and `start`."""
    whole = hashlib.sha256(start)
    for name, content in sorted(files.items()):
        whole.update(f"{name}\0{len(content)}\0".encode() + content)
    return whole.hexdigest()


def _version(sources: Mapping[str, bytes]) -> str:
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    mark = "" if is_released(changelog, __version__) else f"-dev.{digest(sources)[:8]}"
    return f"{__version__}{mark}"


def _modules(sources: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return the modules as they lie one folder deeper than in `/sdk/`."""
    modules = {name: content for name, content in sources.items() if name.endswith(".js")}
    if modules["request.js"].count(_API) != 1:
        raise SiteError(f"request.js does not say {_API.decode()} once")
    return modules | {"request.js": modules["request.js"].replace(_API, b'"../../v1"')}


@lru_cache(maxsize=4)
def _files(sources: tuple[tuple[str, bytes], ...]) -> Mapping[str, bytes]:
    files = dict(sources)
    version = _version(files)
    at = f"{SDK_FOLDER}{version}/"
    facts = json.dumps({"version": version, "files": _integrity(files)}, indent=1).encode() + b"\n"
    modules = {f"{at}{name}": content for name, content in _modules(files).items()}
    packed = _package(files, version)
    for folder in (at, SDK_FOLDER):
        modules |= {f"{folder}{_ARCHIVE}": packed, f"{folder}integrity.json": facts}
    return modules


def _package(sources: Mapping[str, bytes], version: str) -> bytes:
    """Pack what npm installs, as `npm pack` does; what was packed before is taken from `.build`."""
    named = digest(sources, (ROOT / "package-lock.json").read_bytes())[:16]
    cache_file = ROOT / ".build" / "sdk" / f"{version}-{named}.tgz"
    if cache_file.is_file():
        return cache_file.read_bytes()
    described = json.loads(sources["package.json"]) | {"version": version, "scripts": {}}
    contents = {
        **sources,
        **_types(sources),
        "package.json": json.dumps(described, indent=2).encode() + b"\n",
        "LICENSE": (ROOT / "LICENSE").read_bytes(),
    }
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w") as archive:
        for name, content in sorted(contents.items()):
            entry = tarfile.TarInfo(f"package/{name}")
            entry.size = len(content)
            archive.addfile(entry, io.BytesIO(content))
    content = gzip.compress(packed.getvalue(), mtime=0)
    write_whole(cache_file, content)
    return content


def write_whole(path: Path, content: bytes) -> None:
    """Write a file for other processes, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
        file.write(content)
    Path(file.name).replace(path)


def _types(sources: Mapping[str, bytes]) -> dict[str, bytes]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for path, content in sources.items():
            (folder / path).parent.mkdir(exist_ok=True)
            (folder / path).write_bytes(content)
        modules = [str(folder / path) for path in sources if path.endswith(".js")]
        target = ("--outDir", str(folder / "types"), "--rootDir", name)
        done = run_node("types are", "npx", "--no-install", "tsc", *modules, *_TYPESCRIPT, *target)
        if done.returncode:
            raise SiteError(f"types of the SDK cannot be made.\n{done.stdout.strip()}{done.stderr.strip()}")
        made = sorted((folder / "types").rglob("*.d.ts"))
        return {path.relative_to(folder).as_posix(): path.read_bytes() for path in made}
