"""Builds the package by PEP 517 from its files and `pyproject.toml`, with the standard library alone."""

from __future__ import annotations

import base64
import hashlib
import re
import tarfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
# Fixed, so that the same files give the same wheel.
TIME = (1980, 1, 1, 0, 0, 0)


def _project() -> dict[str, str]:
    """The texts of the table `[project]`. Python 3.10 has no TOML reader, and these lines need none."""
    text = (HERE / "pyproject.toml").read_text(encoding="utf-8")
    table = text.split("[project]", 1)[1].split("\n[", 1)[0]
    return dict(re.findall(r'^([a-z-]+) = "([^"]*)"$', table, re.MULTILINE))


def _metadata(project: dict[str, str]) -> str:
    readme = (HERE / project["readme"]).read_text(encoding="utf-8")
    return (
        "Metadata-Version: 2.4\n"
        f"Name: {project['name']}\n"
        f"Version: {project['version']}\n"
        f"Summary: {project['description']}\n"
        f"Requires-Python: {project['requires-python']}\n"
        f"License-Expression: {project['license']}\n"
        "Description-Content-Type: text/markdown\n\n"
        f"{readme}"
    )


def _files() -> list[tuple[str, bytes]]:
    source = HERE / "src"
    found = [path for path in sorted(source.rglob("*")) if path.is_file() and "__pycache__" not in path.parts]
    return [(path.relative_to(source).as_posix(), path.read_bytes()) for path in found]


def build_wheel(wheel_directory: str, config_settings: object = None, metadata_directory: object = None) -> str:
    """Writes the wheel; returns its name."""
    project = _project()
    stem = f"{project['name']}-{project['version']}"
    tag = "py3-none-any"
    info = f"{stem}.dist-info"
    wheel = f"Wheel-Version: 1.0\nGenerator: microsim\nRoot-Is-Purelib: true\nTag: {tag}\n"
    files = _files()
    files.append((f"{info}/METADATA", _metadata(project).encode()))
    files.append((f"{info}/WHEEL", wheel.encode()))
    record = []
    name = f"{stem}-{tag}.whl"
    with zipfile.ZipFile(Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files:
            archive.writestr(zipfile.ZipInfo(path, TIME), content, zipfile.ZIP_DEFLATED)
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            record.append(f"{path},sha256={digest},{len(content)}")
        record.append(f"{info}/RECORD,,")
        archive.writestr(zipfile.ZipInfo(f"{info}/RECORD", TIME), "\n".join(record) + "\n", zipfile.ZIP_DEFLATED)
    return name


def build_sdist(sdist_directory: str, config_settings: object = None) -> str:
    """Writes the sources as an archive; returns its name."""
    project = _project()
    stem = f"{project['name']}-{project['version']}"
    name = f"{stem}.tar.gz"
    information = HERE / "PKG-INFO"
    with tarfile.open(Path(sdist_directory) / name, "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for part in ["pyproject.toml", "README.md", "src", "build_backend", "tests", "examples"]:
            keep = lambda of: None if "__pycache__" in of.name else of  # noqa: E731
            archive.add(HERE / part, f"{stem}/{part}", filter=keep)
        content = _metadata(project).encode()
        of = tarfile.TarInfo(f"{stem}/{information.name}")
        of.size = len(content)
        import io

        archive.addfile(of, io.BytesIO(content))
    return name
