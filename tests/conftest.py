"""Options of the whole test suite."""

from __future__ import annotations

from pathlib import Path

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--shared",
        type=Path,
        metavar="FOLDER",
        help="folder with the third-party files that tests/validation/third_party compares with; without it "
        "these comparisons are not collected",
    )


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """The third-party files are not ours to ship: the comparisons with them exist only where a folder is named."""
    return True if collection_path.name == "third_party" and config.getoption("--shared") is None else None


@pytest.fixture(scope="session")
def shared(request: pytest.FixtureRequest) -> Path:
    """The folder named by --shared."""
    return request.config.getoption("--shared")
